/*
 * `window`: the simulated device's picture in a window, moved by mouse and keys, while a program started here uses the device through its
 * USB. The window is a second host: it sends requests between those of the program.
 */
#define _GNU_SOURCE
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "gtsim.h"
#include "gtsim_device.h"
#include "gtsim_heatmap.h"
#include "gtsim_run.h"
#include "gtsim_window_draw.h"
#include "gtsim_window_frame.h"
#include "gtsim_window_rate.h"
#include "gtsim_window_view.h"
#include "host_model.h"

#define MAX_ZOOM   16
#define EYE_STEP   5.0  /* degrees per arrow key */
#define LIGHT_STEP 15.0 /* degrees */
#define NEARER     0.9
#define DRAG_TURN  180.0 /* degrees for a drag across the picture */

#define KEYS                                                                                                           \
    "  drag, arrows  turn the eye around the scene\n"                                                                  \
    "  wheel         distance; also page up and page down\n"                                                           \
    "  m, M          next, previous material is the selected one\n"                                                    \
    "  t, T          next, previous table slot with a table for it\n"                                                  \
    "  n, N          next, previous model for all materials: as the scene says,\n"                                     \
    "                measured, Lafortune-Phong, Blinn-Phong, metallic-roughness\n"                                     \
    "  e, E          longer, shorter exposure, by a third of a stop\n"                                                 \
    "  1 to 9        light on or off\n"                                                                                \
    "  l, L          turn all lights by 15 degrees to the right, left\n"                                               \
    "  b, B          smaller, larger budget of ticks per tile; the largest is no limit\n"                              \
    "  s, S          coarser, finer rate of shading for all surfaces, without a budget:\n"                             \
    "                1x1, 2x1, 2x2, 4x2, 4x4, flat\n"                                                                  \
    "  c             lays over the picture what each tile took: ticks, rate of shading,\n"                             \
    "                predicted error, nothing; dark blue is 0\n"                                                       \
    "  p             write the picture to the next free gtsim-NNNN.png\n"                                              \
    "  r             forget what was set\n"                                                                            \
    "  h             print the keys\n"                                                                                 \
    "  q             quit\n"

struct window {
    struct bus_options bus;
    struct device_content content;
    const char *screenshots; /* folder */
    int zoom;                /* 0: as fits */

    struct view view;
    struct screen screen;
    struct frame frame;
    int panel; /* of what tiles took, laid over the picture; -1: none */
    bool changed, redraw, quit;
    int learning; /* frames of what does not change, for budgets to settle */
};

/* Asks for a frame if there may be a new one. */
static void window_update(struct window *w)
{
    const uint32_t *budget = &w->frame.stats.tile_budget;
    if (!w->changed && !w->learning)
        return;
    frame_fetch(&w->frame);
    w->learning = !w->changed ? w->learning - 1 : *budget && *budget != RATE_BUDGET ? LEARNING_FRAMES : 0;
    w->changed = false;
    w->redraw = true;
}

/* --- what the window shows --- */

/* `grey`: so that colours on it keep their meaning. */
static uint8_t *picture_copy(const struct canvas *c, bool grey)
{
    size_t bytes = 3 * (size_t)c->width * c->height;
    uint8_t *rgb = memcpy(xmalloc(bytes), c->rgb, bytes);
    for (size_t i = 0; grey && i < bytes; i += 3)
        memset(rgb + i, (rgb[i] + 2 * rgb[i + 1] + rgb[i + 2]) / 4, 3);
    return rgb;
}

static void picture_draw(struct window *w)
{
    const struct frame *f = &w->frame;
    const int scale = w->bus.board.samples == 4 ? 2 : 1; /* a tile is one of samples */
    const uint32_t count = w->panel >= 0 ? f->stats.tile_count : 0;
    uint8_t *rgb = xmalloc(3 * count);
    struct tile_colours tiles = {rgb, 0, 0, RASTER_TILE_WIDTH / scale, RASTER_TILE_HEIGHT / scale};
    tiles.across = (f->canvas.width + tiles.width - 1) / tiles.width;
    tiles.down = (f->canvas.height + tiles.height - 1) / tiles.height;
    for (uint32_t i = 0; i < count; i++)
        heatmap_colour(rgb + 3 * i, heatmap_value(&f->tiles[i], w->panel) / heatmap_most(f->tiles, count, w->panel));
    uint8_t *picture = picture_copy(&f->canvas, count > 0);
    screen_draw(&w->screen, picture, f->refusal, count ? &tiles : NULL);
    free(picture);
    free(rgb);
}

static void title_show(struct window *w)
{
    const struct frame *f = &w->frame;
    char *title, *state = view_text(&w->view);
    size_t bytes;
    FILE *out = open_memstream(&title, &bytes);
    if (!out)
        die(EXIT_INTERNAL, "out of memory");
    fprintf(out, "gtsim | %s", state);
    if (f->refusal) {
        fprintf(out, " | %s", f->refusal);
    } else {
        fprintf(out, " | %.1f M ticks, dearest tile %.3f M", 1e-6 * f->stats.total.ticks,
                1e-6 * heatmap_most(f->tiles, f->stats.tile_count, HEATMAP_TICKS));
        if (f->stats.tile_budget == RATE_BUDGET)
            fprintf(out, ", all surfaces at rate %s", rate_name(rate_now()));
        else if (f->stats.tile_budget)
            fprintf(out, ", budget %.3f M: %u of %u tiles reduced", 1e-6 * f->stats.tile_budget, f->stats.tiles_reduced,
                    f->stats.tile_count);
        fprintf(out, " | %.1f ms, %.0f fps", 1e3 * f->seconds, 1 / f->seconds);
        if (w->panel >= 0)
            fprintf(out, " | %s, bright is %.4g", heatmap_name(w->panel),
                    heatmap_most(f->tiles, f->stats.tile_count, w->panel));
    }
    fclose(out);
    screen_title(&w->screen, title);
    free(title);
    free(state);
}

static void window_draw(struct window *w)
{
    picture_draw(w);
    title_show(w);
}

/* --- keys and mouse --- */

/* Keys that ask something of the device. */
static void key_of_device(struct window *w, SDL_Keycode key, int by)
{
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
    case SDLK_b:
        window_update(w); /* goes by what tiles take now */
        view_budget(&w->view, -by, &w->frame.stats);
        break;
    case SDLK_s:
        view_rate(&w->view, by);
        break;
    case SDLK_l:
        view_turn_lights(&w->view, by * LIGHT_STEP);
        break;
    case SDLK_r:
        view_reset(&w->view);
        break;
    default:
        if (key < SDLK_1 || key > SDLK_9)
            return;
        view_light(&w->view, (uint32_t)(key - SDLK_1));
    }
    w->changed = true;
}

/* The other ones. */
static void key_of_window(struct window *w, SDL_Keycode key)
{
    switch (key) {
    case SDLK_c:
        w->panel = w->panel + 1 < HEATMAP_PANELS ? w->panel + 1 : -1;
        w->redraw = true;
        break;
    case SDLK_p:
        do
            window_update(w); /* keys before this one may have changed the picture */
        while (w->learning);
        frame_write(&w->frame, w->screenshots);
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
        key_of_device(w, e->key.keysym.sym, e->key.keysym.mod & KMOD_SHIFT ? -1 : 1);
        if (!e->key.repeat)
            key_of_window(w, e->key.keysym.sym);
        break;
    case SDL_MOUSEWHEEL:
        view_distance(&w->view, pow(NEARER, e->wheel.y));
        w->changed = true;
        break;
    case SDL_MOUSEMOTION:
        if (e->motion.state & SDL_BUTTON_LMASK) {
            double turn = DRAG_TURN / (w->frame.canvas.width * w->screen.zoom);
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
        screen_close(&w->screen); /* the program may take its time */
        return false;
    }
    window_update(w);
    if (w->redraw)
        window_draw(w);
    w->redraw = false;
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
        w->frame.record = arg;
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
    if (stat(path, &s) || access(path, W_OK))
        die(EXIT_FILE, "%s: %s; give a folder that can be written", path, strerror(errno));
    if (!S_ISDIR(s.st_mode))
        die(EXIT_FILE, "%s: not a folder; give one that can be written", path);
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
        "device as with 'gtsim run': what 'gtusb push' or 'gtusb set' changes appears. Ends with PROGRAM's exit code; "
        "without PROGRAM, or when closed, with 0.\vKeys:\n" KEYS "\nExamples:\n"
        "  $ gtsim window six_models.blob --model lafortune_phong\n"
        "  $ gtsim window oled.blob --table 0=gold.ktx2 -- $SHELL",
        children,
        NULL,
        NULL};
    struct window w = {
        .bus = bus_default(), .content.model = MODEL_OF_SCENE, .screenshots = ".", .panel = -1, .changed = true};
    int first;
    w.bus.board.arena_bytes = DEVICE_ARENA_BYTES;
    options_parse(&argp, ARGP_IN_ORDER, argc, argv, &first, &w);
    folder_check(w.screenshots);
    if (w.frame.record) {
        mkdir(w.frame.record, 0777); /* or it is there already */
        folder_check(w.frame.record);
    }
    bus_preload("window", argv);
    struct bus *b = bus_create(&w.bus);
    w.view.device = w.frame.device = bus_device(b, 0);
    rate_install(w.view.device);
    device_load(w.view.device, &w.content);
    frame_init(&w.frame);
    screen_open(&w.screen, w.frame.canvas.width, w.frame.canvas.height, w.zoom);
    fputs("keys:\n" KEYS, stderr);
    int code = bus_run(b, argv + first, &(struct bus_host){window_step, &w});
    screen_close(&w.screen);
    frame_free(&w.frame);
    return code;
}
