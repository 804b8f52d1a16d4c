/*
 * Reference evaluation of table files in double precision, from the bytes of the file. Shares nothing with the
 * product: no header, no arithmetic. Also minimal writers of table files for tests.
 */
#ifndef REF_TABLE_H
#define REF_TABLE_H

#include <stddef.h>
#include <stdint.h>

#include "ref_models.h"

enum { REF_WARP_H = 129, REF_WARP_D = 65 }; /* nodes of the two warps of a half-vector table */

enum ref_table_kind { REF_SPECULAR_FRAME, REF_HALF_VECTOR };

struct ref_table {
    enum ref_table_kind kind;
    unsigned width, height, depth; /* nodes of phi_d, theta_d, theta_in; or of t, h, d */
    float (*texels)[3];            /* R, G, B; x fastest */
    /* specular frame */
    double theta_max; /* theta_in of the last slice, radians */
    int swap;         /* 1: l and v change places when n.l < n.v */
    /* half vector */
    double warp_h[REF_WARP_H], warp_d[REF_WARP_D]; /* coordinates in nodes */
    double scale;                                  /* what texels are multiplied by */
};

/* Reads a table file; the bytes are not kept. Returns NULL when it is not one. */
struct ref_table *ref_table_open(const void *bytes, size_t n);
void ref_table_free(struct ref_table *t);

/* f(l,v) in 1/sr, zero when n.l <= 0 or n.v <= 0. n, l, v of any length but 0 (normalised here; of equal length, for swap).
 * Returns the largest channel of f over the nodes of the direction's cell and of the cells around it, which is what
 * errors of interpolation scale with; 0 together with rgb. */
double ref_table_eval(double rgb[3], const struct ref_table *t, const double n[3], const double l[3],
                      const double v[3]);

/* ref_table_eval of a half-vector table, for unit vectors above the horizon. */
double ref_half_eval(double rgb[3], const struct ref_table *t, const double n[3], const double l[3], const double v[3]);

/* One RGB9_E5 word, by its bits. */
void ref_rgb9e5_decode(double rgb[3], uint32_t word);

/* The nearest word: shared exponent of the largest channel, mantissas rounded, ties up; 0..65408. */
uint32_t ref_rgb9e5_encode(const double rgb[3]);

/* --- files --- */

struct ref_key {
    const char *name;
    uint8_t *value; /* malloc'd */
    size_t bytes;
};

enum { REF_MAX_KEYS = 12 };

struct ref_keys {
    struct ref_key key[REF_MAX_KEYS];
    unsigned count;
};

/* Adds a key or replaces its value (copied). A text's NUL is part of its value: bytes = strlen + 1. */
void ref_key_set(struct ref_keys *k, const char *name, const void *value, size_t bytes);
void ref_key_set_text(struct ref_keys *k, const char *name, const char *text);
void ref_key_remove(struct ref_keys *k, const char *name);
void ref_keys_free(struct ref_keys *k);

/* A file of width*height*depth words, x fastest, with these keys in ascending order (free() it). */
void *ref_ktx2_write(unsigned width, unsigned height, unsigned depth, const uint32_t *texels, const struct ref_keys *k,
                     size_t *bytes);

/* A specular-frame file; theta_max in thousandths of a degree. */
void *ref_ktx2_make(unsigned width, unsigned height, unsigned depth, const uint32_t *texels, unsigned theta_max,
                    size_t *bytes);

/* What a half-vector file is made of. */
struct ref_half {
    unsigned t, h, d;                                /* nodes */
    const uint32_t *texels;                          /* t fastest, then h */
    uint16_t warp_h[REF_WARP_H], warp_d[REF_WARP_D]; /* coordinate x 512 */
    int scale;                                       /* texels are multiplied by 2^scale; 0 is not written */
    int slabs;                                       /* 1: with the re-packed copy */
};

/* Warps for lobes of this width (sine of the half angle): rows close together up to it and in equal ratios beyond, a quarter of
 * them for the horizon; planes in equal steps. */
void ref_half_warp(struct ref_half *f, double width);

void ref_half_keys(struct ref_keys *k, const struct ref_half *f);
void *ref_half_make(const struct ref_half *f, size_t *bytes);

/* The texels of *f (its sizes, warps and scale must be set) by sampling at the nodes; beside the horizon where a node is on it. The
 * caller frees f->texels. */
void ref_half_sample(struct ref_half *f, ref_brdf_function *brdf, const void *context);

#endif
