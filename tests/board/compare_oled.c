/*
 * Compares the emulator's picture of the OLED with the frame that the host rendered.
 *
 *   compare_oled FRAME.rgb SHOT.ppm
 *
 * FRAME: 128 x 64 RGB888. SHOT: a P6 of 512 x 256, each display pixel four by four, its grey 17 times the level. A frame's pixel is the
 * level (77 R + 150 G + 29 B) / 4096. Every pixel of the shot is checked; at least 8 levels must appear.
 */
#include "common.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 128, HEIGHT = 64, SCALE = 4, LEVELS = 16, MIN_LEVELS = 8 };

int main(int argc, char **argv)
{
    static const char head[] = "P6\n512 256\n255\n";
    common_set_name("compare_oled", NULL);
    if (argc != 3)
        die(EXIT_USAGE, "usage: compare_oled FRAME.rgb SHOT.ppm");
    size_t frame_bytes, shot_bytes;
    uint8_t *frame = read_file(argv[1], 1u << 20, &frame_bytes), *shot = read_file(argv[2], 1u << 20, &shot_bytes);
    if (frame_bytes != WIDTH * HEIGHT * 3)
        die(EXIT_BAD_INPUT, "%s: %zu bytes, not %d", argv[1], frame_bytes, WIDTH * HEIGHT * 3);
    if (shot_bytes != sizeof head - 1 + WIDTH * HEIGHT * SCALE * SCALE * 3 || memcmp(shot, head, sizeof head - 1))
        die(EXIT_BAD_INPUT, "%s: not a picture of 512 x 256", argv[2]);
    unsigned different = 0, levels = 0;
    bool seen[LEVELS] = {false};
    for (int y = 0; y < HEIGHT * SCALE; y++)
        for (int x = 0; x < WIDTH * SCALE; x++) {
            const uint8_t *p = frame + (y / SCALE * WIDTH + x / SCALE) * 3;
            const uint8_t *q = shot + sizeof head - 1 + (y * WIDTH * SCALE + x) * 3;
            int level = (77 * p[0] + 150 * p[1] + 29 * p[2]) / 4096;
            seen[level] = true;
            different += q[0] != level * 17 || q[1] != level * 17 || q[2] != level * 17;
        }
    for (int i = 0; i < LEVELS; i++)
        levels += seen[i];
    free(frame);
    free(shot);
    if (different)
        die(EXIT_MISMATCH, "%s: %u of %d pixels differ from the frame", argv[2], different,
            WIDTH * HEIGHT * SCALE * SCALE);
    if (levels < MIN_LEVELS)
        die(EXIT_MISMATCH, "%s: %u grey levels; the frame shows nothing", argv[1], levels);
    printf("equal, %u grey levels\n", levels);
    return EXIT_OK;
}
