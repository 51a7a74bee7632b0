/* A tree of vessels. Each vessel has a centreline through a list of points (stations), and a diameter at
 * every point. The functions in vessel_file.hpp read vessel trees from files. */
#pragma once
#include "tools/anatomy/skeleton.hpp"
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace anatomy
{

/* A point of a centreline. A point (station) without a name only defines the vessel's course and diameter,
 * and gives no source for the diameter. */
struct Station {
    Vec3 position_mm;
    double diameter_mm;
    std::string name;   // "": none
    std::string source; // source of the diameter of a named station; "assumed ..." when there is none better
};

enum class Bed { body, left_coronary, right_coronary, kidney, gut };

struct Vessel {
    std::string name;
    std::string parent; // the vessel in which it begins; "": blood enters the tree here
    Bed bed = Bed::body;
    std::vector<Station> stations; // at least two
    double flow_ml_min = 0;        // mean flow out of its end; 0: not stated
    bool is_lumen = true;          // false: picture and flow only, and no part of the lumen
    double winding = 0;            // of a small vessel: length over that of its stated course; 0: not stated
    std::string joins = {}; // of a small artery: the small artery that its end passes its blood to; "": none
};

/* Describes a tree of vessels, with the point where a guidewire enters the tree from the introducer sheath.
 */
struct VesselTree {
    std::string title;
    std::string made_by;         // the words behind `anatomy` on the command line, for the scene's first line
    std::string file;            // the user's file; "" for a tree that ships
    bool is_in_patient = true;   // its frame is the modelled patient's; otherwise it is a phantom's own
    std::vector<Vessel> vessels; // the aorta or another inlet first, the coronary arteries last
    size_t coronary_count = 0;
    SkeletonShape skeleton;            // beside whose bones the small arteries run
    std::optional<std::uint64_t> seed; // of a drawn tree; draws what the small vessels leave to chance
    std::vector<Vessel>
        small;            // picture and flow only; each comes after its parent, which may be a vessel above
    double fillet_mm = 0; // width over which vessels are blended at their junctions
    double coronary_fillet_mm = 0; // the same where coronary arteries meet each other
    Vec3 entry_position_mm = Vec3::Zero(), entry_direction = Vec3::Zero();
};

/* body_vessels() returns all vessels except the coronary arteries. */
std::vector<Vessel> body_vessels(const VesselTree &tree);
std::vector<Vessel> coronary_arteries(const VesselTree &tree);

/* Returns the vessels moved with the spine beside which they run. */
std::vector<Vessel> moved_with_spine(std::vector<Vessel> vessels, const SpineBend &bend);

Curve vessel_curve(const Vessel &vessel, double step_mm);

/* Returns the space that blood fills in the whole tree, enlarged by wall_mm. */
Solid tree_solid(const VesselTree &tree, double wall_mm);

/* Returns the space that blood fills in the given vessels, enlarged by wall_mm. Where vessels join, their
 * surfaces are blended over a width of `fillet_mm`.
 */
Solid vessels_solid(const std::vector<Vessel> &vessels, double wall_mm, double fillet_mm);

} // namespace anatomy
