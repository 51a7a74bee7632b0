// The HID interface of a rig that lies, as hidapi would give it.
#pragma once
#include "hil_tests/lies/lie.hpp"
#include "host/link/hid_rig.hpp"
#include <functional>

namespace hil
{

// One at a time; the functions know no user data.
crn::HidApi lying_hid(const Lie &lie, std::function<void()> struck);

} // namespace hil
