// Makes random sessions that `cournand run` would accept: tools that fit into each other, a route into the
// vessels, and actions of hands, inflator, syringe, heart and X-ray room. With the same seed and index, the
// session is the same on every machine (docs/soak.md).
#pragma once
#include "hil_tests/soak/catalogue.hpp"
#include "hil_tests/soak/drawn.hpp"

namespace soak
{

// In a random session, no hand moves or turns faster than the following speeds.
inline constexpr int speed_max_mm_s = 250, turn_max_deg_s = 687; // 12 rad/s

struct DrawSettings {
    int seconds_min = 25, seconds_max = 65; // of the session, as far as it can be predicted
};

// Throws std::runtime_error if the catalogue is empty.
DrawnSession draw_session(const Catalogue &catalogue, std::uint64_t seed, std::uint32_t index,
                          const DrawSettings &settings = {});

} // namespace soak
