/*
 * Inside the half-vector builder: samples of a BRDF laid out along the table's axes, and the least-squares fit of a table to
 * them. How and why: DESIGN.md, "Fitting the half-vector table".
 */
#ifndef HOST_TOOLS_HOST_HALF_VECTOR_FIT_H
#define HOST_TOOLS_HOST_HALF_VECTOR_FIT_H

#include "host_half_vector.h"

/* --- coordinates --- */

/* Row and plane coordinates, 0 .. nodes - 1, of s2 = sin^2 theta_h and y = (1 + sin theta_d - cos theta_d) / 2. */
double half_vector_row(const uint16_t warp_h[HALF_VECTOR_WARP_H], double s2);
double half_vector_plane(const uint16_t warp_d[HALF_VECTOR_WARP_D], double y);

/* Position of s2 among the nodes of warp_h, 0..128, and back. */
double half_vector_segment(double s2);
double half_vector_segment_s2(double segment);

/* Trilinear weights: tap m is the texel corner + (m & 1) + t * ((m >> 1 & 1) + h * (m >> 2)). */
struct half_vector_cell {
    size_t corner;
    float weight[8];
};
void half_vector_cell(struct half_vector_cell *out, const struct half_vector *t, double row, double plane, double t2);

/* --- samples --- */

struct fit_sample {
    float s2, y, t2;
    float g[3]; /* f (n.l + n.v), symmetric */
    /* For the light in either place: the share of a picture's pixels that look here, and how much the colour of such a pixel
     * changes (CIE 1976, per unit of g). */
    float pixels[2], slope[2];
};

/* A grid over the three axes: sample[(plane * rows + row) * columns + column]; t2 ascends with the column. */
struct fit_samples {
    int rows, planes, columns;
    struct fit_sample *sample; /* owned */
};

static inline size_t fit_samples_count(const struct fit_samples *s)
{
    return (size_t)s->rows * (size_t)s->planes * (size_t)s->columns;
}

/* One sample per cell of the grid with these edges (ascending; rows in s2, planes in y; one more than cells). A cell that
 * begins at 0 is averaged, so that no lobe is too narrow to be seen or weighted beyond its energy. */
void fit_samples_take(struct fit_samples *out, const struct brdf_source *source, const double *row_edges, int rows,
                      const double *plane_edges, int planes, int columns);
void fit_samples_free(struct fit_samples *s);

/* --- fit --- */

/* Fits the texels of *t, whose dimensions and warps are set, to the samples, `rounds` times, the later ones with weights that
 * turn the squares of errors into their sizes. Sets texels (allocated when NULL) and scale. Out: row_error[h - 1], each row
 * cell's share of the mean colour difference over the pixels; returns their sum. */
double half_vector_fit(struct half_vector *t, double *row_error, const struct fit_samples *s, int rounds);

/* Lowers planes of an encoded table where its albedo exceeds 1 and the source's by more than 2^-7. */
void half_vector_limit_energy(struct half_vector *t, const struct brdf_source *source);

#endif
