// A reason why a scene cannot be baked: one sentence with file, element and remedy. bake's main prints it and ends with 1.
// May include: nothing. Called by: tools/bake.
#pragma once
#include <stdexcept>
#include <string>

namespace seld::bake
{

struct Fault : std::runtime_error {
    using std::runtime_error::runtime_error;
};

} // namespace seld::bake
