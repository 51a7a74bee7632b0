// toml++, for texts that anyone may have written. Its assertions are meant for its own developers, but some fail on texts that it
// then refuses properly (a lone '['), and would end the program.
// May include: nothing of ours. Called by: whoever reads TOML.
#pragma once
#define TOML_ASSERT(expr) static_cast<void>(0)
#include <toml++/toml.h>
