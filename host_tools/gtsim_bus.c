/*
 * The mocked bus: devices appear and disappear in /sys and /dev, the child runs, the host in this process has its turns. What programs ask of a
 * device is served by gtsim_usbfs.c.
 */
#define _GNU_SOURCE
#include "gtsim_bus.h"

#include <errno.h>
#include <fcntl.h>
#include <glib-unix.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <umockdev.h>
#include <unistd.h>

#include "common.h"
#include "gtsim_usbfs.h"

#define REPLUG_MS  300     /* an unplugged device comes back after */
#define STEP_MS    10      /* between two steps of the host in this process */
#define SILENCE_US 1000000 /* a program with a request under way that no longer asks for the reply has died */

struct port {
    struct bus *bus;
    int number; /* 1.. */
    struct usbfs usbfs;
    UMockdevIoctlBase *handler;
    bool used;    /* by a program since the last step of the host in this process */
    gint64 asked; /* when a program did so last, g_get_monotonic_time */
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
    uint8_t bytes[64];
    g_mutex_lock(&p->bus->lock);
    int count = sim_device_enumerate(p->usbfs.device, bytes);
    g_mutex_unlock(&p->bus->lock);
    if (count < 0)
        die(EXIT_INTERNAL, "device %d: enumeration failed (%d)", p->number, count);
    char *node = device_node(p), *descriptors = hex(bytes, count);
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
    p->usbfs.gone = false;
    free(text);
    free(descriptors);
    free(node);
}

static gboolean port_replug(gpointer port)
{
    port_plug(port);
    return G_SOURCE_REMOVE;
}

/* The cable was pulled: the node disappears, and comes back. */
static void port_disappear(struct port *p)
{
    char *path = device_path(p), *node = device_node(p);
    umockdev_testbed_uevent(p->bus->testbed, path, "remove");
    umockdev_testbed_detach_ioctl(p->bus->testbed, node, NULL);
    umockdev_testbed_remove_device(p->bus->testbed, path);
    g_timeout_add(REPLUG_MS, port_replug, p);
    free(path);
    free(node);
}

static gboolean on_ioctl(UMockdevIoctlBase *handler, UMockdevIoctlClient *client, gpointer port)
{
    struct port *p = port;
    (void)handler;
    g_mutex_lock(&p->bus->lock);
    p->used = true;
    p->asked = g_get_monotonic_time();
    bool here = !p->usbfs.gone;
    int result = usbfs_serve(&p->usbfs, client, umockdev_ioctl_client_get_request(client),
                             umockdev_ioctl_client_get_arg(client));
    if (here && p->usbfs.gone)
        port_disappear(p);
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

static gboolean pass_on(struct bus *b, int signal_number)
{
    if (!b->child)
        return bus_end(b, 128 + signal_number);
    kill(b->child, signal_number);
    return G_SOURCE_CONTINUE;
}

static gboolean on_terminate(gpointer bus)
{
    return pass_on(bus, SIGTERM);
}

static gboolean on_hang_up(gpointer bus)
{
    return pass_on(bus, SIGHUP);
}

/* No program has a request under way. One that died with one is treated as the next to open the device would: what is left is dropped. */
static bool port_free(struct port *p)
{
    struct usbfs *u = &p->usbfs;
    if (u->gone)
        return false;
    if (usbfs_idle(u))
        return true;
    if (g_get_monotonic_time() - p->asked < SILENCE_US)
        return false;
    usbfs_drop(u);
    return usbfs_idle(u);
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

/* --- the flash file --- */

/* Held from reading the file to writing it: two devices would each forget what the other was sent. Beside the file, which is replaced. */
static char *lock_file;

static void flash_unlock(void)
{
    unlink(lock_file);
}

static void flash_lock(const char *flash_file)
{
    struct stat held, there;
    lock_file = xasprintf("%s.lock", flash_file);
    for (;;) {
        int fd = open(lock_file, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
        if (fd < 0)
            die(EXIT_FILE, "%s: %s; is its folder there and writable?", lock_file, strerror(errno));
        if (flock(fd, LOCK_EX | LOCK_NB))
            die(EXIT_FILE, "%s: in use by another gtsim; end that one or give another file", flash_file);
        /* Whoever held it may have removed it just before. */
        if (!fstat(fd, &held) && !stat(lock_file, &there) && held.st_ino == there.st_ino)
            break;
        close(fd);
    }
    atexit(flash_unlock);
}

static _Noreturn void refuse_flash(const struct sim_config *board)
{
    struct sim_config fresh = *board;
    struct stat st;
    uint32_t bytes = 0;
    fresh.flash_file = NULL;
    struct sim_device *device = sim_device_create(&fresh);
    if (device)
        sim_flash(device->board, &bytes);
    if (access(board->flash_file, R_OK) || stat(board->flash_file, &st))
        die(EXIT_FILE, "%s: %s; give a readable file", board->flash_file, strerror(errno));
    if (!S_ISREG(st.st_mode))
        die(EXIT_FILE, "%s: not a regular file; give another", board->flash_file);
    die(EXIT_BAD_INPUT,
        "%s: %lld bytes where this device's flash has %u: truncated, foreign or of another --bank; give another",
        board->flash_file, (long long)st.st_size, bytes);
}

static void port_create(struct bus *b, int i)
{
    struct port *p = &b->ports[i];
    const struct bus_options *o = b->options;
    struct sim_config board = o->board;
    p->bus = b;
    p->number = i + 1;
    if (i)
        board.serial = xasprintf("%s-%d", board.serial, i + 1);
    struct sim_device *device = sim_device_create(&board);
    if (!device && board.flash_file)
        refuse_flash(&board);
    if (!device)
        die(EXIT_INTERNAL, "device %d: cannot be created", i + 1);
    usbfs_init(&p->usbfs, device, o->protocol_version);
    if (i == 0)
        p->usbfs.faults = o->faults;
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
    if (o->board.flash_file)
        flash_lock(o->board.flash_file);
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
    return b->ports[index].usbfs.device;
}

int bus_run(struct bus *b, char **command, const struct bus_host *host)
{
    b->loop = g_main_loop_new(NULL, FALSE);
    b->host = host;
    g_unix_signal_add(SIGINT, on_interrupt, b);
    g_unix_signal_add(SIGTERM, on_terminate, b);
    struct sigaction hang_up;
    if (!sigaction(SIGHUP, NULL, &hang_up) && hang_up.sa_handler != SIG_IGN) /* nohup */
        g_unix_signal_add(SIGHUP, on_hang_up, b);
    if (host)
        g_timeout_add(STEP_MS, on_step, b);
    if (*command)
        bus_spawn(b, command);
    g_main_loop_run(b->loop);
    for (int i = 0; i < b->options->devices; i++) {
        char *node = device_node(&b->ports[i]);
        if (!b->ports[i].usbfs.gone)
            umockdev_testbed_detach_ioctl(b->testbed, node, NULL);
        free(node);
        if (!sim_device_destroy(b->ports[i].usbfs.device))
            die(EXIT_FILE, "%s: the flash cannot be written; is its folder writable?", b->options->board.flash_file);
    }
    int code = b->exit_code;
    living = NULL;
    g_object_unref(b->testbed);
    g_main_loop_unref(b->loop);
    free(b);
    return code;
}
