/* This file has the codecs, the report descriptor and the hash of the HID reports, made from
 * hid_reports.def. */
#include "shared/wire/hid.h"

/* --- plain values --- */
#define PLAIN(type, bytes)                                                                                   \
    static void put_##type(crn_wire_writer *writer, const crn_hid_##type *value)                             \
    {                                                                                                        \
        crn_wire_write(writer, (uint64_t)*value, bytes);                                                     \
    }
PLAIN(u8, 1)
PLAIN(u16, 2)
PLAIN(u32, 4)
PLAIN(u64, 8)
PLAIN(i16, 2)
PLAIN(i32, 4)

#define UNSIGNED(type, bytes)                                                                                \
    static void get_##type(crn_wire_reader *reader, crn_hid_##type *value)                                   \
    {                                                                                                        \
        *value = (crn_hid_##type)crn_wire_read(reader, bytes);                                               \
    }
UNSIGNED(u8, 1)
UNSIGNED(u16, 2)
UNSIGNED(u32, 4)
UNSIGNED(u64, 8)

static void get_i16(crn_wire_reader *reader, int16_t *value)
{
    uint32_t word = (uint32_t)crn_wire_read(reader, 2);
    *value = (int16_t)(word < 0x8000u ? (int32_t)word : (int32_t)word - 0x10000);
}

static void get_i32(crn_wire_reader *reader, int32_t *value)
{
    *value = crn_wire_i32_from_u32((uint32_t)crn_wire_read(reader, 4));
}

/* --- records and reports --- */
/* clang-format off */
#define HID_RECORD(name, text) static void put_##name(crn_wire_writer *writer, const crn_hid_##name *value) {
#define HID_REPORT(name, id, kind, text) HID_RECORD(name, text)
#define HID_FIELD(owner, type, name, unit, text) put_##type(writer, &value->name);
#define HID_ARRAY(owner, type, name, count, unit, text) \
    for (int i = 0; i < (count); i++) put_##type(writer, &value->name[i]);
#define HID_END(owner) }
#include "shared/wire/hid_reports.def"

#define HID_RECORD(name, text) static void get_##name(crn_wire_reader *reader, crn_hid_##name *value) {
#define HID_REPORT(name, id, kind, text) HID_RECORD(name, text)
#define HID_FIELD(owner, type, name, unit, text) get_##type(reader, &value->name);
#define HID_ARRAY(owner, type, name, count, unit, text) \
    for (int i = 0; i < (count); i++) get_##type(reader, &value->name[i]);
#define HID_END(owner) }
#include "shared/wire/hid_reports.def"

#define HID_REPORT(name, id, kind, text) \
    bool crn_hid_put_##name(crn_wire_writer *writer, const crn_hid_##name *value) \
    { \
        put_##name(writer, value); \
        return !writer->overflowed; \
    } \
    bool crn_hid_decode_##name(const uint8_t *bytes, size_t length, crn_hid_##name *value) \
    { \
        crn_wire_reader reader = crn_wire_reader_make(bytes, length); \
        get_##name(&reader, value); \
        return !reader.failed; \
    }
#include "shared/wire/hid_reports.def"

/* --- the report descriptor: items of HID 1.11, 6.2.2; the byte is tag, type and size of the data --- */
enum {
    INPUT = 0x81, OUTPUT = 0x91, FEATURE = 0xb1, /* main items; 0x02: data, variable, absolute */
};

const uint8_t crn_hid_descriptor[CRN_HID_DESCRIPTOR_BYTES] = {
    0x06, 0x00, 0xff, /* usage page: vendor-defined 0xff00 */
    0x09, 0x01,       /* usage 1 */
    0xa1, 0x01,       /* collection: application */
    0x15, 0x00,       /* logical minimum 0 */
    0x26, 0xff, 0x00, /* logical maximum 255 */
    0x75, 0x08,       /* report size: 8 bits */
#define HID_REPORT(name, id, kind, text) \
    0x85, id, 0x09, id, 0x95, CRN_HID_BYTES_##name, kind, 0x02, /* report id, usage, report count, main */
#include "shared/wire/hid_reports.def"
    0xc0, /* end collection */
};

#define HID_REPORT(name, id, kind, text) \
    _Static_assert(CRN_HID_BYTES_##name < 256, "the report count of " #name " fits one byte"); \
    _Static_assert(kind == FEATURE || 1 + CRN_HID_BYTES_##name <= CRN_HID_REPORT_BYTES_MAX, #name " fits one packet");
#include "shared/wire/hid_reports.def"
/* clang-format on */

/* --- the hash: FNV-1a over each text and its terminating zero --- */
static uint64_t hash_text(uint64_t hash, const char *text)
{
    do {
        hash = (hash ^ (uint8_t)*text) * 0x100000001b3u;
    } while (*text++ != '\0');
    return hash;
}

uint64_t crn_hid_report_hash(void)
{
    uint64_t hash = 0xcbf29ce484222325u;
    /* clang-format off */
#define TEXT(text) hash = hash_text(hash, text);
#define HID_RECORD(name, text) TEXT("record") TEXT(#name)
#define HID_REPORT(name, id, kind, text) TEXT("report") TEXT(#name) TEXT(#id) TEXT(#kind)
#define HID_FIELD(owner, type, name, unit, text) TEXT("field") TEXT(#type) TEXT(#name) TEXT(unit)
#define HID_ARRAY(owner, type, name, count, unit, text) TEXT("array") TEXT(#type) TEXT(#name) TEXT(#count) TEXT(unit)
#define HID_END(owner) TEXT("end")
#include "shared/wire/hid_reports.def"
#undef TEXT
    /* clang-format on */
    return hash;
}
