/* The table store on the simulated flash: what is live, before and after whatever happens to an upload. */
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include "crc32.h"
#include "device_fixture.h"

enum { SLOTS = 3, BANKS = 2 * SLOTS };

static uint64_t seed = 1;

static uint32_t random32(void)
{
    seed = seed * 6364136223846793005u + 1442695040888963407u;
    return (uint32_t)(seed >> 32);
}

struct fixture {
    struct sim *board;
    struct table_store store;
    void *tables[3]; /* of 1, 2, 3; all of `bytes` bytes */
    size_t bytes;
};

static int setup(void **state)
{
    struct sim_config c = {.slot_count = SLOTS, .table_bank_bytes = FIXTURE_BANK, .scene_bank_bytes = FIXTURE_BANK};
    struct fixture *f = calloc(1, sizeof *f);
    f->board = sim_create(&c);
    for (uint32_t i = 0; i < 3; i++)
        f->tables[i] = fixture_table(i + 1, &f->bytes);
    *state = f;
    return !table_store_init(&f->store, sim_hal(f->board), SLOTS, FIXTURE_BANK);
}

static int teardown(void **state)
{
    struct fixture *f = *state;
    sim_destroy(f->board);
    for (int i = 0; i < 3; i++)
        free(f->tables[i]);
    free(f);
    return 0;
}

static struct table_store_result begin(struct fixture *f, uint32_t slot, uint32_t kind, const void *data, size_t bytes)
{
    struct usb_begin b = {slot, kind, (uint32_t)bytes, crc32_update(0, data, bytes)};
    return table_store_begin(&f->store, &b);
}

/* The next bytes of an upload, with their check. */
static struct table_store_result write_next(struct fixture *f, const void *data, uint32_t bytes)
{
    return table_store_write(&f->store, data, bytes, crc32_update(f->store.upload.found, data, bytes));
}

/* Writes and commits an upload that has begun; the first status that is not USB_OK. */
static struct table_store_result finish(struct fixture *f, const void *data, size_t bytes)
{
    struct table_store_result r = write_next(f, data, (uint32_t)bytes);
    return r.status == USB_OK ? table_store_commit(&f->store) : r;
}

static enum usb_status push(struct fixture *f, uint32_t slot, const void *data, size_t bytes)
{
    struct table_store_result r = begin(f, slot, USB_SLOT_TABLE, data, bytes);
    return r.status == USB_OK ? finish(f, data, bytes).status : r.status;
}

static void restart(struct fixture *f)
{
    assert_true(table_store_init(&f->store, sim_hal(f->board), SLOTS, FIXTURE_BANK));
}

/* Index of the table that is live in a slot, -1 when it is empty; anything else fails the test. */
static int live(struct fixture *f, uint32_t slot)
{
    uint32_t bytes;
    const uint8_t *content = table_store_content(&f->store, slot, &bytes);
    if (!content)
        return -1;
    assert_int_equal(bytes, f->bytes);
    for (int i = 0; i < 3; i++)
        if (memcmp(content, f->tables[i], f->bytes) == 0)
            return i;
    fail_msg("the live content is none of those pushed");
    return -2;
}

static uint8_t *bank(struct fixture *f, uint32_t slot, uint32_t which)
{
    uint32_t bytes;
    return sim_flash(f->board, &bytes) + (2 * slot + which) * FIXTURE_BANK;
}

static void committed_table_is_live_and_survives_a_restart(void **state)
{
    struct fixture *f = *state;
    assert_int_equal(live(f, 1), -1);
    for (int i = 0; i < 3; i++) {
        assert_int_equal(push(f, 1, f->tables[i], f->bytes), USB_OK);
        assert_int_equal(live(f, 1), i);
        assert_int_equal(f->store.slots[1].bank, i % 2);
        restart(f);
        assert_int_equal(live(f, 1), i);
        assert_int_equal(live(f, 2), -1);
    }
}

static void header_is_as_specified(void **state)
{
    struct fixture *f = *state;
    static const uint8_t fixed[8] = {'G', 'T', 'B', 'K', 1, 0, 2, USB_SLOT_TABLE};
    push(f, 2, f->tables[0], f->bytes);
    push(f, 2, f->tables[1], f->bytes);
    uint8_t *h = bank(f, 2, 1);
    uint32_t words[8];
    memcpy(words, h, 32);
    assert_memory_equal(h, fixed, 8);
    assert_int_equal(words[2], f->bytes);
    assert_int_equal(words[3], crc32_update(0, f->tables[1], f->bytes));
    assert_int_equal(words[4], 2);
    assert_int_equal(words[5] & words[6], 0xffffffff);
    assert_int_equal(words[7], crc32_update(0, h, 28));
    assert_memory_equal(h + 256, f->tables[1], f->bytes);
}

static void upload_without_commit_leaves_the_old_table(void **state)
{
    struct fixture *f = *state;
    push(f, 1, f->tables[0], f->bytes);
    assert_int_equal(begin(f, 1, USB_SLOT_TABLE, f->tables[1], f->bytes).status, USB_OK);
    assert_int_equal(live(f, 1), 0);
    assert_int_equal(write_next(f, f->tables[1], (uint32_t)f->bytes).status, USB_OK);
    assert_int_equal(live(f, 1), 0);
    restart(f);
    assert_int_equal(live(f, 1), 0);
    assert_false(f->store.upload.open);
    assert_int_equal(push(f, 1, f->tables[2], f->bytes), USB_OK); /* over what the unfinished one left */
    assert_int_equal(live(f, 1), 2);
}

/* The flash fails at operation n and from then on, as when the power goes; afterwards one of the two is live. */
static void failure_at_any_operation_leaves_one_whole_table(void **state)
{
    struct fixture *f = *state;
    int now = 0, changes = 0;
    push(f, 1, f->tables[0], f->bytes);
    for (long n = 0; n < 40; n++) {
        int next = (now + 1) % 3;
        sim_fail_flash_after(f->board, n);
        enum usb_status status = push(f, 1, f->tables[next], f->bytes);
        assert_true(status == USB_OK || status == USB_ERR_FLASH);
        assert_int_equal(live(f, 1), status == USB_OK ? next : now);
        sim_fail_flash_after(f->board, -1);
        restart(f);
        assert_int_equal(live(f, 1), status == USB_OK ? next : now);
        changes += status == USB_OK;
        now = live(f, 1);
    }
    assert_in_range(changes, 1, 39);
}

static void flipped_bit_in_the_live_bank_falls_back_to_the_older_one(void **state)
{
    struct fixture *f = *state;
    push(f, 1, f->tables[0], f->bytes);
    push(f, 1, f->tables[1], f->bytes);
    for (int i = 0; i < 200; i++) {
        uint32_t at = 256 + random32() % (uint32_t)f->bytes;
        uint8_t bit = (uint8_t)(1 << random32() % 8);
        bank(f, 1, 1)[at] ^= bit;
        restart(f);
        assert_int_equal(live(f, 1), 0);
        bank(f, 1, 1)[at] ^= bit;
        restart(f);
        assert_int_equal(live(f, 1), 1);
    }
    bank(f, 1, 0)[300] ^= 1; /* the older bank's damage does not matter */
    restart(f);
    assert_int_equal(live(f, 1), 1);
    bank(f, 1, 1)[300] ^= 1;
    restart(f);
    assert_int_equal(live(f, 1), -1);
    assert_int_equal(push(f, 1, f->tables[2], f->bytes), USB_OK);
    assert_int_equal(live(f, 1), 2);
}

/* A header with a wrong bit, as a power cut leaves it, is erased at the next start, unless the board forbids writing. */
static void torn_header_is_scrubbed(void **state)
{
    struct fixture *f = *state;
    for (uint32_t i = 0; i < 8 * 32; i++) {
        push(f, 1, f->tables[0], f->bytes);
        push(f, 1, f->tables[1], f->bytes);
        uint32_t newest = f->store.slots[1].bank, erases = f->store.slots[1].erases[newest];
        bank(f, 1, newest)[i / 8] ^= (uint8_t)(1 << i % 8);
        sim_forbid_writing(f->board, true);
        restart(f);
        assert_int_equal(live(f, 1), 0);
        assert_int_equal(f->store.scrubbed, 0);
        sim_forbid_writing(f->board, false);
        restart(f);
        assert_int_equal(live(f, 1), 0);
        assert_int_equal(f->store.scrubbed, 1);
        assert_int_equal(bank(f, 1, newest)[i / 8], 0xff);
        assert_int_equal(f->store.slots[1].erases[newest], erases + 1);
        restart(f);
        assert_int_equal(live(f, 1), 0);
        assert_int_equal(f->store.scrubbed, 0);
    }
}

/* But not while nothing is live in the slot: read rightly the next time, the newest bank is live again. */
static void torn_headers_stay_while_nothing_is_live(void **state)
{
    struct fixture *f = *state;
    for (int banks = 1; banks <= 2; banks++) {
        push(f, 1, f->tables[banks], f->bytes);
        for (uint32_t i = 0; i < 8 * 32; i++)
            for (int right = 0; right < 2; right++) {
                for (uint32_t which = 0; which < (uint32_t)banks; which++)
                    bank(f, 1, which)[i / 8] ^= (uint8_t)(1 << i % 8);
                restart(f);
                assert_int_equal(live(f, 1), right ? banks : -1);
                assert_int_equal(f->store.scrubbed, 0);
            }
    }
    for (uint32_t which = 0; which < 2; which++)
        bank(f, 1, which)[4] ^= 1;
    restart(f);
    push(f, 1, f->tables[0], f->bytes); /* bank 1, of a later sequence, must not supersede it */
    assert_int_equal(f->store.scrubbed, 1);
    bank(f, 1, 1)[4] &= (uint8_t)~1;
    restart(f);
    assert_int_equal(live(f, 1), 0);
}

static void erasures_are_counted_and_survive(void **state)
{
    struct fixture *f = *state;
    for (uint32_t i = 1; i < 20; i++) {
        push(f, 1, f->tables[i % 3], f->bytes);
        for (int again = 0; again < 2; again++) {
            assert_int_equal(f->store.slots[1].erases[0], (i + 1) / 2);
            assert_int_equal(f->store.slots[1].erases[1], i / 2);
            assert_int_equal(f->store.slots[2].erases[0], 0);
            restart(f);
        }
    }
    uint8_t *record = bank(f, 1, 0) + TABLE_STORE_OPENING_OFFSET;
    uint32_t words[8];
    memcpy(words, record, 32);
    assert_memory_equal(record, "GTOP", 4);
    assert_int_equal(words[1], 10);
    assert_int_equal(words[2], f->bytes);
    assert_int_equal(words[3], crc32_update(0, f->tables[1], f->bytes));
    assert_int_equal(words[4] & words[5] & words[6], 0xffffffff);
    assert_int_equal(words[7], crc32_update(0, record, 28));
    record[4] ^= 1; /* lost: that of the other bank is about the same */
    restart(f);
    assert_int_equal(f->store.slots[1].erases[0], 8);
}

/* A power cut drops what came after the last block that was marked; the rest goes on from there, and ends in the same content. */
static void upload_goes_on_after_a_restart(void **state)
{
    struct fixture *f = *state;
    static uint8_t data[FIXTURE_CAPACITY];
    for (size_t i = 0; i < sizeof data; i++)
        data[i] = (uint8_t)random32();
    memset(bank(f, 1, 0), 0x55, FIXTURE_BANK);
    memset(bank(f, 1, 0), 0xff, 256);
    for (uint32_t cut = 0; cut <= sizeof data; cut += 100) {
        begin(f, 1, USB_SLOT_TABLE, data, sizeof data);
        assert_int_equal(write_next(f, data, cut).status, USB_OK);
        restart(f);
        const struct table_store_upload *u = &f->store.upload;
        uint32_t marked = (cut + 256) / SIM_FLASH_BLOCK * SIM_FLASH_BLOCK;
        assert_int_equal(u->open, marked > 0);
        if (u->open) {
            /* the last block has no mark */
            assert_int_equal(u->received, (marked == FIXTURE_BANK ? marked - SIM_FLASH_BLOCK : marked) - 256);
            assert_int_equal(u->found, crc32_update(0, data, u->received));
            assert_int_equal(u->crc, crc32_update(0, data, sizeof data));
            assert_int_equal(u->length, sizeof data);
            assert_int_equal(u->slot, 1);
            uint32_t rest = u->received;
            assert_int_equal(write_next(f, data + rest, sizeof data - rest).status, USB_OK);
            assert_int_equal(table_store_commit(&f->store).status, USB_ERR_CONTENT); /* whole, though no table */
            assert_memory_equal(bank(f, 1, 0) + 256, data, sizeof data);
            restart(f);
            assert_false(u->open); /* a refused upload does not come back */
        }
    }
    for (int how = 0; how < 2; how++) { /* nor does one that was given up, or dropped by another */
        begin(f, 1, USB_SLOT_TABLE, data, sizeof data);
        write_next(f, data, 5000);
        if (how == 0)
            table_store_abort(&f->store);
        else
            begin(f, 2, USB_SLOT_TABLE, data, sizeof data);
        restart(f);
        assert_false(f->store.upload.open);
    }
    begin(f, 1, USB_SLOT_TABLE, data, sizeof data);
    write_next(f, data, 9000);
    bank(f, 1, 0)[64] = 1; /* a torn mark does not matter when a later one is whole */
    restart(f);
    assert_int_equal(f->store.upload.received, 2 * SIM_FLASH_BLOCK - 256);
    bank(f, 1, 0)[252] = 0x7f; /* nor does the upload come back when its end is torn */
    restart(f);
    assert_false(f->store.upload.open);
}

/* An erasure that the power cut off after the header. */
static int erase_the_header_alone(void *ctx, uint32_t offset)
{
    uint32_t bytes;
    memset(sim_flash(ctx, &bytes) + offset, 0xff, 32);
    return HAL_ERROR;
}

static void bank_whose_erasure_was_cut_off_is_no_upload(void **state)
{
    struct fixture *f = *state;
    struct hal hal = *sim_hal(f->board);
    static uint32_t texels[40 * 20 * 2];
    size_t bytes;
    void *table = ref_ktx2_make(40, 20, 2, texels, 60000, &bytes);
    assert_in_range(bytes, SIM_FLASH_BLOCK, FIXTURE_CAPACITY); /* there is a mark */
    assert_int_equal(push(f, 1, table, bytes), USB_OK);
    assert_int_equal(push(f, 1, f->tables[0], f->bytes), USB_OK);
    hal.flash_erase = erase_the_header_alone;
    f->store.hal = &hal;
    assert_int_equal(push(f, 1, f->tables[1], f->bytes), USB_ERR_FLASH);
    restart(f);
    assert_false(f->store.upload.open);
    assert_int_equal(live(f, 1), 0);
    assert_int_equal(push(f, 1, f->tables[1], f->bytes), USB_OK);
    assert_int_equal(live(f, 1), 1);
    free(table);
}

/* A table that does not open for once must not come back over one that was pushed after it. */
static void later_push_supersedes_a_bank_that_was_damaged_for_a_while(void **state)
{
    struct fixture *f = *state;
    push(f, 1, f->tables[0], f->bytes);
    push(f, 1, f->tables[1], f->bytes);
    bank(f, 1, 0)[300] ^= 1;
    bank(f, 1, 1)[300] ^= 1;
    restart(f);
    assert_int_equal(live(f, 1), -1);
    assert_int_equal(push(f, 1, f->tables[2], f->bytes), USB_OK);
    bank(f, 1, 1)[300] ^= 1;
    restart(f);
    assert_int_equal(live(f, 1), 2);
}

/* What the flash did not take is found when it is read back. */
static int program_nothing(void *ctx, uint32_t offset, const void *data, uint32_t bytes)
{
    (void)ctx;
    (void)offset;
    (void)data;
    (void)bytes;
    return HAL_OK;
}

static void words_that_do_not_stick_are_noticed(void **state)
{
    struct fixture *f = *state;
    struct hal hal = *sim_hal(f->board);
    push(f, 1, f->tables[0], f->bytes);
    f->store.hal = &hal;
    hal.flash_program = program_nothing;
    assert_int_equal(push(f, 1, f->tables[1], f->bytes), USB_ERR_FLASH);
    hal.flash_program = sim_hal(f->board)->flash_program;
    assert_int_equal(begin(f, 1, USB_SLOT_TABLE, f->tables[1], f->bytes).status, USB_OK);
    hal.flash_program = program_nothing;
    assert_int_equal(finish(f, f->tables[1], f->bytes).status, USB_ERR_FLASH);
    assert_int_equal(live(f, 1), 0);
    hal.flash_program = sim_hal(f->board)->flash_program;
    assert_int_equal(push(f, 1, f->tables[1], f->bytes), USB_OK);
}

static void bank_of_another_slot_is_not_mounted(void **state)
{
    struct fixture *f = *state;
    push(f, 1, f->tables[0], f->bytes);
    memcpy(bank(f, 2, 0), bank(f, 1, 0), FIXTURE_BANK);
    restart(f);
    assert_int_equal(live(f, 1), 0);
    assert_int_equal(live(f, 2), -1);
}

/* Written by a firmware that knew other content: everything fits, but this one cannot read it. */
static void content_that_does_not_open_is_not_mounted(void **state)
{
    struct fixture *f = *state;
    push(f, 1, f->tables[0], f->bytes);
    push(f, 1, f->tables[1], f->bytes);
    struct table_store_header h;
    uint8_t *b = bank(f, 1, 1);
    memcpy(&h, b, sizeof h);
    b[256] ^= 1;
    h.crc = crc32_update(0, b + 256, f->bytes);
    h.header_crc = crc32_update(0, &h, 28);
    memcpy(b, &h, sizeof h);
    restart(f);
    assert_int_equal(live(f, 1), 0);
    b[256] ^= 1;
    h.crc = crc32_update(0, b + 256, f->bytes);
    h.version++; /* nor is a bank of another layout */
    h.header_crc = crc32_update(0, &h, 28);
    memcpy(b, &h, sizeof h);
    restart(f);
    assert_int_equal(live(f, 1), 0);
    h.version--;
    h.slot = 2; /* nor one that says it reaches past its bank, here the flash's last */
    h.length = 0x40000000;
    h.header_crc = crc32_update(0, &h, 28);
    memcpy(bank(f, 2, 1), &h, sizeof h);
    restart(f);
    assert_int_equal(live(f, 2), -1);
}

static void damaged_upload_is_refused(void **state)
{
    struct fixture *f = *state;
    uint8_t *damaged = malloc(f->bytes);
    push(f, 1, f->tables[0], f->bytes);
    memcpy(damaged, f->tables[1], f->bytes);
    begin(f, 1, USB_SLOT_TABLE, f->tables[1], f->bytes);
    assert_int_equal(write_next(f, damaged, 300).status, USB_OK);
    struct table_store_result refused =
        table_store_write(&f->store, damaged + 300, 100, crc32_update(0, damaged + 300, 100));
    assert_int_equal(refused.status, USB_ERR_DAMAGED);
    assert_int_equal(refused.detail, 300);
    assert_int_equal(finish(f, damaged + 300, f->bytes - 300).status, USB_OK); /* and goes on */
    assert_int_equal(live(f, 1), 1);
    push(f, 1, f->tables[0], f->bytes);
    damaged[f->bytes - 1] ^= 0x80;
    begin(f, 1, USB_SLOT_TABLE, f->tables[1], f->bytes);
    struct table_store_result r = finish(f, damaged, f->bytes);
    assert_int_equal(r.status, USB_ERR_CRC);
    assert_int_equal(r.detail, crc32_update(0, damaged, f->bytes));
    damaged[0] ^= 1; /* the CRC fits, but it is no table */
    begin(f, 1, USB_SLOT_TABLE, damaged, f->bytes);
    r = finish(f, damaged, f->bytes);
    assert_int_equal(r.status, USB_ERR_CONTENT);
    assert_int_equal(r.detail, LUT_ERR_IDENTIFIER);
    assert_int_equal(live(f, 1), 0);
    restart(f);
    assert_int_equal(live(f, 1), 0);
    free(damaged);
}

/* Any length in pieces of any size arrives whole: the CRC fits and only the content is refused. */
static void any_length_in_any_pieces_is_stored(void **state)
{
    struct fixture *f = *state;
    static uint8_t data[FIXTURE_CAPACITY];
    for (size_t i = 0; i < sizeof data; i++)
        data[i] = (uint8_t)random32();
    for (uint32_t n = 0; n < 300; n++) {
        uint32_t length = n < 3 ? FIXTURE_CAPACITY - n : n < 20 ? n - 2 : 1 + random32() % FIXTURE_CAPACITY, at = 0;
        assert_int_equal(begin(f, 1, USB_SLOT_TABLE, data, length).status, USB_OK);
        while (at < length) {
            uint32_t piece = 1 + random32() % (n % 2 ? 1000 : 9000);
            piece = piece < length - at ? piece : length - at;
            struct table_store_result r = write_next(f, data + at, piece);
            assert_int_equal(r.status, USB_OK);
            at += piece;
            assert_int_equal(r.detail, at);
        }
        assert_int_equal(table_store_commit(&f->store).status, USB_ERR_CONTENT);
        assert_memory_equal(bank(f, 1, 0) + 256, data, length);
    }
}

static void blocks_are_erased_as_the_data_arrives(void **state)
{
    struct fixture *f = *state;
    static uint8_t data[FIXTURE_CAPACITY];
    memset(bank(f, 1, 0), 0x11, FIXTURE_BANK);
    begin(f, 1, USB_SLOT_TABLE, data, sizeof data);
    assert_int_equal(bank(f, 1, 0)[SIM_FLASH_BLOCK - 1], 0xff);
    assert_int_equal(bank(f, 1, 0)[SIM_FLASH_BLOCK], 0x11);
    write_next(f, data, SIM_FLASH_BLOCK);
    assert_int_equal(bank(f, 1, 0)[2 * SIM_FLASH_BLOCK - 1], 0xff);
    assert_int_equal(bank(f, 1, 0)[2 * SIM_FLASH_BLOCK], 0x11);
}

static void begin_refuses_what_cannot_be_stored(void **state)
{
    struct fixture *f = *state;
    push(f, 1, f->tables[0], f->bytes);
    assert_int_equal(begin(f, SLOTS, USB_SLOT_TABLE, "", 1).status, USB_ERR_SLOT);
    assert_int_equal(begin(f, 0, USB_SLOT_TABLE, "", 1).status, USB_ERR_VALUE);
    assert_int_equal(begin(f, 1, USB_SLOT_SCENE, "", 1).status, USB_ERR_VALUE);
    assert_int_equal(begin(f, 1, USB_SLOT_EMPTY, "", 1).status, USB_ERR_VALUE);
    assert_int_equal(begin(f, 1, USB_SLOT_TABLE, "", 0).status, USB_ERR_VALUE);
    struct usb_begin b = {1, USB_SLOT_TABLE, FIXTURE_CAPACITY + 1, 0};
    struct table_store_result r = table_store_begin(&f->store, &b);
    assert_int_equal(r.status, USB_ERR_TOO_LARGE);
    assert_int_equal(r.detail, FIXTURE_CAPACITY);
    sim_forbid_writing(f->board, true);
    assert_int_equal(push(f, 1, f->tables[1], f->bytes), USB_ERR_FORBIDDEN);
    sim_forbid_writing(f->board, false);
    begin(f, 1, USB_SLOT_TABLE, f->tables[1], f->bytes);
    sim_forbid_writing(f->board, true); /* pulled in mid-upload */
    assert_int_equal(finish(f, f->tables[1], f->bytes).status, USB_ERR_FORBIDDEN);
    assert_int_equal(live(f, 1), 0);
}

static void flash_too_small_for_the_slots_is_refused(void **state)
{
    struct fixture *f = *state;
    struct hal hal = *sim_hal(f->board);
    struct table_store s;
    hal.flash_bytes = BANKS * SIM_FLASH_BLOCK;
    assert_true(table_store_init(&s, &hal, SLOTS, 0));
    assert_int_equal(table_store_capacity(&s, 0), SIM_FLASH_BLOCK - 256);
    assert_int_equal(table_store_capacity(&s, 2), SIM_FLASH_BLOCK - 256);
    assert_false(table_store_init(&s, &hal, SLOTS + 1, 0));
    assert_false(table_store_init(&s, &hal, SLOTS, 2 * SIM_FLASH_BLOCK));
    assert_false(table_store_init(&s, &hal, SLOTS, 100));
    assert_false(table_store_init(&s, &hal, SLOTS, 0x80001000));
    hal.flash_block_bytes = 256; /* a bank of one such block would have no room */
    hal.flash_bytes = BANKS * 256;
    assert_false(table_store_init(&s, &hal, SLOTS, 0));
    hal.flash_bytes = 2 * BANKS * 256;
    assert_true(table_store_init(&s, &hal, SLOTS, 0));
}

/* AT45 flash has pages of 264 and 1056 bytes, for one. */
static void blocks_that_are_no_power_of_two_or_below_256_bytes_are_refused(void **state)
{
    struct fixture *f = *state;
    static const uint32_t blocks[] = {1, 128, 255, 264, 1056, 3000};
    struct hal hal = *sim_hal(f->board);
    struct table_store s;
    for (size_t i = 0; i < sizeof blocks / sizeof *blocks; i++) {
        hal.flash_block_bytes = blocks[i];
        assert_false(table_store_init(&s, &hal, SLOTS, 0));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(committed_table_is_live_and_survives_a_restart, setup, teardown),
        cmocka_unit_test_setup_teardown(header_is_as_specified, setup, teardown),
        cmocka_unit_test_setup_teardown(upload_without_commit_leaves_the_old_table, setup, teardown),
        cmocka_unit_test_setup_teardown(failure_at_any_operation_leaves_one_whole_table, setup, teardown),
        cmocka_unit_test_setup_teardown(flipped_bit_in_the_live_bank_falls_back_to_the_older_one, setup, teardown),
        cmocka_unit_test_setup_teardown(torn_header_is_scrubbed, setup, teardown),
        cmocka_unit_test_setup_teardown(torn_headers_stay_while_nothing_is_live, setup, teardown),
        cmocka_unit_test_setup_teardown(erasures_are_counted_and_survive, setup, teardown),
        cmocka_unit_test_setup_teardown(upload_goes_on_after_a_restart, setup, teardown),
        cmocka_unit_test_setup_teardown(bank_whose_erasure_was_cut_off_is_no_upload, setup, teardown),
        cmocka_unit_test_setup_teardown(later_push_supersedes_a_bank_that_was_damaged_for_a_while, setup, teardown),
        cmocka_unit_test_setup_teardown(words_that_do_not_stick_are_noticed, setup, teardown),
        cmocka_unit_test_setup_teardown(bank_of_another_slot_is_not_mounted, setup, teardown),
        cmocka_unit_test_setup_teardown(content_that_does_not_open_is_not_mounted, setup, teardown),
        cmocka_unit_test_setup_teardown(damaged_upload_is_refused, setup, teardown),
        cmocka_unit_test_setup_teardown(any_length_in_any_pieces_is_stored, setup, teardown),
        cmocka_unit_test_setup_teardown(blocks_are_erased_as_the_data_arrives, setup, teardown),
        cmocka_unit_test_setup_teardown(begin_refuses_what_cannot_be_stored, setup, teardown),
        cmocka_unit_test_setup_teardown(flash_too_small_for_the_slots_is_refused, setup, teardown),
        cmocka_unit_test_setup_teardown(blocks_that_are_no_power_of_two_or_below_256_bytes_are_refused, setup,
                                        teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
