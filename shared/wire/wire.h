/* This header has the messages of the wire protocol as structs and codecs, made from wire_messages.def and
 * wire_faults.def.
 *
 *   crn_wire_<name>                the struct of a record or message
 *   CRN_WIRE_TYPE_<name>           its number on the wire
 *   CRN_WIRE_KIND_<name>           the kind of a record that is an option of a choice
 *   crn_wire_<choice>_of_<name>    a choice that holds this record
 *   CRN_WIRE_BYTES_<name>          its largest payload
 *   crn_wire_put_<name>            append to a writer; false when it does not fit, a count is too large or a kind is
 *                                  unknown
 *   crn_wire_get_<name>            read from a reader; false when bytes are missing, a count is too large or a kind
 *                                  is unknown
 *   crn_wire_decode_<name>         read a whole payload; false unless it fits to the byte
 *
 * C11 and C++20. */
#ifndef CRN_WIRE_H
#define CRN_WIRE_H

#include "shared/wire/fault_code.h"
#include "shared/wire/wire_bytes.h"

#ifdef __cplusplus
extern "C" {
#endif

/* clang-format off */
enum {
    CRN_WIRE_PROTOCOL_MAJOR = 7, /* changes when old and new sides cannot communicate */
    CRN_WIRE_PROTOCOL_MINOR = 0,
};

typedef uint8_t crn_wire_u8;
typedef uint16_t crn_wire_u16;
typedef uint32_t crn_wire_u32;
typedef uint64_t crn_wire_u64;
typedef int16_t crn_wire_i16;
typedef int32_t crn_wire_i32;

enum {
    CRN_WIRE_BYTES_u8 = 1,
    CRN_WIRE_BYTES_u16 = 2,
    CRN_WIRE_BYTES_u32 = 4,
    CRN_WIRE_BYTES_u64 = 8,
    CRN_WIRE_BYTES_i16 = 2,
    CRN_WIRE_BYTES_i32 = 4,
};

/* Kinds, needed by the choices. */
#define OPTION(choice, record, kind, text) CRN_WIRE_KIND_##record = kind,
enum {
#include "shared/wire/wire_messages.def"
};

/* The structs. */
#define RECORD(name, text) typedef struct crn_wire_##name {
#define MESSAGE(name, type, direction, text) typedef struct crn_wire_##name {
#define FIELD(owner, type, name, unit, text) crn_wire_##type name;
#define ARRAY(owner, type, name, max, unit, text) uint16_t name##_count; crn_wire_##type name[max];
#define LIST(owner, type, name, max, unit, text) ARRAY(owner, type, name, max, unit, text)
#define END(owner) } crn_wire_##owner;
#define CHOICE(name, text) typedef struct crn_wire_##name { uint8_t kind; union {
#define OPTION(choice, record, kind, text) crn_wire_##record record;
#define CHOICE_END(choice) }; } crn_wire_##choice;
#include "shared/wire/wire_messages.def"

/* Largest sizes in bytes. */
#define RECORD(name, text) enum { CRN_WIRE_BYTES_##name = 0
#define MESSAGE(name, type, direction, text) enum { CRN_WIRE_BYTES_##name = 0
#define FIELD(owner, type, name, unit, text) + (int)CRN_WIRE_BYTES_##type
#define ARRAY(owner, type, name, max, unit, text) + 2 + (max) * (int)CRN_WIRE_BYTES_##type
#define LIST(owner, type, name, max, unit, text) + 1 + (max) * (int)CRN_WIRE_BYTES_##type
#define END(owner) };
#define CHOICE(name, text) typedef union crn_wire_longest_##name {
#define OPTION(choice, record, kind, text) uint8_t record[CRN_WIRE_BYTES_##record];
#define CHOICE_END(choice) } crn_wire_longest_##choice; \
    enum { CRN_WIRE_BYTES_##choice = 1 + (int)sizeof(crn_wire_longest_##choice) };
#include "shared/wire/wire_messages.def"

/* Largest counts of arrays. */
#define ARRAY(owner, type, name, max, unit, text) enum { CRN_WIRE_MAX_##owner##_##name = max };
#define LIST(owner, type, name, max, unit, text) ARRAY(owner, type, name, max, unit, text)
#include "shared/wire/wire_messages.def"

/* Numbers of messages. */
#define MESSAGE(name, type, direction, text) CRN_WIRE_TYPE_##name = type,
enum {
#include "shared/wire/wire_messages.def"
};

/* Choices that hold a record. */
#define OPTION(choice, record, number, text) \
    static inline crn_wire_##choice crn_wire_##choice##_of_##record(crn_wire_##record value) \
    { \
        crn_wire_##choice made; \
        made.kind = number; \
        made.record = value; \
        return made; \
    }
#include "shared/wire/wire_messages.def"

/* Codecs. */
#define CHOICE(name, text) RECORD(name, text)
#define RECORD(name, text) \
    bool crn_wire_put_##name(crn_wire_writer *writer, const crn_wire_##name *value); \
    bool crn_wire_get_##name(crn_wire_reader *reader, crn_wire_##name *value);
#define MESSAGE(name, type, direction, text) \
    bool crn_wire_put_##name(crn_wire_writer *writer, const crn_wire_##name *value); \
    bool crn_wire_get_##name(crn_wire_reader *reader, crn_wire_##name *value); \
    bool crn_wire_decode_##name(const uint8_t *payload, size_t length, crn_wire_##name *value);
#include "shared/wire/wire_messages.def"

/* Lists the codes with which the device refuses a request; the codes of faults are in fault_code.h. */
#define REJECT(NAME, code, text, remedy) CRN_REJECT_##NAME = code,
typedef enum crn_reject_code {
    CRN_REJECT_NONE = 0,
#include "shared/wire/wire_faults.def"
} crn_reject_code;

/* Lists the answers to an order to exchange a tool. */
#define EXCHANGE(NAME, number, text, remedy) CRN_WIRE_EXCHANGE_##NAME = number,
enum {
    CRN_WIRE_EXCHANGE_NONE = 0,
#include "shared/wire/wire_exchanges.def"
};
/* clang-format on */

/* Numbers inside messages, named. */
enum {
    CRN_WIRE_STATE_INIT = 0,
    CRN_WIRE_STATE_READY = 1,
    CRN_WIRE_STATE_ARMED = 2,
    CRN_WIRE_STATE_RUNNING = 3,
    CRN_WIRE_STATE_FAULT = 4,

    CRN_WIRE_MODE_LOCKSTEP = 0,
    CRN_WIRE_MODE_FREE_RUN = 1,

    CRN_WIRE_ACTION_ARM = 1,
    CRN_WIRE_ACTION_START = 2,
    CRN_WIRE_ACTION_STOP = 3,
    CRN_WIRE_ACTION_RESET = 4,
    CRN_WIRE_ACTION_LOCKSTEP = 5,
    CRN_WIRE_ACTION_FREE_RUN = 6,
    CRN_WIRE_ACTION_ARM_MOTORS = 7,
    CRN_WIRE_ACTION_CONFIRM = 8,

    CRN_WIRE_RHYTHM_HEART_RATE = 1,
    CRN_WIRE_RHYTHM_VARIABILITY = 2,
    CRN_WIRE_RHYTHM_PREMATURE = 3,
    CRN_WIRE_RHYTHM_ASYSTOLE = 4,
    CRN_WIRE_RHYTHM_BREATH_RATE = 5,
    CRN_WIRE_RHYTHM_BREATH_HOLD = 6,

    CRN_WIRE_RHYTHM_IS_PREMATURE = 1,
    CRN_WIRE_RHYTHM_NEXT_PREMATURE = 2,
    CRN_WIRE_RHYTHM_WANTS_ASYSTOLE = 4,
    CRN_WIRE_RHYTHM_IS_RESTING = 8,
    CRN_WIRE_RHYTHM_HOLDS_BREATH = 16,

    CRN_WIRE_GET_STATUS = 1,
    CRN_WIRE_GET_NODES = 2,
    CRN_WIRE_GET_NODE_TABLE = 3,
    CRN_WIRE_GET_HASH64 = 4,
    CRN_WIRE_GET_SNAPSHOT = 5,
    CRN_WIRE_GET_FAULT_LOG = 6,
    CRN_WIRE_GET_CONTACTS = 7,
    CRN_WIRE_GET_RIG = 8,
    CRN_WIRE_GET_SET_UP = 9,
    CRN_WIRE_GET_SENSORS = 10,

    CRN_WIRE_EVENT_STATE = 1,
    CRN_WIRE_EVENT_FAULT = 2,
    CRN_WIRE_EVENT_BUTTONS = 3,
    CRN_WIRE_EVENT_COMMAND = 4,
    CRN_WIRE_EVENT_HOST = 5,

    CRN_WIRE_LIVE_HANDS = 1,
    CRN_WIRE_LIVE_POWERED = 2,
    CRN_WIRE_LIVE_LATE = 4,

    CRN_WIRE_OPTION_TRANSLATION_REVERSED = 1,
    CRN_WIRE_OPTION_ROTATION_REVERSED = 2,

    CRN_WIRE_LINE_STOP = 1,
    CRN_WIRE_LINE_SUPPLY = 2,
    CRN_WIRE_LINE_STAGE = 4,
    CRN_WIRE_LINE_UNLOCK = 8,

    CRN_WIRE_CAPABILITY_LOCKSTEP = 1,
    CRN_WIRE_CAPABILITY_FREE_RUN = 2,
    CRN_WIRE_CAPABILITY_SNAPSHOTS = 4,
    CRN_WIRE_CAPABILITY_ENCODERS = 8,
    CRN_WIRE_CAPABILITY_MOTORS = 16,

    CRN_WIRE_MATERIAL_ELASTIC = 0,
    CRN_WIRE_MATERIAL_METAL = 1,
    CRN_WIRE_MATERIAL_SUPERELASTIC = 2,

    CRN_WIRE_BUTTON_XRAY = 1,
    CRN_WIRE_BUTTON_CINE = 2,

    CRN_WIRE_TOOL_MAX = CRN_WIRE_MAX_tools_line,   /* positions of a line */
    CRN_WIRE_TABLE_MAX = CRN_WIRE_MAX_tools_tools, /* tools of a session */

    CRN_WIRE_PAYLOAD_MAX = CRN_WIRE_BYTES_tools, /* the longest message; checked by the test */
};

/* Returns a hash over every name, number, type and unit of wire_messages.def. Two programs that have
 * different hashes refuse to communicate. */
uint64_t crn_wire_schema_hash(void);

/* These functions return texts for people and never return NULL. For unknown numbers the texts are "unknown
 * ...". */
const char *crn_wire_message_name(uint16_t type);
const char *crn_wire_fault_name(uint16_t code);
const char *crn_wire_fault_text(uint16_t code);
const char *crn_wire_fault_remedy(uint16_t code);
uint32_t crn_wire_fault_safe_ms(uint16_t code); /* from the onset of the fault until no force is left; 0: no
                                                   force is at stake */
const char *crn_wire_reject_name(uint16_t code);
const char *crn_wire_reject_text(uint16_t code);
const char *crn_wire_reject_remedy(uint16_t code);
const char *crn_wire_exchange_name(uint8_t answer);
const char *crn_wire_exchange_text(uint8_t answer);
const char *crn_wire_exchange_remedy(uint8_t answer);
const char *crn_wire_state_name(uint8_t state);

#ifdef __cplusplus
}
#endif

#endif
