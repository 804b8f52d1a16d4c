#include "mailbox_usb.h"

/* What the other side wrote before this word is seen after it. */
static uint32_t word_read(const uint32_t *word)
{
    return __atomic_load_n(word, __ATOMIC_ACQUIRE);
}

static void word_write(uint32_t *word, uint32_t value)
{
    __atomic_store_n(word, value, __ATOMIC_RELEASE);
}

static struct mailbox_buffer *buffer_of(struct mailbox *m, uint8_t endpoint)
{
    return &m->buffers[(endpoint & 0x7f ? MAILBOX_BULK_OUT : MAILBOX_CONTROL_OUT) + (endpoint >> 7)];
}

static void buffer_start(struct mailbox_buffer *b, bool stalled)
{
    word_write(&b->stalled, stalled);
    if (!stalled)
        word_write(&b->taken, word_read(&b->put));
}

static enum hal_usb_event usb_event(void *ctx, uint8_t setup[8])
{
    struct mailbox *m = ctx;
    uint32_t posted = word_read(&m->posted);
    if (posted == m->handled)
        return HAL_USB_NONE;
    enum hal_usb_event event = (enum hal_usb_event)m->event;
    if (event != HAL_USB_SETUP)
        m->address = 0;
    for (int i = 0; i < (event == HAL_USB_SETUP ? MAILBOX_BULK_OUT : MAILBOX_BUFFERS); i++)
        buffer_start(&m->buffers[i], false);
    __builtin_memcpy(setup, m->setup, sizeof m->setup);
    word_write(&m->handled, posted);
    return event;
}

static int usb_read(void *ctx, uint8_t endpoint, void *data, size_t max)
{
    struct mailbox_buffer *b = buffer_of(ctx, endpoint);
    uint32_t taken = b->taken;
    if (word_read(&b->put) == taken)
        return HAL_AGAIN;
    uint32_t bytes = b->bytes[taken % MAILBOX_PACKETS];
    if (bytes > max)
        bytes = (uint32_t)max;
    __builtin_memcpy(data, b->data[taken % MAILBOX_PACKETS], bytes);
    word_write(&b->taken, taken + 1);
    return (int)bytes;
}

static int usb_write(void *ctx, uint8_t endpoint, const void *data, size_t bytes)
{
    struct mailbox_buffer *b = buffer_of(ctx, endpoint);
    uint32_t put = b->put;
    if (put - word_read(&b->taken) == MAILBOX_PACKETS || bytes > MAILBOX_PACKET_BYTES)
        return HAL_AGAIN;
    __builtin_memcpy(b->data[put % MAILBOX_PACKETS], data, bytes);
    b->bytes[put % MAILBOX_PACKETS] = (uint32_t)bytes;
    word_write(&b->put, put + 1);
    return HAL_OK;
}

static void usb_stall(void *ctx, uint8_t endpoint, bool stalled)
{
    struct mailbox_buffer *b = buffer_of(ctx, endpoint);
    buffer_start(b, stalled);
    if (endpoint == 0x00)
        buffer_start(b + 1, stalled);
}

static void usb_set_address(void *ctx, uint8_t address)
{
    struct mailbox *m = ctx;
    word_write(&m->address, address);
}

void mailbox_open(struct hal *hal, struct mailbox *m)
{
    hal->ctx = m;
    hal->usb_event = usb_event;
    hal->usb_read = usb_read;
    hal->usb_write = usb_write;
    hal->usb_stall = usb_stall;
    hal->usb_set_address = usb_set_address;
    hal->usb_high_speed = false;
    word_write(&m->ready, MAILBOX_READY);
}
