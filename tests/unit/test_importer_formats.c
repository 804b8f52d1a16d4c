/*
 * Importers of foreign formats on files that the test writes as the formats are specified, from one analytic BRDF: what comes back,
 * what is refused, and that no cut or damaged file is read outside its bytes.
 */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "host_import.h"
#include "importer_fixture.h"
#include "ref_table.h"

static struct import_options options = {.theta_max = 60};

/* The file as import_load gets it: its bytes and a NUL, nothing beyond. */
static void load(struct measurement *m, const struct bytes *b)
{
    uint8_t *copy = xmalloc(b->count + 1);
    memcpy(copy, b->data, b->count);
    copy[b->count] = 0;
    options.geometry = measurement_geometry_find("minidiff");
    import_load(m, import_format_of(copy, b->count), "in.brdf", copy, b->count, &options);
    free(copy);
}

/* Recognises from exactly the bytes, then loads. */
static void read_any(const struct bytes *b)
{
    uint8_t *exact = xmalloc(b->count);
    memcpy(exact, b->data, b->count);
    import_format_of(exact, b->count);
    free(exact);
    struct measurement m;
    load(&m, b);
}

static void expect_format(const struct bytes *b, const char *name)
{
    assert_string_equal(import_format_of(b->data, b->count)->name, name);
}

static void dies(const struct bytes *b, const char *message)
{
    int code = exit_code_of(read_any, b);
    if (code != EXIT_BAD_INPUT || !strstr(child_message, message))
        fail_msg("exit code %d, want %d and '%s'; said: %s", code, EXIT_BAD_INPUT, message, child_message);
}

static void text_dies(const char *text, const char *message)
{
    dies(&(struct bytes){(uint8_t *)text, strlen(text)}, message);
}

/* Every cut and every changed byte ends in success or in the exit code for a bad input, whatever the sanitizers watch. */
static void damage(const struct bytes *b, size_t step)
{
    for (size_t i = 0; i < b->count; i += step) {
        int code = exit_code_of(read_any, &(struct bytes){b->data, i});
        if (code != 0 && code != EXIT_BAD_INPUT)
            fail_msg("cut to %zu bytes: exit code %d, said: %s", i, code, child_message);
        uint8_t was = b->data[i];
        static const uint8_t flips[3] = {0x80, 0x03, 0x10};
        b->data[i] = was ^ flips[i % 3];
        code = exit_code_of(read_any, b);
        b->data[i] = was;
        if (code != 0 && code != EXIT_BAD_INPUT)
            fail_msg("byte %zu changed: exit code %d, said: %s", i, code, child_message);
    }
}

/* Every line left out or doubled. */
static void damage_lines(const struct bytes *b)
{
    for (size_t from = 0, to; from < b->count; from = to) {
        const uint8_t *end = memchr(b->data + from, '\n', b->count - from);
        to = end ? (size_t)(end - b->data) + 1 : b->count;
        struct bytes without = {xmalloc(2 * b->count), b->count - (to - from)};
        memcpy(without.data, b->data, from);
        memcpy(without.data + from, b->data + to, b->count - to);
        int code = exit_code_of(read_any, &without);
        memcpy(without.data, b->data, to);
        memcpy(without.data + to, b->data + from, b->count - from);
        without.count = b->count + to - from;
        int doubled = exit_code_of(read_any, &without);
        free(without.data);
        if ((code && code != EXIT_BAD_INPUT) || (doubled && doubled != EXIT_BAD_INPUT))
            fail_msg("line at byte %zu: exit codes %d without, %d doubled, said: %s", from, code, doubled,
                     child_message);
    }
}

/* Every sample has the BRDF's value times `scale`. */
static void expect_samples(const struct measurement *m, size_t count, const double scale[3], double tolerance)
{
    assert_int_equal(m->count, count);
    for (size_t i = 0; i < count; i++) {
        const struct measurement_point *p = &m->points[i];
        double want = fixture_brdf((double)p->theta_in, (double)p->theta_out, (double)p->phi_out);
        for (int c = 0; c < 3; c++)
            if (!(fabs((double)p->rgb[c] - scale[c] * want) <= tolerance * want))
                fail_msg("sample %zu at %g %g %g channel %d: %g, want %g", i, p->theta_in, p->theta_out, p->phi_out, c,
                         p->rgb[c], scale[c] * want);
    }
}

/* --- ASTM --- */

static struct bytes make_astm(const char *vars, int values)
{
    struct bytes b = {0};
    put_text(&b, "# made by a test\nASTM E1392\nSAMPLE a name\nNUM_POINTS %d\nVARS theta_i,phi_i,theta_s,phi_s,%s\n",
             4 * 5 * 12, vars);
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 5; j++)
            for (int k = 0; k < 12; k++) {
                double f = fixture_brdf(20 * i, 15 * j, 30 * k);
                put_text(&b, "%.9g,%.9g,%.9g,%.9g", 20 * i * fixture_pi / 180, 0.25, 15 * j * fixture_pi / 180,
                         0.25 + (30 * k - 360 * (k > 6)) * fixture_pi / 180);
                for (int v = 0; v < values; v++)
                    put_text(&b, ",%.7g", values == 3 ? f * (v + 1) / 2 : f);
                put_text(&b, "\n");
            }
    return b;
}

static void astm_rgb_comes_back_on_its_own_grid(void **state)
{
    (void)state;
    struct bytes b = make_astm("R,G,B", 3);
    struct measurement m;
    expect_format(&b, "astm");
    load(&m, &b);
    expect_samples(&m, 240, (const double[3]){0.5, 1, 1.5}, 2e-6);
    char *problem = measurement_grid_problem(&m);
    assert_null(problem);
    assert_string_equal(m.source, "in.brdf");
    measurement_free(&m);
    free(b.data);
}

static void astm_xyz_and_spectra_become_linear_srgb(void **state)
{
    (void)state;
    struct measurement m;
    /* XYZ = f (0.5, 1, 1.5), by the inverse of the sRGB primaries */
    struct bytes b = make_astm("X,Y,Z", 3);
    load(&m, &b);
    expect_samples(&m, 240,
                   (const double[3]){3.2404542 * 0.5 - 1.5371385 - 0.4985314 * 1.5 > 0 ? 1 : 0,
                                     -0.9692660 * 0.5 + 1.8760108 + 0.0415560 * 1.5,
                                     0.0556434 * 0.5 - 0.2040259 + 1.0572252 * 1.5},
                   1e-5);
    measurement_free(&m);
    free(b.data);
    b = make_astm("450nm,550,650nm,700nm", 4);
    load(&m, &b);
    expect_samples(&m, 240, (const double[3]){1, 1, 1}, 1e-5);
    measurement_free(&m);
    free(b.data);
}

static void astm_says_what_is_wrong(void **state)
{
    (void)state;
#define ANGLES "VARS theta_i,phi_i,theta_s,phi_s,"
    text_dies("NUM_POINTS 2\n" ANGLES "R,G,B\n0,0,0,0,1,1,1\n", "1 samples where NUM_POINTS says 2");
    text_dies("NUM_POINTS 2\n", "no VARS line");
    text_dies(ANGLES "R,G\n", "VARS must name");
    text_dies("VARS theta_i,phi_i,theta_s,R,G,B\n", "VARS must name");
    static const char *const muddled[] = {"R,R,B", "R,G,450nm", "450nm,R,G", "R,G,Z", "R,G,B,R", "R,G,B,theta_s"};
    for (size_t i = 0; i < sizeof muddled / sizeof *muddled; i++) {
        char text[200];
        snprintf(text, sizeof text, ANGLES "%s\n0,0,0,0,1,1,1,1\n", muddled[i]);
        text_dies(text, "VARS must name");
    }
    text_dies(ANGLES "550nm,450nm\n", "in.brdf:1: wavelength 450 after 550");
    text_dies(ANGLES "R,G,B\n0,0,0,0,1,1\n", "in.brdf:2: 6 numbers where 7");
    text_dies(ANGLES "R,G,B\n0,0,0,0,1,1,x\n", "in.brdf:2: 'x' where a number");
    text_dies(ANGLES "R,G,B\n0,0,45,0,1,1,1\n",
              "in.brdf:2: theta 0 in and 45 out, phi 0 in and 0 out, in radians; theta must be below pi/2");
    text_dies(ANGLES "R,G,B\n1.57079628,0,0,0,1,1,1\n",
              "in.brdf:2: theta 1.5708 in and 0 out"); /* 90 degrees as a float */
    text_dies(ANGLES "R,G,B\n0,0,0,0,1,1,inf\n", "is not finite");
    text_dies(ANGLES "R,G,B\n", "no samples");
}

static void astm_cut_or_damaged_never_reads_outside_the_file(void **state)
{
    (void)state;
    struct bytes b = make_astm("450nm,650nm", 2);
    b.count = 600;
    damage(&b, 1);
    damage_lines(&b);
    free(b.data);
}

/* --- Cornell --- */

static struct bytes make_cornell(bool degrees, int points)
{
    struct bytes b = {0};
    double unit = degrees ? 1 : fixture_pi / 180;
    put_text(&b, "# Cornell, a test\n4\n400 500\n600 700 # not a comment\n");
    b.count -= 16;
    put_text(&b, "\n\n");
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < points; k++) {
            double theta, phi;
            fixture_spread(&theta, &phi, k * SCATTERED / points, 80);
            put_text(&b, "%.9g %.9g %.9g %.9g", (5 + 20 * i) * unit, 0.0, theta * unit, (phi - 180) * unit);
            double f = fixture_brdf(5 + 20 * i, theta, phi - 180);
            put_text(&b, " %.7g %.7g\t%.7g %.7g\n", f, f, f, f);
        }
    return b;
}

static void cornell_spectra_come_back_from_radians_and_degrees(void **state)
{
    (void)state;
    for (int degrees = 0; degrees < 2; degrees++) {
        struct bytes b = make_cornell(degrees != 0, SCATTERED);
        struct measurement m;
        expect_format(&b, "cornell");
        load(&m, &b);
        expect_samples(&m, 4 * SCATTERED, (const double[3]){1, 1, 1}, 1e-5);
        measurement_free(&m);
        free(b.data);
    }
}

static void cornell_says_what_is_wrong(void **state)
{
    (void)state;
    text_dies("2\n400\n", "the file ends where a wavelength is wanted");
    text_dies("0\n", "0 wavelengths, want a whole number from 1");
    text_dies("2\n500 400\n", "wavelength 400; they must");
    text_dies("1\n500 600\n", "in.brdf:2: more than 1 wavelengths");
    text_dies("1\n500\n0 0 0 0\n", "in.brdf:3: 4 numbers where 5");
    text_dies("1\n500\n0 0 0 0 1\n0 0 91 0 1\n", "in.brdf:4: theta 0 in and 91 out");
    text_dies("1\n500\n0 0 0 0 nan\n", "is not finite");
    text_dies("1\n500\n", "no samples");
}

static void cornell_cut_or_damaged_never_reads_outside_the_file(void **state)
{
    (void)state;
    struct bytes b = make_cornell(false, 3);
    damage(&b, 5);
    damage_lines(&b);
    free(b.data);
}

/* --- Zemax --- */

static const double zemax_incidence[] = {0, 10, 30, 60};
static const double zemax_radial[] = {0, 3, 8, 15, 25, 40, 60, 80, 100, 130};

/* The direction at (radial, azimuth) around the mirror direction: rotated out of the pole about the normal of the plane of
 * incidence. */
static double zemax_value(double theta_in, double radial, double azimuth)
{
    double r = radial * fixture_pi / 180, a = azimuth * fixture_pi / 180, t = theta_in * fixture_pi / 180;
    /* at incidence 0 the mirror direction is the normal and azimuth 0 is where the light leans to as theta_in grows */
    double x = sin(r) * cos(a), y = sin(r) * sin(a), z = cos(r);
    double v[3] = {x * cos(t) - z * sin(t), y, x * sin(t) + z * cos(t)};
    if (v[2] < 0)
        return 0;
    return fixture_brdf(theta_in, acos(fmin(v[2], 1)) * 180 / fixture_pi, atan2(v[1], v[0]) * 180 / fixture_pi);
}

static struct bytes make_zemax(bool xyz, bool plane, int incidences)
{
    struct bytes b = {0};
    int azimuths = plane ? 13 : 24;
    put_text(&b, "#Data of a test\nSource  Measured\nSymmetry  %s\nSpectralContent  %s\nScatterType  BRDF\n",
             plane ? "PlaneSymmetrical" : "Asymmetrical", xyz ? "XYZ" : "Monochrome");
    put_text(&b, "SampleRotation 1\n0\nAngleOfIncidence %d\n", incidences);
    for (int i = 0; i < incidences; i++)
        put_text(&b, "%g\t", zemax_incidence[i]);
    put_text(&b, "\nScatterAzimuth %d\n", azimuths);
    for (int i = 0; i < azimuths; i++)
        put_text(&b, "%d ", 15 * i);
    put_text(&b, "\nScatterRadial 10\n0 3 8 15 25 40 60 80 100 130\n\n");
    static const char *const names[3] = {"TristimulusX", "TristimulusY", "TristimulusZ"};
    static const double white[3] = {0.95047, 1, 1.08883};
    for (int c = 0; c < (xyz ? 3 : 1); c++) {
        put_text(&b, "%s\nDataBegin\n", xyz ? names[c] : "Monochrome");
        for (int i = 0; i < incidences; i++) {
            put_text(&b, "TIS 0.5\n");
            for (int a = 0; a < azimuths; a++) {
                for (int r = 0; r < 10; r++)
                    put_text(&b, "%.6E\t",
                             (xyz ? white[c] : 1) * zemax_value(zemax_incidence[i], zemax_radial[r], 15 * a));
                put_text(&b, "\n");
            }
        }
        put_text(&b, "DataEnd\n");
    }
    return b;
}

static void zemax_comes_back_around_the_mirror_direction(void **state)
{
    (void)state;
    for (int kind = 0; kind < 4; kind++) {
        struct bytes b = make_zemax(kind & 1, kind & 2, 4);
        struct measurement m;
        expect_format(&b, "zemax");
        load(&m, &b);
        assert_true(m.count > 500);
        expect_samples(&m, m.count, (const double[3]){1, 1, 1}, 1e-5);
        /* The mirror direction once per incidence, both sides of a symmetrical file. */
        size_t mirror = 0, sides[2] = {0};
        for (size_t i = 0; i < m.count; i++) {
            const struct measurement_point *p = &m.points[i];
            mirror += p->theta_in == 60 && fabsf(p->theta_out - 60) < 1e-3f && fabsf(p->phi_out - 180) < 1e-3f;
            sides[p->phi_out > 180] += p->theta_in == 60 && fabsf(fmodf(p->phi_out + 90, 180) - 90) > 1;
        }
        assert_int_equal(mirror, 1);
        assert_int_equal(sides[0], sides[1]);
        measurement_free(&m);
        free(b.data);
    }
}

static void zemax_says_what_is_wrong(void **state)
{
    (void)state;
#define HEAD "Source Measured\nSymmetry PlaneSymmetrical\nSpectralContent Monochrome\nScatterType BRDF\n"
#define AXES "AngleOfIncidence 1\n0\nScatterAzimuth 2\n0 180\nScatterRadial 2\n0 10\n"
#define DATA "Monochrome\nDataBegin\nTIS 1\n1 1\n1 1\n"
    text_dies("Source Measured\nSpectralContent Colour\n", "SpectralContent is 'Colour'");
    text_dies("SpectralContent XYZ\nScatterType BTDF\n", "ScatterType is 'BTDF'");
    text_dies(HEAD "SampleRotation 2\n0 90\n" AXES DATA "DataEnd\n", "anisotropic, 2 sample rotations");
    text_dies(HEAD "AngleOfIncidence 2\n0\n", "the file ends where AngleOfIncidence is wanted");
    text_dies(HEAD "AngleOfIncidence 2\n10 5\n", "AngleOfIncidence 5; the angles must ascend");
    text_dies(HEAD "AngleOfIncidence 1\n95\n", "AngleOfIncidence 95; the angles must ascend from 0");
    text_dies(HEAD AXES, "'' where Monochrome is wanted");
    text_dies(HEAD "AngleOfIncidence 1\n0\n" DATA, "ScatterAzimuth or ScatterRadial is missing");
    text_dies(HEAD AXES DATA, "'' where DataEnd is wanted");
    text_dies(HEAD AXES "Monochrome\nDataBegin\nTIS 1\n1 1\n1\n", "the file ends where a BSDF value");
    text_dies(HEAD AXES "Monochrome\nDataBegin\nTIS 1\n1 1\n1 x\n", "in.brdf:15: 'x' where a BSDF value");
    text_dies(HEAD AXES "TristimulusX\n", "'TristimulusX' where Monochrome is wanted");
    text_dies(HEAD "Colour 1\n", "'Colour' is no key");
}

static void zemax_cut_or_damaged_never_reads_outside_the_file(void **state)
{
    (void)state;
    struct bytes b = make_zemax(false, true, 1);
    damage(&b, 7);
    damage_lines(&b);
    free(b.data);
}

/* --- MERL --- */

enum { MERL_BYTES = 12 + 3 * 8 * 90 * 90 * 180 };

/* Rusinkiewicz angles of the centre of a cell, back to directions; rotations written as products of axis rotations. */
static double merl_value(int h, int d, int p)
{
    double th = (h + 0.5) * (h + 0.5) / 8100 * fixture_pi / 2, td = (d + 0.5) / 90 * fixture_pi / 2,
           pd = (p + 0.5) / 180 * fixture_pi;
    double dx = sin(td) * cos(pd), dy = sin(td) * sin(pd), dz = cos(td);
    double l[3] = {dx * cos(th) + dz * sin(th), dy, -dx * sin(th) + dz * cos(th)};
    double v[3] = {-dx * cos(th) + dz * sin(th), -dy, dx * sin(th) + dz * cos(th)};
    if (l[2] < 0 || v[2] < 0)
        return -1;
    double phi = atan2(v[1], v[0]) - atan2(l[1], l[0]);
    return fixture_brdf(acos(l[2]) * 180 / fixture_pi, acos(v[2]) * 180 / fixture_pi, phi * 180 / fixture_pi);
}

static struct bytes make_merl(void)
{
    struct bytes b = {xcalloc(MERL_BYTES, 1), MERL_BYTES};
    b.data[0] = b.data[4] = 90;
    b.data[8] = 180;
    static const double scale[3] = {1500, 1500 / 1.15, 1500 / 1.66};
    for (int h = 0; h < 90; h++)
        for (int d = 0; d < 90; d++)
            for (int p = 0; p < 180; p++) {
                double f = merl_value(h, d, p);
                for (int c = 0; c < 3; c++) {
                    double x = f < 0 ? -1 : f * (c + 1) * scale[c];
                    memcpy(b.data + 12 + 8 * (p + 180 * (d + 90 * (h + 90 * (size_t)c))), &x, 8);
                }
            }
    return b;
}

static void merl_comes_back_in_its_scales(void **state)
{
    (void)state;
    struct bytes b = make_merl();
    struct measurement m;
    expect_format(&b, "merl");
    load(&m, &b);
    assert_int_equal(m.count, 4 * 76 * 360);
    double worst = 0;
    for (size_t i = 0; i < m.count; i++) {
        const struct measurement_point *p = &m.points[i];
        double want = fixture_brdf((double)p->theta_in, (double)p->theta_out, (double)p->phi_out);
        for (int c = 0; c < 3; c++)
            worst = fmax(worst, fabs((double)p->rgb[c] / ((c + 1) * want) - 1));
    }
    print_message("# MERL: largest error %.5f\n", worst);
    assert_true(worst < 0.004);
    measurement_free(&m);
    b.count--;
    dies(&b, "34992011 bytes where this format has 34992012");
    b.count = 13;
    dies(&b, "13 bytes where");
    b.count = MERL_BYTES;
    memset(b.data + 12 + 8 * 1000, 0xff, 8);
    dies(&b, "value 1000 is not finite");
    free(b.data);
}

/* --- table files --- */

static void table_comes_back_and_damaged_is_refused(void **state)
{
    (void)state;
    uint32_t texels[5 * 4 * 3];
    for (int i = 0; i < 60; i++)
        texels[i] = 256u | 128u << 9 | 64u << 18 | (uint32_t)(14 + i / 20) << 27; /* doubles per slice */
    struct bytes b = {0};
    b.data = ref_ktx2_make(5, 4, 3, texels, 60000, &b.count);
    struct measurement m;
    expect_format(&b, "ktx2");
    load(&m, &b);
    assert_int_equal(m.count, 4 * 76 * 360);
    for (size_t i = 0; i < m.count; i += 501) {
        const struct measurement_point *p = &m.points[i];
        double at = (double)p->theta_in / 30, want = 0.25 * (at < 1 ? 1 + at : 2 * at); /* linear between the slices */
        if (fabs((double)p->rgb[0] - want) > 1e-5 || fabs((double)p->rgb[2] - want / 4) > 1e-5)
            fail_msg("theta_in %g: %g, want %g", p->theta_in, p->rgb[0], want);
    }
    measurement_free(&m);
    b.count--;
    dies(&b, "build the table again");
    b.count++;
    damage(&b, 11);
    free(b.data);
}

/* --- the table of formats --- */

static void formats_are_told_apart_by_content(void **state)
{
    (void)state;
    static const struct {
        const char *content, *name;
    } cases[] = {
        {"GTMEAS\r\n", "gtm"},
        {"\xabKTX 20", "ktx2"},
        {"v/1\x01", "composite"},
        {"# c\n\n  31\n400", "cornell"},
        {"31.5\n400", "csv"},
        {"31 nm\n", "csv"},
        {"#x\nVARS a,b", "astm"},
        {"VARSITY", "csv"},
        {"Source Measured\nSpectralContent XYZ", "zemax"},
        {"\xef\xbb\xbf"
         "VARS a,b",
         "astm"},
        {"\xef\xbb\xbf"
         "31\n400",
         "cornell"},
        {"\xef\xbb\xbf", "csv"},
        {"", "csv"},
        {"#", "csv"},
        {"  ", "csv"},
        {"theta_in,theta_out", "csv"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        size_t n = strlen(cases[i].content);
        uint8_t *exact = xmalloc(n ? n : 1);
        memcpy(exact, cases[i].content, n);
        if (strcmp(import_format_of(exact, n)->name, cases[i].name))
            fail_msg("case %zu is %s, want %s", i, import_format_of(exact, n)->name, cases[i].name);
        free(exact);
    }
}

static void a_byte_order_mark_is_skipped_and_lines_end_in_lf(void **state)
{
    (void)state;
    static const char *const texts[] = {
        ANGLES "R,G,B\n0,0,0,0,1,2,3\n", "1\n500\n0 0 0 0 1\n",
        "Symmetry Asymmetrical\nAngleOfIncidence 1\n0\nScatterAzimuth 1\n0\nScatterRadial 1\n0\n"
        "Monochrome\nDataBegin\nTIS 0\n1\nDataEnd\n",
        "theta_in,theta_out,phi_out,R,G,B\n0,0,0,1,2,3\n"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        struct bytes b = {0};
        put_text(&b, "\xef\xbb\xbf%s", texts[i]);
        if (exit_code_of(read_any, &b))
            fail_msg("text %zu with a byte order mark: %s", i, child_message);
        for (size_t k = 0; k < b.count; k++)
            b.data[k] = b.data[k] == '\n' ? '\r' : b.data[k];
        dies(&b, "in.brdf: its lines end in CR alone");
        free(b.data);
    }
}

static void wavelengths_that_nobody_sees_are_said(void **state)
{
    (void)state;
    static const char *const texts[] = {"2\n0.45 0.65\n0 0 0 0 1 2\n", "1\n1064\n0 0 0 0 1\n",
                                        ANGLES "0.6328\n0,0,0,0,1\n", "1\n632.8\n0 0 0 0 1\n",
                                        ANGLES "R,G,B\n0,0,0,0,1,1,1\n"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++) {
        assert_int_equal(exit_code_of(read_any, &(struct bytes){(uint8_t *)texts[i], strlen(texts[i])}), 0);
        if (!strstr(child_message, "no wavelength within 380..780 nm") != (i >= 3))
            fail_msg("text %zu: %s", i, child_message);
    }
}

static void negative_values_become_zero_and_raw_keeps_everything(void **state)
{
    (void)state;
    const char *text = ANGLES "R,G,B\n0,0,0,0,1,-1,1\n0,0,0.5,0,2,2,2\n";
    struct bytes b = {(uint8_t *)text, strlen(text)};
    assert_int_equal(exit_code_of(read_any, &b), 0);
    assert_non_null(strstr(child_message, "1 samples with negative values, set to 0"));
    struct measurement m;
    options.raw = true;
    load(&m, &b);
    options.raw = false;
    assert_true(m.points[0].rgb[1] == -1);
    measurement_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(astm_rgb_comes_back_on_its_own_grid),
        cmocka_unit_test(astm_xyz_and_spectra_become_linear_srgb),
        cmocka_unit_test(astm_says_what_is_wrong),
        cmocka_unit_test(astm_cut_or_damaged_never_reads_outside_the_file),
        cmocka_unit_test(cornell_spectra_come_back_from_radians_and_degrees),
        cmocka_unit_test(cornell_says_what_is_wrong),
        cmocka_unit_test(cornell_cut_or_damaged_never_reads_outside_the_file),
        cmocka_unit_test(zemax_comes_back_around_the_mirror_direction),
        cmocka_unit_test(zemax_says_what_is_wrong),
        cmocka_unit_test(zemax_cut_or_damaged_never_reads_outside_the_file),
        cmocka_unit_test(merl_comes_back_in_its_scales),
        cmocka_unit_test(table_comes_back_and_damaged_is_refused),
        cmocka_unit_test(formats_are_told_apart_by_content),
        cmocka_unit_test(a_byte_order_mark_is_skipped_and_lines_end_in_lf),
        cmocka_unit_test(wavelengths_that_nobody_sees_are_said),
        cmocka_unit_test(negative_values_become_zero_and_raw_keeps_everything),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
