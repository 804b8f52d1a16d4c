/* Opening: a file of up to a kilobyte of unknown bytes. */
#include "lut.h"
#include "prove.h"

static uint32_t file[1024 / 4];

int main(void)
{
    struct lut_table t;
    Frama_C_make_unknown((char *)file, sizeof file);
    return (int)lut_open(&t, file, Frama_C_unsigned_int_interval(0, sizeof file));
}
