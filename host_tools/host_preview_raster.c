/* A depth buffer for a few thousand triangles (host_preview_internal.h). */
#include "host_preview_internal.h"

#include <math.h>

#include "common.h"

static double cross(const double a[3], const double b[3], double x, double y)
{
    return (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
}

static void draw(struct preview_hit *hits, int width, int height, const double *p[3], uint32_t number)
{
    double area = cross(p[0], p[1], p[2][0], p[2][1]), lo[2], hi[2];
    const int last[2] = {width - 1, height - 1};
    for (int k = 0; k < 2; k++) {
        lo[k] = fmax(floor(fmin(p[0][k], fmin(p[1][k], p[2][k])) - 0.5), 0);
        hi[k] = fmin(ceil(fmax(p[0][k], fmax(p[1][k], p[2][k])) - 0.5), last[k]);
    }
    if (area == 0)
        return;
    for (int y = (int)lo[1]; y <= hi[1]; y++)
        for (int x = (int)lo[0]; x <= hi[0]; x++) {
            double b = cross(p[2], p[0], x + 0.5, y + 0.5) / area, c = cross(p[0], p[1], x + 0.5, y + 0.5) / area;
            struct preview_hit *hit = &hits[(size_t)(height - 1 - y) * (size_t)width + (size_t)x];
            if (b < 0 || c < 0 || b + c > 1)
                continue;
            double z = p[0][2] + b * (p[1][2] - p[0][2]) + c * (p[2][2] - p[0][2]);
            if (!hit->triangle || z > hit->z)
                *hit = (struct preview_hit){number + 1, {(float)b, (float)c}, (float)z};
        }
}

struct preview_hit *preview_rasterize(int width, int height, const double (*points)[3], const unsigned *indices,
                                      size_t index_count)
{
    struct preview_hit *hits = xcalloc((size_t)width * (size_t)height, sizeof *hits);
    for (size_t i = 0; i + 2 < index_count; i += 3) {
        const double *p[3] = {points[indices[i]], points[indices[i + 1]], points[indices[i + 2]]};
        draw(hits, width, height, p, (uint32_t)i);
    }
    return hits;
}
