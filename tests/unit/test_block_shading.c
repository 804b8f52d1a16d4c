/*
 * Shading of a tile of hand-made surfaces, each pixel with a normal of its own, by one light: every model and table against
 * double precision, from the same stored normals, the same light and each pixel's own view ray. Errors are in steps of the 8-bit
 * picture: the irradiance is pi, no tone curve, sRGB.
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "internal.h"
#include "ref_blob.h"
#include "ref_render.h"

enum { TILES = 12, PIXELS = RASTER_TILE_WIDTH * RASTER_TILE_HEIGHT };
static const uint32_t pi_16 = 205887;

static uint64_t seed = 1;

static uint32_t random32(void)
{
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    uint32_t x = (uint32_t)(seed >> 33);
    return x * 2654435761u ^ x >> 15;
}

static double uniform(double low, double high)
{
    return low + (high - low) * random32() * 0x1p-32;
}

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

static void random_direction(double v[3])
{
    double z = uniform(-1, 1), a = uniform(0, 6.283185307179586), r = sqrt(1 - z * z);
    v[0] = r * cos(a), v[1] = r * sin(a), v[2] = z;
}

/* Nearest q17_15_t components, no larger than 32767 as in a batch, of a direction of unit length. */
static struct vec3 quantise(const double v[3])
{
    int32_t q[3];
    for (int i = 0; i < 3; i++)
        q[i] = fx_clamp((int32_t)lrint(v[i] * 32768), -32767, 32767);
    return (struct vec3){q[0], q[1], q[2]};
}

static void direction_of(double out[3], struct vec3 v)
{
    out[0] = v.x, out[1] = v.y, out[2] = v.z;
    normalise(out);
}

static struct {
    struct raster r;
    struct raster_tile tile;
    struct scene scene; /* one object that does not show */
    void *blob;
    struct scene_light light;
    struct scene_material material;
    const struct lut_table *tables[RASTER_MAX_SLOTS];
    struct scene_camera camera;
    uint64_t arena[1 << 16];
} k;

static int make_scene(void **state)
{
    struct ref_blob b;
    size_t bytes;
    (void)state;
    ref_blob_init(&b);
    ref_blob_light(&b, (const double[3]){0, 0, 1}, 3);
    ref_blob_material(&b, 1, 0, 0.5, "grey");
    const int16_t v[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    const uint16_t t[1][3] = {{0, 1, 2}};
    ref_blob_object(&b, ref_blob_mesh(&b, v, t, 1), 0, (const double[3]){0, 0, 9}, 1);
    k.blob = ref_blob_finish(&b, &bytes);
    ref_blob_free(&b);
    return scene_open(&k.scene, k.blob, bytes) != SCENE_OK;
}

static int free_scene(void **state)
{
    (void)state;
    free(k.blob);
    return 0;
}

struct subject {
    struct scene_material material;
    struct ref_material model;
    struct lut_table lut;
    struct ref_table *ref; /* NULL: the model */
    void *file;
};

/* A frame of the subject's material under one light; a vertical field of view of 45 degrees. */
static void frame_begin(const struct subject *s, unsigned width, unsigned height, struct vec3 light,
                        uint32_t irradiance)
{
    k.material = s->material;
    k.tables[0] = s->ref ? &s->lut : NULL;
    k.camera = k.scene.header->camera;
    k.camera.focal = 158217;
    k.light = (struct scene_light){.kind = SCENE_LIGHT_DIRECTIONAL,
                                   .direction = {light.x * 32768, light.y * 32768, light.z * 32768},
                                   .irradiance = {irradiance, irradiance, irradiance}};
    struct raster_frame f = {.scene = &k.scene,
                             .camera = &k.camera,
                             .output = &k.scene.header->output,
                             .lights = &k.light,
                             .materials = &k.material,
                             .tables = k.tables,
                             .width = (uint16_t)width,
                             .height = (uint16_t)height,
                             .light_count = 1,
                             .format = RASTER_RGB888};
    assert_int_equal(raster_begin(&k.r, &f, k.arena, sizeof k.arena), RASTER_OK);
    memset(&k.tile, 0, sizeof k.tile);
    k.tile.slots[1] = (struct raster_slot){{1 << 14, 0, 0, 0, 1 << 14, 0, 0, 0, 1 << 14}, 0, 0};
    k.tile.slot_count = 1;
}

static void view_of(double v[3], unsigned x, unsigned y)
{
    double scale = k.r.frame.height * (k.camera.focal / 65536.0);
    v[0] = -(2.0 * x + 1 - k.r.frame.width) / scale, v[1] = (2.0 * y + 1 - k.r.frame.height) / scale, v[2] = 1;
    normalise(v);
}

static void reference(double radiance[3], const struct subject *s, const double n[3], const double l[3],
                      const double v[3])
{
    double f[3];
    if (s->ref)
        ref_table_eval(f, s->ref, n, l, v);
    else if (s->model.kind == REF_BLINN_PHONG)
        ref_blinn_phong(f, &s->model, n, l, v);
    else
        ref_model_value(f, &s->model, n, l, v);
    const double pi = 3.14159265358979323846, kind = s->model.kind;
    double scale = pi_16 / 65536.0, ambient = 0;
    scale *= kind == REF_BLINN_PHONG ? 1 / pi : fmax(dot(n, l), 0);
    if (!s->ref)
        ambient = kind == REF_BLINN_PHONG ? 0.02 : kind == REF_METALLIC_ROUGHNESS ? 0.05 : 0;
    for (int c = 0; c < 3; c++)
        radiance[c] = f[c] * scale + ambient * s->model.kd[c];
}

enum normals {
    NORMALS_SPHERE,    /* as often as a sphere shows them */
    NORMALS_HIGHLIGHT, /* the half vector and around it: within a degree as often as within 60 */
    NORMALS_GRAZING    /* n.v = 0.05 and around it */
};

/* As a surface in slot 1 stores it, and then exactly what is stored. */
static struct raster_surface random_surface(double n[3], const double l[3], const double v[3], enum normals kind)
{
    const int32_t d = 16383;
    for (;;) {
        double spread = exp(uniform(-9, 0)), square;
        random_direction(n);
        if (kind == NORMALS_SPHERE) { /* uniform over the disk that it shows */
            double height = dot(n, v), rest = sqrt(1 - height * height), radius = sqrt(uniform(0, 1));
            for (int c = 0; c < 3; c++)
                n[c] = radius * (n[c] - height * v[c]) / rest + sqrt(1 - radius * radius) * v[c];
        } else {
            for (int c = 0; c < 3; c++)
                n[c] = kind == NORMALS_HIGHLIGHT ? l[c] + v[c] + spread * n[c] : n[c] - (dot(n, v) - 0.05) * v[c];
        }
        normalise(n);
        if (n[2] < -0.5)
            continue;
        int32_t u = (int32_t)lrint(d * n[0] / (1 + n[2])), w = (int32_t)lrint(d * n[1] / (1 + n[2]));
        square = (double)u * u + (double)w * w + (double)d * d;
        n[0] = 2.0 * u * d / square, n[1] = 2.0 * w * d / square, n[2] = 2.0 * d * d / square - 1;
        if (dot(n, v) >= 1.0 / 120)
            return (struct raster_surface){((uint32_t)d + DEPTH_BIAS) << 8 | 1,
                                           (uint32_t)(u & 0xffff) | (uint32_t)w << 16};
    }
}

/* Shades a tile anywhere in the picture; the error of each of its pixels, in steps, into e. */
static void shade_tile(double *e, const struct subject *s, const double light[3], enum normals normals, unsigned width,
                       unsigned height)
{
    static double normal[PIXELS][3], view[PIXELS][3];
    const struct raster_rect rect = {(uint16_t)(random32() % (width / RASTER_TILE_WIDTH) * RASTER_TILE_WIDTH),
                                     (uint16_t)(random32() % (height / RASTER_TILE_HEIGHT) * RASTER_TILE_HEIGHT),
                                     RASTER_TILE_WIDTH, RASTER_TILE_HEIGHT};
    struct raster_stats stats = {0};
    double l[3];
    frame_begin(s, width, height, quantise(light), pi_16);
    direction_of(l, quantise(light));
    for (unsigned i = 0; i < PIXELS; i++) {
        view_of(view[i], rect.x + i % RASTER_TILE_WIDTH, rect.y + i / RASTER_TILE_WIDTH);
        k.tile.surface[i] = random_surface(normal[i], l, view[i], normals);
    }
    raster_shade_tile(&k.r, &k.tile, &rect, &stats);
    assert_int_equal(stats.covered, PIXELS);
    const uint8_t *pixels = raster_tile_pixels(&k.tile);
    for (unsigned i = 0; i < PIXELS; i++) {
        double want[3], display[3];
        reference(want, s, normal[i], l, view[i]);
        ref_tone(display, want, 0);
        e[i] = 0;
        for (int c = 0; c < 3; c++)
            e[i] = fmax(e[i], fabs(pixels[3 * i + (unsigned)c] - floor(display[c] + 0.5)));
    }
}

/* Lights anywhere; a quarter of them near the camera's direction, where l - v is short. */
static void check_normals(const char *name, const struct subject *s, enum normals normals, double within, double max)
{
    static const unsigned size[3][2] = {{320, 240}, {1280, 720}, {3840, 2160}};
    static double e[TILES * PIXELS];
    for (unsigned i = 0; i < TILES; i++) {
        double l[3];
        random_direction(l);
        for (int c = 0; c < 3 && i % 4 == 0; c++)
            l[c] = exp(-1.0 - i / 2) * l[c] + (c == 2);
        normalise(l);
        shade_tile(e + i * PIXELS, s, l, normals, size[i % 3][0], size[i % 3][1]);
    }
    double right = 0, near = 0, count = TILES * PIXELS, worst = 0;
    for (unsigned i = 0; i < TILES * PIXELS; i++) {
        right += e[i] < 0.5;
        near += e[i] < 1.5;
        worst = fmax(worst, e[i]);
    }
    print_message("# %s: %.2f %% right, %.3f %% within a step, max %g\n", name, 100 * right / count, 100 * near / count,
                  worst);
    assert_true(100 * near / count >= within && worst <= max);
}

struct limits {
    double within, most; /* percent of pixels within a step, steps */
};
static const struct limits sphere = {99.9, 8}, highlight = {97, 26}, grazing = {99.5, 26};
/* Beside the horizon g = f (n.l + n.v) falls to nothing within a row, of which fractions have eight bits: dark pixels. */
static const struct limits half_sphere = {99.5, 16}, half_highlight = {99, 26}, half_grazing = {80, 45};
/* (n.h)^1 ends in a kink at the horizon that the table of powers rounds off. */
static const struct limits kink_sphere = {93, 75}, kink_grazing = {78, 75};

/* Frees the subject. */
static void check_limits(const char *name, struct subject s, struct limits a, struct limits b, struct limits c)
{
    char text[128];
    check_normals(name, &s, NORMALS_SPHERE, a.within, a.most);
    snprintf(text, sizeof text, "%s, highlight", name);
    check_normals(text, &s, NORMALS_HIGHLIGHT, b.within, b.most);
    snprintf(text, sizeof text, "%s, grazing", name);
    check_normals(text, &s, NORMALS_GRAZING, c.within, c.most);
    free(s.file);
    ref_table_free(s.ref);
}

static void check(const char *name, struct subject s)
{
    check_limits(name, s, sphere, highlight, grazing);
}

static void check_half(const char *name, struct subject s)
{
    check_limits(name, s, half_sphere, half_highlight, half_grazing);
}

static uint32_t fixed16(double x)
{
    return (uint32_t)lrint(x * 65536);
}

static struct subject model_subject(enum scene_material_kind kind, enum ref_model_kind ref, double kd, double ks,
                                    double exponent)
{
    struct subject s = {.material = {.kind = (uint8_t)kind,
                                     .kd = {fixed16(kd), fixed16(kd / 2), 0},
                                     .ks = {fixed16(ks), 0, fixed16(ks / 2)},
                                     .exponent = fixed16(exponent)},
                        .model = {.kind = ref, .exponent = fixed16(exponent) / 65536.0}};
    for (int c = 0; c < 3; c++) {
        s.model.kd[c] = s.material.kd[c] / 65536.0;
        s.model.ks[c] = s.material.ks[c] / 65536.0;
    }
    return s;
}

static struct subject metallic_subject(double roughness, double metalness)
{
    struct subject s = model_subject(SCENE_MATERIAL_METALLIC_ROUGHNESS, REF_METALLIC_ROUGHNESS, 0.9, 0, 0);
    s.material.roughness = fixed16(roughness);
    s.material.metalness = fixed16(metalness);
    s.model.roughness = s.material.roughness / 65536.0;
    s.model.metalness = s.material.metalness / 65536.0;
    return s;
}

static struct subject table_subject(void *file, size_t bytes)
{
    struct subject s = {.material = {.kind = SCENE_MATERIAL_MEASURED}, .file = file};
    assert_int_equal(lut_open(&s.lut, file, bytes), LUT_OK);
    s.ref = ref_table_open(file, bytes);
    assert_non_null(s.ref);
    return s;
}

static struct subject half_subject(unsigned h, unsigned d, unsigned t, double alpha, double metalness, int scale,
                                   int slabs)
{
    struct ref_material m = {
        .kind = REF_METALLIC_ROUGHNESS, .kd = {0.9, 0.5, 0.1}, .metalness = metalness, .roughness = sqrt(alpha)};
    struct ref_half f = {.t = t, .h = h, .d = d, .scale = scale, .slabs = slabs};
    size_t bytes;
    ref_half_warp(&f, alpha);
    ref_half_sample(&f, ref_brdf_of_material, &m);
    void *file = ref_half_make(&f, &bytes);
    free((void *)f.texels);
    return table_subject(file, bytes);
}

/* A lobe around the mirror direction on a diffuse base. */
static struct subject frame_subject(unsigned width, unsigned height, unsigned depth, bool swap)
{
    uint32_t *texels = malloc(sizeof *texels * width * height * depth);
    struct ref_keys keys = {.count = 0};
    size_t bytes;
    for (unsigned i = 0; i < width * height * depth; i++) {
        double theta = 180.0 * (i / width % height) / (height - 1), phi = 6.283185307179586 * (i % width) / (width - 1);
        double degrees = 8 - (i / width / height) * (1 + 0.5 * cos(phi) * sin(theta / 57.3));
        double f = 0.2 + 4 * exp(-theta * theta / (degrees * degrees));
        texels[i] = ref_rgb9e5_encode((const double[3]){f, f * 0.75, f * 0.5});
    }
    ref_key_set_text(&keys, "goniotile.kind", "specular_frame");
    ref_key_set_text(&keys, "goniotile.swap", swap ? "1" : "0");
    ref_key_set_text(&keys, "goniotile.theta_max", "60000");
    ref_key_set_text(&keys, "goniotile.version", "1");
    void *file = ref_ktx2_write(width, height, depth, texels, &keys, &bytes);
    ref_keys_free(&keys);
    free(texels);
    return table_subject(file, bytes);
}

static void lafortune_phong_agrees(void **state)
{
    (void)state;
    static const double exponents[] = {2, 3.5, 32, 1000, 4096};
    for (size_t i = 0; i < sizeof exponents / sizeof *exponents; i++) {
        char name[64];
        snprintf(name, sizeof name, "Lafortune-Phong, exponent %g", exponents[i]);
        check(name, model_subject(SCENE_MATERIAL_LAFORTUNE_PHONG, REF_LAFORTUNE_PHONG, 0.7,
                                  exponents[i] > 100 ? 0.05 : 0.9, exponents[i]));
    }
}

static void blinn_phong_agrees(void **state)
{
    (void)state;
    static const double exponents[] = {2, 3.5, 32, 1000, 4096};
    for (size_t i = 0; i < sizeof exponents / sizeof *exponents; i++) {
        char name[64];
        snprintf(name, sizeof name, "Blinn-Phong, exponent %g", exponents[i]);
        check(name, model_subject(SCENE_MATERIAL_BLINN_PHONG, REF_BLINN_PHONG, 0.2, 0.8, exponents[i]));
    }
}

static void exponents_of_one_agree_but_at_the_kink(void **state)
{
    (void)state;
    check_limits("Lafortune-Phong, exponent 1",
                 model_subject(SCENE_MATERIAL_LAFORTUNE_PHONG, REF_LAFORTUNE_PHONG, 0.7, 0.9, 1), kink_sphere,
                 highlight, kink_grazing);
    check_limits("Blinn-Phong, exponent 1", model_subject(SCENE_MATERIAL_BLINN_PHONG, REF_BLINN_PHONG, 0.2, 0.8, 1),
                 kink_sphere, highlight, kink_grazing);
}

static void metallic_roughness_agrees(void **state)
{
    (void)state;
    static const double roughness[] = {0.1, 0.3, 0.5, 0.8, 1};
    for (size_t i = 0; i < 2 * sizeof roughness / sizeof *roughness; i++) {
        char name[64];
        snprintf(name, sizeof name, "metallic-roughness, roughness %g, metalness %zu", roughness[i / 2], i % 2);
        check(name, metallic_subject(roughness[i / 2], (double)(i % 2)));
    }
    check("metallic-roughness, roughness 0.4, metalness 0.3", metallic_subject(0.4, 0.3));
}

static void half_vector_rough_agrees(void **state)
{
    (void)state;
    check_half("half-vector 64x32x8, alpha 0.3, dielectric", half_subject(64, 32, 8, 0.3, 0, 0, 0));
}

static void half_vector_glossy_agrees(void **state)
{
    (void)state;
    check_half("half-vector 64x32x8, alpha 0.05, metal", half_subject(64, 32, 8, 0.05, 1, 0, 0));
    check_half("the same, texels times 2^-3", half_subject(64, 32, 8, 0.05, 1, -3, 0));
    check_half("half-vector 21x16x3, alpha 0.1", half_subject(21, 16, 3, 0.1, 0, 2, 0));
}

static void specular_frame_agrees(void **state)
{
    (void)state;
    check("specular frame 361x181x4", frame_subject(361, 181, 4, false));
    check("specular frame 181x91x7 with swap", frame_subject(181, 91, 7, true));
}

/* The re-packed copy gives the same bits. */
static void slabs_change_no_bit(void **state)
{
    (void)state;
    struct subject s[2] = {half_subject(64, 32, 8, 0.05, 0, 0, 0), half_subject(64, 32, 8, 0.05, 0, 0, 1)};
    static uint8_t pixels[3 * PIXELS];
    static double e[PIXELS];
    assert_true(!s[0].lut.slabs && s[1].lut.slabs);
    for (int i = 0; i < 6; i++) {
        uint64_t before = seed;
        for (int j = 0; j < 2; j++) {
            double l[3];
            seed = before;
            random_direction(l);
            l[2] = fabs(l[2]);
            shade_tile(e, &s[j], l, i % 3, 320, 224);
            if (j)
                assert_memory_equal(pixels, raster_tile_pixels(&k.tile), sizeof pixels);
            memcpy(pixels, raster_tile_pixels(&k.tile), sizeof pixels);
        }
    }
    for (int j = 0; j < 2; j++) {
        free(s[j].file);
        ref_table_free(s[j].ref);
    }
}

/* Under the brightest light there is, the highlight is white: nothing wraps around. */
static void radiance_saturates(void **state)
{
    (void)state;
    struct subject s[] = {model_subject(SCENE_MATERIAL_LAFORTUNE_PHONG, REF_LAFORTUNE_PHONG, 1, 1, 4096),
                          model_subject(SCENE_MATERIAL_BLINN_PHONG, REF_BLINN_PHONG, 1, 1, 3),
                          metallic_subject(0.04, 1),
                          half_subject(64, 32, 8, 0.01, 1, 0, 0),
                          half_subject(64, 32, 8, 0.01, 1, 0, 1),
                          frame_subject(19, 10, 4, false)};
    for (size_t i = 0; i < sizeof s / sizeof *s; i++) {
        const struct raster_rect rect = {128, 96, RASTER_TILE_WIDTH, RASTER_TILE_HEIGHT};
        struct raster_stats stats = {0};
        double v[3];
        view_of(v, 160, 112);
        frame_begin(&s[i], 320, 240, quantise(v), UINT32_MAX);
        int32_t d = 16383, u = (int32_t)lrint(d * v[0] / (1 + v[2])), w = (int32_t)lrint(d * v[1] / (1 + v[2]));
        for (unsigned j = 0; j < PIXELS; j++)
            k.tile.surface[j] = (struct raster_surface){((uint32_t)d + DEPTH_BIAS) << 8 | 1,
                                                        (uint32_t)(u & 0xffff) | (uint32_t)w << 16};
        raster_shade_tile(&k.r, &k.tile, &rect, &stats);
        for (unsigned j = 0; j < PIXELS; j++)
            assert_int_equal(raster_tile_pixels(&k.tile)[3 * j], 255);
        free(s[i].file);
        ref_table_free(s[i].ref);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lafortune_phong_agrees),
        cmocka_unit_test(blinn_phong_agrees),
        cmocka_unit_test(exponents_of_one_agree_but_at_the_kink),
        cmocka_unit_test(metallic_roughness_agrees),
        cmocka_unit_test(half_vector_rough_agrees),
        cmocka_unit_test(half_vector_glossy_agrees),
        cmocka_unit_test(specular_frame_agrees),
        cmocka_unit_test(slabs_change_no_bit),
        cmocka_unit_test(radiance_saturates),
    };
    return cmocka_run_group_tests(tests, make_scene, free_scene);
}
