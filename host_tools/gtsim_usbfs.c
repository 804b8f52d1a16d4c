/*
 * usbfs in user space. A program's ioctls on the device's node are served here, and the firmware runs inside, as far as a transfer needs it.
 */
#include "gtsim_usbfs.h"

#include <errno.h>
#include <linux/usbdevice_fs.h>
#include <string.h>
#include <sys/ioctl.h>

#include "common.h"

#define IDLE_POLLS    16 /* firmware steps without any progress after which nothing moves */
#define IDLE_SLEEP_US 500
#define PACKET_MAX    1024

struct urb {
    UMockdevIoctlData *data;   /* the struct usbdevfs_urb, holds a reference */
    UMockdevIoctlData *buffer; /* its buffer, holds a reference; NULL when empty */
    UMockdevIoctlClient *client;
    uint32_t done; /* bytes moved */
};

static struct usbdevfs_urb *urb_fields(const struct urb *u)
{
    return (struct usbdevfs_urb *)(void *)u->data->data;
}

static void urb_free(struct urb *u)
{
    g_object_unref(u->data);
    if (u->buffer)
        g_object_unref(u->buffer);
    g_free(u);
}

static void urb_complete(struct usbfs *p, GQueue *from, struct urb *u, int status)
{
    urb_fields(u)->status = status;
    urb_fields(u)->actual_length = (int)u->done;
    if (from)
        g_queue_remove(from, u);
    g_queue_push_tail(&p->complete, u);
}

/* The first bytes of a message: a header of the firmware's protocol version. */
static bool is_header(const uint8_t *data, size_t bytes)
{
    return bytes >= sizeof(struct usb_header) && (data[0] | data[1] << 8) == USB_PROTOCOL_MAGIC &&
           data[2] == USB_PROTOCOL_VERSION;
}

/* Pulls the cable: what is under way ends with an error. */
static void unplug(struct usbfs *p)
{
    p->gone = true;
    p->faults.unplug_after = -1;
    sim_unplug(p->device->board);
    for (GQueue *q = &p->out; q; q = q == &p->out ? &p->in : NULL)
        while (!g_queue_is_empty(q))
            urb_complete(p, q, g_queue_peek_head(q), -ESHUTDOWN);
}

/* Sends packets of the first OUT transfer; true when something moved. */
static bool send_some(struct usbfs *p)
{
    struct urb *u = g_queue_peek_head(&p->out);
    if (!u)
        return false;
    size_t left = (size_t)urb_fields(u)->buffer_length - u->done;
    uint8_t *data = u->buffer ? u->buffer->data + u->done : NULL;
    if (u->done == 0 && p->protocol_version != USB_PROTOCOL_VERSION && is_header(data, left))
        data[2] = (uint8_t)~USB_PROTOCOL_VERSION; /* the firmware refuses it, as that of another version would */
    if (p->faults.damage_after >= 0 && p->out_bytes >= p->faults.damage_after && left > 100) {
        data[left / 2] ^= 1;
        p->faults.damage_after = -1;
    }
    int n = sim_out(p->device->board, USB_ENDPOINT_OUT, data, left);
    if (n == SIM_NAK)
        return false;
    if (n < 0) {
        urb_complete(p, &p->out, u, n == SIM_STALL ? -EPIPE : -ESHUTDOWN);
        return true;
    }
    u->done += (uint32_t)n;
    p->out_bytes += n;
    if ((size_t)n == left)
        urb_complete(p, &p->out, u, 0);
    if (p->faults.unplug_after >= 0 && p->out_bytes >= p->faults.unplug_after)
        unplug(p);
    if (p->faults.freeze_after >= 0 && p->out_bytes >= p->faults.freeze_after) {
        p->faults.freeze_after = -1;
        p->frozen = true;
    }
    return n > 0 || left == 0;
}

/* Fetches packets of the first IN transfer; true when something moved. */
static bool receive_some(struct usbfs *p)
{
    struct urb *u = g_queue_peek_head(&p->in);
    uint8_t packet[PACKET_MAX];
    if (!u)
        return false;
    size_t left = (size_t)urb_fields(u)->buffer_length - u->done;
    int n = sim_in(p->device->board, USB_ENDPOINT_IN, packet, left < sizeof packet ? left : sizeof packet);
    if (n == SIM_NAK)
        return false;
    if (n < 0) {
        urb_complete(p, &p->in, u, n == SIM_STALL ? -EPIPE : n == SIM_OVERFLOW ? -EOVERFLOW : -ESHUTDOWN);
        return true;
    }
    if (is_header(packet, (size_t)n))
        packet[2] = (uint8_t)p->protocol_version;
    if (n)
        umockdev_ioctl_data_update(u->buffer, u->done, packet, n);
    u->done += (uint32_t)n;
    if ((size_t)n < sim_packet(p->device->board, USB_ENDPOINT_IN) || (size_t)n == left)
        urb_complete(p, &p->in, u, 0);
    return true;
}

/* Runs the device until a transfer is complete or nothing moves any more. libusb asks again and again: from the second
 * time in vain on, wait a little. */
static void run(struct usbfs *p)
{
    for (int idle = 0; idle < IDLE_POLLS && g_queue_is_empty(&p->complete);) {
        bool moved = !p->frozen && !p->gone && send_some(p);
        moved = (!p->frozen && !p->gone && receive_some(p)) || moved;
        sim_device_poll(p->device);
        idle = moved ? 0 : idle + 1;
    }
    if (g_queue_is_empty(&p->complete) && p->waiting)
        g_usleep(IDLE_SLEEP_US);
    p->waiting = g_queue_is_empty(&p->complete);
}

/* A control transfer with the device, its data stage in `data`; a negative errno on failure, else the bytes. */
static int control(struct usbfs *p, const uint8_t setup[8], uint8_t *data)
{
    int n = sim_device_control(p->device, setup, data);
    return n >= 0 ? n : n == SIM_STALL ? -EPIPE : n == SIM_GONE ? -ESHUTDOWN : -ETIMEDOUT;
}

static int order(struct usbfs *p, uint8_t type, uint8_t request, uint16_t value, uint16_t index)
{
    uint8_t setup[8] = {type, request, (uint8_t)value, (uint8_t)(value >> 8), (uint8_t)index, (uint8_t)(index >> 8),
                        0,    0};
    return control(p, setup, NULL);
}

static int submit_control(struct usbfs *p, struct urb *u)
{
    uint32_t length = (uint32_t)urb_fields(u)->buffer_length;
    if (!u->buffer || length < 8)
        return -EINVAL;
    uint8_t *setup = u->buffer->data;
    if (length < 8u + (setup[6] | setup[7] << 8))
        return -EINVAL;
    uint8_t *data = xmalloc(length);
    memcpy(data, setup + 8, length - 8);
    int n = control(p, setup, data);
    if (n > 0 && setup[0] & 0x80)
        umockdev_ioctl_data_update(u->buffer, 8, data, n);
    free(data);
    u->done = n > 0 ? (uint32_t)n : 0;
    urb_complete(p, NULL, u, n < 0 ? n : 0);
    return 0;
}

static int submit_urb(struct usbfs *p, UMockdevIoctlClient *client, UMockdevIoctlData *arg)
{
    UMockdevIoctlData *data = umockdev_ioctl_data_resolve(arg, 0, sizeof(struct usbdevfs_urb), NULL);
    if (!data)
        return -EFAULT;
    struct urb *u = g_new0(struct urb, 1);
    u->data = data;
    u->client = client;
    struct usbdevfs_urb *fields = urb_fields(u);
    fields->status = -EINPROGRESS;
    p->waiting = false;
    if (fields->buffer_length > 0)
        u->buffer = umockdev_ioctl_data_resolve(data, G_STRUCT_OFFSET(struct usbdevfs_urb, buffer),
                                                (gsize)fields->buffer_length, NULL);
    int e = 0;
    if (fields->buffer_length > 0 && !u->buffer)
        e = -EFAULT;
    else if (fields->type == USBDEVFS_URB_TYPE_CONTROL)
        e = submit_control(p, u);
    else if (fields->type == USBDEVFS_URB_TYPE_BULK)
        g_queue_push_tail(fields->endpoint & 0x80 ? &p->in : &p->out, u);
    else
        e = -EINVAL;
    if (e)
        urb_free(u);
    return e;
}

static struct urb *complete_find(struct usbfs *p, const UMockdevIoctlClient *client)
{
    for (GList *l = p->complete.head; l; l = l->next) {
        struct urb *u = l->data;
        if (u->client == client)
            return u;
    }
    return NULL;
}

static int reap_urb(struct usbfs *p, const UMockdevIoctlClient *client, UMockdevIoctlData *arg)
{
    struct urb *u = complete_find(p, client);
    if (!u && !p->gone) {
        run(p);
        u = complete_find(p, client);
    }
    if (!u)
        return p->gone ? -ENODEV : -EAGAIN;
    UMockdevIoctlData *slot = umockdev_ioctl_data_resolve(arg, 0, sizeof(gpointer), NULL);
    if (!slot)
        return -EFAULT;
    umockdev_ioctl_data_set_ptr(slot, 0, u->data);
    g_object_unref(slot);
    g_queue_remove(&p->complete, u);
    urb_free(u);
    return 0;
}

static int discard_urb(struct usbfs *p, UMockdevIoctlData *arg)
{
    gulong address;
    memcpy(&address, arg->data, sizeof address);
    for (GQueue *q = &p->out; q; q = q == &p->out ? &p->in : NULL)
        for (GList *l = q->head; l; l = l->next) {
            struct urb *u = l->data;
            if (u->data->client_addr == address) {
                urb_complete(p, q, u, -ENOENT);
                return 0;
            }
        }
    return -EINVAL;
}

/* The first 32-bit word that the argument points to. */
static uint32_t arg_word(UMockdevIoctlData *arg)
{
    uint32_t word = 0;
    UMockdevIoctlData *d = umockdev_ioctl_data_resolve(arg, 0, sizeof word, NULL);
    if (d) {
        memcpy(&word, d->data, sizeof word);
        g_object_unref(d);
    }
    return word;
}

static int get_capabilities(UMockdevIoctlData *arg)
{
    uint32_t capabilities = USBDEVFS_CAP_ZERO_PACKET | USBDEVFS_CAP_BULK_CONTINUATION |
                            USBDEVFS_CAP_NO_PACKET_SIZE_LIM | USBDEVFS_CAP_BULK_SCATTER_GATHER |
                            USBDEVFS_CAP_REAP_AFTER_DISCONNECT;
    UMockdevIoctlData *d = umockdev_ioctl_data_resolve(arg, 0, sizeof capabilities, NULL);
    if (!d)
        return -EFAULT;
    umockdev_ioctl_data_update(d, 0, (guint8 *)&capabilities, sizeof capabilities);
    g_object_unref(d);
    return 0;
}

/* umockdev does not tell when a program closes the device or is killed. Whoever claims the interface is taken for the only
 * user: bulk transfers of an earlier one are dropped, and a frozen device thaws. */
static int claim(struct usbfs *p)
{
    GQueue *queues[] = {&p->out, &p->in, &p->complete};
    for (int i = 0; i < 3; i++)
        for (GList *l = queues[i]->head, *next; l; l = next) {
            struct urb *u = l->data;
            next = l->next;
            if (urb_fields(u)->type == USBDEVFS_URB_TYPE_BULK) {
                g_queue_delete_link(queues[i], l);
                urb_free(u);
            }
        }
    p->frozen = false;
    return 0;
}

static int reset(struct usbfs *p)
{
    uint8_t descriptors[64];
    return sim_device_enumerate(p->device, descriptors) < 0 ? -ENODEV : 0;
}

int usbfs_serve(struct usbfs *p, UMockdevIoctlClient *client, gulong request, UMockdevIoctlData *arg)
{
    switch (request) {
    case USBDEVFS_GET_CAPABILITIES:
        return get_capabilities(arg);
    case USBDEVFS_REAPURB:
    case USBDEVFS_REAPURBNDELAY:
        return reap_urb(p, client, arg);
    case USBDEVFS_DISCARDURB:
        return discard_urb(p, arg);
    default:
        break;
    }
    if (p->gone)
        return -ENODEV;
    switch (request) {
    case USBDEVFS_SUBMITURB:
        return submit_urb(p, client, arg);
    case USBDEVFS_CLAIMINTERFACE:
        return claim(p);
    case USBDEVFS_RELEASEINTERFACE:
        return 0;
    case USBDEVFS_SETINTERFACE:
        return order(p, 0x01, 11, 0, (uint16_t)arg_word(arg));
    case USBDEVFS_CLEAR_HALT:
        return order(p, 0x02, 1, 0, (uint16_t)arg_word(arg));
    case USBDEVFS_SETCONFIGURATION:
        return order(p, 0x00, 9, (uint16_t)arg_word(arg), 0);
    case USBDEVFS_RESET:
        return reset(p);
    case USBDEVFS_GETDRIVER:
        return -ENODATA;
    default:
        return -ENOTTY;
    }
}

void usbfs_init(struct usbfs *p, struct sim_device *device, unsigned protocol_version)
{
    *p = (struct usbfs){.device = device, .protocol_version = protocol_version, .faults = {-1, -1, -1}};
    g_queue_init(&p->out);
    g_queue_init(&p->in);
    g_queue_init(&p->complete);
}

bool usbfs_idle(const struct usbfs *p)
{
    return g_queue_is_empty((GQueue *)&p->out) && sim_device_idle(p->device);
}

void usbfs_drop(struct usbfs *p)
{
    claim(p);
    order(p, 0x02, 1, 0, USB_ENDPOINT_OUT);
    order(p, 0x02, 1, 0, USB_ENDPOINT_IN);
}
