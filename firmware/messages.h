/*
 * What each request of the protocol does (usb_protocol.h).
 */
#ifndef FIRMWARE_MESSAGES_H
#define FIRMWARE_MESSAGES_H

#include "app.h"

/* Serves the request in app->protocol: replies and releases it, or leaves it there to be called again (a VERIFY at
 * work, a request that waits for the frame's end or for its share of the time, a FRAME being streamed). Only while no reply is being sent. */
void messages_serve(struct app *app);

#endif
