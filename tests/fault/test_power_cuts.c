/*
 * Power cuts at every flash operation. All cases with GONIOTILE_LONG set, else a sample spread over them; GONIOTILE_CASE=name runs that one
 * alone, as a failure prints it.
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>

#include "power_cuts.h"

enum { SAMPLE_STEP = 17 }; /* no divisor of the ways to cut, so that all of them get their turn */

static struct power_cuts *cuts;
static uint32_t cases;

static void run(const struct power_cut *c)
{
    char name[64];
    const char *wrong = power_cuts_run(cuts, c);
    cases++;
    power_cuts_name(name, c);
    if (wrong)
        fail_msg("%s; to run this case alone: GONIOTILE_CASE=%s build/tests/fault/test_power_cuts", wrong, name);
}

static void scenario_leaves_old_or_new(void **state)
{
    unsigned scenario = *(const unsigned *)*state;
    uint32_t step = getenv("GONIOTILE_LONG") ? 1 : SAMPLE_STEP;
    for (uint32_t n = scenario % step; n < power_cuts_count(cuts, scenario); n += step) {
        struct power_cut c = power_cuts_case(cuts, scenario, n);
        run(&c);
    }
}

static void one_case(void **state)
{
    struct power_cut c;
    (void)state;
    if (!power_cuts_parse(&c, getenv("GONIOTILE_CASE")))
        fail_msg("GONIOTILE_CASE=%s names no case", getenv("GONIOTILE_CASE"));
    run(&c);
}

int main(void)
{
    static unsigned numbers[POWER_CUT_SCENARIOS];
    static char names[POWER_CUT_SCENARIOS][80];
    struct CMUnitTest tests[POWER_CUT_SCENARIOS] = {{0}};
    const struct CMUnitTest alone[] = {cmocka_unit_test(one_case)};
    cuts = power_cuts_create();
    for (unsigned s = 0; s < POWER_CUT_SCENARIOS; s++) {
        numbers[s] = s;
        snprintf(names[s], sizeof names[s], "power_cuts_in_%s_leave_the_old_or_the_new_content",
                 power_cuts_scenario(s));
        tests[s] = (struct CMUnitTest){names[s], scenario_leaves_old_or_new, NULL, NULL, &numbers[s]};
    }
    int failed = getenv("GONIOTILE_CASE") ? cmocka_run_group_tests(alone, NULL, NULL)
                                          : cmocka_run_group_tests(tests, NULL, NULL);
    uint32_t all = 0;
    for (unsigned s = 0; s < POWER_CUT_SCENARIOS; s++)
        all += power_cuts_count(cuts, s);
    printf("# %u of %u power cuts, %u pushes resumed\n", cases, all, power_cuts_resumed(cuts));
    power_cuts_destroy(cuts);
    return failed;
}
