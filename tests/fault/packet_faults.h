/*
 * One packet of a push goes wrong: the cable is pulled, the bus reset, the endpoint stalled, the packet lost, repeated, exchanged with
 * the next, cut short or changed, on its way to the device or back. The host notices what it can notice, opens the device again and
 * pushes again, as gtusb does; then the slot holds what was pushed, and before that what it held or what was pushed.
 */
#ifndef TESTS_FAULT_PACKET_FAULTS_H
#define TESTS_FAULT_PACKET_FAULTS_H

#include "lab.h"

enum { PACKET_FAULT_SCENARIOS = 4 };

struct packet_fault {
    unsigned scenario;
    unsigned packet; /* of the push: those to the device first, then those from it */
    unsigned how;
};

struct packet_faults;

struct packet_faults *packet_faults_create(void);
void packet_faults_destroy(struct packet_faults *p);

const char *packet_faults_scenario(unsigned scenario);

/* Cases of a scenario; the n-th. */
uint32_t packet_faults_count(const struct packet_faults *p, unsigned scenario);
struct packet_fault packet_faults_case(const struct packet_faults *p, unsigned scenario, uint32_t n);

/* "full_speed/17/5", and back; false when it names no case. */
void packet_faults_name(char name[64], const struct packet_fault *f);
bool packet_faults_parse(struct packet_fault *f, const char *name);

/* NULL when all is well, else what is wrong. */
const char *packet_faults_run(struct packet_faults *p, const struct packet_fault *f);

/* Pushes so far that went on where the fault had stopped them. */
uint32_t packet_faults_resumed(const struct packet_faults *p);

#endif
