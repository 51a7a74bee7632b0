// Simulates what wounds of the vessels do to the blood and to the contrast medium in it
// (docs/complications.md). Through a hole, blood and medium leave into the tissue; the medium stays there as
// a blush. A flap narrows the lumen, and a pocket behind it fills with medium and holds it.
//
//   dV/dt = g p            blood through a hole: conductance g, pressure p above the veins
//   dm/dt = c g p          iodine in the blush: concentration c in the blood before the hole
//   dm/dt = (c V - m) / t  iodine in a pocket of volume V: t is short while it fills, long while it empties
#pragma once
#include "host/base/state_archive.hpp"
#include "host/effects/flow_network.hpp"
#include <span>
#include <vector>

namespace crn
{

struct WallHole {
    std::size_t cell = 0;
    double ml_s_per_mmHg = 0.0; // its conductance while it is open
    double seal_s = 600.0;      // without pressure for so long, it closes
    // For the picture: the way out of the vessel, the diameter, and the iodine in the middle of the blush.
    Eigen::Vector3d outward = Eigen::Vector3d::UnitX();
    double diameter_mm = 0.0, blush_mg_per_ml = 100.0;
    bool is_jet = false; // medium leaves it as a visible jet
    // Results:
    double stopped_s = 0.0; // for how long no blood has passed it
    double flow_ml_s = 0.0, leaked_ml = 0.0, iodine_mg = 0.0;

    // It closes in proportion to the time without blood, which clots in it meanwhile.
    double open_share() const { return stopped_s < seal_s ? 1.0 - stopped_s / seal_s : 0.0; }
};

struct WallFlap {
    std::size_t begin = 0, end = 0; // consecutive cells of one branch
    double narrowing = 0.0;         // share of the lumen's diameter that it takes: 0 to 1
    double pocket_ml = 0.0;         // volume behind the flap
    double fill_s = 1.0, empty_s = 60.0;
    Eigen::Vector3d side = Eigen::Vector3d::UnitX(); // of the lumen on which it lies
    double iodine_mg = 0.0;                          // result: in the pocket

    double pocket_mg_per_ml() const { return pocket_ml > 0.0 ? iodine_mg / pocket_ml : 0.0; }
};

void archive_hole(StateArchive &state, WallHole &hole, std::size_t cells);
void archive_flap(StateArchive &state, WallFlap &flap, std::size_t cells);

// Returns the volume of the pocket behind a flap that narrows these cells: the part of the healthy lumen that
// the flap takes.
double pocket_ml(const FlowCells &cells, std::size_t begin, std::size_t end, double narrowing);

// Simulates all wounds of the vessels.
class Wounds
{
  public:
    bool is_empty() const { return holes_.empty() && flaps_.empty(); }
    const std::vector<WallHole> &holes() const { return holes_; }
    const std::vector<WallFlap> &flaps() const { return flaps_; }
    bool is_bleeding() const; // there is a hole through the whole wall
    double leaked_ml() const;
    double tissue_mg() const; // iodine in all blushes
    double pocket_mg() const; // iodine in all pockets

    // Adds the hole or flap, or changes the one with this index; its results stay.
    void set_hole(std::size_t index, const WallHole &hole);
    void set_flap(std::size_t index, const WallFlap &flap);

    // Returns the holes as far as they are open now, and the share of each cell's radius that the flaps
    // leave.
    std::vector<CellHole> open_holes() const;
    std::vector<double> open_shares(std::size_t cells) const; // empty: no flap

    // Takes the share of one run's leak, in `ml` of blood with `mg` of iodine, that belongs to its holes.
    void leak(std::size_t cell, double ml, double mg);
    // Advances the times of the holes, with the pressure in each hole's cell from the network's last
    // solution.
    void pass(const FlowNetwork &network, double dt_s);
    // Exchanges iodine between the pockets and the two layers of blood before them.
    void exchange(std::span<const double> volume_ml, std::span<double> core_mg, std::span<double> wall_mg,
                  double dt_s);

    void archive(StateArchive &state, std::size_t cells);

  private:
    std::vector<WallHole> holes_;
    std::vector<WallFlap> flaps_;
};

} // namespace crn
