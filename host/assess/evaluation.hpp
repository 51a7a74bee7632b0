// Finds the phases, the steps and the handling errors of a session by the conditions of a plan.
#pragma once
#include "host/assess/plan.hpp"
#include <optional>

namespace crn
{

struct FoundError {
    std::size_t kind = 0;                       // index in the plan's errors
    std::uint32_t begin_tick = 0, end_tick = 0; // while the condition held
    bool counts = true;                         // false: beyond the plan's at_most
};

struct FoundStep {
    std::string why_not; // why the step does not apply to this session; empty: it applies
    std::optional<std::uint32_t> done_tick;
};

struct FoundPhase {
    std::string why_not; // why the phase does not apply; empty: it applies
    std::optional<std::uint32_t> begin_tick, end_tick;
    std::vector<FoundStep> steps;
};

struct Evaluation {
    std::vector<FoundError> errors;   // by weight, then by time
    std::vector<std::string> why_not; // one per error of the plan: why it does not apply; empty: it applies
    std::vector<FoundPhase> phases;   // one per phase of the plan
    double lost_marks = 0.0;          // sum of the weights of the errors that count
    bool has_life_threatening = false;
};

// Throws FileError if the plan names a vessel that the scene does not have.
Evaluation evaluate(const AssessPlan &plan, const SessionLog &log);

// Checks before a session that the scene has the vessels that the plan names, so that evaluate() will find
// them. Throws FileError.
void check_plan(const AssessPlan &plan, const SessionLog &log);

} // namespace crn
