/*
 * Pictures of a material: lobe, plots, slices, a sphere. Each is one page, drawn by gnuplot; the extension of its path, .svg or .png,
 * chooses the format. All die with EXIT_FILE when it cannot be written.
 *
 * What was not measured is marked: hatched in orange where extrapolated, in violet where filled in by interpolation, dotted in curves,
 * and the page says so.
 */
#ifndef HOST_TOOLS_HOST_PREVIEW_H
#define HOST_TOOLS_HOST_PREVIEW_H

#include "host_environment.h"
#include "host_gnuplot.h"
#include "host_measurement.h"
#include "host_mesh.h"
#include "host_source.h"

struct preview {
    char *title; /* owned */
    struct brdf_source source;
    struct measurement_grid samples; /* that the source was made from; count 0 when it was made from something else */
};

void preview_free(struct preview *p);

/* Light comes in at each multiple of 15 degrees up to 75: the BRDF's luminance in the plane of incidence, polar and Cartesian. */
void preview_plots(const struct preview *p, const char *path);

/* The BRDF's luminance as a surface around the point where light from theta_in (degrees, 0..89) arrives, seen from the side. The
 * distance is the value's cube root, the colour that of the reflected light. */
void preview_lobe(const struct preview *p, double theta_in, const char *path);

/* Half vector's angle theta_h to the right, difference angle theta_d upwards, azimuth phi_d 90 degrees (Burley 2012, "Physically-based
 * shading at Disney"); beside it those of `against` and ten times the difference unless NULL. */
void preview_image_slices(const struct preview *p, const struct preview *against, const char *path);

struct preview_view {
    const struct environment *environment;
    const struct mesh *mesh; /* NULL: a sphere */
    double turn;       /* of the mesh about the y axis, degrees; it is then tipped 12 degrees towards the viewer */
    int size;          /* pixels, of the longer side */
    double exposure;   /* 1: what shows the map's mean radiance as a light grey */
    int threads;       /* 0: as many as there are processors */
    double coarseness; /* of environment_reflect */
};

/* Lit by the environment, without shadows. For a page the material is sampled finely first; a path in .exr gets the radiance alone,
 * from the material as it is, in floats, 0 around it. */
void preview_sphere(const struct preview *p, const struct preview_view *view, const char *path);

/* A sphere of each material with its title below. `open` fills in material i and is called for each of `count`, one after the other;
 * false leaves it out. Dies with EXIT_BAD_INPUT when none is left. */
void preview_sheet(bool (*open)(struct preview *out, const void *ctx, size_t i), const void *ctx, size_t count,
                   const struct preview_view *view, const char *path);

/* A room with a bright sky, two lamps and a floor: light where there is no map at hand. */
void preview_studio(struct environment *out);

#endif
