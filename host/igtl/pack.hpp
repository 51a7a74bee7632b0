// Writes an item as the bytes of one OpenIGTLink message. pack.cpp is the only file of the program that knows
// libOpenIGTLink.
#pragma once
#include "host/igtl/frame.hpp"

namespace crn
{

// Returns the whole message. The time stamp of the message is the time since the start of the session.
std::vector<std::uint8_t> pack_igtl(const std::string &name, const IgtlItem &item);

} // namespace crn
