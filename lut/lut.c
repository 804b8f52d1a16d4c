/* Opening a table: what the metadata says becomes a descriptor ready for evaluation. */
#include "lut.h"

static bool value_equals(const uint8_t *value, uint32_t bytes, const char *text)
{
    uint32_t i = 0;
    while (i < bytes && text[i] != 0 && value[i] == (uint8_t)text[i]) {
        i++;
    }
    return i == bytes && text[i] == 0;
}

/* A decimal number of 1 to 9 digits. False when the key is missing or its value is anything else. */
static bool find_number(uint32_t *out, const struct ktx2_view *v, const char *key)
{
    uint32_t bytes, x = 0;
    const uint8_t *value = ktx2_find(v, key, &bytes);
    if (value == NULL || bytes == 0 || bytes > 9) {
        return false;
    }
    for (uint32_t i = 0; i < bytes; i++) {
        if (value[i] < '0' || value[i] > '9') {
            return false;
        }
        x = 10 * x + (value[i] - (uint32_t)'0'); /* < 10^9 */
    }
    *out = x;
    return true;
}

enum lut_status lut_open(struct lut_table *out, const void *file, size_t bytes)
{
    struct ktx2_view view;
    uint32_t version, length, theta_max;
    enum lut_status s = ktx2_open(&view, file, bytes);
    if (s != LUT_OK) {
        return s;
    }
    if (!find_number(&version, &view, "goniotile.version") || version != 1) {
        return LUT_ERR_VERSION;
    }
    const uint8_t *kind = ktx2_find(&view, "goniotile.kind", &length);
    if (kind == NULL || !value_equals(kind, length, "specular_frame")) {
        return LUT_ERR_KIND;
    }
    if (!find_number(&theta_max, &view, "goniotile.theta_max") || theta_max < 1 || theta_max > 90000 ||
        view.width < 2 || view.height < 2) {
        return LUT_ERR_AXES;
    }
    /* slice_scale = (depth-1) 2^12 2^32 / (theta_max 2^28 / 180000) = (depth-1) 360000 2^15 / theta_max, in two steps:
     * the dividend is at most 4095 * 360000 < 2^31, the remainder < 90000 < 2^17. */
    uint32_t dividend = (view.depth - 1) * 360000;
    uint32_t quotient = dividend / theta_max, remainder = dividend % theta_max;
    if (quotient >= 1u << 17) {
        return LUT_ERR_AXES;
    }
    out->kind = LUT_SPECULAR_FRAME;
    out->texels = view.texels;
    out->width = view.width;
    out->height = view.height;
    out->depth = view.depth;
    out->slice_scale = (quotient << 15) + (remainder << 15) / theta_max;
    return LUT_OK;
}
