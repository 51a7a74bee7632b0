// Describes what moves in the picture: tools along their common centreline, struts and contrast medium as
// curves, and bodies that beat with the heart.
#pragma once
#include "host/model/wire_frame.hpp"
#include "host/xray/paths/materials.hpp"
#include "host/xray/paths/tube_labels.hpp"
#include <span>
#include <vector>

namespace crn
{

// Describes how X-rays see one stretch of a tool; arc lengths from the tool's tip give the ends of the
// stretch. A coil is described as a tube that metal fills partly. A braided wall is described as two sections
// over the same stretch, one of polymer and one of steel.
struct RadiopaqueSection {
    double arc_begin_m = 0.0;
    double arc_end_m = 3.0;
    Material material = Material::steel;
    double fill = 0.75;        // share of the cross-section filled by the material, 0 .. 1
    double radius_share = 1.0; // of the tool's outer radius; above 1: a band around it
    // Holds the inner radius of a tool's section, as a fraction of the tool's outer radius. A section with an
    // inner radius above 0 is a ring around this radius, such as a jacket or a marker band; `fill` is the
    // filled fraction of the ring. A section with the inner radius 0 reaches inwards to the lumen; `fill` is
    // the filled fraction of the tool's whole cross-section.
    double inner_radius_share = 0.0;
};

// Holds a tool's outer and inner radius at an arc length from the tool's tip. Between two entries of a list
// of radii, the radii change linearly; two entries at the same arc length make a step.
struct RadiopaqueRadius {
    double arc_m = 0.0;
    double outer_m = 0.0;
    double inner_m = 0.0; // of the lumen, where nothing is drawn; 0: solid
};

struct RadiopaqueInstrument {
    std::vector<RadiopaqueSection> sections; // may overlap: a core wire inside a coil
    std::vector<RadiopaqueRadius> radii;     // empty: the nodes' radius, solid
};

// Returns the X-ray properties of a typical guidewire: core and coil are of steel, and the last `tip_m` of
// the coil are of platinum.
RadiopaqueInstrument guidewire_look(double tip_m = 0.03);

// A point of a curve. From one point of the curve to the next, the radius and the filled fraction of the
// cross-section change linearly.
struct SweptPoint {
    Eigen::Vector3d at_m;
    double radius_m = 0.0;
    double share = 1.0; // of the cross-section that the material fills, 0 .. 1
};

// Describes a round body along a chain of straight pieces, such as a strut of a stent, or the contrast medium
// in a stretch of vessel. A curve is drawn without triangles, by exact path lengths, so that a picture can
// have hundreds of curves.
struct SweptCurve {
    Material material = Material::steel;
    // At least one; a curve that is not finite is left out. A curve with a single point is a soft ball of
    // contrast medium (tube_faint.hpp): the point's radius is the ball's, and its share that of the ball's
    // middle.
    std::vector<SweptPoint> points;
    bool is_fine = false; // contrast medium in a small vessel, drawn as a line of about a pixel
};

// Returns the volume fraction of iohexol 350 in blood that contains the given concentration of iodine.
double contrast_share(double iodine_mg_per_ml);

// Holds the new positions of the vertices of a body. The number of vertices must equal that of the scene's
// body, because the triangles keep their vertex indices. A moved body with another number of vertices is
// ignored.
struct MovedBody {
    int body = 0; // index in Bodies
    std::span<const Eigen::Vector3i> vertices_um;
};

// Holds everything that moves in a picture, in its position at the tick (millisecond) of the WireFrame.
struct XrayFrame {
    std::span<const RadiopaqueInstrument>
        tools; // from the innermost out, each over its part of the line (wire.tip_arc_m)
    const WireFrame &wire;
    std::span<const SweptCurve> curves = {};
    std::span<const MovedBody> bodies = {};
    TubeLabels *labels = nullptr; // receives the label image of tools and curves
};

} // namespace crn
