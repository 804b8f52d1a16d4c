/* Opening a table: what the metadata says becomes a descriptor ready for evaluation. */
#include "kinds.h"

static bool value_equals(const uint8_t *value, uint32_t bytes, const char *text)
{
    uint32_t i = 0;
    while (i < bytes && text[i] != 0 && value[i] == (uint8_t)text[i]) {
        i++;
    }
    return i == bytes && text[i] == 0;
}

/* A decimal number of 1 to 9 digits. False for anything else. */
static bool parse_number(uint32_t *out, const uint8_t *value, uint32_t bytes)
{
    uint32_t x = 0;
    if (bytes == 0 || bytes > 9) {
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

static bool find_number(uint32_t *out, const struct ktx2_view *v, const char *key)
{
    uint32_t bytes;
    const uint8_t *value = ktx2_find(v, key, &bytes);
    return value != NULL && parse_number(out, value, bytes);
}

static enum lut_status open_specular_frame(struct lut_table *out, const struct ktx2_view *view)
{
    uint32_t theta_max, swap = 0, length;
    if (!find_number(&theta_max, view, "goniotile.theta_max") || theta_max < 1 || theta_max > 90000 ||
        view->width < 2 || view->height < 2) {
        return LUT_ERR_AXES;
    }
    if (ktx2_find(view, "goniotile.swap", &length) && (!find_number(&swap, view, "goniotile.swap") || swap > 1)) {
        return LUT_ERR_AXES;
    }
    /* slice_scale = (depth-1) 2^12 2^32 / (theta_max 2^28 / 180000) = (depth-1) 360000 2^15 / theta_max, in two steps:
     * the dividend is at most 4095 * 360000 < 2^31, the remainder < 90000 < 2^17. */
    uint32_t dividend = (view->depth - 1) * 360000;
    uint32_t quotient = dividend / theta_max, remainder = dividend % theta_max;
    if (quotient >= 1u << 17) {
        return LUT_ERR_AXES;
    }
    out->swap = swap;
    out->slice_scale = (quotient << 15) + (remainder << 15) / theta_max;
    return LUT_OK;
}

/* The value of a key that must have `bytes` bytes and be 4-aligned, or NULL. */
static const void *find_array(const struct ktx2_view *v, const char *key, uint32_t bytes)
{
    uint32_t length;
    const uint8_t *value = ktx2_find_bytes(v, key, &length);
    return value != NULL && length == bytes && ((uintptr_t)value & 3) == 0 ? value : NULL;
}

/* From the first to the last node without a step back; the last step rises, so that all before the end is in a cell. */
static bool warp_valid(const uint16_t *w, uint32_t count, uint32_t nodes)
{
    if (w == NULL || w[0] != 0 || w[count - 1] != (nodes - 1) << LUT_WARP_BITS || w[count - 2] == w[count - 1]) {
        return false;
    }
    for (uint32_t i = 1; i < count; i++) {
        if (w[i] < w[i - 1]) {
            return false;
        }
    }
    return true;
}

/* Every record has its cell's exponent, and its two rows lie behind the records and inside the value. In: bytes < 2^24, a multiple of 4. */
static bool slabs_valid(const uint32_t *slabs, const uint8_t *exponents, uint32_t bytes, uint32_t cells,
                        uint32_t row_bytes)
{
    if (bytes < 4 * cells || bytes - 4 * cells < 2 * row_bytes) {
        return false;
    }
    for (uint32_t i = 0; i < cells; i++) {
        uint32_t offset = slabs[i] >> 8;
        if ((slabs[i] & 255) != exponents[i] || offset % 4 != 0 || offset < 4 * cells ||
            offset > bytes - 2 * row_bytes) {
            return false;
        }
    }
    return true;
}

static enum lut_status open_half_vector(struct lut_table *out, const struct ktx2_view *view)
{
    const uint32_t width = view->width, height = view->height, depth = view->depth;
    uint32_t length, scale = 0;
    if (width < 2 || width > LUT_MAX_T || height < 2 || height > LUT_MAX_H || depth < 2 || depth > LUT_MAX_D ||
        width * height * depth > 1u << 16) {
        return LUT_ERR_AXES;
    }
    out->warp_h = find_array(view, "goniotile.warph", 2 * LUT_WARP_H_NODES);
    out->warp_d = find_array(view, "goniotile.warpd", 2 * LUT_WARP_D_NODES);
    if (!warp_valid(out->warp_h, LUT_WARP_H_NODES, height) || !warp_valid(out->warp_d, LUT_WARP_D_NODES, depth)) {
        return LUT_ERR_WARP;
    }
    const uint8_t *text = ktx2_find(view, "goniotile.scale", &length);
    bool negative = text != NULL && length > 0 && text[0] == '-';
    if (text != NULL && (!parse_number(&scale, text + negative, length - negative) || scale > 16)) {
        return LUT_ERR_EXPONENT;
    }
    out->scale = negative ? -(int32_t)scale : (int32_t)scale;
    const uint32_t cells = (height - 1) * (depth - 1);
    out->cells = find_array(view, "goniotile.cells", cells);
    if (out->cells == NULL) {
        return LUT_ERR_EXPONENT;
    }
    out->brightest = 0;
    for (uint32_t i = 0; i < cells; i++) {
        out->brightest = out->cells[i] > out->brightest ? out->cells[i] : out->brightest;
    }
    if (out->brightest > 31) {
        return LUT_ERR_EXPONENT;
    }
    out->slabs = NULL;
    if (ktx2_find_bytes(view, "goniotile.slabs", &length)) {
        out->slabs = find_array(view, "goniotile.slabs", length);
        if (out->slabs == NULL || length >> 24 || length % 4 ||
            !slabs_valid(out->slabs, out->cells, length, cells, 12 * width)) {
            return LUT_ERR_SLABS;
        }
    }
    return LUT_OK;
}

enum lut_status lut_open(struct lut_table *out, const void *file, size_t bytes)
{
    struct ktx2_view view;
    uint32_t version, length;
    enum lut_status s = ktx2_open(&view, file, bytes);
    if (s != LUT_OK) {
        return s;
    }
    if (!find_number(&version, &view, "goniotile.version") || version != 1) {
        return LUT_ERR_VERSION;
    }
    struct lut_table t = {.texels = view.texels, .width = view.width, .height = view.height, .depth = view.depth};
    const uint8_t *kind = ktx2_find(&view, "goniotile.kind", &length);
    if (kind != NULL && value_equals(kind, length, "specular_frame")) {
        t.kind = LUT_SPECULAR_FRAME;
        s = open_specular_frame(&t, &view);
    } else if (kind != NULL && value_equals(kind, length, "half_vector")) {
        t.kind = LUT_HALF_VECTOR;
        s = open_half_vector(&t, &view);
    } else {
        return LUT_ERR_KIND;
    }
    if (s == LUT_OK) {
        *out = t;
    }
    return s;
}

unsigned lut_eval(struct lut_rgb *out, const struct lut_table *t, struct vec3 n, struct vec3 l, struct vec3 v)
{
    if (dot_wrapping(n, l) <= 0 || dot_wrapping(n, v) <= 0) {
        *out = (struct lut_rgb){{0, 0, 0}, 0};
        return 0;
    }
    *out = t->kind == LUT_HALF_VECTOR ? lut_half_vector(t, n, l, v) : lut_specular_frame(t, n, l, v);
    return 8;
}
