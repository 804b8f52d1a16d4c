/*
 * The scene blob: what the host tool gtscene writes and the device renders, read in place.
 *
 * Layout: one scene_header, then the arrays it points to. Little-endian, every array 4-aligned at the byte offset
 * given, lengths in elements. All structures are fixed-size and padding-free; SPEC.md, "Scene blob", repeats this
 * byte by byte.
 *
 * Conventions: world and eye space are right-handed with +Y up; the eye looks down -Z; triangles are
 * counter-clockwise seen from outside; a rotation is nine q2_30_t, row-major.
 * Eye space: e = camera.rotation * (world - camera.eye). Depth: w = -e.z, visible from camera.near on.
 * Screen (pixels, y down, pixel centres at .5), H the picture's height:
 *   sx = W/2 + H/2 * focal * e.x / w        sy = H/2 - H/2 * focal * e.y / w
 * World position of vertex q: object.rotation * q * scale + object.position, where scale =
 * object.scale_mantissa * 2^-(30 + object.scale_shift): uniform, so that normals need only the rotation.
 */
#ifndef RASTER_SCENE_H
#define RASTER_SCENE_H

#include "fixed.h"

#define SCENE_MAGIC                 0x43535447u /* "GTSC" */
#define SCENE_VERSION               4u
#define SCENE_MAX_BYTES             (64u << 20)
#define SCENE_MAX_OBJECTS           4096u
#define SCENE_MAX_MATERIALS         64u
#define SCENE_MAX_LIGHTS            128u
#define SCENE_MESHLET_MAX_VERTICES  32u
#define SCENE_MESHLET_MAX_TRIANGLES 32u
#define SCENE_MAX_LOD_ERROR         (64u << 16)
#define SCENE_MAX_RADIUS            (32768u << 16)
/* 1/32: the lobe of alpha = 2^-10 is eight steps of a stored normal (2^-13 rad) wide; a narrower one would fall between them. */
#define SCENE_MIN_ROUGHNESS (1u << 11)

struct scene_array {
    uint32_t offset; /* bytes from the start of the blob, a multiple of 4 */
    uint32_t count;  /* elements */
};

struct scene_camera {
    q16_16_t eye[3];
    q2_30_t rotation[9]; /* rows: right, up, back; orthonormal within 2^-14 */
    uq16_16_t focal;     /* cot(vertical field of view / 2), 2^-8 .. 2^8 */
    uq16_16_t near;      /* > 0 */
};

enum scene_tone_curve {
    SCENE_TONE_NONE = 0,  /* clamp, sRGB encode */
    SCENE_TONE_ACES = 1,  /* Hill's ACES fit, sRGB encode */
    SCENE_TONE_LINEAR = 2 /* clamp only: linear pixels */
};

struct scene_output {
    uq16_16_t exposure;    /* multiplies every light */
    uint8_t tone_curve;    /* enum scene_tone_curve */
    uint8_t background[3]; /* sRGB, what a pixel without surface shows */
};

enum scene_light_kind { SCENE_LIGHT_DIRECTIONAL = 0, SCENE_LIGHT_POINT = 1 };

/*
 * A point light of power P (any photometric or radiant unit per colour) has the intensity I = P / (4 pi); on a surface facing it
 * at distance d the irradiance is I * min(1/max(d, 0.01)^2 * clamp(1 - (d/radius)^4, 0, 1)^2, 1), see point_light.h.
 */
struct scene_light {
    uint8_t kind;        /* enum scene_light_kind */
    uint8_t reserved[3]; /* 0 */
    union {
        q2_30_t direction[3]; /* directional: world space, unit within 2^-14, towards the light */
        q16_16_t position[3]; /* point: world space */
    };
    uq16_16_t irradiance[3]; /* linear sRGB. Directional: on a surface facing the light, 0..256; pi on white diffuse is
                                display white. Point: its intensity, any */
    uq16_16_t radius;        /* point: where its light ends, > 0, at most SCENE_MAX_RADIUS; directional: 0 */
};

enum scene_material_kind {
    SCENE_MATERIAL_MEASURED = 0,
    SCENE_MATERIAL_LAFORTUNE_PHONG = 1, /* f = kd/pi + ks (n+2)/(2 pi) max(v.r, 0)^n */
    SCENE_MATERIAL_BLINN_PHONG = 2,     /* see raster/blinn_phong.c */
    SCENE_MATERIAL_METALLIC_ROUGHNESS = 3,
    SCENE_MATERIAL_KIND_COUNT
};

struct scene_material {
    uint8_t kind;        /* enum scene_material_kind */
    uint8_t slot;        /* table slot, for measured */
    uint8_t reserved[2]; /* 0 */
    uq16_16_t kd[3];     /* 0..1; of metallic-roughness its base colour */
    uq16_16_t ks[3];     /* 0..1; of metallic-roughness 0 */
    uq16_16_t exponent;  /* n, 0..4096 */
    uq16_16_t metalness; /* 0..1 */
    uq16_16_t roughness; /* 0..1; of metallic-roughness at least SCENE_MIN_ROUGHNESS */
    char name[16];       /* ASCII, NUL-padded */
};

struct scene_object {
    uint16_t mesh, material;
    q16_16_t position[3];
    q2_30_t rotation[9];     /* orthonormal within 2^-14 */
    uint32_t scale_mantissa; /* 2^30 .. 2^31-1 */
    int32_t scale_shift;     /* 0 .. 40: world units per vertex unit = mantissa * 2^-(30+shift) */
};

struct scene_mesh {
    uint32_t lod_first, lod_count; /* into lods; count >= 1, finest first */
    int16_t lo[3], hi[3];          /* bounding box of all its vertices */
};

/*
 * A frame draws of each object the coarsest level with error * scale * focal * H/2 / w <= lod_error, w the depth of the
 * nearest point of its mesh's box that is not behind the near plane.
 */
struct scene_lod {
    uint32_t meshlet_first, meshlet_count; /* into meshlets */
    uint32_t error;                        /* largest distance from the original surface, vertex units, rounded up */
};

/*
 * A meshlet: at most 32 vertices and 32 triangles. Its frame's rows are x, y, z axes in object space (Q14,
 * orthonormal within 2^-12); z is the mean normal direction. Normals are stored in that frame.
 * Back-face cone: every triangle's geometric normal g satisfies g.z_axis >= cos(a), and cone_cutoff = sin(a)
 * in Q14 rounded up, so that a meshlet is invisible when for its whole box dot(p - eye, z_axis) >=
 * cone_cutoff * |p - eye|; 16384 disables the test.
 * Size: area and perimeter of its triangles, summed, in a code c that stands for (8 + c%8) 2^(c/8), rounded up; area in units
 * of 64 square vertex units. What a tile's budget guarantees follows from them. Lengths are those of scene_length.
 */
struct scene_meshlet {
    int16_t lo[3], hi[3]; /* box of its vertices, object space, vertex units */
    int16_t frame[9];
    int16_t cone_cutoff;
    uint32_t vertex_first;   /* into vertices */
    uint32_t triangle_first; /* into triangles */
    uint8_t vertex_count;    /* 3..32 */
    uint8_t triangle_count;  /* 1..32 */
    uint8_t area, perimeter; /* codes */
};

/* Position in vertex units and normal as stereographic coordinates in the meshlet's frame, Q14:
 * n = (2u, 2v, 1-s)/(1+s), s = u^2+v^2; s <= 1 (a normal within 90 degrees of the frame's z). */
struct scene_vertex {
    int16_t x, y, z;
    int16_t u, v;
};

/* Three vertex indices local to the meshlet, counter-clockwise. */
struct scene_triangle {
    uint8_t v[3];
};

/* At least the length of (x, y, z), at most 1.42 times it: the largest magnitude plus half of the others'. In: |x|, |y|, |z| < 2^61. */
static inline uint64_t scene_length(int64_t x, int64_t y, int64_t z)
{
    const uint64_t a = fx_magnitude(x), b = fx_magnitude(y), c = fx_magnitude(z), ab = a > b ? a : b;
    const uint64_t most = ab > c ? ab : c;
    return (a + b + c + most + 1) >> 1;
}

/* What a size code stands for: 8 .. 15 2^31. */
static inline uint64_t scene_size(uint8_t code)
{
    return (uint64_t)(8 + code % 8) << code / 8;
}

/* Sets a meshlet's area and perimeter to the least codes that hold for its triangles. In: its other fields, valid; the arrays that they
 * are in. */
void scene_measure(struct scene_meshlet *m, const struct scene_vertex *vertices,
                   const struct scene_triangle *triangles);

struct scene_header {
    uint32_t magic;
    uint16_t version;
    uint16_t header_bytes; /* sizeof(struct scene_header) */
    uint32_t total_bytes;
    struct scene_camera camera;
    struct scene_output output;
    struct scene_array lights, materials, objects, meshes, lods, meshlets, vertices, triangles;
    uq16_16_t
        lod_error; /* largest projected simplification error, pixels, 0..64: see struct scene_lod; 0 draws the finest */
};

_Static_assert(sizeof(struct scene_camera) == 56, "layout");
_Static_assert(sizeof(struct scene_output) == 8, "layout");
_Static_assert(sizeof(struct scene_light) == 32, "layout");
_Static_assert(sizeof(struct scene_material) == 56, "layout");
_Static_assert(sizeof(struct scene_object) == 60, "layout");
_Static_assert(sizeof(struct scene_mesh) == 20, "layout");
_Static_assert(sizeof(struct scene_lod) == 12, "layout");
_Static_assert(sizeof(struct scene_meshlet) == 44, "layout");
_Static_assert(sizeof(struct scene_vertex) == 10, "layout");
_Static_assert(sizeof(struct scene_triangle) == 3, "layout");
_Static_assert(sizeof(struct scene_header) == 144, "layout");

/* A validated blob; pointers into it. */
struct scene {
    const struct scene_header *header;
    const struct scene_light *lights;
    const struct scene_material *materials;
    const struct scene_object *objects;
    const struct scene_mesh *meshes;
    const struct scene_lod *lods;
    const struct scene_meshlet *meshlets;
    const struct scene_vertex *vertices;
    const struct scene_triangle *triangles;
};

enum scene_status {
    SCENE_OK = 0,
    SCENE_ERR_TRUNCATED, /* shorter than its header or an array says */
    SCENE_ERR_ALIGNMENT, /* the buffer or an array offset is not 4-aligned */
    SCENE_ERR_MAGIC,
    SCENE_ERR_VERSION,
    SCENE_ERR_HEADER, /* header_bytes or total_bytes wrong */
    SCENE_ERR_LIMIT,  /* more of something than SCENE_MAX_* */
    SCENE_ERR_CAMERA,
    SCENE_ERR_OUTPUT,
    SCENE_ERR_LIGHT,
    SCENE_ERR_MATERIAL,
    SCENE_ERR_OBJECT,
    SCENE_ERR_MESH,
    SCENE_ERR_MESHLET,
    SCENE_STATUS_COUNT
};

/* A short lower-case English sentence, constant storage. */
const char *scene_status_text(enum scene_status s);

/* Validates every offset, count, index and range above (one pass over meshlets and triangles) and fills *out,
 * which is untouched on error. In: blob of `bytes` bytes, 4-aligned, owned by the caller, must outlive *out. Nothing is drawn by
 * meshlets' area and perimeter, which are not looked at. */
enum scene_status scene_open(struct scene *out, const void *blob, size_t bytes);

/* The same for frames under a budget (raster_frame.bounds), which rests on them: SCENE_ERR_MESHLET, too, where an area or a perimeter is
 * less than scene_measure finds. */
enum scene_status scene_open_bounded(struct scene *out, const void *blob, size_t bytes);

/* The checks scene_open makes of the parts that a host may also set one by one. */
enum scene_status scene_check_camera(const struct scene_camera *c);
enum scene_status scene_check_output(const struct scene_output *o);
enum scene_status scene_check_light(const struct scene_light *l);
enum scene_status scene_check_material(const struct scene_material *m);

#endif
