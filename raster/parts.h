/*
 * The parts of the renderer that a program has. Materials, lights and budgets reach theirs through this table alone, so that a linker
 * which drops what nothing refers to (-ffunction-sections -fdata-sections -Wl,--gc-sections) leaves out those that a product does not
 * name:
 *   static const struct raster_parts parts = {.half_vector = &raster_half_vector_model, .diffuse_rows = &raster_diffuse_rows};
 */
#ifndef RASTER_PARTS_H
#define RASTER_PARTS_H

struct raster_model;
struct raster_rows;
struct raster_points;
struct raster_cells;
struct raster_fewer_taps;

/* NULL: the program does without. A frame whose materials or lights ask for that is refused, but rows are only a faster way. */
struct raster_parts {
    /* Materials; measured ones by the kind of their table. */
    const struct raster_model *half_vector, *specular_frame, *lafortune_phong, *blinn_phong, *metallic_roughness;
    /* Runs of a row at a time, under few directional lights: Lafortune-Phong without ks; Blinn-Phong with exponents 2, 4, .. 64. Pixels
     * differ from the models' by their rounding. */
    const struct raster_rows *diffuse_rows, *blinn_phong_rows;
    const struct raster_points *point_lights;
    /* 4 samples per pixel, shading at less than full quality, which budgets choose, and raster_frame.memory. */
    const struct raster_cells *cells;
    /* Half-vector tables by fewer texels, which budgets choose; without, they do not. */
    const struct raster_fewer_taps *fewer_taps;
};

extern const struct raster_model raster_half_vector_model;
extern const struct raster_model raster_specular_frame_model;
extern const struct raster_model raster_lafortune_phong_model;
extern const struct raster_model raster_blinn_phong_model;
extern const struct raster_model raster_metallic_roughness_model;
extern const struct raster_rows raster_diffuse_rows;
extern const struct raster_rows raster_blinn_phong_rows;
extern const struct raster_points raster_point_lights;
extern const struct raster_cells raster_cells;
extern const struct raster_fewer_taps raster_fewer_taps;

/* All of them. */
extern const struct raster_parts raster_all_parts;

#endif
