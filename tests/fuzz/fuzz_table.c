/* A table file: the KTX2 view, opening, and evaluation in many directions of what opens. */
#include "fuzz.h"
#include "lut.h"

enum { DIRECTIONS = 13 };

/* Of length 1 within rounding, but the last: the largest components that lut_eval accepts. */
static const struct vec3 directions[DIRECTIONS] = {
    {0, 0, 32768},          {32768, 0, 0},       {0, -32768, 0},        {32767, 0, 256},       {-32767, 0, 256},
    {23170, 0, 23170},      {-23170, 0, 23170},  {0, 23170, 23170},     {18919, 18919, 18919}, {-18919, 18919, 18919},
    {18919, -18919, 18919}, {-23170, -23170, 1}, {32832, 32832, 32832},
};

static void evaluate(const struct lut_table *t)
{
    for (int n = 0; n < DIRECTIONS; n += 6)
        for (int l = 0; l < DIRECTIONS; l++)
            for (int v = 0; v <= l; v++) {
                struct lut_rgb a, b;
                unsigned fetched = lut_eval(&a, t, directions[n], directions[l], directions[v]);
                CLAIM(fetched == 0 || fetched == 8);
                CLAIM((a.c[0] | a.c[1] | a.c[2]) < 1u << 21);
                lut_eval(&b, t, directions[n], directions[v], directions[l]);
                if (t->kind == LUT_HALF_VECTOR)
                    CLAIM(!memcmp(&a, &b, sizeof a));
            }
}

/* Every key that a reader asks for lies in the file. */
static void look_up(const struct ktx2_view *view)
{
    static const char *const keys[] = {"goniotile.kind", "goniotile.source", "KTXwriter", ""};
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++) {
        uint32_t bytes = 0;
        const uint8_t *value = ktx2_find(view, keys[i], &bytes);
        CLAIM(!value || (value >= view->kvd && bytes <= (size_t)(view->kvd + view->kvd_bytes - value)));
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t bytes)
{
    struct ktx2_view view;
    struct lut_table table;
    void *file = exact_copy(data, bytes);
    enum lut_status seen = ktx2_open(&view, file, bytes), opened = lut_open(&table, file, bytes);
    CLAIM(seen == LUT_OK || opened == seen);
    if (seen == LUT_OK)
        look_up(&view);
    if (opened == LUT_OK)
        evaluate(&table);
    free(file);
    return 0;
}
