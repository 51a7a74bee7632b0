// Watches whether the simulated physics stays in the range for which it is valid. Every tick of a session is
// checked. The physics leaves its range when a number in the core reaches the limit of its format, or a tool
// lies too deep in the wall. The physics also leaves its range when the nested tools become too long or too
// short. After the physics has left its range, the computed shape is no longer that of the tools, and the
// session must not continue.
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

inline constexpr int exit_out_of_range = 3; // exit code of run, replay and view

struct RangeBreak {
    std::uint32_t tick = 0;     // the first tick out of range, and its values:
    bool is_saturated = false;  // CRN_FAULT_SATURATED of the core
    double penetration_m = 0.0; // deepest contact
    double length_error = 0.0;  // of the free part of the line
    // Holds the position of the node with the largest wall force. The position of the largest wall force is
    // read shortly after the physics left its range, at the next tick that every run and every replay reads.
    // `place_m` is empty if the tools touch no wall.
    std::optional<Eigen::Vector3d> place_m{};
    std::string branch{}; // branch of the vessel around it; empty: not known
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
    } // the range was left and its place has been looked up: nothing remains to be done
    const std::optional<RangeBreak> &left() const { return left_; }
    // Returns true if the physics has left its range and the position of the largest wall force must be read
    // now. If `is_last` is true, no later tick will be read.
    bool wants_place(std::uint32_t tick, bool is_last) const;
    // Reads the position of the largest wall force from the device. Throws LinkError.
    void find_place(Link &link);
    // Adds the name of the vessel branch at the position of the largest wall force, if the vessels are known.
    void name_branch(const VesselTree &vessels);

  private:
    std::optional<RangeBreak> left_;
    bool is_placed_ = false;
};

// Returns a short text about where and when the physics left its range, such as "physics left its range at
// 00:12.3".
std::string range_notice(const RangeBreak &left);
// Returns the text of range_notice(), followed by tick, quantity, position, limit and remedy.
std::string range_text(const RangeBreak &left);
// Returns tick, quantity, position and limit for the report, or null if the physics stayed in its range.
nlohmann::ordered_json range_report(const std::optional<RangeBreak> &left);

} // namespace crn
