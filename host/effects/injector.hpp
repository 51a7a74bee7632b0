// Supplies the injected fluid tick by tick, in whole nanolitres, so that it is the same on every machine and
// in every replay.
#pragma once
#include "host/base/state_archive.hpp"
#include "host/effects/contrast_flow.hpp"
#include <cstdint>
#include <vector>

namespace crn
{

class Injector
{
  public:
    // Starts an injection of this volume at this rate at `tick` (1 ul/s is 1 nl per tick). Two simultaneous
    // injections add up. Returns the number of the injection, which cancel() needs.
    std::uint64_t inject(std::uint32_t tick, std::int32_t volume_ul, std::int32_t rate_ul_s,
                         double iodine_mg_per_ml);
    // Ends, at `tick`, all injections that were commanded so far.
    void stop(std::uint32_t tick);
    void cancel(std::uint64_t injection); // the rest of it is not given
    bool is_empty() const { return injections_.empty(); }
    std::uint32_t first_tick() const; // of the remaining injections; only when there are any
    // Drops the fluid that is due before `tick`, for a replay that shows a session only from that tick on.
    void skip_to(std::uint32_t tick);
    // Returns the fluid that is injected during the tick (millisecond) that ends at time `tick`.
    InjectedFluid take(std::uint32_t tick);
    double injected_ml() const { return static_cast<double>(injected_nl_) * 1e-6; }
    void archive(StateArchive &state);

  private:
    struct Injection {
        std::uint64_t number = 0;
        std::uint32_t tick = 0, tick_end = UINT32_MAX;
        std::int64_t left_nl = 0, rate_nl = 0;
        double iodine_mg_per_ml = 0.0;
    };
    void drop_ended();
    std::vector<Injection> injections_;
    std::int64_t injected_nl_ = 0;
    std::uint64_t asked_ = 0; // injections
};

} // namespace crn
