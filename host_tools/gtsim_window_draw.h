/* The window itself: a picture at integer zoom in the middle, and over it, if wanted, a colour for each tile. */
#ifndef HOST_TOOLS_GTSIM_WINDOW_DRAW_H
#define HOST_TOOLS_GTSIM_WINDOW_DRAW_H

#if !__has_include(<SDL.h>)
#error "gtsim window needs SDL 2: install libsdl2-dev ('make deps-demo' does), or its equivalent, then make again"
#endif
#include <SDL.h>
#include <stdbool.h>
#include <stdint.h>

struct screen {
    SDL_Window *window;
    SDL_Surface *frame; /* the picture, with the overlay, in the window's pixel format */
    int zoom;           /* window pixels per pixel, as drawn last */
};

/* A colour for each of the tiles that cover a picture row by row. */
struct tile_colours {
    const uint8_t *rgb; /* of `across` * `down` tiles */
    int across, down;
    int width, height; /* of a tile, picture pixels; those at the right and bottom edge may stick out */
};

/* zoom 0: the largest at which the window takes three quarters of the screen. Dies with EXIT_INTERNAL when there is no screen. */
void screen_open(struct screen *w, int width, int height, int zoom);
/* Once more does nothing. */
void screen_close(struct screen *w);

/* rgb: width * height * 3 bytes. `stale`: darker, since it is not what the device would show. tiles: laid over it, or NULL. */
void screen_draw(struct screen *w, const uint8_t *rgb, bool stale, const struct tile_colours *tiles);

void screen_title(struct screen *w, const char *text);

#endif
