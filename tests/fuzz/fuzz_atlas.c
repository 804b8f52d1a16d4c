/* An atlas file: what opens gives its tables, as many as it says, each of which opens. */
#include "fuzz.h"

#include "host_atlas.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t bytes)
{
    struct atlas a;
    void *file = exact_copy(data, bytes);
    char *problem = atlas_read(&a, file, bytes);
    CLAIM(problem || a.tables);
    for (uint32_t i = 0; !problem && i < a.tables; i++) {
        struct lut_table t;
        size_t length;
        uint8_t *table = atlas_table(&length, &a, i);
        CLAIM(lut_open(&t, table, length) == LUT_OK && t.width == a.width && t.height == a.height &&
              t.depth == a.depth);
        free(table);
    }
    free(problem);
    free(file);
    return 0;
}
