/* A host's side of the protocol for tests: requests to a simulated device that fail the test when they are not answered. */
#ifndef TESTS_UNIT_PROTOCOL_CLIENT_H
#define TESTS_UNIT_PROTOCOL_CLIENT_H

#include "crc32.h"
#include "device_fixture.h"

enum { WIDTH = 100, HEIGHT = 40, PICTURE = 3 * WIDTH * HEIGHT, TILES = 4 };

/* A request whose reply has no payload: its status; *detail may be NULL. */
static inline unsigned ask(struct sim_device *d, uint8_t type, const void *payload, uint32_t bytes, uint32_t *detail)
{
    struct usb_header h;
    assert_true(sim_device_request(d, type, payload, bytes, &h, NULL, 0));
    assert_int_equal(h.type, type | USB_REPLY);
    assert_int_equal(h.length, 0);
    if (detail)
        *detail = h.detail;
    return h.status;
}

static inline struct usb_info info(struct sim_device *d)
{
    struct usb_header h;
    struct usb_info i;
    assert_true(sim_device_request(d, USB_MSG_INFO, NULL, 0, &h, &i, sizeof i));
    assert_int_equal(h.status, USB_OK);
    assert_int_equal(h.length, sizeof i);
    return i;
}

static inline unsigned push(struct sim_device *d, uint32_t slot, const void *data, size_t bytes, uint32_t *detail)
{
    struct usb_header h;
    assert_true(sim_device_push(d, slot, slot ? USB_SLOT_TABLE : USB_SLOT_SCENE, data, (uint32_t)bytes, &h));
    if (detail)
        *detail = h.detail;
    return h.status;
}

static inline unsigned push_table(struct sim_device *d, uint32_t slot, uint32_t mantissa)
{
    size_t bytes;
    void *table = fixture_table(mantissa, &bytes);
    unsigned status = push(d, slot, table, bytes, NULL);
    free(table);
    return status;
}

/* A device that can render: scene, and a table in slot 1. */
static inline struct sim_device *ready_device(bool high_speed, bool display)
{
    struct sim_device *d = fixture_device(high_speed, display);
    size_t bytes;
    void *scene = fixture_scene(&bytes);
    assert_int_equal(push(d, 0, scene, bytes, NULL), USB_OK);
    assert_int_equal(push_table(d, 1, 200), USB_OK);
    free(scene);
    return d;
}

static inline unsigned frame(struct sim_device *d, uint8_t *pixels, uint32_t *detail)
{
    struct usb_header h;
    memset(pixels, 0xee, PICTURE);
    assert_true(sim_device_frame(d, pixels, &h));
    if (detail)
        *detail = h.detail;
    return h.status;
}

static inline void clear_halt(struct sim_device *d, uint8_t endpoint)
{
    const uint8_t request[8] = {0x02, 1, 0, 0, endpoint};
    assert_int_equal(sim_device_control(d, request, NULL), 0);
}

/* Requests one behind the other, as bytes for the OUT endpoint. */
struct stream {
    uint8_t data[40000];
    size_t bytes;
    uint32_t content_crc; /* of the DATA so far */
};

/* The check of a request that is not DATA. */
static inline uint32_t request_check(const struct usb_header *h, const void *payload)
{
    return crc32_update(crc32_update(0, h, 12), payload, h->length);
}

static inline void stream_add(struct stream *s, uint8_t type, const void *payload, uint32_t bytes)
{
    struct usb_header h = {USB_PROTOCOL_MAGIC, USB_PROTOCOL_VERSION, type, (uint16_t)s->bytes, 0, bytes, 0};
    uint32_t offset = 1;
    assert_true(s->bytes + sizeof h + bytes <= sizeof s->data);
    h.detail = request_check(&h, payload);
    if (type == USB_MSG_DATA && bytes > 4) {
        memcpy(&offset, payload, 4);
        s->content_crc = crc32_update(offset ? s->content_crc : 0, (const uint8_t *)payload + 4, bytes - 4);
        h.detail = s->content_crc;
    }
    memcpy(s->data + s->bytes, &h, sizeof h);
    if (bytes)
        memcpy(s->data + s->bytes + sizeof h, payload, bytes);
    s->bytes += sizeof h + bytes;
}

#endif
