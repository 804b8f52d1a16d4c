#include "gtsim_tiles.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "common.h"

struct pool {
    const struct raster *raster;
    const uint32_t *order;
    uint8_t *pixels;
    atomic_uint next; /* index into order */
};

struct worker {
    pthread_t thread;
    struct pool *pool;
    struct raster_stats sum;
};

void tiles_order(uint32_t *order, uint32_t count, bool shuffled, uint32_t seed)
{
    uint64_t state = seed;
    for (uint32_t i = 0; i < count; i++) { /* inside out: entry i is swapped with one before it or itself */
        state = state * 6364136223846793005u + 1442695040888963407u;
        uint32_t j = shuffled ? (uint32_t)((state >> 32) * (i + 1) >> 32) : i;
        order[i] = order[j];
        order[j] = i;
    }
}

/* Tiles do not overlap: each thread writes pixels of its own. */
static void tile_place(uint8_t *pixels, const struct raster *r, const struct raster_rect *rect, const uint8_t *tile)
{
    size_t size = r->frame.format == RASTER_RGB565 ? 2 : 3, row = rect->width * size;
    for (size_t y = 0; y < rect->height; y++)
        memcpy(pixels + ((rect->y + y) * r->frame.width + rect->x) * size, tile + y * row, row);
}

static void stats_add(struct raster_stats *sum, const struct raster_stats *s)
{
    sum->meshlets += s->meshlets;
    sum->triangles += s->triangles;
    sum->tested += s->tested;
    sum->covered += s->covered;
    sum->shaded += s->shaded;
    sum->fetches += s->fetches;
}

static void *worker_run(void *argument)
{
    struct worker *w = argument;
    struct pool *p = w->pool;
    struct raster_tile *work = xmalloc(sizeof *work);
    uint32_t count = raster_tile_count(p->raster), i;
    while ((i = atomic_fetch_add(&p->next, 1)) < count) {
        struct raster_rect rect;
        struct raster_stats s;
        raster_render_tile(p->raster, p->order[i], work, &rect, &s);
        tile_place(p->pixels, p->raster, &rect, raster_tile_pixels(work));
        stats_add(&w->sum, &s);
    }
    free(work);
    return NULL;
}

void tiles_render(uint8_t *pixels, struct raster_stats *sum, const struct raster *r, const uint32_t *order,
                  unsigned threads)
{
    struct pool pool = {.raster = r, .order = order, .pixels = pixels};
    struct worker *workers = xcalloc(threads, sizeof *workers);
    for (unsigned i = 0; i < threads; i++) {
        workers[i].pool = &pool;
        if (pthread_create(&workers[i].thread, NULL, worker_run, &workers[i]))
            die(EXIT_INTERNAL, "thread %u of %u cannot be started; give fewer --threads", i + 1, threads);
    }
    *sum = (struct raster_stats){0};
    for (unsigned i = 0; i < threads; i++) {
        pthread_join(workers[i].thread, NULL);
        stats_add(sum, &workers[i].sum);
    }
    free(workers);
}
