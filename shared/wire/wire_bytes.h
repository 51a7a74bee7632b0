/* This header has functions that read and write little-endian values within the limits of a buffer. A writer
 * whose buffer is full and a reader that has no more bytes stop permanently and report the error; they never
 * touch a byte outside their buffers. */
#ifndef CRN_WIRE_BYTES_H
#define CRN_WIRE_BYTES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct crn_wire_writer {
    uint8_t *bytes;
    size_t capacity;
    size_t length;
    bool overflowed; /* something did not fit; `length` counts only what did */
} crn_wire_writer;

typedef struct crn_wire_reader {
    const uint8_t *bytes;
    size_t length;
    size_t position;
    bool failed; /* something was missing or out of range; values read since are 0 */
} crn_wire_reader;

static inline crn_wire_writer crn_wire_writer_make(uint8_t *bytes, size_t capacity)
{
    crn_wire_writer writer = {bytes, capacity, 0, false};
    return writer;
}

static inline crn_wire_reader crn_wire_reader_make(const uint8_t *bytes, size_t length)
{
    crn_wire_reader reader = {bytes, length, 0, false};
    return reader;
}

/* Writes a 32-bit value by four stores, which a compiler merges into one. */
static inline void crn_wire_put_u32_at(uint8_t *to, uint32_t value)
{
    to[0] = (uint8_t)value;
    to[1] = (uint8_t)(value >> 8);
    to[2] = (uint8_t)(value >> 16);
    to[3] = (uint8_t)(value >> 24);
}

/* Writes the low `count` bytes (1 .. 8) of `value`. A value of four bytes is the most common case and needs
 * no loop. */
static inline void crn_wire_write(crn_wire_writer *writer, uint64_t value, unsigned count)
{
    if (writer->overflowed || writer->capacity - writer->length < count) {
        writer->overflowed = true;
        return;
    }
    uint8_t *to = writer->bytes + writer->length;
    writer->length += count;
    if (count == 4) {
        crn_wire_put_u32_at(to, (uint32_t)value);
        return;
    }
    for (unsigned i = 0; i < count; i++) to[i] = (uint8_t)(value >> (8 * i));
}

/* Reads a value of `count` bytes (1 .. 8); returns 0 when the buffer has too few bytes. */
static inline uint64_t crn_wire_read(crn_wire_reader *reader, unsigned count)
{
    if (reader->failed || reader->length - reader->position < count) {
        reader->failed = true;
        return 0;
    }
    uint64_t value = 0;
    for (unsigned i = 0; i < count; i++) value |= (uint64_t)reader->bytes[reader->position++] << (8 * i);
    return value;
}

/* Returns the signed value of a 32-bit number in two's complement, without a cast whose result the C standard
 * leaves to the compiler. */
static inline int32_t crn_wire_i32_from_u32(uint32_t value)
{
    return value <= (uint32_t)INT32_MAX ? (int32_t)value : -(int32_t)(UINT32_MAX - value) - 1;
}

#endif
