// What the syringe was asked for, tick by tick, in whole nanolitres: the same on every machine and in every
// replay.
#pragma once
#include "host/effects/contrast_flow.hpp"
#include <cstdint>
#include <vector>

namespace crn
{

class Injector
{
  public:
    // From `tick` on, so much at this rate (1 ul/s is 1 nl per tick). Two at a time add. Returns what
    // cancel() takes.
    std::uint64_t inject(std::uint32_t tick, std::int32_t volume_ul, std::int32_t rate_ul_s,
                         double iodine_mg_per_ml);
    // Nothing of what was asked for up to now is given after `tick`.
    void stop(std::uint32_t tick);
    void cancel(std::uint64_t injection); // what is left of it is not given
    bool is_empty() const { return injections_.empty(); }
    std::uint32_t first_tick() const; // of what is left; not when it is empty
    // What should have gone in before `tick` is left out: a session that is looked at from its middle.
    void skip_to(std::uint32_t tick);
    // During the tick that ends at `tick`.
    InjectedFluid take(std::uint32_t tick);
    double injected_ml() const { return static_cast<double>(injected_nl_) * 1e-6; }

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
