/* These tests check the frames and the encoders and decoders of the wire protocol. Decoding an encoded
 * message gives the message back, a damaged frame is dropped and counted, and a receiver that has lost
 * synchronisation finds the next frame. The tests use random messages with fixed seeds and every single-bit
 * flip. Seeds are fixed: running the program again reproduces a failure. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "shared/wire/wire_frame.h"

static uint32_t random_state = 12345;

static uint32_t random_u32(void)
{
    random_state ^= random_state << 13;
    random_state ^= random_state >> 17;
    random_state ^= random_state << 5;
    return random_state;
}

static size_t encode_random(uint8_t *payload, size_t length, int zero_share, uint8_t *frame)
{
    for (size_t i = 0; i < length; i++)
        payload[i] = random_u32() % 8 < (uint32_t)zero_share ? 0 : (uint8_t)random_u32();
    const crn_wire_header header = {(uint16_t)random_u32(), (uint16_t)random_u32(), (uint16_t)random_u32()};
    return crn_wire_frame_encode(&header, payload, length, frame, CRN_WIRE_FRAME_MAX);
}

static crn_wire_event push_all(crn_wire_decoder *decoder, const uint8_t *bytes, size_t count)
{
    crn_wire_event event = CRN_WIRE_NEED_MORE;
    for (size_t i = 0; i < count; i++) event = crn_wire_decoder_push(decoder, bytes[i]);
    return event;
}

static uint8_t payload[CRN_WIRE_PAYLOAD_MAX];
static uint8_t frame[CRN_WIRE_FRAME_MAX];
static crn_wire_decoder decoder;

/* The expected value is the published check value of CRC-32 (IEEE 802.3) for the digits 1 to 9. */
static void crc32_of_the_digits_is_the_published_value(void **state)
{
    (void)state;
    assert_int_equal(crn_wire_crc32(0, (const uint8_t *)"123456789", 9), 0xcbf43926u);
    uint32_t in_two =
        crn_wire_crc32(crn_wire_crc32(0, (const uint8_t *)"1234", 4), (const uint8_t *)"56789", 5);
    assert_int_equal(in_two, 0xcbf43926u);
}

/* Every entry of the CRC table agrees with the definition, which passes one bit after the other through the
 * polynomial 0xedb88320. */
static void crc32_of_every_byte_is_that_of_its_bits(void **state)
{
    (void)state;
    for (uint32_t byte = 0; byte < 256; byte++) {
        uint32_t crc = 0xffffffffu ^ byte;
        for (int bit = 0; bit < 8; bit++) crc = (crc >> 1) ^ ((crc & 1u) != 0 ? 0xedb88320u : 0);
        assert_int_equal(crn_wire_crc32(0, &(const uint8_t){(uint8_t)byte}, 1), ~crc);
    }
}

static uint32_t crc_by_bits(const uint8_t *bytes, size_t length)
{
    uint32_t crc = 0xffffffffu;
    for (size_t i = 0; i < length; i++) {
        crc ^= bytes[i];
        for (int bit = 0; bit < 8; bit++) crc = (crc >> 1) ^ ((crc & 1u) != 0 ? 0xedb88320u : 0);
    }
    return ~crc;
}

/* A host takes eight bytes at a time, so the test's lengths and beginnings lie on and off multiples of eight.
 */
static void crc32_of_every_length_is_that_of_its_bits(void **state)
{
    (void)state;
    for (size_t i = 0; i < 100; i++) payload[i] = (uint8_t)random_u32();
    for (size_t begin = 0; begin < 9; begin++) {
        for (size_t length = 0; begin + length <= 100; length++)
            assert_int_equal(crn_wire_crc32(0, payload + begin, length),
                             crc_by_bits(payload + begin, length));
    }
}

/* The test's frames include lengths around 254 bytes, where a COBS block ends, and the largest length; their
 * contents have few or many zero bytes. */
static void frames_of_every_length_come_back(void **state)
{
    (void)state;
    crn_wire_decoder_init(&decoder);
    for (size_t length = 0; length <= CRN_WIRE_PAYLOAD_MAX;
         length = length < 800 ? length + 1 : length + 431) {
        for (int zero_share = 0; zero_share <= 8; zero_share += 4) {
            size_t bytes = encode_random(payload, length, zero_share, frame);
            assert_true(bytes > 0);
            assert_null(memchr(frame, 0, bytes - 1));
            assert_int_equal(push_all(&decoder, frame, bytes), CRN_WIRE_FRAME);
            assert_int_equal(decoder.payload_bytes, length);
            assert_memory_equal(decoder.payload, payload, length);
        }
    }
}

static void a_frame_without_payload_needs_no_bytes(void **state)
{
    (void)state;
    const crn_wire_header header = {1, 0, 1};
    crn_wire_decoder_init(&decoder);
    const size_t bytes = crn_wire_frame_encode(&header, NULL, 0, frame, sizeof frame);
    assert_int_equal(push_all(&decoder, frame, bytes), CRN_WIRE_FRAME);
    assert_int_equal(decoder.payload_bytes, 0);
}

static void the_longest_payload_fits_and_one_more_byte_is_refused(void **state)
{
    (void)state;
    const crn_wire_header header = {1, 0, 1};
    static uint8_t longer[CRN_WIRE_PAYLOAD_MAX + 1];
    memset(longer, 1, sizeof longer);
    assert_true(crn_wire_frame_encode(&header, longer, CRN_WIRE_PAYLOAD_MAX, frame, sizeof frame) > 0);
    assert_int_equal(crn_wire_frame_encode(&header, longer, sizeof longer, frame, sizeof frame), 0);
    assert_int_equal(crn_wire_frame_encode(&header, longer, 100, frame, 100), 0);
}

/* The test flips every bit of a frame once, and the receiver must never accept a frame with other contents. A
 * flipped bit may split the frame or remove its end mark. */
static void a_flipped_bit_never_gives_another_message(void **state)
{
    (void)state;
    size_t bytes = encode_random(payload, 300, 2, frame);
    for (size_t bit = 0; bit < 8 * bytes; bit++) {
        crn_wire_decoder_init(&decoder);
        frame[bit / 8] ^= (uint8_t)(1u << (bit % 8));
        for (size_t i = 0; i < bytes; i++) {
            assert_int_not_equal(crn_wire_decoder_push(&decoder, frame[i]), CRN_WIRE_FRAME);
        }
        frame[bit / 8] ^= (uint8_t)(1u << (bit % 8));
    }
}

static void the_frame_after_garbage_is_received(void **state)
{
    (void)state;
    crn_wire_decoder_init(&decoder);
    for (int round = 0; round < 200; round++) {
        size_t garbage = random_u32() % 24000; /* up to two frames of the largest size */
        const uint8_t never_zero = round % 2;  /* so that some garbage is longer than any frame */
        for (size_t i = 0; i < garbage; i++)
            crn_wire_decoder_push(&decoder, (uint8_t)(random_u32() | never_zero));
        crn_wire_decoder_push(&decoder, 0);
        size_t bytes = encode_random(payload, random_u32() % 500, 2, frame);
        assert_int_equal(push_all(&decoder, frame, bytes), CRN_WIRE_FRAME);
    }
    assert_int_equal(decoder.event_counts[CRN_WIRE_FRAME], 200);
    assert_true(decoder.event_counts[CRN_WIRE_BAD_SIZE] > 0 && decoder.event_counts[CRN_WIRE_BAD_COBS] > 0);
}

/* Makes whole frames, damaged frames, garbage and idle zeros, up to the given number of bytes. */
static size_t make_stream(uint8_t *stream, size_t most)
{
    size_t count = 0;
    for (;;) {
        const uint32_t kind = random_u32() % 4;
        size_t bytes = encode_random(payload, random_u32() % 700, (int)(random_u32() % 8), frame);
        if (count + bytes > most) return count;
        if (kind == 1) frame[random_u32() % bytes] ^= (uint8_t)(1u << random_u32() % 8);
        if (kind == 2) memset(frame, (int)(random_u32() % 2), bytes);
        memcpy(stream + count, frame, bytes);
        count += bytes;
    }
}

/* A decoder that takes the same bytes in pieces of any size gives the same events at the same bytes and the
 * same messages as a decoder that takes single bytes. A run of 15,000 bytes without a zero is longer than any
 * frame. */
static void bytes_taken_in_pieces_give_what_single_bytes_give(void **state)
{
    (void)state;
    static uint8_t stream[100000];
    static crn_wire_decoder single;
    size_t count = make_stream(stream, sizeof stream - 15000);
    memset(stream + count, 1, 15000);
    count += 15000;
    crn_wire_decoder_init(&single);
    crn_wire_decoder_init(&decoder);
    for (size_t i = 0, taken; i < count; i += taken) {
        const size_t piece = 1 + random_u32() % 900;
        const crn_wire_event event =
            crn_wire_decoder_take(&decoder, stream + i, piece < count - i ? piece : count - i, &taken);
        assert_true(taken > 0);
        for (size_t k = 0; k + 1 < taken; k++)
            assert_int_equal(crn_wire_decoder_push(&single, stream[i + k]), CRN_WIRE_NEED_MORE);
        assert_int_equal(crn_wire_decoder_push(&single, stream[i + taken - 1]), event);
        if (event != CRN_WIRE_FRAME) continue;
        assert_memory_equal(&decoder.header, &single.header, sizeof single.header);
        assert_int_equal(decoder.payload_bytes, single.payload_bytes);
        assert_memory_equal(decoder.payload, single.payload, single.payload_bytes);
    }
    assert_memory_equal(decoder.event_counts, single.event_counts, sizeof single.event_counts);
    assert_true(single.event_counts[CRN_WIRE_FRAME] > 50 && single.event_counts[CRN_WIRE_BAD_CRC] > 0);
}

static void damage_is_counted_by_its_cause(void **state)
{
    (void)state;
    const uint8_t cobs_past_end[] = {9, 1, 2, 0}, too_short[] = {3, 1, 2, 0};
    crn_wire_decoder_init(&decoder);
    assert_int_equal(push_all(&decoder, cobs_past_end, sizeof cobs_past_end), CRN_WIRE_BAD_COBS);
    assert_int_equal(push_all(&decoder, too_short, sizeof too_short), CRN_WIRE_BAD_SIZE);
    for (int i = 0; i < 3 * CRN_WIRE_FRAME_MAX; i++) crn_wire_decoder_push(&decoder, 1);
    assert_int_equal(crn_wire_decoder_push(&decoder, 0), CRN_WIRE_BAD_SIZE);
    size_t bytes = encode_random(payload, 20, 0, frame);
    frame[14] = (uint8_t)(frame[14] == 7 ? 8 : 7);
    assert_int_equal(push_all(&decoder, frame, bytes), CRN_WIRE_BAD_CRC);
}

static void idle_zeros_between_frames_are_no_errors(void **state)
{
    (void)state;
    crn_wire_decoder_init(&decoder);
    for (int i = 0; i < 100; i++) assert_int_equal(crn_wire_decoder_push(&decoder, 0), CRN_WIRE_NEED_MORE);
    assert_int_equal(decoder.event_counts[CRN_WIRE_BAD_SIZE], 0);
}

/* The expected bytes follow the protocol's document: the least significant byte comes first, and the count
 * comes before the elements. */
static void a_step_is_laid_out_as_documented(void **state)
{
    (void)state;
    static crn_wire_step step = {.tick = 0x01020304,
                                 .want_nodes = 1,
                                 .inputs_count = 1,
                                 .inputs = {{.hands_count = 2,
                                             .hands = {{-2, 5}, {7, -1}},
                                             .buttons = 0x80,
                                             .inflator_raw = 3,
                                             .orders = {.items_count = 3}}}};
    crn_wire_order *orders = step.inputs[0].orders.items;
    orders[0] = crn_wire_order_of_rhythm((crn_wire_rhythm){1, 150});
    orders[1] = crn_wire_order_of_scaffold((crn_wire_scaffold){1, 4, 12, 0x7ffe});
    orders[2] = crn_wire_order_of_strut((crn_wire_strut){64, 1, 1, -2, 0x10203, 1500, 81});
    const uint8_t expected[] = {
        4,    3,    2,    1,  1, 1, 0, 2, 0, 0xfe, 0xff, 0xff, 0xff, 5, 0, 0, 0, 7,    0, 0,  0, 0xff, 0xff,
        0xff, 0xff, 0x80, 0,  0, 0, 0, 0, 0, 0,    3,    0,    0,    0, 3, 1, 1, 150,  0, 2,  1, 4,    12,
        0xfe, 0x7f, 3,    64, 1, 1, 0, 0, 0, 0xfe, 0xff, 0xff, 0xff, 3, 2, 1, 0, 0xdc, 5, 81, 0};
    crn_wire_writer writer = crn_wire_writer_make(payload, sizeof payload);
    assert_true(crn_wire_put_step(&writer, &step));
    assert_int_equal(writer.length, sizeof expected);
    assert_memory_equal(payload, expected, sizeof expected);
    static crn_wire_step back;
    assert_true(crn_wire_decode_step(payload, writer.length, &back));
    assert_int_equal(back.inputs[0].hands_count, 2);
    assert_int_equal(back.inputs[0].hands[0].translation_counts, -2);
    assert_int_equal(back.inputs[0].hands[1].rotation_counts, -1);
    assert_int_equal(back.inputs[0].orders.items_count, 3);
    assert_int_equal(back.inputs[0].orders.items[1].kind, CRN_WIRE_KIND_scaffold);
    assert_int_equal(back.inputs[0].orders.items[1].scaffold.open_q15, 0x7ffe);
    assert_int_equal(back.inputs[0].orders.items[2].strut.z_um, 0x10203);
}

/* An empty list of commands takes one byte, which states that the list is empty. */
static void a_tick_without_orders_pays_a_byte_for_them(void **state)
{
    (void)state;
    const crn_wire_tick_input input = {.hands_count = 1};
    crn_wire_writer writer = crn_wire_writer_make(payload, sizeof payload);
    assert_true(crn_wire_put_tick_input(&writer, &input));
    assert_int_equal(writer.length, 2 + CRN_WIRE_BYTES_hand + 3 * 4 + 1);
    assert_int_equal(payload[writer.length - 1], 0);
}

/* The test sends a list with as many commands as the list may hold, of every kind in turn. */
static size_t put_full_list(uint8_t *to)
{
    crn_wire_orders message = {.orders = {.items_count = CRN_WIRE_MAX_order_list_items}};
    crn_wire_order *items = message.orders.items;
    items[0] = crn_wire_order_of_strut((crn_wire_strut){1, 1, INT32_MIN, -1, INT32_MAX, 1500, 81});
    items[1] = crn_wire_order_of_rhythm((crn_wire_rhythm){255, 65535});
    items[2] = crn_wire_order_of_scaffold((crn_wire_scaffold){1, 2, 3, 4});
    items[3] = items[0];
    crn_wire_writer writer = crn_wire_writer_make(to, CRN_WIRE_PAYLOAD_MAX);
    assert_true(crn_wire_put_orders(&writer, &message));
    return writer.length;
}

/* The test's messages are those of a hostile host: cut at every byte, one byte too long, with an unknown kind
 * of command, or with one command too many. */
static void lists_of_orders_that_are_damaged_are_refused(void **state)
{
    (void)state;
    crn_wire_orders back;
    const size_t length = put_full_list(payload);
    assert_int_equal(length, 1 + 2 * (1 + CRN_WIRE_BYTES_strut) + 1 + CRN_WIRE_BYTES_rhythm + 1 +
                                 CRN_WIRE_BYTES_scaffold);
    assert_true(crn_wire_decode_orders(payload, length, &back));
    assert_int_equal(back.orders.items[0].strut.z_um, INT32_MAX);
    assert_int_equal(back.orders.items[1].rhythm.value, 65535);
    for (size_t cut = 0; cut < length; cut++) assert_false(crn_wire_decode_orders(payload, cut, &back));
    assert_false(crn_wire_decode_orders(payload, length + 1, &back));
    for (unsigned kind = 0; kind < 256; kind++) {
        payload[1] = (uint8_t)kind;
        assert_int_equal(crn_wire_decode_orders(payload, length, &back), kind == CRN_WIRE_KIND_strut);
    }
    payload[1] = CRN_WIRE_KIND_strut;
    payload[0] = CRN_WIRE_MAX_order_list_items + 1;
    assert_false(crn_wire_decode_orders(payload, length, &back));
    assert_false(crn_wire_decode_orders(payload, sizeof payload, &back));
}

static void nobody_can_send_an_order_that_is_none(void **state)
{
    (void)state;
    crn_wire_orders message = {.orders = {.items_count = 1}};
    for (unsigned kind = 0; kind < 256; kind++) {
        message.orders.items[0].kind = (uint8_t)kind;
        crn_wire_writer writer = crn_wire_writer_make(payload, sizeof payload);
        assert_int_equal(crn_wire_put_orders(&writer, &message), kind >= 1 && kind <= 4);
    }
    message.orders.items[0].kind = CRN_WIRE_KIND_rhythm;
    message.orders.items_count = CRN_WIRE_MAX_order_list_items + 1;
    crn_wire_writer writer = crn_wire_writer_make(payload, sizeof payload);
    assert_false(crn_wire_put_orders(&writer, &message));
}

static void every_kind_of_order_is_used_once_and_one_list_holds_all(void **state)
{
    (void)state;
    static const uint8_t kinds[] = {
#define OPTION(choice, record, kind, text) kind,
#include "shared/wire/wire_messages.def"
    };
    for (size_t i = 0; i < sizeof kinds; i++) assert_int_equal(kinds[i], i + 1);
    assert_true(sizeof kinds <= CRN_WIRE_MAX_order_list_items);
}

static void extreme_values_come_back(void **state)
{
    (void)state;
    const int32_t values[] = {INT32_MIN, INT32_MIN + 1, -1, 0, 1, INT32_MAX};
    for (size_t i = 0; i < sizeof values / sizeof values[0]; i++) {
        const crn_wire_contact contact = {UINT16_MAX, values[i], -(values[i] / 2), 0};
        crn_wire_contact back;
        crn_wire_reader reader = crn_wire_reader_make(payload, CRN_WIRE_BYTES_contact);
        crn_wire_writer writer = crn_wire_writer_make(payload, sizeof payload);
        assert_true(crn_wire_put_contact(&writer, &contact));
        assert_true(crn_wire_get_contact(&reader, &back));
        assert_int_equal(back.node, contact.node);
        assert_int_equal(back.force_x_N_q22, contact.force_x_N_q22);
        assert_int_equal(back.force_y_N_q22, contact.force_y_N_q22);
    }
}

/* The test tries every type of message with every payload length from 0 to its largest length; a decoder
 * accepts a payload only if its length fits the counts in it. */
static void a_payload_of_wrong_length_is_refused(void **state)
{
    (void)state;
    static crn_wire_ticks ticks;
    const int empty_bytes =
        (int)CRN_WIRE_BYTES_tick_state - CRN_WIRE_TOOL_MAX * ((int)CRN_WIRE_BYTES_tool_state + 1);
    memset(payload, 0, sizeof payload);
    payload[0] = 3; /* states without a tool and without a line */
    for (size_t length = 0; length < 500; length++) {
        bool fits = length == 2 + 3 * (size_t)empty_bytes;
        assert_int_equal(crn_wire_decode_ticks(payload, length, &ticks), fits);
    }
    payload[2 + 12] = CRN_WIRE_TOOL_MAX; /* three tools in the first */
    for (size_t length = 0; length < 500; length++) {
        bool fits = length == 2 + 3 * (size_t)empty_bytes + CRN_WIRE_TOOL_MAX * CRN_WIRE_BYTES_tool_state;
        assert_int_equal(crn_wire_decode_ticks(payload, length, &ticks), fits);
    }
    payload[2 + 12] = CRN_WIRE_TOOL_MAX + 1;
    for (size_t length = 0; length < 500; length++)
        assert_false(crn_wire_decode_ticks(payload, length, &ticks));
    payload[2 + 12] = 0;
    payload[0] = CRN_WIRE_MAX_ticks_states + 1;
    assert_false(
        crn_wire_decode_ticks(payload, 2 + (CRN_WIRE_MAX_ticks_states + 1) * (size_t)empty_bytes, &ticks));
    ticks.states_count = CRN_WIRE_MAX_ticks_states + 1;
    crn_wire_writer writer = crn_wire_writer_make(payload, sizeof payload);
    assert_false(crn_wire_put_ticks(&writer, &ticks));
    ticks.states_count = 1;
    ticks.states[0].tools_count = CRN_WIRE_TOOL_MAX + 1;
    writer = crn_wire_writer_make(payload, sizeof payload);
    assert_false(crn_wire_put_ticks(&writer, &ticks));
}

/* The constant CRN_WIRE_PAYLOAD_MAX must be the size of the largest payload of all messages. */
static void no_message_is_longer_than_the_longest_payload(void **state)
{
    (void)state;
#define MESSAGE(name, type, direction, text)                                                                 \
    assert_true((int)CRN_WIRE_BYTES_##name <= (int)CRN_WIRE_PAYLOAD_MAX);
#include "shared/wire/wire_messages.def"
}

static void every_message_number_is_used_once(void **state)
{
    (void)state;
    static uint8_t seen[256];
#define MESSAGE(name, type, direction, text) assert_int_equal(seen[type]++, 0);
#include "shared/wire/wire_messages.def"
}

/* The test computes the FNV-1a hash over names, types and units; the constant in wire_schema.c must be
 * updated with every change of the messages. */
static void the_schema_hash_covers_names_types_and_units(void **state)
{
    (void)state;
    uint64_t hash = 14695981039346656037u;
    const char *texts[] = {
#define RECORD(name, text) "record", #name,
#define MESSAGE(name, type, direction, text) "message", #name, #type, direction,
#define FIELD(owner, type, name, unit, text) "field", #type, #name, unit,
#define ARRAY(owner, type, name, max, unit, text) "array", #type, #name, #max, unit,
#define LIST(owner, type, name, max, unit, text) "list", #type, #name, #max, unit,
#define END(owner) "end",
#define CHOICE(name, text) "choice", #name,
#define OPTION(choice, record, kind, text) "option", #record, #kind,
#define CHOICE_END(choice) "end",
#include "shared/wire/wire_messages.def"
    };
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        for (size_t k = 0; k <= strlen(texts[i]); k++) hash = (hash ^ (uint8_t)texts[i][k]) * 1099511628211u;
    }
    if (hash != crn_wire_schema_hash()) {
        fail_msg("the messages have changed: write 0x%016llxu in shared/wire/wire_schema.c, then make docs",
                 (unsigned long long)hash);
    }
}

static void every_fault_and_refusal_has_a_text_and_a_remedy(void **state)
{
    (void)state;
#define FAULT(NAME, code, effect, safe_ms, test, text, detection, remedy)                                    \
    assert_string_equal(crn_wire_fault_name(code), #NAME);                                                   \
    assert_int_equal(crn_wire_fault_safe_ms(code), safe_ms);                                                 \
    assert_true(strlen(text) > 10 && strlen(remedy) > 5 && strlen(detection) > 5 && strlen(test) > 10);      \
    assert_true((effect[0] == 'l') == ((safe_ms) == 0) && (safe_ms) <= (effect[0] == 'f' ? 50 : 9));
#define REJECT(NAME, code, text, remedy)                                                                     \
    assert_string_equal(crn_wire_reject_name(code), #NAME);                                                  \
    assert_true(strlen(text) > 10 && strlen(remedy) > 5);
#include "shared/wire/wire_faults.def"
    assert_string_equal(crn_wire_fault_name(9999), "unknown fault");
    assert_string_equal(crn_wire_reject_name(9999), "unknown refusal");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(crc32_of_the_digits_is_the_published_value),
        cmocka_unit_test(crc32_of_every_byte_is_that_of_its_bits),
        cmocka_unit_test(frames_of_every_length_come_back),
        cmocka_unit_test(a_frame_without_payload_needs_no_bytes),
        cmocka_unit_test(the_longest_payload_fits_and_one_more_byte_is_refused),
        cmocka_unit_test(a_flipped_bit_never_gives_another_message),
        cmocka_unit_test(the_frame_after_garbage_is_received),
        cmocka_unit_test(damage_is_counted_by_its_cause),
        cmocka_unit_test(idle_zeros_between_frames_are_no_errors),
        cmocka_unit_test(a_step_is_laid_out_as_documented),
        cmocka_unit_test(a_tick_without_orders_pays_a_byte_for_them),
        cmocka_unit_test(lists_of_orders_that_are_damaged_are_refused),
        cmocka_unit_test(nobody_can_send_an_order_that_is_none),
        cmocka_unit_test(every_kind_of_order_is_used_once_and_one_list_holds_all),
        cmocka_unit_test(extreme_values_come_back),
        cmocka_unit_test(a_payload_of_wrong_length_is_refused),
        cmocka_unit_test(no_message_is_longer_than_the_longest_payload),
        cmocka_unit_test(every_message_number_is_used_once),
        cmocka_unit_test(the_schema_hash_covers_names_types_and_units),
        cmocka_unit_test(every_fault_and_refusal_has_a_text_and_a_remedy),
        cmocka_unit_test(bytes_taken_in_pieces_give_what_single_bytes_give),
        cmocka_unit_test(crc32_of_every_length_is_that_of_its_bits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
