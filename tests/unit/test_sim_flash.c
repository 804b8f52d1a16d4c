/* The simulated flash: it ends the program that breaks the rules of NOR. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <sys/wait.h>
#include <unistd.h>

#include "device_fixture.h"

/* True when programming `offset` ends the process by abort. */
static bool program_aborts(struct sim *board, uint32_t offset, uint32_t bytes)
{
    static const uint32_t zeros[4];
    int status;
    pid_t child = fork();
    if (child == 0) {
        close(2);
        sim_hal(board)->flash_program(board, offset, zeros, bytes);
        _exit(0);
    }
    assert_int_equal(waitpid(child, &status, 0), child);
    return WIFSIGNALED(status) && WTERMSIG(status) == SIGABRT;
}

static void simulated_flash_insists_on_the_rules_of_nor(void **state)
{
    struct sim_config c = {.slot_count = 2, .table_bank_bytes = FIXTURE_BANK, .scene_bank_bytes = FIXTURE_BANK};
    struct sim *board = sim_create(&c);
    uint32_t bytes;
    (void)state;
    sim_flash(board, &bytes);
    assert_false(program_aborts(board, 8, 8));
    assert_int_equal(sim_hal(board)->flash_program(board, 8, "1234", 4), HAL_OK);
    assert_true(program_aborts(board, 8, 8));
    assert_true(program_aborts(board, 4, 8));
    assert_false(program_aborts(board, 12, 8));
    assert_true(program_aborts(board, 13, 4));
    assert_true(program_aborts(board, 16, 3));
    assert_true(program_aborts(board, bytes - 4, 8));
    assert_int_equal(sim_hal(board)->flash_erase(board, 0), HAL_OK);
    assert_false(program_aborts(board, 8, 8));
    sim_destroy(board);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(simulated_flash_insists_on_the_rules_of_nor),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
