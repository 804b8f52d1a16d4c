/* The firmware's side of the mailbox. */
#ifndef HAL_MPS2_MAILBOX_USB_H
#define HAL_MPS2_MAILBOX_USB_H

#include "hal.h"
#include "mailbox.h"

/* Sets the USB functions of *hal, whose ctx must be the mailbox, and tells the bridge that the device is on. */
void mailbox_open(struct hal *hal, struct mailbox *m);

#endif
