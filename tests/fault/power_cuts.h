/*
 * The power fails at every flash operation of a push, in every way sim_cut_power knows; then the device starts again, and its slots hold
 * what they held before or what was pushed, whole; it renders, and takes the push when it is repeated.
 */
#ifndef TESTS_FAULT_POWER_CUTS_H
#define TESTS_FAULT_POWER_CUTS_H

#include "lab.h"

enum { POWER_CUT_SCENARIOS = 8 };

struct power_cut {
    unsigned scenario;
    unsigned operation; /* flash operation of the scenario */
    uint32_t how;       /* of sim_cut_power */
    bool again;         /* a second cut, at an operation of the start that follows or of the repeated push */
    unsigned second_operation;
    uint32_t second_how;
};

struct power_cuts;

struct power_cuts *power_cuts_create(void);
void power_cuts_destroy(struct power_cuts *p);

const char *power_cuts_scenario(unsigned scenario);

/* Cases of a scenario; the n-th. */
uint32_t power_cuts_count(const struct power_cuts *p, unsigned scenario);
struct power_cut power_cuts_case(const struct power_cuts *p, unsigned scenario, uint32_t n);

/* "replace/17/5" or "replace/17/5/3/2", and back; false when it names no case. */
void power_cuts_name(char name[64], const struct power_cut *c);
bool power_cuts_parse(struct power_cut *c, const char *name);

/* Pushes so far that went on where the power had failed. */
uint32_t power_cuts_resumed(const struct power_cuts *p);

/* NULL when all is well, else what is wrong. */
const char *power_cuts_run(struct power_cuts *p, const struct power_cut *c);

#endif
