/* The check of requests, VERIFY, and the time that uploads may take. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "protocol_client.h"

/* One bit of a request wrong, header or payload: refused, nothing happens, and the halt's clearing brings all back. */
static void damaged_requests_do_nothing(void **state)
{
    struct sim_device *d = ready_device(true, false);
    struct usb_select select = {0, 1};
    struct usb_header reply;
    static uint8_t first[PICTURE], now[PICTURE];
    (void)state;
    push_table(d, 2, 50);
    frame(d, first, NULL);
    for (unsigned bit = 0; bit < 8 * 20; bit++) {
        struct stream s = {.bytes = 0};
        uint8_t packet[512];
        stream_add(&s, USB_MSG_SELECT, &select, sizeof select);
        s.data[bit / 8] ^= (uint8_t)(1 << bit % 8);
        sim_out(d->board, 1, s.data, s.bytes);
        for (int i = 0; i < 20; i++)
            sim_device_poll(d);
        int n = sim_in(d->board, 0x81, packet, sizeof packet);
        if (n != SIM_NAK) { /* a longer length makes it wait for more */
            assert_int_equal(n, 16);
            memcpy(&reply, packet, 16);
            assert_true(reply.status == USB_ERR_DAMAGED || reply.status == USB_ERR_MAGIC ||
                        reply.status == USB_ERR_VERSION || reply.status == USB_ERR_LENGTH ||
                        reply.status == USB_ERR_STATE); /* of a DATA without upload */
        }
        clear_halt(d, 0x01);
        clear_halt(d, 0x81);
        assert_int_equal(d->app.content.materials[0].slot, 0);
    }
    frame(d, now, NULL);
    assert_memory_equal(now, first, PICTURE);
    sim_device_destroy(d);
}

/* A DATA message whose content was damaged on the way is refused at once, and may be sent again. */
static void damaged_data_is_refused_and_can_be_sent_again(void **state)
{
    struct sim_device *d = ready_device(false, false);
    size_t bytes;
    uint8_t *table = fixture_table(31, &bytes);
    struct usb_begin begin = {2, USB_SLOT_TABLE, (uint32_t)bytes, crc32_update(0, table, bytes)};
    static struct stream s;
    uint8_t message[USB_MAX_PAYLOAD] = {0}, packet[64];
    struct usb_header reply;
    (void)state;
    memcpy(message + 4, table, 300);
    assert_int_equal(ask(d, USB_MSG_BEGIN, &begin, sizeof begin, NULL), USB_OK);
    for (int bit = 0; bit < 8 * 300; bit += 11) {
        stream_add(&s, USB_MSG_DATA, message, 304);
        s.data[20 + bit / 8] ^= (uint8_t)(1 << bit % 8);
        assert_int_equal(sim_out(d->board, 1, s.data, s.bytes), s.bytes);
        s.bytes = 0;
        sim_device_poll(d);
        assert_int_equal(sim_in(d->board, 0x81, packet, 64), 16);
        memcpy(&reply, packet, 16);
        assert_int_equal(reply.status, USB_ERR_DAMAGED);
        assert_int_equal(reply.detail, 0);
    }
    for (uint32_t at = 0, n; at < bytes; at += n) {
        n = bytes - at < 300 ? (uint32_t)bytes - at : 300;
        memcpy(message, &at, 4);
        memcpy(message + 4, table + at, n);
        assert_int_equal(ask(d, USB_MSG_DATA, message, 4 + n, NULL), USB_OK);
        struct usb_info i = info(d);
        assert_int_equal(i.upload_received, at + n);
        assert_int_equal(i.upload_found, crc32_update(0, table, at + n));
    }
    assert_int_equal(ask(d, USB_MSG_COMMIT, NULL, 0, NULL), USB_OK);
    free(table);
    sim_device_destroy(d);
}

static void verify_reads_the_flash(void **state)
{
    struct sim_device *d = ready_device(false, true);
    struct usb_verify v = {1};
    uint32_t detail, bytes, flash_bytes;
    (void)state;
    struct usb_info i = info(d);
    assert_int_equal(ask(d, USB_MSG_VERIFY, &v, sizeof v, &detail), USB_OK);
    assert_int_equal(detail, i.slots[1].crc);
    uint8_t *content =
        sim_flash(d->board, &flash_bytes) + (table_store_content(&d->app.store, 1, &bytes) - sim_hal(d->board)->flash);
    content[bytes - 1] ^= 1;
    assert_int_equal(ask(d, USB_MSG_VERIFY, &v, sizeof v, &detail), USB_OK);
    assert_int_equal(detail, crc32_update(0, content, bytes));
    assert_int_not_equal(detail, i.slots[1].crc);
    v.slot = 2;
    assert_int_equal(ask(d, USB_MSG_VERIFY, &v, sizeof v, NULL), USB_ERR_STATE);
    v.slot = 3;
    assert_int_equal(ask(d, USB_MSG_VERIFY, &v, sizeof v, &detail), USB_ERR_SLOT);
    assert_int_equal(detail, 3);
    sim_device_destroy(d);
}

/* Content larger than what one step reads, and a host that goes away in the middle: the next VERIFY starts anew. */
static void verify_of_much_goes_on_beside_frames(void **state)
{
    struct sim_device *d = ready_device(false, true);
    struct usb_verify v = {0};
    struct stream s = {.bytes = 0};
    static uint32_t words[FIXTURE_CAPACITY / 4];
    uint32_t detail;
    (void)state;
    size_t bytes;
    uint8_t *scene = fixture_scene(&bytes);
    memcpy(words, scene, bytes);
    struct table_store_slot *live = &d->app.store.slots[0];
    live->length = FIXTURE_CAPACITY; /* as if the scene were this long */
    stream_add(&s, USB_MSG_VERIFY, &v, sizeof v);
    sim_out(d->board, 1, s.data, s.bytes);
    sim_device_poll(d);
    assert_true(d->app.verified > 0 && d->app.verified < FIXTURE_CAPACITY);
    clear_halt(d, 0x01);
    clear_halt(d, 0x81);
    assert_int_equal(d->app.verified, 0);
    memset((uint8_t *)words + bytes, 0xff, sizeof words - bytes);
    assert_int_equal(ask(d, USB_MSG_VERIFY, &v, sizeof v, &detail), USB_OK);
    uint32_t padded = crc32_update(0, words, sizeof words);
    assert_int_equal(detail, padded);
    free(scene);
    sim_device_destroy(d);
}

/* Between two tiles of the display's frames no more is served than the tiles have earned. */
static void uploads_leave_the_tiles_their_time(void **state)
{
    struct sim_device *d = ready_device(true, true);
    static uint8_t data[FIXTURE_CAPACITY];
    static struct stream s;
    struct usb_begin begin = {2, USB_SLOT_TABLE, sizeof data, 1};
    uint64_t ticks = 0, served = 0;
    uint32_t frames = d->app.frames, first = frames;
    uint8_t message[4 + 1000] = {0}, packet[512];
    (void)state;
    assert_int_equal(ask(d, USB_MSG_BEGIN, &begin, sizeof begin, NULL), USB_OK);
    for (uint32_t at = 0; at + 1000 <= sizeof data; at += 1000) {
        memcpy(message, &at, 4);
        stream_add(&s, USB_MSG_DATA, message, sizeof message);
    }
    size_t sent = 0;
    uint32_t total = d->app.frame.stats.total.ticks, tile = d->app.frame.next_tile;
    while (d->app.store.upload.received < 12000) {
        uint32_t before = d->app.store.upload.received;
        int n = sim_out(d->board, 1, s.data + sent, s.bytes - sent);
        sent += n > 0 ? (size_t)n : 0;
        sim_device_poll(d);
        sim_in(d->board, 0x81, packet, sizeof packet);
        served += d->app.store.upload.received - before;
        if (d->app.frame.active && d->app.frame.next_tile > tile && d->app.frames == frames)
            ticks += d->app.frame.stats.total.ticks - total;
        else if (d->app.frame.active)
            ticks += d->app.frame.stats.total.ticks;
        frames = d->app.frames;
        total = d->app.frame.active ? d->app.frame.stats.total.ticks : 0;
        tile = d->app.frame.next_tile;
        assert_true(served * APP_PUSH_SHARE * APP_PUSH_COST <=
                    ticks + (USB_MAX_DATA + TILES * (frames - first) + TILES) * APP_PUSH_SHARE * APP_PUSH_COST);
        assert_true(d->app.store.upload.received - before <= 1000);
    }
    sim_device_destroy(d);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(damaged_requests_do_nothing),
        cmocka_unit_test(damaged_data_is_refused_and_can_be_sent_again),
        cmocka_unit_test(verify_reads_the_flash),
        cmocka_unit_test(verify_of_much_goes_on_beside_frames),
        cmocka_unit_test(uploads_leave_the_tiles_their_time),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
