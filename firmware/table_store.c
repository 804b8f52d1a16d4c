#include "table_store.h"

#include "crc32.h"
#include "lut.h"
#include "scene.h"

#define ERASED_WORD 0xffffffffu

static const struct table_store_result done = {USB_OK, 0};

static uint32_t bank_offset(const struct table_store *s, uint32_t slot, uint32_t bank)
{
    if (slot == 0)
        return bank * s->scene_bank_bytes;
    return 2 * s->scene_bank_bytes + (2 * (slot - 1) + bank) * s->table_bank_bytes;
}

static const uint8_t *bank_content(const struct table_store *s, uint32_t slot, uint32_t bank)
{
    return s->hal->flash + bank_offset(s, slot, bank) + TABLE_STORE_DATA_OFFSET;
}

uint32_t table_store_capacity(const struct table_store *s, uint32_t slot)
{
    return (slot == 0 ? s->scene_bank_bytes : s->table_bank_bytes) - TABLE_STORE_DATA_OFFSET;
}

static uint32_t header_crc(const struct table_store_header *h)
{
    return crc32_update(0, h, offsetof(struct table_store_header, header_crc));
}

static uint32_t opening_crc(const struct table_store_opening *o)
{
    return crc32_update(0, o, offsetof(struct table_store_opening, record_crc));
}

/* Bytes of a bank between two marks: whole blocks, so that no more marks are needed than there are. */
static uint32_t mark_bytes(const struct table_store *s, uint32_t length)
{
    uint32_t block = s->hal->flash_block_bytes;
    return ((TABLE_STORE_DATA_OFFSET + length) / (TABLE_STORE_MARKS * block) + 1) * block;
}

static uint8_t kind_of_slot(uint32_t slot)
{
    return slot == 0 ? USB_SLOT_SCENE : USB_SLOT_TABLE;
}

/* 0, or the enum lut_status or scene_status that refuses the content. */
static uint32_t content_check(uint8_t kind, const uint8_t *content, uint32_t bytes)
{
    if (kind == USB_SLOT_SCENE) {
        struct scene scene;
        return (uint32_t)scene_open_bounded(&scene, content, bytes);
    }
    struct lut_table table;
    return (uint32_t)lut_open(&table, content, bytes);
}

/* --- writing --- */

/* Programs words and reads them back. */
static int words_program(struct table_store *s, uint32_t offset, const void *words, uint32_t bytes)
{
    const uint32_t *wanted = words, *found = (const uint32_t *)(const void *)(s->hal->flash + offset);
    int result = s->hal->flash_program(s->hal->ctx, offset, words, bytes);
    for (uint32_t i = 0; i < bytes / 4 && result == HAL_OK; i++)
        if (found[i] != wanted[i])
            result = HAL_ERROR;
    return result;
}

/* Programs one word to 0. One that a power cut left torn stays as it is. */
static int word_clear(struct table_store *s, uint32_t offset)
{
    static const uint32_t zero = 0, erased = ERASED_WORD;
    if (__builtin_memcmp(s->hal->flash + offset, &erased, sizeof erased) != 0)
        return HAL_OK;
    return words_program(s, offset, &zero, sizeof zero);
}

/* Erases a bank's first block, its records with it, and notes the erasure and what is to come. */
static int bank_open(struct table_store *s, uint32_t slot, uint32_t bank, uint32_t length, uint32_t crc)
{
    uint32_t offset = bank_offset(s, slot, bank), old;
    struct table_store_opening o = {
        .magic = TABLE_STORE_OPENING_MAGIC,
        .erases = ++s->slots[slot].erases[bank],
        .length = length,
        .crc = crc,
        .reserved = {ERASED_WORD, ERASED_WORD, ERASED_WORD},
    };
    o.record_crc = opening_crc(&o);
    /* An erasure that is cut off may clear the header and leave the rest: that is not to look like an upload under way. */
    __builtin_memcpy(&old, s->hal->flash + offset + TABLE_STORE_OPENING_OFFSET, sizeof old);
    if (old == TABLE_STORE_OPENING_MAGIC)
        (void)word_clear(s, offset + TABLE_STORE_CLOSED_OFFSET); /* if that fails, so may what follows */
    int result = s->hal->flash_erase(s->hal->ctx, offset);
    return result == HAL_OK ? words_program(s, offset + TABLE_STORE_OPENING_OFFSET, &o, sizeof o) : result;
}

/* The same in the upload's page. */
static int upload_word_clear(struct table_store *s, uint32_t offset)
{
    return word_clear(s, bank_offset(s, s->upload.slot, s->upload.bank) + offset);
}

static bool write_allowed(const struct table_store *s)
{
    return !s->hal->write_allowed || s->hal->write_allowed(s->hal->ctx);
}

/* --- what is live at start --- */

enum bank_state { BANK_BLANK, BANK_TORN, BANK_FOREIGN, BANK_INTACT };

static enum bank_state header_read(struct table_store_header *h, const struct table_store *s, uint32_t slot,
                                   uint32_t bank)
{
    uint32_t blank = ERASED_WORD, words[sizeof *h / 4];
    __builtin_memcpy(h, s->hal->flash + bank_offset(s, slot, bank), sizeof *h);
    __builtin_memcpy(words, h, sizeof *h);
    for (uint32_t i = 0; i < sizeof *h / 4; i++)
        blank &= words[i];
    if (blank == ERASED_WORD)
        return BANK_BLANK;
    if (h->magic != TABLE_STORE_MAGIC || h->header_crc != header_crc(h))
        return BANK_TORN;
    bool ours = h->version == TABLE_STORE_VERSION && h->slot == slot && h->kind == kind_of_slot(slot) &&
                h->length != 0 && h->length <= table_store_capacity(s, slot);
    return ours ? BANK_INTACT : BANK_FOREIGN;
}

/* An upload that the power cut off: open again from the last mark on. */
static void upload_reopen(struct table_store *s, uint32_t slot, uint32_t bank, const struct table_store_opening *o)
{
    const uint32_t *page = (const uint32_t *)(const void *)(s->hal->flash + bank_offset(s, slot, bank));
    const uint32_t *marks = page + TABLE_STORE_MARKS_OFFSET / 4;
    uint32_t n = 0, step = mark_bytes(s, o->length);
    if (o->length == 0 || o->length > table_store_capacity(s, slot) ||
        page[TABLE_STORE_CLOSED_OFFSET / 4] != ERASED_WORD)
        return;
    for (uint32_t i = 0; i < TABLE_STORE_MARKS; i++)
        n = marks[i] == 0 ? i + 1 : n; /* one before may be torn: what counts is the last */
    uint32_t end = n * step;           /* <= 47 * (flash / 47 + block) */
    if (n == 0 || end >= TABLE_STORE_DATA_OFFSET + o->length)
        return;
    s->upload = (struct table_store_upload){
        .open = true,
        .slot = (uint8_t)slot,
        .kind = kind_of_slot(slot),
        .bank = (uint8_t)bank,
        .length = o->length,
        .crc = o->crc,
        .received = end - TABLE_STORE_DATA_OFFSET,
        .found = crc32_update(0, bank_content(s, slot, bank), end - TABLE_STORE_DATA_OFFSET),
        .erased = end,
    };
}

static void openings_read(struct table_store *s, uint32_t slot, const enum bank_state state[2])
{
    uint32_t *erases = s->slots[slot].erases;
    for (uint32_t bank = 0; bank < 2; bank++) {
        struct table_store_opening o;
        __builtin_memcpy(&o, s->hal->flash + bank_offset(s, slot, bank) + TABLE_STORE_OPENING_OFFSET, sizeof o);
        if (o.magic != TABLE_STORE_OPENING_MAGIC || o.record_crc != opening_crc(&o))
            continue;
        erases[bank] = o.erases;
        if (state[bank] == BANK_BLANK && !s->upload.open)
            upload_reopen(s, slot, bank, &o);
    }
    for (uint32_t bank = 0; bank < 2; bank++)
        if (erases[bank] == 0 && erases[1 - bank] > 0) /* lost, or never used: banks take turns */
            erases[bank] = erases[1 - bank] - 1;
}

static bool bank_mount(struct table_store *s, uint32_t slot, uint8_t bank, const struct table_store_header *h)
{
    const uint8_t *content = bank_content(s, slot, bank);
    struct table_store_slot *live = &s->slots[slot];
    if (crc32_update(0, content, h->length) != h->crc || content_check(h->kind, content, h->length) != 0)
        return false;
    live->kind = h->kind;
    live->bank = bank;
    live->length = h->length;
    live->crc = h->crc;
    return true;
}

/* Where nothing is live, a header read badly may be that of the only copy: it stays until another one is. */
static void slot_scrub(struct table_store *s, uint32_t slot)
{
    const uint32_t other = 1u - s->slots[slot].bank;
    struct table_store_header h;
    if (s->slots[slot].kind != USB_SLOT_EMPTY && header_read(&h, s, slot, other) == BANK_TORN && write_allowed(s) &&
        bank_open(s, slot, other, 0, 0) == HAL_OK)
        s->scrubbed++;
}

static void slot_mount(struct table_store *s, uint32_t slot)
{
    struct table_store_header h[2];
    enum bank_state state[2] = {header_read(&h[0], s, slot, 0), header_read(&h[1], s, slot, 1)};
    bool intact[2] = {state[0] == BANK_INTACT, state[1] == BANK_INTACT};
    uint8_t newest = intact[1] && (!intact[0] || h[1].sequence - h[0].sequence < 1u << 31); /* sequences wrap */
    openings_read(s, slot, state);
    s->slots[slot].sequence =
        intact[newest] ? h[newest].sequence : 0; /* later ones supersede it even if it does not open */
    if (!intact[newest] || !bank_mount(s, slot, newest, &h[newest]))
        if (intact[1 - newest])
            bank_mount(s, slot, (uint8_t)(1 - newest), &h[1 - newest]);
    slot_scrub(s, slot);
}

bool table_store_init(struct table_store *s, const struct hal *hal, uint8_t slot_count, uint32_t scene_bank_bytes)
{
    uint32_t block = hal->flash_block_bytes, tables = 2u * (slot_count - 1u);
    __builtin_memset(s, 0, sizeof *s);
    s->hal = hal;
    s->slot_count = slot_count;
    if (block < TABLE_STORE_DATA_OFFSET || block & (block - 1))
        return false;
    if (scene_bank_bytes == 0)
        scene_bank_bytes = hal->flash_bytes / (tables + 2) & ~(block - 1);
    if (scene_bank_bytes < block || scene_bank_bytes > hal->flash_bytes / 2 || scene_bank_bytes & (block - 1))
        return false;
    s->scene_bank_bytes = scene_bank_bytes;
    s->table_bank_bytes = (hal->flash_bytes - 2 * scene_bank_bytes) / tables & ~(block - 1);
    /* a block of 256 bytes would hold the header's page and nothing else */
    if (s->table_bank_bytes <= TABLE_STORE_DATA_OFFSET || s->scene_bank_bytes <= TABLE_STORE_DATA_OFFSET)
        return false;
    for (uint32_t slot = 0; slot < slot_count; slot++)
        slot_mount(s, slot);
    return true;
}

const uint8_t *table_store_content(const struct table_store *s, uint32_t slot, uint32_t *bytes)
{
    const struct table_store_slot *live = &s->slots[slot];
    *bytes = live->length;
    return live->kind == USB_SLOT_EMPTY ? NULL : bank_content(s, slot, live->bank);
}

/* --- uploads --- */

static struct table_store_result flash_failed(struct table_store *s, int result)
{
    s->upload.open = false;
    return (struct table_store_result){result == HAL_FORBIDDEN ? USB_ERR_FORBIDDEN : USB_ERR_FLASH, 0};
}

/* Erases the upload's bank up to `end` bytes from its start, block by block. */
static int bank_erase(struct table_store *s, uint32_t end)
{
    struct table_store_upload *u = &s->upload;
    while (u->erased < end) {
        int result = s->hal->flash_erase(s->hal->ctx, bank_offset(s, u->slot, u->bank) + u->erased);
        if (result != HAL_OK)
            return result;
        u->erased += s->hal->flash_block_bytes;
    }
    return HAL_OK;
}

struct table_store_result table_store_begin(struct table_store *s, const struct usb_begin *b)
{
    if (b->slot >= s->slot_count)
        return (struct table_store_result){USB_ERR_SLOT, s->slot_count};
    if (b->kind != kind_of_slot(b->slot) || b->length == 0)
        return (struct table_store_result){USB_ERR_VALUE, 0};
    if (b->length > table_store_capacity(s, b->slot))
        return (struct table_store_result){USB_ERR_TOO_LARGE, table_store_capacity(s, b->slot)};
    if (!write_allowed(s))
        return (struct table_store_result){USB_ERR_FORBIDDEN, 0};
    const struct table_store_slot *live = &s->slots[b->slot];
    struct table_store_upload *u = &s->upload;
    table_store_abort(s);
    u->open = true;
    u->slot = (uint8_t)b->slot;
    u->kind = (uint8_t)b->kind;
    u->bank = live->kind != USB_SLOT_EMPTY && live->bank == 0;
    u->length = b->length;
    u->crc = b->crc;
    u->received = u->found = 0;
    u->erased = s->hal->flash_block_bytes;
    int result = bank_open(s, u->slot, u->bank, u->length, u->crc);
    return result == HAL_OK ? done : flash_failed(s, result);
}

/* Programs `bytes` of content, a multiple of 4, at `at`; a mark behind it, where one is due. */
static int content_program(struct table_store *s, uint32_t at, const void *words, uint32_t bytes)
{
    const struct table_store_upload *u = &s->upload;
    uint32_t start = TABLE_STORE_DATA_OFFSET + at, end = start + bytes, step = mark_bytes(s, u->length);
    int result = bank_erase(s, end);
    if (result == HAL_OK)
        result = words_program(s, bank_offset(s, u->slot, u->bank) + start, words, bytes);
    if (result == HAL_OK && end % step == 0 && end < TABLE_STORE_DATA_OFFSET + u->length) /* a mark <= 47 */
        result = upload_word_clear(s, TABLE_STORE_MARKS_OFFSET + (end / step - 1) * 4);
    return result;
}

struct table_store_result table_store_write(struct table_store *s, const void *data, uint32_t bytes, uint32_t check)
{
    struct table_store_upload *u = &s->upload;
    const uint8_t *p = data;
    uint32_t found = crc32_update(u->found, data, bytes);
    if (found != check)
        return (struct table_store_result){USB_ERR_DAMAGED, u->received};
    u->found = found;
    while (bytes) {
        uint32_t have = u->received % TABLE_STORE_CHUNK, n = TABLE_STORE_CHUNK - have, at = u->received - have;
        const void *chunk = u->chunk;
        if (n > bytes)
            n = bytes;
        if (n == TABLE_STORE_CHUNK && (uintptr_t)p % 4 == 0)
            chunk = p;
        else
            __builtin_memcpy((uint8_t *)u->chunk + have, p, n);
        u->received += n;
        p += n;
        bytes -= n;
        if (have + n == TABLE_STORE_CHUNK || u->received == u->length) {
            uint32_t padding = -(have + n) & 3;
            __builtin_memset((uint8_t *)u->chunk + (have + n) % TABLE_STORE_CHUNK, 0xff, padding);
            int result = content_program(s, at, chunk, have + n + padding);
            if (result != HAL_OK)
                return flash_failed(s, result);
        }
    }
    return (struct table_store_result){USB_OK, u->received};
}

struct table_store_result table_store_commit(struct table_store *s)
{
    struct table_store_upload *u = &s->upload;
    struct table_store_slot *live = &s->slots[u->slot];
    uint32_t refused = u->found == u->crc ? content_check(u->kind, bank_content(s, u->slot, u->bank), u->length) : 0;
    if (u->found != u->crc || refused) {
        table_store_abort(s);
        return u->found != u->crc ? (struct table_store_result){USB_ERR_CRC, u->found}
                                  : (struct table_store_result){USB_ERR_CONTENT, refused};
    }
    u->open = false;
    struct table_store_header h = {
        .magic = TABLE_STORE_MAGIC,
        .version = TABLE_STORE_VERSION,
        .slot = u->slot,
        .kind = u->kind,
        .length = u->length,
        .crc = u->crc,
        .sequence = live->sequence + 1,
        .reserved = {ERASED_WORD, ERASED_WORD},
    };
    h.header_crc = header_crc(&h);
    int result = words_program(s, bank_offset(s, u->slot, u->bank), &h, sizeof h);
    if (result != HAL_OK)
        return flash_failed(s, result);
    live->kind = u->kind;
    live->bank = u->bank;
    live->length = u->length;
    live->crc = u->crc;
    live->sequence = h.sequence;
    slot_scrub(s, u->slot);
    return done;
}

void table_store_abort(struct table_store *s)
{
    struct table_store_upload *u = &s->upload;
    if (u->open)
        (void)upload_word_clear(s, TABLE_STORE_CLOSED_OFFSET); /* else a restart would open it again */
    u->open = false;
}
