/*
 * The protocol and everything behind it: a stream of packets, whole requests with a right check, and interruptions, into the firmware on
 * a simulated board with little flash. Whatever came, a host that resets the bus is answered.
 *
 * Input: a byte of options (1: high speed, 2: display, 4: write-protected), then operations of one byte (low three bits: which) and
 * their arguments.
 */
#include "fuzz.h"
#include "sim_device.h"

enum { WIDTH = 16, HEIGHT = 16, BANK = 2 * SIM_FLASH_BLOCK, POLLS = 100 };

/* Takes what the device has to say; true when there was something. */
static bool drain(struct sim_device *d)
{
    uint8_t packet[512];
    int n = sim_in(d->board, USB_ENDPOINT_IN, packet, sizeof packet);
    CLAIM(n <= (int)sim_packet(d->board, USB_ENDPOINT_IN));
    return n >= 0;
}

static void send(struct sim_device *d, const void *data, size_t bytes, bool listen)
{
    size_t sent = 0;
    for (int i = 0; i < POLLS && sent < bytes; i++) {
        int n = sim_out(d->board, USB_ENDPOINT_OUT, (const uint8_t *)data + sent, bytes - sent);
        if (n < 0 && n != SIM_NAK)
            return;
        sent += n > 0 ? (size_t)n : 0;
        sim_device_poll(d);
        while (listen && drain(d))
            sim_device_poll(d);
    }
}

static void request(struct sim_device *d, uint8_t type, const void *payload, size_t bytes, bool listen)
{
    struct {
        struct usb_header h;
        uint8_t payload[USB_MAX_PAYLOAD];
    } m = {.h = {USB_PROTOCOL_MAGIC, USB_PROTOCOL_VERSION, type, 0, 0, (uint32_t)bytes, 0}};
    if (bytes)
        memcpy(m.payload, payload, bytes);
    sim_device_check(d, &m.h, m.payload);
    send(d, &m, sizeof m.h + bytes, listen);
}

/* A whole push of what the input says next. */
static void push(struct sim_device *d, struct input *in, bool listen)
{
    uint8_t slot = input_byte(in), message[USB_MAX_PAYLOAD] = {0};
    const uint8_t *content;
    size_t n = input_byte(in);
    n |= (size_t)input_byte(in) << 8;
    n = input_bytes(&content, in, n < USB_MAX_DATA ? n : USB_MAX_DATA);
    struct usb_header h = {.type = USB_MSG_DATA, .length = (uint32_t)(sizeof(struct usb_data) + n)};
    if (n)
        memcpy(message + sizeof(struct usb_data), content, n);
    sim_device_check(d, &h, message); /* the check of DATA is the content's CRC */
    struct usb_begin begin = {slot & 3, slot & 3 ? USB_SLOT_TABLE : USB_SLOT_SCENE, (uint32_t)n, h.detail};
    request(d, USB_MSG_BEGIN, &begin, sizeof begin, listen);
    request(d, USB_MSG_DATA, message, h.length, listen);
    if (!(slot & 0x80))
        request(d, USB_MSG_COMMIT, NULL, 0, listen);
}

static void operate(struct sim_device *d, struct input *in)
{
    uint8_t setup[8] = {0}, descriptors[64], op = input_byte(in), type;
    bool listen = !(op & 0x08);
    const uint8_t *bytes;
    size_t n;
    switch (op & 7) {
    case 0: /* bytes as they are */
        n = input_bytes(&bytes, in, input_byte(in));
        send(d, bytes, n, listen);
        break;
    case 1: /* a request with a right header and check */
        type = input_byte(in);
        n = input_bytes(&bytes, in, input_byte(in));
        request(d, type, bytes, n, listen);
        break;
    case 2:
        push(d, in, listen);
        break;
    case 3:
        for (int i = 0; i < op >> 3; i++)
            sim_device_poll(d);
        break;
    case 4:
        for (int i = 0; i < op >> 4; i++)
            drain(d);
        break;
    case 5:
        n = input_bytes(&bytes, in, sizeof setup);
        memcpy(setup, bytes, n);
        sim_setup(d->board, setup);
        sim_device_poll(d);
        break;
    case 6: /* clears both halts */
        setup[0] = 0x02;
        setup[1] = 1;
        for (int i = 0; i < 2; i++) {
            setup[4] = i ? USB_ENDPOINT_IN : USB_ENDPOINT_OUT;
            CLAIM(sim_device_control(d, setup, NULL) != SIM_NAK);
        }
        break;
    default:
        if (op & 0x10)
            sim_device_restart(d);
        else if (op & 0x20)
            sim_unplug(d->board);
        else
            sim_fail_flash_after(d->board, op >> 6);
        CLAIM(sim_device_enumerate(d, descriptors) == 18 + 32);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t bytes)
{
    struct input in = {data, bytes};
    uint8_t options = input_byte(&in), descriptors[64];
    struct sim_config c = {.width = WIDTH,
                           .height = HEIGHT,
                           .format = RASTER_RGB888,
                           .high_speed = options & 1,
                           .display = options & 2,
                           .write_forbidden = options & 4,
                           .slot_count = 3,
                           .table_bank_bytes = BANK,
                           .scene_bank_bytes = BANK,
                           .arena_bytes = 8192};
    struct sim_device *d = sim_device_create(&c);
    struct usb_header h;
    struct usb_info info;
    CLAIM(d && sim_device_enumerate(d, descriptors) == 18 + 32);
    while (in.left)
        operate(d, &in);
    CLAIM(sim_device_enumerate(d, descriptors) == 18 + 32);
    CLAIM(sim_device_request(d, USB_MSG_INFO, NULL, 0, &h, &info, sizeof info) && h.status == USB_OK);
    sim_device_destroy(d);
    return 0;
}
