/*
 * A board to start from: compiles for any target and does nothing. Copy the folder, then work through the comments: each says what the
 * firmware relies on. hal.h is the contract, hal/sim an implementation to compare with, hal/PORTING.md tells the whole way.
 *
 * Before main
 *   [ ] startup copies .data, clears .bss and sets the stack (the firmware's own need: `make boards` prints it)
 *   [ ] .data and .bss hold no code the firmware calls; it needs no heap, no floating point, no C library but memcpy, memset,
 *       memmove and memcmp
 *   [ ] the end of the stack is guarded, and faults have a stack of their own (hal/emulated/cortex_m.c)
 *   [ ] caches are on for flash; memory that DMA reads is clean or not cached
 */
#include "app.h"
#include "costs/cortex_m7.h"

#define FLASH_BYTES       (128u * 1024u)
#define FLASH_BLOCK_BYTES 4096u

/* [ ] All of this in the fastest RAM there is: struct app holds the tile that the renderer works on. */
static struct app app;
/* [ ] The ways of shading that the product's scenes take: what is not named takes no flash, and scenes that ask for it are refused. */
static const struct raster_parts parts = {
    .half_vector = &raster_half_vector_model,
    .lafortune_phong = &raster_lafortune_phong_model,
    .cells = &raster_cells, /* for budgets */
};

/* [ ] Large enough for the scenes to come: a frame that needs more is refused, and the reply says how much it takes. */
static uint64_t arena[16 * 1024 / 8];
/* [ ] The flash region for scene and tables, not an array; 4-aligned, outside the program, of blocks of one size. */
static const _Alignas(4) uint8_t flash[FLASH_BYTES];

/* [ ] Rows follow each other without gap; RGB565 is little-endian in memory: many panels want it swapped.
 * [ ] `pixels` may be overwritten on return: wait for the DMA that reads it, or copy.
 * [ ] Any tile inside the picture, in any order; tiles at the right and bottom edge are smaller. */
static int display_write(void *ctx, uint16_t x, uint16_t y, uint16_t w, uint16_t h, const void *pixels)
{
    (void)ctx;
    (void)x;
    (void)y;
    (void)w;
    (void)h;
    (void)pixels;
    return HAL_OK;
}

/* [ ] Interrupts only queue; this takes from the queue, in order, and never waits.
 * [ ] A bus reset empties the endpoints' queues, clears their stalls and the address.
 * [ ] A SETUP packet, when it arrives, empties endpoint 0 in both directions, clears its stall, voids an address that waits for its status
 *     packet and replaces a SETUP not yet taken. What is queued on endpoint 0x80 until it is taken is dropped, a stall and an address, too. */
static enum hal_usb_event usb_event(void *ctx, uint8_t setup[8])
{
    (void)ctx;
    (void)setup;
    return HAL_USB_NONE;
}

/* [ ] One packet per call; at least 4 KB of endpoint 1 are buffered, so that the bus keeps moving while a tile renders.
 * [ ] A full buffer answers NAK.
 * [ ] `data` has any alignment; nothing writes there after the return. */
static int usb_read(void *ctx, uint8_t endpoint, void *data, size_t max)
{
    (void)ctx;
    (void)endpoint;
    (void)data;
    (void)max;
    return HAL_AGAIN;
}

/* [ ] Copies the packet before it returns: `data` has any alignment and is gone then. Zero-length packets are sent, too. */
static int usb_write(void *ctx, uint8_t endpoint, const void *data, size_t bytes)
{
    (void)ctx;
    (void)endpoint;
    (void)data;
    (void)bytes;
    return HAL_AGAIN;
}

/* [ ] Clearing empties the queue and resets the data toggle; the first clearing opens the endpoint. */
static void usb_stall(void *ctx, uint8_t endpoint, bool stalled)
{
    (void)ctx;
    (void)endpoint;
    (void)stalled;
}

/* [ ] Called before the status packet is queued, perhaps several times: the address waits until that packet, the next one on endpoint
 *     0x80, has been acknowledged. Controllers that change over by themselves then (the OTG cores of many STM32) are written at once.
 * [ ] A SETUP packet or a bus reset before that voids it. */
static void usb_set_address(void *ctx, uint8_t address)
{
    (void)ctx;
    (void)address;
}

/* [ ] Erased bytes read 0xff, through the mapping, caches included.
 * [ ] Returns when it is done: the firmware reads at once. Code that runs meanwhile, interrupts among it, is not in the flash being
 *     erased, or the core stalls: that is allowed as long as the USB controller answers NAK by itself.
 * [ ] A failed verification is HAL_ERROR. */
static int flash_erase(void *ctx, uint32_t offset)
{
    (void)ctx;
    (void)offset;
    return HAL_FORBIDDEN;
}

/* [ ] The flash programs single words of 4 bytes, each once between two erases, and a torn one reads without a fault: see hal.h for
 *     flash that does not. `bytes` may span pages of the flash; `data` is 4-aligned.
 * [ ] A power cut in here leaves no other word than those asked for undefined. */
static int flash_program(void *ctx, uint32_t offset, const void *data, uint32_t bytes)
{
    (void)ctx;
    (void)offset;
    (void)data;
    (void)bytes;
    return HAL_FORBIDDEN;
}

/* [ ] The jumper or strap, read each time. */
static bool write_allowed(void *ctx)
{
    (void)ctx;
    return false;
}

int main(void)
{
    static const struct hal hal = {
        /* [ ] NULL: ticks are modelled from counts, and repeat exactly. Else it counts up, wraps at 2^32 and costs little: the cycle
         *     counter (DWT CYCCNT, mcycle), or a timer at the core's clock.
         * [ ] It runs, sleep included: uploads beside frames wait for what tiles earn in ticks, and all but stop with a clock that
         *     stands still. CYCCNT needs DEMCR.TRCENA, on Cortex-M7 its lock access register (0xc5acce55 to DWT_LAR) first, then
         *     DWT_CTRL.CYCCNTENA; it counts the core's clock, and not while the core waits in WFI. */
        .clock = NULL,
        .display_write = display_write,
        .usb_event = usb_event,
        .usb_read = usb_read,
        .usb_write = usb_write,
        .usb_stall = usb_stall,
        .usb_set_address = usb_set_address,
        /* [ ] Where the controller can run at high speed: capable, and what each bus reset negotiates is set before that event is
         * returned; this struct is then not const. */
        .usb_high_speed = false,
        .usb_high_speed_capable = false,
        .flash = flash,
        .flash_bytes = FLASH_BYTES,
        .flash_block_bytes = FLASH_BLOCK_BYTES,
        .flash_erase = flash_erase,
        .flash_program = flash_program,
        .write_allowed = write_allowed,
    };
    static const struct app_config config = {
        .width = 128, /* [ ] the display's */
        .height = 64,
        .format = RASTER_RGB565,
        .slot_count = 2, /* [ ] one for the scene, the others for tables; each takes two banks of flash */
        .parts = &parts,
        .arena = arena,
        .arena_bytes = sizeof arena,
        .costs = &costs_cortex_m7,    /* [ ] the target's own: `make calibrate BOARD=...` writes them */
        .budgets = &budget_scheduler, /* [ ] NULL: without, and with 17 KB less code */
        .serial = "GT-0001",          /* [ ] different on every device */
    };
    if (app_init(&app, &hal, &config) != APP_OK)
        return 1; /* [ ] a light, a message: the configuration does not fit the flash */
    for (;;)
        /* [ ] While the bus is suspended a device that lives on it may draw 2.5 mA: sleep here until there is activity. */
        /* [ ] Feed the watchdog here. One call takes a tile's time, and what a request takes on top: DATA erases 4 KB of blocks, rounded up,
         * and one more, and programs 4 KB; COMMIT opens the content; the first call of a frame culls and bins. */
        app_poll(&app);
}
