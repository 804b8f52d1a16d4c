#include "gtsim_window_draw.h"

#include <stdlib.h>
#include <string.h>

#include "common.h"

#define TILE_ALPHA 178 /* of 255: the picture stays visible below */
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
        die(EXIT_NO_DEVICE, "no screen: %s; set DISPLAY or WAYLAND_DISPLAY, or use gtsim render", SDL_GetError());
    if (!getenv("SDL_VIDEODRIVER") && !strcmp(SDL_GetCurrentVideoDriver(), "offscreen")) /* SDL's last resort */
        die(EXIT_NO_DEVICE, "no screen; set DISPLAY or WAYLAND_DISPLAY, or use gtsim render");
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

/* One pixel per tile, enlarged onto the picture. */
static void draw_tiles(SDL_Surface *frame, const struct tile_colours *tiles)
{
    SDL_Surface *colours = SDL_CreateRGBSurfaceWithFormat(0, tiles->across, tiles->down, 32, SDL_PIXELFORMAT_ARGB8888);
    SDL_Rect to = {0, 0, tiles->across * tiles->width, tiles->down * tiles->height};
    if (!colours)
        sdl_die("overlay");
    for (int i = 0; i < tiles->across * tiles->down; i++) {
        const uint8_t *c = tiles->rgb + 3 * i;
        SDL_Rect tile = {i % tiles->across, i / tiles->across, 1, 1};
        SDL_FillRect(colours, &tile, SDL_MapRGBA(colours->format, c[0], c[1], c[2], TILE_ALPHA));
    }
    if (SDL_BlitScaled(colours, NULL, frame, &to))
        sdl_die("overlay");
    SDL_FreeSurface(colours);
}

void screen_draw(struct screen *w, const uint8_t *rgb, bool stale, const struct tile_colours *tiles)
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
    if (tiles)
        draw_tiles(frame, tiles);
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
