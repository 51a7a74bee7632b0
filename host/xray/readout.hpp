// Converts counted quanta to raw values and to the picture on the screen: blur by the scintillator, lag,
// gain, display curve, window and level.
#pragma once
#include "host/xray/chain.hpp"

namespace crn
{

// Computes `raw`, `shown` and `grey` of a picture whose photons have been counted. Without `memory` (nullptr)
// there is no lag. Otherwise the traps in the memory must fit the size of the picture.
void read_out(const XrayChain &chain, const XrayDisplay &display, XrayMemory *memory, XrayPicture &picture);

} // namespace crn
