#include "tools/docs/dissector.hpp"
#include "host/base/number_text.hpp"
#include "shared/wire/wire.h"

namespace
{

// Returns a Lua string. The texts in the wire protocol's definition have only printable ASCII characters, but
// these may include quotes and backslashes.
std::string quoted(const char *text)
{
    std::string result = "\"";
    for (const char *c = text; *c; c++) {
        if (*c == '"' || *c == '\\') result += '\\';
        result += *c;
    }
    return result + "\"";
}

// `count_bytes` is the size of the number that precedes a list and gives its length; 0 means that there is no
// list but a single value.
std::string field(const char *name, const char *type, const char *unit, int max, int count_bytes)
{
    const std::string limit =
        max > 0 ? ", max = " + std::to_string(max) + ", count_bytes = " + std::to_string(count_bytes) : "";
    return "    { name = " + quoted(name) + ", type = " + quoted(type) + ", unit = " + quoted(unit) + limit +
           " },\n";
}

} // namespace

std::string dissector_tables()
{
    std::string out = "-- Generated from shared/wire by `make dissector`; do not edit.\n-- Protocol " +
                      std::to_string(CRN_WIRE_PROTOCOL_MAJOR) + "." + std::to_string(CRN_WIRE_PROTOCOL_MINOR);
    out += ", schema hash " + crn::hex_text(crn_wire_schema_hash()) + "\n";
    out += "local records, choices, messages, faults, rejects = {}, {}, {}, {}, {}\n";
#define RECORD(name, text) out += "records." #name " = { fields = {\n";
#define MESSAGE(name, number, direction, text)                                                               \
    out += "messages[" #number "] = { name = " + quoted(#name) + ", from = " + quoted(direction) +           \
           ", fields = {\n";
#define FIELD(owner, type, name, unit, text) out += field(#name, #type, unit, 0, 0);
#define ARRAY(owner, type, name, max, unit, text) out += field(#name, #type, unit, max, 2);
#define LIST(owner, type, name, max, unit, text) out += field(#name, #type, unit, max, 1);
#define END(owner) out += "} }\n";
#define CHOICE(name, text) out += "choices." #name " = {\n";
#define OPTION(choice, record, kind, text) out += "    [" #kind "] = " + quoted(#record) + ",\n";
#define CHOICE_END(choice) out += "}\n";
#include "shared/wire/wire_messages.def"
#define FAULT(NAME, code, effect, safe_ms, test, text, detection, remedy)                                    \
    out += "faults[" #code "] = " + quoted(#NAME ": " text) + "\n";
#define REJECT(NAME, code, text, remedy) out += "rejects[" #code "] = " + quoted(#NAME ": " text) + "\n";
#include "shared/wire/wire_faults.def"
    return out + "\n";
}
