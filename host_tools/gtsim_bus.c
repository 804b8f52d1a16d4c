/*
 * usbfs in user space. The child's ioctls on a device node arrive as signals, on a thread of umockdev; the firmware runs inside their
 * handlers, as far as a transfer needs it.
 */
#define _GNU_SOURCE
#include "gtsim_bus.h"

#include <errno.h>
#include <glib-unix.h>
#include <linux/usbdevice_fs.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <umockdev.h>

#include "common.h"

#define IDLE_POLLS    16 /* firmware steps without any progress after which nothing moves */
#define IDLE_SLEEP_US 500
#define REPLUG_MS     300 /* an unplugged device comes back after */
#define PACKET_MAX    1024
#define STEP_MS       10      /* between two steps of the host in this process */
#define SILENCE_US    1000000 /* a program with a request under way that no longer asks for the reply has died */

struct urb {
    UMockdevIoctlData *data;   /* the struct usbdevfs_urb, holds a reference */
    UMockdevIoctlData *buffer; /* its buffer, holds a reference; NULL when empty */
    UMockdevIoctlClient *client;
    uint32_t done; /* bytes moved */
};

struct port {
    struct bus *bus;
    int number; /* 1.. */
    struct sim_device *device;
    UMockdevIoctlBase *handler;
    GQueue out, in, complete; /* of struct urb */
    bool gone, frozen;
    bool waiting; /* the last REAPURB found nothing */
    bool used;    /* by a program since the last step of the host in this process */
    gint64 asked; /* when a program did so last, g_get_monotonic_time */
    long long out_bytes, unplug_after, freeze_after, damage_after;
    uint8_t descriptors[64];
    int descriptor_bytes;
};

struct bus {
    const struct bus_options *options;
    UMockdevTestbed *testbed;
    GMutex lock; /* of everything in `ports`: ioctls come on another thread than timeouts */
    struct port ports[BUS_MAX_DEVICES];
    GMainLoop *loop;
    const struct bus_host *host; /* in this process, or NULL */
    GPid child;                  /* 0: none */
    bool stepping, closed;       /* in a step of the host; it asked to end */
    int exit_code;
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

static void urb_complete(struct port *p, GQueue *from, struct urb *u, int status)
{
    urb_fields(u)->status = status;
    urb_fields(u)->actual_length = (int)u->done;
    if (from)
        g_queue_remove(from, u);
    g_queue_push_tail(&p->complete, u);
}

/* --- plugging --- */

static char *device_path(const struct port *p)
{
    return xasprintf("/sys/devices/usb1/1-%d", p->number);
}

static char *device_node(const struct port *p)
{
    return xasprintf("/dev/bus/usb/001/%03d", p->number + 1);
}

static gboolean on_ioctl(UMockdevIoctlBase *handler, UMockdevIoctlClient *client, gpointer port);

static void testbed_add(struct bus *b, const char *description)
{
    GError *e = NULL;
    if (!umockdev_testbed_add_from_string(b->testbed, description, &e))
        die(EXIT_INTERNAL, "umockdev: %s", e->message);
}

static char *hex(const uint8_t *bytes, int count)
{
    char *text = xmalloc(2 * (size_t)count + 1);
    text[0] = 0;
    for (int i = 0; i < count; i++)
        snprintf(text + 2 * i, 3, "%02x", bytes[i]);
    return text;
}

/* Plugs the device in: the firmware is enumerated, then the node appears. */
static void port_plug(struct port *p)
{
    GError *e = NULL;
    g_mutex_lock(&p->bus->lock);
    p->descriptor_bytes = sim_device_enumerate(p->device, p->descriptors);
    g_mutex_unlock(&p->bus->lock);
    if (p->descriptor_bytes < 0)
        die(EXIT_INTERNAL, "device %d: enumeration failed (%d)", p->number, p->descriptor_bytes);
    char *node = device_node(p), *descriptors = hex(p->descriptors, p->descriptor_bytes);
    char *text = xasprintf("P: /devices/usb1/1-%d\nN: %s\nE: SUBSYSTEM=usb\nE: DRIVER=usb\nE: DEVTYPE=usb_device\n"
                           "E: BUSNUM=001\nE: DEVNUM=%03d\nE: DEVNAME=%s\nA: bConfigurationValue=1\\n\nA: busnum=1\\n\n"
                           "A: devnum=%d\\n\nA: speed=%s\\n\nH: descriptors=%s\n",
                           p->number, node + strlen("/dev/"), p->number + 1, node, p->number + 1,
                           p->bus->options->board.high_speed ? "480" : "12", descriptors);
    testbed_add(p->bus, text);
    if (!p->handler) {
        p->handler = umockdev_ioctl_base_new();
        g_signal_connect(p->handler, "handle-ioctl", G_CALLBACK(on_ioctl), p);
    }
    if (!umockdev_testbed_attach_ioctl(p->bus->testbed, node, p->handler, &e))
        die(EXIT_INTERNAL, "umockdev: %s", e->message);
    p->gone = false;
    free(text);
    free(descriptors);
    free(node);
}

static gboolean port_replug(gpointer port)
{
    port_plug(port);
    return G_SOURCE_REMOVE;
}

/* Pulls the cable: what is under way ends with an error, the node disappears. */
static void port_unplug(struct port *p)
{
    char *path = device_path(p), *node = device_node(p);
    p->gone = true;
    p->unplug_after = -1;
    sim_unplug(p->device->board);
    for (GQueue *q = &p->out; q; q = q == &p->out ? &p->in : NULL)
        while (!g_queue_is_empty(q))
            urb_complete(p, q, g_queue_peek_head(q), -ESHUTDOWN);
    umockdev_testbed_uevent(p->bus->testbed, path, "remove");
    umockdev_testbed_detach_ioctl(p->bus->testbed, node, NULL);
    umockdev_testbed_remove_device(p->bus->testbed, path);
    g_timeout_add(REPLUG_MS, port_replug, p);
    free(path);
    free(node);
}

/* --- moving data --- */

/* The first bytes of a message: a header of the firmware's protocol version. */
static bool is_header(const uint8_t *data, size_t bytes)
{
    return bytes >= sizeof(struct usb_header) && (data[0] | data[1] << 8) == USB_PROTOCOL_MAGIC &&
           data[2] == USB_PROTOCOL_VERSION;
}

/* Sends packets of the first OUT transfer; true when something moved. */
static bool port_send(struct port *p)
{
    struct urb *u = g_queue_peek_head(&p->out);
    if (!u)
        return false;
    size_t left = (size_t)urb_fields(u)->buffer_length - u->done;
    uint8_t *data = u->buffer ? u->buffer->data + u->done : NULL;
    if (u->done == 0 && p->bus->options->protocol_version != USB_PROTOCOL_VERSION && is_header(data, left))
        data[2] = (uint8_t)~USB_PROTOCOL_VERSION; /* the firmware refuses it, as that of another version would */
    if (p->damage_after >= 0 && p->out_bytes >= p->damage_after && left > 100) {
        data[left / 2] ^= 1;
        p->damage_after = -1;
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
    if (p->unplug_after >= 0 && p->out_bytes >= p->unplug_after)
        port_unplug(p);
    if (p->freeze_after >= 0 && p->out_bytes >= p->freeze_after) {
        p->freeze_after = -1;
        p->frozen = true;
    }
    return n > 0 || left == 0;
}

/* Fetches packets of the first IN transfer; true when something moved. */
static bool port_receive(struct port *p)
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
        packet[2] = (uint8_t)p->bus->options->protocol_version;
    if (n)
        umockdev_ioctl_data_update(u->buffer, u->done, packet, n);
    u->done += (uint32_t)n;
    if ((size_t)n < sim_packet(p->device->board, USB_ENDPOINT_IN) || (size_t)n == left)
        urb_complete(p, &p->in, u, 0);
    return true;
}

/* Runs the device until a transfer is complete or nothing moves any more. libusb asks again and again: from the second
 * time in vain on, wait a little. */
static void port_run(struct port *p)
{
    for (int idle = 0; idle < IDLE_POLLS && g_queue_is_empty(&p->complete);) {
        bool moved = !p->frozen && !p->gone && port_send(p);
        moved = (!p->frozen && !p->gone && port_receive(p)) || moved;
        sim_device_poll(p->device);
        idle = moved ? 0 : idle + 1;
    }
    if (g_queue_is_empty(&p->complete) && p->waiting)
        g_usleep(IDLE_SLEEP_US);
    p->waiting = g_queue_is_empty(&p->complete);
}

/* A control transfer with the device, its data stage in `data`; a negative errno on failure, else the bytes. */
static int port_control(struct port *p, const uint8_t setup[8], uint8_t *data)
{
    int n = sim_device_control(p->device, setup, data);
    return n >= 0 ? n : n == SIM_STALL ? -EPIPE : n == SIM_GONE ? -ESHUTDOWN : -ETIMEDOUT;
}

static int port_order(struct port *p, uint8_t type, uint8_t request, uint16_t value, uint16_t index)
{
    uint8_t setup[8] = {type, request, (uint8_t)value, (uint8_t)(value >> 8), (uint8_t)index, (uint8_t)(index >> 8),
                        0,    0};
    return port_control(p, setup, NULL);
}

/* --- usbfs --- */

static int submit_control(struct port *p, struct urb *u)
{
    uint32_t length = (uint32_t)urb_fields(u)->buffer_length;
    if (!u->buffer || length < 8)
        return -EINVAL;
    uint8_t *setup = u->buffer->data;
    if (length < 8u + (setup[6] | setup[7] << 8))
        return -EINVAL;
    uint8_t *data = xmalloc(length);
    memcpy(data, setup + 8, length - 8);
    int n = port_control(p, setup, data);
    if (n > 0 && setup[0] & 0x80)
        umockdev_ioctl_data_update(u->buffer, 8, data, n);
    free(data);
    u->done = n > 0 ? (uint32_t)n : 0;
    urb_complete(p, NULL, u, n < 0 ? n : 0);
    return 0;
}

static int submit_urb(struct port *p, UMockdevIoctlClient *client, UMockdevIoctlData *arg)
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

static struct urb *complete_find(struct port *p, const UMockdevIoctlClient *client)
{
    for (GList *l = p->complete.head; l; l = l->next) {
        struct urb *u = l->data;
        if (u->client == client)
            return u;
    }
    return NULL;
}

static int reap_urb(struct port *p, const UMockdevIoctlClient *client, UMockdevIoctlData *arg)
{
    struct urb *u = complete_find(p, client);
    if (!u && !p->gone) {
        port_run(p);
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

static int discard_urb(struct port *p, UMockdevIoctlData *arg)
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
static int claim(struct port *p)
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

/* Serves one ioctl; a negative errno on failure. */
static int serve(struct port *p, UMockdevIoctlClient *client, gulong request, UMockdevIoctlData *arg)
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
        return port_order(p, 0x01, 11, 0, (uint16_t)arg_word(arg));
    case USBDEVFS_CLEAR_HALT:
        return port_order(p, 0x02, 1, 0, (uint16_t)arg_word(arg));
    case USBDEVFS_SETCONFIGURATION:
        return port_order(p, 0x00, 9, (uint16_t)arg_word(arg), 0);
    case USBDEVFS_RESET:
        return sim_device_enumerate(p->device, p->descriptors) < 0 ? -ENODEV : 0;
    case USBDEVFS_GETDRIVER:
        return -ENODATA;
    default:
        return -ENOTTY;
    }
}

static gboolean on_ioctl(UMockdevIoctlBase *handler, UMockdevIoctlClient *client, gpointer port)
{
    struct port *p = port;
    (void)handler;
    g_mutex_lock(&p->bus->lock);
    p->used = true;
    p->asked = g_get_monotonic_time();
    int result = serve(p, client, umockdev_ioctl_client_get_request(client), umockdev_ioctl_client_get_arg(client));
    g_mutex_unlock(&p->bus->lock);
    umockdev_ioctl_client_complete(client, result < 0 ? -1 : result, result < 0 ? -result : 0);
    return TRUE;
}

/* --- the child --- */

static gboolean bus_end(struct bus *b, int exit_code)
{
    b->exit_code = exit_code;
    g_main_loop_quit(b->loop);
    return G_SOURCE_REMOVE;
}

static void on_child_exit(GPid pid, gint status, gpointer bus)
{
    struct bus *b = bus;
    (void)pid;
    bus_end(b, b->closed ? EXIT_OK : WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status));
}

/* Ctrl-C reaches the child by itself; a termination is passed on. Either way the child ends first. */
static gboolean on_interrupt(gpointer bus)
{
    return ((struct bus *)bus)->child ? G_SOURCE_CONTINUE : bus_end(bus, 128 + SIGINT);
}

static gboolean on_terminate(gpointer bus)
{
    struct bus *b = bus;
    if (!b->child)
        return bus_end(b, 128 + SIGTERM);
    kill(b->child, SIGTERM);
    return G_SOURCE_CONTINUE;
}

/* No program has a request under way. One that died with one is treated as the next to open the device would: what is left is dropped. */
static bool port_free(struct port *p)
{
    if (p->gone)
        return false;
    if (g_queue_is_empty(&p->out) && sim_device_idle(p->device))
        return true;
    if (g_get_monotonic_time() - p->asked < SILENCE_US)
        return false;
    claim(p);
    port_order(p, 0x02, 1, 0, USB_ENDPOINT_OUT);
    port_order(p, 0x02, 1, 0, USB_ENDPOINT_IN);
    return sim_device_idle(p->device);
}

static gboolean on_step(gpointer bus)
{
    struct bus *b = bus;
    struct port *p = &b->ports[0];
    g_mutex_lock(&b->lock);
    if (port_free(p)) {
        bool used = p->used;
        p->used = false;
        b->stepping = true;
        b->closed = !b->host->step(b->host->ctx, used);
        b->stepping = false;
    }
    g_mutex_unlock(&b->lock);
    if (!b->closed)
        return G_SOURCE_CONTINUE;
    if (!b->child)
        return bus_end(b, EXIT_OK);
    kill(b->child, SIGHUP);
    return G_SOURCE_REMOVE;
}

static void bus_spawn(struct bus *b, char **command)
{
    GError *e = NULL;
    if (!g_spawn_async(NULL, command, NULL,
                       G_SPAWN_DO_NOT_REAP_CHILD | G_SPAWN_SEARCH_PATH | G_SPAWN_CHILD_INHERITS_STDIN, NULL, NULL,
                       &b->child, &e))
        die(EXIT_FILE, "%s; is it on the PATH?", e->message);
    g_child_watch_add(b->child, on_child_exit, b);
}

static void port_create(struct bus *b, int i)
{
    struct port *p = &b->ports[i];
    struct sim_config board = b->options->board;
    p->bus = b;
    p->number = i + 1;
    p->unplug_after = i ? -1 : b->options->unplug_after;
    p->freeze_after = i ? -1 : b->options->freeze_after;
    p->damage_after = i ? -1 : b->options->damage_after;
    g_queue_init(&p->out);
    g_queue_init(&p->in);
    g_queue_init(&p->complete);
    if (i)
        board.serial = xasprintf("%s-%d", board.serial, i + 1);
    p->device = sim_device_create(&board);
    if (!p->device && board.flash_file)
        die(EXIT_FILE, "%s: cannot be read, or is the flash of a device with other banks; give another",
            board.flash_file);
    if (!p->device)
        die(EXIT_INTERNAL, "device %d: cannot be created", i + 1);
    port_plug(p);
}

/* umockdev complains when a program is killed with the device open, which is no trouble. */
static void on_log(const gchar *domain, GLogLevelFlags level, const gchar *message, gpointer data)
{
    if (!strstr(message, "open stream"))
        g_log_default_handler(domain, level, message, data);
}

/* The mocked /sys and /dev are a folder, removed with the testbed, also when the program dies. */
static struct bus *living;

static void testbed_remove(void)
{
    if (!living)
        return;
    if (living->stepping)
        g_mutex_unlock(&living->lock); /* the thread of the ioctls is waited for */
    g_object_unref(living->testbed);
}

struct bus *bus_create(const struct bus_options *o)
{
    struct bus *b = xcalloc(1, sizeof *b);
    b->options = o;
    b->testbed = umockdev_testbed_new();
    living = b;
    atexit(testbed_remove);
    /* The root hub. */
    testbed_add(
        b, "P: /devices/usb1\nN: bus/usb/001/001\nE: SUBSYSTEM=usb\nE: DRIVER=usb\nE: DEVTYPE=usb_device\n"
           "E: BUSNUM=001\nE: DEVNUM=001\nE: DEVNAME=/dev/bus/usb/001/001\nA: bConfigurationValue=1\\n\n"
           "A: busnum=1\\n\nA: devnum=1\\n\nA: speed=480\\n\n"
           "H: descriptors=12010002090001406b1d020000060302010109021900010100e0000904000001090000000705810304000c\n");
    for (int i = 0; i < o->devices; i++)
        port_create(b, i);
    g_log_set_default_handler(on_log, NULL);
    return b;
}

struct sim_device *bus_device(struct bus *b, int index)
{
    return b->ports[index].device;
}

int bus_run(struct bus *b, char **command, const struct bus_host *host)
{
    b->loop = g_main_loop_new(NULL, FALSE);
    b->host = host;
    g_unix_signal_add(SIGINT, on_interrupt, b);
    g_unix_signal_add(SIGTERM, on_terminate, b);
    if (host)
        g_timeout_add(STEP_MS, on_step, b);
    if (*command)
        bus_spawn(b, command);
    g_main_loop_run(b->loop);
    for (int i = 0; i < b->options->devices; i++) {
        char *node = device_node(&b->ports[i]);
        if (!b->ports[i].gone)
            umockdev_testbed_detach_ioctl(b->testbed, node, NULL);
        free(node);
        if (!sim_device_destroy(b->ports[i].device))
            die(EXIT_FILE, "%s: the flash cannot be written; is its folder writable?", b->options->board.flash_file);
    }
    int code = b->exit_code;
    living = NULL;
    g_object_unref(b->testbed);
    g_main_loop_unref(b->loop);
    free(b);
    return code;
}
