/*
 * What a drawn tile has to be shaded: counted by cells of 4 x 4 pixels, and sorted into classes by what the last frame saw.
 */
#include "internal.h"
#include "quality.h"

#define UNKNOWN_CONTRAST 7
#define CELL_WORDS       16 /* with 4 samples per pixel */

/* Removes a slot from words of four slots each; returns how many samples had it. */
static uint32_t take_slot(uint32_t *word, uint32_t words, uint32_t slot)
{
    uint32_t others = 0;
    for (uint32_t i = 0; i < words; i++) {
        const uint32_t differs = raster_slots_differ(word[i], slot);
        others += differs >> 7;
        word[i] = raster_keep_slots(word[i], differs);
    }
    return 4 * words - (others * EACH_SLOT >> 24); /* <= 64 */
}

static inline void add_cell(struct raster_tile *t, uint32_t region, uint32_t slot, uint32_t samples)
{
    struct raster_area *area = &t->m.shading.survey.area[t->slots[slot].class_id][region];
    area->pixels += (uint16_t)samples;
    area->cells++;
    t->m.shading.pixels[slot] += (uint16_t)samples;
}

/* Those of a cell, in words of four. */
static void count_slots(struct raster_tile *t, uint32_t *word, uint32_t words, uint32_t region)
{
    for (uint32_t i = 0; i < words; i++)
        while (word[i]) {
            const uint32_t slot = raster_first_slot(word[i]);
            add_cell(t, region, slot, take_slot(word + i, words - i, slot));
        }
}

/* A cell of width x height samples that is cut or larger than four by four. */
static void count_cell(struct raster_tile *t, const struct raster_surface *s, uint32_t width, uint32_t height,
                       uint32_t region)
{
    uint32_t word[CELL_WORDS], words = 0;
    for (uint32_t y = 0; y < height; y++, s += RASTER_TILE_WIDTH)
        for (uint32_t x = 0; x < width; x += 4)
            word[words++] = raster_four_slots(s + x) & (width - x < 4 ? ~(UINT32_MAX >> 8 * (width - x)) : UINT32_MAX);
    t->m.shading.survey.edges++;
    count_slots(t, word, words, region);
}

/* One of four by four. */
static void count_whole_cell(struct raster_tile *t, const struct raster_surface *s, uint32_t region)
{
    uint32_t word[4] = {raster_four_slots(s), raster_four_slots(s + RASTER_TILE_WIDTH),
                        raster_four_slots(s + 2 * RASTER_TILE_WIDTH), raster_four_slots(s + 3 * RASTER_TILE_WIDTH)};
    const uint32_t first = word[0];
    if ((first ^ (first << 8 | first >> 24)) | (first ^ word[1]) | (first ^ word[2]) | (first ^ word[3])) {
        const uint32_t full = raster_slots_differ(first, 0) & raster_slots_differ(word[1], 0) &
                              raster_slots_differ(word[2], 0) & raster_slots_differ(word[3], 0);
        t->m.shading.survey.edges += full != 128 * EACH_SLOT;
        count_slots(t, word, 4, region);
    } else if (first)
        add_cell(t, region, first & 255, 16);
}

static void count_cells(const struct raster *r, struct raster_tile *t, const struct raster_rect *rect)
{
    const uint32_t edge = 4u << r->sample_shift, columns = RASTER_REGIONS(rect->width);
    const uint32_t right = (uint32_t)rect->width << r->sample_shift, below = (uint32_t)rect->height << r->sample_shift;
    const unsigned region_shift = RASTER_REGION_SHIFT + r->sample_shift;
    for (uint32_t y = 0; y < below; y += edge)
        for (uint32_t x = 0; x < right; x += edge) {
            const struct raster_surface *s = &t->surface[y * RASTER_TILE_WIDTH + x];
            const uint32_t region = (y >> region_shift) * columns + (x >> region_shift);
            const uint32_t width = right - x < edge ? right - x : edge, height = below - y < edge ? below - y : edge;
            if (width == 4 && height == 4)
                count_whole_cell(t, s, region);
            else
                count_cell(t, s, width, height, region);
        }
}

/* Sorts slots into classes: each way of shading gets as many, which share its range of contrast. */
static void find_classes(const struct raster *r, struct raster_tile *t)
{
    struct raster_survey *s = &t->m.shading.survey;
    uint8_t low[RASTER_SHADE_COUNT], high[RASTER_SHADE_COUNT], first[RASTER_SHADE_COUNT];
    uint32_t kinds = 0, each;
    _Static_assert(RASTER_SHADE_COUNT <= RASTER_CLASSES, "a class for every kind");
    __builtin_memset(low, 255, sizeof low);
    __builtin_memset(high, 0, sizeof high);
    for (uint32_t i = 1; i <= t->slot_count; i++) {
        struct raster_slot *slot = &t->slots[i];
        const uint8_t known = t->memory ? t->memory->contrast[slot->memory] : 0;
        const enum raster_shading k = raster_shading_of(r, slot->material, RASTER_RATE_1X1);
        slot->contrast = known ? known - 1 : UNKNOWN_CONTRAST;
        slot->class_id = (uint8_t)k; /* until it is known */
        if (low[k] == 255)
            first[k] = (uint8_t)kinds++;
        low[k] = slot->contrast < low[k] ? slot->contrast : low[k];
        high[k] = slot->contrast > high[k] ? slot->contrast : high[k];
    }
    each = kinds ? RASTER_CLASSES / kinds : 0;
    s->classes = kinds * each;
    for (uint32_t i = 1; i <= t->slot_count; i++) {
        struct raster_slot *slot = &t->slots[i];
        const uint32_t k = slot->class_id;
        slot->class_id = (uint8_t)(first[k] * each + (slot->contrast - low[k]) * each / (high[k] - low[k] + 1u));
        s->material[slot->class_id] = slot->material;
    }
}

static void sum_classes(struct raster_tile *t)
{
    struct raster_survey *s = &t->m.shading.survey;
    for (uint32_t c = 0; c < s->classes; c++) {
        struct raster_area *sum = &s->total[c];
        *sum = (struct raster_area){0, 0};
        s->detail[c] = 0;
        s->meshlets[c] = 0;
        for (uint32_t i = 0; i < s->regions; i++) {
            sum->pixels += s->area[c][i].pixels;
            sum->cells += s->area[c][i].cells;
        }
    }
    for (uint32_t i = 1; i <= t->slot_count; i++) {
        const uint32_t c = t->slots[i].class_id, pixels = t->m.shading.pixels[i];
        s->detail[c] += pixels << t->slots[i].contrast; /* <= 2^(12+16) */
        s->meshlets[c] = (uint8_t)(s->meshlets[c] + (pixels != 0));
    }
}

const struct raster_survey *raster_tile_survey(const struct raster *r, struct raster_tile *t,
                                               const struct raster_rect *rect)
{
    struct raster_survey *s = &t->m.shading.survey;
    bool any = false;
    s->regions = RASTER_REGIONS(rect->width) * RASTER_REGIONS(rect->height);
    s->slots = t->slot_count;
    s->edges = 0;
    t->memory = r->frame.parts->cells ? r->frame.memory : NULL;
    find_classes(r, t);
    __builtin_memset(s->area, 0, s->classes * sizeof s->area[0]);
    __builtin_memset(t->m.shading.flat, 0, sizeof t->m.shading.flat);
    __builtin_memset(t->m.shading.pixels, 0, sizeof t->m.shading.pixels);
    __builtin_memset(t->m.shading.low, 255, sizeof t->m.shading.low);
    __builtin_memset(t->m.shading.high, 0, sizeof t->m.shading.high);
    count_cells(r, t, rect);
    sum_classes(t);
    for (uint32_t c = 0; c < s->classes; c++)
        any |= s->total[c].pixels != 0;
    t->light_count = 0;
    if (any)
        raster_find_lights(r, t, rect);
    s->point_lights = any ? t->light_count - r->directional : 0;
    return s;
}

void raster_remember(struct raster_tile *t)
{
    struct raster_memory *memory = t->memory;
    t->memory = NULL;
    for (uint32_t i = 1; i <= t->slot_count; i++) {
        const uint32_t low = t->m.shading.low[i], high = t->m.shading.high[i], pixels = t->m.shading.pixels[i];
        uint8_t *known = &memory->contrast[t->slots[i].memory];
        if (low > high)
            continue;
        const uint32_t now = 32 - fx_clz(1 + (high - low) * (high - low) / pixels); /* one plus the contrast */
        if (now > *known)
            *known = (uint8_t)now;
        else if (now + 3 < *known) /* less: coarse shading shows less of it */
            *known -= 1;
    }
}
