/*
 * Lobes far below a degree, as fitted half-vector tables: they create no energy, and a sphere seen in perspective shows them as
 * double precision does, from 240 to 2160 lines. The view direction turns by degrees over a shading block of the small pictures and
 * a pixel's step in the normal is several lobes there: whatever is held constant shows.
 */
#include "tile_fixture.h"

#include "host_half_vector.h"

static void source_value(double rgb[3], const void *material, const double l[3], const double v[3])
{
    const double n[3] = {0, 0, 1};
    ref_model_value(rgb, material, n, l, v);
}

/* GGX of this width with the reflectance of a perfect mirror, fitted to 16384 texels. */
static struct subject fit(double alpha)
{
    struct ref_material m = {.kind = REF_MICROFACET, .eta = {1, 1, 1}, .k = {1e6, 1e6, 1e6}, .roughness = sqrt(alpha)};
    struct brdf_source source = {
        .name = "ggx", .value = source_value, .ctx = &m, .theta_in = 90, .theta_out = 90, .symmetric = true};
    struct half_vector_options options = {.texels = 16384};
    struct half_vector table;
    struct half_vector_report report;
    size_t bytes;
    half_vector_build(&table, &report, &source, &options);
    uint8_t *file = half_vector_compose(&bytes, &table, NULL, 0, true);
    half_vector_free(&table);
    struct subject s = table_subject(file, bytes);
    s.model = m;
    return s;
}

static const double alphas[] = {0.003, 0.01, 0.02};
enum { COUNT = sizeof alphas / sizeof *alphas };
static struct subject subjects[COUNT];

static int set_up(void **state)
{
    for (int i = 0; i < COUNT; i++)
        subjects[i] = fit(alphas[i]);
    return make_scene(state);
}

static int tear_down(void **state)
{
    for (int i = 0; i < COUNT; i++)
        subject_free(&subjects[i]);
    return free_scene(state);
}

/* A BRDF of the product's table, from vectors rounded to Q15. */
static void product(double rgb[3], const void *subject, const double n[3], const double l[3], const double v[3])
{
    struct lut_rgb out;
    lut_eval(&out, &((const struct subject *)subject)->lut, quantise(n), quantise(l), quantise(v));
    for (int c = 0; c < 3; c++)
        rgb[c] = ldexp(out.c[c], out.e);
}

/* Point samples one degree apart give 6.06 and 1.18 for the first two. */
static void no_energy_is_created(void **state)
{
    (void)state;
    for (int i = 0; i < COUNT; i++) {
        char text[128] = "";
        double worst = 0;
        for (int angle = 0; angle <= 80; angle += 10) {
            double albedo[3], exact[3];
            ref_albedo(albedo, product, &subjects[i], angle * 0.0174533, 160);
            ref_albedo(exact, ref_brdf_of_material, &subjects[i].model, angle * 0.0174533, 160);
            snprintf(text + strlen(text), sizeof text - strlen(text), " %.4f", albedo[0]);
            assert_true(albedo[0] <= 1 + 0x1p-6);
            worst = fmax(worst, fabs(albedo[0] - exact[0]));
        }
        print_message("# alpha %g: albedo at 0, 10, .. 80 degrees:%s\n", alphas[i], text);
        assert_true(worst <= 0.01);
    }
}

/* A sphere that fills 0.8 of the height, seen from 5 radii: its unit normal at a pixel, or false. */
static bool sphere_normal(double n[3], const double v[3])
{
    const double distance = 5, half = 0.17; /* of the view's half height 0.41 at distance 1 */
    double radius = distance * half * 2;
    double along = distance * v[2],
           square = distance * distance - radius * radius; /* |t v + (0,0,d)|, v towards the eye */
    double root = along * along - square;
    if (root <= 0)
        return false;
    double t = along - sqrt(root);
    for (int c = 0; c < 3; c++)
        n[c] = (-t * v[c] + (c == 2) * distance) / radius;
    return true;
}

struct sums {
    double pixels, right, near, worst, energy, exact_energy;
};

/* Shades the tile with pixel (x, y) and adds up its errors. */
static void add_tile(struct sums *sums, const struct subject *s, const double l[3], unsigned x, unsigned y)
{
    static double normal[PIXELS][3], view[PIXELS][3];
    const unsigned x0 = x / RASTER_TILE_WIDTH * RASTER_TILE_WIDTH, y0 = y / RASTER_TILE_HEIGHT * RASTER_TILE_HEIGHT;
    const struct raster_rect rect = {(uint16_t)x0, (uint16_t)y0, RASTER_TILE_WIDTH, RASTER_TILE_HEIGHT};
    struct raster_stats stats = {0};
    for (unsigned i = 0; i < PIXELS; i++) {
        view_of(view[i], x0 + i % RASTER_TILE_WIDTH, y0 + i / RASTER_TILE_WIDTH);
        k.tile.surface[i] = (struct raster_surface){0, 0};
        if (sphere_normal(normal[i], view[i]) && normal[i][2] > -0.5)
            k.tile.surface[i] = store_normal(normal[i]);
        else
            normal[i][0] = 2;
    }
    raster_shade_tile(&k.r, &k.tile, &rect, &stats);
    for (unsigned i = 0; i < PIXELS; i++) {
        double want[3], display[3], step;
        if (normal[i][0] > 1 || dot(normal[i], view[i]) < 1.0 / 120)
            continue;
        reference(want, s, normal[i], l, view[i]);
        ref_tone(display, want, 0);
        uint8_t got = raster_tile_pixels(&k.tile)[3 * i];
        step = fabs(got - floor(display[0] + 0.5));
        sums->pixels++;
        sums->right += step < 0.5;
        sums->near += step < 1.5;
        sums->worst = fmax(sums->worst, step);
        sums->energy += pow((got / 255.0 + 0.055) / 1.055, 2.4);
        sums->exact_energy += pow((fmin(display[0], 255) / 255 + 0.055) / 1.055, 2.4);
    }
}

/* The light so bright that the lobe's peak is just below white. The tiles around the highlight, found by search, and some others. */
static void render_sphere(const struct subject *s, double alpha, unsigned height, double within, double most)
{
    static const double lights[3][3] = {
        {0.3, 0.4, 0.866}, {-0.7, 0.69, 0.17}, {0.5, -0.4, -0.77}}; /* 30, 80, 140 degrees */
    struct sums sums = {0};
    const unsigned width = height / 3 * 4;
    for (int i = 0; i < 3; i++) {
        double l[3] = {lights[i][0], lights[i][1], lights[i][2]}, best = -1, n[3], v[3];
        unsigned at[2] = {0, 0};
        normalise(l);
        frame_begin(s, width, height, quantise(l), (uint32_t)ceil(65536 * 0.9 * 4 * 3.14159 * alpha * alpha));
        direction_of(l, quantise(l));
        for (unsigned y = 0; y < height; y += 4)
            for (unsigned x = 0; x < width; x += 4) {
                view_of(v, x, y);
                double h[3] = {l[0] + v[0], l[1] + v[1], l[2] + v[2]};
                normalise(h);
                if (sphere_normal(n, v) && dot(n, h) > best && dot(n, l) > 0) {
                    best = dot(n, h);
                    at[0] = x, at[1] = y;
                }
            }
        for (int j = 0; j < 4; j++) /* the highlight's tile and three beside it */
            add_tile(&sums, s, l, at[0] + (j & 1) * 24 - 12, at[1] + (j >> 1) * 16 - 8);
        for (int j = 0; j < 2; j++)
            add_tile(&sums, s, l, width / 2 + j * height / 4, height / 2 - j * height / 8);
    }
    print_message("# alpha %g, %u lines: %.2f %% right, %.3f %% within a step, max %g, light %.4f of the exact\n",
                  alpha, height, 100 * sums.right / sums.pixels, 100 * sums.near / sums.pixels, sums.worst,
                  sums.energy / sums.exact_energy);
    assert_true(sums.pixels >= 6 * PIXELS);
    assert_true(100 * sums.near / sums.pixels >= within && sums.worst <= most);
    assert_true(fabs(sums.energy / sums.exact_energy - 1) <= 0.02);
}

static void spheres_of_240_lines_agree(void **state)
{
    (void)state;
    for (int i = 0; i < COUNT; i++)
        render_sphere(&subjects[i], alphas[i], 240, 99, 32);
}

static void spheres_of_480_and_720_lines_agree(void **state)
{
    (void)state;
    for (int i = 0; i < COUNT; i++) {
        render_sphere(&subjects[i], alphas[i], 480, 99, 32);
        render_sphere(&subjects[i], alphas[i], 720, 99, 32);
    }
}

static void spheres_of_1080_and_2160_lines_agree(void **state)
{
    (void)state;
    for (int i = 0; i < COUNT; i++) {
        render_sphere(&subjects[i], alphas[i], 1080, 99, 32);
        render_sphere(&subjects[i], alphas[i], 2160, 99, 32);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_energy_is_created),
        cmocka_unit_test(spheres_of_240_lines_agree),
        cmocka_unit_test(spheres_of_480_and_720_lines_agree),
        cmocka_unit_test(spheres_of_1080_and_2160_lines_agree),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
