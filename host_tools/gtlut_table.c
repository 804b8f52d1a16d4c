#include "gtlut_table.h"

#include <stdlib.h>
#include <string.h>

#include "common.h"

bool table_recognise(const void *data, size_t bytes)
{
    return bytes >= 6 && !memcmp(data, "\xabKTX 2", 6);
}

void table_open(struct table_file *out, const char *path, void *data, size_t bytes)
{
    out->data = data;
    out->bytes = bytes;
    enum lut_status status = ktx2_open(&out->view, data, bytes);
    if (status == LUT_OK)
        status = lut_open(&out->table, data, bytes);
    if (status != LUT_OK)
        die(EXIT_BAD_INPUT, "%s: %s; build the table again", path, lut_status_text(status));
    uint32_t value_bytes;
    const uint8_t *text = ktx2_find(&out->view, "goniotile.theta_max", &value_bytes);
    long thousandths = 0; /* digits only: lut_open has checked */
    for (uint32_t i = 0; i < value_bytes; i++)
        thousandths = 10 * thousandths + (text[i] - '0');
    out->theta_max = 1e-3 * (double)thousandths;
}

void table_close(struct table_file *t)
{
    free(t->data);
}

double table_theta_in(const struct table_file *t, uint32_t z)
{
    return t->table.depth > 1 ? t->theta_max * z / (t->table.depth - 1) : 0;
}
