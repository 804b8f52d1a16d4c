/*
 * Point lights, see point_light.h. A distance is kept as its square with 32 fraction bits, normalised by an even shift, so that one
 * reciprocal root serves direction and attenuation alike.
 */
#include "point_light.h"

#include "func.h"
#include "internal.h"

#define ONE (1u << 30)
/* 0.01^2 with 32 fraction bits; 2^60 over it normalised, and the shift that normalises it */
#define LEAST_SQUARE  429497u
#define LEAST_INVERSE 655359587u
#define LEAST_SHIFT   44

static int32_t saturate(int64_t x)
{
    return x < -INT32_MAX ? -INT32_MAX : x > INT32_MAX ? INT32_MAX : (int32_t)x;
}

void raster_light_position(struct vec3 *eye, const struct scene_camera *camera, const q16_16_t position[3])
{
    const q2_30_t *m = camera->rotation;
    int64_t d[3];
    int32_t e[3];
    for (int i = 0; i < 3; i++)
        d[i] = (int64_t)position[i] - camera->eye[i]; /* |d| <= 2^32 */
    for (int i = 0; i < 3; i++)                       /* Q46: a unit row times |d| <= sqrt(3) 2^32, so < 2^62.8 */
        e[i] = saturate((m[3 * i] * d[0] + m[3 * i + 1] * d[1] + m[3 * i + 2] * d[2] + (1 << 29)) >> 30);
    *eye = (struct vec3){e[0], e[1], e[2]};
}

/* x * 2^s rounded to nearest, within +-INT32_MAX. In: |x| <= 2^30. */
static int32_t scale(int32_t x, int32_t s)
{
    if (s < 0)
        return s < -31 ? 0 : ((x >> (-s - 1)) + 1) >> 1;
    if ((uint32_t)(x < 0 ? -x : x) > (s > 30 ? 0 : (uint32_t)INT32_MAX >> s))
        return x < 0 ? -INT32_MAX : INT32_MAX;
    return s > 30 ? 0 : x * (1 << s);
}

/*
 * With D = depth - bias, w = 2^23 near2 / D in world units, and the pixel whose centre is px half pixels from the picture's is at
 * x = px w / A, A = height * focal: one reciprocal, of A D, serves both. Every factor is normalised to 32 bits.
 */
struct vec3 raster_surface_point(const struct raster *r, uint32_t x, uint32_t y, uint32_t depth)
{
    const struct raster_frame *f = &r->frame;
    uint32_t d = depth > DEPTH_BIAS ? depth - DEPTH_BIAS : 1, height = f->height, focal = f->camera->focal;
    int32_t px = 2 * (int32_t)x + 1 - f->width, py = f->height - 2 * (int32_t)y - 1; /* < 2^12 */
    unsigned lead_d = fx_clz(d), lead_a = fx_clz(height) + fx_clz(focal);
    uint32_t a = fx_mulhi_u(height << fx_clz(height), focal << fx_clz(focal)); /* A 2^(lead_a - 16): 2^30 .. 2^32 */
    uint32_t p = fx_mulhi_u(d << lead_d, a);                                   /* 2^29 .. 2^32 */
    unsigned lead_p = fx_clz(p);
    int32_t q = (int32_t)fx_recip(p << lead_p); /* 2^(109 - all leads) / (D A): 2^29 .. 2^30 */
    /* near2 = 2^(31 - clz(near)) with 16 fraction bits */
    int32_t s = (int32_t)(lead_d + lead_p) + 31 - (int32_t)fx_clz(f->camera->near) - 38;
    int32_t sx = s + (int32_t)lead_a - 35;
    return (struct vec3){scale(fx_mulhi(px * (1 << 19), q), sx), scale(fx_mulhi(py * (1 << 19), q), sx),
                         -scale((int32_t)fx_mulhi_u(a, (uint32_t)q), s)};
}

/* How far x is from lo..hi. */
static inline uint32_t distance_from(int32_t x, int32_t lo, int32_t hi)
{
    return x < lo ? (uint32_t)lo - (uint32_t)x : x > hi ? (uint32_t)x - (uint32_t)hi : 0;
}

/* 1/d^2 (1 - (d/radius)^4)^2, 1.0 = 2^30, at most that: d^2 = square * 2^-shift, below radius^2, square >= 2^30;
 * inverse = 2^60/square, 2^28 .. 2^30, or 2^60 over the normalised least square, whose shift `inverse_shift` then is. */
static uint32_t attenuate(uint32_t square, int32_t shift, uint32_t inverse, int32_t inverse_shift, uq16_16_t radius)
{
    int32_t lead = (int32_t)fx_clz(radius);
    uint32_t r = fx_recip(radius << lead) << 1; /* 2^(46 - lead) / radius: 2^30 .. 2^31 */
    uint32_t ratio = fx_mulhi_u(square, fx_mulhi_u(r, r));
    int32_t k = 2 * lead - shift + 2; /* from there to (d/radius)^2 with 30 fraction bits; <= 4 as that is below 1 */
    uint32_t t = k >= 0 ? ratio << k : k < -31 ? 0 : ratio >> -k;
    if (t >= ONE)
        return 0;
    uint32_t window = ONE - fx_mulhi_u(t << 1, t << 1);
    uint32_t a = fx_mulhi_u(inverse << 1, fx_mulhi_u(window << 1, window << 1) << 1);
    int32_t s = inverse_shift - 30;
    if (s < 0)
        return ((a >> (-s - 1)) + 1) >> 1;
    return s > 30 || a > ONE >> s ? (a ? ONE : 0) : a << s;
}

bool raster_point_light(struct vec3 *l, uint32_t *attenuation, const struct vec3 *position, uq16_16_t radius,
                        struct vec3 point)
{
    const uint32_t x = distance_from(position->x, point.x, point.x), y = distance_from(position->y, point.y, point.y),
                   z = distance_from(position->z, point.z, point.z);
    if (x >= radius || y >= radius || z >= radius) /* and so below 2^31 */
        return false;
    uint64_t d2 = (uint64_t)x * x + (uint64_t)y * y + (uint64_t)z * z;
    if (d2 >= (uint64_t)radius * radius) /* <= 2^62 */
        return false;
    if (!d2) { /* no direction: any */
        *l = (struct vec3){0, 0, 32768};
        *attenuation = ONE;
        return true;
    }
    uint32_t hi = (uint32_t)(d2 >> 32);
    int32_t shift = (int32_t)(hi ? fx_clz(hi) & ~1u : 32 + (fx_clz((uint32_t)d2) & ~1u)); /* 2 .. 62 */
    uint32_t square = (uint32_t)(d2 << shift >> 32);                                      /* 2^30 .. 2^32 */
    unsigned root_shift;                                                                  /* 16 */
    uint32_t root = lut_rsqrt(square, &root_shift);                                       /* 2^46/sqrt(square) */
    /* |d| < 2^(32 - shift/2), so each component is below 2^31; the product with the root has 46 fraction bits. */
    int32_t up = 1 << (shift / 2 - 1), m = (int32_t)(root >> 1);
    const int32_t dx = (int32_t)((uint32_t)position->x - (uint32_t)point.x),
                  dy = (int32_t)((uint32_t)position->y - (uint32_t)point.y),
                  dz = (int32_t)((uint32_t)position->z - (uint32_t)point.z);
    *l = (struct vec3){(fx_mulhi(dx * up, m) + (1 << 12)) >> 13, (fx_mulhi(dy * up, m) + (1 << 12)) >> 13,
                       (fx_mulhi(dz * up, m) + (1 << 12)) >> 13};
    bool least = d2 < LEAST_SQUARE;
    *attenuation =
        attenuate(square, shift, least ? LEAST_INVERSE : fx_mulhi_u(root, root), least ? LEAST_SHIFT : shift, radius);
    return true;
}

static bool light_at(struct vec3 *l, uint32_t *attenuation, const struct raster *r, const struct raster_light *light,
                     uint32_t x, uint32_t y, uint32_t depth)
{
    return raster_point_light(l, attenuation, &light->v, light->radius, raster_surface_point(r, x, y, depth));
}

FX_NOINLINE static int32_t lower(int32_t a, int32_t b)
{
    return saturate((int64_t)fx_min(a, b) - 2 - (fx_max(a < 0 ? -a : a, b < 0 ? -b : b) >> 22));
}

static int32_t upper(int32_t a, int32_t b)
{
    return -lower(-a, -b);
}

void raster_light_box_setup(struct raster_light_box *box, const struct raster *r, const struct raster_rect *rect,
                            uint32_t nearest, uint32_t farthest)
{
    const uint32_t x1 = rect->x + rect->width - 1u, y1 = rect->y + rect->height - 1u;
    /* x grows with the pixel's and with the distance from the view axis, so the extremes are at the corners. */
    const struct vec3 a = raster_surface_point(r, rect->x, y1, nearest),
                      b = raster_surface_point(r, x1, rect->y, nearest),
                      c = raster_surface_point(r, rect->x, y1, farthest),
                      d = raster_surface_point(r, x1, rect->y, farthest);
    /* A coordinate errs by 2^-24 of itself and a unit, so nearly equal depths may be out of order by twice that. */
    box->lo = (struct vec3){lower(a.x, c.x), lower(a.y, c.y), lower(a.z, c.z)};
    box->hi = (struct vec3){upper(b.x, d.x), upper(b.y, d.y), upper(b.z, d.z)};
}

bool raster_light_box_reached(const struct raster_light_box *box, const struct vec3 *position, uq16_16_t radius)
{
    const uint32_t x = distance_from(position->x, box->lo.x, box->hi.x),
                   y = distance_from(position->y, box->lo.y, box->hi.y),
                   z = distance_from(position->z, box->lo.z, box->hi.z);
    if (x >= radius || y >= radius || z >= radius) /* and so below 2^31 */
        return false;
    return (uint64_t)x * x + (uint64_t)y * y + (uint64_t)z * z < (uint64_t)radius * radius;
}

uint32_t raster_light_box_attenuation(const struct raster_light_box *box, const struct vec3 *position, uq16_16_t radius)
{
    const struct vec3 nearest = {fx_clamp(position->x, box->lo.x, box->hi.x),
                                 fx_clamp(position->y, box->lo.y, box->hi.y),
                                 fx_clamp(position->z, box->lo.z, box->hi.z)};
    struct vec3 l;
    uint32_t attenuation;
    if (!raster_point_light(&l, &attenuation, position, radius, nearest))
        return 0;
    attenuation += (attenuation >> 13) + 2; /* both attenuations err by up to 2^-15 and a unit */
    return attenuation < ONE ? attenuation : ONE;
}

static void find_box(const struct raster *r, struct raster_tile *t, const struct raster_rect *rect)
{
    uint32_t nearest = 0, farthest = UINT32_MAX;
    for (const struct raster_surface *s = t->surface; s != t->surface + RASTER_TILE_PIXELS; s++) {
        uint32_t depth = s->depth_slot >> 8;
        if (depth) {
            nearest = depth > nearest ? depth : nearest;
            farthest = depth < farthest ? depth : farthest;
        }
    }
    raster_light_box_setup(&t->m.shading.box, r, rect, nearest, farthest);
}

const struct raster_points raster_point_lights = {raster_light_position, light_at, find_box, raster_light_box_reached,
                                                  raster_light_box_attenuation};
