/*
 * Counts what shading takes on an emulated board, exactly, for the input at board_input (sphere.h):
 *   instructions     by which lights make sphere_shade dearer: blocks and their set-up, and the model
 *   lit              pixel-lights with n.l > 0 and n.v > 0
 *   per_pixel_light  one by the other
 *   hash             FNV-1a of all radiances
 *   shaded           pixel-lights that the rasterizer says it evaluated
 *   covered, gather  pixels, and instructions for each that shading takes without lights: finding and gathering them, storing what
 *                    was shaded; tone curve and packing are in neither
 */
#include "board.h"
#include "sphere.h"

static struct sphere sphere;
static uint32_t hash = REPORT_HASH_START;
static bool hashing;
static uint32_t shaded; /* of all pictures */

void sphere_radiance(uint32_t *out, uq12_20_t radiance[][3], uint32_t count)
{
    (void)out; /* whatever is there */
    if (hashing)
        hash = report_hash(hash, radiance, count * sizeof *radiance);
}

/* Instructions of all tiles, shaded or only made. Out of line, so that the clock's readings stay around it. */
__attribute__((noinline)) static uint32_t picture(bool shade)
{
    const uint32_t start = board_clock();
    for (uint32_t i = 0; i < SPHERE_TILES; i++) {
        struct raster_stats stats = {0};
        sphere_fill(&sphere, i);
        if (shade)
            sphere_shade(&sphere, &stats);
        shaded += stats.shaded;
    }
    return board_clock() - start;
}

static void checked(const char *wrong)
{
    if (wrong)
        report_failure(wrong);
}

/* To one decimal. */
static void report_ratio(const char *label, uint32_t a, uint32_t b)
{
    report_number(label, a / b);
    report_text((const char[]){'.', (char)('0' + a % b * 10 / b), 0}); /* b < 2^28 */
}

_Noreturn void board_main(void)
{
    uint32_t covered = 0, lit = 0;
    checked(sphere_open(&sphere, board_input));
    for (uint32_t i = 0; i < SPHERE_TILES; i++) {
        sphere_fill(&sphere, i);
        sphere_count(&sphere, &covered, &lit);
    }
    hashing = true;
    picture(true);
    hashing = false;
    const uint32_t evaluated = shaded;
    const uint32_t bright = picture(true), fill = picture(false);
    checked(sphere_begin(&sphere, false));
    const uint32_t dark = picture(true);
    report_text("shade");
    report_number("instructions", bright - dark);
    report_number("lit", lit);
    report_ratio("per_pixel_light", bright - dark, lit);
    report_hex("hash", hash);
    report_number("shaded", evaluated);
    report_number("covered", covered);
    report_ratio("gather", dark - fill, covered);
    report_text("\n");
    board_exit(BOARD_EXIT_OK);
}
