// A check of messages and reports, for the tests of this room.
#pragma once
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string>
extern "C" {
#include <cmocka.h>
}

namespace crn::bake::tests
{

// Fails unless the text has every part.
inline void contains(const std::string &text, std::initializer_list<const char *> parts)
{
    for (const char *part : parts)
        if (text.find(part) == std::string::npos) fail_msg("\"%s\" does not say \"%s\"", text.c_str(), part);
}

} // namespace crn::bake::tests
