// Injuries of a vessel's wall: what they are called, and how large a wound they leave
// (docs/complications.md).
#pragma once
#include "host/base/state_archive.hpp"
#include "host/complications/limits.hpp"
#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <string>

namespace crn
{

enum class InjuryKind { perforation, dissection };
enum class InjuryCause { tip, balloon };

struct Injury {
    InjuryKind kind = InjuryKind::perforation;
    InjuryCause cause = InjuryCause::tip;
    std::uint32_t tick = 0; // at which the limit had been exceeded for the stated time
    std::string tool, vessel;
    Eigen::Vector3d place_m = Eigen::Vector3d::Zero(); // at that tick
    Eigen::Vector3d outward = Eigen::Vector3d::Zero(); // out of the vessel
    // What was measured at most, and the limit: kPa of a tip, or the ratio of a balloon.
    double value = 0.0, limit = 0.0;
    double force_N = 0.0;            // of a tip
    double size_mm = 0.0;            // diameter of the hole, or length of the flap
    double narrowing = 0.0;          // of the lumen by the flap, a share of its diameter
    std::size_t cell = 0, cells = 0; // of the flow's cells: the first one, and how many
    std::size_t wound = 0;           // index among the holes or flaps; a crater has none
    bool bleeds = false;             // a hole through the whole wall

    const char *unit() const { return cause == InjuryCause::tip ? "kPa" : "times the vessel"; }
};

// Returns the diameter of the hole that a balloon of this ratio leaves.
double balloon_hole_mm(const ComplicationLimits &limits, double ratio);
// Returns the flow through a hole per mmHg: that of an orifice at the mean pressure of the arteries.
double hole_ml_s_per_mmHg(const ComplicationLimits &limits, double diameter_mm);
// Returns the share of the lumen's diameter that a flap takes: from the share at the limit on, in proportion
// to the part of the limit by which it was exceeded.
double flap_narrowing(const ComplicationLimits &limits, InjuryCause cause, double value, double limit);

// Returns the class of a perforation by Ellis, I to III, or the type of a dissection by the NHLBI, B to F.
std::string injury_class(const Injury &injury, const ComplicationLimits &limits);
// Returns what happened, where, and what to do, for the window: "PERFORATION ...".
std::string injury_notice(const Injury &injury, const ComplicationLimits &limits);

// Returns the share of the arterial pressure that is left after so much blood was lost around the heart, and
// in all.
double pressure_left(const ComplicationLimits &limits, double around_heart_ml, double all_ml);

// Waits until a value has exceeded its limit without a break for some time.
class LimitWatch
{
  public:
    // Returns true from the tick on at which the value has been above the limit for `hold_ms`.
    bool take(std::uint32_t tick, double value, double limit, double hold_ms);
    void reset() { is_above_ = false; }
    bool is_above() const { return is_above_; }
    void archive(StateArchive &state);

  private:
    bool is_above_ = false;
    std::uint32_t since_ = 0;
};

void archive_injury(StateArchive &state, Injury &injury);

} // namespace crn
