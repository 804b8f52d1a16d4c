/*
 * Faults at every packet of a push. All cases with GONIOTILE_LONG set, else a sample spread over them; GONIOTILE_CASE=name runs that one
 * alone, as a failure prints it.
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>

#include "packet_faults.h"

enum { SAMPLE_STEP = 13 };

static struct packet_faults *faults;
static uint32_t cases;

static void run(const struct packet_fault *f)
{
    char name[64];
    const char *wrong = packet_faults_run(faults, f);
    cases++;
    packet_faults_name(name, f);
    if (wrong)
        fail_msg("%s; to run this case alone: GONIOTILE_CASE=%s build/tests/fault/test_packet_faults", wrong, name);
}

static void scenario_ends_in_the_same_content(void **state)
{
    unsigned scenario = *(const unsigned *)*state;
    uint32_t step = getenv("GONIOTILE_LONG") ? 1 : SAMPLE_STEP;
    for (uint32_t n = scenario % step; n < packet_faults_count(faults, scenario); n += step) {
        struct packet_fault f = packet_faults_case(faults, scenario, n);
        run(&f);
    }
}

static void one_case(void **state)
{
    struct packet_fault f;
    (void)state;
    if (!packet_faults_parse(&f, getenv("GONIOTILE_CASE")))
        fail_msg("GONIOTILE_CASE=%s names no case", getenv("GONIOTILE_CASE"));
    run(&f);
}

int main(void)
{
    static unsigned numbers[PACKET_FAULT_SCENARIOS];
    static char names[PACKET_FAULT_SCENARIOS][80];
    struct CMUnitTest tests[PACKET_FAULT_SCENARIOS] = {{0}};
    const struct CMUnitTest alone[] = {cmocka_unit_test(one_case)};
    faults = packet_faults_create();
    for (unsigned s = 0; s < PACKET_FAULT_SCENARIOS; s++) {
        numbers[s] = s;
        snprintf(names[s], sizeof names[s], "packet_faults_at_%s_end_in_the_content_pushed", packet_faults_scenario(s));
        tests[s] = (struct CMUnitTest){names[s], scenario_ends_in_the_same_content, NULL, NULL, &numbers[s]};
    }
    int failed = getenv("GONIOTILE_CASE") ? cmocka_run_group_tests(alone, NULL, NULL)
                                          : cmocka_run_group_tests(tests, NULL, NULL);
    uint32_t all = 0;
    for (unsigned s = 0; s < PACKET_FAULT_SCENARIOS; s++)
        all += packet_faults_count(faults, s);
    printf("# %u of %u packet faults, %u pushes resumed\n", cases, all, packet_faults_resumed(faults));
    packet_faults_destroy(faults);
    return failed;
}
