#include "ref_coverage.h"

void ref_triangle_setup(struct ref_triangle *t, const int32_t vertex[3][2])
{
    for (int i = 0; i < 3; i++) { /* edge i is opposite vertex i */
        const int32_t *from = vertex[(i + 1) % 3], *to = vertex[(i + 2) % 3];
        int64_t dx = (int64_t)to[0] - from[0], dy = (int64_t)to[1] - from[1];
        t->a[i] = dy;
        t->b[i] = -dx;
        t->c[i] = dx * from[1] - dy * from[0];
        /* Interior to the right: the value grows with x. Horizontal with interior below: it grows with y. */
        t->owns[i] = dy > 0 || (dy == 0 && dx < 0);
    }
    t->area = t->a[0] * vertex[0][0] + t->b[0] * vertex[0][1] + t->c[0];
}

static int64_t edge_at(const struct ref_triangle *t, int i, int32_t x, int32_t y)
{
    return t->a[i] * (256 * (int64_t)x + 128) + t->b[i] * (256 * (int64_t)y + 128) + t->c[i];
}

bool ref_triangle_covers(const struct ref_triangle *t, int32_t x, int32_t y)
{
    if (t->area <= 0)
        return false;
    for (int i = 0; i < 3; i++) {
        int64_t e = edge_at(t, i, x, y);
        if (e < 0 || (e == 0 && !t->owns[i]))
            return false;
    }
    return true;
}

void ref_triangle_weights(double weight[3], const struct ref_triangle *t, int32_t x, int32_t y)
{
    for (int i = 0; i < 3; i++)
        weight[i] = (double)edge_at(t, i, x, y) / (double)t->area;
}
