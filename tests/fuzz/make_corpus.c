/*
 * Writes the seeds of the fuzz harnesses, one folder each: small files that are accepted. make_corpus FOLDER
 */
#include <errno.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "common.h"
#include "host_atlas.h"
#include "host_measurement.h"
#include "ref_blob.h"
#include "ref_table.h"
#include "usb_protocol.h"

static const char *folder;

static char *seed_path(const char *harness, const char *name)
{
    char *path = xasprintf("%s/%s", folder, harness);
    if (mkdir(path, 0777) && errno != EEXIST)
        die(EXIT_FILE, "%s: %s", path, strerror(errno));
    return xasprintf("%s/%s", path, name);
}

static void seed(const char *harness, const char *name, const void *data, size_t bytes)
{
    write_file(seed_path(harness, name), data, bytes);
}

static void seed_text(const char *harness, const char *name, const char *text)
{
    seed(harness, name, text, strlen(text));
}

/* --- tables and scenes --- */

static void *make_frame_table(size_t *bytes)
{
    uint32_t texels[3 * 3 * 2];
    for (size_t i = 0; i < sizeof texels / sizeof *texels; i++)
        texels[i] = (uint32_t)(256 + i) | 300u << 9 | 400u << 18 | 15u << 27;
    return ref_ktx2_make(3, 3, 2, texels, 60000, bytes);
}

static void *make_half_table(size_t *bytes, int slabs)
{
    uint32_t texels[2 * 3 * 2];
    struct ref_half f = {.t = 2, .h = 3, .d = 2, .texels = texels, .scale = -2, .slabs = slabs};
    for (size_t i = 0; i < sizeof texels / sizeof *texels; i++)
        texels[i] = (uint32_t)(256 + i) | 300u << 9 | 400u << 18 | (uint32_t)(14 + i % 3) << 27;
    ref_half_warp(&f, 0.3);
    return ref_half_make(&f, bytes);
}

static void *make_scene(size_t *bytes, unsigned kind, double near)
{
    static const int16_t vertices[4][3] = {{-8000, -8000, 0}, {8000, -8000, 0}, {0, 8000, 0}, {0, 0, 9000}};
    static const uint16_t triangles[2][3] = {{0, 1, 2}, {1, 2, 3}};
    struct ref_blob b;
    ref_blob_init(&b);
    b.near = near;
    b.background[0] = kind == 0;
    ref_blob_light(&b, (const double[3]){0, 0, 1}, 1);
    unsigned material = ref_blob_material(&b, kind, 0, 0.5, "seed");
    unsigned mesh = ref_blob_mesh(&b, vertices, triangles, 2);
    ref_blob_object(&b, mesh, material, (const double[3]){0, 0, -0.9}, 1 / 8192.0);
    return ref_blob_finish(&b, bytes);
}

static void seed_files(void)
{
    size_t bytes;
    void *frame = make_frame_table(&bytes);
    seed("table", "specular_frame", frame, bytes);
    seed("import_ktx2", "specular_frame", frame, bytes);
    for (int slabs = 0; slabs < 2; slabs++) {
        void *half = make_half_table(&bytes, slabs);
        seed("table", slabs ? "half_vector_slabs" : "half_vector", half, bytes);
        if (slabs == 0)
            seed("import_ktx2", "half_vector", half, bytes);
    }
    frame = make_frame_table(&bytes);
    const struct atlas_member members[3] = {{"", frame, bytes}, {"", frame, bytes}, {"", frame, bytes}};
    void *atlas = atlas_compose(&bytes, members, 3);
    seed("atlas", "three", atlas, bytes);
    free(frame);
    for (unsigned kind = 0; kind < 2; kind++) {
        void *scene = make_scene(&bytes, kind, kind ? 0.9 : 0.0625);
        seed("scene", kind ? "near" : "measured", scene, bytes);
    }
}

/* --- streams --- */

enum {
    CAMERA = 12,
    CAMERA_BYTES = 56,
    OUTPUT = CAMERA + CAMERA_BYTES,
    OUTPUT_BYTES = 8,
    LIGHTS = OUTPUT + OUTPUT_BYTES,
    LIGHT_BYTES = 32
};

struct stream {
    uint8_t data[8192];
    size_t bytes;
};

static void put(struct stream *s, const void *data, size_t bytes)
{
    if (bytes) /* else data may be NULL */
        memcpy(s->data + s->bytes, data, bytes);
    s->bytes += bytes;
}

static void put_byte(struct stream *s, unsigned x)
{
    put(s, &(uint8_t){(uint8_t)x}, 1);
}

static void put_push(struct stream *s, unsigned slot, const void *content, size_t bytes)
{
    put_byte(s, 2);
    put_byte(s, slot);
    put_byte(s, bytes & 255);
    put_byte(s, (unsigned)(bytes >> 8));
    put(s, content, bytes);
}

static void put_request(struct stream *s, unsigned type, const void *payload, size_t bytes)
{
    put_byte(s, 1);
    put_byte(s, type);
    put_byte(s, (unsigned)bytes);
    put(s, payload, bytes);
}

static void put_setting(struct stream *s, uint32_t setting, const void *value, size_t bytes)
{
    struct stream payload = {0};
    put(&payload, &setting, sizeof setting);
    if (setting == USB_SET_LIGHT)
        put(&payload, (const uint32_t[1]){1}, 4);
    put(&payload, value, bytes);
    put_request(s, USB_MSG_SET, payload.data, payload.bytes);
}

/* Camera, output and a second light as the scene has them. */
static void put_settings(struct stream *s, const uint8_t *scene)
{
    uint32_t lights;
    memcpy(&lights, scene + LIGHTS, sizeof lights);
    put_setting(s, USB_SET_CAMERA, scene + CAMERA, CAMERA_BYTES);
    put_setting(s, USB_SET_OUTPUT, scene + OUTPUT, OUTPUT_BYTES);
    put_setting(s, USB_SET_LIGHT, scene + lights, LIGHT_BYTES);
    put_setting(s, USB_SET_MODEL, (const uint32_t[1]){1}, 4);
}

static void seed_protocol(void)
{
    struct stream s = {0};
    size_t bytes;
    put_byte(&s, 0);
    void *scene = make_scene(&bytes, 0, 0.0625);
    put_push(&s, 0, scene, bytes);
    void *table = make_frame_table(&bytes);
    put_push(&s, 1, table, bytes);
    put_request(&s, USB_MSG_INFO, NULL, 0);
    put_request(&s, USB_MSG_SELECT, (const uint16_t[2]){0, 0}, 4);
    put_settings(&s, scene);
    put_request(&s, USB_MSG_FRAME, NULL, 0);
    put_request(&s, USB_MSG_STATS, (const uint32_t[1]){1}, 4);
    put_request(&s, USB_MSG_VERIFY, (const uint32_t[1]){1}, 4);
    put_request(&s, USB_MSG_RESET, NULL, 0);
    seed("protocol", "session", s.data, s.bytes);
    s.data[0] = 3; /* high speed, with a display */
    seed("protocol", "display", s.data, s.bytes);
    s = (struct stream){0};
    const uint8_t raw[] = {0, 0, 16, 0x47, 0x54, 2, 1, 7, 0, 0, 0, 0, 0, 0, 0, 0x12, 0x34, 0x56, 0x78, 6, 0x17, 4};
    put(&s, raw, sizeof raw);
    seed("protocol", "raw", s.data, s.bytes);
}

static void seed_usb(void)
{
    static const uint8_t setups[][8] = {
        {0x80, 6, 0, 1, 0, 0, 18},
        {0x00, 5, 1},
        {0x80, 6, 0, 2, 0, 0, 255, 1},
        {0x80, 6, 3, 3, 9, 4, 255},
        {0x00, 9, 1},
        {0x80, 6, 0, 15, 0, 0, 33},
        {0xc0, 0x20, 0, 0, 7, 0, 162},
        {0x82, 0, 0, 0, 0x81, 0, 2},
        {0x02, 3, 0, 0, 0x81},
        {0x02, 1, 0, 0, 0x81},
        {0x81, 10, 0, 0, 0, 0, 1},
        {0x01, 11},
        {0x80, 8, 0, 0, 0, 0, 1},
        {0x80, 6, 0, 6, 0, 0, 10},
        {0x80, 6, 0, 7, 0, 0, 32},
    };
    for (unsigned high = 0; high < 2; high++) {
        struct stream s = {{(uint8_t)high}, 1};
        for (size_t i = 0; i < sizeof setups / sizeof *setups; i++) {
            put_byte(&s, 4);
            put(&s, setups[i], 8);
        }
        put_byte(&s, 0x80);
        put(&s, setups[0], 8);
        put_byte(&s, 3);
        put_byte(&s, 2);
        put_byte(&s, 0x17);
        put_byte(&s, 5);
        put_byte(&s, 6);
        seed("usb", high ? "high_speed" : "full_speed", s.data, s.bytes);
    }
}

/* --- measurements --- */

static void put_number(struct stream *s, uint64_t x, int bytes)
{
    for (int i = 0; i < bytes; i++)
        put_byte(s, (unsigned)(x >> 8 * i & 255));
}

static void seed_rgl(void)
{
    static const struct {
        const char *name;
        int type, dimensions, shape[5];
    } fields[] = {
        {"phi_i", 10, 1, {1}},    {"theta_i", 10, 1, {2}},       {"ndf", 10, 2, {2, 3}},
        {"sigma", 10, 2, {2, 3}}, {"vndf", 10, 4, {1, 2, 3, 2}}, {"rgb", 10, 5, {1, 2, 3, 2, 2}},
        {"jacobian", 1, 1, {1}},
    };
    enum { FIELDS = sizeof fields / sizeof *fields };
    struct stream s = {0};
    size_t at[FIELDS];
    put(&s, "tensor_file", 12);
    put_number(&s, 1, 2);
    put_number(&s, FIELDS, 4);
    for (int i = 0; i < FIELDS; i++) {
        put_number(&s, strlen(fields[i].name), 2);
        put(&s, fields[i].name, strlen(fields[i].name));
        put_number(&s, (uint64_t)fields[i].dimensions, 2);
        put_number(&s, (uint64_t)fields[i].type, 1);
        at[i] = s.bytes;
        put_number(&s, 0, 8);
        for (int d = 0; d < fields[i].dimensions; d++)
            put_number(&s, (uint64_t)fields[i].shape[d], 8);
    }
    for (int i = 0; i < FIELDS; i++) {
        int count = 1;
        for (int d = 0; d < fields[i].dimensions; d++)
            count *= fields[i].shape[d];
        memcpy(s.data + at[i], &(uint64_t){s.bytes}, 8);
        for (int k = 0; k < count; k++) {
            float x = fields[i].name[0] == 'p' ? 0 : 0.25f + 0.5f * (float)k;
            put(&s, fields[i].type == 1 ? (const void *)"\1" : &x, fields[i].type == 1 ? 1 : 4);
        }
    }
    seed("import_rgl", "small", s.data, s.bytes);
}

static void seed_measurements(void)
{
    struct measurement m;
    struct stream merl = {{90, 0, 0, 0, 90, 0, 0, 0, 180}, 12};
    measurement_init(&m, "seed");
    for (int i = 0; i < 4; i++)
        measurement_add(&m, &(struct measurement_point){
                                .theta_out = (float)(i / 2 * 30), .phi_out = (float)(i % 2 * 180), .rgb = {1, 2, 3}});
    measurement_write(&m, seed_path("import_gtm", "grid"));
    put(&merl, (const double[3]){3, -1, 500}, 24);
    seed("import_merl", "three_values", merl.data, merl.bytes);
    /* 5 slices of 4 x 3 nodes in rows of 2, up to 60 degrees: see fuzz_import.c */
    struct stream composite = {{0x76, 0x2f, 0x31, 0x01, 2, 1, 4, 1, 170}, 11};
    put(&composite, (const float[5]){0, 0.25f, 3, 70000, 0.01f}, 20);
    seed("import_composite", "five_slices", composite.data, composite.bytes);
    seed_text("import_csv", "grid",
              "theta_in,theta_out,phi_out,R,G,B\n0,0,0,1,2,3\n0,0,180,1,2,3\n0,30,0,1e-3,.5,3\n0,30,180,1,2,3\n");
    seed_text("import_csv", "cloud",
              "# c\nB,G,R,phi_out,theta_in,theta_out,x\n1,1,1,10,5,20,a\n2,2,2,50,5,40,b\n1,1,-1,170,35,40,\n");
    seed_text("import_astm", "rgb",
              "ASTM E1392\nNUM_POINTS 3\nVARS theta_i,phi_i,theta_s,phi_s,red,green,blue\n"
              "0,0,0.5,3.1,1,2,3\n0,0,0.2,1,1,2,3\n0.3,0,0.2,2,1,2,3\n");
    seed_text("import_astm", "spectral",
              "#c\nASTM E2387\nNUM_POINTS 2\nVARS theta_i,phi_i,theta_s,phi_s,450 nm,550 nm,650 nm\n"
              "0,0,0.5,3.1,1,2,3\n0.3,0,0.2,2,1,2,3\n");
    seed_text("import_cornell", "spectral",
              "# c\n4\n400 500 600 700\n\n0.1 0 0.2 3 1 1 1 1\n0.1 0 0.5 1 1 .5 1 1\n0.5 0 0.5 1 1 .5 1 1\n");
    static const char zemax[] =
        "#c\nSource  Measured\nSymmetry  PlaneSymmetrical\nSpectralContent  Monochrome\nScatterType  BRDF\n"
        "SampleRotation 1\n0\nAngleOfIncidence 2\n0 30\nScatterAzimuth 3\n0 90 180\nScatterRadial 3\n0 20 60\n\n"
        "Monochrome\nDataBegin\nTIS 0.5\n1 2 3\n1 2 3\n1 2 3\nTIS 0.4\n1 2 3\n1 2 3\n1 2 3\nDataEnd\n";
    seed_text("import_zemax", "plane", zemax);
    char sgd[1024] = "material", *end = sgd + strlen(sgd);
    static const char *const names[] = {"rhoD", "rhoS", "alpha", "p", "f0", "f1", "kap", "lam", "c", "k", "theta0"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++)
        end += sprintf(end, ",%s_r,%s_g,%s_b", names[i], names[i], names[i]);
    end += sprintf(end, "\nseed");
    for (size_t i = 0; i < 3 * sizeof names / sizeof *names; i++)
        end += sprintf(end, ",0.%zu", 1 + i % 9);
    sprintf(end, "\n");
    seed_text("import_sgd", "one", sgd);
}

int main(int argc, char **argv)
{
    common_set_name("make_corpus", NULL);
    if (argc != 2)
        die(EXIT_USAGE, "one argument is wanted: the folder to write to");
    folder = argv[1];
    seed_files();
    seed_protocol();
    seed_usb();
    seed_rgl();
    seed_measurements();
    return 0;
}
