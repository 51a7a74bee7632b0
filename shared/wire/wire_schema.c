/* The schema hash and the texts, made from the two .def files. */
#include "shared/wire/wire.h"

/* FNV-1a over a string and its terminating zero, so that ("ab","c") and ("a","bc") differ. Written out letter by letter, because
 * a compiler folds this into one constant and a loop over 250 texts not: a HELLO cost 106,000 instructions for it. */
#define PRIME 0x100000001b3u
#define LETTER(text, i) ((i) < sizeof(text) ? (uint8_t)(text)[(i) < sizeof(text) ? (i) : 0] : 0u)
#define LETTER_HASHED(hash, text, i) (((hash) ^ LETTER(text, i)) * ((i) < sizeof(text) ? PRIME : 1u))
#define TEXT_1(text, i) hash = LETTER_HASHED(hash, text, i);
#define TEXT_4(text, i) TEXT_1(text, i) TEXT_1(text, (i) + 1) TEXT_1(text, (i) + 2) TEXT_1(text, (i) + 3)
#define TEXT_16(text, i) TEXT_4(text, i) TEXT_4(text, (i) + 4) TEXT_4(text, (i) + 8) TEXT_4(text, (i) + 12)
#define TEXT(text)                                                                                           \
    {                                                                                                        \
        _Static_assert(sizeof(text) <= 32, "longer than what is written out");                               \
        TEXT_16(text, 0u) TEXT_16(text, 16u)                                                                 \
    }

/* Meanings are hashed too where they are numbers or units; the explaining texts are not. */
uint64_t seld_wire_schema_hash(void)
{
    uint64_t hash = 0xcbf29ce484222325u;
    /* clang-format off */
#define RECORD(name, text) TEXT("record") TEXT(#name)
#define MESSAGE(name, type, direction, text) TEXT("message") TEXT(#name) TEXT(#type) TEXT(direction)
#define FIELD(owner, type, name, unit, text) TEXT("field") TEXT(#type) TEXT(#name) TEXT(unit)
#define ARRAY(owner, type, name, max, unit, text) TEXT("array") TEXT(#type) TEXT(#name) TEXT(#max) TEXT(unit)
#define END(owner) TEXT("end")
#include "shared/wire/wire_messages.def"
    /* clang-format on */
    return hash;
}

const char *seld_wire_message_name(uint16_t type)
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

const char *seld_wire_fault_name(uint16_t code)
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

const char *seld_wire_fault_text(uint16_t code)
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

const char *seld_wire_fault_remedy(uint16_t code)
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

uint32_t seld_wire_fault_safe_ms(uint16_t code)
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

const char *seld_wire_reject_name(uint16_t code)
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

const char *seld_wire_reject_text(uint16_t code)
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

const char *seld_wire_reject_remedy(uint16_t code)
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

const char *seld_wire_state_name(uint8_t state)
{
    static const char *const names[] = {"INIT", "READY", "ARMED", "RUNNING", "FAULT"};
    return state < sizeof names / sizeof names[0] ? names[state] : "unknown state";
}
