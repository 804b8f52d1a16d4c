/*
 * Plugin for QEMU: the addresses of instructions as they are executed in functions whose names begin with one of PREFIXES, one a line
 * on stderr: COUNT of them after SKIP.
 *
 *   -plugin trace.so,names=PREFIX[:PREFIX...],skip=SKIP,count=COUNT
 */
#include "qemu_plugin.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

int qemu_plugin_version = 1;

static const char *names = "";
static uint64_t skip, count;

static bool is_traced(const char *symbol)
{
    for (const char *n = names; symbol && *n;) {
        const size_t length = strcspn(n, ":");
        if (!strncmp(symbol, n, length))
            return true;
        n += length + (n[length] == ':');
    }
    return false;
}

static void executed(unsigned cpu, void *address)
{
    (void)cpu;
    if (skip)
        skip--;
    else if (count) {
        count--;
        fprintf(stderr, "%lx\n", (unsigned long)(uintptr_t)address);
    }
}

static void translated(uint64_t id, struct qemu_plugin_tb *tb)
{
    (void)id;
    for (size_t i = 0; i < qemu_plugin_tb_n_insns(tb); i++) {
        struct qemu_plugin_insn *insn = qemu_plugin_tb_get_insn(tb, i);
        if (is_traced(qemu_plugin_insn_symbol(insn)))
            qemu_plugin_register_vcpu_insn_exec_cb(insn, executed, PLUGIN_NO_REGS,
                                                   (void *)(uintptr_t)qemu_plugin_insn_vaddr(insn));
    }
}

int qemu_plugin_install(uint64_t id, const void *info, int argc, char **argv)
{
    (void)info;
    for (int i = 0; i < argc; i++)
        if (!strncmp(argv[i], "names=", 6))
            names = strdup(argv[i] + 6);
        else if (!strncmp(argv[i], "skip=", 5))
            skip = strtoull(argv[i] + 5, NULL, 10);
        else if (!strncmp(argv[i], "count=", 6))
            count = strtoull(argv[i] + 6, NULL, 10);
        else
            return -1;
    qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
    return 0;
}
