/*
 * Shading of a tile of hand-made surfaces, each pixel with a normal of its own, by one light: every model and table against
 * double precision, from the same stored normals, the same light and each pixel's own view ray. Errors are in steps of the 8-bit
 * picture: the irradiance is pi, no tone curve, sRGB.
 */
#include "tile_fixture.h"

enum { TILES = 12 };

enum normals {
    NORMALS_SPHERE,    /* as often as a sphere shows them */
    NORMALS_HIGHLIGHT, /* the half vector and around it: within a degree as often as within 60 */
    NORMALS_GRAZING    /* n.v = 0.05 and around it */
};

static struct raster_surface random_surface(double n[3], const double l[3], const double v[3], enum normals kind)
{
    for (;;) {
        double spread = exp(uniform(-9, 0));
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
        struct raster_surface s = store_normal(n);
        if (dot(n, v) >= 1.0 / 120)
            return s;
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
    seed = 1;
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
/* What five other seeds left room for; most of them have 99.9 % within a step and at most 4. */
static const struct limits sphere = {99.8, 12}, highlight = {95, 35}, grazing = {99.5, 10};
/* Beside the horizon g = f (n.l + n.v) falls to nothing within a row, of which fractions have eight bits: dark pixels. */
static const struct limits half_sphere = {99, 30}, half_highlight = {99.5, 20}, half_grazing = {92, 45};
/* (n.h)^1 ends in a kink at the horizon that the table of powers rounds off. */
static const struct limits kink_sphere = {93, 75}, kink_highlight = {99, 75}, kink_grazing = {80, 75};

/* Frees the subject. */
static void check_limits(const char *name, struct subject s, struct limits a, struct limits b, struct limits c)
{
    char text[128];
    check_normals(name, &s, NORMALS_SPHERE, a.within, a.most);
    snprintf(text, sizeof text, "%s, highlight", name);
    check_normals(text, &s, NORMALS_HIGHLIGHT, b.within, b.most);
    snprintf(text, sizeof text, "%s, grazing", name);
    check_normals(text, &s, NORMALS_GRAZING, c.within, c.most);
    subject_free(&s);
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
                 kink_highlight, kink_grazing);
    check_limits("Blinn-Phong, exponent 1", model_subject(SCENE_MATERIAL_BLINN_PHONG, REF_BLINN_PHONG, 0.2, 0.8, 1),
                 kink_sphere, kink_highlight, kink_grazing);
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
        subject_free(&s[j]);
    }
}

/* Exponents of cells below those of their texels, as no honest writer says: wrong pixels, and nothing worse. */
static void cells_that_lie_do_no_harm(void **state)
{
    (void)state;
    struct ref_half f = {.t = 8, .h = 32, .d = 16, .slabs = 1};
    uint32_t *texels = malloc(sizeof *texels * 8 * 32 * 16);
    for (unsigned i = 0; i < 8 * 32 * 16; i++)
        texels[i] = random32();
    f.texels = texels;
    ref_half_warp(&f, 0.05);
    for (int lie = 0; lie < 6; lie++) {
        static double e[PIXELS];
        struct ref_keys keys;
        size_t bytes;
        ref_half_keys(&keys, &f);
        for (size_t j = 0; j < 31 * 15; j++) {
            const uint8_t said = (uint8_t)(lie < 2 ? 31u * (unsigned)lie : random32() % 32);
            for (unsigned i = 0; i < keys.count; i++) {
                if (!strcmp(keys.key[i].name, "goniotile.cells"))
                    keys.key[i].value[j] = said;
                if (!strcmp(keys.key[i].name, "goniotile.slabs")) /* which agrees, or is refused */
                    keys.key[i].value[4 * j] = said;
            }
        }
        if (lie % 2)
            ref_key_remove(&keys, "goniotile.slabs");
        void *file = ref_ktx2_write(f.t, f.h, f.d, texels, &keys, &bytes);
        ref_keys_free(&keys);
        struct subject s = table_subject(file, bytes);
        for (int i = 0; i < 3; i++) {
            double l[3];
            random_direction(l);
            l[2] = fabs(l[2]);
            shade_tile(e, &s, l, (enum normals)i, 1280, 704);
        }
        subject_free(&s);
    }
    free(texels);
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
        struct raster_surface facing = store_normal(v);
        for (unsigned j = 0; j < PIXELS; j++)
            k.tile.surface[j] = facing;
        raster_shade_tile(&k.r, &k.tile, &rect, &stats);
        for (unsigned j = 0; j < PIXELS; j++)
            assert_int_equal(raster_tile_pixels(&k.tile)[3 * j], 255);
        subject_free(&s[i]);
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
        cmocka_unit_test(cells_that_lie_do_no_harm),
        cmocka_unit_test(radiance_saturates),
    };
    return cmocka_run_group_tests(tests, make_scene, free_scene);
}
