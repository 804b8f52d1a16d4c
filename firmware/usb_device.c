#include "usb_device.h"

#include "usb_protocol.h"

/* Standard requests, descriptor types and features (USB 2.0, tables 9-4, 9-5, 9-6). */
enum {
    GET_STATUS = 0,
    CLEAR_FEATURE = 1,
    SET_FEATURE = 3,
    SET_ADDRESS = 5,
    GET_DESCRIPTOR = 6,
    GET_CONFIGURATION = 8,
    SET_CONFIGURATION = 9,
    GET_INTERFACE = 10,
    SET_INTERFACE = 11,
};
enum {
    DESCRIPTOR_DEVICE = 1,
    DESCRIPTOR_CONFIGURATION = 2,
    DESCRIPTOR_STRING = 3,
    DESCRIPTOR_QUALIFIER = 6,
    DESCRIPTOR_OTHER_SPEED = 7,
    DESCRIPTOR_BOS = 15,
    DESCRIPTOR_CAPABILITY = 16,
};
enum { TO_DEVICE = 0x00, TO_INTERFACE = 0x01, TO_ENDPOINT = 0x02, VENDOR = 0x40, FROM_DEVICE = 0x80 };
enum { FEATURE_ENDPOINT_HALT = 0, CONFIGURATION_VALUE = 1, MAX_ADDRESS = 127 };
enum { STRING_LANGUAGE = 0, STRING_MANUFACTURER = 1, STRING_PRODUCT = 2, STRING_SERIAL = 3 };

#define DEVICE_RELEASE 0x0010u /* bcdDevice 0.10 */

/* The vendor request that fetches the Microsoft OS 2.0 descriptor set; wIndex says which of its kinds. */
enum { MICROSOFT_REQUEST = 0x20, MICROSOFT_SET_INDEX = 7 };

// clang-format off
/* USB 2.01: 2.0 with a BOS; the class is told per interface. */
static const uint8_t device_descriptor[18] = {
    18, DESCRIPTOR_DEVICE, 0x01, 0x02, 0, 0, 0, USB_CONTROL_PACKET,
    USB_VENDOR_ID & 0xff, USB_VENDOR_ID >> 8, USB_PRODUCT_ID & 0xff, USB_PRODUCT_ID >> 8,
    DEVICE_RELEASE & 0xff, DEVICE_RELEASE >> 8, STRING_MANUFACTURER, STRING_PRODUCT, STRING_SERIAL, 1,
};
// clang-format on

/* Answered only where the controller knows both speeds: what the device is at the other one, the same. */
static const uint8_t qualifier_descriptor[10] = {
    10, DESCRIPTOR_QUALIFIER, 0x01, 0x02, 0, 0, 0, USB_CONTROL_PACKET, 1, 0,
};

#define CONFIGURATION_BYTES 32u
#define CONFIGURATION(type, packet)                                                                                    \
    {                                                                                                                  \
        9, type, CONFIGURATION_BYTES, 0, 1, CONFIGURATION_VALUE, 0, 0x80, 50, /* bus powered, 100 mA */                \
            9, 4, 0, 0, 2, USB_INTERFACE_CLASS, 0, 0, 0,                      /* interface 0 */                        \
            7, 5, USB_ENDPOINT_OUT, 2, (packet)&0xff, (packet) >> 8, 0,       /* bulk */                               \
            7, 5, USB_ENDPOINT_IN, 2, (packet)&0xff, (packet) >> 8, 0,                                                 \
    }

static const uint8_t full_speed_configuration[CONFIGURATION_BYTES] =
    CONFIGURATION(DESCRIPTOR_CONFIGURATION, USB_FULL_SPEED_BULK);
static const uint8_t high_speed_configuration[CONFIGURATION_BYTES] =
    CONFIGURATION(DESCRIPTOR_CONFIGURATION, USB_HIGH_SPEED_BULK);
static const uint8_t other_full_speed_configuration[CONFIGURATION_BYTES] =
    CONFIGURATION(DESCRIPTOR_OTHER_SPEED, USB_FULL_SPEED_BULK);
static const uint8_t other_high_speed_configuration[CONFIGURATION_BYTES] =
    CONFIGURATION(DESCRIPTOR_OTHER_SPEED, USB_HIGH_SPEED_BULK);

/* Microsoft OS 2.0 descriptor set (Microsoft's specification of that name, tables 10 to 15): Windows 8.1 and later bind
 * WinUSB without a driver file and give the interface a GUID that programs find it by. */
static const struct {
    uint16_t length, type, windows[2], total;
    uint16_t id_length, id_type;
    uint8_t id[16];
    uint16_t property_length, property_type, value_type, name_length, name[21], value_length, value[40];
} microsoft_set = {.length = 10,
                   .windows = {0x0000, 0x0603},
                   .total = sizeof microsoft_set,
                   .id_length = 20,
                   .id_type = 3,
                   .id = "WINUSB",
                   .property_length = 132,
                   .property_type = 4,
                   .value_type = 7, /* several strings */
                   .name_length = sizeof microsoft_set.name,
                   .name = u"DeviceInterfaceGUIDs",
                   .value_length = sizeof microsoft_set.value,
                   .value = u"{6D3B1F6E-52C4-4F0B-9E0B-5C1A7E2D9A41}"};
_Static_assert(sizeof microsoft_set == 162, "layout");

// clang-format off
/* One capability: that of the platform D8DD60DF-4589-4CC7-9CD2-659D9E648A9F, Microsoft's descriptors. */
static const uint8_t bos_descriptor[33] = {
    5, DESCRIPTOR_BOS, 33, 0, 1,
    28, DESCRIPTOR_CAPABILITY, 5, 0, 0xdf, 0x60, 0xdd, 0xd8, 0x89, 0x45, 0xc7, 0x4c, 0x9c, 0xd2, 0x65, 0x9d, 0x9e, 0x64, 0x8a, 0x9f,
    0x00, 0x00, 0x03, 0x06, sizeof microsoft_set, 0, MICROSOFT_REQUEST, 0,
};
// clang-format on

struct setup {
    uint8_t type, request;
    uint16_t value, index, length;
};

void usb_device_init(struct usb_device *d, const struct hal *hal, const char *serial)
{
    *d = (struct usb_device){.hal = hal, .serial = serial, .state = USB_STATE_DETACHED};
}

size_t usb_device_packet(const struct usb_device *d)
{
    return d->hal->usb_high_speed ? USB_HIGH_SPEED_BULK : USB_FULL_SPEED_BULK;
}

int usb_device_read(struct usb_device *d, void *data, size_t max)
{
    if (d->state != USB_STATE_CONFIGURED || d->halted_out)
        return HAL_AGAIN;
    return d->hal->usb_read(d->hal->ctx, USB_ENDPOINT_OUT, data, max);
}

int usb_device_write(struct usb_device *d, const void *data, size_t bytes)
{
    if (d->state != USB_STATE_CONFIGURED || d->halted_in)
        return HAL_AGAIN;
    return d->hal->usb_write(d->hal->ctx, USB_ENDPOINT_IN, data, bytes);
}

static void endpoint_halt(struct usb_device *d, uint8_t endpoint, bool halted)
{
    if (endpoint == USB_ENDPOINT_OUT)
        d->halted_out = halted;
    else
        d->halted_in = halted;
    d->hal->usb_stall(d->hal->ctx, endpoint, halted);
}

void usb_device_halt_out(struct usb_device *d)
{
    endpoint_halt(d, USB_ENDPOINT_OUT, true);
}

/* Both bulk endpoints start anew: open, no halt, data toggles zero; or they are stalled, as the device is not configured. */
static unsigned endpoints_start(struct usb_device *d, bool open)
{
    endpoint_halt(d, USB_ENDPOINT_OUT, !open);
    endpoint_halt(d, USB_ENDPOINT_IN, !open);
    return USB_CLEARED_OUT | USB_CLEARED_IN;
}

/* --- the data stage of control reads --- */

static bool answer(struct usb_device *d, const void *data, uint16_t bytes)
{
    d->data = data;
    d->data_bytes = bytes;
    return true;
}

static bool answer_number(struct usb_device *d, uint8_t number, uint16_t bytes)
{
    d->built[0] = number;
    d->built[1] = 0;
    return answer(d, d->built, bytes);
}

static bool answer_string(struct usb_device *d, unsigned index)
{
    static const char *const names[] = {[STRING_MANUFACTURER] = "Goniotile", [STRING_PRODUCT] = "Goniotile"};
    static const uint8_t languages[4] = {4, DESCRIPTOR_STRING, 0x09, 0x04}; /* English (United States) */
    if (index == STRING_LANGUAGE)
        return answer(d, languages, sizeof languages);
    if (index > STRING_SERIAL)
        return false;
    const char *text = index == STRING_SERIAL ? d->serial : names[index];
    uint8_t n = 2;
    for (; *text && n < sizeof d->built; text++) { /* UTF-16 of ASCII */
        d->built[n++] = (uint8_t)*text;
        d->built[n++] = 0;
    }
    d->built[0] = n;
    d->built[1] = DESCRIPTOR_STRING;
    return answer(d, d->built, n);
}

static bool answer_descriptor(struct usb_device *d, const struct setup *s)
{
    const bool high = d->hal->usb_high_speed, both = high || d->hal->usb_high_speed_capable;
    unsigned type = s->value >> 8, index = s->value & 0xff;
    if (type == DESCRIPTOR_STRING)
        return answer_string(d, index);
    if (index != 0)
        return false;
    switch (type) {
    case DESCRIPTOR_DEVICE:
        return answer(d, device_descriptor, sizeof device_descriptor);
    case DESCRIPTOR_CONFIGURATION:
        return answer(d, high ? high_speed_configuration : full_speed_configuration, CONFIGURATION_BYTES);
    case DESCRIPTOR_QUALIFIER: /* a device without high speed must refuse these two (9.6.2, 9.6.4) */
        return both && answer(d, qualifier_descriptor, sizeof qualifier_descriptor);
    case DESCRIPTOR_OTHER_SPEED:
        return both &&
               answer(d, high ? other_full_speed_configuration : other_high_speed_configuration, CONFIGURATION_BYTES);
    case DESCRIPTOR_BOS:
        return answer(d, bos_descriptor, sizeof bos_descriptor);
    default:
        return false;
    }
}

static bool is_bulk(uint16_t endpoint)
{
    return endpoint == USB_ENDPOINT_OUT || endpoint == USB_ENDPOINT_IN;
}

static bool answer_status(struct usb_device *d, const struct setup *s)
{
    bool configured = d->state == USB_STATE_CONFIGURED;
    if (s->value != 0 || s->length != 2 || d->state == USB_STATE_DEFAULT)
        return false;
    switch (s->type & 0x1f) {
    case TO_DEVICE: /* bus powered, no remote wake-up */
        return s->index == 0 && answer_number(d, 0, 2);
    case TO_INTERFACE:
        return configured && s->index == 0 && answer_number(d, 0, 2);
    case TO_ENDPOINT:
        if (s->index == 0x00 || s->index == 0x80)
            return answer_number(d, 0, 2);
        return configured && is_bulk(s->index) &&
               answer_number(d, s->index == USB_ENDPOINT_OUT ? d->halted_out : d->halted_in, 2);
    default:
        return false;
    }
}

/* Prepares the data; false: stall. */
static bool control_read(struct usb_device *d, const struct setup *s)
{
    bool configured = d->state == USB_STATE_CONFIGURED, plain = s->value == 0 && s->index == 0 && s->length == 1;
    if (s->type == (FROM_DEVICE | VENDOR | TO_DEVICE) && s->request == MICROSOFT_REQUEST)
        return s->value == 0 && s->index == MICROSOFT_SET_INDEX && answer(d, &microsoft_set, sizeof microsoft_set);
    if (s->request == GET_STATUS && !(s->type & 0x60))
        return answer_status(d, s);
    if (s->type == (FROM_DEVICE | TO_DEVICE) && s->request == GET_DESCRIPTOR)
        return answer_descriptor(d, s);
    if (s->type == (FROM_DEVICE | TO_DEVICE) && s->request == GET_CONFIGURATION)
        return plain && d->state != USB_STATE_DEFAULT && answer_number(d, configured ? CONFIGURATION_VALUE : 0, 1);
    if (s->type == (FROM_DEVICE | TO_INTERFACE) && s->request == GET_INTERFACE)
        return plain && configured && answer_number(d, 0, 1);
    return false;
}

/* --- requests without data stage --- */

static bool set_address(struct usb_device *d, const struct setup *s)
{
    if (d->state == USB_STATE_CONFIGURED || s->value > MAX_ADDRESS || s->index != 0)
        return false;
    d->new_address = (uint8_t)s->value;
    d->has_new_address = true;
    return true;
}

static bool set_configuration(struct usb_device *d, const struct setup *s, unsigned *cleared)
{
    if (d->state == USB_STATE_DEFAULT || s->value > CONFIGURATION_VALUE || s->index != 0)
        return false;
    d->state = s->value == CONFIGURATION_VALUE ? USB_STATE_CONFIGURED : USB_STATE_ADDRESS;
    *cleared |= endpoints_start(d, d->state == USB_STATE_CONFIGURED);
    return true;
}

static bool set_endpoint_halt(struct usb_device *d, const struct setup *s, unsigned *cleared)
{
    if (d->state != USB_STATE_CONFIGURED || s->value != FEATURE_ENDPOINT_HALT || !is_bulk(s->index))
        return false;
    endpoint_halt(d, (uint8_t)s->index, s->request == SET_FEATURE);
    if (s->request == CLEAR_FEATURE)
        *cleared |= s->index == USB_ENDPOINT_OUT ? USB_CLEARED_OUT : USB_CLEARED_IN;
    return true;
}

static bool control_order(struct usb_device *d, const struct setup *s, unsigned *cleared)
{
    if (s->length != 0)
        return false;
    if (s->type == TO_DEVICE && s->request == SET_ADDRESS)
        return set_address(d, s);
    if (s->type == TO_DEVICE && s->request == SET_CONFIGURATION)
        return set_configuration(d, s, cleared);
    if (s->type == TO_ENDPOINT && (s->request == SET_FEATURE || s->request == CLEAR_FEATURE))
        return set_endpoint_halt(d, s, cleared);
    if (s->type == TO_INTERFACE && s->request == SET_INTERFACE) {
        if (d->state != USB_STATE_CONFIGURED || s->value != 0 || s->index != 0)
            return false;
        *cleared |= endpoints_start(d, true);
        return true;
    }
    return false; /* remote wake-up and test modes are not supported */
}

/* --- stages --- */

static void setup_arrived(struct usb_device *d, const uint8_t p[8], unsigned *cleared)
{
    struct setup s = {p[0], p[1], (uint16_t)(p[2] | p[3] << 8), (uint16_t)(p[4] | p[5] << 8),
                      (uint16_t)(p[6] | p[7] << 8)};
    bool read = s.type & FROM_DEVICE, ok;
    d->has_new_address = false; /* an unfinished SET_ADDRESS is void */
    d->data_sent = 0;
    ok = read ? control_read(d, &s) : control_order(d, &s, cleared);
    if (read && ok) {
        d->zero_packet = d->data_bytes < s.length && d->data_bytes % USB_CONTROL_PACKET == 0;
        if (d->data_bytes > s.length)
            d->data_bytes = s.length;
    }
    d->stage = read && s.length != 0 ? USB_STAGE_DATA_IN : USB_STAGE_STATUS_IN; /* no length, no data stage (9.3.5) */
    if (!ok) {
        d->stage = USB_STAGE_IDLE;
        d->hal->usb_stall(d->hal->ctx, 0x00, true);
    }
}

static void data_in_step(struct usb_device *d)
{
    while (d->stage == USB_STAGE_DATA_IN) {
        uint16_t n = (uint16_t)(d->data_bytes - d->data_sent);
        if (n > USB_CONTROL_PACKET)
            n = USB_CONTROL_PACKET;
        if (n == 0 && !d->zero_packet) {
            d->stage = USB_STAGE_STATUS_OUT;
            return;
        }
        if (d->hal->usb_write(d->hal->ctx, 0x80, d->data + d->data_sent, n) != HAL_OK)
            return;
        d->data_sent = (uint16_t)(d->data_sent + n);
        if (n == 0)
            d->zero_packet = false;
    }
}

static void control_step(struct usb_device *d)
{
    data_in_step(d);
    if (d->stage == USB_STAGE_DATA_IN || d->stage == USB_STAGE_STATUS_OUT) {
        uint8_t packet[USB_CONTROL_PACKET]; /* the status stage; the host may end the data stage early */
        if (d->hal->usb_read(d->hal->ctx, 0x00, packet, sizeof packet) >= 0)
            d->stage = USB_STAGE_IDLE;
    }
    if (d->stage == USB_STAGE_STATUS_IN) {
        if (d->has_new_address) /* before its status packet, which may be acknowledged as soon as it is queued */
            d->hal->usb_set_address(d->hal->ctx, d->new_address);
        if (d->hal->usb_write(d->hal->ctx, 0x80, d->built, 0) != HAL_OK)
            return;
        if (d->has_new_address) /* the one request that acts after its status stage (9.4.6) */
            d->state = d->new_address ? USB_STATE_ADDRESS : USB_STATE_DEFAULT;
        d->has_new_address = false;
        d->stage = USB_STAGE_IDLE;
    }
}

unsigned usb_device_poll(struct usb_device *d)
{
    unsigned cleared = 0;
    uint8_t packet[8];
    enum hal_usb_event event = d->hal->usb_event(d->hal->ctx, packet);
    if (event == HAL_USB_RESET || event == HAL_USB_DETACH) {
        usb_device_init(d, d->hal, d->serial);
        if (event == HAL_USB_RESET)
            d->state = USB_STATE_DEFAULT;
        cleared = USB_CLEARED_OUT | USB_CLEARED_IN;
    } else if (event == HAL_USB_SETUP && d->state != USB_STATE_DETACHED) {
        setup_arrived(d, packet, &cleared);
    }
    control_step(d);
    return cleared;
}
