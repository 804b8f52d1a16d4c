/*
 * Pushes of random sizes with random faults, one after the other, while the device renders for its display: nothing is lost, nothing leaks,
 * uploads never take more of the tiles' time than is theirs, and no tile takes more than its budget. 10,000 with GONIOTILE_LONG set, else 200.
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "lab.h"
#include "ref_table.h"

enum { MAX_HEIGHT = 146, FAULTS = 9, TILES = 4 };

static uint64_t seed = 1;

static uint32_t random32(void)
{
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(seed >> 32);
}

struct table {
    uint8_t *data;
    size_t bytes;
};

static struct table table_random(void)
{
    static uint32_t texels[9 * MAX_HEIGHT * 2];
    struct table t;
    unsigned height = 2 + random32() % (MAX_HEIGHT - 1);
    for (size_t i = 0; i < 9 * 2 * height; i++)
        texels[i] = (random32() & 0x7ffffff) | 15u << 27;
    t.data = ref_ktx2_make(9, height, 2, texels, 60000, &t.bytes);
    return t;
}

/* What one step of the firmware may serve, and what it served. */
struct account {
    uint64_t frames, ticks, served;
};

static struct lab *lab;
static struct account account;
static unsigned resumed;                                       /* pushes, after a loss of power */
static unsigned budgeted, reduced;                             /* tiles with a budget; below full quality */
static enum { INTACT, DATA_WRONG, HEADER_WRONG } next_message; /* one bit of it, on its way */
static struct table slots[LAB_SLOTS];                          /* what is live in the table slots */

static bool holds(uint32_t slot, const struct table *t)
{
    uint32_t bytes;
    const uint8_t *found = table_store_content(&lab->device->app.store, slot, &bytes);
    return found && bytes == t->bytes && memcmp(found, t->data, bytes) == 0;
}

/* Of the frame that has just ended. */
static void check_tiles(const struct app *app)
{
    for (uint32_t i = 0; i < app->stats.tile_count; i++) {
        const struct usb_tile_stats *t = &app->config.tile_stats[i];
        assert_true(!t->budget || t->ticks <= t->budget);
        budgeted += t->budget != 0;
    }
    reduced += app->stats.tiles_reduced;
}

/* Runs the firmware for a while and keeps the account: the bytes served cost no more than one part in APP_PUSH_SHARE of the tiles,
 * but for what was saved up and a byte that every tile earns however cheap it is. */
static void account_steps(unsigned count)
{
    const struct app *app = &lab->device->app;
    for (unsigned i = 0; i < count; i++) {
        uint32_t ticks = app->frame.active ? app->frame.stats.total.ticks : 0, frames = app->frames;
        uint32_t received = app->store.upload.received;
        sim_device_poll(lab->device);
        if (app->frame.active && app->frame.stats.total.ticks > ticks)
            account.ticks += app->frame.stats.total.ticks - ticks;
        account.frames += app->frames - frames;
        if (app->frames != frames)
            check_tiles(app);
        if (app->store.upload.received > received) {
            assert_true(app->store.upload.received - received <= USB_MAX_DATA);
            account.served += app->store.upload.received - received;
        }
        assert_true(account.served * APP_PUSH_SHARE * APP_PUSH_COST <=
                    account.ticks + (USB_MAX_DATA + account.frames * TILES + TILES) * APP_PUSH_SHARE * APP_PUSH_COST);
    }
}

/* A request and its reply, with every step of the firmware on the account. False when the device is gone or refuses. */
static bool ask(uint8_t type, const void *payload, uint32_t bytes, void *into, size_t most)
{
    static uint16_t sequence;
    struct sim_device *d = lab->device;
    uint8_t message[sizeof(struct usb_header) + USB_MAX_PAYLOAD], packet[512];
    struct usb_header h = {USB_PROTOCOL_MAGIC, USB_PROTOCOL_VERSION, type, ++sequence, 0, bytes, 0};
    sim_device_check(d, &h, payload);
    memcpy(message, &h, sizeof h);
    if (bytes)
        memcpy(message + sizeof h, payload, bytes);
    bool lost = next_message == HEADER_WRONG; /* who asked cannot be told from it */
    if (next_message == DATA_WRONG)
        message[sizeof h + 4 + random32() % (bytes - 4)] ^= (uint8_t)(1 << random32() % 8);
    else if (next_message == HEADER_WRONG)
        message[random32() % 3] ^= (uint8_t)(1 << random32() % 8); /* magic or version */
    next_message = INTACT;
    int n = 0, total = (int)(sizeof h + bytes);
    for (int sent = 0; sent<total; sent += n> 0 ? n : 0) {
        n = sim_out(d->board, USB_ENDPOINT_OUT, message + sent, (size_t)(total - sent));
        if (n < 0 && n != SIM_NAK) {
            assert_true(n != SIM_STALL || lost);
            return false;
        }
        account_steps(random32() % 3);
    }
    size_t got = 0;
    do {
        for (n = SIM_NAK; n == SIM_NAK; n = sim_in(d->board, USB_ENDPOINT_IN, packet, sizeof packet))
            account_steps(1);
        if (n < 0)
            return false;
        if (got == 0)
            memcpy(&h, packet, sizeof h);
        size_t skip = got == 0 ? sizeof h : 0, place = got + skip - sizeof h;
        if (place < most)
            memcpy((uint8_t *)into + place, packet + skip,
                   (size_t)n - skip < most - place ? (size_t)n - skip : most - place);
        got += (size_t)n;
    } while (n == (int)sizeof packet);
    assert_true(lost || h.sequence == sequence);
    return h.status == USB_OK;
}

/* BEGIN, or going on after `kept`, and DATA up to `end`, in messages of random sizes. Stops where the power does. */
static bool send_part(uint32_t slot, const struct table *t, uint32_t kept, uint32_t end)
{
    struct usb_begin begin = {slot, USB_SLOT_TABLE, (uint32_t)t->bytes, (uint32_t)crc32(0, t->data, (uInt)t->bytes)};
    if (kept == 0 && !ask(USB_MSG_BEGIN, &begin, sizeof begin, NULL, 0))
        return false;
    lab->device->content_crc = (uint32_t)crc32(0, t->data, kept);
    for (uint32_t at = kept, n; at < end; at += n) {
        uint8_t message[USB_MAX_PAYLOAD];
        n = 1 + random32() % USB_MAX_DATA;
        n = n < end - at ? n : end - at;
        memcpy(message, &at, 4);
        memcpy(message + 4, t->data + at, n);
        if (!ask(USB_MSG_DATA, message, 4 + n, NULL, 0))
            return false;
    }
    return true;
}

static bool commit(void)
{
    return ask(USB_MSG_COMMIT, NULL, 0, NULL, 0);
}

static void enumerate(void)
{
    uint8_t descriptors[64];
    assert_true(sim_device_enumerate(lab->device, descriptors) > 0);
}

/* A push that meets one fault and is then brought to its end. */
static void push_with_fault(uint32_t slot, struct table *t, unsigned fault)
{
    uint32_t part = random32() % (uint32_t)(t->bytes + 1);
    struct usb_info info;
    bool done = false;
    switch (fault) {
    case 0: /* none */
        assert_true(send_part(slot, t, 0, (uint32_t)t->bytes) && commit());
        done = true;
        break;
    case 1: /* the cable is pulled, or the bus reset: the push goes on */
    case 2:
        assert_true(send_part(slot, t, 0, part));
        if (fault == 1)
            sim_unplug(lab->device->board);
        account_steps(random32() % 20);
        enumerate();
        assert_true(ask(USB_MSG_INFO, NULL, 0, &info, sizeof info));
        assert_int_equal(info.upload_received, part);
        assert_int_equal(info.upload_found, crc32(0, t->data, part));
        assert_true(send_part(slot, t, part, (uint32_t)t->bytes) && commit());
        done = true;
        break;
    case 6: /* a bit of the data is wrong: it is sent again */
    case 7: /* a bit of the header is: the endpoint stalls, the halts are cleared and the push goes on */
        part = 1 + part % (uint32_t)(t->bytes - 1);
        assert_true(send_part(slot, t, 0, part));
        next_message = fault == 6 ? DATA_WRONG : HEADER_WRONG;
        assert_false(send_part(slot, t, part, (uint32_t)t->bytes));
        for (unsigned endpoint = 0x01; fault == 7 && endpoint <= 0x81; endpoint += 0x80)
            assert_int_equal(
                sim_device_control(lab->device, (const uint8_t[8]){0x02, 1, 0, 0, (uint8_t)endpoint}, NULL), 0);
        assert_true(ask(USB_MSG_INFO, NULL, 0, &info, sizeof info));
        assert_int_equal(info.upload_received, part);
        assert_true(send_part(slot, t, part, (uint32_t)t->bytes) && commit());
        done = true;
        break;
    case 8: /* the flash fails for a while */
        sim_fail_flash_after(lab->device->board, random32() % 50);
        done = send_part(slot, t, 0, (uint32_t)t->bytes) && commit();
        sim_fail_flash_after(lab->device->board, -1);
        break;
    case 3: /* it is given up */
        assert_true(send_part(slot, t, 0, part));
        assert_true(ask(USB_MSG_ABORT, NULL, 0, NULL, 0));
        break;
    default: /* the power fails */
        sim_cut_power(lab->device->board, random32() % 50, random32() % 200);
        done = send_part(slot, t, 0, (uint32_t)t->bytes) && commit();
        sim_cut_power(lab->device->board, -1, 0);
        sim_device_restart(lab->device);
        enumerate();
        assert_true(ask(USB_MSG_INFO, NULL, 0, &info, sizeof info));
        if (!done && fault == 5 && info.upload_slot == slot &&
            info.upload_crc == crc32(0, t->data, (uInt)t->bytes)) { /* it goes on from the last mark */
            assert_int_equal(info.upload_found, crc32(0, t->data, info.upload_received));
            assert_true(send_part(slot, t, info.upload_received, (uint32_t)t->bytes) && commit());
            done = true;
            resumed++;
        }
        break;
    }
    if (holds(slot, t)) {
        struct table old = slots[slot];
        slots[slot] = *t;
        *t = old;
    } else {
        assert_false(done); /* a push that ended well is never lost */
    }
}

/* Between the least that the scene needs and twice that. */
static void set_budget(void)
{
    uint32_t set[2] = {USB_SET_BUDGET, 1};
    assert_false(ask(USB_MSG_SET, set, sizeof set, NULL, 0));
    const uint32_t least = lab->device->app.frame.raster.budget_needed;
    assert_true(least > 1);
    set[1] = least + random32() % least;
    assert_true(ask(USB_MSG_SET, set, sizeof set, NULL, 0));
}

static void pushes_with_faults_while_rendering_lose_nothing(void **state)
{
    unsigned count = getenv("GONIOTILE_LONG") ? 10000 : 200;
    (void)state;
    for (unsigned i = 0; i < count; i++) {
        uint32_t slot = 1 + random32() % (LAB_SLOTS - 1), frames = lab->device->app.frames;
        struct table t = table_random();
        set_budget(); /* a loss of power has forgotten the last one */
        push_with_fault(slot, &t, random32() % FAULTS);
        free(t.data);
        for (uint32_t s = 1; s < LAB_SLOTS; s++)
            assert_true(slots[s].data ? holds(s, &slots[s]) : lab->device->app.store.slots[s].kind == USB_SLOT_EMPTY);
        frames = lab->device->app.frames;
        for (int steps = 0; lab->device->app.frames < frames + 2; steps++) {
            assert_true(steps < 100);
            account_steps(1);
        }
    }
    printf("# %u pushes, %llu bytes, %u resumed after a loss of power, %llu frames, %u tiles with a budget, %u of them "
           "reduced\n",
           count, (unsigned long long)account.served, resumed, (unsigned long long)account.frames, budgeted, reduced);
    assert_true(budgeted > count && reduced > 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(pushes_with_faults_while_rendering_lose_nothing)};
    lab = lab_create(true, true);
    lab_start(lab, NULL);
    lab_push(lab, 0, LAB_SCENE_A);
    slots[1] = table_random(); /* from now on it renders, always */
    struct usb_header h = {0};
    if (!sim_device_push(lab->device, 1, USB_SLOT_TABLE, slots[1].data, (uint32_t)slots[1].bytes, &h) || h.status)
        abort();
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    for (int s = 0; s < LAB_SLOTS; s++)
        free(slots[s].data);
    lab_destroy(lab);
    return failed;
}
