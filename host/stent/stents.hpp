// All stents of a session: the one on the balloon that is in the patient, and those that were deployed
// before. And what the core has to know of them: how far they hold a lesion open.
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
// baked .. 1 healthy, in steps of 1/256, so that an order for the core is the same whatever machine found it.
struct StentHold {
    std::uint32_t first = 0, last = 0;
    std::uint32_t open_256 = 0;
};

class Stents
{
  public:
    // A stent that was still on the balloon before goes out of the patient with it.
    void add(const StentDesign &design, double mount_arc_mm);
    void step(const StentWall *wall, const BalloonPose *balloon);
    // The same with a wall for each: stents may lie in several vessels. As many as there are stents; null:
    // none.
    void step(std::span<const StentWall *const> walls, const BalloonPose *balloon);

    std::size_t size() const { return stents_.size(); }
    const Stent &operator[](std::size_t i) const { return stents_[i]; }
    std::span<const Stent> all() const { return stents_; }

    // What rings that were opened hold open of a lesion with so many stations, neighbours that are held alike
    // as one. On the balloon they hold what they will when it goes: the width less the recoil. `open`: how
    // far each station is open now, 0 .. 1. Stents open nothing by themselves, and hold no more than that;
    // empty: they hold whatever their rings are wide.
    std::vector<StentHold> holds(const VesselWall &vessel, std::size_t lesion, std::uint32_t stations,
                                 std::span<const double> open = {}) const;

    // As Stent's: of the same stents in the same order.
    std::vector<std::uint8_t> snapshot() const;
    bool restore(std::span<const std::uint8_t> bytes);

  private:
    std::vector<Stent> stents_;
};

} // namespace crn
