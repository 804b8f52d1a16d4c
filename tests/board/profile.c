/*
 * Plugin for QEMU: instructions executed per function of the emulated program, most first, on stderr at its end. Functions
 * inlined into others count there.
 */
#include "qemu_plugin.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int qemu_plugin_version = 1;

#define MAX_FUNCTIONS 1000
static struct function {
    uint64_t instructions;
    char name[56];
} functions[MAX_FUNCTIONS];
static size_t function_count;

static uint64_t *counter_of(const char *name)
{
    for (size_t i = 0; i < function_count; i++)
        if (!strcmp(functions[i].name, name))
            return &functions[i].instructions;
    if (function_count == MAX_FUNCTIONS)
        abort();
    snprintf(functions[function_count].name, sizeof functions->name, "%.55s", name);
    return &functions[function_count++].instructions;
}

static void translated(uint64_t id, struct qemu_plugin_tb *tb)
{
    (void)id;
    for (size_t i = 0; i < qemu_plugin_tb_n_insns(tb); i++) {
        struct qemu_plugin_insn *insn = qemu_plugin_tb_get_insn(tb, i);
        const char *name = qemu_plugin_insn_symbol(insn);
        qemu_plugin_register_vcpu_insn_exec_inline(insn, PLUGIN_ADD, counter_of(name ? name : "?"), 1);
    }
}

static int compare(const void *a, const void *b)
{
    uint64_t x = ((const struct function *)a)->instructions, y = ((const struct function *)b)->instructions;
    return (x < y) - (x > y);
}

static void ended(uint64_t id, void *data)
{
    (void)id;
    (void)data;
    qsort(functions, function_count, sizeof *functions, compare);
    for (size_t i = 0; i < function_count && functions[i].instructions; i++)
        fprintf(stderr, "%12llu %s\n", (unsigned long long)functions[i].instructions, functions[i].name);
}

int qemu_plugin_install(uint64_t id, const void *info, int argc, char **argv)
{
    (void)info;
    (void)argc;
    (void)argv;
    qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
    qemu_plugin_register_atexit_cb(id, ended, NULL);
    return 0;
}
