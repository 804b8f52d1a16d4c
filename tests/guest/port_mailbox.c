/* The bridge's side of the mailbox (hal/mps2/mailbox.h). */
#define _GNU_SOURCE
#include "port.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "common.h"
#include "hal.h"
#include "mailbox.h"
#include "sim.h" /* enum sim_result */

#define PATIENCE_MS 60000 /* for a board on a busy machine */

struct board {
    struct mailbox *mailbox;
    char **command;
    pid_t pid; /* 0: off */
};

static uint32_t word_read(const uint32_t *word)
{
    return __atomic_load_n(word, __ATOMIC_ACQUIRE);
}

static void word_write(uint32_t *word, uint32_t value)
{
    __atomic_store_n(word, value, __ATOMIC_RELEASE);
}

static void run(void *ctx)
{
    (void)ctx;
    nanosleep(&(struct timespec){.tv_nsec = 50000}, NULL);
}

/* Waits until the board has written this; false when it never does, or has ended. */
static bool await(struct board *b, const uint32_t *word, uint32_t value)
{
    for (int i = 0; word_read(word) != value; i++) {
        if (b->pid == 0 || i == PATIENCE_MS || waitpid(b->pid, NULL, WNOHANG) == b->pid)
            return false;
        nanosleep(&(struct timespec){.tv_nsec = i < 20 ? 50000 : 1000000}, NULL);
    }
    return true;
}

static bool post(struct board *b, enum hal_usb_event event)
{
    struct mailbox *m = b->mailbox;
    m->event = event;
    word_write(&m->posted, m->posted + 1);
    return await(b, &m->handled, m->posted);
}

static bool plug(void *ctx)
{
    struct board *b = ctx;
    memset(b->mailbox, 0, sizeof *b->mailbox);
    b->pid = fork();
    if (b->pid < 0)
        die(EXIT_INTERNAL, "fork: %s", strerror(errno));
    if (b->pid == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        execvp(b->command[0], b->command);
        _exit(127);
    }
    return await(b, &b->mailbox->ready, MAILBOX_READY) && post(b, HAL_USB_RESET);
}

static void unplug(void *ctx)
{
    struct board *b = ctx;
    kill(b->pid, SIGKILL);
    waitpid(b->pid, NULL, 0);
    b->pid = 0;
}

static void reset(void *ctx)
{
    post(ctx, HAL_USB_RESET);
}

static int setup(void *ctx, const uint8_t packet[8])
{
    struct board *b = ctx;
    memcpy(b->mailbox->setup, packet, sizeof b->mailbox->setup);
    return post(b, HAL_USB_SETUP) ? 0 : SIM_GONE;
}

static struct mailbox_buffer *buffer_of(struct board *b, uint8_t endpoint)
{
    return &b->mailbox->buffers[(endpoint & 0x7f ? MAILBOX_BULK_OUT : MAILBOX_CONTROL_OUT) + (endpoint >> 7)];
}

static int out(void *ctx, uint8_t endpoint, const void *data, size_t bytes)
{
    struct board *b = ctx;
    struct mailbox_buffer *q = buffer_of(b, endpoint);
    size_t sent = 0;
    if (b->pid == 0)
        return SIM_GONE;
    if (word_read(&q->stalled))
        return SIM_STALL;
    do {
        size_t n = bytes - sent < MAILBOX_PACKET_BYTES ? bytes - sent : MAILBOX_PACKET_BYTES;
        uint32_t put = q->put;
        if (put - word_read(&q->taken) == MAILBOX_PACKETS)
            return sent ? (int)sent : SIM_NAK;
        if (n)
            memcpy(q->data[put % MAILBOX_PACKETS], (const uint8_t *)data + sent, n);
        q->bytes[put % MAILBOX_PACKETS] = (uint32_t)n;
        word_write(&q->put, put + 1);
        sent += n;
    } while (sent < bytes);
    return (int)sent;
}

static int in(void *ctx, uint8_t endpoint, void *data, size_t max)
{
    struct board *b = ctx;
    struct mailbox_buffer *q = buffer_of(b, endpoint);
    uint32_t taken = q->taken;
    if (b->pid == 0)
        return SIM_GONE;
    if (word_read(&q->stalled))
        return SIM_STALL;
    if (word_read(&q->put) == taken)
        return SIM_NAK;
    size_t bytes = q->bytes[taken % MAILBOX_PACKETS];
    if (bytes > max)
        return SIM_OVERFLOW;
    if (bytes)
        memcpy(data, q->data[taken % MAILBOX_PACKETS], bytes);
    word_write(&q->taken, taken + 1);
    return (int)bytes;
}

static void rest(void *ctx, bool resting)
{
    const struct board *b = ctx;
    if (b->pid)
        kill(b->pid, resting ? SIGSTOP : SIGCONT);
}

struct port port_mailbox(const char *file, char **command)
{
    struct board *b = xcalloc(1, sizeof *b);
    int f = open(file, O_RDWR);
    b->mailbox = f < 0 ? MAP_FAILED
                       : mmap(NULL, sizeof *b->mailbox, PROT_READ | PROT_WRITE, MAP_SHARED, f, (off_t)MAILBOX_OFFSET);
    if (b->mailbox == MAP_FAILED)
        die(EXIT_FILE, "%s: %s; give the file that backs the board's external memory", file, strerror(errno));
    close(f);
    b->command = command;
    return (struct port){b, false, plug, unplug, reset, setup, out, in, run, rest};
}
