/*
 * Tile rasterizer: a scene becomes pixels, one tile at a time, without frame buffer, malloc or floating point.
 *
 *   struct raster r; struct raster_tile work;
 *   raster_begin(&r, &frame, arena, sizeof arena);
 *   for (uint32_t t = 0; t < raster_tile_count(&r); t++) {
 *       struct raster_rect rect; struct raster_stats stats;
 *       raster_render_tile(&r, t, &work, &rect, &stats);
 *       display(rect.x, rect.y, rect.width, rect.height, raster_tile_pixels(&work));
 *   }
 *
 * raster_begin culls meshlets and bins them to tiles; raster_render_tile transforms, rasterizes and shades one
 * tile. Tiles are independent: any order and any number of threads, with one struct raster_tile each, give the same pixels. So does any tile
 * size, but with 4 samples per pixel where a tile has more than RASTER_SLOTS - 1 meshlets: there a pixel may be a step off.
 */
#ifndef RASTER_RASTER_H
#define RASTER_RASTER_H

#include "lut.h"
#include "parts.h"
#include "scene.h"

/* Tile size in samples; compile-time, both powers of two, 16 to 64; with 4 samples per pixel 32 or 64. */
#ifndef RASTER_TILE_WIDTH
#define RASTER_TILE_WIDTH 64
#endif
#ifndef RASTER_TILE_HEIGHT
#define RASTER_TILE_HEIGHT 32
#endif
#define RASTER_TILE_EDGE(n) ((n) == 16 || (n) == 32 || (n) == 64)
_Static_assert(RASTER_TILE_EDGE(RASTER_TILE_WIDTH) && RASTER_TILE_EDGE(RASTER_TILE_HEIGHT),
               "blocks of 16 x 16 in a tile");

#define RASTER_MAX_WIDTH  4096u
#define RASTER_MAX_HEIGHT 4096u
#define RASTER_MAX_SLOTS  16u /* table slots */

enum raster_format {
    RASTER_RGB565 = 0, /* uint16_t per pixel, R in bits 15..11 */
    RASTER_RGB888 = 1  /* three bytes per pixel: R, G, B */
};

enum raster_status {
    RASTER_OK = 0,
    RASTER_ERR_SIZE, /* width or height zero or above RASTER_MAX_*, half of that with 4 samples; samples not 0, 1 or, with cells among
                        the parts and tiles of at least 32 x 32, 4 */
    RASTER_ERR_ARENA, /* the arena is too small even for the coarsest levels: raster.arena_needed says what they take */
    RASTER_ERR_TABLE, /* a measured material's slot holds no table: raster.bad_material says whose */
    RASTER_ERR_LIMIT, /* more than 65535 runs of meshlets in tiles at the coarsest levels, or than SCENE_MAX_LIGHTS lights */
    RASTER_ERR_BUDGET, /* tile_budget is too small: raster.budget_needed is the least */
    RASTER_ERR_MODEL, /* a material asks for a model that is not among the frame's parts: raster.bad_material says which */
    RASTER_ERR_POINT, /* a point light, and the frame's parts are without */
    RASTER_STATUS_COUNT
};

/* What frames before found, for budgets: of each tile (modulo their number here) what shading it at full quality took, and all else, over what
 * bounds expect; 6 fraction bits, 0: not known. And how often the threshold for levels of detail was doubled. */
#define RASTER_LEARNT_TILES 128
struct raster_learnt {
    uint8_t besides[RASTER_LEARNT_TILES], shading[RASTER_LEARNT_TILES];
    uint8_t lod_bias;
};

/* Everything one frame is made from. Pointers stay owned by the caller and must outlive the frame. What is not the opened scene's own has
 * passed scene_check_camera, _output, _light, _material: raster_begin looks at none of their values again. */
struct raster_frame {
    const struct raster_parts *parts;
    const struct scene *scene;
    const struct scene_camera *camera; /* usually the scene's own, or a moved copy */
    const struct scene_output *output;
    const struct scene_light *lights;       /* light_count of them */
    const struct scene_material *materials; /* as many as the scene has */
    const struct lut_table *const *tables;  /* never NULL: RASTER_MAX_SLOTS pointers, NULL where a slot is empty */
    uint16_t width, height;
    uint8_t light_count; /* at most SCENE_MAX_LIGHTS */
    uint8_t format;      /* enum raster_format */
    uint8_t samples;     /* of coverage per pixel: 4 (width, height <= 2048), or 0 or 1 for the centre alone */
    const struct raster_costs *costs; /* what the target takes (quality.h); NULL: it is not counted */
    const struct raster_bounds *
        bounds; /* &raster_tile_bounds (quality.h): tiles' bounds are found, needs costs and scene_open_bounded; or NULL */
    uint32_t tile_budget; /* ticks, mean over tiles; 0: no limit. Needs bounds, and cells among the parts */
    const struct raster_learnt *learnt; /* with a budget; zero at first; NULL: nothing is learnt */
    struct raster_memory *memory; /* zero at first; NULL: nothing is remembered. No two threads' tiles may share it */
};

struct raster_rect {
    uint16_t x, y, width, height;
};

/* What a tile cost, in counts; all zero for a tile without a meshlet, but for cost. */
struct raster_stats {
    uint32_t meshlets;  /* transformed */
    uint32_t triangles; /* front-facing ones set up */
    uint32_t tested;    /* pixels whose depth was compared */
    uint32_t general;   /* of these, by what suits triangles of any size and shape */
    uint32_t covered;   /* pixels of the tile that show a surface */
    uint32_t samples;   /* surfaces shaded, each by all lights that may reach it */
    uint32_t tried;     /* pixel-lights: of them, whether the surface faces the light or not */
    uint32_t shaded;    /* pixel-lights evaluated: of those, what is lit */
    uint32_t fetches;   /* table texels read */
    uint64_t cost;      /* drawing, shading and finishing by the frame's costs, ticks with 4 fraction bits; 0 without */
};

struct raster_object; /* per-object transform of this frame, in the arena */
struct raster_run;    /* meshlets that follow each other in a tile's list, in the arena */

/* What a tile takes, in ticks; see bound.h. */
struct raster_tile_bound {
    uint32_t least;   /* is enough, whatever there is to be drawn: for the coarsest levels at the last rung */
    uint32_t largest; /* drawing one meshlet of its list, at most */
    uint32_t demand;  /* shading it at full quality, roughly */
    uint32_t besides; /* all else: to draw its list, most of it; roughly */
    uint32_t
        keep; /* beyond the least of tiles after it, for none to need its coarsest levels, roughly; with a budget */
    uint32_t shown;    /* pixels, roughly; internal */
    uint32_t pixels;   /* of the coarsest levels: tested, at most */
    uint32_t meshlets; /* likewise: in the list */
    uint32_t passes;   /* likewise: pairs of a region and a material that may show in it, at most */
    uint16_t regions;  /* bit for each region counted in passes for a material; internal */
    uint16_t order;    /* the tile that comes as many-th as this one's index; with a budget */
    uint8_t material;  /* that */
};

struct raster_light {
    struct vec3 v; /* eye space: the unit vector towards a directional light, Q15; a point light's position, q16_16 */
    uq16_16_t irradiance[3]; /* times exposure; a point light's intensity */
    uq16_16_t radius;        /* of a point light; 0: directional */
};

struct raster_lobe; /* a power function by table, in the arena */

/* From a pixel to the direction of its view ray, see raster_view_vector. */
struct raster_view {
    int32_t step; /* half a pixel, with VIEW_STEP_BITS fraction bits, in the unit of `axis` */
    int32_t axis; /* the ray's component along the view axis, below 2^15 */
};

/* A frame being rendered. Read-only while tiles render. Fields are internal but for arena_needed, lod_bias,
 * bad_material, bounds, budget_needed. */
struct raster {
    struct raster_frame frame;
    struct raster_object *objects;
    struct raster_run *runs;
    uint16_t *heads; /* per tile: index of its first run + 1, 0 = none */
    uint32_t object_count, visible_count;
    uint16_t tiles_x, tiles_y;
    uint16_t width, height;      /* of the grid of samples */
    uint8_t sample_shift;        /* 1 with 4 samples per pixel, else 0 */
    struct raster_light *lights; /* directional ones first, in the arena */
    uint32_t directional;        /* how many they are */
    struct raster_lobe *lobes;   /* of materials whose model has one, in the arena */
    uint8_t lobe_of_material[SCENE_MAX_MATERIALS];
    bool in_rows[SCENE_MAX_MATERIALS];    /* materials shaded in runs of a row: without the view, or point lights */
    uint8_t shading[SCENE_MAX_MATERIALS]; /* enum raster_shading, where they are not */
    uint32_t slow; /* RASTER_SLOW(enum raster_shading): some material takes a slower way than its costs are of */
    struct raster_view view;
    uint8_t
        block_shift; /* log2 of the largest shading block's edge, pixels; 0: v changes too fast to be interpolated */
    size_t arena_needed; /* bytes of arena that this frame uses */
    uint32_t lod_bias;   /* how often the threshold for levels of detail was doubled to make the frame fit */
    uint32_t bad_material;
    struct raster_tile_bound *bounds; /* per tile, in the arena; NULL where they are not found */
    uint16_t *coarse_heads;           /* as heads, of all objects' coarsest levels; likewise */
    uint32_t budget_needed;           /* the mean of tiles' least ticks, rounded up */
};

/* One tile's working memory: fast RAM, one per thread. Contents are internal. */
#define RASTER_TILE_PIXELS (RASTER_TILE_WIDTH * RASTER_TILE_HEIGHT)
#define RASTER_BATCH       64  /* pixels of one material shaded together */
#define RASTER_RUN_LIGHTS  16  /* most lights of a frame whose diffuse surfaces are shaded in runs */
#define RASTER_SLOTS       128 /* meshlets of a tile between two shadings, plus one; at most 128 */

struct raster_surface {
    uint32_t depth_slot; /* depth << 8 | slot, larger is nearer; 0 = background; slot 0 = already shaded */
    uint32_t normal;     /* homogeneous U (low half) and V (high half); the finished pixel once shaded */
};

struct raster_vertex { /* projected */
    q24_8_t x, y;      /* relative to the tile's corner */
    uint32_t inv_w;    /* proportional to 1/w, at most 2^23 */
    int16_t u, v;      /* homogeneous */
};

struct raster_small { /* projected, of a small meshlet */
    uint32_t xy;      /* 24.8 from the tile's first pixel centre, x in the low half */
    uint32_t inv_w;
    uint32_t uv; /* u in the low half */
};

struct raster_clip_vertex { /* before the perspective division, in its object's scales */
    int32_t x, y, w;
    int16_t u, v; /* stereographic, Q14 */
};

struct raster_slot {  /* a meshlet in this tile: what shading needs of it */
    int16_t frame[9]; /* columns: its frame's axes in eye space, Q14 */
    uint8_t material;
    uint8_t normal_shift; /* from 1/w to the normal's third coordinate */
    uint8_t class_id;     /* see raster_survey; 0 without a survey */
    uint8_t contrast;
    uint16_t memory; /* index into raster_memory */
};

struct raster_batch_pixel {
    uint32_t normal_xy; /* eye space, Q15, x in the low half */
    int32_t normal_z;
    int32_t nv;  /* n.v, Q30 */
    uint32_t at; /* in the block: x | y << 8 */
};

/* Pixels of one material in one shading block, row by row. */
struct raster_batch {
    union {
        struct raster_batch_pixel pixel[RASTER_BATCH];
        struct { /* shading in runs, which takes no pixels */
            /* kd/pi * irradiance of a material under each light, 21 fraction bits */
            uint32_t diffuse_colour[RASTER_RUN_LIGHTS][3];
            uint32_t diffuse_material; /* whose, plus one; 0: none yet */
        };
    };
    uq12_20_t radiance[RASTER_BATCH][3];
    uint32_t surface[RASTER_BATCH]; /* index into the tile's; in the upper half which of those around it, see cells.c */
    uint32_t count;
    uint32_t material;
    uint32_t taps; /* enum raster_taps, quality.h */
};

#define RASTER_REGION_SHIFT  4 /* log2 of a region's edge, pixels: see quality.h */
#define RASTER_REGIONS(edge) (((edge) + (1u << RASTER_REGION_SHIFT) - 1) >> RASTER_REGION_SHIFT)
#define RASTER_MAX_REGIONS   (RASTER_REGIONS(RASTER_TILE_WIDTH) * RASTER_REGIONS(RASTER_TILE_HEIGHT))

/*
 * What a tile's shading tells the same surfaces' next frame: by a hash of object and meshlet, one plus the contrast of what it showed,
 * 0: unknown. Contrast is log2 of 1 + (the range of its green, in 8-bit steps)^2 / its pixels: the square of its gradient, roughly.
 */
#define RASTER_MEMORY_SHIFT 12
struct raster_memory {
    uint8_t contrast[1 << RASTER_MEMORY_SHIFT];
};

/* What waits for its shading, of one class. Cells are of 4 x 4 pixels, aligned in the tile. */
struct raster_area {
    uint16_t pixels; /* samples of them, where there are 4 in a pixel */
    uint16_t cells;  /* pairs of a cell and a meshlet that shows in it: what is shaded at rate 4x4 */
};

/* An axis-aligned box, eye space, q16_16: see point_light.h. */
struct raster_light_box {
    struct vec3 lo, hi;
};

/* Of a tile that is drawn. Its meshlets are sorted into classes, which get a rate each: by how they are shaded, and by contrast. */
#define RASTER_CLASSES 7u /* one for every way of shading, at least; more take longer to choose for than they gain */
struct raster_survey {
    uint32_t regions;      /* of the tile, row-major */
    uint32_t slots;        /* taken: the most that a flat tile evaluates */
    uint32_t point_lights; /* that may reach one of its surfaces */
    uint32_t classes;      /* some may be without pixels */
    uint32_t edges; /* cells of 4 x 4 with samples without a surface beside others, and all that are cut or larger */
    uint8_t material[RASTER_CLASSES]; /* one of the class: all its materials are shaded alike */
    uint8_t meshlets[RASTER_CLASSES]; /* of the class, that show */
    uint32_t detail[RASTER_CLASSES];  /* 2^contrast, summed over pixels */
    struct raster_area total[RASTER_CLASSES];
    struct raster_area area[RASTER_CLASSES][RASTER_MAX_REGIONS];
};

struct raster_tile {
    struct raster_surface surface[RASTER_TILE_PIXELS]; /* the finished pixels overwrite it from the start */
    struct raster_slot slots[RASTER_SLOTS];            /* 0 is not used */
    union {                                            /* the meshlet being drawn; then the tile being shaded */
        struct {
            union {
                struct raster_small small[SCENE_MESHLET_MAX_VERTICES];
                struct {
                    struct raster_vertex vertices[SCENE_MESHLET_MAX_VERTICES];
                    struct raster_clip_vertex clip[SCENE_MESHLET_MAX_VERTICES];
                } general;
            };
            int32_t spans[2 * RASTER_TILE_HEIGHT];
        };
        struct {
            struct raster_survey survey;
            struct raster_light_box box;                   /* what is seen, where there are point lights */
            uint32_t flat[RASTER_SLOTS];                   /* a slot's finished colour, see cells.c */
            uint16_t pixels[RASTER_SLOTS];                 /* that show it */
            uint8_t low[RASTER_SLOTS], high[RASTER_SLOTS]; /* of its green; low above high: nothing is known */
        } shading;
    } m;
    int32_t centre_x2,
        centre_y2;       /* the picture's centre from the tile's corner in 1/512 px, plus one to round to nearest */
    uint32_t run;        /* of the next meshlet, index + 1; 0: all are drawn */
    uint32_t meshlet;    /* that */
    uint32_t run_left;   /* older ones in its run */
    uint32_t slot_count; /* used, without slot 0 */
    struct raster_memory *memory;                  /* the frame's, from the survey on */
    uint32_t light_reaches[SCENE_MAX_LIGHTS / 32]; /* lights that may reach a surface of the tile */
    uint32_t light_chosen[SCENE_MAX_LIGHTS / 32];  /* of these, the strongest */
    uint32_t light_count, chosen_count;            /* how many they are */
    struct raster_batch batch;
};

/* Bytes of arena that this very frame needs at the levels of detail that its threshold asks for, whatever its budget; 0 when raster_begin
 * would fail for another reason. Runs the culling pass once for every 48 tiles, with bounds twice. */
size_t raster_arena_bytes(const struct raster_frame *f);

/*
 * Chooses levels of detail, culls and bins. In: arena of `bytes` bytes, 8-aligned, used until the frame's last tile. When the
 * arena is too small, or 16-bit ids run out, the threshold (of 0: 1/16 px) is doubled until the frame fits: no triangle is
 * ever left out; it is doubled, too, while under a budget some tile is expected to need its coarsest levels, as far as the arena goes. On error *r is not a frame, but r->arena_needed (RASTER_ERR_ARENA) and r->bad_material (RASTER_ERR_TABLE, RASTER_ERR_MODEL) and r->budget_needed
 * (RASTER_ERR_BUDGET) are set.
 */
enum raster_status raster_begin(struct raster *r, const struct raster_frame *f, void *arena, size_t bytes);

/* A short lower-case English sentence, constant storage. */
const char *raster_status_text(enum raster_status s);

static inline uint32_t raster_tile_count(const struct raster *r)
{
    return (uint32_t)r->tiles_x * r->tiles_y;
}

/* The tile to be rendered i-th: with a budget those that need the least for certain come first, so that what they leave is of use to
 * others. Any order is right. In: i < raster_tile_count. */
static inline uint32_t raster_tile_at(const struct raster *r, uint32_t i)
{
    return r->frame.tile_budget ? r->bounds[i].order : i;
}

/* Renders tile `index` (row-major, < raster_tile_count). *rect is its place on the screen, cut at the picture's
 * right and bottom edge; pixels are rect->width * rect->height, row by row without padding, at
 * raster_tile_pixels(work), valid until work is used again. They were stored as words, too: read 16-bit ones by memcpy, DMA or a type that may
 * alias. */
void raster_render_tile(const struct raster *r, uint32_t index, struct raster_tile *work, struct raster_rect *rect,
                        struct raster_stats *stats);

static inline const uint8_t *raster_tile_pixels(const struct raster_tile *work)
{
    return (const uint8_t *)work->surface;
}

#endif
