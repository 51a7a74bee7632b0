// Instrument files (TOML, docs/instruments.md) -> the numbers of the wire's `instrument` message.
//
// Every physical value stands as { value = ..., source = "..." } or { from = ..., to = ..., source = "..." } with its
// unit in the key. Errors name file, line, section and key.
// May include: shared/wire, text. Called by: host/app, tools.
#pragma once
#include "shared/wire/wire.h"
#include <string>
#include <vector>

namespace seld
{

// What the X-ray sees of one stretch: a share of the cross-section filled with a material.
struct InstrumentLayer {
    double arc_begin_m = 0.0; // from the distal tip
    double arc_end_m = 0.0;
    std::string material;      // name as in docs/xray.md
    double fill = 1.0;         // share of the layer's cross-section, 0 .. 1
    double radius_share = 1.0; // of the outer radius, 0 .. 1
};

struct Instrument {
    std::string name;
    double length_m = 0.0;
    seld_wire_instrument table{}; // validated by the device
    std::vector<InstrumentLayer> layers;
};

// Throws FileError.
Instrument read_instrument(const std::string &path);

} // namespace seld
