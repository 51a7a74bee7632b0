/* This header has the HID reports as structs and codecs, made from hid_reports.def.
 *
 *   crn_hid_<name>          the struct of a record or report
 *   CRN_HID_ID_<name>       the report's id
 *   CRN_HID_BYTES_<name>    its size without the id
 *   crn_hid_put_<name>      append to a writer, without the id; false when it does not fit
 *   crn_hid_decode_<name>   read the bytes behind the id; false when some are missing. More are allowed and
 *                           ignored: some hosts pad a report to the longest of its kind
 *
 * C11 and C++20.
 */
#ifndef CRN_HID_H
#define CRN_HID_H

#include "shared/wire/wire_bytes.h"

#ifdef __cplusplus
extern "C" {
#endif

/* clang-format off */
typedef uint8_t crn_hid_u8;
typedef uint16_t crn_hid_u16;
typedef uint32_t crn_hid_u32;
typedef uint64_t crn_hid_u64;
typedef int16_t crn_hid_i16;
typedef int32_t crn_hid_i32;

enum {
    CRN_HID_BYTES_u8 = 1,
    CRN_HID_BYTES_u16 = 2,
    CRN_HID_BYTES_u32 = 4,
    CRN_HID_BYTES_u64 = 8,
    CRN_HID_BYTES_i16 = 2,
    CRN_HID_BYTES_i32 = 4,
};

/* The structs. */
#define HID_RECORD(name, text) typedef struct crn_hid_##name {
#define HID_REPORT(name, id, kind, text) typedef struct crn_hid_##name {
#define HID_FIELD(owner, type, name, unit, text) crn_hid_##type name;
#define HID_ARRAY(owner, type, name, count, unit, text) crn_hid_##type name[count];
#define HID_END(owner) } crn_hid_##owner;
#include "shared/wire/hid_reports.def"

/* Sizes in bytes. */
#define HID_RECORD(name, text) enum { CRN_HID_BYTES_##name = 0
#define HID_REPORT(name, id, kind, text) enum { CRN_HID_BYTES_##name = 0
#define HID_FIELD(owner, type, name, unit, text) + (int)CRN_HID_BYTES_##type
#define HID_ARRAY(owner, type, name, count, unit, text) + (count) * (int)CRN_HID_BYTES_##type
#define HID_END(owner) };
#include "shared/wire/hid_reports.def"

/* Ids. */
#define HID_REPORT(name, id, kind, text) CRN_HID_ID_##name = id,
enum {
#include "shared/wire/hid_reports.def"
};

/* Codecs. */
#define HID_REPORT(name, id, kind, text) \
    bool crn_hid_put_##name(crn_wire_writer *writer, const crn_hid_##name *value); \
    bool crn_hid_decode_##name(const uint8_t *bytes, size_t length, crn_hid_##name *value);
#include "shared/wire/hid_reports.def"

/* The report descriptor has one vendor-defined collection, in which every report is an array of bytes. */
enum {
    CRN_HID_REPORT_BYTES_MAX = 64, /* with the id: one packet at both speeds */
    CRN_HID_DESCRIPTOR_HEAD_BYTES = 14,
    CRN_HID_DESCRIPTOR_ITEM_BYTES = 8, /* of each report */
    CRN_HID_DESCRIPTOR_BYTES = CRN_HID_DESCRIPTOR_HEAD_BYTES + 1
#define HID_REPORT(name, id, kind, text) + CRN_HID_DESCRIPTOR_ITEM_BYTES
#include "shared/wire/hid_reports.def"
};
/* clang-format on */
extern const uint8_t crn_hid_descriptor[CRN_HID_DESCRIPTOR_BYTES];

/* Returns a hash over every name, id, type and unit of hid_reports.def. */
uint64_t crn_hid_report_hash(void);

#ifdef __cplusplus
}
#endif

#endif
