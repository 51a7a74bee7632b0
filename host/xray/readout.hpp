// Converts counted quanta to raw values and to the picture on the screen: blur by the scintillator, lag,
// gain, display curve, window and level.
#pragma once
#include "host/xray/chain.hpp"

namespace crn
{

// Computes the raw values, display values and grey values (`raw`, `shown`, `grey`) of a picture whose photons
// have been counted. If `memory` is nullptr, the picture has no lag. If `memory` is not null, its array of
// traps must have the size of the picture.
void read_out(const XrayChain &chain, const XrayDisplay &display, XrayMemory *memory, XrayPicture &picture);

} // namespace crn
