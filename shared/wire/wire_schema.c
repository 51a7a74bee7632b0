/* This file has the schema hash and the texts for people, made from wire_messages.def and wire_faults.def. */
#include "shared/wire/wire.h"

/* The hash is FNV-1a over every name, type and unit of wire_messages.def. Each name, type and unit is hashed
 * with its terminating zero, so that ("ab","c") and ("a","bc") differ; the explaining texts are not hashed.
 * The schema hash is a constant, because computing it costs a device 106,000 instructions per HELLO. The
 * program test_wire computes the hash and prints the number to write here when the messages have changed. */
uint64_t crn_wire_schema_hash(void)
{
    return 0x1b28984df7507099u;
}

const char *crn_wire_message_name(uint16_t type)
{
    switch (type) {
#define MESSAGE(name, number, direction, text)                                                               \
    case number:                                                                                             \
        return #name;
#include "shared/wire/wire_messages.def"
    default:
        return "unknown message";
    }
}

const char *crn_wire_fault_name(uint16_t code)
{
    switch (code) {
#define FAULT(NAME, number, effect, safe_ms, test, text, detection, remedy)                                  \
    case number:                                                                                             \
        return #NAME;
#include "shared/wire/wire_faults.def"
    default:
        return "unknown fault";
    }
}

const char *crn_wire_fault_text(uint16_t code)
{
    switch (code) {
#define FAULT(NAME, number, effect, safe_ms, test, text, detection, remedy)                                  \
    case number:                                                                                             \
        return text;
#include "shared/wire/wire_faults.def"
    default:
        return "unknown fault";
    }
}

const char *crn_wire_fault_remedy(uint16_t code)
{
    switch (code) {
#define FAULT(NAME, number, effect, safe_ms, test, text, detection, remedy)                                  \
    case number:                                                                                             \
        return remedy;
#include "shared/wire/wire_faults.def"
    default:
        return "use the same version on both sides";
    }
}

uint32_t crn_wire_fault_safe_ms(uint16_t code)
{
    switch (code) {
#define FAULT(NAME, number, effect, safe_ms, test, text, detection, remedy)                                  \
    case number:                                                                                             \
        return safe_ms;
#include "shared/wire/wire_faults.def"
    default:
        return 0;
    }
}

const char *crn_wire_reject_name(uint16_t code)
{
    switch (code) {
#define REJECT(NAME, number, text, remedy)                                                                   \
    case number:                                                                                             \
        return #NAME;
#include "shared/wire/wire_faults.def"
    default:
        return "unknown refusal";
    }
}

const char *crn_wire_reject_text(uint16_t code)
{
    switch (code) {
#define REJECT(NAME, number, text, remedy)                                                                   \
    case number:                                                                                             \
        return text;
#include "shared/wire/wire_faults.def"
    default:
        return "unknown refusal";
    }
}

const char *crn_wire_reject_remedy(uint16_t code)
{
    switch (code) {
#define REJECT(NAME, number, text, remedy)                                                                   \
    case number:                                                                                             \
        return remedy;
#include "shared/wire/wire_faults.def"
    default:
        return "use the same version on both sides";
    }
}

const char *crn_wire_exchange_name(uint8_t answer)
{
    switch (answer) {
#define EXCHANGE(NAME, number, text, remedy)                                                                 \
    case number:                                                                                             \
        return #NAME;
#include "shared/wire/wire_exchanges.def"
    default:
        return "unknown answer";
    }
}

const char *crn_wire_exchange_text(uint8_t answer)
{
    switch (answer) {
#define EXCHANGE(NAME, number, text, remedy)                                                                 \
    case number:                                                                                             \
        return text;
#include "shared/wire/wire_exchanges.def"
    default:
        return "unknown answer";
    }
}

const char *crn_wire_exchange_remedy(uint8_t answer)
{
    switch (answer) {
#define EXCHANGE(NAME, number, text, remedy)                                                                 \
    case number:                                                                                             \
        return remedy;
#include "shared/wire/wire_exchanges.def"
    default:
        return "use the same version on both sides";
    }
}

const char *crn_wire_state_name(uint8_t state)
{
    static const char *const names[] = {"INIT", "READY", "ARMED", "RUNNING", "FAULT"};
    return state < sizeof names / sizeof names[0] ? names[state] : "unknown state";
}
