/* This fuzz target gives arbitrary bytes to the frame decoder, and every payload to every message decoder. No
 * decoder may read or write outside its buffers, and a decoded message must encode to the same bytes again.
 */
#include <stdlib.h>
#include <string.h>

#include "shared/wire/wire_frame.h"

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t count);
size_t fuzz_seed(unsigned index, uint8_t *bytes, size_t capacity);

static uint8_t again[CRN_WIRE_PAYLOAD_MAX];

/* For every message that the encoder or the decoder accepts, decoding the encoded message must give the same
 * message, and encoding the decoded message must give the same bytes. */
static void check_message(uint16_t type, const uint8_t *payload, size_t length)
{
    crn_wire_writer writer = crn_wire_writer_make(again, sizeof again);
    switch (type) {
#define MESSAGE(name, number, direction, text)                                                               \
    case number: {                                                                                           \
        static crn_wire_##name value;                                                                        \
        if (!crn_wire_decode_##name(payload, length, &value)) break;                                         \
        if (!crn_wire_put_##name(&writer, &value)) abort();                                                  \
        if (writer.length != length || memcmp(again, payload, length) != 0) abort();                         \
        break;                                                                                               \
    }
#include "shared/wire/wire_messages.def"
    default:
        break;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t count)
{
    static crn_wire_decoder decoder;
    crn_wire_decoder_init(&decoder);
    for (size_t i = 0; i < count; i++) {
        if (crn_wire_decoder_push(&decoder, bytes[i]) != CRN_WIRE_FRAME) continue;
        check_message(decoder.header.type, decoder.payload, decoder.payload_bytes);
    }
    if (count > 0) check_message(bytes[0], bytes + 1, count - 1);
    return 0;
}

size_t fuzz_seed(unsigned index, uint8_t *bytes, size_t capacity)
{
    static const uint16_t types[] = {
#define MESSAGE(name, number, direction, text) number,
#include "shared/wire/wire_messages.def"
    };
    static const uint8_t payload[80] = {1, 0, 2, 0, 3};
    if (index >= 2 * sizeof types / sizeof types[0]) return 0;
    uint16_t type = types[index / 2];
    if (index % 2 == 0) {
        bytes[0] = (uint8_t)type;
        memset(bytes + 1, 0, 12);
        return 13;
    }
    const crn_wire_header header = {1, 0, type};
    return crn_wire_frame_encode(&header, payload, sizeof payload, bytes, capacity);
}
