#include "power_cuts.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { HOWS = SIM_CUT_DURING + 99, TWICE_HOWS = 5, MAX_STEPS = 6 };

/* Ways to cut when there are two cuts: around the operation, after half of its bytes, with half or almost all of its bits. */
static const uint32_t twice_hows[TWICE_HOWS] = {SIM_CUT_BEFORE, SIM_CUT_AFTER, SIM_CUT_DURING + 9 * 32,
                                                SIM_CUT_DURING + 3, SIM_CUT_DURING + 5};

struct step {
    uint32_t slot;
    enum lab_content content;
};

/* What is pushed before, undisturbed; then the push that is cut. */
static const struct scenario {
    const char *name;
    bool twice;  /* two cuts in a row instead of one */
    bool scrubs; /* the header of the push before is torn: its erasure at start belongs to the operations */
    struct step before[MAX_STEPS];
    struct step cut;
} scenarios[POWER_CUT_SCENARIOS] = {
    {"first_write", false, false, {{0, LAB_SCENE_A}}, {1, LAB_BIG_A}},
    {"replace", false, false, {{0, LAB_SCENE_A}, {1, LAB_BIG_A}}, {1, LAB_BIG_B}},
    {"replace_other_bank", false, false, {{0, LAB_SCENE_A}, {1, LAB_BIG_A}, {1, LAB_BIG_B}}, {1, LAB_BIG_C}},
    {"full_store",
     false,
     false,
     {{0, LAB_SCENE_B}, {0, LAB_SCENE_A}, {1, LAB_BIG_B}, {1, LAB_BIG_A}, {2, LAB_BIG_C}, {2, LAB_BIG_B}},
     {2, LAB_BIG_A}},
    {"interrupted_scrub", false, true, {{0, LAB_SCENE_A}, {1, LAB_BIG_A}, {1, LAB_BIG_B}}, {1, LAB_BIG_C}},
    {"scene", false, false, {{0, LAB_SCENE_A}, {1, LAB_SMALL_A}}, {0, LAB_SCENE_B}},
    {"replace_twice_cut", true, false, {{0, LAB_SCENE_A}, {1, LAB_MIDDLE_A}}, {1, LAB_MIDDLE_B}},
    {"scrub_twice_cut", true, true, {{0, LAB_SCENE_A}, {1, LAB_SMALL_A}, {1, LAB_SMALL_B}}, {1, LAB_SMALL_C}},
};

struct power_cuts {
    struct lab *lab;
    uint8_t *images[POWER_CUT_SCENARIOS]; /* of the flash at the beginning */
    unsigned operations[POWER_CUT_SCENARIOS];
    enum lab_content before[POWER_CUT_SCENARIOS][LAB_SLOTS];
};

static struct sim *board(struct power_cuts *p)
{
    return p->lab->device->board;
}

/* The start and the push, as far as the power lasts. True when it lasts to the end. */
static bool attempt(struct power_cuts *p, unsigned scenario, const uint8_t *image)
{
    const struct step *cut = &scenarios[scenario].cut;
    lab_start(p->lab, image);
    return lab_try_push(p->lab, cut->slot, cut->content);
}

static void scenario_prepare(struct power_cuts *p, unsigned scenario)
{
    const struct scenario *s = &scenarios[scenario];
    uint32_t bytes;
    lab_start(p->lab, NULL);
    for (int i = 0; i < MAX_STEPS && s->before[i].content; i++) {
        enum lab_content *slot = &p->before[scenario][s->before[i].slot];
        bool torn = s->scrubs && (i + 1 == MAX_STEPS || !s->before[i + 1].content);
        long before = sim_flash_operations(board(p));
        if (torn) { /* count, then do it again with the power failing in the header */
            uint8_t *copy = malloc(p->lab->flash_bytes);
            memcpy(copy, sim_flash(board(p), &bytes), p->lab->flash_bytes);
            lab_push(p->lab, s->before[i].slot, s->before[i].content);
            long header = sim_flash_operations(board(p)) - before - 1;
            lab_start(p->lab, copy);
            sim_cut_power(board(p), header, SIM_CUT_DURING + 3);
            lab_try_push(p->lab, s->before[i].slot, s->before[i].content);
            free(copy);
        } else {
            lab_push(p->lab, s->before[i].slot, s->before[i].content);
            *slot = s->before[i].content;
        }
    }
    p->images[scenario] = malloc(p->lab->flash_bytes);
    memcpy(p->images[scenario], sim_flash(board(p), &bytes), p->lab->flash_bytes);
    sim_cut_power(board(p), -1, 0);
    long first = sim_flash_operations(board(p));
    if (!attempt(p, scenario, p->images[scenario]))
        abort();
    p->operations[scenario] = (unsigned)(sim_flash_operations(board(p)) - first);
}

struct power_cuts *power_cuts_create(void)
{
    struct power_cuts *p = calloc(1, sizeof *p);
    p->lab = lab_create(true, false);
    for (unsigned s = 0; s < POWER_CUT_SCENARIOS; s++)
        scenario_prepare(p, s);
    return p;
}

void power_cuts_destroy(struct power_cuts *p)
{
    for (unsigned s = 0; s < POWER_CUT_SCENARIOS; s++)
        free(p->images[s]);
    lab_destroy(p->lab);
    free(p);
}

uint32_t power_cuts_resumed(const struct power_cuts *p)
{
    return p->lab->resumed;
}

const char *power_cuts_scenario(unsigned scenario)
{
    return scenarios[scenario].name;
}

/* Operations between the first cut and the end of the repeated push, at most: scrubbing takes three more. */
static unsigned second_operations(const struct power_cuts *p, unsigned scenario)
{
    return p->operations[scenario] + 3;
}

uint32_t power_cuts_count(const struct power_cuts *p, unsigned scenario)
{
    if (scenarios[scenario].twice)
        return p->operations[scenario] * TWICE_HOWS * second_operations(p, scenario) * TWICE_HOWS;
    return p->operations[scenario] * HOWS;
}

struct power_cut power_cuts_case(const struct power_cuts *p, unsigned scenario, uint32_t n)
{
    if (!scenarios[scenario].twice)
        return (struct power_cut){.scenario = scenario, .operation = n / HOWS, .how = n % HOWS};
    unsigned first_how = n % TWICE_HOWS, second_how = n / TWICE_HOWS % TWICE_HOWS;
    n /= TWICE_HOWS * TWICE_HOWS;
    return (struct power_cut){.scenario = scenario,
                              .operation = n / second_operations(p, scenario),
                              .how = twice_hows[first_how],
                              .again = true,
                              .second_operation = n % second_operations(p, scenario),
                              .second_how = twice_hows[second_how]};
}

void power_cuts_name(char name[64], const struct power_cut *c)
{
    int n = snprintf(name, 64, "%s/%u/%u", scenarios[c->scenario].name, c->operation, c->how);
    if (c->again)
        snprintf(name + n, 64 - (size_t)n, "/%u/%u", c->second_operation, c->second_how);
}

bool power_cuts_parse(struct power_cut *c, const char *name)
{
    for (unsigned s = 0; s < POWER_CUT_SCENARIOS; s++) {
        size_t n = strlen(scenarios[s].name);
        *c = (struct power_cut){.scenario = s};
        if (strncmp(name, scenarios[s].name, n) != 0 || name[n] != '/')
            continue;
        int fields = sscanf(name + n, "/%u/%u/%u/%u", &c->operation, &c->how, &c->second_operation, &c->second_how);
        c->again = fields == 4;
        return fields == 2 || fields == 4;
    }
    return false;
}

/* After a restart: the slot holds the old or the new content, whole; *slots follows. */
static const char *slots_check(struct power_cuts *p, unsigned scenario, enum lab_content slots[LAB_SLOTS],
                               bool complete)
{
    const struct step *cut = &scenarios[scenario].cut;
    if (lab_slot(p->lab, cut->slot) == (int)cut->content)
        slots[cut->slot] = cut->content;
    else if (complete)
        return "a push that was answered with success is lost";
    return lab_check(p->lab, slots);
}

const char *power_cuts_run(struct power_cuts *p, const struct power_cut *c)
{
    const struct step *cut = &scenarios[c->scenario].cut;
    enum lab_content slots[LAB_SLOTS];
    const char *wrong;
    memcpy(slots, p->before[c->scenario], sizeof slots);

    sim_cut_power(board(p), c->operation, c->how);
    bool complete = attempt(p, c->scenario, p->images[c->scenario]);
    if (!sim_power_is_cut(board(p)))
        return "the power was not cut: the operations are other than they were";
    if (complete)
        return "the host was told of success by a device without power";
    unsigned last = p->operations[c->scenario] - 1;
    bool must_be_old = c->operation < last || c->how == SIM_CUT_BEFORE;
    bool must_be_new = c->operation == last && c->how == SIM_CUT_AFTER;

    uint32_t bytes;
    uint8_t *image = NULL;
    if (c->again) { /* without a look in between, which would not disturb anything */
        image = malloc(p->lab->flash_bytes);
        memcpy(image, sim_flash(board(p), &bytes), p->lab->flash_bytes);
        sim_cut_power(board(p), c->second_operation, c->second_how);
        complete = attempt(p, c->scenario, image);
        free(image);
        must_be_old = false;
    }
    bool powered = !sim_power_is_cut(board(p)); /* the second cut's operation may lie behind the end */
    sim_cut_power(board(p), -1, 0);
    lab_start(p->lab, sim_flash(board(p), &bytes));
    wrong = slots_check(p, c->scenario, slots, must_be_new || (powered && complete));
    if (!wrong && must_be_old && slots[cut->slot] != p->before[c->scenario][cut->slot])
        wrong = "the new content is live before its record was written";
    if (wrong)
        return wrong;
    if (!lab_try_push(p->lab, cut->slot, cut->content))
        return "the push cannot be repeated";
    slots[cut->slot] = cut->content;
    if ((wrong = lab_check(p->lab, slots)))
        return wrong;
    lab_start(p->lab, sim_flash(board(p), &bytes));
    return lab_check(p->lab, slots);
}
