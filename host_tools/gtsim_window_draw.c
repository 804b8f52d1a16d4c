#include "gtsim_window_draw.h"

#include <stdlib.h>
#include <string.h>

#include "common.h"

#define HEAT_ALPHA 144 /* of 255: the picture stays visible below */
#define STALE      80  /* of 255 */

static _Noreturn void sdl_die(const char *what)
{
    die(EXIT_INTERNAL, "%s: %s", what, SDL_GetError());
}

static int zoom_of_screen(int width, int height)
{
    SDL_Rect screen;
    if (SDL_GetDisplayUsableBounds(0, &screen))
        return 1;
    int across = screen.w * 3 / 4 / width, down = screen.h * 3 / 4 / height, zoom = across < down ? across : down;
    return zoom ? zoom : 1;
}

void screen_open(struct screen *w, int width, int height, int zoom)
{
    SDL_SetHint(SDL_HINT_FRAMEBUFFER_ACCELERATION, "0"); /* no GPU is needed, and /dev is a mocked one */
    SDL_SetHint(SDL_HINT_NO_SIGNAL_HANDLERS, "1");
    SDL_SetHint(SDL_HINT_VIDEO_ALLOW_SCREENSAVER, "1");
    if (SDL_Init(SDL_INIT_VIDEO))
        sdl_die("no screen");
    if (!getenv("SDL_VIDEODRIVER") && !strcmp(SDL_GetCurrentVideoDriver(), "offscreen")) /* SDL's last resort */
        die(EXIT_INTERNAL, "no screen; set DISPLAY or WAYLAND_DISPLAY, or use gtsim render");
    w->zoom = zoom ? zoom : zoom_of_screen(width, height);
    w->window = SDL_CreateWindow("gtsim", SDL_WINDOWPOS_CENTERED, SDL_WINDOWPOS_CENTERED, width * w->zoom,
                                 height * w->zoom, SDL_WINDOW_RESIZABLE);
    if (!w->window)
        sdl_die("window");
    SDL_SetWindowMinimumSize(w->window, width, height);
    SDL_Surface *surface = SDL_GetWindowSurface(w->window);
    w->frame = surface ? SDL_CreateRGBSurfaceWithFormat(0, width, height, 0, surface->format->format) : NULL;
    if (!w->frame)
        sdl_die("window");
}

void screen_close(struct screen *w)
{
    SDL_FreeSurface(w->frame);
    w->frame = NULL;
    if (w->window)
        SDL_DestroyWindow(w->window);
    w->window = NULL;
    SDL_Quit();
}

/* Blue, cyan, green, yellow, red for 0 to 1. */
static uint32_t heat_colour(const SDL_PixelFormat *format, double heat)
{
    double c[3];
    for (int i = 0; i < 3; i++) {
        double x = 1.5 - SDL_fabs(4 * heat - (3 - i));
        c[i] = 255 * SDL_clamp(x, 0, 1);
    }
    return SDL_MapRGBA(format, (uint8_t)c[0], (uint8_t)c[1], (uint8_t)c[2], HEAT_ALPHA);
}

/* One pixel per tile, enlarged onto the picture. */
static void draw_costs(SDL_Surface *frame, const struct tile_costs *costs)
{
    SDL_Surface *heat = SDL_CreateRGBSurfaceWithFormat(0, costs->across, costs->down, 32, SDL_PIXELFORMAT_ARGB8888);
    SDL_Rect to = {0, 0, costs->across * costs->width, costs->down * costs->height};
    if (!heat)
        sdl_die("overlay");
    for (int y = 0; y < costs->down; y++)
        for (int x = 0; x < costs->across; x++) {
            uint32_t ticks = costs->ticks[y * costs->across + x];
            double share = costs->full ? (double)ticks / costs->full : 0;
            SDL_Rect tile = {x, y, 1, 1};
            SDL_FillRect(heat, &tile, heat_colour(heat->format, share < 1 ? share : 1));
        }
    if (SDL_BlitScaled(heat, NULL, frame, &to))
        sdl_die("overlay");
    SDL_FreeSurface(heat);
}

void screen_draw(struct screen *w, const uint8_t *rgb, bool stale, const struct tile_costs *costs)
{
    SDL_Surface *frame = w->frame,
                *surface = SDL_GetWindowSurface(w->window); /* anew: the window may have another size */
    SDL_Surface *picture = SDL_CreateRGBSurfaceWithFormatFrom((void *)(uintptr_t)rgb, frame->w, frame->h, 24,
                                                              3 * frame->w, SDL_PIXELFORMAT_RGB24);
    if (!surface || !picture)
        sdl_die("window");
    if (stale)
        SDL_SetSurfaceColorMod(picture, STALE, STALE, STALE);
    if (SDL_BlitSurface(picture, NULL, frame, NULL))
        sdl_die("window");
    SDL_FreeSurface(picture);
    if (costs)
        draw_costs(frame, costs);
    int across = surface->w / frame->w, down = surface->h / frame->h;
    w->zoom = SDL_max(1, SDL_min(across, down));
    SDL_Rect to = {(surface->w - frame->w * w->zoom) / 2, (surface->h - frame->h * w->zoom) / 2, frame->w * w->zoom,
                   frame->h * w->zoom};
    if (SDL_FillRect(surface, NULL, SDL_MapRGB(surface->format, 32, 32, 32)) ||
        SDL_BlitScaled(frame, NULL, surface, &to) || SDL_UpdateWindowSurface(w->window))
        sdl_die("window");
}

void screen_title(struct screen *w, const char *text)
{
    if (strcmp(SDL_GetWindowTitle(w->window), text))
        SDL_SetWindowTitle(w->window, text);
}
