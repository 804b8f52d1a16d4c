/*
 * `window`: the simulated device's picture in a window, moved by mouse and keys, while a program started here uses the device through its
 * USB. The window is a second host: it sends requests between those of the program.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "gtsim.h"
#include "gtsim_device.h"
#include "gtsim_run.h"
#include "gtsim_window_draw.h"
#include "gtsim_window_view.h"
#include "host_canvas.h"
#include "host_image.h"
#include "host_model.h"

#define MAX_ZOOM   16
#define EYE_STEP   5.0  /* degrees per arrow key */
#define LIGHT_STEP 15.0 /* degrees */
#define NEARER     0.9
#define DRAG_TURN  180.0 /* degrees for a drag across the picture */

#define KEYS                                                                                                           \
    "  drag, arrows  turn the eye around the scene\n"                                                                  \
    "  wheel, page up/down  distance\n"                                                                                \
    "  m, M   next, previous material is the selected one\n"                                                           \
    "  t, T   its next, previous table slot\n"                                                                         \
    "  n, N   next, previous model; the first is: as the scene says\n"                                                 \
    "  e, E   longer, shorter exposure, by a third of a stop\n"                                                        \
    "  1...9  light on or off\n"                                                                                       \
    "  l, L   turn all lights by 15 degrees to the left, right\n"                                                      \
    "  c      what each tile cost: blue little, red as much as the dearest\n"                                          \
    "  p      write the picture to the next free gtsim-NNNN.png\n"                                                     \
    "  r      forget what was set (RESET)\n"                                                                           \
    "  h      print this\n"                                                                                            \
    "  q      quit\n"

struct window {
    struct bus_options bus;
    struct device_content content;
    const char *screenshots, *record; /* folders; record: NULL for none */
    int zoom;                         /* 0: as fits */

    struct view view;
    struct screen screen;
    struct canvas canvas; /* the last frame */
    char *refusal;        /* why the device has refused another one since, or NULL */
    double seconds;       /* that it took here */
    struct usb_stats stats;
    uint32_t *ticks; /* of its stats.tile_count tiles */
    unsigned recorded;
    bool costs, changed, redraw, quit;
};

static double seconds_now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + (double)t.tv_nsec * 1e-9;
}

/* --- frames --- */

static void picture_write(const struct canvas *c, char *path)
{
    image_write_u8(path, c->width, c->height, 3, c->rgb);
    free(path);
}

static void screenshot(const struct window *w)
{
    char *path = NULL;
    for (unsigned i = 1; !path || !access(path, F_OK); i++) {
        free(path);
        path = xasprintf("%s/gtsim-%04u.png", w->screenshots, i);
    }
    picture_write(&w->canvas, path);
}

/* What the last frame cost. */
static void stats_fetch(struct window *w)
{
    struct sim_device *d = w->view.device;
    struct usb_stats_request want = {1};
    struct usb_header h;
    struct {
        struct usb_stats head;
        struct usb_tile_stats tiles[];
    } * reply;
    size_t bytes = sizeof *reply + d->config.tile_stats_count * sizeof *reply->tiles;
    reply = xmalloc(bytes);
    if (!sim_device_request(d, USB_MSG_STATS, &want, sizeof want, &h, reply, bytes) || h.status != USB_OK)
        die(EXIT_INTERNAL, "the simulated device has no statistics");
    w->stats = reply->head;
    for (uint32_t i = 0; i < reply->head.tile_count; i++)
        w->ticks[i] = reply->tiles[i].ticks;
    free(reply);
}

/* Asks for a frame. One that differs from the one before is recorded. */
static void frame_fetch(struct window *w)
{
    const struct sim_config *board = sim_configuration(w->view.device->board);
    struct canvas next;
    struct usb_header h;
    canvas_init(&next, board->width, board->height, board->format);
    size_t bytes = 3 * (size_t)next.width * next.height;
    uint8_t *pixels = xmalloc(bytes);
    double start = seconds_now();
    if (!sim_device_frame(w->view.device, pixels, &h))
        die(EXIT_INTERNAL, "the simulated device does not answer");
    free(w->refusal);
    w->refusal = device_refusal(w->view.device, h.status, h.detail);
    if (w->refusal) {
        canvas_free(&next);
    } else {
        w->seconds = seconds_now() - start;
        canvas_put(&next, 0, 0, next.width, next.height, pixels);
        bool same = w->recorded && !memcmp(next.rgb, w->canvas.rgb, bytes);
        canvas_free(&w->canvas);
        w->canvas = next;
        stats_fetch(w);
        if (w->record && !same)
            picture_write(&w->canvas, xasprintf("%s/frame-%06u.png", w->record, ++w->recorded));
    }
    free(pixels);
}

/* --- what the window shows --- */

static uint32_t dearest(const struct window *w)
{
    uint32_t most = 0;
    for (uint32_t i = 0; i < w->stats.tile_count; i++)
        most = w->ticks[i] > most ? w->ticks[i] : most;
    return most;
}

static void window_draw(struct window *w)
{
    int scale = w->bus.board.samples == 4 ? 2 : 1; /* a tile is one of samples */
    struct tile_costs costs = {.ticks = w->ticks,
                               .width = RASTER_TILE_WIDTH / scale,
                               .height = RASTER_TILE_HEIGHT / scale,
                               .full = dearest(w)};
    costs.across = (w->canvas.width + costs.width - 1) / costs.width;
    costs.down = (w->canvas.height + costs.height - 1) / costs.height;
    screen_draw(&w->screen, w->canvas.rgb, w->refusal, w->costs && w->stats.tile_count ? &costs : NULL);
    char *state = view_text(&w->view), *dear = xstrdup("");
    if (w->costs)
        dear = xasprintf(", dearest tile %.3f M", 1e-6 * costs.full);
    char *title = w->refusal ? xasprintf("gtsim | %s | %s", state, w->refusal)
                             : xasprintf("gtsim | %s | %.1f M ticks%s | %.1f ms, %.0f fps", state,
                                         1e-6 * w->stats.total.ticks, dear, 1e3 * w->seconds, 1 / w->seconds);
    screen_title(&w->screen, title);
    free(title);
    free(dear);
    free(state);
}

/* --- keys and mouse --- */

static void key_pressed(struct window *w, SDL_Keycode key, int by)
{
    w->changed = true;
    switch (key) {
    case SDLK_LEFT:
    case SDLK_RIGHT:
        view_orbit(&w->view, key == SDLK_LEFT ? -EYE_STEP : EYE_STEP, 0);
        break;
    case SDLK_UP:
    case SDLK_DOWN:
        view_orbit(&w->view, 0, key == SDLK_UP ? EYE_STEP : -EYE_STEP);
        break;
    case SDLK_PAGEUP:
    case SDLK_PAGEDOWN:
        view_distance(&w->view, key == SDLK_PAGEUP ? NEARER : 1 / NEARER);
        break;
    case SDLK_m:
        view_material(&w->view, by);
        break;
    case SDLK_t:
        view_slot(&w->view, by);
        break;
    case SDLK_n:
        view_model(&w->view, by);
        break;
    case SDLK_e:
        view_exposure(&w->view, by);
        break;
    case SDLK_l:
        view_turn_lights(&w->view, by * LIGHT_STEP);
        break;
    case SDLK_r:
        view_reset(&w->view);
        break;
    default:
        if (key >= SDLK_1 && key <= SDLK_9)
            view_light(&w->view, (uint32_t)(key - SDLK_1));
    }
}

/* Keys that do not ask anything of the device. */
static void key_of_window(struct window *w, SDL_Keycode key)
{
    switch (key) {
    case SDLK_c:
        w->costs = !w->costs;
        w->redraw = true;
        break;
    case SDLK_p:
        screenshot(w);
        break;
    case SDLK_h:
        fputs(KEYS, stderr);
        break;
    case SDLK_q:
        w->quit = true;
        break;
    default:
        break;
    }
}

static void event_serve(struct window *w, const SDL_Event *e)
{
    switch (e->type) {
    case SDL_QUIT:
        w->quit = true;
        break;
    case SDL_WINDOWEVENT:
        w->redraw = true;
        break;
    case SDL_KEYDOWN:
        if (e->key.keysym.mod & (KMOD_CTRL | KMOD_ALT | KMOD_GUI))
            break;
        key_pressed(w, e->key.keysym.sym, e->key.keysym.mod & KMOD_SHIFT ? -1 : 1);
        if (!e->key.repeat)
            key_of_window(w, e->key.keysym.sym);
        break;
    case SDL_MOUSEWHEEL:
        view_distance(&w->view, e->wheel.y > 0 ? NEARER : 1 / NEARER);
        w->changed = true;
        break;
    case SDL_MOUSEMOTION:
        if (e->motion.state & SDL_BUTTON_LMASK) {
            double turn = DRAG_TURN / (w->canvas.width * w->screen.zoom);
            view_orbit(&w->view, -turn * e->motion.xrel, turn * e->motion.yrel);
            w->changed = true;
        }
        break;
    default:
        break;
    }
}

static bool window_step(void *ctx, bool used)
{
    struct window *w = ctx;
    SDL_Event e;
    w->changed |= used;
    while (SDL_PollEvent(&e))
        event_serve(w, &e);
    if (w->quit) {
        screen_close(&w->screen);
        return false;
    }
    if (w->changed)
        frame_fetch(w);
    if (w->changed || w->redraw)
        window_draw(w);
    w->changed = w->redraw = false;
    return true;
}

/* --- start --- */

enum { KEY_SCREENSHOTS = 1000, KEY_RECORD, KEY_ZOOM };

static error_t parse_option(int key, char *arg, struct argp_state *state)
{
    struct window *w = state->input;
    switch (key) {
    case ARGP_KEY_INIT:
        state->child_inputs[0] = &w->content;
        state->child_inputs[1] = &w->bus;
        return 0;
    case KEY_SCREENSHOTS:
        w->screenshots = arg;
        return 0;
    case KEY_RECORD:
        w->record = arg;
        return 0;
    case KEY_ZOOM:
        w->zoom = (int)parse_long("--zoom", arg, 1, MAX_ZOOM);
        return 0;
    case ARGP_KEY_ARG:
        if (state->quoted && state->next > state->quoted)
            return ARGP_ERR_UNKNOWN; /* the program, after -- */
        if (w->content.scene)
            die(EXIT_USAGE, "'%s': a second scene; a program goes after --", arg);
        w->content.scene = arg;
        return 0;
    case ARGP_KEY_SUCCESS:
        if (!w->bus.devices)
            die(EXIT_USAGE, "--devices: 0, but a window shows one");
        return 0;
    default:
        return ARGP_ERR_UNKNOWN;
    }
}

static void folder_check(const char *path)
{
    struct stat s;
    if (stat(path, &s) || !S_ISDIR(s.st_mode) || access(path, W_OK))
        die(EXIT_FILE, "%s: %s; give a folder that can be written", path, errno ? strerror(errno) : "not a folder");
}

int command_window(int argc, char **argv)
{
    static const struct argp_option options[] = {
        {"screenshot-dir", KEY_SCREENSHOTS, "FOLDER", 0, "where the key p writes pictures (the current folder)", 0},
        {"record", KEY_RECORD, "FOLDER", 0, "write each frame that differs from the one before: frame-NNNNNN.png", 0},
        {"zoom", KEY_ZOOM, "N", 0, "window pixels per pixel, 1 to 16 (as fits the screen)", 0},
        {0}};
    static const struct argp_child children[] = {{&content_argp, 0, NULL, 0}, {&bus_argp, 0, "The device:", 2}, {0}};
    static const struct argp argp = {
        options,
        parse_option,
        "[SCENE] [-- PROGRAM [ARGUMENT...]]",
        "Shows the simulated device's picture in a window. PROGRAM, often $SHELL, and whatever it starts see the "
        "device "
        "as with 'gtsim run': what 'gtusb push' or 'gtusb set' changes appears. Ends with PROGRAM's exit code; without "
        "PROGRAM, or when closed, with 0.\vKeys:\n" KEYS "\nExamples:\n"
        "  $ gtsim window six_models.blob --model lafortune_phong\n"
        "  $ gtsim window oled.blob --table 0=gold.ktx2 -- $SHELL",
        children,
        NULL,
        NULL};
    struct window w = {.bus = bus_default(), .content.model = MODEL_OF_SCENE, .screenshots = ".", .changed = true};
    int first;
    w.bus.board.arena_bytes = DEVICE_ARENA_BYTES;
    options_parse(&argp, ARGP_IN_ORDER, argc, argv, &first, &w);
    folder_check(w.screenshots);
    if (w.record && (mkdir(w.record, 0777) == 0 || errno == EEXIST))
        errno = 0;
    if (w.record)
        folder_check(w.record);
    bus_preload("window", argv);
    struct bus *b = bus_create(&w.bus);
    struct sim_device *d = w.view.device = bus_device(b, 0);
    const struct sim_config *board = sim_configuration(d->board);
    device_load(d, &w.content);
    w.ticks = xcalloc(d->config.tile_stats_count, sizeof *w.ticks);
    canvas_init(&w.canvas, board->width, board->height, board->format);
    screen_open(&w.screen, board->width, board->height, w.zoom);
    fputs("keys:\n" KEYS, stderr);
    int code = bus_run(b, argv + first, &(struct bus_host){window_step, &w});
    canvas_free(&w.canvas);
    free(w.refusal);
    free(w.ticks);
    return code;
}
