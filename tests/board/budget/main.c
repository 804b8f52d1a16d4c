/*
 * Frames at budgets on an emulated board, with the board's own clock, which counts instructions exactly. Input: input.h. Lines:
 *   tiles N over N frames N reduced N coarse N late N           over: tiles that took more than their share; late: frames more than theirs
 *   differ N                                                    frames at generous budgets that are not the unlimited one, bit for bit
 *   ratio p50 N p99 N most N                                    spent over predicted of a tile, thousandths
 *   used p50 N own N                                            of reduced frames: spent over budget; deciding over budget; thousandths, millionths
 * and of one scene alone, when still, at parts of what its shading takes at full quality besides all else:
 *   full fixed N shading N least N frame N                      ticks of a frame: all else, shading, and of one made without steps, culling and
 *                                                               binning included; the least budget
 *   half|quarter|given budget N lod N coarse N spent N shading N frame N own N squares N   per tile; per frame: ticks, what of them is beyond `fixed`, those of a frame
 *                                                               with culling and binning, squared errors summed; the picture is left behind the full one
 * or of that scene with all surfaces at one rate, for each, of half-vector tables also with fewer taps:
 *   rate N taps N shading N samples N lit N hash H              ticks; surfaces and pixel-lights evaluated; of the picture
 */
#include "board.h"
#include "budget.h"
#include "input.h"

enum {
    WIDTH = 320,
    HEIGHT = 240,
    TILES = ((WIDTH + RASTER_TILE_WIDTH - 1) / RASTER_TILE_WIDTH) *
            ((HEIGHT + RASTER_TILE_HEIGHT - 1) / RASTER_TILE_HEIGHT),
    ARENA_BYTES = 512 * 1024,
    BUCKETS = 4096, /* of ratios, a thousandth each */
    LEARN = 8       /* frames until a still picture is steady */
};

struct histogram {
    uint32_t count[BUCKETS], sum, most;
};

static uint64_t arena[ARENA_BYTES / 8];
static struct scene scene;
static struct lut_table tables[BUDGET_INPUT_TABLES];
static const struct lut_table *slots[RASTER_MAX_SLOTS];
static struct raster raster;
static struct raster_tile work;
static struct raster_memory memory;
static struct budget budget;
static struct histogram ratios, used;
static uint32_t tiles, over, frames, reduced_frames, coarse, late, differ;
static uint64_t own_ticks, reduced_ticks;
static uint64_t random_state;

static const struct budget_input *input(void)
{
    return (const struct budget_input *)(const void *)board_input;
}

static void checked(bool right, const char *wrong)
{
    if (!right)
        report_failure(wrong);
}

static uint32_t draw(uint32_t below)
{
    random_state = random_state * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)((random_state >> 32) * below >> 32);
}

static void add(struct histogram *h, uint64_t over_this, uint64_t under)
{
    const uint32_t thousandths = (uint32_t)((over_this * 1000 + under - 1) / under); /* rounded up */
    h->count[thousandths < BUCKETS ? thousandths : BUCKETS - 1]++;
    h->sum++;
    h->most = thousandths > h->most ? thousandths : h->most;
}

static uint32_t quantile(const struct histogram *h, uint32_t hundredths)
{
    uint32_t at = 0;
    for (uint32_t below = h->count[0]; at < BUCKETS - 1 && (uint64_t)below * 100 < (uint64_t)h->sum * hundredths;)
        below += h->count[++at];
    return at;
}

/* Squared errors of a tile against the picture at board_picture. */
static uint32_t tile_squares(const struct raster_rect *rect)
{
    uint8_t *kept = board_picture + 3 * WIDTH * HEIGHT;
    uint32_t sum = 0;
    for (uint32_t y = 0; y < rect->height; y++) {
        const uint8_t *full = board_picture + ((rect->y + y) * (uint32_t)WIDTH + rect->x) * 3,
                      *p = raster_tile_pixels(&work) + y * rect->width * 3u;
        for (uint32_t i = 0; i < rect->width * 3u; i++) {
            sum += (uint32_t)((p[i] - full[i]) * (p[i] - full[i]));
            kept[full - board_picture + i] = p[i];
        }
    }
    return sum;
}

static uint32_t clock_read(void *ctx)
{
    (void)ctx;
    return board_clock();
}

/* Of hal.h this part asks for the clock alone. */
static struct hal hal;

static enum raster_status begin(uint32_t mean)
{
    const struct raster_frame frame = {.parts = &raster_all_parts,
                                       .scene = &scene,
                                       .camera = &scene.header->camera,
                                       .output = &scene.header->output,
                                       .lights = scene.lights,
                                       .materials = scene.materials,
                                       .tables = slots,
                                       .width = WIDTH,
                                       .height = HEIGHT,
                                       .light_count = (uint8_t)scene.header->lights.count,
                                       .format = RASTER_RGB888,
                                       .samples = 1,
                                       .costs = &input()->costs,
                                       .bounds = &raster_tile_bounds,
                                       .tile_budget = mean,
                                       .learnt = &budget.learnt,
                                       .memory = mean ? &memory : NULL};
    return raster_begin(&raster, &frame, arena, sizeof arena);
}

struct frame {
    uint64_t spent, own, squares;
    uint32_t hash; /* the sum of tiles, whatever their order */
    bool reduced;
};

/* `compare`: its squares are wanted; `backward`: the tiles that have the most in reserve come first. */
static struct frame render(uint32_t mean, bool compare, bool backward)
{
    struct frame f = {0};
    checked(begin(mean) == RASTER_OK, "no frame");
    if (mean)
        budget_begin(&budget, &hal, &raster, mean);
    for (uint32_t i = 0; i < TILES; i++) {
        const uint32_t t = raster_tile_at(&raster, backward ? TILES - 1 - i : i);
        struct raster_rect rect;
        struct raster_stats stats;
        struct budget_report report;
        if (mean) {
            budget_render_tile(&budget, &report, &raster, t, &work, &rect, &stats);
        } else {
            const uint32_t start = board_clock();
            raster_render_tile(&raster, t, &work, &rect, &stats);
            report.spent = board_clock() - start;
        }
        f.spent += report.spent;
        if (compare) {
            f.squares += tile_squares(&rect);
            f.hash += report_hash(REPORT_HASH_START ^ t, raster_tile_pixels(&work), 3u * rect.width * rect.height);
        }
        if (!mean)
            continue;
        f.own += report.own;
        tiles++;
        over += report.spent > report.share;
        coarse += report.coarse;
        f.reduced |= budget_reduced(&report);
        add(&ratios, report.spent, report.predicted);
    }
    if (!mean)
        return f;
    frames++;
    late += f.spent > (uint64_t)mean * TILES;
    if (f.reduced) {
        reduced_frames++;
        add(&used, f.spent, (uint64_t)mean * TILES);
        own_ticks += f.own;
        reduced_ticks += (uint64_t)mean * TILES;
    }
    return f;
}

static void open_scene(uint32_t index)
{
    const struct budget_input *in = input();
    checked(scene_open_bounded(&scene, board_input + in->scenes[index].at, in->scenes[index].bytes) == SCENE_OK,
            "no scene");
    memory = (struct raster_memory){.contrast = {0}};
    budget = (struct budget){.hal = &hal};
}

/* Of every scene a frame without limit, then budgets from the least to a tenth beyond what it took, and a generous one. */
static void walk(void)
{
    for (uint32_t s = 0; s < input()->scene_count; s++) {
        open_scene(s);
        const struct frame full = render(0, s % 8 == 0, false);
        const uint32_t least = raster.budget_needed, mean = (uint32_t)(full.spent / TILES) + 1;
        const uint32_t most = (mean > least ? mean : least) / 10 * 11;
        for (uint32_t i = 0; i < input()->frames; i++)
            render(i ? least + draw(most - least + 1) : least, false, i % 4 == 3);
        if (s % 8 == 0) {
            const struct frame generous = render(1u << 28, true, false);
            differ += generous.reduced || generous.hash != full.hash;
        }
    }
    report_text("tiles");
    report_number("", tiles);
    report_number("over", over);
    report_number("frames", frames);
    report_number("reduced", reduced_frames);
    report_number("coarse", coarse);
    report_number("late", late);
    report_text("\ndiffer");
    report_number("", differ);
    report_text("\nratio");
    report_number("p50", quantile(&ratios, 50));
    report_number("p99", quantile(&ratios, 99));
    report_number("most", ratios.most);
    report_text("\nused");
    report_number("p50", reduced_frames ? quantile(&used, 50) : 0);
    report_number("own", reduced_ticks ? (uint32_t)(own_ticks * 1000000 / reduced_ticks) : 0);
    report_text("\n");
}

struct steps {
    uint32_t rest, shade, finish, samples, lit; /* ticks; counts */
};

/* A frame with all surfaces at a rate, step by step, into board_picture. */
static struct steps render_steps(enum raster_rate rate, enum raster_taps taps)
{
    struct raster_quality q = {.lights = RASTER_ALL_LIGHTS, .taps = (uint8_t)taps};
    struct steps s = {0};
    const uint32_t start = board_clock();
    for (uint32_t i = 0; i < RASTER_CLASSES; i++)
        q.rate[i] = (uint8_t)rate;
    for (uint32_t t = 0; t < TILES; t++) {
        struct raster_rect rect;
        struct raster_stats stats;
        raster_tile_begin(&raster, t, &work, &rect, &stats);
        for (bool more = true; more;) {
            more = raster_tile_draw(&raster, &work, UINT32_MAX, &stats) == RASTER_NO_SLOT;
            const struct raster_survey *survey = raster_tile_survey(&raster, &work, &rect);
            const uint32_t surveyed = board_clock();
            for (uint32_t region = 0; region < survey->regions; region++)
                raster_tile_shade(&raster, &work, &rect, region, &q, &stats);
            s.shade += board_clock() - surveyed;
            if (more)
                raster_tile_free_slots(&raster, &work, &rect, &stats);
        }
        const uint32_t shaded = board_clock();
        raster_tile_finish(&raster, &work, &rect, &stats);
        s.finish += board_clock() - shaded;
        s.samples += stats.samples;
        s.lit += stats.shaded;
        report_tile(rect.x, rect.y, rect.width, rect.height, raster_tile_pixels(&work), WIDTH, 3);
    }
    s.rest = board_clock() - start - s.shade - s.finish;
    return s;
}

/* What is shaded in rows is shaded when a tile is finished; at rate flat nothing is. */
static void rates(void)
{
    open_scene(0);
    checked(begin(0) == RASTER_OK, "no frame");
    const uint32_t packing = render_steps(RASTER_RATE_FLAT, RASTER_TAPS_8).finish;
    const bool table = slots[0] && slots[0]->kind == LUT_HALF_VECTOR;
    for (uint32_t rung = 0; rung < (table ? RASTER_TAPS_COUNT : 1u) * RASTER_RATE_COUNT; rung++) {
        const uint32_t rate = rung % RASTER_RATE_COUNT, taps = rung / RASTER_RATE_COUNT;
        const struct steps s = render_steps((enum raster_rate)rate, (enum raster_taps)taps);
        report_text("rate");
        report_number("", rate);
        report_number("taps", taps);
        report_number("shading", s.shade + s.finish - packing);
        report_number("samples", s.samples);
        report_number("lit", s.lit);
        report_hex("hash", report_hash(REPORT_HASH_START, board_picture, 3 * WIDTH * HEIGHT));
        report_text("\n");
    }
}

/* Of a frame with culling and binning. */
static uint32_t frame_ticks(uint32_t mean)
{
    const uint32_t start = board_clock();
    render(mean, false, false);
    return board_clock() - start;
}

static void report_part(const char *name, uint32_t mean, uint32_t fixed)
{
    for (uint32_t i = 0; i < LEARN - 2; i++)
        render(mean, false, false);
    const uint32_t ticks = frame_ticks(mean);
    coarse = 0;
    const struct frame f = render(mean, true, false);
    report_text(name);
    report_number("budget", mean);
    report_number("lod", raster.lod_bias);
    report_number("coarse", coarse);
    report_number("spent", (uint32_t)f.spent);
    report_number("shading", f.spent > fixed ? (uint32_t)f.spent - fixed : 0);
    report_number("frame", ticks);
    report_number("own", (uint32_t)f.own);
    report_number("squares", (uint32_t)f.squares);
    report_text("\n");
}

static void picture(void)
{
    open_scene(0);
    const uint32_t ticks = frame_ticks(0);
    checked(begin(0) == RASTER_OK, "no frame");
    const struct steps s = render_steps(RASTER_RATE_1X1, RASTER_TAPS_8);
    const uint32_t fixed = s.rest + s.finish, given = input()->frames;
    report_text("full");
    report_number("fixed", fixed);
    report_number("shading", s.shade);
    report_number("least", raster.budget_needed);
    report_number("frame", ticks);
    report_text("\n");
    if (given) {
        report_part("given", given, fixed);
        return;
    }
    report_part("half", (fixed + s.shade / 2) / TILES, fixed);
    report_part("quarter", (fixed + s.shade / 4) / TILES, fixed);
}

static void open_tables(void)
{
    for (uint32_t i = 0; i < BUDGET_INPUT_TABLES && input()->tables[i].bytes; i++) {
        checked(lut_open(&tables[i], board_input + input()->tables[i].at, input()->tables[i].bytes) == LUT_OK,
                "no table");
        slots[i] = &tables[i];
    }
}

_Noreturn void board_main(void)
{
    hal.clock = clock_read;
    random_state = input()->seed;
    open_tables();
    if (input()->mode == BUDGET_INPUT_TILES)
        walk();
    else if (input()->mode == BUDGET_INPUT_PICTURE)
        picture();
    else
        rates();
    board_exit(BOARD_EXIT_OK);
}
