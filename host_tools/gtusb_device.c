/* Finding and opening the device; `list`. */
#define _GNU_SOURCE
#include "gtusb.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_CANDIDATES 32
#define MAX_PORT_DEPTH 7
#define RULE_FILE      "60-goniotile.rules"

struct candidate {
    libusb_device *device;
    char port[40];
    char serial[64]; /* empty when it could not be read */
    int error;       /* of opening it, a libusb_error */
};

static const char *wanted_serial, *wanted_port;
static double timeout = 5;
static libusb_context *context;
static libusb_device_handle *handle;

static error_t parse_option(int key, char *arg, struct argp_state *state)
{
    (void)state;
    switch (key) {
    case 's':
        wanted_serial = arg;
        return 0;
    case 'p':
        wanted_port = arg;
        return 0;
    case 't':
        timeout = parse_double("--timeout", arg, 0.01, 3600);
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static const struct argp_option option_table[] = {
    {"serial", 's', "SERIAL", 0, "the device with this serial number", 0},
    {"port", 'p', "BUS-PORT", 0, "the device on this port, as 'gtusb list' prints it: 1-1", 0},
    {"timeout", 't', "SECONDS", 0, "give up when nothing moves for so long (5; flash and frames get six times that)",
     0},
    {0}};
static const struct argp device_argp = {option_table, parse_option, NULL, NULL, NULL, NULL, NULL};
const struct argp_child device_options[] = {{&device_argp, 0, "Which device:", 9}, {0}};

static void port_text(char *out, size_t size, libusb_device *device)
{
    uint8_t ports[MAX_PORT_DEPTH];
    int n = libusb_get_port_numbers(device, ports, MAX_PORT_DEPTH);
    int used = snprintf(out, size, "%u", libusb_get_bus_number(device));
    for (int i = 0; i < n; i++)
        used += snprintf(out + used, size - (size_t)used, "%c%u", i ? '.' : '-', ports[i]);
}

/* Reads the serial number; remembers why not. */
static void candidate_identify(struct candidate *c, const struct libusb_device_descriptor *d)
{
    libusb_device_handle *h;
    port_text(c->port, sizeof c->port, c->device);
    c->error = libusb_open(c->device, &h);
    if (c->error)
        return;
    int n = libusb_get_string_descriptor_ascii(h, d->iSerialNumber, (unsigned char *)c->serial, sizeof c->serial - 1);
    c->serial[n > 0 ? n : 0] = 0;
    libusb_close(h);
}

static int candidates_find(struct candidate *out)
{
    libusb_device **list;
    int e = context ? 0 : libusb_init(&context), count = 0;
    if (e)
        die(EXIT_USB, "libusb: %s; is /dev/bus/usb there?", libusb_strerror(e));
    ssize_t n = libusb_get_device_list(context, &list);
    if (n < 0)
        die(EXIT_USB, "libusb: %s; is /dev/bus/usb there?", libusb_strerror((enum libusb_error)n));
    for (ssize_t i = 0; i < n && count < MAX_CANDIDATES; i++) {
        struct libusb_device_descriptor d;
        if (libusb_get_device_descriptor(list[i], &d) || d.idVendor != USB_VENDOR_ID || d.idProduct != USB_PRODUCT_ID)
            continue;
        struct candidate c = {.device = libusb_ref_device(list[i])};
        candidate_identify(&c, &d);
        out[count++] = c;
    }
    libusb_free_device_list(list, 1);
    return count;
}

static void candidate_print(FILE *to, const struct candidate *c)
{
    fprintf(to, "%-8s %04x:%04x  %s\n", c->port, USB_VENDOR_ID, USB_PRODUCT_ID,
            c->error     ? libusb_strerror(c->error)
            : *c->serial ? c->serial
                         : "(no serial number)");
}

static _Noreturn void open_failed(const struct candidate *c, int error)
{
    if (error == LIBUSB_ERROR_ACCESS)
        die(EXIT_PERMISSION,
            "device %s: no permission; install host_tools/" RULE_FILE
            " into /etc/udev/rules.d, then unplug the device and plug it in again",
            c->port);
    if (error == LIBUSB_ERROR_BUSY)
        die(EXIT_USB, "device %s: in use by another program; end that first", c->port);
    die(EXIT_USB, "device %s: %s; unplug it and plug it in again", c->port, libusb_strerror(error));
}

static bool candidate_matches(const struct candidate *c)
{
    return (!wanted_port || !strcmp(wanted_port, c->port)) && (!wanted_serial || !strcmp(wanted_serial, c->serial));
}

/* The one candidate that the options name. */
static struct candidate candidate_choose(void)
{
    struct candidate all[MAX_CANDIDATES];
    int count = candidates_find(all), matching = 0, chosen = 0;
    for (int i = 0; i < count; i++)
        if (candidate_matches(&all[i])) {
            matching++;
            chosen = i;
        }
    if (!count)
        die(EXIT_NO_DEVICE, "no device: none with id %04x:%04x on any bus; plug it in, or try 'gtsim run -- gtusb ...'",
            USB_VENDOR_ID, USB_PRODUCT_ID);
    if (!matching) {
        for (int i = 0; wanted_serial && i < count; i++)
            if (all[i].error == LIBUSB_ERROR_ACCESS)
                open_failed(&all[i], all[i].error);
        die(EXIT_NO_DEVICE, "no device: %d there, none with%s%s%s%s; see 'gtusb list'", count,
            wanted_serial ? " serial number " : "", wanted_serial ? wanted_serial : "", wanted_port ? " port " : "",
            wanted_port ? wanted_port : "");
    }
    if (matching > 1) {
        warn("%d devices match; choose one by --serial or --port:", matching);
        for (int i = 0; i < count; i++)
            if (candidate_matches(&all[i]))
                candidate_print(stderr, &all[i]);
        exit(EXIT_SEVERAL);
    }
    for (int i = 0; i < count; i++)
        if (i != chosen)
            libusb_unref_device(all[i].device);
    return all[chosen];
}

struct link *device_open(struct usb_info *info)
{
    struct candidate c = candidate_choose();
    struct reply r;
    int e = c.error ? c.error : libusb_open(c.device, &handle);
    if (e)
        open_failed(&c, e);
    e = libusb_claim_interface(handle, 0);
    /* A program that was killed may have left half a request or replies behind: setting the interface clears both. */
    if (!e)
        e = libusb_set_interface_alt_setting(handle, 0, 0);
    int packet = e ? 0 : libusb_get_max_packet_size(c.device, USB_ENDPOINT_IN);
    if (e || packet <= 0)
        open_failed(&c, e ? e : packet);
    libusb_unref_device(c.device);
    struct link *l = link_open(context, handle, (unsigned)packet, timeout);
    link_request(l, &r, NULL, USB_MSG_INFO, NULL, 0);
    if (r.length != sizeof *info)
        die(EXIT_USB, "info: %u bytes where %zu are expected; update the older of firmware and this program", r.length,
            sizeof *info);
    memcpy(info, r.payload, sizeof *info);
    if (info->protocol_version != USB_PROTOCOL_VERSION || info->slot_count > USB_MAX_SLOTS || info->slot_count < 1)
        die(EXIT_REFUSED,
            "the device speaks protocol version %u with %u slots, this program version %u; update the older",
            info->protocol_version, info->slot_count, USB_PROTOCOL_VERSION);
    return l;
}

void device_close(struct link *l)
{
    link_close(l);
    libusb_release_interface(handle, 0);
    libusb_close(handle);
    libusb_exit(context);
}

/* Serial numbers are ASCII; what else a device may send is left out. */
static void candidate_print_json(const struct candidate *c, bool first)
{
    char serial[sizeof c->serial];
    size_t n = 0;
    for (const char *p = c->serial; *p; p++)
        if (*p >= ' ' && *p < 127 && *p != '"' && *p != '\\')
            serial[n++] = *p;
    serial[n] = 0;
    printf("%s {\"port\": \"%s\", \"serial\": \"%s\", \"error\": ", first ? "" : ",\n", c->port, serial);
    printf(c->error ? "\"%s\"}" : "null}", libusb_strerror(c->error));
}

static error_t parse_list_option(int key, char *arg, struct argp_state *state)
{
    (void)arg;
    if (key != 'j')
        return ARGP_ERR_UNKNOWN;
    *(bool *)state->input = true;
    return 0;
}

void command_list(int argc, char **argv)
{
    static const struct argp_option options[] = {{"json", 'j', NULL, 0, "print JSON", 0}, {0}};
    static const struct argp argp = {options,
                                     parse_list_option,
                                     NULL,
                                     "Prints port, id and serial number of every device, one a line."
                                     "\vExamples:\n"
                                     "  $ gtusb list\n"
                                     "  $ gtusb list --json",
                                     NULL,
                                     NULL,
                                     NULL};
    struct candidate all[MAX_CANDIDATES];
    bool json = false;
    options_parse(&argp, argc, argv, &json);
    int count = candidates_find(all);
    fputs(json ? "[" : "", stdout);
    for (int i = 0; i < count; i++) {
        if (json)
            candidate_print_json(&all[i], i == 0);
        else
            candidate_print(stdout, &all[i]);
        libusb_unref_device(all[i].device);
    }
    fputs(json ? "]\n" : "", stdout);
    libusb_exit(context);
    if (!count)
        die(EXIT_NO_DEVICE, "no device: none with id %04x:%04x on any bus; plug it in, or try 'gtsim run -- gtusb ...'",
            USB_VENDOR_ID, USB_PRODUCT_ID);
}
