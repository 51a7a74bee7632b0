/* CRC-32, COBS and frames. */
#include "shared/wire/wire_frame.h"

/* Table k has the CRC remainder of each byte value that k zero bytes follow, for the polynomial 0xedb88320. A
 * CRC is linear, so the remainder of a byte is the exclusive or of the remainders of its bits, which TABLE
 * takes. A table takes 1 kB of flash; with a table of only 16 entries, each byte would take four more
 * instructions. */
#define BIT(i, bit, rest) ((((i) >> (bit)) & 1u) * (rest))
#define OF(i, b0, b1, b2, b3, b4, b5, b6, b7)                                                                \
    (BIT(i, 0, b0) ^ BIT(i, 1, b1) ^ BIT(i, 2, b2) ^ BIT(i, 3, b3) ^ BIT(i, 4, b4) ^ BIT(i, 5, b5) ^         \
     BIT(i, 6, b6) ^ BIT(i, 7, b7))
#define OF_4(i, ...)                                                                                         \
    OF((i), __VA_ARGS__), OF((i) + 1u, __VA_ARGS__), OF((i) + 2u, __VA_ARGS__), OF((i) + 3u, __VA_ARGS__)
#define OF_16(i, ...)                                                                                        \
    OF_4((i), __VA_ARGS__), OF_4((i) + 4u, __VA_ARGS__), OF_4((i) + 8u, __VA_ARGS__),                        \
        OF_4((i) + 12u, __VA_ARGS__)
#define OF_64(i, ...)                                                                                        \
    OF_16((i), __VA_ARGS__), OF_16((i) + 16u, __VA_ARGS__), OF_16((i) + 32u, __VA_ARGS__),                   \
        OF_16((i) + 48u, __VA_ARGS__)
#define TABLE(...)                                                                                           \
    {                                                                                                        \
        OF_64(0u, __VA_ARGS__), OF_64(64u, __VA_ARGS__), OF_64(128u, __VA_ARGS__), OF_64(192u, __VA_ARGS__)  \
    }

/* A host takes eight bytes at a time, one from each of eight tables. A board takes one byte at a time and
 * saves 7 kB of its flash. */
#if UINTPTR_MAX > UINT32_MAX
enum { CRC_TABLES = 8 };
#else
enum { CRC_TABLES = 1 };
#endif
static const uint32_t crc_of[CRC_TABLES][256] = {
    TABLE(0x77073096u, 0xee0e612cu, 0x076dc419u, 0x0edb8832u, 0x1db71064u, 0x3b6e20c8u, 0x76dc4190u,
          0xedb88320u),
#if UINTPTR_MAX > UINT32_MAX
    TABLE(0x191b3141u, 0x32366282u, 0x646cc504u, 0xc8d98a08u, 0x4ac21251u, 0x958424a2u, 0xf0794f05u,
          0x3b83984bu),
    TABLE(0x01c26a37u, 0x0384d46eu, 0x0709a8dcu, 0x0e1351b8u, 0x1c26a370u, 0x384d46e0u, 0x709a8dc0u,
          0xe1351b80u),
    TABLE(0xb8bc6765u, 0xaa09c88bu, 0x8f629757u, 0xc5b428efu, 0x5019579fu, 0xa032af3eu, 0x9b14583du,
          0xed59b63bu),
    TABLE(0x3d6029b0u, 0x7ac05360u, 0xf580a6c0u, 0x30704bc1u, 0x60e09782u, 0xc1c12f04u, 0x58f35849u,
          0xb1e6b092u),
    TABLE(0xcb5cd3a5u, 0x4dc8a10bu, 0x9b914216u, 0xec53826du, 0x03d6029bu, 0x07ac0536u, 0x0f580a6cu,
          0x1eb014d8u),
    TABLE(0xa6770bb4u, 0x979f1129u, 0xf44f2413u, 0x33ef4e67u, 0x67de9cceu, 0xcfbd399cu, 0x440b7579u,
          0x8816eaf2u),
    TABLE(0xccaa009eu, 0x4225077du, 0x844a0efau, 0xd3e51bb5u, 0x7cbb312bu, 0xf9766256u, 0x299dc2edu,
          0x533b85dau),
#endif
};

static uint32_t word_at(const uint8_t *b)
{
    return (uint32_t)b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

uint32_t crn_wire_crc32(uint32_t crc, const uint8_t *bytes, size_t length)
{
    crc = ~crc;
    for (; CRC_TABLES == 8 && length >= 8; bytes += 8, length -= 8) {
        const uint32_t low = crc ^ word_at(bytes), high = word_at(bytes + 4);
        crc = 0;
        for (int k = 0; k < 4; k++) {
            crc ^= crc_of[(7 - k) % CRC_TABLES][low >> (8 * k) & 255u];
            crc ^= crc_of[(3 - k) % CRC_TABLES][high >> (8 * k) & 255u];
        }
    }
    for (size_t i = 0; i < length; i++) crc = (crc >> 8) ^ crc_of[0][(crc ^ bytes[i]) & 255u];
    return ~crc;
}

/* --- encoding --- */
enum { COBS_BLOCK_BYTES = 255 }; /* of a full block, with its code */

typedef struct cobs_writer {
    uint8_t *bytes;
    size_t length;
    size_t code_position; /* where the present block's code byte goes */
} cobs_writer;

/* With each byte, the code byte receives the length that the block has so far. Zeros come irregularly, so a
 * branch that writes the code byte only at a zero would cost more than these writes. */
static void cobs_put_all(cobs_writer *writer, const uint8_t *bytes, size_t length)
{
    uint8_t *code = writer->bytes + writer->code_position, *to = writer->bytes + writer->length;
    for (size_t i = 0; i < length; i++) {
        const uint8_t byte = bytes[i];
        *code = (uint8_t)(to - code);
        code = byte == 0 ? to : code;
        *to++ = byte;
        if (to != code + COBS_BLOCK_BYTES) continue;
        *code = COBS_BLOCK_BYTES;
        code = to++;
    }
    writer->code_position = (size_t)(code - writer->bytes);
    writer->length = (size_t)(to - writer->bytes);
}

size_t crn_wire_frame_encode(const crn_wire_header *header, const uint8_t *payload, size_t payload_bytes,
                             uint8_t *frame, size_t capacity)
{
    size_t body_bytes = CRN_WIRE_HEADER_BYTES + payload_bytes + CRN_WIRE_CRC_BYTES;
    if (payload_bytes > CRN_WIRE_PAYLOAD_MAX || capacity < body_bytes + body_bytes / 254 + 2) return 0;
    uint8_t head[CRN_WIRE_HEADER_BYTES], tail[CRN_WIRE_CRC_BYTES];
    crn_wire_writer words = crn_wire_writer_make(head, sizeof head);
    crn_wire_write(&words, header->sequence, 2);
    crn_wire_write(&words, header->answers, 2);
    crn_wire_write(&words, header->type, 2);
    crn_wire_write(&words, payload_bytes, 2);
    uint32_t crc = crn_wire_crc32(crn_wire_crc32(0, head, sizeof head), payload, payload_bytes);
    words = crn_wire_writer_make(tail, sizeof tail);
    crn_wire_write(&words, crc, 4);

    cobs_writer writer = {frame, 1, 0};
    cobs_put_all(&writer, head, sizeof head);
    cobs_put_all(&writer, payload, payload_bytes);
    cobs_put_all(&writer, tail, sizeof tail);
    frame[writer.code_position] = (uint8_t)(writer.length - writer.code_position);
    frame[writer.length++] = 0;
    return writer.length;
}

/* --- decoding --- */
void crn_wire_decoder_init(crn_wire_decoder *decoder)
{
    for (size_t i = 0; i < CRN_WIRE_EVENT_COUNT; i++) decoder->event_counts[i] = 0;
    decoder->header = (crn_wire_header){0, 0, 0};
    decoder->payload = decoder->body;
    decoder->payload_bytes = 0;
    decoder->body_bytes = 0;
    decoder->block_left = 0;
    decoder->block_full = true;
    decoder->started = false;
    decoder->too_long = false;
}

static void append(crn_wire_decoder *decoder, uint8_t byte)
{
    if (decoder->body_bytes == CRN_WIRE_BODY_MAX) {
        decoder->too_long = true;
        return;
    }
    decoder->body[decoder->body_bytes++] = byte;
}

/* When the zero byte that ends a frame arrives, decides whether the bytes before it form a valid frame. */
static crn_wire_event judge(crn_wire_decoder *decoder)
{
    size_t bytes = decoder->body_bytes;
    if (decoder->too_long) return CRN_WIRE_BAD_SIZE;
    if (decoder->block_left != 0) return CRN_WIRE_BAD_COBS;
    if (bytes < CRN_WIRE_HEADER_BYTES + CRN_WIRE_CRC_BYTES) return CRN_WIRE_BAD_SIZE;
    crn_wire_reader reader = crn_wire_reader_make(decoder->body, bytes);
    decoder->header.sequence = (uint16_t)crn_wire_read(&reader, 2);
    decoder->header.answers = (uint16_t)crn_wire_read(&reader, 2);
    decoder->header.type = (uint16_t)crn_wire_read(&reader, 2);
    size_t length = (size_t)crn_wire_read(&reader, 2);
    reader.position = bytes - CRN_WIRE_CRC_BYTES;
    if (crn_wire_crc32(0, decoder->body, bytes - CRN_WIRE_CRC_BYTES) != crn_wire_read(&reader, 4))
        return CRN_WIRE_BAD_CRC;
    if (length != bytes - CRN_WIRE_HEADER_BYTES - CRN_WIRE_CRC_BYTES) return CRN_WIRE_BAD_LENGTH;
    decoder->payload = decoder->body + CRN_WIRE_HEADER_BYTES;
    decoder->payload_bytes = length;
    return CRN_WIRE_FRAME;
}

static crn_wire_event end_frame(crn_wire_decoder *decoder)
{
    if (!decoder->started) return CRN_WIRE_NEED_MORE; /* zeros between frames are idle */
    crn_wire_event event = judge(decoder);
    decoder->event_counts[event]++;
    decoder->body_bytes = 0;
    decoder->block_left = 0;
    decoder->block_full = true;
    decoder->started = false;
    decoder->too_long = false;
    return event;
}

crn_wire_event crn_wire_decoder_push(crn_wire_decoder *decoder, uint8_t byte)
{
    if (byte == 0) return end_frame(decoder);
    decoder->started = true;
    if (decoder->block_left > 0) {
        decoder->block_left--;
        append(decoder, byte);
        return CRN_WIRE_NEED_MORE;
    }
    /* Handles a code byte. A code byte begins a COBS block, and the previous block ended with a zero, unless
     * the previous block was full or this code byte is the first. */
    if (!decoder->block_full) append(decoder, 0);
    decoder->block_left = (uint8_t)(byte - 1);
    decoder->block_full = byte == 255;
    return CRN_WIRE_NEED_MORE;
}

/* Takes bytes that are not zero while the body has room for them, as crn_wire_decoder_push() does, but
 * without a branch for each code byte: the blocks of a message are short and of irregular length. Returns how
 * many bytes it took. */
static size_t take_some(crn_wire_decoder *decoder, const uint8_t *bytes, size_t count)
{
    const size_t room = CRN_WIRE_BODY_MAX - decoder->body_bytes;
    const size_t most = count < room ? count : room;
    uint8_t *to = decoder->body + decoder->body_bytes;
    unsigned left = decoder->block_left, follows_full = decoder->block_full;
    size_t i = 0;
    for (; i < most && bytes[i] != 0; i++) {
        const unsigned byte = bytes[i], is_code = left == 0;
        *to = (uint8_t)(is_code ? 0 : byte);
        to += 1u - (is_code & follows_full);
        follows_full = is_code ? byte == 255 : follows_full;
        left = (is_code ? byte : left) - 1;
    }
    decoder->body_bytes = (size_t)(to - decoder->body);
    decoder->block_left = (uint8_t)left;
    decoder->block_full = follows_full != 0;
    decoder->started = decoder->started || i > 0;
    return i;
}

crn_wire_event crn_wire_decoder_take(crn_wire_decoder *decoder, const uint8_t *bytes, size_t count,
                                     size_t *taken)
{
    crn_wire_event event = CRN_WIRE_NEED_MORE;
    *taken = 0;
    while (*taken < count && event == CRN_WIRE_NEED_MORE) {
        *taken += take_some(decoder, bytes + *taken, count - *taken);
        if (*taken < count) event = crn_wire_decoder_push(decoder, bytes[(*taken)++]);
    }
    return event;
}
