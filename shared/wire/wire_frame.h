/* A frame carries one message over any pipe of bytes.
 *
 *   frame  = COBS(body) 0x00
 *   body   = sequence u16 | answers u16 | type u16 | length u16 | payload (length bytes) | CRC-32 u32
 *
 * The frame's CRC covers all bytes before the CRC. The field `sequence` counts the sender's frames. The field
 * `answers` repeats, in a reply, the sequence of the request, and is 0 in a message without a request. The
 * COBS encoding leaves no zero inside a frame, so a receiver that has lost synchronisation finds the next
 * frame after the next zero byte. The frame decoder accepts bytes in pieces of any size. The frame decoder
 * never writes outside its buffer, and counts dropped frames by cause.
 *
 * C11 and C++20. */
#ifndef CRN_WIRE_FRAME_H
#define CRN_WIRE_FRAME_H

#include "shared/wire/wire.h"

#ifdef __cplusplus
extern "C" {
#endif

enum {
    CRN_WIRE_HEADER_BYTES = 8,
    CRN_WIRE_CRC_BYTES = 4,
    CRN_WIRE_BODY_MAX = CRN_WIRE_HEADER_BYTES + CRN_WIRE_PAYLOAD_MAX + CRN_WIRE_CRC_BYTES,
    /* The COBS encoding adds one byte for each full or partial block of 254 bytes, and a zero byte ends the
     * frame. */
    CRN_WIRE_FRAME_MAX = CRN_WIRE_BODY_MAX + CRN_WIRE_BODY_MAX / 254 + 2,
};

typedef struct crn_wire_header {
    uint16_t sequence;
    uint16_t answers;
    uint16_t type;
} crn_wire_header;

/* Returns the CRC-32 of IEEE 802.3 (reflected 0xEDB88320, start and end inverted). `crc` is 0 in the first
 * call; in later calls it is the result for all bytes so far. */
uint32_t crn_wire_crc32(uint32_t crc, const uint8_t *bytes, size_t length);

/* Makes one frame from a header and a payload. Returns the number of bytes written to `frame` (including the
 * zero at its end), or 0 when the payload exceeds CRN_WIRE_PAYLOAD_MAX or the frame exceeds `capacity`. */
size_t crn_wire_frame_encode(const crn_wire_header *header, const uint8_t *payload, size_t payload_bytes,
                             uint8_t *frame, size_t capacity);

typedef enum crn_wire_event {
    CRN_WIRE_NEED_MORE = 0, /* no frame yet */
    CRN_WIRE_FRAME,         /* header and payload of the decoder are valid until the next byte */
    CRN_WIRE_BAD_COBS,      /* a code byte points past the frame's end */
    CRN_WIRE_BAD_SIZE,      /* longer than any frame, or shorter than a header and CRC */
    CRN_WIRE_BAD_CRC,
    CRN_WIRE_BAD_LENGTH, /* the length field differs from the bytes received */
    CRN_WIRE_EVENT_COUNT,
} crn_wire_event;

typedef struct crn_wire_decoder {
    crn_wire_header header;
    const uint8_t *payload;
    size_t payload_bytes;
    uint32_t event_counts[CRN_WIRE_EVENT_COUNT]; /* frames by outcome since the start */
    /* private */
    size_t body_bytes;
    uint8_t block_left; /* bytes until the next COBS code byte */
    bool block_full;    /* the present block has 254 bytes: no zero follows it */
    bool started;
    bool too_long;
    uint8_t body[CRN_WIRE_BODY_MAX];
} crn_wire_decoder;

void crn_wire_decoder_init(crn_wire_decoder *decoder);

/* Take one byte. */
crn_wire_event crn_wire_decoder_push(crn_wire_decoder *decoder, uint8_t byte);

/* Takes bytes as crn_wire_decoder_push() does, until the first that ends a frame, whole or broken, or until
 * all are taken. `taken` receives how many bytes were taken. */
crn_wire_event crn_wire_decoder_take(crn_wire_decoder *decoder, const uint8_t *bytes, size_t count,
                                     size_t *taken);

#ifdef __cplusplus
}
#endif

#endif
