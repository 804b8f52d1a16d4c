/*
 * Protocol version 3 between host and device, over one bulk OUT and one bulk IN endpoint (SPEC.md,
 * "Protocol").
 *
 * The host sends requests: a 16-byte header and `length` payload bytes. The device answers each request with
 * one reply, in order: a 16-byte header and `length` payload bytes; FRAME is answered by one reply per tile
 * and a last one with USB_TILE_LAST set (or by a single reply without payload when it is refused).
 * Little-endian.
 *
 * Check: `detail` of a request is a CRC-32, so that what arrives damaged does nothing. Of DATA: over the upload's content from its start to
 * the end of this message. Of all others: over the header's first 12 bytes and the payload.
 *
 * Packets: requests form a byte stream (they may span packets and share them; zero-length packets are
 * ignored). Each reply starts in a new packet and ends with a short one, zero-length when its bytes are a
 * multiple of the packet size, so that a host's read of any multiple of the packet size ends with the reply.
 *
 * Order: one request is served at a time; further ones wait in the endpoint, also while a frame is streamed.
 * What changes the picture (COMMIT, SELECT, SET, RESET), FRAME and STATS take effect between two frames; INFO,
 * BEGIN, DATA, ABORT and VERIFY at once.
 *
 * Recovery: a header with wrong magic or version, a length above USB_MAX_DRAIN or a wrong check (but DATA's) is answered, then the OUT
 * endpoint stalls. Clearing the halt of the OUT endpoint drops a half-received request; clearing the halt of
 * the IN endpoint drops pending replies, the request in hand and the frame being streamed; a host does
 * both, OUT first, when it opens the device. SET_CONFIGURATION, SET_INTERFACE and a bus reset do the same for both. None of these touches an
 * upload: INFO tells how far it got and DATA goes on from there.
 */
#ifndef FIRMWARE_USB_PROTOCOL_H
#define FIRMWARE_USB_PROTOCOL_H

#include <stdint.h>

#define USB_PROTOCOL_VERSION 3u
#define USB_PROTOCOL_MAGIC   0x5447u /* "GT" */

#define USB_VENDOR_ID       0x1209u /* pid.codes test id: for development only, not for shipping */
#define USB_PRODUCT_ID      0x0001u
#define USB_ENDPOINT_OUT    0x01u
#define USB_ENDPOINT_IN     0x81u
#define USB_INTERFACE_CLASS 0xffu

enum usb_message {
    USB_MSG_INFO = 1, /* -> usb_info */
    USB_MSG_BEGIN,    /* usb_begin -> nothing; opens an upload to a slot's spare bank */
    USB_MSG_DATA,     /* usb_data + 1..USB_MAX_DATA bytes -> nothing, detail = bytes received; offsets ascend
                         without gap */
    USB_MSG_COMMIT, /* -> nothing; checks length, CRC-32 and content, then makes the upload live (one flash record); a new scene
                       forgets select and set; an upload that fails the CRC or content check is dropped */
    USB_MSG_ABORT,  /* -> nothing; drops the upload */
    USB_MSG_SELECT, /* usb_select -> nothing; material to table slot */
    USB_MSG_SET,    /* usb_set + value -> nothing */
    USB_MSG_FRAME,  /* -> one reply per tile, in any order: usb_tile + pixels; then one with USB_TILE_LAST */
    USB_MSG_STATS,  /* usb_stats_request -> usb_stats [+ usb_tile_stats per tile] */
    USB_MSG_RESET,  /* -> nothing; forgets select and set, drops an upload; flash stays */
    USB_MSG_VERIFY, /* usb_verify -> nothing, detail = CRC-32 of the slot's live content, read from flash now */
};

#define USB_REPLY 0x80u /* set in the type of a reply */

enum usb_status {
    USB_OK = 0,
    USB_ERR_MAGIC,      /* not a header: the OUT endpoint stalls after this reply, whose sequence is 0 */
    USB_ERR_VERSION,    /* protocol version not served: detail = the one that is; the OUT endpoint stalls */
    USB_ERR_TYPE,       /* unknown message */
    USB_ERR_LENGTH,     /* payload length does not fit the message: detail = the largest that would */
    USB_ERR_STATE,      /* data/commit without begin; select/set/frame without scene; verify of an empty slot */
    USB_ERR_SLOT,       /* no such slot */
    USB_ERR_TOO_LARGE,  /* upload longer than the slot's bank: detail = bank bytes */
    USB_ERR_OFFSET,     /* data not at the expected offset: detail = expected offset */
    USB_ERR_INCOMPLETE, /* commit before all bytes came: detail = bytes received */
    USB_ERR_CRC,        /* CRC-32 differs: detail = CRC found */
    USB_ERR_CONTENT,    /* table or scene refused: detail = enum lut_status or enum scene_status */
    USB_ERR_FLASH,      /* erase or program failed */
    USB_ERR_FORBIDDEN,  /* the board forbids writing */
    USB_ERR_VALUE,      /* begin/set/select value out of range */
    USB_ERR_RENDER,     /* frame refused: detail = enum raster_status */
    USB_ERR_TABLE,      /* frame refused: a measured material's slot is empty: detail = material index */
    USB_ERR_MEMORY,     /* frame, SELECT or SET refused: arena too small: detail = bytes needed */
    USB_ERR_DAMAGED, /* the check differs: nothing was done; of DATA detail = expected offset, else the OUT endpoint stalls */
    USB_ERR_BUDGET, /* set or frame refused: the scene as the camera sees it takes more than the budget: detail = the least */
    USB_ERR_MODEL, /* frame refused: the firmware is without the model of a material: detail = material index */
    USB_STATUS_COUNT
};

struct usb_header {    /* both directions */
    uint16_t magic;    /* USB_PROTOCOL_MAGIC */
    uint8_t version;   /* USB_PROTOCOL_VERSION */
    uint8_t type;      /* enum usb_message; replies set USB_REPLY */
    uint16_t sequence; /* chosen by the host, returned in the reply */
    uint16_t status;   /* 0 in requests; enum usb_status in replies */
    uint32_t length;   /* payload bytes that follow */
    uint32_t detail;   /* the check of requests; see enum usb_status */
};

enum usb_slot_kind { USB_SLOT_EMPTY = 0, USB_SLOT_TABLE = 1, USB_SLOT_SCENE = 2 };

#define USB_NO_UPLOAD 0xffffffffu
#define USB_MAX_SLOTS 17u /* slot 0 is the scene's, 1..16 are table slots 0..15 of the scene's materials */

struct usb_slot_info {
    uint32_t kind;  /* enum usb_slot_kind */
    uint32_t bytes; /* of the live content */
    uint32_t crc;
    uint32_t bank_bytes; /* largest upload */
    uint32_t erases[2];  /* of the two banks, as far as known: a power cut may lose one */
};

struct usb_info {
    uint16_t protocol_version, scene_version;
    char firmware[16]; /* GONIOTILE_VERSION, NUL-padded */
    uint16_t width, height;
    uint8_t format; /* enum raster_format */
    uint8_t slot_count;
    uint16_t tile_width, tile_height;
    uint16_t material_count, object_count; /* of the live scene; 0 without */
    uint16_t light_count;
    uint32_t triangle_count; /* of the live scene, finest levels */
    uint32_t arena_bytes;
    uint32_t flash_bytes, flash_block_bytes;   /* of all banks; erase unit */
    uint32_t scrubbed;                         /* banks that a power cut had left torn, erased since the last start */
    uint32_t upload_slot;                      /* of the open upload, or USB_NO_UPLOAD and the next four 0 */
    uint32_t upload_length;                    /* as BEGIN said */
    uint32_t upload_crc;                       /* as BEGIN said */
    uint32_t upload_received;                  /* bytes that came and were checked: the next offset expected */
    uint32_t upload_found;                     /* CRC-32 of these: a host that goes on compares it with its own */
    struct usb_slot_info slots[USB_MAX_SLOTS]; /* slot_count are meaningful */
};

struct usb_begin {
    uint32_t slot;   /* < slot_count */
    uint32_t kind;   /* enum usb_slot_kind; scene only in slot 0, tables only elsewhere */
    uint32_t length; /* bytes that will come, > 0 */
    uint32_t crc;    /* CRC-32 (IEEE 802.3) over them */
};

#define USB_MAX_DATA    4096u               /* bytes after usb_data in one message */
#define USB_MAX_PAYLOAD (4u + USB_MAX_DATA) /* of any request */
#define USB_MAX_DRAIN   65536u              /* a wrong length up to this is read and dropped; above, OUT stalls */

struct usb_data {
    uint32_t offset;
};

struct usb_select {
    uint16_t material;
    uint16_t table; /* table slot 0..15 */
};

struct usb_verify {
    uint32_t slot; /* < slot_count */
};

enum usb_setting {
    USB_SET_CAMERA = 1, /* struct scene_camera */
    USB_SET_LIGHT,      /* index (uint32_t) + struct scene_light; index = count adds one; see APP_MAX_SET_LIGHTS */
    USB_SET_OUTPUT,     /* struct scene_output */
    USB_SET_MODEL,      /* uint32_t: enum scene_material_kind for all materials, or 0xffffffff: as the scene says */
    USB_SET_BUDGET      /* uint32_t: ticks per tile on average, 0: no limit */
};

struct usb_set {
    uint32_t setting; /* enum usb_setting; the value follows */
};

struct usb_tile { /* payload of a FRAME reply; the pixels follow, rows without padding */
    uint16_t x, y, width, height;
    uint32_t flags; /* USB_TILE_LAST */
};
#define USB_TILE_LAST 1u /* the frame is complete; this reply has width = height = 0 and no pixels */

struct usb_stats_request {
    uint32_t want_tiles; /* 0 or 1 */
};

struct usb_tile_stats {
    uint32_t triangles, tested, covered, shaded, fetches;
    uint32_t ticks;     /* spent */
    uint32_t budget;    /* ticks that were its share; 0: no budget, and nothing below is meaningful */
    uint32_t predicted; /* ticks, after visibility */
    uint32_t error;     /* predicted: squared 8-bit steps, summed over pixels and colours */
    uint8_t coarsest;   /* rate of shading, enum raster_rate */
    uint8_t lights;     /* evaluated at most; 255: all */
    uint16_t rate;      /* mean over pixels, 8 fraction bits */
};

struct usb_stats {               /* of the last complete frame; totals over its tiles */
    uint32_t frames;             /* since power-up */
    uint32_t tile_count;         /* usb_tile_stats follow when wanted and kept (the length tells), row-major */
    uint32_t ticks_are_modelled; /* 1: from counts; 0: hal.clock */
    uint32_t begin_ticks;        /* culling and binning */
    uint32_t meshlets_visible;
    uint32_t arena_used;
    uint32_t tile_budget; /* as set */
    uint32_t
        least_tile_budget; /* the least that the frame could have had; 0: not known, without a budget and with a clock */
    uint32_t lod_bias;     /* how often their threshold was doubled, for memory or for the budget */
    uint32_t tiles_reduced;      /* below full quality */
    uint32_t tiles_coarse;       /* of them, drawn at the coarsest levels of detail */
    uint32_t budget_ticks;       /* spent on deciding, part of the tiles' */
    struct usb_tile_stats total; /* coarsest and fewest of all; the mean over all pixels */
};

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "structures are copied to and from the bus as they are");
_Static_assert(sizeof(struct usb_header) == 16, "layout");
_Static_assert(sizeof(struct usb_slot_info) == 24, "layout");
_Static_assert(sizeof(struct usb_info) == 76 + 24 * USB_MAX_SLOTS, "layout");
_Static_assert(sizeof(struct usb_tile) == 12, "layout");
_Static_assert(sizeof(struct usb_tile_stats) == 40, "layout");
_Static_assert(sizeof(struct usb_stats) == 88, "layout");

#endif
