/*
 * What frames are made from: the live scene and tables of the store, and what the host has set over the scene's own
 * values. Everything here is called between two frames only.
 */
#ifndef FIRMWARE_CONTENT_H
#define FIRMWARE_CONTENT_H

#include "app.h"

/* Takes over what is live in a slot: opens the table, or the scene (which forgets select and set). */
void content_load(struct app *app, uint32_t slot);

/* Bytes of the arena that are left for a frame. */
size_t content_arena_bytes(const struct app *app);

/* Back to what the scene says. */
void content_reset(struct app *app);

struct table_store_result content_select(struct app *app, const struct usb_select *select);

/* `setting`: enum usb_setting with its value's bytes, 4-aligned. */
struct table_store_result content_set(struct app *app, uint32_t setting, const void *value, uint32_t bytes);

#endif
