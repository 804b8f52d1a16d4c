/*
 * Light from all around: an environment map, and what a surface reflects of it, by numerical integration in double precision.
 *
 * A map is equirectangular. The column is the longitude, +180 degrees at the left edge down to -180 at the right one; the row is
 * the latitude, +90 degrees at the top. Latitude 0, longitude 0, the map's centre, is direction +z; longitude 90 is +x; y is up
 * (OpenEXR's latitude-longitude maps). To a camera that looks along -z the centre is what lies behind it.
 */
#ifndef HOST_TOOLS_HOST_ENVIRONMENT_H
#define HOST_TOOLS_HOST_ENVIRONMENT_H

#include "host_source.h"

struct environment {
    int width, height;
    float *rgb;                     /* [height][width][3]: radiance, linear, >= 0, the same all over a pixel; owned */
    double mean;                    /* luminance of the radiance, over all directions */
    struct environment_node *nodes; /* owned */
};

/* Reads an EXR or HDR file. A map of more than ENVIRONMENT_MAX_WIDTH columns is averaged down. Negative values become 0. Dies with
 * EXIT_FILE, or EXIT_BAD_INPUT when it cannot be decoded or a value is not finite. */
enum { ENVIRONMENT_MAX_WIDTH = 1024 };
void environment_read(struct environment *out, const char *path);

/* The same from pixels, which are copied: 4 to ENVIRONMENT_MAX_WIDTH columns, 2 to ENVIRONMENT_MAX_WIDTH rows. */
void environment_make(struct environment *out, int width, int height, const float *rgb);
void environment_free(struct environment *e);

/* Unit vector towards the point (x, y) of the map, 0..width and 0..height from its upper left corner: + 0.5 for a pixel's middle. */
void environment_direction(double d[3], const struct environment *e, double x, double y);

/* Of each pixel in the row, in steradians; 4 pi over all pixels. */
double environment_solid_angle(const struct environment *e, int row);

/*
 * Radiance that a surface with normal n sends towards v (unit vectors, in the map's frame): the integral of f(l,v) L(l) n.l over all l; 0
 * where n.v <= 0. Every pixel counts, with its exact solid angle. Neighbours are taken as one direction, the mean of their light,
 * where f can hardly differ between them: as wide apart as a share of the half vector's angle to the normal, and closer where it is
 * bright. Near the mirror direction pixels are split instead. Hierarchy as in Walter et al. 2005, "Lightcuts: a scalable approach to
 * illumination".
 *
 * coarseness: 1 for figures, error mostly below 0.3 % (chrome 1 %), 1000 to 3000 evaluations of f; 4 for pictures, a sixth of the
 * evaluations, 2 %. Deterministic; may be called from several threads when f may.
 */
void environment_reflect(double rgb[3], const struct environment *e, const struct brdf_source *f, const double n[3],
                         const double v[3], double coarseness);

#endif
