/* This file has the codecs of every record and message, made from wire_messages.def. */
#include "shared/wire/wire.h"

/* --- plain values --- */
#define PLAIN(type, bytes)                                                                                   \
    static bool crn_wire_put_##type(crn_wire_writer *writer, const crn_wire_##type *value)                   \
    {                                                                                                        \
        crn_wire_write(writer, *value, bytes);                                                               \
        return !writer->overflowed;                                                                          \
    }                                                                                                        \
    static bool crn_wire_get_##type(crn_wire_reader *reader, crn_wire_##type *value)                         \
    {                                                                                                        \
        *value = (crn_wire_##type)crn_wire_read(reader, bytes);                                              \
        return !reader->failed;                                                                              \
    }
PLAIN(u8, 1)
PLAIN(u16, 2)
PLAIN(u32, 4)
PLAIN(u64, 8)

static bool crn_wire_put_i16(crn_wire_writer *writer, const int16_t *value)
{
    crn_wire_write(writer, (uint16_t)*value, 2);
    return !writer->overflowed;
}

static bool crn_wire_get_i16(crn_wire_reader *reader, int16_t *value)
{
    const int32_t bits = (int32_t)crn_wire_read(reader, 2);
    *value = (int16_t)(bits <= INT16_MAX ? bits : bits - 65536);
    return !reader->failed;
}

static bool crn_wire_put_i32(crn_wire_writer *writer, const int32_t *value)
{
    crn_wire_write(writer, (uint32_t)*value, 4);
    return !writer->overflowed;
}

static bool crn_wire_get_i32(crn_wire_reader *reader, int32_t *value)
{
    *value = crn_wire_i32_from_u32((uint32_t)crn_wire_read(reader, 4));
    return !reader->failed;
}

/* --- counts and kinds --- */
static uint16_t put_count(crn_wire_writer *writer, uint16_t count, uint16_t max, unsigned bytes)
{
    if (count > max) {
        writer->overflowed = true;
        return 0;
    }
    crn_wire_write(writer, count, bytes);
    return count;
}

static uint16_t get_count(crn_wire_reader *reader, uint16_t max, unsigned bytes)
{
    uint16_t count = (uint16_t)crn_wire_read(reader, bytes);
    if (count > max) reader->failed = true;
    return reader->failed ? 0 : count;
}

static bool put_unknown_kind(crn_wire_writer *writer)
{
    writer->overflowed = true;
    return false;
}

static bool get_unknown_kind(crn_wire_reader *reader)
{
    reader->failed = true;
    return false;
}

/* --- records, choices and messages --- */
/* clang-format off */
#define RECORD(name, text) \
    bool crn_wire_put_##name(crn_wire_writer *writer, const crn_wire_##name *value) {
#define MESSAGE(name, type, direction, text) RECORD(name, text)
#define FIELD(owner, type, name, unit, text) crn_wire_put_##type(writer, &value->name);
#define PUT_ALL(type, name, max, bytes) \
    for (uint16_t i = 0, count = put_count(writer, value->name##_count, max, bytes); i < count; i++) \
        crn_wire_put_##type(writer, &value->name[i]);
#define ARRAY(owner, type, name, max, unit, text) PUT_ALL(type, name, max, 2)
#define LIST(owner, type, name, max, unit, text) PUT_ALL(type, name, max, 1)
#define END(owner) return !writer->overflowed; }
#define CHOICE(name, text) \
    bool crn_wire_put_##name(crn_wire_writer *writer, const crn_wire_##name *value) { \
        crn_wire_put_u8(writer, &value->kind); \
        switch (value->kind) {
#define OPTION(choice, record, number, text) \
        case number: return crn_wire_put_##record(writer, &value->record);
#define CHOICE_END(choice) default: return put_unknown_kind(writer); } }
#include "shared/wire/wire_messages.def"

#define RECORD(name, text) \
    bool crn_wire_get_##name(crn_wire_reader *reader, crn_wire_##name *value) {
#define MESSAGE(name, type, direction, text) RECORD(name, text)
#define FIELD(owner, type, name, unit, text) crn_wire_get_##type(reader, &value->name);
#define GET_ALL(type, name, max, bytes) \
    value->name##_count = get_count(reader, max, bytes); \
    for (uint16_t i = 0; i < value->name##_count; i++) crn_wire_get_##type(reader, &value->name[i]);
#define ARRAY(owner, type, name, max, unit, text) GET_ALL(type, name, max, 2)
#define LIST(owner, type, name, max, unit, text) GET_ALL(type, name, max, 1)
#define END(owner) return !reader->failed; }
#define CHOICE(name, text) \
    bool crn_wire_get_##name(crn_wire_reader *reader, crn_wire_##name *value) { \
        crn_wire_get_u8(reader, &value->kind); \
        switch (value->kind) {
#define OPTION(choice, record, number, text) \
        case number: return crn_wire_get_##record(reader, &value->record);
#define CHOICE_END(choice) default: return get_unknown_kind(reader); } }
#include "shared/wire/wire_messages.def"

#define MESSAGE(name, type, direction, text) \
    bool crn_wire_decode_##name(const uint8_t *payload, size_t length, crn_wire_##name *value) \
    { \
        crn_wire_reader reader = crn_wire_reader_make(payload, length); \
        return crn_wire_get_##name(&reader, value) && reader.position == length; \
    }
#include "shared/wire/wire_messages.def"
