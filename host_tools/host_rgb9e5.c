#include "host_rgb9e5.h"

#include <math.h>

static uint32_t mantissa(double c, int e)
{
    double x = ldexp(c, 24 - e), whole = floor(x);
    /* floor(x + 0.5) would round the sum: 0.49999999999999994 + 0.5 is 1. The difference below is exact. */
    return (uint32_t)whole + (x - whole >= 0.5);
}

uint32_t rgb9e5_encode(const double rgb[3])
{
    double c[3], max = 0;
    for (int i = 0; i < 3; i++) {
        c[i] = rgb[i] > 0 ? fmin(rgb[i], RGB9E5_MAX) : 0; /* NaN compares false */
        max = fmax(max, c[i]);
    }
    int e;
    frexp(max, &e); /* max in [2^(e-1), 2^e) */
    e = max > 0 && e > -15 ? e + 15 : 0;
    if (mantissa(max, e) == 512)
        e++; /* at most 31: RGB9E5_MAX itself has mantissa 511 there */
    return mantissa(c[0], e) | mantissa(c[1], e) << 9 | mantissa(c[2], e) << 18 | (uint32_t)e << 27;
}
