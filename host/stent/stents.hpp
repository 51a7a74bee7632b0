// Holds all stents of a session: the stent on the balloon in the patient, and the stents that were deployed
// before. The class also computes, for the core, how far the stents hold a lesion open.
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
#include <utility>
#include <vector>

namespace crn
{

// A stent holds a lesion open: its points `first` to `last` cannot become narrower than open_256 / 256, where
// 0 is the opening in the scene file and 1 that of the healthy vessel. The points of a lesion ("stations")
// are evenly spaced from the lesion's beginning to its end. The opening of a station has steps of 1/256, so
// that every machine sends the core the same command.
struct StentHold {
    std::uint32_t first = 0, last = 0;
    std::uint32_t open_256 = 0;
};

class Stents
{
  public:
    Stents() = default;
    explicit Stents(std::vector<Stent> stents) : stents_(std::move(stents)) {}

    // If the previously added stent is still on its balloon, that stent leaves the patient together with the
    // balloon.
    void add(const StentDesign &design, double mount_arc_mm);
    // Removes the stent that was added last from the patient, if it is still on its balloon.
    void take_out();
    void step(const StentWall *wall, const BalloonPose *balloon);
    // Advances each stent by one step with its own wall, because stents may lie in several vessels. `walls`
    // has one entry per stent; a null entry means that the stent lies in no vessel.
    void step(std::span<const StentWall *const> walls, const BalloonPose *balloon);

    std::size_t size() const { return stents_.size(); }
    const Stent &operator[](std::size_t i) const { return stents_[i]; }
    std::span<const Stent> all() const { return stents_; }

    // Returns how far the opened rings hold a lesion open, for a lesion with this number of stations (evenly
    // spaced points). Neighbouring stations (points) of the lesion that are held equally far open are merged
    // into one entry of the returned list. A ring that is still on the balloon counts with its width after
    // deflation, which is its present width minus the recoil. `open` holds the present opening of each
    // station of the lesion, 0 .. 1. A stent opens no lesion by itself, so it holds each station (point) of a
    // lesion only as far open as the station is now. If `open` is empty, each ring holds the lesion open with
    // the ring's full width.
    std::vector<StentHold> holds(const VesselWall &vessel, std::size_t lesion, std::uint32_t stations,
                                 std::span<const double> open = {}) const;

    // The snapshot contains the states of all stents; restore() requires the same stents in the same order.
    std::vector<std::uint8_t> snapshot() const;
    bool restore(std::span<const std::uint8_t> bytes);

  private:
    std::vector<Stent> stents_;
};

} // namespace crn
