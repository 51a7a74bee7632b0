// All stents of a session: the one on the balloon in the patient, and those that were deployed before. They
// also give what the core needs: how far they hold a lesion open.
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

// Stations first .. last of a lesion (evenly from its beginning to its end) cannot close below this: 0 as
// baked .. 1 healthy. It has steps of 1/256, so that every machine gives the core the same order.
struct StentHold {
    std::uint32_t first = 0, last = 0;
    std::uint32_t open_256 = 0;
};

class Stents
{
  public:
    // A stent that was still on the previous balloon leaves the patient with it.
    void add(const StentDesign &design, double mount_arc_mm);
    void step(const StentWall *wall, const BalloonPose *balloon);
    // Does the same with one wall for each stent, since stents may lie in several vessels. There are as many
    // walls as stents; null means no wall.
    void step(std::span<const StentWall *const> walls, const BalloonPose *balloon);

    std::size_t size() const { return stents_.size(); }
    const Stent &operator[](std::size_t i) const { return stents_[i]; }
    std::span<const Stent> all() const { return stents_; }

    // Returns how far opened rings hold a lesion of so many stations open; neighbours that are held alike are
    // merged. Rings on the balloon count with the width that they will have when it deflates: their width
    // less the recoil. `open` gives how far each station is open now, 0 .. 1. Stents open nothing by
    // themselves, and hold no more than that; if `open` is empty, they hold the full width of their rings.
    std::vector<StentHold> holds(const VesselWall &vessel, std::size_t lesion, std::uint32_t stations,
                                 std::span<const double> open = {}) const;

    // Works like Stent's snapshot, for the same stents in the same order.
    std::vector<std::uint8_t> snapshot() const;
    bool restore(std::span<const std::uint8_t> bytes);

  private:
    std::vector<Stent> stents_;
};

} // namespace crn
