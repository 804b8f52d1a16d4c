#include "parts.h"

const struct raster_parts raster_all_parts = {
    .half_vector = &raster_half_vector_model,
    .specular_frame = &raster_specular_frame_model,
    .lafortune_phong = &raster_lafortune_phong_model,
    .blinn_phong = &raster_blinn_phong_model,
    .metallic_roughness = &raster_metallic_roughness_model,
    .diffuse_rows = &raster_diffuse_rows,
    .blinn_phong_rows = &raster_blinn_phong_rows,
    .point_lights = &raster_point_lights,
    .cells = &raster_cells,
    .fewer_taps = &raster_fewer_taps,
};
