/* The half-vector table's energy. Between two planes, g rises towards grazing faster than the line between them: what is fitted for
 * the eye may there reflect more than arrives. */
#include <math.h>

#include "common.h"
#include "host_half_vector_fit.h"
#include "host_metrics.h"
#include "host_rgb9e5.h"

static const double pi = 3.14159265358979323846;

enum { LAST_ANGLE = 89, PASSES = 8 };

/* Closer towards grazing, where it happens. */
static int angle_after(int angle)
{
    return angle < 60 ? angle + 20 : angle < 80 ? angle + 5 : angle + 1;
}

static double albedo(const struct brdf_source *source, int angle)
{
    double rgb[3];
    metrics_albedo(rgb, source, angle);
    return fmax(rgb[0], fmax(rgb[1], rgb[2]));
}

static void scale_plane(struct half_vector *t, uint32_t plane, double factor)
{
    uint32_t *texel = t->texels + (size_t)t->t * t->h * plane;
    for (uint32_t n = 0; n < t->t * t->h; n++) {
        double rgb[3];
        for (int c = 0; c < 3; c++)
            rgb[c] = ldexp(factor * (texel[n] >> 9 * c & 511), (int)(texel[n] >> 27) - 24);
        texel[n] = rgb9e5_encode(rgb);
    }
}

/* A lobe around the mirror direction of light at `angle` stands at theta_d = angle. Of the planes at its sides, the farther from the
 * normal is lowered: the nearer one serves the angles where it stands. */
static void lower(struct half_vector *t, int angle, double excess)
{
    double theta = angle * pi / 180, plane = half_vector_plane(t->warp_d, (1 + sin(theta) - cos(theta)) / 2);
    uint32_t j = (uint32_t)fmin(plane, t->d - 2);
    scale_plane(t, j + 1, 1 - fmin(excess / fmax(plane - j, 0.25), 0.5));
}

void half_vector_limit_energy(struct half_vector *t, const struct brdf_source *source)
{
    const double tolerance = 0x1p-7;
    struct brdf_source table, symmetric;
    half_vector_source(&table, t, "table");
    source_make_symmetric(&symmetric, source);
    double allowed[LAST_ANGLE + 1] = {0}; /* 0: not known yet */
    bool settled[LAST_ANGLE + 1] = {0};   /* lowering a plane raises no angle's albedo */
    for (int pass = 0; pass < PASSES; pass++)
        for (int angle = 0; angle <= LAST_ANGLE; angle = angle_after(angle)) {
            if (settled[angle])
                continue;
            double is = albedo(&table, angle);
            if (is > 1 + tolerance && !(allowed[angle] > 0)) /* a source may itself reflect more than arrives */
                allowed[angle] = fmax(albedo(&symmetric, angle), 1);
            settled[angle] = is <= fmax(allowed[angle], 1) * (1 + tolerance);
            if (!settled[angle])
                lower(t, angle, 1 - (1 + tolerance / 2) * allowed[angle] / is);
        }
}
