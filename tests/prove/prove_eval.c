/* Evaluation: tables of unknown texels, warps and scale, any three directions that lut_eval accepts. */
#include "lut.h"
#include "prove.h"

static uint32_t texels[3 * 4 * 2];
static uint16_t warp_h[LUT_WARP_H_NODES], warp_d[LUT_WARP_D_NODES];

static struct vec3 direction(void)
{
    return (struct vec3){Frama_C_interval(-32832, 32832), Frama_C_interval(-32832, 32832),
                         Frama_C_interval(-32832, 32832)};
}

int main(void)
{
    struct lut_table t = {.kind = Frama_C_interval(0, 1) ? LUT_HALF_VECTOR : LUT_SPECULAR_FRAME,
                          .texels = texels,
                          .width = 3,
                          .height = 4,
                          .depth = 2,
                          .slice_scale = Frama_C_unsigned_int_interval(0, UINT32_MAX),
                          .swap = Frama_C_interval(0, 1),
                          .scale = Frama_C_interval(-16, 16),
                          .warp_h = warp_h,
                          .warp_d = warp_d};
    struct lut_rgb out;
    Frama_C_make_unknown((char *)texels, sizeof texels);
    for (uint32_t i = 0; i < LUT_WARP_H_NODES; i++)
        warp_h[i] = (uint16_t)Frama_C_interval(0, 3 << LUT_WARP_BITS);
    for (uint32_t i = 0; i < LUT_WARP_D_NODES; i++)
        warp_d[i] = (uint16_t)Frama_C_interval(0, 1 << LUT_WARP_BITS);
    lut_eval(&out, &t, direction(), direction(), direction());
    return 0;
}
