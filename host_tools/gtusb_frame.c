/* `frame`: the device renders and streams its tiles; the picture is put together here. */
#include "gtusb.h"

#include <string.h>

#include "host_canvas.h"
#include "host_image.h"

static error_t parse_option(int key, char *arg, struct argp_state *state)
{
    switch (key) {
    case 'o':
        *(const char **)state->input = arg;
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static _Noreturn void frame_bad_tile(const struct usb_tile *t)
{
    die(EXIT_USB, "tile of %u x %u pixels at (%u, %u) does not fit the picture; update the firmware", t->width,
        t->height, t->x, t->y);
}

/* Receives tiles until the last one. */
static void frame_receive(struct link *l, struct canvas *c)
{
    struct reply r;
    struct usb_tile t;
    uint64_t total = c->missing;
    for (;;) {
        link_receive(l, &r);
        if (r.status != USB_OK)
            reply_refuse(&r, NULL);
        if (r.length < sizeof t)
            die(EXIT_USB, "tile of %u bytes, %zu are the least; update the firmware", r.length, sizeof t);
        memcpy(&t, r.payload, sizeof t);
        if (t.flags & USB_TILE_LAST)
            return;
        if (r.length != sizeof t + (size_t)t.width * t.height * canvas_pixel_bytes(c->format) ||
            !canvas_put(c, t.x, t.y, t.width, t.height, r.payload + sizeof t))
            frame_bad_tile(&t);
        progress("frame", total - c->missing, total);
        if (link_interrupted()) { /* the next host that opens the device drops the rest of the frame */
            device_close(l);
            link_end_interrupted();
        }
        link_expect_more(l);
    }
}

void command_frame(int argc, char **argv)
{
    static const struct argp_option options[] = {{"output", 'o', "FILE", 0, "the picture (PNG)", 0}, {0}};
    static const struct argp argp = {options,
                                     parse_option,
                                     NULL,
                                     "Lets the device render a frame and stream its tiles, and writes the picture."
                                     "\vExamples:\n"
                                     "  $ gtusb frame -o frame.png",
                                     device_options,
                                     NULL,
                                     NULL};
    const char *output = NULL;
    struct usb_info info;
    struct canvas canvas;
    options_parse(&argp, argc, argv, &output);
    if (!output)
        die(EXIT_USAGE, "no output file; give -o FILE.png");
    image_need(output, ".png"); /* before the device renders */
    struct link *l = device_open(&info);
    canvas_init(&canvas, info.width, info.height, info.format);
    link_set_patience(l, 6);
    link_send(l, USB_MSG_FRAME, NULL, 0);
    frame_receive(l, &canvas);
    device_close(l);
    if (link_interrupted())
        link_end_interrupted();
    if (canvas.missing)
        die(EXIT_USB, "the frame ended with %u of %u pixels missing; try again", canvas.missing,
            (unsigned)canvas.width * canvas.height);
    image_write_u8(output, canvas.width, canvas.height, 3, canvas.rgb);
    canvas_free(&canvas);
}
