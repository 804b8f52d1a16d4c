/*
 * What each request of the protocol does (usb_protocol.h).
 */
#ifndef FIRMWARE_MESSAGES_H
#define FIRMWARE_MESSAGES_H

#include "app.h"

/* Serves the request in app->protocol: replies and releases it, or leaves it there to be called again (a COMMIT being
 * checked, a request that waits for the frame's end, a FRAME being streamed). Only while no reply is being sent. */
void messages_serve(struct app *app);

#endif
