/*
 * From vertices to the screen: an object's matrix for this frame, the perspective division, and the view rays.
 */
#include "internal.h"
#include "func.h"

/* A number m * 2^e; |m| < 2^63. */
struct scaled {
    int64_t m;
    int32_t e;
};

/* Bits needed for |x|: 2^(n-1) <= |x| < 2^n; 0 for 0. */
static int32_t bit_length(uint64_t x)
{
    uint32_t hi = (uint32_t)(x >> 32), lo = (uint32_t)x;
    return hi ? 64 - (int32_t)fx_clz(hi) : lo ? 32 - (int32_t)fx_clz(lo) : 0;
}

/* x.m * 2^(x.e + e), rounded to nearest. In: the result is known to fit. */
FX_NOINLINE static int64_t scaled_to_int(struct scaled x, int32_t e)
{
    int32_t shift = x.e + e;
    if (shift >= 0) /* x.m is small: the result fits */
        return x.m ? x.m * ((int64_t)1 << shift) : 0;
    if (shift <= -63)
        return 0;
    return ((x.m >> (-shift - 1)) + 1) >> 1;
}

/* a*b with b's mantissa below 2^31. Keeps 31 bits of a. */
FX_NOINLINE static struct scaled scaled_mul(struct scaled a, struct scaled b)
{
    int32_t drop = fx_max(bit_length(fx_magnitude(a.m)) - 31, 0);
    return (struct scaled){(a.m >> drop) * (int32_t)b.m, a.e + drop + b.e};
}

/* Exponent E such that sum(|row|) * 2^15 + |offset| < 2^(E+1) * (1 - 2^-7), and each of both terms below 2^E. */
static int32_t row_exponent(const struct scaled row[3], struct scaled offset)
{
    uint64_t sum =
        fx_magnitude(row[0].m) + fx_magnitude(row[1].m) + fx_magnitude(row[2].m); /* < 2^64: |m| < 2^62 here */
    uint64_t t = fx_magnitude(offset.m);
    int32_t a = bit_length(sum + (sum >> 6) + 1) + row[0].e + 15;
    int32_t b = t ? bit_length(t + (t >> 6) + 1) + offset.e : a;
    return a > b ? a : b;
}

static inline void row_store(struct raster_object *o, int i, const struct scaled row[3], struct scaled offset,
                             int32_t scale)
{
    for (int j = 0; j < 3; j++)
        o->row[i][j] = (int32_t)scaled_to_int(row[j], scale + ROW_BITS); /* < 2^15 * 2^ROW_BITS */
    o->offset[i] = scaled_to_int(offset, scale + ROW_BITS);              /* < 2^30 * 2^ROW_BITS */
}

/* Of a row of a matrix, or with a stride of 3 of a column, with d, Q46. In: it is of unit length, |d| <= sqrt(3) 2^32; so |result| < 2^63. */
FX_NOINLINE static int64_t dot_q46(const q2_30_t *m, unsigned stride, const int64_t d[3])
{
    return m[0] * d[0] + m[stride] * d[1] + m[2 * stride] * d[2];
}

/* The eye in vertex units, rounded, so far as back-face cones need it. In: from it to the object, q17.16. */
static void eye_setup(struct raster_object *o, const struct scene_object *so, const int64_t d[3])
{
    int64_t e[3];
    uint64_t all = 0;
    for (int j = 0; j < 3; j++) {
        e[j] = -dot_q46(&so->rotation[j], 3, d);
        all |= fx_magnitude(e[j]);
    }
    /* 1/scale: mantissa in [2^30, 2^31), so recip(2m) = 2^60/m. */
    struct scaled inverse = {fx_recip(so->scale_mantissa << 1), 30 + so->scale_shift - 60};
    int32_t bits = bit_length(all) - 46 + 1 + so->scale_shift; /* upper bound of the result's length */
    o->eye_shift = (uint8_t)(bits > 16 ? bits - 16 : 0);
    for (int j = 0; j < 3; j++)
        o->eye[j] = (int32_t)scaled_to_int(scaled_mul((struct scaled){e[j], -46}, inverse), -(int32_t)o->eye_shift);
}

void raster_object_setup(struct raster_object *o, const struct raster_frame *f, const struct scene_object *so)
{
    const struct scene_camera *cam = f->camera;
    int64_t d[3];
    for (int i = 0; i < 3; i++)
        d[i] = (int64_t)so->position[i] - cam->eye[i]; /* q17.16, |d| <= 2^32 */

    /* X and Y in half sub-pixels times w: H/2 * focal * 512 = H * focal * 2^8. w = -e.z, and y runs down. */
    struct scaled pixels = {(int64_t)f->height * cam->focal, 8 - 16 + raster_sample_shift(f)}; /* < 2^12 * 2^24 */
    int32_t drop = bit_length((uint64_t)pixels.m) - 31;
    if (drop > 0)
        pixels = (struct scaled){pixels.m >> drop, pixels.e + drop};
    struct scaled row[3][3], offset[3];
    int32_t exponent[3];
    for (int i = 0; i < 3; i++) {
        const q2_30_t *c = cam->rotation + 3 * i;
        for (int j = 0; j < 3; j++) {
            /* Q60 sum of products of unit rows and columns: < 2^61 */
            int64_t q60 = (int64_t)c[0] * so->rotation[j] + (int64_t)c[1] * so->rotation[3 + j] +
                          (int64_t)c[2] * so->rotation[6 + j];
            int64_t q30 = (q60 + ((int64_t)1 << 29)) >> 30;
            o->rotation[3 * i + j] = (int16_t)((q30 + (1 << 15)) >> 16);
            int64_t m = (int64_t)(int32_t)q30 * (int32_t)so->scale_mantissa >> 30; /* <= 2^31.1 */
            const int half = i < 2;                                                /* one exponent: |m| < 2^31 */
            m >>= half;
            row[i][j] = (struct scaled){i ? -m : m, half - 30 - so->scale_shift};
            if (half)
                row[i][j] = scaled_mul(row[i][j], pixels);
        }
        const int64_t along = dot_q46(c, 1, d);
        offset[i] = (struct scaled){i ? -along : along, -46};
        if (i < 2)
            offset[i] = scaled_mul(offset[i], pixels);
        exponent[i] = row_exponent(row[i], offset[i]);
    }
    const int32_t scale_xy = 30 - fx_max(exponent[0], exponent[1]), scale_w = 30 - exponent[2];
    for (int i = 0; i < 3; i++)
        row_store(o, i, row[i], offset[i], i < 2 ? scale_xy : scale_w);
    o->scale_w = scale_w;
    o->shift_xy = 29 + scale_xy - scale_w;
    /* near_w = ceil(near * 2^scale_w), at least 1; beyond int32 the whole object is nearer than the plane. */
    int32_t s = scale_w - 16;
    uint64_t near_w = s >= 0    ? (s > 31 ? UINT32_MAX : (uint64_t)cam->near << s)
                      : s < -32 ? 1
                                : ((uint64_t)cam->near + ((uint64_t)1 << -s) - 1) >> -s;
    o->near_w = near_w > INT32_MAX ? INT32_MAX : near_w < 1 ? 1 : (int32_t)near_w;
    /* inv_w = 2^23 * near2 / w, near2 = the power of two at or below near = 2^(15 - clz(near)) in world units:
     * 1/w = recip * 2^(c - 61 + scale_w), so inv_w = recip >> (61 - 23 - (15 - clz) - scale_w - c). */
    o->shift_depth = 61 - 23 - (15 - (int32_t)fx_clz(cam->near)) - scale_w;
    eye_setup(o, so, d);
    o->material = (uint8_t)so->material;
}

/* floor(product / 2^(32+s)) for any s; s above 31 leaves the sign. */
static int32_t shift_product(int64_t product, int32_t s)
{
    if (s >= 0)
        return (int32_t)(product >> 32) >> (s > 31 ? 31 : s);
    s = s < -32 ? -32 : s;
    product >>= 32 + s;
    const int64_t limit = (int64_t)1 << (GUARD_BITS + 9);
    return (int32_t)(product < -limit ? -limit : product > limit ? limit : product);
}

void raster_project(struct raster_vertex *p, const struct raster_object *o, const struct raster_clip_vertex *c,
                    int32_t centre_x2, int32_t centre_y2)
{
    const int32_t limit = 1 << (GUARD_BITS + 9);    /* half sub-pixels */
    int32_t lead = (int32_t)fx_clz((uint32_t)c->w); /* w >= 1 */
    uint32_t recip = fx_recip((uint32_t)c->w << lead);
    int32_t s = o->shift_xy - lead, sd = o->shift_depth - lead;
    /* |x| < 2^31, recip <= 2^30: the product fits */
    int32_t hx = fx_clamp(shift_product((int64_t)c->x * (int32_t)recip, s), -limit, limit);
    int32_t hy = fx_clamp(shift_product((int64_t)c->y * (int32_t)recip, s), -limit, limit);
    p->x = (hx + centre_x2) >> 1;
    p->y = (hy + centre_y2) >> 1;
    /* w >= near_w >= near2 makes inv_w <= 2^23, sd >= 6 but for rounding */
    uint32_t inv_w = recip >> (sd > 31 ? 31 : sd < 6 ? 6 : sd);
    p->inv_w = inv_w > 1u << 23 ? 1u << 23 : inv_w;
}

/*
 * The ray through a pixel's centre is (X, Y, -1), X = (2x+1-W) / (H focal), Y = (H-2y-1) / (H focal). Components are
 * brought to a unit in which the largest of the picture is below 2^15, so that their squares sum below 2^32.
 */
void raster_view_setup(struct raster_view *v, const struct scene_camera *c, uint16_t width, uint16_t height)
{
    uint64_t axis = (uint64_t)height * c->focal; /* where half a pixel is 2^16: 2^8 .. 2^36 */
    /* A region is looked at in its middle, 8 pixels from its corner, whether that is in the picture or not. */
    uint64_t half = (uint64_t)fx_max(16, width > height ? width : height) << 16;
    int32_t drop = bit_length(axis > half ? axis : half) - 15; /* 6 .. 22 */
    v->axis = fx_max((int32_t)(axis >> drop), 1);              /* no ray has length 0 */
    v->step = 1 << (16 + VIEW_STEP_BITS - drop);
}

struct vec3 raster_view_vector(const struct raster *r, uint32_t x, uint32_t y)
{
    const struct raster_view *v = &r->view;
    int32_t px = 2 * (int32_t)x + 1 - r->frame.width, py = 2 * (int32_t)y + 1 - r->frame.height;
    /* |p| * step < 2^(15 + VIEW_STEP_BITS) */
    int32_t rx = (px * v->step) >> VIEW_STEP_BITS, ry = (py * v->step) >> VIEW_STEP_BITS, rz = v->axis;
    unsigned shift;
    uint32_t m = lut_rsqrt((uint32_t)(rx * rx) + (uint32_t)(ry * ry) + (uint32_t)(rz * rz), &shift);
    int32_t k = (int32_t)(m >> 1); /* 1/length = k * 2^-(29 + shift), k <= 2^30 */
    unsigned s = shift + 14;       /* to Q15 */
    int64_t half = (int64_t)1 << (s - 1);
    return (struct vec3){-(int32_t)((rx * (int64_t)k + half) >> s), (int32_t)((ry * (int64_t)k + half) >> s),
                         (int32_t)((rz * (int64_t)k + half) >> s)};
}
