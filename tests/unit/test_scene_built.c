/* What gtscene puts into the benchmark scene (GONIOTILE_SIX_MODELS), by the product's structures and by the reference's reader. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "ref_scene.h"
#include "scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static uint32_t random_state = 1;

static uint32_t random_u32(void)
{
    random_state ^= random_state << 13;
    random_state ^= random_state >> 17;
    random_state ^= random_state << 5;
    return random_state;
}

static double random_signed(void)
{
    return random_u32() / 2147483648.0 - 1;
}

/* The benchmark scene, both ways. */
static uint8_t *six_blob;
static size_t six_bytes;
static struct scene six;
static struct ref_scene *ref;

static int open_six(void **state)
{
    (void)state;
    const char *path = getenv("GONIOTILE_SIX_MODELS");
    FILE *f = path ? fopen(path, "rb") : NULL;
    if (!f)
        return 1;
    six_blob = malloc(4 << 20);
    six_bytes = fread(six_blob, 1, 4 << 20, f);
    fclose(f);
    ref = ref_scene_open(six_blob, six_bytes);
    return !ref || scene_open(&six, six_blob, six_bytes) != SCENE_OK;
}

static int close_six(void **state)
{
    (void)state;
    ref_scene_close(ref);
    free(six_blob);
    return 0;
}

static void benchmark_scene_is_what_it_says(void **state)
{
    (void)state;
    unsigned total = 0;
    assert_int_equal(ref->object_count, 6);
    assert_int_equal(ref->light_count, 3);
    assert_int_equal(ref->material_count, 6);
    for (unsigned i = 0; i < 6; i++) {
        assert_int_equal(ref->materials[i].slot, i);
        assert_true(ref->materials[i].measured);
        unsigned triangles = 0;
        const struct ref_mesh *m = &ref->meshes[i];
        for (unsigned j = 0; j < m->meshlet_count; j++)
            triangles += ref->meshlets[m->meshlet_first + j].triangle_count;
        assert_in_range(triangles, 4600, 5400);
        total += triangles;
    }
    assert_in_range(total, 29000, 31000);
}

static void reference_reader_agrees_with_the_structures(void **state)
{
    (void)state;
    const struct scene_header *h = six.header;
    assert_true(ref->camera.focal == h->camera.focal / 65536.0 && ref->camera.near == h->camera.near / 65536.0);
    assert_true(ref->camera.rotation[1][2] == ldexp(h->camera.rotation[5], -30));
    assert_true(ref->exposure == h->output.exposure / 65536.0 && ref->aces == h->output.tone_curve);
    assert_memory_equal(ref->background, h->output.background, 3);
    for (unsigned i = 0; i < 3; i++) {
        assert_true(fabs(ref->lights[i].direction[1] - ldexp(six.lights[i].direction[1], -30)) < 1e-8);
        assert_true(ref->lights[i].irradiance[2] == six.lights[i].irradiance[2] / 65536.0);
    }
    for (unsigned i = 0; i < 6; i++) {
        const struct scene_object *o = &six.objects[i];
        const struct scene_material *m = &six.materials[i];
        assert_string_equal(ref->materials[i].name, m->name);
        assert_true(ref->materials[i].ks[1] == m->ks[1] / 65536.0 && ref->materials[i].kd[0] == m->kd[0] / 65536.0);
        assert_true(ref->materials[i].exponent == m->exponent / 65536.0);
        assert_true(ref->materials[i].roughness == m->roughness / 65536.0);
        assert_true(ref->objects[i].matrix[2][3] == o->position[2] / 65536.0);
        assert_true(ref->objects[i].matrix[1][0] ==
                    ldexp(o->scale_mantissa, -30 - o->scale_shift) * ldexp(o->rotation[3], -30));
    }
    for (unsigned i = 0; i < ref->meshlet_count; i++) {
        const struct scene_meshlet *m = &six.meshlets[i];
        assert_int_equal(ref->meshlets[i].vertex_first, m->vertex_first);
        assert_true(ref->meshlets[i].frame[2][1] == m->frame[7] / 16384.0);
        assert_true(ref->meshlets[i].cone_cutoff == m->cone_cutoff / 16384.0 && ref->meshlets[i].hi[2] == m->hi[2]);
        assert_true(ref->vertices[m->vertex_first].position[2] == six.vertices[m->vertex_first].z);
        assert_int_equal(ref->triangles[m->triangle_first][1], six.triangles[m->triangle_first].v[1]);
    }
}

static double dot(const double a[3], const double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Corners of triangle t of meshlet m, and its geometric normal (any length). */
static void triangle_get(const double *corner[3], double normal[3], const struct ref_meshlet *m, unsigned t)
{
    double e[2][3];
    for (int k = 0; k < 3; k++)
        corner[k] = ref->vertices[m->vertex_first + ref->triangles[m->triangle_first + t][k]].position;
    for (int k = 0; k < 3; k++) {
        e[0][k] = corner[1][k] - corner[0][k];
        e[1][k] = corner[2][k] - corner[0][k];
    }
    for (int k = 0; k < 3; k++)
        normal[k] = e[0][(k + 1) % 3] * e[1][(k + 2) % 3] - e[0][(k + 2) % 3] * e[1][(k + 1) % 3];
}

static void boxes_are_tight(void **state)
{
    (void)state;
    for (unsigned i = 0; i < ref->mesh_count; i++) {
        double lo[3] = {1e9, 1e9, 1e9}, hi[3] = {-1e9, -1e9, -1e9};
        const struct scene_lod *first = &six.lods[six.meshes[i].lod_first], *last = first + six.meshes[i].lod_count - 1;
        for (unsigned j = first->meshlet_first; j < last->meshlet_first + last->meshlet_count;
             j++) { /* of all levels */
            const struct ref_meshlet *m = &ref->meshlets[j];
            for (int k = 0; k < 3; k++) {
                double least = 1e9, most = -1e9;
                for (unsigned v = m->vertex_first; v < m->vertex_first + m->vertex_count; v++) {
                    least = fmin(least, ref->vertices[v].position[k]);
                    most = fmax(most, ref->vertices[v].position[k]);
                }
                assert_true(m->lo[k] == least && m->hi[k] == most);
                lo[k] = fmin(lo[k], least);
                hi[k] = fmax(hi[k], most);
            }
        }
        double largest = 0;
        for (int k = 0; k < 3; k++) {
            assert_true(ref->meshes[i].lo[k] == lo[k] && ref->meshes[i].hi[k] == hi[k]);
            largest = fmax(largest, fmax(-lo[k], hi[k]));
        }
        assert_true(largest == 32767); /* the whole range is used */
    }
}

static bool is_finest(unsigned meshlet)
{
    for (unsigned i = 0; i < ref->mesh_count; i++)
        if (meshlet - ref->meshes[i].meshlet_first < ref->meshes[i].meshlet_count)
            return true;
    return false;
}

/* Is the whole box in the (convex) region where the cone test culls? */
static bool cone_culls(const struct ref_meshlet *m, const double eye[3])
{
    for (int i = 0; i < 8; i++) {
        double d[3];
        for (int k = 0; k < 3; k++)
            d[k] = (i >> k & 1 ? m->hi[k] : m->lo[k]) - eye[k];
        if (!(dot(d, m->frame[2]) >= m->cone_cutoff * sqrt(dot(d, d))))
            return false;
    }
    return m->cone_cutoff < 1;
}

static void cones_never_cull_a_triangle_that_faces_the_eye(void **state)
{
    (void)state;
    unsigned culled[2] = {0, 0}, hidden[2] = {0, 0}; /* of coarser levels, of the finest */
    for (unsigned i = 0; i < ref->meshlet_count; i++) {
        const struct ref_meshlet *m = &ref->meshlets[i];
        for (int n = 0; n < 200; n++) {
            double eye[3], reach = n % 2 ? 2e5 : 4e4;
            bool faces = false;
            for (int k = 0; k < 3; k++)
                eye[k] = reach * random_signed();
            for (unsigned t = 0; t < m->triangle_count && !faces; t++) {
                const double *corner[3];
                double normal[3], d[3];
                triangle_get(corner, normal, m, t);
                for (int k = 0; k < 3; k++)
                    d[k] = eye[k] - corner[0][k];
                faces = dot(d, normal) > 0;
            }
            hidden[is_finest(i)] += !faces;
            if (cone_culls(m, eye)) {
                culled[is_finest(i)]++;
                assert_false(faces);
            }
        }
    }
    /* not by disabling the test: it finds most of what can be found */
    print_message("# cones cull %.1f %% of the finest meshlets that face away, %.1f %% of coarser ones\n",
                  100.0 * culled[1] / hidden[1], 100.0 * culled[0] / hidden[0]);
    assert_true(culled[1] > 0.7 * hidden[1] && culled[0] > 0.3 * hidden[0]);
}

static void cone_cutoffs_are_the_sine_of_the_widest_normal_rounded_up(void **state)
{
    (void)state;
    for (unsigned i = 0; i < ref->meshlet_count; i++) {
        const struct ref_meshlet *m = &ref->meshlets[i];
        double z_length = sqrt(dot(m->frame[2], m->frame[2])), sine = 0;
        for (unsigned t = 0; t < m->triangle_count; t++) {
            const double *corner[3];
            double g[3], across = 0;
            triangle_get(corner, g, m, t);
            double along = dot(g, m->frame[2]) / z_length;
            for (int k = 0; k < 3; k++)
                across += pow(g[k] - along * m->frame[2][k] / z_length, 2);
            sine = along <= 0 ? 2 : fmax(sine, sqrt(across / dot(g, g)));
        }
        /* the test multiplies by the rounded axis, whose length differs from 1: the cutoff makes good for it */
        assert_true(m->cone_cutoff >= fmin(1, sine * z_length));
        assert_true(m->cone_cutoff <= sine + 4.0 / 16384 || m->cone_cutoff == 1);
    }
}

/* At most 1.23 times as a length is estimated, and a ninth as the codes' steps are. */
static void sizes_are_the_triangles_sums_rounded_up(void **state)
{
    (void)state;
    double area_ratio = 0, perimeter_ratio = 0;
    for (unsigned i = 0; i < ref->meshlet_count; i++) {
        const struct ref_meshlet *m = &ref->meshlets[i];
        double area = 0, perimeter = 0;
        for (unsigned t = 0; t < m->triangle_count; t++) {
            const double *corner[3];
            double g[3];
            triangle_get(corner, g, m, t);
            area += sqrt(dot(g, g)) / 2;
            for (int k = 0; k < 3; k++) {
                const double *a = corner[k], *b = corner[(k + 1) % 3];
                perimeter += sqrt(pow(a[0] - b[0], 2) + pow(a[1] - b[1], 2) + pow(a[2] - b[2], 2));
            }
        }
        assert_true(m->area >= area && m->area <= 1.4 * area + 512);
        assert_true(m->perimeter >= perimeter && m->perimeter <= 1.4 * perimeter + 8);
        area_ratio += m->area / area / ref->meshlet_count;
        perimeter_ratio += m->perimeter / perimeter / ref->meshlet_count;
    }
    print_message("# stored over true, mean: area %.3f, perimeter %.3f\n", area_ratio, perimeter_ratio);
}

static void meshes_are_closed_and_face_outwards(void **state)
{
    (void)state;
    for (unsigned i = 0; i < ref->mesh_count; i++) {
        const struct ref_mesh *mesh = &ref->meshes[i];
        enum { SLOTS = 1 << 16 };
        /* Edges by their end points: +1 in one direction, -1 in the other; equal hashes share a slot. */
        int *balance = calloc(SLOTS, sizeof *balance);
        double volume = 0;
        for (unsigned j = 0; j < mesh->meshlet_count; j++) {
            const struct ref_meshlet *m = &ref->meshlets[mesh->meshlet_first + j];
            for (unsigned t = 0; t < m->triangle_count; t++) {
                const double *corner[3];
                double normal[3];
                triangle_get(corner, normal, m, t);
                volume += dot(normal, corner[0]);
                for (int k = 0; k < 3; k++) {
                    const double *a = corner[k], *b = corner[(k + 1) % 3];
                    int order = memcmp(a, b, 3 * sizeof *a);
                    const double *first = order < 0 ? a : b, *second = order < 0 ? b : a;
                    uint32_t hash = 0;
                    for (int c = 0; c < 6; c++)
                        hash = (hash ^ (uint32_t)((c < 3 ? first[c] : second[c - 3]) + 40000)) * 2654435761u;
                    balance[hash >> 16] += order < 0 ? 1 : -1;
                }
            }
        }
        for (int j = 0; j < SLOTS; j++)
            assert_int_equal(balance[j], 0);
        assert_true(volume > 0);
        free(balance);
    }
}

/* The sphere (mesh 0) has its normals and radius by definition, whatever gtscene did. Positions are rounded to half a
 * unit of 32767 per axis; normals by 2^-15 in u and v, which doubles, and by the frame's own rounding. */
static void sphere_is_within_the_quantisation_bounds(void **state)
{
    (void)state;
    double worst_angle = 0, worst_radius = 0;
    for (unsigned j = 0; j < ref->meshes[0].meshlet_count; j++) {
        const struct ref_meshlet *m = &ref->meshlets[ref->meshes[0].meshlet_first + j];
        for (unsigned v = m->vertex_first; v < m->vertex_first + m->vertex_count; v++) {
            const double *p = ref->vertices[v].position, *n = ref->vertices[v].normal;
            double length = sqrt(dot(p, p)), across = 0;
            for (int k = 0; k < 3; k++)
                across += pow(n[k] - p[k] / length, 2);
            worst_angle = fmax(worst_angle, sqrt(across));
            worst_radius = fmax(worst_radius, fabs(length - 32767));
        }
    }
    print_message("# sphere: normals within %.2e rad, radius within %.2f units\n", worst_angle, worst_radius);
    assert_true(worst_radius <= 0.8661); /* sqrt(3)/2 */
    assert_true(worst_angle <= 2e-4);
}

static void normals_agree_with_the_triangles(void **state)
{
    (void)state;
    /* Every vertex normal of a finest level is within 60 degrees of its triangles': no flipped or garbled one. */
    for (unsigned i = 0; i < ref->meshlet_count; i++)
        for (unsigned t = 0; t < ref->meshlets[i].triangle_count && is_finest(i); t++) {
            const struct ref_meshlet *m = &ref->meshlets[i];
            const double *corner[3];
            double g[3];
            triangle_get(corner, g, m, t);
            for (int k = 0; k < 3; k++) {
                const double *n = ref->vertices[m->vertex_first + ref->triangles[m->triangle_first + t][k]].normal;
                assert_true(dot(n, g) > 0.5 * sqrt(dot(g, g)));
            }
        }
}

int main(void)
{
    const struct CMUnitTest built[] = {
        cmocka_unit_test(benchmark_scene_is_what_it_says),
        cmocka_unit_test(reference_reader_agrees_with_the_structures),
        cmocka_unit_test(boxes_are_tight),
        cmocka_unit_test(cones_never_cull_a_triangle_that_faces_the_eye),
        cmocka_unit_test(cone_cutoffs_are_the_sine_of_the_widest_normal_rounded_up),
        cmocka_unit_test(sizes_are_the_triangles_sums_rounded_up),
        cmocka_unit_test(meshes_are_closed_and_face_outwards),
        cmocka_unit_test(sphere_is_within_the_quantisation_bounds),
        cmocka_unit_test(normals_agree_with_the_triangles),
    };
    return cmocka_run_group_tests(built, open_six, close_six);
}
