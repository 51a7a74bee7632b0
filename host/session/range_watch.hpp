// Did the physics stay in its range? Looks at every tick of a session: a number of the core at its format's
// limit, a tool too deep in the wall or a line too long or too short mean that the shape is no longer that of
// the tools, and the session must not go on as if it were.
#pragma once
#include "shared/wire/wire.h"
#include <Eigen/Core>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

namespace crn
{

struct VesselTree;
class Link;

inline constexpr int exit_out_of_range = 3; // of run, replay and view

struct RangeBreak {
    std::uint32_t tick = 0;     // the first one out of range, and what it had:
    bool is_saturated = false;  // CRN_FAULT_SATURATED of the core
    double penetration_m = 0.0; // deepest contact
    double length_error = 0.0;  // of the free part of the line
    // Soon after it, on a tick that every run and replay looks at: the node that the wall presses hardest;
    // none: it touches nowhere.
    std::optional<Eigen::Vector3d> place_m{};
    std::string branch{}; // of the vessel around it; empty: not known
};

class RangeWatch
{
  public:
    static constexpr double penetration_max_m = 1e-3, length_error_max = 0.01;
    static constexpr std::uint32_t look_every_ticks = 16;

    void take(const crn_wire_tick_state &state); // every tick, in order
    bool is_left() const { return left_.has_value(); }
    bool is_placed() const
    {
        return is_placed_;
    } // left, and its place is looked for: nothing more to wait for
    const std::optional<RangeBreak> &left() const { return left_; }
    // Is there a break whose place is wanted now? `is_last`: no later tick will be looked at.
    bool wants_place(std::uint32_t tick, bool is_last) const;
    // Asks the device where. Throws LinkError.
    void find_place(Link &link);
    // Names the branch, where the vessels are known.
    void name_branch(const VesselTree &vessels);

  private:
    std::optional<RangeBreak> left_;
    bool is_placed_ = false;
};

// "physics left its range at 00:12.3"
std::string range_notice(const RangeBreak &left);
// The same with tick, what it was, where, the limit and what to do.
std::string range_text(const RangeBreak &left);
// For the report; null: it stayed in its range.
nlohmann::ordered_json range_report(const std::optional<RangeBreak> &left);

} // namespace crn
