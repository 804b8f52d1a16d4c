#include "ref_render.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "ref_coverage.h"

struct corner {
    int32_t xy[2];
    double inv_w, normal[3], uv[2]; /* normal: eye space */
};

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void normalise(double v[3])
{
    double length = sqrt(dot(v, v));
    for (int i = 0; i < 3; i++)
        v[i] /= length;
}

/* Eye space from world space, for directions. */
static void to_eye(double out[3], const struct ref_camera *c, const double world[3])
{
    for (int i = 0; i < 3; i++)
        out[i] = dot(c->rotation[i], world);
}

static void corner_make(struct corner *c, const struct ref_view *view, unsigned object, unsigned vertex)
{
    const struct ref_scene *s = view->scene;
    const struct ref_object *o = &s->objects[object];
    const struct ref_vertex *v = &s->vertices[vertex];
    double from_eye[3], normal[3];
    for (int i = 0; i < 3; i++) {
        from_eye[i] = dot(o->matrix[i], v->position) + o->matrix[i][3] - s->camera.eye[i];
        normal[i] = dot(o->rotation[i], v->normal);
    }
    c->inv_w = -1 / dot(s->camera.rotation[2], from_eye);
    to_eye(c->normal, &s->camera, normal);
    memcpy(c->uv, v->uv, sizeof c->uv);
    view->snapped(c->xy, view->context, object, vertex);
}

/* First and last pixel whose centre may lie within the vertices' extent along one axis. */
static void pixel_range(int range[2], const struct corner c[3], int axis, int size)
{
    int32_t lo = c[0].xy[axis], hi = lo;
    for (int i = 1; i < 3; i++) {
        lo = c[i].xy[axis] < lo ? c[i].xy[axis] : lo;
        hi = c[i].xy[axis] > hi ? c[i].xy[axis] : hi;
    }
    double first = floor(lo / 256.0) - 1, last = ceil(hi / 256.0) + 1;
    range[0] = (int)fmax(first, 0);
    range[1] = (int)fmin(last, size - 1);
}

/* From the surface's corners and their shares in the pixel, which sum to 1. */
static void linear_normal(double normal[3], const struct corner c[3], const double share[3])
{
    for (int j = 0; j < 3; j++)
        normal[j] = share[0] * c[0].normal[j] + share[1] * c[1].normal[j] + share[2] * c[2].normal[j];
    normalise(normal);
}

/* n = (2u, 2v, 1-s)/(1+s), s = u^2+v^2, in the meshlet's frame. */
static void stereographic_normal(double normal[3], const struct corner c[3], const double share[3],
                                 const struct ref_view *view, int object, const struct ref_meshlet *m)
{
    double u = share[0] * c[0].uv[0] + share[1] * c[1].uv[0] + share[2] * c[2].uv[0];
    double v = share[0] * c[0].uv[1] + share[1] * c[1].uv[1] + share[2] * c[2].uv[1];
    double s = u * u + v * v, in_object[3], world[3];
    for (int j = 0; j < 3; j++)
        in_object[j] = 2 * u * m->frame[0][j] + 2 * v * m->frame[1][j] + (1 - s) * m->frame[2][j];
    for (int j = 0; j < 3; j++)
        world[j] = dot(view->scene->objects[object].rotation[j], in_object);
    to_eye(normal, &view->scene->camera, world);
    normalise(normal);
}

static void draw_triangle(struct ref_picture *p, const struct ref_view *view, const struct corner c[3], int object,
                          const struct ref_meshlet *m)
{
    int32_t xy[3][2];
    int x[2], y[2];
    struct ref_triangle t;
    for (int i = 0; i < 3; i++)
        memcpy(xy[i], c[i].xy, sizeof xy[i]);
    ref_triangle_setup(&t, (const int32_t(*)[2])xy);
    pixel_range(x, c, 0, view->width);
    pixel_range(y, c, 1, view->height);
    for (int py = y[0]; py <= y[1]; py++)
        for (int px = x[0]; px <= x[1]; px++) {
            if (!ref_triangle_covers(&t, px, py))
                continue;
            int at = py * view->width + px;
            double weight[3], inv_w = 0;
            ref_triangle_weights(weight, &t, px, py);
            for (int i = 0; i < 3; i++)
                inv_w += weight[i] * c[i].inv_w;
            if (inv_w <= p->inv_w[at])
                continue;
            p->inv_w[at] = inv_w;
            p->object[at] = object;
            for (int i = 0; i < 3; i++)
                weight[i] *= c[i].inv_w / inv_w;
            if (view->normals == REF_NORMALS_LINEAR)
                linear_normal(p->normal[at], c, weight);
            else
                stereographic_normal(p->normal[at], c, weight, view, object, m);
        }
}

static void draw_objects(struct ref_picture *p, const struct ref_view *view)
{
    const struct ref_scene *s = view->scene;
    for (unsigned o = 0; o < s->object_count; o++) {
        const struct ref_mesh *mesh = &s->meshes[s->objects[o].mesh];
        for (unsigned m = 0; m < mesh->meshlet_count; m++) {
            const struct ref_meshlet *let = &s->meshlets[mesh->meshlet_first + m];
            struct corner *corners = malloc(let->vertex_count * sizeof *corners);
            if (!corners)
                abort();
            for (unsigned i = 0; i < let->vertex_count; i++)
                corner_make(&corners[i], view, o, let->vertex_first + i);
            for (unsigned i = 0; i < let->triangle_count; i++) {
                const unsigned *v = s->triangles[let->triangle_first + i];
                draw_triangle(p, view, (const struct corner[3]){corners[v[0]], corners[v[1]], corners[v[2]]}, (int)o,
                              let);
            }
            free(corners);
        }
    }
}

/* Direction to a light from a point in eye space, and what it brings to a surface that faces it there. */
static void light_at(double l[3], double irradiance[3], const struct ref_scene *s, const struct ref_light *light,
                     const double point[3])
{
    double share = s->exposure;
    if (light->point) {
        double from_eye[3], distance = 0;
        for (int i = 0; i < 3; i++)
            from_eye[i] = light->position[i] - s->camera.eye[i];
        to_eye(l, &s->camera, from_eye);
        for (int i = 0; i < 3; i++) {
            l[i] -= point[i];
            distance += l[i] * l[i];
        }
        distance = sqrt(distance);
        share *= ref_attenuation(distance, light->radius);
        if (distance > 0)
            normalise(l);
    } else {
        to_eye(l, &s->camera, light->direction);
    }
    for (int i = 0; i < 3; i++)
        irradiance[i] = share * light->irradiance[i];
}

static const double ambient_blinn_phong = 0.02, ambient_metallic_roughness = 0.05; /* James 2022 */

static void shade_blinn_phong(double radiance[3], const struct ref_scene *s, const struct ref_material *m,
                              const double n[3], const double v[3], const double point[3])
{
    for (int j = 0; j < 3; j++)
        radiance[j] = ambient_blinn_phong * m->kd[j] * s->exposure;
    for (unsigned i = 0; i < s->light_count; i++) {
        double l[3], irradiance[3], c[3];
        light_at(l, irradiance, s, &s->lights[i], point);
        ref_blinn_phong(c, m, n, l, v);
        for (int j = 0; j < 3; j++)
            radiance[j] += c[j] * irradiance[j] / M_PI;
    }
    for (int j = 0; j < 3; j++)
        radiance[j] = radiance[j] < 1 ? radiance[j] : 1;
}

/* The material as the view wants it: of its own kind, or of the one asked for. */
static struct ref_material material_of(const struct ref_view *view, int object)
{
    static const enum ref_model_kind kinds[] = {
        [REF_MODEL_AS_SCENE] = REF_LAMBERT,
        [REF_MODEL_MEASURED] = REF_LAMBERT,
        [REF_MODEL_LAFORTUNE_PHONG] = REF_LAFORTUNE_PHONG,
        [REF_MODEL_BLINN_PHONG] = REF_BLINN_PHONG,
        [REF_MODEL_METALLIC_ROUGHNESS] = REF_METALLIC_ROUGHNESS,
    };
    struct ref_material m = view->scene->materials[view->scene->objects[object].material];
    if (view->model != REF_MODEL_AS_SCENE) {
        m.measured = view->model == REF_MODEL_MEASURED;
        m.kind = kinds[view->model];
    }
    return m;
}

/* `point` is the surface's, in eye space. */
static void shade(double radiance[3], const struct ref_view *view, const struct ref_material *m, const double n[3],
                  const double v[3], const double point[3])
{
    const struct ref_scene *s = view->scene;
    if (!m->measured && m->kind == REF_BLINN_PHONG) {
        shade_blinn_phong(radiance, s, m, n, v, point);
        return;
    }
    double facing[3] = {n[0], n[1], n[2]};
    if ((m->measured || m->kind == REF_METALLIC_ROUGHNESS) && dot(n, v) < 1.0 / 128) {
        /* there is no value there: the normal is turned back to where there is one */
        for (int j = 0; j < 3; j++)
            facing[j] += v[j] * (1.0 / 128 - dot(n, v));
        normalise(facing);
        n = facing;
    }
    for (int j = 0; j < 3 && !m->measured && m->kind == REF_METALLIC_ROUGHNESS; j++)
        radiance[j] = ambient_metallic_roughness * m->kd[j] * s->exposure;
    for (unsigned i = 0; i < s->light_count; i++) {
        double l[3], irradiance[3], f[3];
        light_at(l, irradiance, s, &s->lights[i], point);
        if (dot(n, l) <= 0)
            continue;
        if (m->measured)
            ref_table_eval(f, view->tables[m->slot], n, l, v);
        else
            ref_model_value(f, m, n, l, v);
        for (int j = 0; j < 3; j++)
            radiance[j] += irradiance[j] * f[j] * dot(n, l);
    }
}

static double clamp01(double x)
{
    return x < 0 ? 0 : x > 1 ? 1 : x;
}

/* Stephen Hill's fit of the ACES RRT and sRGB ODT (BakingLab, ACES.hlsl, 2016). */
static void aces_curve(double out[3], const double in[3])
{
    static const double input[3][3] = {
        {0.59719, 0.35458, 0.04823}, {0.07600, 0.90834, 0.01566}, {0.02840, 0.13383, 0.83777}};
    static const double output[3][3] = {
        {1.60475, -0.53108, -0.07367}, {-0.10208, 1.10813, -0.00605}, {-0.00327, -0.07276, 1.07602}};
    double fit[3];
    for (int i = 0; i < 3; i++) {
        double v = dot(input[i], in);
        fit[i] = (v * (v + 0.0245786) - 0.000090537) / (v * (0.983729 * v + 0.4329510) + 0.238081);
    }
    for (int i = 0; i < 3; i++)
        out[i] = dot(output[i], fit);
}

void ref_tone(double display[3], const double radiance[3], int aces)
{
    double c[3] = {radiance[0], radiance[1], radiance[2]};
    if (aces)
        aces_curve(c, radiance);
    for (int i = 0; i < 3; i++) {
        double x = clamp01(c[i]);
        display[i] = 255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055); /* IEC 61966-2-1 */
    }
}

static void finish_pixel(struct ref_picture *p, const struct ref_view *view, int x, int y)
{
    const struct ref_scene *s = view->scene;
    int at = y * view->width + x;
    if (p->object[at] < 0) {
        for (int i = 0; i < 3; i++)
            p->display[at][i] = s->background[i];
    } else {
        double scale = view->height * s->camera.focal;
        double v[3] = {-(2 * x + 1 - view->width) / scale, (2 * y + 1 - view->height) / scale, 1};
        double point[3] = {-v[0] / p->inv_w[at], -v[1] / p->inv_w[at], -v[2] / p->inv_w[at]};
        normalise(v);
        struct ref_material m = material_of(view, p->object[at]);
        shade(p->radiance[at], view, &m, p->normal[at], v, point);
        ref_tone(p->display[at], p->radiance[at], s->aces);
    }
    for (int i = 0; i < 3; i++)
        p->rgb[3 * at + i] = (uint8_t)floor(p->display[at][i] + 0.5);
}

void ref_render(struct ref_picture *out, const struct ref_view *view)
{
    size_t n = (size_t)view->width * view->height;
    out->rgb = calloc(n, 3);
    out->object = malloc(n * sizeof *out->object);
    out->inv_w = calloc(n, sizeof *out->inv_w);
    out->normal = calloc(n, sizeof *out->normal);
    out->radiance = calloc(n, sizeof *out->radiance);
    out->display = calloc(n, sizeof *out->display);
    if (!out->rgb || !out->object || !out->inv_w || !out->normal || !out->radiance || !out->display)
        abort();
    for (size_t i = 0; i < n; i++)
        out->object[i] = -1;
    draw_objects(out, view);
    for (int y = 0; y < view->height; y++)
        for (int x = 0; x < view->width; x++)
            finish_pixel(out, view, x, y);
}

void ref_picture_free(struct ref_picture *p)
{
    free(p->rgb);
    free(p->object);
    free(p->inv_w);
    free(p->normal);
    free(p->radiance);
    free(p->display);
    memset(p, 0, sizeof *p);
}
