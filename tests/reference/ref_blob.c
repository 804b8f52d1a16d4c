#include "ref_blob.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { LIGHTS, MATERIALS, OBJECTS, MESHES, LODS, MESHLETS, VERTICES, TRIANGLES };
enum { HEADER_BYTES = 144 };

static void put(struct ref_blob_bytes *a, const void *data, size_t bytes)
{
    if (a->bytes + bytes > a->room) {
        a->room = 2 * a->room + bytes + 64;
        a->data = realloc(a->data, a->room);
        if (!a->data)
            abort();
    }
    memcpy(a->data + a->bytes, data, bytes);
    a->bytes += bytes;
}

static void put_int(struct ref_blob_bytes *a, int bytes, int64_t value)
{
    for (int i = 0; i < bytes; i++)
        put(a, &(uint8_t){(uint8_t)((uint64_t)value >> (8 * i))}, 1);
}

static void put_fixed(struct ref_blob_bytes *a, int bytes, double value, int fraction_bits)
{
    put_int(a, bytes, (int64_t)floor(ldexp(value, fraction_bits) + 0.5));
}

static void put_vector(struct ref_blob_bytes *a, int bytes, const double *v, int n, int fraction_bits)
{
    for (int i = 0; i < n; i++)
        put_fixed(a, bytes, v[i], fraction_bits);
}

static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

void ref_blob_init(struct ref_blob *b)
{
    memset(b, 0, sizeof *b);
    memcpy(b->rotation, identity, sizeof identity);
    b->focal = 1;
    b->near = 1 / 16.0;
    b->exposure = 1;
}

void ref_blob_light(struct ref_blob *b, const double direction[3], double irradiance)
{
    struct ref_blob_bytes *a = &b->array[LIGHTS];
    double length = sqrt(direction[0] * direction[0] + direction[1] * direction[1] + direction[2] * direction[2]);
    put_int(a, 4, 0);
    for (int i = 0; i < 3; i++)
        put_fixed(a, 4, direction[i] / length, 30);
    for (int i = 0; i < 3; i++)
        put_fixed(a, 4, irradiance, 16);
    put_int(a, 4, 0);
    a->count++;
}

unsigned ref_blob_material(struct ref_blob *b, unsigned kind, unsigned slot, double kd, const char *name)
{
    struct ref_blob_bytes *a = &b->array[MATERIALS];
    char padded[16] = {0};
    memcpy(padded, name, strlen(name) < 15 ? strlen(name) : 15);
    put_int(a, 1, kind);
    put_int(a, 1, slot);
    put_int(a, 2, 0);
    put_vector(a, 4, (double[9]){kd, kd, kd, 0, 0, 0, 1, 0, 0}, 9, 16);
    put(a, padded, sizeof padded);
    return a->count++;
}

/* Unit axes of a triangle: z its normal. Returns 0 when it has no area. */
static int triangle_frame(double frame[9], const int16_t *p0, const int16_t *p1, const int16_t *p2)
{
    double e[3], d[3], *x = frame, *y = frame + 3, *z = frame + 6;
    for (int i = 0; i < 3; i++) {
        e[i] = p1[i] - p0[i];
        d[i] = p2[i] - p0[i];
    }
    for (int i = 0; i < 3; i++)
        z[i] = e[(i + 1) % 3] * d[(i + 2) % 3] - e[(i + 2) % 3] * d[(i + 1) % 3];
    double area = sqrt(z[0] * z[0] + z[1] * z[1] + z[2] * z[2]);
    double length = sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2]);
    if (area == 0)
        return 0;
    for (int i = 0; i < 3; i++) {
        x[i] = e[i] / length;
        z[i] /= area;
    }
    for (int i = 0; i < 3; i++)
        y[i] = z[(i + 1) % 3] * x[(i + 2) % 3] - z[(i + 2) % 3] * x[(i + 1) % 3];
    return 1;
}

/* Lowest and highest coordinates of n vertices. */
static void put_box(struct ref_blob_bytes *a, const int16_t *const *vertices, unsigned n)
{
    int lo[3] = {32767, 32767, 32767}, hi[3] = {-32768, -32768, -32768};
    for (unsigned i = 0; i < n; i++)
        for (int j = 0; j < 3; j++) {
            lo[j] = vertices[i][j] < lo[j] ? vertices[i][j] : lo[j];
            hi[j] = vertices[i][j] > hi[j] ? vertices[i][j] : hi[j];
        }
    for (int j = 0; j < 3; j++)
        put_int(a, 2, lo[j]);
    for (int j = 0; j < 3; j++)
        put_int(a, 2, hi[j]);
}

/* A length that is never too small. */
static double long_length(const double d[3])
{
    double a = fabs(d[0]), b = fabs(d[1]), c = fabs(d[2]);
    return floor((a + b + c + fmax(a, fmax(b, c)) + 1) / 2);
}

/* The least code of at least `size`: (8 + c%8) 2^(c/8). */
static int size_code(double size)
{
    int code = 0;
    while (ldexp(8 + code % 8, code / 8) < size)
        code++;
    return code;
}

/* A triangle's area, in 64ths, and perimeter. */
static void put_size(struct ref_blob_bytes *a, const int16_t *const corner[3])
{
    double e[3][3], cross[3], perimeter = 0;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 3; j++)
            e[i][j] = corner[(i + 1) % 3][j] - corner[i][j];
        perimeter += long_length(e[i]);
    }
    for (int i = 0; i < 3; i++)
        cross[i] = e[0][(i + 1) % 3] * e[1][(i + 2) % 3] - e[0][(i + 2) % 3] * e[1][(i + 1) % 3];
    put_int(a, 1, size_code(ceil(long_length(cross) / 128)));
    put_int(a, 1, size_code(perimeter));
}

static void put_meshlet(struct ref_blob *b, const int16_t *const corner[3])
{
    struct ref_blob_bytes *m = &b->array[MESHLETS], *v = &b->array[VERTICES], *t = &b->array[TRIANGLES];
    double frame[9];
    /* The frame's z is off by at most the rounding of three components, 2^-15 each: sin < 2 in Q14. */
    int cone_cutoff = 2;
    if (!triangle_frame(frame, corner[0], corner[1], corner[2])) {
        memcpy(frame, identity, sizeof frame);
        cone_cutoff = 16384;
    }
    put_box(m, corner, 3);
    put_vector(m, 2, frame, 9, 14);
    put_int(m, 2, cone_cutoff);
    put_int(m, 4, v->count);
    put_int(m, 4, t->count);
    put_int(m, 1, 3);
    put_int(m, 1, 1);
    put_size(m, corner);
    m->count++;
    for (int i = 0; i < 3; i++, v->count++) {
        for (int j = 0; j < 3; j++)
            put_int(v, 2, corner[i][j]);
        put_int(v, 4, 0);
    }
    for (int i = 0; i < 3; i++)
        put_int(t, 1, i);
    t->count++;
}

unsigned ref_blob_mesh(struct ref_blob *b, const int16_t (*vertices)[3], const uint16_t (*triangles)[3],
                       unsigned triangle_count)
{
    struct ref_blob_bytes *mesh = &b->array[MESHES], *lod = &b->array[LODS];
    const int16_t **corner = malloc(3 * triangle_count * sizeof *corner);
    if (!corner)
        abort();
    for (unsigned i = 0; i < 3 * triangle_count; i++)
        corner[i] = vertices[triangles[i / 3][i % 3]];
    put_int(mesh, 4, lod->count);
    put_int(mesh, 4, 1);
    put_box(mesh, corner, 3 * triangle_count);
    put_int(lod, 4, b->array[MESHLETS].count);
    put_int(lod, 4, triangle_count);
    put_int(lod, 4, 0);
    lod->count++;
    for (unsigned i = 0; i < triangle_count; i++)
        put_meshlet(b, corner + 3 * i);
    free(corner);
    return mesh->count++;
}

void ref_blob_object(struct ref_blob *b, unsigned mesh, unsigned material, const double position[3], double scale)
{
    struct ref_blob_bytes *a = &b->array[OBJECTS];
    int exponent;
    double mantissa = frexp(scale, &exponent); /* 0.5 <= mantissa < 1 */
    put_int(a, 2, mesh);
    put_int(a, 2, material);
    put_vector(a, 4, position, 3, 16);
    put_vector(a, 4, identity, 9, 30);
    put_fixed(a, 4, mantissa, 31);
    put_int(a, 4, 1 - exponent);
    a->count++;
}

void *ref_blob_finish(const struct ref_blob *b, size_t *bytes)
{
    struct ref_blob_bytes out = {0};
    size_t offset[REF_BLOB_ARRAYS], total = HEADER_BYTES;
    for (int i = 0; i < REF_BLOB_ARRAYS; i++) {
        offset[i] = total;
        total += (b->array[i].bytes + 3) & ~(size_t)3;
    }
    put(&out, "GTSC", 4);
    put_int(&out, 2, 4);
    put_int(&out, 2, HEADER_BYTES);
    put_int(&out, 4, (int64_t)total);
    put_vector(&out, 4, b->eye, 3, 16);
    put_vector(&out, 4, b->rotation, 9, 30);
    put_fixed(&out, 4, b->focal, 16);
    put_fixed(&out, 4, b->near, 16);
    put_fixed(&out, 4, b->exposure, 16);
    put_int(&out, 1, b->tone_curve);
    put(&out, b->background, 3);
    for (int i = 0; i < REF_BLOB_ARRAYS; i++) {
        put_int(&out, 4, (int64_t)offset[i]);
        put_int(&out, 4, b->array[i].count);
    }
    put_int(&out, 4, 0);
    for (int i = 0; i < REF_BLOB_ARRAYS; i++) {
        put(&out, b->array[i].data ? b->array[i].data : (uint8_t *)"", b->array[i].bytes);
        while (out.bytes % 4)
            put_int(&out, 1, 0);
    }
    *bytes = out.bytes;
    return out.data;
}

void ref_blob_free(struct ref_blob *b)
{
    for (int i = 0; i < REF_BLOB_ARRAYS; i++)
        free(b->array[i].data);
    memset(b, 0, sizeof *b);
}
