/*
 * Tile budgets: no tile takes longer than its share, and what is saved is saved where it is seen least.
 *
 * The host sets the mean of a tile's ticks; times the tiles that is the frame's deadline. What each tile takes at the coarsest levels of
 * detail and the last rung of shading is known (struct raster_tile_bound), and kept for those to come: a tile that would reach into it is drawn
 * again so. What is left beyond that is dealt out as tiles are drawn: after visibility, pixels per class of surfaces are known, and so is what each
 * rate of shading costs. All tiles are to be shaded at the same price of an error in ticks, which the tiles so far tell; the plan is the
 * assignment of least summed error that is expected to fit. As the expectation may be wrong, every region of the tile is shaded only at rates that
 * fit at their worst, with everything after it at the last rung: the plan may err, the tile is never over its share, nor the frame.
 *
 * Errors are squared 8-bit steps of the displayed pixel, summed over pixels and colours.
 */
#ifndef FIRMWARE_BUDGET_H
#define FIRMWARE_BUDGET_H

#include "hal.h"
#include "quality.h"

/* What a tile got and took. */
struct budget_report {
    uint32_t share;       /* ticks, granted after visibility; 0: no budget */
    uint32_t spent;       /* ticks */
    uint32_t predicted;   /* ticks, after visibility */
    uint32_t own;         /* ticks spent on deciding */
    uint32_t error;       /* predicted, see above */
    uint32_t pixels;      /* shaded; samples, where there are 4 in a pixel */
    uint32_t rates;       /* enum raster_rate summed over its pixels */
    uint8_t coarsest;     /* enum raster_rate */
    uint8_t lights, taps; /* as in struct raster_quality */
    bool coarse;          /* drawn at the coarsest levels of detail */
};

/* Below full quality. */
static inline bool budget_reduced(const struct budget_report *t)
{
    return t->coarsest || t->coarse || t->lights != RASTER_ALL_LIGHTS || t->taps != RASTER_TAPS_8;
}

/* One class of a survey: what every rate of shading is expected to take, and to err. */
struct budget_class {
    uint32_t ticks[RASTER_RATE_COUNT];
    uint32_t error[RASTER_RATE_COUNT];
    uint32_t samples[RASTER_RATE_COUNT]; /* whose ticks depend on the taps */
    uint32_t saved[RASTER_TAPS_COUNT];   /* of each, 4 fraction bits, beside all taps */
    uint8_t rate;                        /* the choice */
};

/* What a sample takes at most, 4 fraction bits: where planes hold, where they do not, in rows. */
struct budget_units {
    uint32_t planes[RASTER_CLASSES], exact[RASTER_CLASSES], row[RASTER_CLASSES], row_run[RASTER_CLASSES];
    uint8_t lights; /* under so many */
};

/* Of what is drawn of a tile. */
struct budget_plan {
    const struct raster *r;
    const struct raster_survey *survey;
    bool last;                  /* every meshlet is drawn */
    uint32_t count, pixels;     /* classes that show; their pixels */
    uint8_t id[RASTER_CLASSES]; /* which; what follows goes by the index into this */
    struct budget_class classes[RASTER_CLASSES];
    uint64_t materials[RASTER_CLASSES]; /* bit for each */
    /* In which they show, by raster_region_planes: where a material of theirs shows in none of the classes before; and others. */
    uint8_t first[RASTER_CLASSES][RASTER_REGION_SHIFT + 1], shared[RASTER_CLASSES][RASTER_REGION_SHIFT + 1];
    uint32_t exact[RASTER_CLASSES]; /* pixels in regions without planes */
    uint32_t rows;                  /* bit for each class: it is shaded in rows at rate 1x1 */
    uint8_t region_planes[RASTER_MAX_REGIONS];
    uint32_t pass[RASTER_REGION_SHIFT + 1]
                 [RASTER_RATE_FLAT];  /* for a material at a rate, by region_planes; 4 fraction bits */
    struct budget_units units, least; /* with the plan's lights and taps; with the fewest lights and all taps */
    /* The last rung from a region on, at most: all but the meshlets' evaluations, and how many these may be. */
    uint32_t flat_ticks[RASTER_MAX_REGIONS + 1], flat_cells[RASTER_MAX_REGIONS + 1];
    uint32_t flat_each;   /* an evaluation's ticks */
    uint32_t flat_planes; /* of a region and material, 4 fraction bits */
    struct raster_quality quality;
};

/* Prices of a tick, each sixteen times the one before, from 2^-8 squared steps on. */
#define BUDGET_PRICES 6u
/* The taps that are worth their ticks at a price. */
static inline enum raster_taps budget_taps_at(uint32_t price)
{
    return price == 0 ? RASTER_TAPS_8 : price == 1 ? RASTER_TAPS_4 : RASTER_TAPS_1;
}

/* A running ratio of a frame's sums, half of the sums before, and so on. */
struct budget_ratio {
    uint64_t over, under;
};

/* A frame's. What was learnt of the frames before remains: begin the first one with all 0. */
struct budget {
    const struct hal *hal; /* its clock, or NULL: ticks are modelled */
    uint32_t mean;         /* ticks per tile */
    uint64_t left;         /* ticks of the tiles to come */
    /* What these need for certain, and are expected to take: shading at full quality, and all else. */
    uint64_t least, demand, besides;
    struct budget_ratio price_ratio[BUDGET_PRICES]; /* shading at a price over shading in full */
    struct budget_ratio shading_ratio;              /* what shading took over what was expected of it */
    struct budget_ratio chosen_ratio;               /* what was expected of it over shading in full */
    uint32_t done;                                  /* tiles begun */
    /* Tiles from the `from`-th on must find so much, but are expected to take less than that, by the most that there is: as above. */
    struct budget_reserve {
        uint32_t from;
        uint64_t ticks, demand, besides;
    } reserve;
    uint32_t lit;                /* to be expected, of 256 */
    uint32_t point;              /* what a point light takes of what it may, to be expected, of 256 */
    struct raster_learnt learnt; /* for the next frame's raster_begin */
    struct budget_plan plan;
};

/* Begins a frame. In: *r as raster_begin filled it, with bounds; mean as there, > 0. */
void budget_begin(struct budget *b, const struct hal *hal, const struct raster *r, uint32_t mean);

/* Renders a tile as raster_render_tile does, within its share. Tiles in any order, each once; raster_tile_at has the best. */
void budget_render_tile(struct budget *b, struct budget_report *report, const struct raster *r, uint32_t index,
                        struct raster_tile *work, struct raster_rect *rect, struct raster_stats *stats);

/* All of it: a program that does not refer to this is linked without budgets. */
struct budget_scheduler {
    const struct raster_bounds *bounds; /* for the frame */
    void (*begin)(struct budget *b, const struct hal *hal, const struct raster *r, uint32_t mean);
    void (*render_tile)(struct budget *b, struct budget_report *report, const struct raster *r, uint32_t index,
                        struct raster_tile *work, struct raster_rect *rect, struct raster_stats *stats);
};
extern const struct budget_scheduler budget_scheduler;

/* --- budget_plan.c, for budget.c --- */

/* What waits in the tile, which was surveyed, and what it takes. `last`: every meshlet is drawn. */
void budget_plan_begin(struct budget_plan *p, const struct budget *b, const struct raster *r,
                       const struct raster_tile *work, const struct raster_rect *rect, bool last);
/* Everything from a region on at the last rung, at most. */
uint32_t budget_least_ticks(const struct budget_plan *p, uint32_t region);
/* Chooses rates and lights that are expected to take at most `ticks` with these taps. Returns the ticks expected. */
uint32_t budget_plan_choose(struct budget_plan *p, const struct budget *b, uint32_t ticks, enum raster_taps taps);
/* The last rung: every class flat. Returns the ticks at most. */
uint32_t budget_plan_flat(struct budget_plan *p);
/* Coarsens a region's rates until it takes at most `ticks`, or what it takes at the last rung. */
void budget_region_fit(struct raster_quality *q, struct budget_plan *p, uint32_t region, uint32_t ticks);
/* What visiting a region's cells takes, modelled. */
uint32_t budget_cells_ticks(const struct budget_plan *p, uint32_t region, const struct raster_quality *q);
/* What of a region's shading is left for the end of the tile, in rows, at most. */
uint32_t budget_rows_ticks(const struct budget_plan *p, uint32_t region, const struct raster_quality *q);
/* --- budget_choose.c --- */

/* What all classes take at BUDGET_PRICES prices, with the taps of each, where each class, on its own, weighs its errors against ticks. */
void budget_ticks_at_prices(uint32_t ticks[BUDGET_PRICES], const struct budget_class *classes, uint32_t count);

/*
 * Chooses a rate for each of `count` <= RASTER_CLASSES classes: all 1x1 where `ticks` allow it, else the least summed error that takes at
 * most `ticks` in all, else the cheapest. The optimum for up to four classes. Returns the summed error. In: errors do not fall from a rate to
 * the next; sums of ticks, and of errors, are below 2^31.
 */
uint32_t budget_choose(struct budget_class *classes, uint32_t count, uint32_t ticks);

#endif
