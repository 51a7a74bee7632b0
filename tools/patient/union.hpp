// Makes one closed lumen of the parts of an atlas: walls become the lumen inside them, openings are capped,
// parts that overlap become one, and short gaps between them are bridged.
#pragma once
#include "tools/mesh/progress.hpp"
#include "tools/patient/parts.hpp"

#include <optional>

namespace crn::patient
{

struct UnionWish {
    std::string walls = "auto"; // "auto", "lumen": every part is a lumen; "wall": every part is a wall
    double solid_mm = 0;        // voxel of the level set; 0: by the size of the vessels
    double bridge_mm = 3;       // gaps up to this wide are bridged; 0: none
    std::optional<Eigen::Vector3d> inlet_mm; // the piece nearest to it is kept; otherwise the largest
};

struct WholeLumen {
    bake::Mesh surface;          // as the mesh gives it, with its openings, or closed
    bake::Mesh closed;           // for the scene
    std::vector<bake::Mesh> own; // closed lumen of each part, in the order of the parts
    bool is_remade = false;      // from a level set
};

// Throws Fault if no closed surface comes of the parts.
WholeLumen whole_lumen(const std::vector<Part> &parts, const UnionWish &wish, Choices &choices,
                       bake::Progress &progress);

} // namespace crn::patient
