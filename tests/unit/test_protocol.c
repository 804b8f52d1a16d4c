/* The protocol over the simulated bus: what every message does, and every refusal. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <unistd.h>

#include "protocol_client.h"

static unsigned set(struct sim_device *d, uint32_t setting, const void *value, size_t bytes)
{
    uint8_t message[128];
    memcpy(message, &setting, 4);
    memcpy(message + 4, value, bytes);
    return ask(d, USB_MSG_SET, message, (uint32_t)(4 + bytes), NULL);
}

/* --- messages that are served --- */

static void info_describes_the_device(void **state)
{
    struct sim_device *d = fixture_device(false, false);
    (void)state;
    struct usb_info i = info(d);
    assert_int_equal(i.protocol_version, USB_PROTOCOL_VERSION);
    assert_int_equal(i.scene_version, SCENE_VERSION);
    assert_int_equal(i.width, WIDTH);
    assert_int_equal(i.height, HEIGHT);
    assert_int_equal(i.format, RASTER_RGB888);
    assert_int_equal(i.slot_count, 3);
    assert_int_equal(i.object_count, 0);
    assert_int_equal(i.upload_slot, USB_NO_UPLOAD);
    for (int s = 0; s < 3; s++) {
        assert_int_equal(i.slots[s].kind, USB_SLOT_EMPTY);
        assert_int_equal(i.slots[s].bank_bytes, FIXTURE_CAPACITY);
    }
    sim_device_destroy(d);
    d = ready_device(true, false);
    i = info(d);
    size_t bytes;
    void *table = fixture_table(200, &bytes);
    assert_int_equal(i.slots[0].kind, USB_SLOT_SCENE);
    assert_int_equal(i.slots[1].kind, USB_SLOT_TABLE);
    assert_int_equal(i.slots[1].bytes, bytes);
    assert_int_equal(i.slots[1].crc, crc32_update(0, table, bytes));
    assert_int_equal(i.slots[2].kind, USB_SLOT_EMPTY);
    assert_int_equal(i.object_count, 1);
    assert_int_equal(i.material_count, 1);
    assert_int_equal(i.light_count, 1);
    assert_int_equal(i.triangle_count, 1);
    free(table);
    sim_device_destroy(d);
}

/* Tiles cover the picture without overlap, in row-major order, and are what the display shows. */
static void frame_streams_every_tile_once(void **state)
{
    static uint8_t pixels[PICTURE], again[PICTURE];
    (void)state;
    for (int speed = 0; speed < 2; speed++) {
        struct sim_device *d = ready_device(speed, true);
        assert_int_equal(frame(d, pixels, NULL), USB_OK);
        assert_memory_equal(pixels, sim_picture(d->board), PICTURE);
        assert_int_equal(frame(d, again, NULL), USB_OK);
        assert_memory_equal(pixels, again, PICTURE);
        sim_device_destroy(d);
        d = ready_device(speed, false); /* without a display the same */
        assert_int_equal(frame(d, again, NULL), USB_OK);
        assert_memory_equal(pixels, again, PICTURE);
        sim_device_destroy(d);
    }
    /* the triangle's middle is lit, the corners show the background */
    assert_true(pixels[3 * (20 * WIDTH + 50)] > 0);
    assert_int_equal(pixels[0], 0);
}

static void statistics_are_of_the_last_frame(void **state)
{
    struct sim_device *d = ready_device(false, false);
    struct {
        struct usb_stats s;
        struct usb_tile_stats tiles[TILES];
    } stats;
    struct usb_header h;
    static uint8_t pixels[PICTURE];
    uint32_t want = 1, covered = 0, ticks = 0, slowest = 0;
    (void)state;
    assert_true(sim_device_request(d, USB_MSG_STATS, &want, 4, &h, &stats, sizeof stats));
    assert_int_equal(h.length, sizeof stats.s); /* no frame yet */
    assert_int_equal(stats.s.frames, 0);
    frame(d, pixels, NULL);
    frame(d, pixels, NULL);
    assert_true(sim_device_request(d, USB_MSG_STATS, &want, 4, &h, &stats, sizeof stats));
    assert_int_equal(h.length, sizeof stats);
    assert_int_equal(stats.s.frames, 2);
    assert_int_equal(stats.s.tile_count, TILES);
    assert_int_equal(stats.s.ticks_are_modelled, 1);
    assert_int_equal(stats.s.meshlets_visible, 1);
    assert_true(stats.s.begin_ticks > 0);
    assert_in_range(stats.s.arena_used, 1, d->config.arena_bytes);
    for (int i = 0; i < TILES; i++) {
        covered += stats.tiles[i].covered;
        ticks += stats.tiles[i].ticks;
        slowest = stats.tiles[i].ticks > slowest ? stats.tiles[i].ticks : slowest;
    }
    assert_int_equal(stats.s.total.covered, covered);
    assert_int_equal(stats.s.total.ticks, ticks);
    assert_true(slowest > 2000);
    uint32_t lit = 0;
    for (int i = 0; i < WIDTH * HEIGHT; i++)
        lit += pixels[3 * i] != 0;
    assert_int_equal(covered, lit);
    want = 0;
    assert_true(sim_device_request(d, USB_MSG_STATS, &want, 4, &h, &stats, sizeof stats));
    assert_int_equal(h.length, sizeof stats.s);
    sim_device_destroy(d);
}

/* On a board without display a frame that its host gives up is never finished: its tiles are not passed for the last one's. */
static void tiles_of_a_frame_that_was_broken_off_are_kept_back(void **state)
{
    struct sim_device *d = ready_device(true, false);
    static uint8_t pixels[PICTURE];
    struct {
        struct usb_stats all;
        struct usb_tile_stats tiles[TILES];
    } reply;
    struct stream s = {.bytes = 0};
    struct usb_header h;
    uint32_t one = 1, model = SCENE_MATERIAL_LAFORTUNE_PHONG;
    (void)state;
    assert_int_equal(frame(d, pixels, NULL), USB_OK);
    assert_int_equal(set(d, USB_SET_MODEL, &model, sizeof model), USB_OK); /* tiles now cost otherwise */
    stream_add(&s, USB_MSG_FRAME, NULL, 0);
    sim_out(d->board, 1, s.data, s.bytes);
    while (!d->app.frame.active || d->app.frame.next_tile == 0)
        sim_device_poll(d);
    clear_halt(d, 0x01);
    clear_halt(d, 0x81);
    for (int complete = 0; complete < 2; complete++) {
        assert_true(sim_device_request(d, USB_MSG_STATS, &one, sizeof one, &h, &reply, sizeof reply));
        assert_int_equal(h.length, complete ? sizeof reply : sizeof reply.all);
        assert_int_equal(reply.all.frames, complete + 1);
        if (!complete)
            assert_int_equal(frame(d, pixels, NULL), USB_OK);
    }
    uint32_t sum = 0;
    for (uint32_t i = 0; i < TILES; i++)
        sum += reply.tiles[i].ticks;
    assert_int_equal(sum, reply.all.total.ticks);
    sim_device_destroy(d);
}

static void select_and_set_change_the_picture_and_reset_restores_it(void **state)
{
    static uint8_t first[PICTURE], now[PICTURE];
    struct sim_device *d = ready_device(false, true);
    struct scene_camera camera = d->app.content.camera;
    struct scene_output output = d->app.content.output;
    struct {
        uint32_t index;
        struct scene_light light;
    } light = {0, d->app.content.lights[0]};
    struct usb_select select = {0, 1};
    uint32_t model = SCENE_MATERIAL_LAFORTUNE_PHONG;
    (void)state;
    camera.eye[0] += 1 << 15;
    output.exposure = 1 << 15;
    light.light.irradiance[0] = 1 << 14;
    assert_int_equal(push_table(d, 2, 50), USB_OK);
    frame(d, first, NULL);
    for (int change = 0; change < 5; change++) {
        unsigned status = change == 0   ? ask(d, USB_MSG_SELECT, &select, sizeof select, NULL)
                          : change == 1 ? set(d, USB_SET_CAMERA, &camera, sizeof camera)
                          : change == 2 ? set(d, USB_SET_LIGHT, &light, sizeof light)
                          : change == 3 ? set(d, USB_SET_OUTPUT, &output, sizeof output)
                                        : set(d, USB_SET_MODEL, &model, sizeof model);
        assert_int_equal(status, USB_OK);
        assert_int_equal(frame(d, now, NULL), USB_OK);
        assert_memory_not_equal(now, first, PICTURE);
        assert_memory_equal(now, sim_picture(d->board), PICTURE);
        assert_int_equal(ask(d, USB_MSG_RESET, NULL, 0, NULL), USB_OK);
        frame(d, now, NULL);
        assert_memory_equal(now, first, PICTURE);
    }
    model = 0xffffffff;
    assert_int_equal(set(d, USB_SET_MODEL, &model, sizeof model), USB_OK);
    frame(d, now, NULL);
    assert_memory_equal(now, first, PICTURE);
    /* lights are added up to the limit */
    for (light.index = 1; light.index < APP_MAX_SET_LIGHTS; light.index++)
        assert_int_equal(set(d, USB_SET_LIGHT, &light, sizeof light), USB_OK);
    assert_int_equal(info(d).light_count, APP_MAX_SET_LIGHTS);
    assert_int_equal(set(d, USB_SET_LIGHT, &light, sizeof light), USB_ERR_VALUE);
    sim_device_destroy(d);
}

static void content_survives_a_power_cycle(void **state)
{
    static uint8_t first[PICTURE], now[PICTURE];
    struct sim_device *d = ready_device(false, false);
    uint8_t descriptors[64];
    (void)state;
    frame(d, first, NULL);
    sim_device_restart(d);
    assert_int_equal(sim_device_enumerate(d, descriptors), 50);
    assert_int_equal(frame(d, now, NULL), USB_OK);
    assert_memory_equal(now, first, PICTURE);
    sim_device_destroy(d);
}

static void flash_file_carries_the_content_over(void **state)
{
    static uint8_t first[PICTURE], now[PICTURE];
    char name[] = "/tmp/goniotile-flash-XXXXXX";
    struct sim_config c = {.width = WIDTH, .height = HEIGHT, .format = RASTER_RGB888, .slot_count = 3};
    uint8_t descriptors[64];
    size_t bytes;
    (void)state;
    int file = mkstemp(name);
    assert_true(file >= 0);
    close(file);
    assert_int_equal(unlink(name), 0);
    c.table_bank_bytes = c.scene_bank_bytes = FIXTURE_BANK;
    c.flash_file = name;
    struct sim_device *d = sim_device_create(&c);
    assert_non_null(d);
    sim_device_enumerate(d, descriptors);
    void *scene = fixture_scene(&bytes);
    push(d, 0, scene, bytes, NULL);
    push_table(d, 1, 77);
    frame(d, first, NULL);
    assert_true(sim_device_destroy(d));
    d = sim_device_create(&c);
    assert_non_null(d);
    sim_device_enumerate(d, descriptors);
    assert_int_equal(frame(d, now, NULL), USB_OK);
    assert_memory_equal(now, first, PICTURE);
    assert_true(sim_device_destroy(d));
    c.slot_count = 4; /* a file of another size is refused and left alone */
    assert_null(sim_device_create(&c));
    c.slot_count = 3;
    d = sim_device_create(&c);
    assert_non_null(d);
    assert_int_equal(d->app.store.slots[0].kind, USB_SLOT_SCENE);
    sim_device_destroy(d);
    unlink(name);
    free(scene);
}

/* --- refusals --- */

/* Sends raw bytes and takes the reply's header; true when the OUT endpoint is stalled afterwards. */
static bool ask_raw(struct sim_device *d, const struct usb_header *request, uint32_t payload, struct usb_header *reply)
{
    uint8_t packet[512], zeros[64] = {0};
    assert_int_equal(sim_out(d->board, 1, request, sizeof *request), sizeof *request);
    for (uint32_t at = 0; at < payload; at += 64) {
        int n = SIM_NAK;
        for (int i = 0; i < 10 && n == SIM_NAK; i++) {
            n = sim_out(d->board, 1, zeros, payload - at < 64 ? payload - at : 64);
            sim_device_poll(d);
        }
        if (n < 0)
            break;
    }
    int n = SIM_NAK;
    for (int i = 0; i < 10 && n == SIM_NAK; i++) {
        sim_device_poll(d);
        n = sim_in(d->board, 0x81, packet, sizeof packet);
    }
    assert_int_equal(n, sizeof *reply);
    memcpy(reply, packet, sizeof *reply);
    assert_int_equal(reply->magic, USB_PROTOCOL_MAGIC);
    assert_int_equal(reply->version, USB_PROTOCOL_VERSION);
    return sim_out(d->board, 1, NULL, 0) == SIM_STALL;
}

static void foreign_headers_are_answered_then_stalled_until_cleared(void **state)
{
    static const struct {
        struct usb_header request;
        uint16_t status;
        uint32_t detail;
        uint16_t sequence;
    } cases[] = {
        {{0x4754, USB_PROTOCOL_VERSION, USB_MSG_INFO, 7, 0, 0, 0}, USB_ERR_MAGIC, USB_PROTOCOL_MAGIC, 0},
        {{0, 0, 0, 0, 0, 0, 0}, USB_ERR_MAGIC, USB_PROTOCOL_MAGIC, 0},
        {{USB_PROTOCOL_MAGIC, USB_PROTOCOL_VERSION + 1, USB_MSG_INFO, 7, 0, 0, 0},
         USB_ERR_VERSION,
         USB_PROTOCOL_VERSION,
         7},
        {{USB_PROTOCOL_MAGIC, 0, USB_MSG_INFO, 8, 0, 0, 0}, USB_ERR_VERSION, USB_PROTOCOL_VERSION, 8},
        {{USB_PROTOCOL_MAGIC, USB_PROTOCOL_VERSION, USB_MSG_DATA, 9, 0, USB_MAX_DRAIN + 1, 0},
         USB_ERR_LENGTH,
         USB_MAX_PAYLOAD,
         9},
        {{USB_PROTOCOL_MAGIC, USB_PROTOCOL_VERSION, USB_MSG_DATA, 9, 0, 0xffffffff, 0},
         USB_ERR_LENGTH,
         USB_MAX_PAYLOAD,
         9},
    };
    struct sim_device *d = fixture_device(false, false);
    struct usb_header reply;
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        assert_true(ask_raw(d, &cases[i].request, 0, &reply));
        assert_int_equal(reply.status, cases[i].status);
        assert_int_equal(reply.detail, cases[i].detail);
        assert_int_equal(reply.sequence, cases[i].sequence);
        clear_halt(d, 0x01);
        assert_int_equal(info(d).slot_count, 3); /* and all is well again */
    }
    /* the reply may be fetched after the halt has been cleared, too */
    sim_out(d->board, 1, &cases[0].request, sizeof cases[0].request);
    sim_device_poll(d);
    clear_halt(d, 0x01);
    assert_int_equal(sim_in(d->board, 0x81, &reply, sizeof reply), 16);
    assert_int_equal(reply.status, USB_ERR_MAGIC);
    sim_device_destroy(d);
}

/* Nine replies are more than the controller's 64 packets: the refusal waits for the last one when the endpoint is cleared. */
static void clearing_the_in_endpoint_drops_a_refusal_that_waits(void **state)
{
    (void)state;
    struct sim_device *d = fixture_device(false, false);
    struct stream s = {.bytes = 0};
    uint8_t packet[64];
    for (int i = 0; i < 9; i++)
        stream_add(&s, USB_MSG_INFO, NULL, 0);
    memset(s.data + s.bytes, 0, sizeof(struct usb_header)); /* no header */
    s.bytes += sizeof(struct usb_header);
    assert_int_equal(sim_out(d->board, 1, s.data, s.bytes), s.bytes);
    for (int i = 0; i < 20; i++)
        sim_device_poll(d);
    assert_int_equal(sim_out(d->board, 1, NULL, 0), 0); /* not yet refused */
    clear_halt(d, 0x81);
    for (int i = 0; i < 20; i++)
        sim_device_poll(d);
    assert_int_equal(sim_in(d->board, 0x81, packet, sizeof packet), SIM_NAK);
    assert_int_equal(sim_out(d->board, 1, NULL, 0), SIM_STALL); /* where the next one begins is unknown as ever */
    clear_halt(d, 0x01);
    assert_int_equal(info(d).slot_count, 3);
    sim_device_destroy(d);
}

static void wrong_lengths_are_drained_and_refused(void **state)
{
    static const struct {
        uint8_t type;
        uint32_t length, detail;
    } cases[] = {
        {USB_MSG_INFO, 1, 0},    {USB_MSG_BEGIN, 0, 16},     {USB_MSG_BEGIN, 15, 16},    {USB_MSG_BEGIN, 17, 16},
        {USB_MSG_DATA, 0, 4100}, {USB_MSG_DATA, 4, 4100},    {USB_MSG_DATA, 4101, 4100}, {USB_MSG_DATA, 65536, 4100},
        {USB_MSG_COMMIT, 64, 0}, {USB_MSG_ABORT, 4, 0},      {USB_MSG_SELECT, 3, 4},     {USB_MSG_SELECT, 5, 4},
        {USB_MSG_SET, 3, 4100},  {USB_MSG_FRAME, 1, 0},      {USB_MSG_STATS, 0, 4},      {USB_MSG_STATS, 8, 4},
        {USB_MSG_RESET, 100, 0}, {USB_MSG_INFO, 5000, 4100},
    };
    struct sim_device *d = fixture_device(false, false);
    (void)state;
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        static const uint8_t zeros[USB_MAX_PAYLOAD];
        struct usb_header
            request = {USB_PROTOCOL_MAGIC, USB_PROTOCOL_VERSION, cases[i].type, (uint16_t)i, 0, cases[i].length, 0},
            reply;
        if (cases[i].length <= sizeof zeros) /* ask_raw's payload */
            request.detail = request_check(&request, zeros);
        assert_false(ask_raw(d, &request, cases[i].length, &reply));
        assert_int_equal(reply.status, USB_ERR_LENGTH);
        assert_int_equal(reply.detail, cases[i].detail);
        assert_int_equal(reply.sequence, i);
        assert_int_equal(info(d).slot_count, 3);
    }
    sim_device_destroy(d);
}

static void unknown_messages_are_refused(void **state)
{
    struct sim_device *d = fixture_device(false, false);
    (void)state;
    assert_int_equal(ask(d, 0, NULL, 0, NULL), USB_ERR_TYPE);
    assert_int_equal(ask(d, USB_MSG_VERIFY + 1, "abc", 3, NULL), USB_ERR_TYPE);
    assert_int_equal(ask(d, 0x7f, NULL, 0, NULL), USB_ERR_TYPE);
    sim_device_destroy(d);
}

static void uploads_out_of_order_are_refused(void **state)
{
    struct sim_device *d = ready_device(false, false);
    uint8_t data[4 + 8] = {0};
    struct usb_begin begin = {1, USB_SLOT_TABLE, 8, 0};
    uint32_t detail;
    (void)state;
    assert_int_equal(ask(d, USB_MSG_DATA, data, 12, NULL), USB_ERR_STATE);
    assert_int_equal(ask(d, USB_MSG_COMMIT, NULL, 0, NULL), USB_ERR_STATE);
    assert_int_equal(ask(d, USB_MSG_BEGIN, &begin, sizeof begin, NULL), USB_OK);
    assert_int_equal(ask(d, USB_MSG_COMMIT, NULL, 0, &detail), USB_ERR_INCOMPLETE);
    assert_int_equal(detail, 0);
    assert_int_equal(ask(d, USB_MSG_DATA, data, 4 + 5, &detail), USB_OK);
    assert_int_equal(detail, 5);
    assert_int_equal(ask(d, USB_MSG_DATA, data, 4 + 3, &detail), USB_ERR_OFFSET);
    assert_int_equal(detail, 5);
    data[0] = 5;
    assert_int_equal(ask(d, USB_MSG_DATA, data, 4 + 4, &detail), USB_ERR_LENGTH);
    assert_int_equal(detail, 4 + 3);
    assert_int_equal(ask(d, USB_MSG_COMMIT, NULL, 0, &detail), USB_ERR_INCOMPLETE);
    assert_int_equal(detail, 5);
    struct usb_info i = info(d);
    assert_int_equal(i.upload_slot, 1);
    assert_int_equal(i.upload_length, 8);
    assert_int_equal(i.upload_received, 5);
    assert_int_equal(ask(d, USB_MSG_ABORT, NULL, 0, NULL), USB_OK);
    assert_int_equal(info(d).upload_slot, USB_NO_UPLOAD);
    assert_int_equal(ask(d, USB_MSG_COMMIT, NULL, 0, NULL), USB_ERR_STATE);
    assert_int_equal(ask(d, USB_MSG_ABORT, NULL, 0, NULL), USB_OK);
    sim_device_destroy(d);
}

static void unfit_uploads_are_refused_and_the_old_table_stays(void **state)
{
    static uint8_t first[PICTURE], now[PICTURE];
    struct sim_device *d = ready_device(false, true);
    size_t bytes;
    uint8_t *table = fixture_table(13, &bytes);
    struct usb_begin begin = {3, USB_SLOT_TABLE, (uint32_t)bytes, 0};
    uint32_t detail;
    (void)state;
    frame(d, first, NULL);
    assert_int_equal(ask(d, USB_MSG_BEGIN, &begin, sizeof begin, NULL), USB_ERR_SLOT);
    begin.slot = 0;
    assert_int_equal(ask(d, USB_MSG_BEGIN, &begin, sizeof begin, NULL), USB_ERR_VALUE);
    begin = (struct usb_begin){1, USB_SLOT_TABLE, FIXTURE_CAPACITY + 1, 0};
    assert_int_equal(ask(d, USB_MSG_BEGIN, &begin, sizeof begin, &detail), USB_ERR_TOO_LARGE);
    assert_int_equal(detail, FIXTURE_CAPACITY);
    assert_int_equal(push(d, 1, table, bytes - 4, &detail), USB_ERR_CONTENT); /* truncated */
    assert_int_equal(detail, LUT_ERR_TRUNCATED);
    assert_int_equal(push(d, 0, table, bytes, &detail), USB_ERR_CONTENT);
    assert_int_equal(detail, SCENE_ERR_MAGIC);
    begin = (struct usb_begin){1, USB_SLOT_TABLE, 5, 0x12345678};
    assert_int_equal(ask(d, USB_MSG_BEGIN, &begin, sizeof begin, NULL), USB_OK);
    assert_int_equal(ask(d, USB_MSG_DATA, "\0\0\0\0hello", 9, NULL), USB_OK);
    assert_int_equal(ask(d, USB_MSG_COMMIT, NULL, 0, &detail), USB_ERR_CRC);
    assert_int_equal(detail, crc32_update(0, "hello", 5));
    assert_int_equal(ask(d, USB_MSG_COMMIT, NULL, 0, NULL), USB_ERR_STATE); /* dropped */
    sim_forbid_writing(d->board, true);
    assert_int_equal(push(d, 1, table, bytes, NULL), USB_ERR_FORBIDDEN);
    sim_forbid_writing(d->board, false);
    sim_fail_flash_after(d->board, 2);
    assert_int_equal(push(d, 1, table, bytes, NULL), USB_ERR_FLASH);
    sim_fail_flash_after(d->board, -1);
    assert_int_equal(frame(d, now, NULL), USB_OK);
    assert_memory_equal(now, first, PICTURE);
    assert_int_equal(push(d, 1, table, bytes, NULL), USB_OK);
    frame(d, now, NULL);
    assert_memory_not_equal(now, first, PICTURE);
    free(table);
    sim_device_destroy(d);
}

static void frames_that_cannot_be_are_refused_with_the_reason(void **state)
{
    static uint8_t pixels[PICTURE];
    struct sim_device *d = fixture_device(false, true);
    size_t bytes;
    void *scene = fixture_scene(&bytes);
    struct usb_select select = {0, 1};
    uint32_t detail;
    (void)state;
    assert_int_equal(frame(d, pixels, NULL), USB_ERR_STATE);
    assert_int_equal(push(d, 0, scene, bytes, NULL), USB_OK);
    assert_int_equal(frame(d, pixels, &detail), USB_ERR_TABLE);
    assert_int_equal(detail, 0);
    push_table(d, 1, 9);
    assert_int_equal(frame(d, pixels, NULL), USB_OK);
    assert_int_equal(ask(d, USB_MSG_SELECT, &select, sizeof select, NULL), USB_OK);
    assert_int_equal(frame(d, pixels, NULL), USB_ERR_TABLE);
    push_table(d, 2, 9);
    assert_int_equal(frame(d, pixels, NULL), USB_OK);
    d->app.config.arena_bytes = 8;
    assert_int_equal(frame(d, pixels, &detail), USB_ERR_MEMORY);
    assert_in_range(detail, 9, d->config.arena_bytes);
    assert_int_equal(ask(d, USB_MSG_RESET, NULL, 0, NULL), USB_OK); /* the copy of what was set is given up */
    assert_int_equal(ask(d, USB_MSG_SELECT, &select, sizeof select, &detail), USB_ERR_MEMORY);
    assert_int_equal(detail, sizeof(struct scene_material) + APP_MAX_SET_LIGHTS * sizeof(struct scene_light));
    d->app.config.arena_bytes = d->config.arena_bytes;
    assert_int_equal(frame(d, pixels, NULL), USB_OK);
    free(scene);
    sim_device_destroy(d);
}

static void firmware_refuses_what_it_has_no_part_for(void **state)
{
    static uint8_t pixels[PICTURE];
    static const struct raster_parts none, specular = {.specular_frame = &raster_specular_frame_model};
    struct sim_device *d = fixture_device(false, false);
    size_t bytes;
    void *scene = fixture_scene(&bytes);
    struct {
        uint32_t setting, index;
        struct scene_light light;
    } set = {USB_SET_LIGHT, 1, {.kind = SCENE_LIGHT_POINT, .radius = 1 << 16}};
    uint32_t detail = 7;
    (void)state;
    assert_int_equal(push(d, 0, scene, bytes, NULL), USB_OK);
    push_table(d, 1, 9);
    d->app.config.parts = &none;
    assert_int_equal(frame(d, pixels, &detail), USB_ERR_MODEL);
    assert_int_equal(detail, 0);
    d->app.config.parts = &specular;
    assert_int_equal(frame(d, pixels, NULL), USB_OK);
    assert_int_equal(ask(d, USB_MSG_SET, &set, sizeof set, NULL), USB_OK);
    assert_int_equal(frame(d, pixels, &detail), USB_ERR_RENDER);
    assert_int_equal(detail, RASTER_ERR_POINT);
    assert_int_equal(ask(d, USB_MSG_RESET, NULL, 0, NULL), USB_OK);
    assert_int_equal(frame(d, pixels, NULL), USB_OK);
    free(scene);
    sim_device_destroy(d);
}

/* Nine objects over all of 8192 tiles are more bin entries than the rasterizer can number. */
static void unrenderable_scene_is_refused_with_the_rasterizers_reason(void **state)
{
    static const int16_t vertices[3][3] = {{-8000, -8000, 0}, {8000, -8000, 0}, {0, 8000, 0}};
    static const uint16_t triangles[1][3] = {{0, 1, 2}};
    struct sim_config c = {.width = 4096,
                           .height = 4096,
                           .slot_count = 2,
                           .table_bank_bytes = FIXTURE_BANK,
                           .scene_bank_bytes = FIXTURE_BANK};
    struct sim_device *d = sim_device_create(&c);
    uint8_t descriptors[64];
    struct ref_blob b;
    struct usb_header h;
    size_t bytes;
    (void)state;
    assert_non_null(d);
    assert_true(sim_device_enumerate(d, descriptors) > 0);
    ref_blob_init(&b);
    unsigned material = ref_blob_material(&b, SCENE_MATERIAL_LAFORTUNE_PHONG, 0, 0.5, "grey");
    unsigned mesh = ref_blob_mesh(&b, vertices, triangles, 1);
    for (int i = 0; i < 9; i++)
        ref_blob_object(&b, mesh, material, (const double[3]){0, 0, -0.5}, 1 / 8192.0);
    void *scene = ref_blob_finish(&b, &bytes);
    assert_int_equal(push(d, 0, scene, bytes, NULL), USB_OK);
    assert_true(sim_device_frame(d, NULL, &h));
    assert_int_equal(h.status, USB_ERR_RENDER);
    assert_int_equal(h.detail, RASTER_ERR_LIMIT);
    ref_blob_free(&b);
    free(scene);
    sim_device_destroy(d);
}

static void values_out_of_range_are_refused(void **state)
{
    static uint8_t first[PICTURE], now[PICTURE];
    struct sim_device *d = fixture_device(false, false);
    struct usb_select select = {0, 0};
    uint32_t number = 0, zeros[16] = {0};
    (void)state;
    assert_int_equal(ask(d, USB_MSG_SELECT, &select, sizeof select, NULL), USB_ERR_STATE);
    assert_int_equal(set(d, USB_SET_MODEL, &number, 4), USB_ERR_STATE);
    sim_device_destroy(d);
    d = ready_device(false, false);
    frame(d, first, NULL);
    select.material = 1;
    assert_int_equal(ask(d, USB_MSG_SELECT, &select, sizeof select, NULL), USB_ERR_VALUE);
    select = (struct usb_select){0, 2};
    assert_int_equal(ask(d, USB_MSG_SELECT, &select, sizeof select, NULL), USB_ERR_VALUE);
    assert_int_equal(set(d, 0, zeros, 4), USB_ERR_VALUE);
    assert_int_equal(set(d, USB_SET_BUDGET + 1, zeros, 4), USB_ERR_VALUE);
    assert_int_equal(set(d, USB_SET_CAMERA, zeros, sizeof(struct scene_camera)), USB_ERR_VALUE);
    assert_int_equal(set(d, USB_SET_CAMERA, zeros, sizeof(struct scene_camera) - 4), USB_ERR_LENGTH);
    assert_int_equal(set(d, USB_SET_LIGHT, zeros, 4 + sizeof(struct scene_light)), USB_ERR_VALUE);
    uint32_t beyond[1 + sizeof(struct scene_light) / 4];
    memcpy(beyond + 1, &d->app.content.lights[0], sizeof(struct scene_light));
    beyond[0] = 2; /* one is there: 1 would be the next */
    assert_int_equal(set(d, USB_SET_LIGHT, beyond, sizeof beyond), USB_ERR_VALUE);
    memset(zeros, 0xff, sizeof zeros);
    assert_int_equal(set(d, USB_SET_OUTPUT, zeros, sizeof(struct scene_output)), USB_ERR_VALUE);
    number = SCENE_MATERIAL_KIND_COUNT;
    assert_int_equal(set(d, USB_SET_MODEL, &number, 4), USB_ERR_VALUE);
    assert_int_equal(ask(d, USB_MSG_STATS, &number, 4, NULL), USB_ERR_VALUE);
    assert_int_equal(frame(d, now, NULL), USB_OK);
    assert_memory_equal(now, first, PICTURE);
    sim_device_destroy(d);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(info_describes_the_device),
        cmocka_unit_test(frame_streams_every_tile_once),
        cmocka_unit_test(statistics_are_of_the_last_frame),
        cmocka_unit_test(tiles_of_a_frame_that_was_broken_off_are_kept_back),
        cmocka_unit_test(select_and_set_change_the_picture_and_reset_restores_it),
        cmocka_unit_test(content_survives_a_power_cycle),
        cmocka_unit_test(flash_file_carries_the_content_over),
        cmocka_unit_test(foreign_headers_are_answered_then_stalled_until_cleared),
        cmocka_unit_test(clearing_the_in_endpoint_drops_a_refusal_that_waits),
        cmocka_unit_test(wrong_lengths_are_drained_and_refused),
        cmocka_unit_test(unknown_messages_are_refused),
        cmocka_unit_test(uploads_out_of_order_are_refused),
        cmocka_unit_test(unfit_uploads_are_refused_and_the_old_table_stays),
        cmocka_unit_test(frames_that_cannot_be_are_refused_with_the_reason),
        cmocka_unit_test(firmware_refuses_what_it_has_no_part_for),
        cmocka_unit_test(unrenderable_scene_is_refused_with_the_rasterizers_reason),
        cmocka_unit_test(values_out_of_range_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
