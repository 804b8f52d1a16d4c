/* The protocol in packets: split anywhere, read slowly, cut off in the middle; and what the picture keeps meanwhile. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "protocol_client.h"

static uint64_t seed = 1;

static uint32_t random32(void)
{
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(seed >> 32);
}

/* --- packets --- */

/* Pushes a table, asks for about everything and makes some mistakes. */
static void stream_fill(struct stream *s)
{
    size_t bytes;
    uint8_t *table = fixture_table(99, &bytes), message[USB_MAX_PAYLOAD] = {0};
    struct usb_begin begin = {1, USB_SLOT_TABLE, (uint32_t)bytes, crc32_update(0, table, bytes)};
    uint32_t one = 1;
    s->bytes = 0;
    stream_add(s, USB_MSG_INFO, NULL, 0);
    stream_add(s, USB_MSG_BEGIN, &begin, sizeof begin);
    for (uint32_t at = 0; at < bytes; at += 333) {
        uint32_t n = bytes - at < 333 ? (uint32_t)bytes - at : 333;
        memcpy(message, &at, 4);
        memcpy(message + 4, table + at, n);
        stream_add(s, USB_MSG_DATA, message, 4 + n);
    }
    stream_add(s, USB_MSG_DATA, message, 17);
    stream_add(s, 99, message, 64);
    stream_add(s, USB_MSG_COMMIT, NULL, 0);
    stream_add(s, USB_MSG_FRAME, NULL, 0);
    stream_add(s, USB_MSG_INFO, message, 48);
    stream_add(s, USB_MSG_STATS, &one, 4);
    stream_add(s, USB_MSG_RESET, NULL, 0);
    stream_add(s, USB_MSG_FRAME, NULL, 0);
    stream_add(s, USB_MSG_INFO, NULL, 0);
    free(table);
}

/* Sends the stream in pieces of up to `most` bytes, reads or not at random; collects what comes back. */
static size_t stream_play(struct sim_device *d, const struct stream *s, size_t most, uint8_t *replies, size_t room)
{
    size_t sent = 0, got = 0, idle = 0;
    while (idle < 200) {
        size_t n = random32() % (most + 1); /* zero-length packets among them */
        n = n < s->bytes - sent ? n : s->bytes - sent;
        if (sent < s->bytes && random32() % 4) {
            int r = sim_out(d->board, 1, s->data + sent, n);
            sent += r > 0 ? (size_t)r : 0;
        }
        sim_device_poll(d);
        int r = SIM_NAK;
        if (random32() % 3) {
            assert_true(room - got >= 512);
            r = sim_in(d->board, 0x81, replies + got, 512);
            got += r > 0 ? (size_t)r : 0;
        }
        idle = r >= 0 || sent < s->bytes ? 0 : idle + 1;
    }
    return got;
}

static void packet_boundaries_do_not_matter(void **state)
{
    static struct stream s;
    static uint8_t first[100000], replies[100000];
    size_t first_bytes = 0;
    (void)state;
    stream_fill(&s);
    for (int i = 0; i < 24; i++) {
        struct sim_device *d = ready_device(i % 2, false);
        size_t most = i < 2 ? 4000 : i < 12 ? 1 + random32() % 20 : 1 + random32() % 1000;
        size_t bytes = stream_play(d, &s, most, i ? replies : first, sizeof first);
        if (i == 0)
            first_bytes = bytes;
        else {
            assert_int_equal(bytes, first_bytes);
            assert_memory_equal(replies, first, bytes);
        }
        sim_device_destroy(d);
    }
    assert_true(first_bytes > 2 * PICTURE);
}

/* 40 tiles' statistics are 1024 bytes: only a zero-length packet tells the host that the reply is over. */
static void reply_of_whole_packets_ends_with_an_empty_one(void **state)
{
    struct sim_config c = {.width = 23 * RASTER_TILE_WIDTH, /* 16 + 88 + 23 * 40 bytes */
                           .height = RASTER_TILE_HEIGHT,
                           .slot_count = 2,
                           .table_bank_bytes = FIXTURE_BANK,
                           .scene_bank_bytes = FIXTURE_BANK};
    (void)state;
    for (int speed = 0; speed < 2; speed++) {
        c.high_speed = speed;
        struct sim_device *d = sim_device_create(&c);
        static uint8_t pixels[320 * 240 * 2];
        uint8_t descriptors[64], packet[512], request[20] = {0};
        struct usb_header h;
        size_t bytes, got = 0;
        assert_non_null(d);
        sim_device_enumerate(d, descriptors);
        void *scene = fixture_scene(&bytes);
        push(d, 0, scene, bytes, NULL);
        push_table(d, 1, 1);
        assert_true(sim_device_frame(d, pixels, &h));
        assert_int_equal(h.status, USB_OK);
        h = (struct usb_header){USB_PROTOCOL_MAGIC, USB_PROTOCOL_VERSION, USB_MSG_STATS, 1, 0, 4, 0};
        request[16] = 1;
        h.detail = request_check(&h, request + 16);
        memcpy(request, &h, 16);
        sim_out(d->board, 1, request, sizeof request);
        for (int n = 1; n != 0;) {
            sim_device_poll(d);
            n = sim_in(d->board, 0x81, packet, sizeof packet);
            assert_true(n >= 0);
            got += (size_t)n;
        }
        assert_int_equal(got, 1024);
        sim_device_poll(d);
        assert_int_equal(sim_in(d->board, 0x81, packet, sizeof packet), SIM_NAK);
        free(scene);
        sim_device_destroy(d);
    }
}

/* --- interruptions --- */

/* Pushes until `bytes` bytes are out, in the middle of a message, without reading a reply. */
static void push_part(struct sim_device *d, const uint8_t *table, size_t length, size_t part)
{
    static struct stream s;
    struct usb_begin begin = {1, USB_SLOT_TABLE, (uint32_t)length, crc32_update(0, table, length)};
    uint8_t message[USB_MAX_PAYLOAD] = {0};
    memcpy(message + 4, table, length);
    s.bytes = 0;
    stream_add(&s, USB_MSG_BEGIN, &begin, sizeof begin);
    stream_add(&s, USB_MSG_DATA, message, 4 + 100);
    message[0] = 100;
    memcpy(message + 4, table + 100, length - 100);
    stream_add(&s, USB_MSG_DATA, message, (uint32_t)(4 + length - 100));
    sim_out(d->board, 1, s.data, part);
    for (int i = 0; i < 10; i++)
        sim_device_poll(d);
}

static void push_cut_off_anywhere_keeps_the_old_table_and_can_go_on(void **state)
{
    static uint8_t first[PICTURE], now[PICTURE], last[PICTURE];
    size_t bytes;
    uint8_t *table = fixture_table(21, &bytes), descriptors[64];
    struct sim_device *d = ready_device(false, true);
    (void)state;
    frame(d, first, NULL);
    push_table(d, 2, 21);
    ask(d, USB_MSG_SELECT, &(struct usb_select){0, 1}, 4, NULL);
    frame(d, last, NULL);
    ask(d, USB_MSG_RESET, NULL, 0, NULL);
    for (size_t part = 1; part < 32 + 120 + 20 + bytes - 100; part += 37) {
        push_part(d, table, bytes, part);
        if (part % 2) {
            sim_unplug(d->board);
            sim_device_poll(d);
        }
        assert_int_equal(sim_device_enumerate(d, descriptors), 50);
        assert_int_equal(frame(d, now, NULL), USB_OK);
        assert_memory_equal(now, first, PICTURE);
        struct usb_info i = info(d);
        if (part < 32) {
            assert_int_equal(i.upload_slot, USB_NO_UPLOAD);
        } else {
            assert_int_equal(i.upload_slot, 1);
            assert_int_equal(i.upload_received, part < 32 + 120 ? 0 : 100);
        }
        if (part > 200 && part < 237) { /* the host takes up where it was */
            uint8_t message[USB_MAX_PAYLOAD] = {100};
            d->content_crc = i.upload_found;
            memcpy(message + 4, table + 100, bytes - 100);
            assert_int_equal(ask(d, USB_MSG_DATA, message, (uint32_t)(4 + bytes - 100), NULL), USB_OK);
            assert_int_equal(ask(d, USB_MSG_COMMIT, NULL, 0, NULL), USB_OK);
            frame(d, now, NULL);
            assert_memory_equal(now, last, PICTURE);
            assert_int_equal(push_table(d, 1, 200), USB_OK);
        }
        ask(d, USB_MSG_ABORT, NULL, 0, NULL);
    }
    free(table);
    sim_device_destroy(d);
}

static void half_a_request_is_forgotten_when_the_host_clears_the_endpoints(void **state)
{
    struct sim_device *d = ready_device(false, false);
    (void)state;
    sim_out(d->board, 1, "GT\2\2 a header cut off", 15);
    sim_device_poll(d);
    clear_halt(d, 0x01);
    clear_halt(d, 0x81);
    assert_int_equal(info(d).slot_count, 3);
    /* a reply nobody fetched does not reach the next host */
    struct usb_header h = {USB_PROTOCOL_MAGIC, USB_PROTOCOL_VERSION, USB_MSG_INFO, 4242, 0, 0, 0};
    h.detail = request_check(&h, NULL);
    sim_out(d->board, 1, &h, sizeof h);
    sim_device_poll(d);
    clear_halt(d, 0x01);
    clear_halt(d, 0x81);
    assert_int_equal(info(d).slot_count, 3);
    sim_device_destroy(d);
}

static void interrupted_frame_leaves_a_working_device(void **state)
{
    static uint8_t first[PICTURE], now[PICTURE];
    (void)state;
    for (int how = 0; how < 6; how++) {
        struct sim_device *d = ready_device(false, how % 2);
        struct usb_header h = {USB_PROTOCOL_MAGIC, USB_PROTOCOL_VERSION, USB_MSG_FRAME, 1, 0, 0, 0};
        uint8_t packet[64], descriptors[64];
        h.detail = request_check(&h, NULL);
        frame(d, first, NULL);
        sim_out(d->board, 1, &h, sizeof h);
        for (int i = 0; i < 30; i++) {
            sim_device_poll(d);
            if (how > 3)
                sim_in(d->board, 0x81, packet, 64);
        }
        assert_true(d->app.frame.streamed);
        /* endpoint 0 is served while nobody reads the tiles */
        assert_int_equal(sim_device_control(d, (const uint8_t[8]){0x80, 8, 0, 0, 0, 0, 1, 0}, packet), 1);
        if (how < 2)
            clear_halt(d, 0x81);
        else if (how < 4)
            sim_unplug(d->board);
        if (how >= 2) {
            sim_device_poll(d);
            sim_device_enumerate(d, descriptors);
        }
        assert_false(d->app.frame.streamed);
        assert_true(how % 2 || !d->app.frame.active); /* without a display nobody wants the rest */
        assert_int_equal(frame(d, now, NULL), USB_OK);
        assert_memory_equal(now, first, PICTURE);
        sim_device_destroy(d);
    }
}

/* A commit and a begin between two tiles of a frame: the frame on the display is all old or all new. */
static void frame_in_flight_keeps_its_table(void **state)
{
    static uint8_t pictures[2][PICTURE];
    struct sim_device *d = ready_device(true, true);
    size_t bytes[2];
    void *tables[2] = {fixture_table(200, &bytes[0]), fixture_table(30, &bytes[1])};
    static struct stream s;
    int seen[2] = {0, 0};
    (void)state;
    for (int i = 0; i < 2; i++) {
        push(d, 1, tables[i], bytes[i], NULL);
        frame(d, pictures[i], NULL);
    }
    assert_memory_not_equal(pictures[0], pictures[1], PICTURE);
    uint32_t frames = d->app.frames;
    for (int push_number = 0; push_number < 40; push_number++) {
        int which = push_number % 2;
        uint8_t message[USB_MAX_PAYLOAD] = {0};
        struct usb_begin begin = {1, USB_SLOT_TABLE, (uint32_t)bytes[which],
                                  crc32_update(0, tables[which], bytes[which])};
        memcpy(message + 4, tables[which], bytes[which]);
        s.bytes = 0;
        stream_add(&s, USB_MSG_BEGIN, &begin, sizeof begin);
        stream_add(&s, USB_MSG_DATA, message, (uint32_t)(4 + bytes[which]));
        stream_add(&s, USB_MSG_COMMIT, NULL, 0);
        sim_out(d->board, 1, s.data, s.bytes);
        for (uint32_t i = 0; i < 17 + random32() % 5; i++) { /* from one to several frames */
            uint8_t packet[512];
            sim_device_poll(d);
            sim_in(d->board, 0x81, packet, sizeof packet);
            if (d->app.frames != frames) {
                const uint8_t *shown = sim_picture(d->board);
                frames = d->app.frames;
                int now = memcmp(shown, pictures[0], PICTURE) == 0 ? 0 : 1;
                assert_memory_equal(shown, pictures[now], PICTURE);
                assert_int_equal(sim_tiles_shown(d->board), TILES * frames); /* each frame whole */
                seen[now]++;
            }
        }
    }
    assert_true(seen[0] > 5 && seen[1] > 5);
    for (int i = 0; i < 2; i++)
        free(tables[i]);
    sim_device_destroy(d);
}

/* Asks for the tiles' statistics, then lets the display go on with other frames before reading them. True when the tiles add
 * up to the total: all are of one frame. */
static bool statistics_add_up(struct sim_device *d, struct scene_camera next, uint32_t *covered)
{
    static uint8_t reply[16 + 88 + 600 * 40 + 64]; /* more than the controller buffers */
    struct usb_header h = {USB_PROTOCOL_MAGIC, USB_PROTOCOL_VERSION, USB_MSG_STATS, 1, 0, 4, 0};
    struct usb_stats stats;
    uint32_t request[5] = {0};
    uint8_t packet[64];
    size_t got = 0;
    request[4] = 1;
    h.detail = request_check(&h, request + 4);
    memcpy(request, &h, 16);
    sim_out(d->board, 1, request, 20);
    for (uint32_t frames = d->app.frames; d->app.frames < frames + 2;)
        sim_device_poll(d);
    d->app.content.camera = next;
    for (uint32_t frames = d->app.frames; d->app.frames < frames + 3;)
        sim_device_poll(d);
    for (size_t n = 64; n == 64; got += n) {
        sim_device_poll(d);
        int taken = sim_in(d->board, 0x81, packet, 64);
        assert_true(taken >= 0 && got + 64 <= sizeof reply);
        n = taken > 0 ? (size_t)taken : 0;
        memcpy(reply + got, packet, n);
    }
    memcpy(&stats, reply + 16, sizeof stats);
    assert_int_equal(got, 104 + stats.tile_count * 40);
    *covered = 0;
    for (uint32_t i = 0; i < stats.tile_count; i++) {
        struct usb_tile_stats t;
        memcpy(&t, reply + 104 + i * sizeof t, sizeof t);
        *covered += t.covered;
    }
    return *covered == stats.total.covered;
}

static void statistics_read_slowly_are_those_of_one_frame(void **state)
{
    struct sim_config c = {.width = 1280,
                           .height = 960,
                           .display = true,
                           .slot_count = 2,
                           .table_bank_bytes = FIXTURE_BANK,
                           .scene_bank_bytes = FIXTURE_BANK};
    struct sim_device *d = sim_device_create(&c);
    uint8_t descriptors[64];
    uint32_t covered;
    size_t bytes;
    (void)state;
    assert_non_null(d);
    sim_device_enumerate(d, descriptors);
    void *scene = fixture_scene(&bytes);
    push(d, 0, scene, bytes, NULL);
    push_table(d, 1, 1);
    while (d->app.frames < 2)
        sim_device_poll(d);
    struct scene_camera here = d->app.content.camera, away = here; /* from where nothing is to be seen */
    away.eye[0] = 100 << 16;
    assert_true(statistics_add_up(d, away, &covered));
    assert_true(covered > 0);
    for (uint32_t frames = d->app.frames; d->app.frames < frames + 2;) /* an empty frame is the last one recorded */
        sim_device_poll(d);
    d->app.content.camera = here;
    while (d->app.frame.next_tile != 300)
        sim_device_poll(d);
    assert_true(statistics_add_up(d, away, &covered)); /* asked for in mid-frame, when the frame before was empty */
    assert_true(covered > 0);
    free(scene);
    sim_device_destroy(d);
}

static void several_devices_live_side_by_side(void **state)
{
    static uint8_t a[PICTURE], b[PICTURE];
    struct sim_device *one = ready_device(false, false), *two = ready_device(true, false);
    (void)state;
    assert_int_equal(push_table(two, 1, 33), USB_OK);
    frame(one, a, NULL);
    frame(two, b, NULL);
    assert_memory_not_equal(a, b, PICTURE);
    assert_int_equal(push_table(one, 1, 33), USB_OK);
    frame(one, a, NULL);
    assert_memory_equal(a, b, PICTURE);
    sim_device_destroy(one);
    sim_device_destroy(two);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(packet_boundaries_do_not_matter),
        cmocka_unit_test(reply_of_whole_packets_ends_with_an_empty_one),
        cmocka_unit_test(push_cut_off_anywhere_keeps_the_old_table_and_can_go_on),
        cmocka_unit_test(half_a_request_is_forgotten_when_the_host_clears_the_endpoints),
        cmocka_unit_test(interrupted_frame_leaves_a_working_device),
        cmocka_unit_test(frame_in_flight_keeps_its_table),
        cmocka_unit_test(statistics_read_slowly_are_those_of_one_frame),
        cmocka_unit_test(several_devices_live_side_by_side),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
