// Converts counted quanta to raw values and to the screen: the scintillator's blur, lag, gain, display curve,
// window and level.
#pragma once
#include "host/xray/chain.hpp"

namespace crn
{

// Fills raw, shown and grey of a picture whose photons are counted. Without `memory` (nullptr) there is no
// lag; otherwise its traps must fit the picture's size.
void read_out(const XrayChain &chain, const XrayDisplay &display, XrayMemory *memory, XrayPicture &picture);

} // namespace crn
