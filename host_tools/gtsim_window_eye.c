#include "gtsim_window_eye.h"

#include <float.h>
#include <math.h>
#include <string.h>

#define DEGREE         (3.14159265358979323846 / 180)
#define MAX_PITCH      (89 * DEGREE)
#define MAX_COORDINATE 32767 /* of q16_16_t */

static const double vertical[3] = {0, 1, 0};

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(double out[3], const double a[3], const double b[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

static void normalize(double v[3])
{
    double length = sqrt(dot(v, v));
    for (int i = 0; i < 3; i++)
        v[i] /= length;
}

/* v turned about the unit vector `axis` (Rodrigues). */
static void turn(double v[3], const double axis[3], double angle)
{
    double c = cos(angle), s = sin(angle), along = dot(v, axis), side[3];
    cross(side, axis, v);
    for (int i = 0; i < 3; i++)
        v[i] = c * v[i] + s * side[i] + (1 - c) * along * axis[i];
}

void eye_turn_vertical(double v[3], double degrees)
{
    turn(v, vertical, degrees * DEGREE);
}

void eye_read(struct eye *e, const struct scene_camera *c)
{
    for (int i = 0; i < 3; i++)
        e->at[i] = ldexp(c->eye[i], -16);
    for (int i = 0; i < 9; i++)
        e->row[i / 3][i % 3] = ldexp(c->rotation[i], -30);
}

bool eye_write(struct scene_camera *c, const struct eye *e)
{
    for (int i = 0; i < 3; i++)
        if (fabs(e->at[i]) > MAX_COORDINATE)
            return false;
    for (int i = 0; i < 3; i++)
        c->eye[i] = (int32_t)lrint(ldexp(e->at[i], 16));
    for (int i = 0; i < 9; i++)
        c->rotation[i] = (int32_t)lrint(ldexp(e->row[i / 3][i % 3], 30));
    return true;
}

void eye_scene_middle(double middle[3], const struct scene *s)
{
    double lo[3] = {DBL_MAX, DBL_MAX, DBL_MAX}, hi[3] = {-DBL_MAX, -DBL_MAX, -DBL_MAX};
    for (uint32_t o = 0; o < s->header->objects.count; o++) {
        const struct scene_object *object = &s->objects[o];
        const struct scene_mesh *m = &s->meshes[object->mesh];
        double scale = ldexp(object->scale_mantissa, -(30 + object->scale_shift));
        for (int corner = 0; corner < 8; corner++)
            for (int i = 0; i < 3; i++) {
                double x = ldexp(object->position[i], -16);
                for (int k = 0; k < 3; k++)
                    x += scale * ldexp(object->rotation[3 * i + k], -30) * (corner >> k & 1 ? m->hi[k] : m->lo[k]);
                lo[i] = fmin(lo[i], x);
                hi[i] = fmax(hi[i], x);
            }
    }
    for (int i = 0; i < 3; i++)
        middle[i] = s->header->objects.count ? (lo[i] + hi[i]) / 2 : 0;
}

void eye_pivot(double pivot[3], const struct eye *e, const struct scene *s, double least)
{
    double middle[3], to[3];
    eye_scene_middle(middle, s);
    for (int i = 0; i < 3; i++)
        to[i] = middle[i] - e->at[i];
    double ahead = -dot(to, e->row[2]);
    if (ahead < least)
        ahead = sqrt(dot(to, to));
    for (int i = 0; i < 3; i++)
        pivot[i] = e->at[i] - ahead * e->row[2][i];
}

bool eye_orbit(struct eye *e, const double pivot[3], double around, double up)
{
    double right[3], pitch = asin(fmax(-1, fmin(1, e->row[2][1])));
    double raise = fmax(-MAX_PITCH, fmin(MAX_PITCH, pitch + up * DEGREE)) - pitch;
    if (fabs(raise) + fabs(around) < 1e-6)
        return false;
    memcpy(right, e->row[0], sizeof right);
    for (int i = 0; i < 3; i++)
        e->at[i] -= pivot[i];
    double *turned[] = {e->at, e->row[0], e->row[1], e->row[2]};
    for (int i = 0; i < 4; i++) {
        turn(turned[i], right, -raise);
        eye_turn_vertical(turned[i], around);
    }
    for (int i = 0; i < 3; i++)
        e->at[i] += pivot[i];
    normalize(e->row[2]); /* errors of rounding do not add up */
    cross(e->row[0], e->row[1], e->row[2]);
    normalize(e->row[0]);
    cross(e->row[1], e->row[2], e->row[0]);
    return true;
}

bool eye_approach(struct eye *e, const double pivot[3], double factor, double least)
{
    double from[3];
    for (int i = 0; i < 3; i++)
        from[i] = e->at[i] - pivot[i];
    if (factor < 1 && factor * sqrt(dot(from, from)) < least)
        return false;
    for (int i = 0; i < 3; i++)
        e->at[i] = pivot[i] + factor * from[i];
    return true;
}
