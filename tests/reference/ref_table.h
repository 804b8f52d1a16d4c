/*
 * Reference evaluation of table files in double precision, from the bytes of the file. Shares nothing with the
 * product: no header, no arithmetic. Also a minimal writer of table files for tests.
 */
#ifndef REF_TABLE_H
#define REF_TABLE_H

#include <stddef.h>
#include <stdint.h>

struct ref_table {
    unsigned width, height, depth; /* nodes of phi_d, theta_d, theta_in */
    double theta_max;              /* theta_in of the last slice, radians */
    float (*texels)[3];            /* R, G, B; x fastest */
};

/* Reads a specular-frame table file; the bytes are not kept. Returns NULL when it is not one. */
struct ref_table *ref_table_open(const void *bytes, size_t n);
void ref_table_free(struct ref_table *t);

/* f(l,v) * (n.l) in 1/sr, zero when n.l <= 0 or n.v <= 0. n, l, v of any length but 0 (normalised here).
 * Returns the largest channel of f over the nodes of the direction's cell and of the cells around it, which is what
 * errors of interpolation scale with; 0 together with rgb. */
double ref_table_eval(double rgb[3], const struct ref_table *t, const double n[3], const double l[3],
                      const double v[3]);

/* One RGB9_E5 word, by its bits. */
void ref_rgb9e5_decode(double rgb[3], uint32_t word);

/* A table file in memory (free() it). In: width*height*depth words, x fastest; theta_max in thousandths of a
 * degree. */
void *ref_ktx2_make(unsigned width, unsigned height, unsigned depth, const uint32_t *texels, unsigned theta_max,
                    size_t *bytes);

#endif
