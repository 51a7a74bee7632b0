// Simulates the HID interface of a rig that sends false reports, with the functions of hidapi.
#pragma once
#include "hil_tests/lies/lie.hpp"
#include "host/link/hid_rig.hpp"
#include <functional>

namespace hil
{

// Only one simulated HID interface can exist at a time, because hidapi's functions pass no user data to the
// simulation.
crn::HidApi lying_hid(const Lie &lie, std::function<void()> struck);

} // namespace hil
