/*
 * Table store: slots of two banks in flash, of which at most one is live (SPEC.md, "Flash layout").
 *
 * Purpose   an upload goes to the slot's spare bank and becomes live by one record, the bank header, which is
 *           programmed last: before it the old content is live, after it the new one, never a mixture.
 * Bank      a 256-byte page with two records, each programmed once: the header, and the opening, which comes right after the
 *           page's erasure and says how often it was erased and what is to come; and marks of how far that came. Then the
 *           content from offset TABLE_STORE_DATA_OFFSET.
 * Start     of the banks whose header, data CRC and content are intact, the one with the highest sequence is live. A header
 *           that a power cut left torn is erased (scrubbed), since what reads as torn today may read as whole tomorrow; where
 *           nothing is live in the slot, not before something is, as it may be the only copy's, read badly for once. An upload
 *           that a power cut left is open again, up to the last mark.
 * Checks    every message of an upload against the CRC of the content so far before anything is programmed; every word
 *           programmed is read back.
 */
#ifndef FIRMWARE_TABLE_STORE_H
#define FIRMWARE_TABLE_STORE_H

#include "hal.h"
#include "usb_protocol.h"

#define TABLE_STORE_MAGIC       0x4b425447u /* "GTBK" */
#define TABLE_STORE_VERSION     1u
#define TABLE_STORE_DATA_OFFSET 256u
#define TABLE_STORE_CHUNK       256u /* programmed at once */

#define TABLE_STORE_OPENING_MAGIC  0x504f5447u /* "GTOP" */
#define TABLE_STORE_OPENING_OFFSET 32u
#define TABLE_STORE_MARKS_OFFSET   64u  /* words: 0 when the blocks up to this mark are programmed */
#define TABLE_STORE_MARKS          47u  /* at most */
#define TABLE_STORE_CLOSED_OFFSET  252u /* a word: not erased: given up, or to be erased */

struct table_store_header { /* at the start of a bank, little-endian */
    uint32_t magic;
    uint16_t version;
    uint8_t slot, kind;   /* kind: enum usb_slot_kind */
    uint32_t length, crc; /* of the content */
    uint32_t sequence;    /* 1 + the latest in the slot's headers */
    uint32_t reserved[2]; /* 0xffffffff: left erased */
    uint32_t header_crc;  /* CRC-32 of the 28 bytes before */
};
_Static_assert(sizeof(struct table_store_header) == 32, "layout");

struct table_store_opening { /* at TABLE_STORE_OPENING_OFFSET */
    uint32_t magic;
    uint32_t erases;      /* of the bank's first block, this one included */
    uint32_t length, crc; /* of the content to come; 0 when the block was but erased */
    uint32_t reserved[3]; /* 0xffffffff */
    uint32_t record_crc;  /* CRC-32 of the 28 bytes before */
};
_Static_assert(sizeof(struct table_store_opening) == 32, "layout");

struct table_store_slot {
    uint8_t kind; /* enum usb_slot_kind; EMPTY: nothing is live */
    uint8_t bank; /* 0 or 1: the live one */
    uint32_t length, crc;
    uint32_t sequence;  /* the latest in the slot's headers, 0 without */
    uint32_t erases[2]; /* of each bank; where the record is lost, one less than the other bank's */
};

struct table_store_upload {
    bool open;
    uint8_t slot, kind, bank;
    uint32_t length, crc;
    uint32_t received;                     /* bytes taken and checked */
    uint32_t found;                        /* CRC-32 of these */
    uint32_t erased;                       /* bytes of the bank erased, from its start */
    uint32_t chunk[TABLE_STORE_CHUNK / 4]; /* bytes received and not yet programmed */
};

struct table_store {
    const struct hal *hal;
    uint32_t scene_bank_bytes, table_bank_bytes;
    uint32_t scrubbed; /* banks, since the start */
    uint8_t slot_count;
    struct table_store_slot slots[USB_MAX_SLOTS];
    struct table_store_upload upload;
};

/* An outcome with the `detail` of the reply (usb_protocol.h). */
struct table_store_result {
    enum usb_status status;
    uint32_t detail;
};

/* Lays the banks out (slot 0's two, then the others', equal, whole blocks), finds what is live, opens an upload that a power cut
 * left, and scrubs torn banks beside live ones where writing is allowed. In:
 * slot_count 2..USB_MAX_SLOTS; scene_bank_bytes of each of slot 0's banks, 0 = as large as the others. False
 * when the flash is too small, or its blocks are not as hal.h says. */
bool table_store_init(struct table_store *s, const struct hal *hal, uint8_t slot_count, uint32_t scene_bank_bytes);

/* Largest content of a slot, bytes. */
uint32_t table_store_capacity(const struct table_store *s, uint32_t slot);

/* Live content, 4-aligned, in flash, or NULL; *bytes its length. Stays readable until the second next begin
 * for the slot. */
const uint8_t *table_store_content(const struct table_store *s, uint32_t slot, uint32_t *bytes);

/* Opens an upload (dropping an open one) and erases the spare bank's first block, so that its old header is
 * gone. Nobody may still be reading the spare bank. */
struct table_store_result table_store_begin(struct table_store *s, const struct usb_begin *begin);

/* Takes bytes of the open upload when `check` is the CRC-32 of the content up to their end; USB_ERR_DAMAGED: nothing
 * changed, detail = bytes received before. The caller has checked offset and length. Erases block by block as the data
 * arrives. Drops the upload when the flash fails. */
struct table_store_result table_store_write(struct table_store *s, const void *data, uint32_t bytes, uint32_t check);

/* Ends a complete upload: CRC and content right, programs the header and switches the slot; else drops the
 * upload. */
struct table_store_result table_store_commit(struct table_store *s);

/* Drops the open upload, if any, for good. */
void table_store_abort(struct table_store *s);

#endif
