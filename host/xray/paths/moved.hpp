// Objects that move from picture to picture: tools on the wire, curves of struts and contrast medium, and
// bodies that beat.
#pragma once
#include "host/model/wire_frame.hpp"
#include "host/xray/paths/materials.hpp"
#include <span>
#include <vector>

namespace crn
{

// One stretch of a tool by arc length from the tool's tip. A coil is a tube that metal fills partly; a
// braided wall is two sections over the same stretch, polymer and steel.
struct RadiopaqueSection {
    double arc_begin_m = 0.0;
    double arc_end_m = 3.0;
    Material material = Material::steel;
    double fill = 0.75;        // share of the cross-section filled by the material, 0 .. 1
    double radius_share = 1.0; // of the tool's outer radius; above 1: a band around it
    // The inner radius is a share of the tool's outer radius. Above 0 the section is a ring outside this
    // radius and `fill` counts the ring alone (a jacket, a marker band). At 0 it reaches down to the lumen,
    // and `fill` counts the whole cross-section.
    double inner_radius_share = 0.0;
};

// Radii at an arc length from the tool's tip, linear in between; two at the same place make a step.
struct RadiopaqueRadius {
    double arc_m = 0.0;
    double outer_m = 0.0;
    double inner_m = 0.0; // of the lumen, where nothing is drawn; 0: solid
};

struct RadiopaqueInstrument {
    std::vector<RadiopaqueSection> sections; // may overlap: a core wire inside a coil
    std::vector<RadiopaqueRadius> radii;     // empty: the nodes' radius, solid
};

// Returns the look of a working guidewire: steel core and coil, with the last `tip_m` of the coil in
// platinum.
RadiopaqueInstrument guidewire_look(double tip_m = 0.03);

// A point of a curve. Radius and share change linearly to the next point.
struct SweptPoint {
    Eigen::Vector3d at_m;
    double radius_m = 0.0;
    double share = 1.0; // of the cross-section that the material fills, 0 .. 1
};

// A round body along a line of straight pieces: a stent's strut, or the contrast medium in a stretch of
// vessel. It is drawn directly by exact chords without making triangles, so that a picture can hold hundreds
// of them.
struct SweptCurve {
    Material material = Material::steel;
    std::vector<SweptPoint> points; // two at least; a curve that is not finite is left out
};

// Returns the share of iohexol 350 in blood that contains this much iodine.
double contrast_share(double iodine_mg_per_ml);

// Other vertices for a body of the scene: as many as it has, since its triangles stay. Entries that do not
// fit are left out.
struct MovedBody {
    int body = 0; // index in Bodies
    std::span<const Eigen::Vector3i> vertices_um;
};

// All moving parts at the tick of the wire frame.
struct XrayFrame {
    std::span<const RadiopaqueInstrument>
        tools; // from the innermost out, each over its part of the line (wire.tip_arc_m)
    const WireFrame &wire;
    std::span<const SweptCurve> curves = {};
    std::span<const MovedBody> bodies = {};
};

} // namespace crn
