// Names of instructions: what the name says of operands, flags and condition.
#pragma once
#include <optional>
#include <string>

namespace chip
{

enum class Form {
    compute,
    move,
    compare,
    shift,
    bits,
    product,
    accumulate,
    long_accumulate,
    divide,
    load,
    narrow,
    load_two,
    store,
    store_two,
    load_many,
    store_many,
    branch,
    test_branch,
    nothing
};

struct Name {
    Form form = Form::nothing;
    std::string base;
    bool sets_flags = false, is_conditional = false;
};

// A mnemonic is a name, then `s` where it sets the flags, then a condition, then a width such as ".w".
// Returns nothing for a name that is not known.
std::optional<Name> name_of(const std::string &mnemonic);

} // namespace chip
