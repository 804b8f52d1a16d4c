/*
 * A small device with flash to spare, and what its pictures look like with each of the tables: what the fault tests do their harm to.
 *
 * Scene in slot 0, table slots 1 to 3; the scene's only material takes its table from slot 1. Everything the tests push is known here,
 * so that any content found later is either one of these, whole, or wrong.
 */
#ifndef TESTS_FAULT_LAB_H
#define TESTS_FAULT_LAB_H

#include "sim_device.h"

enum { LAB_SLOTS = 4, LAB_WIDTH = 100, LAB_HEIGHT = 40, LAB_PICTURE = 3 * LAB_WIDTH * LAB_HEIGHT };

/* Contents by number. Tables are of one colour each; they take one, two or three blocks, which is all of a bank. LAB_NOTHING: an empty
 * slot. */
enum lab_content {
    LAB_NOTHING,
    LAB_SMALL_A,
    LAB_SMALL_B,
    LAB_SMALL_C,
    LAB_MIDDLE_A,
    LAB_MIDDLE_B,
    LAB_BIG_A,
    LAB_BIG_B,
    LAB_BIG_C,
    LAB_SCENE_A,
    LAB_SCENE_B,
    LAB_CONTENTS
};

struct lab {
    struct sim_device *device;
    uint32_t resumed; /* pushes that went on where an earlier one had stopped */
    uint32_t flash_bytes;
    size_t bytes[LAB_CONTENTS];
    uint8_t *data[LAB_CONTENTS];
    uint8_t pictures[2][LAB_CONTENTS][LAB_PICTURE]; /* by scene, A or B, and table in slot 1 */
};

/* Ends the program when anything goes wrong that is not the firmware's fault. */
struct lab *lab_create(bool high_speed, bool display);
void lab_destroy(struct lab *lab);

/* The device's flash becomes `image` (NULL: erased), the firmware starts anew and is enumerated. */
void lab_start(struct lab *lab, const uint8_t *image);

/* A push that must succeed; a push whose end does not matter. As gtusb, they go on with what an earlier one left. */
void lab_push(struct lab *lab, uint32_t slot, enum lab_content content);
bool lab_try_push(struct lab *lab, uint32_t slot, enum lab_content content);

/* What a slot holds: its number, or -1 when it is none of these, whole. */
int lab_slot(struct lab *lab, uint32_t slot);

/* NULL when the device tells the same of its slots as `content` says, holds it whole, verifies it and renders what belongs to
 * it; else what is wrong. */
const char *lab_check(struct lab *lab, const enum lab_content content[LAB_SLOTS]);

#endif
