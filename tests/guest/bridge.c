/*
 * A device on a virtual machine's USB: the host's side of the usbredir protocol on one socket, and on another one an operator's hand on
 * the cable. Both are the machine's: its usb-redir device and one of its serial lines.
 *   bridge USB_SOCKET ORDERS_SOCKET sim
 *   bridge USB_SOCKET ORDERS_SOCKET board MEMORY_FILE COMMAND...
 * Orders are lines, each answered by one that begins with "ok" (plug also by "failed"):
 *   plug, unplug
 *   unplug_after N   when N more bytes have gone out on the bulk endpoint
 *   damage_after N   then one bit of the next transfer's first byte is wrong
 *   freeze, thaw     the bulk endpoints answer NAK
 *   counts           what there was so far: stalled bulk transfers, cancelled ones, bus resets
 * Ends when the machine does.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>
#include <usbredirparser.h>

#include "common.h"
#include "port.h"
#include "sim.h" /* enum sim_result */

enum { BULK_OUT = 0x01, BULK_IN = 0x81, CONTROL_PACKET = 64, CONTROL_SECONDS = 30, BUSY_STEPS = 100, ORDER_CHARS = 80 };

struct transfer {
    struct transfer *next;
    uint64_t id;
    struct usb_redir_bulk_packet_header header;
    uint8_t *data;
    size_t bytes, done;
};

struct bridge {
    struct port port;
    struct usbredirparser *parser;
    int usb, orders;
    bool attached; /* the machine knows of the device */
    bool leaving;  /* it has been told of the unplugging and has not said yes yet */
    bool frozen;
    struct transfer *out, *in;                 /* bulk, oldest first */
    long long out_bytes, unplug_at, damage_at; /* -1: never */
    unsigned stalls, cancelled, resets;
    char order[ORDER_CHARS];
    size_t order_chars;
};

/* --- control transfers: nothing else happens meanwhile --- */

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static int control_in(struct port *p, uint8_t *packet)
{
    int n = SIM_NAK;
    for (double end = now() + CONTROL_SECONDS; n == SIM_NAK && now() < end;) {
        p->run(p->ctx);
        n = p->in(p->ctx, 0x80, packet, CONTROL_PACKET);
    }
    return n;
}

/* Bytes of the data stage, or a negative enum sim_result. */
static int control(struct port *p, const uint8_t setup[8], uint8_t *data)
{
    int length = setup[6] | setup[7] << 8, moved = 0, n = p->setup(p->ctx, setup);
    uint8_t packet[CONTROL_PACKET];
    if (n < 0)
        return n;
    if (setup[0] & 0x80 && length) {
        do {
            n = control_in(p, packet);
            if (n < 0 || n > length - moved)
                return n < 0 ? n : SIM_OVERFLOW;
            memcpy(data + moved, packet, (size_t)n);
            moved += n;
        } while (n == CONTROL_PACKET && moved < length);
        n = p->out(p->ctx, 0x00, NULL, 0);
        p->run(p->ctx);
    } else {
        if (length && (moved = p->out(p->ctx, 0x00, data, (size_t)length)) < 0)
            return moved;
        n = control_in(p, packet);
    }
    return n < 0 ? n : moved;
}

static int request(struct bridge *b, uint8_t type, uint8_t code, uint16_t value, uint16_t index, uint16_t length,
                   uint8_t *data)
{
    const uint8_t setup[8] = {type,
                              code,
                              (uint8_t)value,
                              (uint8_t)(value >> 8),
                              (uint8_t)index,
                              (uint8_t)(index >> 8),
                              (uint8_t)length,
                              (uint8_t)(length >> 8)};
    return control(&b->port, setup, data);
}

static uint8_t redir_status(int result)
{
    return result >= 0              ? usb_redir_success
           : result == SIM_STALL    ? usb_redir_stall
           : result == SIM_OVERFLOW ? usb_redir_babble
           : result == SIM_NAK      ? usb_redir_timeout
                                    : usb_redir_ioerror;
}

/* --- bulk transfers --- */

static void transfer_end(struct bridge *b, struct transfer **queue, uint8_t status)
{
    struct transfer *t = *queue;
    size_t n = t->done;
    *queue = t->next;
    t->header.status = status;
    t->header.length = (uint16_t)n;
    t->header.length_high = (uint16_t)(n >> 16);
    bool in = t->header.endpoint & 0x80;
    if (b->attached)
        usbredirparser_send_bulk_packet(b->parser, t->id, &t->header, in ? t->data : NULL, in ? (int)n : 0);
    free(t->data);
    free(t);
}

static void transfers_drop(struct bridge *b, uint8_t status)
{
    while (b->out)
        transfer_end(b, &b->out, status);
    while (b->in)
        transfer_end(b, &b->in, status);
}

/* The endpoint answers with a failure. */
static void transfer_fail(struct bridge *b, struct transfer **queue, int result)
{
    b->stalls += result == SIM_STALL;
    transfer_end(b, queue, redir_status(result));
}

static void unplug(struct bridge *b);

/* Both move packets of the oldest transfer; true when something happened. */
static bool out_step(struct bridge *b)
{
    struct transfer *t = b->out;
    if (!t)
        return false;
    if (t->done == 0 && t->bytes && b->damage_at >= 0 && b->out_bytes >= b->damage_at) {
        t->data[0] ^= 1;
        b->damage_at = -1;
    }
    int n = b->port.out(b->port.ctx, BULK_OUT, t->data + t->done, t->bytes - t->done);
    if (n == SIM_NAK)
        return false;
    if (n < 0) {
        transfer_fail(b, &b->out, n);
        return true;
    }
    t->done += (size_t)n;
    b->out_bytes += n;
    if (t->done == t->bytes)
        transfer_end(b, &b->out, usb_redir_success);
    if (b->unplug_at >= 0 && b->out_bytes >= b->unplug_at)
        unplug(b);
    return true;
}

static bool in_step(struct bridge *b)
{
    struct transfer *t = b->in;
    if (!t)
        return false;
    int packet = b->port.high_speed ? 512 : 64;
    int n = b->port.in(b->port.ctx, BULK_IN, t->data + t->done, t->bytes - t->done);
    if (n == SIM_NAK)
        return false;
    if (n < 0) {
        transfer_fail(b, &b->in, n);
        return true;
    }
    t->done += (size_t)n;
    if (n < packet || t->done == t->bytes)
        transfer_end(b, &b->in, usb_redir_success);
    return true;
}

/* --- the cable --- */

/* Reset and address, as a host does; tells the machine of the endpoints that the configuration descriptor has. */
static bool enumerate(struct bridge *b)
{
    struct usb_redir_ep_info_header e = {0};
    struct usb_redir_interface_info_header i = {.interface_count = 1};
    struct usb_redir_device_connect_header c = {.speed =
                                                    b->port.high_speed ? usb_redir_speed_high : usb_redir_speed_full};
    uint8_t device[18], configuration[512];
    b->port.reset(b->port.ctx);
    if (request(b, 0x80, 6, 0x100, 0, sizeof device, device) != sizeof device || request(b, 0, 5, 1, 0, 0, NULL) < 0)
        return false;
    int n = request(b, 0x80, 6, 0x200, 0, sizeof configuration, configuration);
    if (n < 9)
        return false;
    memset(e.type, usb_redir_type_invalid, sizeof e.type);
    e.type[0] = e.type[16] = usb_redir_type_control;
    e.max_packet_size[0] = e.max_packet_size[16] = CONTROL_PACKET;
    for (int at = 0; at + 2 <= n && configuration[at] >= 2 && at + configuration[at] <= n; at += configuration[at]) {
        const uint8_t *d = configuration + at;
        if (d[1] == 4)
            i.interface_class[0] = d[5];
        if (d[1] != 5)
            continue;
        int slot = (d[2] & 0x0f) | (d[2] & 0x80) >> 3;
        e.type[slot] = d[3] & 3;
        e.max_packet_size[slot] = (uint16_t)(d[4] | d[5] << 8);
    }
    c.vendor_id = (uint16_t)(device[8] | device[9] << 8);
    c.product_id = (uint16_t)(device[10] | device[11] << 8);
    c.device_version_bcd = (uint16_t)(device[12] | device[13] << 8);
    usbredirparser_send_ep_info(b->parser, &e);
    usbredirparser_send_interface_info(b->parser, &i);
    if (!b->attached)
        usbredirparser_send_device_connect(b->parser, &c);
    b->attached = true;
    return true;
}

static void unplug(struct bridge *b)
{
    b->unplug_at = b->damage_at = -1;
    b->frozen = false;
    b->port.unplug(b->port.ctx);
    if (!b->attached)
        return;
    b->attached = false;
    b->leaving = true;
    transfers_drop(b, usb_redir_cancelled);
    usbredirparser_send_device_disconnect(b->parser);
}

/* --- what the machine asks --- */

static void on_log(void *priv, int level, const char *message)
{
    (void)priv;
    if (level <= usbredirparser_warning)
        fprintf(stderr, "usbredir: %s\n", message);
}

static int on_read(void *priv, uint8_t *data, int count)
{
    const struct bridge *b = priv;
    ssize_t n = read(b->usb, data, (size_t)count);
    if (n == 0 || (n < 0 && errno == ECONNRESET))
        exit(EXIT_OK); /* the machine is off */
    return n < 0 && errno == EAGAIN ? 0 : (int)n;
}

static int on_write(void *priv, uint8_t *data, int count)
{
    const struct bridge *b = priv;
    ssize_t n = write(b->usb, data, (size_t)count);
    return n < 0 && errno == EAGAIN ? 0 : (int)n;
}

static void on_reset(void *priv)
{
    struct bridge *b = priv;
    b->resets++;
    transfers_drop(b, usb_redir_cancelled);
    if (b->attached && !enumerate(b))
        warn("the device does not come back from a reset");
}

static void on_set_configuration(void *priv, uint64_t id, struct usb_redir_set_configuration_header *h)
{
    struct bridge *b = priv;
    int n = request(b, 0x00, 9, h->configuration, 0, 0, NULL);
    struct usb_redir_configuration_status_header s = {redir_status(n), h->configuration};
    usbredirparser_send_configuration_status(b->parser, id, &s);
}

static void on_get_configuration(void *priv, uint64_t id)
{
    struct bridge *b = priv;
    uint8_t value = 0;
    int n = request(b, 0x80, 8, 0, 0, 1, &value);
    struct usb_redir_configuration_status_header s = {redir_status(n), value};
    usbredirparser_send_configuration_status(b->parser, id, &s);
}

static void on_set_alternate(void *priv, uint64_t id, struct usb_redir_set_alt_setting_header *h)
{
    struct bridge *b = priv;
    int n = request(b, 0x01, 11, h->alt, h->interface, 0, NULL);
    struct usb_redir_alt_setting_status_header s = {redir_status(n), h->interface, h->alt};
    usbredirparser_send_alt_setting_status(b->parser, id, &s);
}

static void on_get_alternate(void *priv, uint64_t id, struct usb_redir_get_alt_setting_header *h)
{
    struct bridge *b = priv;
    uint8_t value = 0;
    int n = request(b, 0x81, 10, 0, h->interface, 1, &value);
    struct usb_redir_alt_setting_status_header s = {redir_status(n), h->interface, value};
    usbredirparser_send_alt_setting_status(b->parser, id, &s);
}

static void on_control(void *priv, uint64_t id, struct usb_redir_control_packet_header *h, uint8_t *data, int bytes)
{
    struct bridge *b = priv;
    uint8_t answer[65536];
    bool in = h->endpoint & 0x80;
    int n = request(b, h->requesttype, h->request, h->value, h->index, in ? h->length : (uint16_t)bytes,
                    in ? answer : data);
    h->status = redir_status(n);
    h->length = (uint16_t)(n > 0 ? n : 0);
    usbredirparser_send_control_packet(b->parser, id, h, in ? answer : NULL, in ? h->length : 0);
    usbredirparser_free_packet_data(b->parser, data);
}

static void on_bulk(void *priv, uint64_t id, struct usb_redir_bulk_packet_header *h, uint8_t *data, int bytes)
{
    struct bridge *b = priv;
    struct transfer *t = xcalloc(1, sizeof *t), **queue = h->endpoint & 0x80 ? &b->in : &b->out;
    size_t wanted = h->length | (size_t)h->length_high << 16;
    *t = (struct transfer){.id = id, .header = *h, .bytes = h->endpoint & 0x80 ? wanted : (size_t)bytes};
    t->data = xmalloc(t->bytes + 1);
    if (bytes)
        memcpy(t->data, data, (size_t)bytes);
    usbredirparser_free_packet_data(b->parser, data);
    while (*queue)
        queue = &(*queue)->next;
    *queue = t;
    if (!b->attached || (h->endpoint != BULK_OUT && h->endpoint != BULK_IN))
        transfer_end(b, queue, usb_redir_ioerror);
}

static void on_cancel(void *priv, uint64_t id)
{
    struct bridge *b = priv;
    struct transfer **queues[] = {&b->out, &b->in};
    for (int i = 0; i < 2; i++)
        for (struct transfer **q = queues[i]; *q; q = &(*q)->next)
            if ((*q)->id == id) {
                b->cancelled++;
                transfer_end(b, q, usb_redir_cancelled);
                return;
            }
}

static void on_disconnect_ack(void *priv)
{
    struct bridge *b = priv;
    b->leaving = false;
}

static void on_hello(void *priv, struct usb_redir_hello_header *h)
{
    (void)priv;
    (void)h;
}

static void on_filter(void *priv, struct usbredirfilter_rule *rules, int count)
{
    (void)priv;
    (void)count;
    free(rules);
}

static void parser_start(struct bridge *b)
{
    static const int capabilities[] = {usb_redir_cap_connect_device_version, usb_redir_cap_device_disconnect_ack,
                                       usb_redir_cap_ep_info_max_packet_size, usb_redir_cap_64bits_ids,
                                       usb_redir_cap_32bits_bulk_length};
    uint32_t caps[USB_REDIR_CAPS_SIZE] = {0};
    struct usbredirparser *p = b->parser = usbredirparser_create();
    if (!p)
        die(EXIT_INTERNAL, "usbredirparser_create: out of memory");
    p->priv = b;
    p->log_func = on_log;
    p->read_func = on_read;
    p->write_func = on_write;
    p->hello_func = on_hello;
    p->filter_filter_func = on_filter;
    p->reset_func = on_reset;
    p->set_configuration_func = on_set_configuration;
    p->get_configuration_func = on_get_configuration;
    p->set_alt_setting_func = on_set_alternate;
    p->get_alt_setting_func = on_get_alternate;
    p->control_packet_func = on_control;
    p->bulk_packet_func = on_bulk;
    p->cancel_data_packet_func = on_cancel;
    p->device_disconnect_ack_func = on_disconnect_ack;
    for (size_t i = 0; i < sizeof capabilities / sizeof *capabilities; i++)
        usbredirparser_caps_set_cap(caps, capabilities[i]);
    usbredirparser_init(p, "goniotile", caps, USB_REDIR_CAPS_SIZE, usbredirparser_fl_usb_host);
}

/* --- orders --- */

static void answer(const struct bridge *b, const char *text)
{
    if (write(b->orders, text, strlen(text)) < 0)
        exit(EXIT_OK);
}

static void order_obey(struct bridge *b, const char *order)
{
    long long number;
    bool good = true;
    char text[ORDER_CHARS] = "ok\n";
    if (!strcmp(order, "plug"))
        good = b->port.plug(b->port.ctx) && enumerate(b);
    else if (!strcmp(order, "unplug"))
        unplug(b);
    else if (sscanf(order, "unplug_after %lld", &number) == 1)
        b->unplug_at = b->out_bytes + number;
    else if (sscanf(order, "damage_after %lld", &number) == 1)
        b->damage_at = b->out_bytes + number;
    else if (!strcmp(order, "freeze") || !strcmp(order, "thaw"))
        b->frozen = order[0] == 'f';
    else if (!strcmp(order, "counts"))
        snprintf(text, sizeof text, "ok stalls %u cancelled %u resets %u\n", b->stalls, b->cancelled, b->resets);
    else
        good = false;
    answer(b, good ? text : "failed\n");
}

static void orders_read(struct bridge *b)
{
    char c;
    for (ssize_t n; !b->leaving && (n = read(b->orders, &c, 1)) != -1;) {
        if (n == 0)
            exit(EXIT_OK);
        if (c != '\n' && b->order_chars < ORDER_CHARS - 1) {
            b->order[b->order_chars++] = c;
            continue;
        }
        b->order[b->order_chars] = 0;
        b->order_chars = 0;
        order_obey(b, b->order);
    }
}

static int socket_listen(const char *path)
{
    struct sockaddr_un a = {.sun_family = AF_UNIX};
    int s = socket(AF_UNIX, SOCK_STREAM, 0);
    if (strlen(path) >= sizeof a.sun_path)
        die(EXIT_USAGE, "%s: longer than the path of a socket may be (%zu); give a shorter one", path,
            sizeof a.sun_path - 1);
    strcpy(a.sun_path, path);
    if (s < 0 || bind(s, (const struct sockaddr *)&a, sizeof a) || listen(s, 1))
        die(EXIT_FILE, "%s: %s", path, strerror(errno));
    return s;
}

static int socket_accept(int listening)
{
    int s = accept4(listening, NULL, NULL, SOCK_NONBLOCK | SOCK_CLOEXEC);
    if (s < 0)
        die(EXIT_INTERNAL, "accept: %s", strerror(errno));
    close(listening);
    return s;
}

int main(int argc, char **argv)
{
    struct bridge b = {.unplug_at = -1, .damage_at = -1};
    common_set_name("bridge", NULL);
    signal(SIGPIPE, SIG_IGN);
    if (argc == 4 && !strcmp(argv[3], "sim"))
        b.port = port_sim();
    else if (argc > 5 && !strcmp(argv[3], "board"))
        b.port = port_mailbox(argv[4], argv + 5);
    else
        die(EXIT_USAGE, "give USB_SOCKET ORDERS_SOCKET and sim, or board MEMORY_FILE COMMAND...");
    int usb = socket_listen(argv[1]), orders = socket_listen(argv[2]);
    b.usb = socket_accept(usb);
    b.orders = socket_accept(orders);
    parser_start(&b);
    for (int idle = 0;;) {
        /* Data under way: go on at once; nothing has moved for long: look again soon; no transfers: sleep. */
        bool waiting = (b.out || b.in) && !b.frozen;
        struct pollfd fds[2] = {{b.usb, POLLIN, 0}, {b.leaving ? -1 : b.orders, POLLIN, 0}};
        if (usbredirparser_has_data_to_write(b.parser))
            fds[0].events |= POLLOUT;
        bool resting = idle == BUSY_STEPS && !waiting;
        if (resting)
            b.port.rest(b.port.ctx, true);
        poll(fds, 2, idle < BUSY_STEPS ? 0 : waiting ? 1 : -1);
        if (resting)
            b.port.rest(b.port.ctx, false);
        if (fds[0].revents & (POLLIN | POLLHUP) && usbredirparser_do_read(b.parser))
            die(EXIT_INTERNAL, "usbredir: the machine's messages cannot be read");
        if (usbredirparser_has_data_to_write(b.parser) && usbredirparser_do_write(b.parser))
            die(EXIT_INTERNAL, "usbredir: %s", strerror(errno));
        if (fds[1].revents)
            orders_read(&b);
        bool moved = fds[0].revents || fds[1].revents;
        if (!b.frozen) {
            moved = out_step(&b) || moved;
            moved = in_step(&b) || moved;
        }
        b.port.run(b.port.ctx);
        idle = moved ? 0 : idle < BUSY_STEPS ? idle + 1 : idle;
    }
}
