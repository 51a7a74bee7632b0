// Holds all stents of a session: the one on the balloon in the patient, and those that were deployed before
// it. The class also computes, for the core, how far the stents hold a lesion open.
//
//   Stents stents;
//   stents.add(read_stent(path), mount_arc_mm);          with the balloon that carries it
//   stents.step(&vessel.wall(), &balloon);               every picture; null where there is no wall or no balloon
//   for (const StentHold &hold : stents.holds(vessel, lesion, stations)) ...
#pragma once
#include "host/stent/stent.hpp"
#include "host/stent/vessel_wall.hpp"
#include <cstdint>
#include <span>
#include <vector>

namespace crn
{

// The stations `first` to `last` of a lesion cannot become narrower than this: 0 is as baked, 1 is healthy.
// Stations are evenly spaced from the lesion's beginning to its end. The value has steps of 1/256, so that
// every machine sends the core the same order.
struct StentHold {
    std::uint32_t first = 0, last = 0;
    std::uint32_t open_256 = 0;
};

class Stents
{
  public:
    // If the stent added before is still on its balloon, it leaves the patient with that balloon.
    void add(const StentDesign &design, double mount_arc_mm);
    void step(const StentWall *wall, const BalloonPose *balloon);
    // Advances the stents with a wall for each of them, because stents may lie in several vessels. There are
    // as many walls as stents; a null wall means that the stent lies in no vessel.
    void step(std::span<const StentWall *const> walls, const BalloonPose *balloon);

    std::size_t size() const { return stents_.size(); }
    const Stent &operator[](std::size_t i) const { return stents_[i]; }
    std::span<const Stent> all() const { return stents_; }

    // Returns how far the opened rings hold a lesion with this number of stations open. Neighbouring stations
    // with equal values are merged. A ring that is still on the balloon counts with the width that it will
    // have after deflation, which is its present width minus the recoil. `open` gives how far each station is
    // open now, 0 .. 1. A stent opens nothing by itself, so it holds a station no farther open than it is. If
    // `open` is empty, each ring holds its full width.
    std::vector<StentHold> holds(const VesselWall &vessel, std::size_t lesion, std::uint32_t stations,
                                 std::span<const double> open = {}) const;

    // The snapshot works as for one Stent; restore() requires the same stents in the same order.
    std::vector<std::uint8_t> snapshot() const;
    bool restore(std::span<const std::uint8_t> bytes);

  private:
    std::vector<Stent> stents_;
};

} // namespace crn
