// Simulates a balloon-expandable stent in a moving vessel. The stent is first crimped, then opened by its
// balloon, deployed, and held by the wall. One step per picture.
//
//   Stent stent(read_stent("coronary_3_0x18.toml"), mount_arc_mm);
//   stent.step({&wall, &pose, others, sleeves});     every picture, 15 to 60 a second
//   stent.points(), stent.stage(), stent_lines(stent), stent_figures(stent, wall)
//
// The state of the stent depends on the sequence of steps (one per picture) and not on time, because masses
// of micrograms reach equilibrium at once. Equal sequences of steps give results that are equal bit for bit.
// Lengths are in mm and forces in N, in the patient's coordinates: docs/stent.md.
#pragma once
#include "host/stent/balloon_axis.hpp"
#include "host/stent/design.hpp"
#include "host/stent/lattice.hpp"
#include "host/stent/wall.hpp"
#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

namespace crn
{

enum class StentStage : std::uint8_t {
    on_balloon, // crimped, or being opened
    deployed,   // off its balloon, held by the wall
    stripped,   // slid off its balloon before it was opened: lost
    adrift,     // released where no wall holds it: lost
};

struct StentPoint {
    Eigen::Vector3d place_mm = Eigen::Vector3d::Zero();
    double peak_mm = 0.0; // largest radius reached on the balloon
    WallFoot foot;        // place where the wall carries it, or where it is held; when deployed
    Eigen::Vector3d offset_mm = Eigen::Vector3d::Zero(); // offset from there at the end of the step
    double layer_mm = 0.0;                               // thickness of another stent between it and the wall
    double slid_mm = 0.0;   // distance slid over the wall since the triangles near its struts were listed
    bool is_bedded = false; // held in the wall's lining
};

// Describes an outer stent as a sleeve, inside which another stent lies.
struct StentSleeve {
    std::vector<Eigen::Vector3d> centres_mm; // of its rings
    double overhang_mm = 0.0;                // beyond the first and the last
    double thickness_mm = 0.0;
    bool covers(const Eigen::Vector3d &place_mm) const;
};

// Describes a balloon inside the stent, and the thickness of another stent that lies on that balloon.
struct StentBalloon {
    const BalloonPose *pose = nullptr;
    double layer_mm = 0.0;
};

// The inputs of a step. The wall, the balloons and the outer stents (sleeves) are optional inputs of a step.
struct StentSurroundings {
    const StentWall *wall = nullptr;
    const BalloonPose *own = nullptr;            // the balloon that carries it
    std::span<const StentBalloon> balloons = {}; // others that may lie in it
    std::span<const StentSleeve> sleeves = {};
};

// Holds those parts of a stent's state on which its next step depends.
struct StentState {
    StentStage stage = StentStage::on_balloon;
    bool was_placed = false;
    double slip_mm = 0.0; // slip of the stent on its balloon, towards the hub
    Eigen::Vector3d across = Eigen::Vector3d::UnitX();
    std::vector<StentPoint> points;
    std::vector<double> rest_mm;      // of every spring
    std::vector<std::uint32_t> patch; // triangles that it may meet
    std::vector<std::uint32_t> near_begin,
        near; // of every strut: the nearby triangles, by index in the patch
    std::vector<Eigen::Vector3d> ring_centre_mm; // on the balloon, in the previous picture
};

class Stent
{
  public:
    // `mount_arc_mm` is the position of the stent's middle on its tool, measured from the tool's tip.
    Stent(const StentDesign &design, double mount_arc_mm);
    void step(const StentSurroundings &around);

    const StentDesign &design() const { return design_; }
    const StentLattice &lattice() const { return lattice_; }
    StentStage stage() const { return state_.stage; }
    bool is_on_balloon() const { return state_.stage == StentStage::on_balloon; }
    bool was_placed() const { return state_.was_placed; } // its points have been placed
    std::span<const StentPoint> points() const { return state_.points; }
    double mount_arc_mm() const { return mount_arc_mm_ + state_.slip_mm; }
    double slip_mm() const { return state_.slip_mm; }

    // Returns the radius at which a point of the stent lies when no force acts on the stent.
    double free_radius_mm(const StentPoint &point) const;
    bool is_opened(int ring) const;
    // The next functions return the middle of a ring, and the direction of its axis towards the hub, as a
    // unit vector.
    Eigen::Vector3d ring_centre_mm(int ring) const;
    Eigen::Vector3d ring_axis(int ring) const;
    // Returns the middle of a strut; the strut is bent, because the balloon opened the stent around itself.
    Eigen::Vector3d strut_middle_mm(std::size_t strut) const;
    StentSleeve sleeve() const;
    // Returns the elastic energy of the stent in N mm, which is the sum of k/2 (length - resting length)^2
    // over all springs.
    double energy_N_mm() const;

    const StentState &state() const { return state_; }
    // Returns, as bytes, the whole state of the stent on which its next step depends. The function restore()
    // refuses a snapshot of another stent design.
    std::vector<std::uint8_t> snapshot() const;
    bool restore(std::span<const std::uint8_t> bytes);
    // Returns false if the stent's state refers to a triangle that does not exist in a wall with this number
    // of triangles.
    bool fits(std::size_t triangle_count) const;

  private:
    friend class StentRelaxation;
    struct Layout { // of the rings on the balloon: arc of the crowns on either side, and their radii
        std::vector<double> tip_arc_mm, hub_arc_mm;
        std::vector<double> tip_radius_mm, hub_radius_mm;
    };
    void carry(const StentWall &wall);
    void follow(const StentSurroundings &around, const BalloonAxis &axis);
    double radius_on(const BalloonAxis &axis, double arc_mm, int ring, int side) const;
    Layout lay_out(const BalloonAxis &axis) const;
    void slide(const BalloonAxis &axis);
    bool has_separated(const BalloonAxis &axis) const;
    std::vector<std::uint32_t> patch_of(const StentWall &wall) const;
    void deploy(const StentSurroundings &around);
    void settle_stage();

    StentDesign design_;
    StentLattice lattice_;
    double mount_arc_mm_;
    StentState state_;
};

} // namespace crn
