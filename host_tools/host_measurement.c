#include "host_measurement.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"
#include "host_csv.h"
#include "host_rgl.h"

/* The file, little-endian (SPEC.md, "Measurement file"). The line ends in the magic show a transfer that
 * changed them. */
static const uint8_t magic[8] = {'G', 'T', 'M', 'E', 'A', 'S', '\r', '\n'};
enum {
    VERSION = 2,
    HEADER_BYTES = 88,
    POINT_BYTES = 28, /* 24 in version 1, which had no marks */
    CRC_OFFSET = 12,
    CRC_FROM = 16,
    COUNT_OFFSET = 16,
    SOURCE_OFFSET = 24
};
#define MAX_FILE_BYTES ((size_t)1 << 30)

static uint32_t crc32_ieee(const uint8_t *data, size_t bytes)
{
    uint32_t table[256], crc = 0xffffffff;
    for (uint32_t i = 0; i < 256; i++) {
        table[i] = i;
        for (int bit = 0; bit < 8; bit++)
            table[i] = table[i] >> 1 ^ (table[i] & 1 ? 0xedb88320 : 0);
    }
    for (size_t i = 0; i < bytes; i++)
        crc = crc >> 8 ^ table[(crc ^ data[i]) & 0xff];
    return ~crc;
}

static uint32_t get_u32(const uint8_t *p)
{
    return p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

static void put_u32(uint8_t *p, uint32_t x)
{
    for (int i = 0; i < 4; i++)
        p[i] = (uint8_t)(x >> 8 * i);
}

static float get_f32(const uint8_t *p)
{
    uint32_t u = get_u32(p);
    float x;
    memcpy(&x, &u, 4);
    return x;
}

static void put_f32(uint8_t *p, float x)
{
    uint32_t u;
    memcpy(&u, &x, 4);
    put_u32(p, u);
}

const struct measurement_geometry *measurement_geometry_find(const char *name)
{
    static const struct measurement_geometry all[] = {{"minidiff", 20, 4, 75}, {"dense", 5, 18, 88}};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++)
        if (!strcmp(name, all[i].name))
            return &all[i];
    die(EXIT_USAGE, "--geometry: '%s' is not minidiff or dense", name);
}

void measurement_init(struct measurement *out, const char *source)
{
    memset(out, 0, sizeof *out);
    const char *slash = strrchr(source, '/');
    const char *base = slash ? slash + 1 : source;
    for (size_t i = 0; base[i] && i < sizeof out->source - 1; i++)
        out->source[i] = base[i] > ' ' && base[i] < 0x7f ? base[i] : '_';
}

void measurement_add(struct measurement *m, const struct measurement_point *point)
{
    if (m->count == m->room) {
        m->room = m->room ? 2 * m->room : 4096;
        m->points = xrealloc(m->points, m->room * sizeof *m->points);
    }
    m->points[m->count++] = *point;
}

void measurement_sample(struct measurement *m, const struct measurement_geometry *g,
                        enum measurement_mark (*value)(double rgb[3], const void *ctx, double theta_in,
                                                       double theta_out, double phi_out),
                        const void *ctx, double theta_in_last)
{
    const double degree = 3.14159265358979323846 / 180;
    for (int i = 0; i < g->theta_in_count; i++) {
        double theta_in = i * g->theta_in_step, rgb[3];
        bool beyond = theta_in > theta_in_last + 1e-3;
        for (int theta = 0; theta <= g->theta_out_max; theta++)
            for (int phi = 0; phi < 360; phi++) {
                enum measurement_mark mark = value(rgb, ctx, theta_in * degree, theta * degree, phi * degree);
                measurement_add(m, &(struct measurement_point){(float)theta_in,
                                                               (float)theta,
                                                               (float)phi,
                                                               {(float)rgb[0], (float)rgb[1], (float)rgb[2]},
                                                               beyond ? MEASUREMENT_EXTRAPOLATED : mark});
            }
    }
}

void measurement_free(struct measurement *m)
{
    free(m->points);
    memset(m, 0, sizeof *m);
}

bool measurement_recognise(const uint8_t *data, size_t bytes)
{
    return bytes >= 6 && !memcmp(data, magic, 6);
}

static bool point_valid(const struct measurement_point *p)
{
    bool ok = p->theta_in >= 0 && p->theta_in < 90 && p->theta_out >= 0 && p->theta_out <= 90 && p->phi_out >= 0 &&
              p->phi_out < 360 && p->mark <= MEASUREMENT_FILLED;
    for (int c = 0; c < 3; c++)
        ok = ok && p->rgb[c] >= 0 && p->rgb[c] <= FLT_MAX;
    return ok;
}

void measurement_parse(struct measurement *out, const char *path, const uint8_t *data, size_t bytes)
{
    if (bytes < HEADER_BYTES)
        die(EXIT_BAD_INPUT, "%s: %zu bytes, shorter than the %d-byte header; import it again", path, bytes,
            HEADER_BYTES);
    if (memcmp(data, magic, sizeof magic))
        die(EXIT_BAD_INPUT, "%s: line ends of the magic were changed; copy the file as binary", path);
    unsigned version = data[8] | (unsigned)data[9] << 8, header = data[10] | (unsigned)data[11] << 8;
    if (version < 1 || version > VERSION)
        die(EXIT_BAD_INPUT, "%s: measurement file version %u, this program reads 1 to %d; use a newer gtlut", path,
            version, VERSION);
    size_t point_bytes = version == 1 ? POINT_BYTES - 4 : POINT_BYTES;
    uint32_t count = get_u32(data + COUNT_OFFSET);
    if (header != HEADER_BYTES || !count || count > MEASUREMENT_MAX_POINTS)
        die(EXIT_BAD_INPUT, "%s: header of %u bytes and %u points, want %d bytes and 1..%u points; import it again",
            path, header, count, HEADER_BYTES, MEASUREMENT_MAX_POINTS);
    if (bytes != HEADER_BYTES + count * point_bytes)
        die(EXIT_BAD_INPUT,
            "%s: %zu bytes where %u points need %zu; the file is truncated or has a tail: import it again", path, bytes,
            count, HEADER_BYTES + count * point_bytes);
    uint32_t crc = crc32_ieee(data + CRC_FROM, bytes - CRC_FROM);
    if (crc != get_u32(data + CRC_OFFSET))
        die(EXIT_BAD_INPUT, "%s: CRC-32 is %08x, the header says %08x; the file is damaged: import it again", path, crc,
            get_u32(data + CRC_OFFSET));
    char source[sizeof out->source];
    memcpy(source, data + SOURCE_OFFSET, sizeof source);
    source[sizeof source - 1] = 0;
    measurement_init(out, source);
    const uint8_t *p = data + HEADER_BYTES;
    for (uint32_t i = 0; i < count; i++, p += point_bytes) {
        struct measurement_point point = {get_f32(p),
                                          get_f32(p + 4),
                                          get_f32(p + 8),
                                          {get_f32(p + 12), get_f32(p + 16), get_f32(p + 20)},
                                          version == 1 ? MEASURED : get_u32(p + 24)};
        if (!point_valid(&point))
            die(EXIT_BAD_INPUT,
                "%s: point %u is out of range (angles %g %g %g, values %g %g %g, mark %u); import it again", path, i,
                point.theta_in, point.theta_out, point.phi_out, point.rgb[0], point.rgb[1], point.rgb[2], point.mark);
        measurement_add(out, &point);
    }
}

void measurement_load(struct measurement *out, const char *path, uint8_t *data, size_t bytes)
{
    if (rgl_recognise(data, bytes))
        die(EXIT_BAD_INPUT, "%s: an RGL material file; gtlut import it first", path);
    if (measurement_recognise(data, bytes))
        measurement_parse(out, path, data, bytes);
    else
        csv_parse(out, path, (char *)data, bytes, false);
}

void measurement_read(struct measurement *out, const char *path)
{
    size_t bytes;
    uint8_t *data = read_file(path, MAX_FILE_BYTES, &bytes);
    measurement_load(out, path, data, bytes);
    free(data);
}

void measurement_write(const struct measurement *m, const char *path)
{
    size_t bytes = HEADER_BYTES + m->count * POINT_BYTES;
    uint8_t *data = xcalloc(bytes, 1), *p = data + HEADER_BYTES;
    memcpy(data, magic, sizeof magic);
    data[8] = VERSION;
    data[10] = HEADER_BYTES;
    put_u32(data + COUNT_OFFSET, (uint32_t)m->count);
    memcpy(data + SOURCE_OFFSET, m->source, sizeof m->source);
    for (size_t i = 0; i < m->count; i++, p += POINT_BYTES) {
        const struct measurement_point *s = &m->points[i];
        put_f32(p, s->theta_in);
        put_f32(p + 4, s->theta_out);
        put_f32(p + 8, s->phi_out);
        for (int c = 0; c < 3; c++)
            put_f32(p + 12 + 4 * c, s->rgb[c]);
        put_u32(p + 24, s->mark);
    }
    put_u32(data + CRC_OFFSET, crc32_ieee(data + CRC_FROM, bytes - CRC_FROM));
    write_file(path, data, bytes);
    free(data);
}
