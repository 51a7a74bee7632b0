// This is the HID interface of a lying rig, in the form of hidapi.
#pragma once
#include "hil_tests/lies/lie.hpp"
#include "host/link/hid_rig.hpp"
#include <functional>

namespace hil
{

// Only one such interface can exist at a time, because the functions have no user data.
crn::HidApi lying_hid(const Lie &lie, std::function<void()> struck);

} // namespace hil
