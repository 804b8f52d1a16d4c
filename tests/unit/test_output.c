/* Files that the host programs write: where they may, and what is left when they are ended half-way. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common.h"

static char folder[] = "/tmp/goniotile_output_XXXXXX";
static int struck_by; /* the signal that a write meets before its file is renamed; 0: none */

/* In libc's place. */
int fsync(int fd)
{
    (void)fd;
    return struck_by ? raise(struck_by) : 0;
}

static int in_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) && !chdir(folder) ? 0 : -1;
}

static int no_folder(void **state)
{
    (void)state;
    return chdir("/") || rmdir(folder);
}

/* Writes "new" to `path` in a child that has read `input` (may be NULL); its wait status. */
static int status_of_write(const char *path, const char *input)
{
    pid_t child = fork();
    if (!child) {
        size_t bytes;
        freopen("/dev/null", "w", stderr);
        if (input)
            free(read_file(input, 100, &bytes));
        write_file(path, "new", 3);
        _exit(EXIT_OK);
    }
    int status = -1;
    assert_int_equal(waitpid(child, &status, 0), child);
    return status;
}

static int code_of_write(const char *path, const char *input)
{
    int status = status_of_write(path, input);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

static void put(const char *path, const char *text)
{
    FILE *f = fopen(path, "w");
    assert_non_null(f);
    assert_true(fputs(text, f) >= 0 && !fclose(f));
}

/* Not by read_file, which would make it an input. */
static void assert_holds(const char *path, const char *text)
{
    char data[100] = "";
    FILE *f = fopen(path, "r");
    assert_non_null(f);
    assert_non_null(fgets(data, sizeof data, f));
    fclose(f);
    assert_string_equal(data, text);
}

static void assert_removed(const char *path)
{
    assert_int_equal(unlink(path), 0);
}

static void a_write_ended_by_a_signal_leaves_the_old_file_alone(void **state)
{
    (void)state;
    static const int deadly[] = {SIGINT, SIGTERM, SIGHUP};
    put("old", "old");
    for (int i = 0; i < 3; i++) {
        struck_by = deadly[i];
        signal(struck_by, SIG_DFL); /* a shell ignores SIGINT for what it starts in the background */
        int status = status_of_write("old", NULL);
        assert_true(WIFSIGNALED(status));
        assert_int_equal(WTERMSIG(status), deadly[i]);
        assert_holds("old", "old");
    }
    struck_by = 0;
    assert_removed("old");
    /* That nothing else was there is what removing the folder in the end says. */
}

static void a_signal_that_is_ignored_lets_the_write_end(void **state)
{
    (void)state;
    signal(SIGHUP, SIG_IGN);
    struck_by = SIGHUP;
    assert_int_equal(code_of_write("new", NULL), EXIT_OK);
    struck_by = 0;
    signal(SIGHUP, SIG_DFL);
    assert_holds("new", "new");
    assert_removed("new");
}

static void an_input_is_never_replaced_by_whatever_name(void **state)
{
    (void)state;
    put("input", "old");
    assert_int_equal(symlink("input", "link"), 0);
    assert_int_equal(link("input", "hard"), 0);
    static const char *const names[] = {"input", "./input", "link", "hard"};
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 4; k++)
            assert_int_equal(code_of_write(names[i], names[k]), EXIT_USAGE);
    assert_holds("input", "old");
    put("other", "old");
    assert_int_equal(code_of_write("other", "input"), EXIT_OK);
    assert_holds("other", "new");
    for (int i = 0; i < 4; i++)
        if (i != 1)
            assert_removed(names[i]);
    assert_removed("other");
}

static void a_link_stays_and_its_file_is_replaced(void **state)
{
    (void)state;
    struct stat st;
    put("file", "old");
    assert_int_equal(symlink("file", "link"), 0);
    assert_int_equal(code_of_write("link", NULL), EXIT_OK);
    assert_holds("file", "new");
    assert_int_equal(lstat("link", &st), 0);
    assert_true(S_ISLNK(st.st_mode));
    assert_removed("file");
    assert_int_equal(code_of_write("link", NULL), EXIT_FILE); /* leads nowhere */
    assert_removed("link");
}

static void a_device_or_a_pipe_is_written_to(void **state)
{
    (void)state;
    struct stat st;
    assert_int_equal(symlink("/dev/full", "full"), 0);
    assert_int_equal(code_of_write("full", NULL), EXIT_FILE);
    assert_int_equal(code_of_write("/dev/null", NULL), EXIT_OK);
    assert_true(!stat("/dev/null", &st) && S_ISCHR(st.st_mode));
    assert_removed("full");

    char text[4] = "";
    assert_int_equal(mkfifo("pipe", 0600), 0);
    int fd = open("pipe", O_RDWR);
    assert_true(fd >= 0);
    assert_int_equal(code_of_write("pipe", NULL), EXIT_OK);
    assert_int_equal(read(fd, text, 3), 3);
    assert_string_equal(text, "new");
    close(fd);
    assert_true(!stat("pipe", &st) && S_ISFIFO(st.st_mode));
    assert_removed("pipe");
}

static void a_folder_is_refused(void **state)
{
    (void)state;
    assert_int_equal(mkdir("folder", 0700), 0);
    assert_int_equal(code_of_write("folder", NULL), EXIT_FILE);
    assert_int_equal(rmdir("folder"), 0);
}

static int code_of_number(const char *text)
{
    pid_t child = fork();
    if (!child) {
        freopen("/dev/null", "w", stderr);
        _exit(parse_long("--n", text, 0, 99) == 10 && parse_double("--x", text, 0, 99) == 10 ? EXIT_OK : EXIT_INTERNAL);
    }
    int status = -1;
    assert_int_equal(waitpid(child, &status, 0), child);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

static void numbers_are_decimal(void **state)
{
    (void)state;
    double x;
    assert_int_equal(code_of_number("10"), EXIT_OK);
    assert_int_equal(code_of_number("010"), EXIT_OK);
    assert_int_equal(code_of_number("0xa"), EXIT_USAGE);
    assert_int_equal(code_of_number("10 "), EXIT_USAGE);
    assert_true(decimal("1e1", &x) && x == 10);
    assert_true(decimal("inf", &x) && decimal("nan", &x));
    assert_false(decimal("0x1p3", &x) || decimal("", &x) || decimal("1,5", &x));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_write_ended_by_a_signal_leaves_the_old_file_alone),
        cmocka_unit_test(a_signal_that_is_ignored_lets_the_write_end),
        cmocka_unit_test(an_input_is_never_replaced_by_whatever_name),
        cmocka_unit_test(a_link_stays_and_its_file_is_replaced),
        cmocka_unit_test(a_device_or_a_pipe_is_written_to),
        cmocka_unit_test(a_folder_is_refused),
        cmocka_unit_test(numbers_are_decimal),
    };
    return cmocka_run_group_tests(tests, in_folder, no_folder);
}
