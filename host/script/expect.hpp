// A session script states conditions that must hold (docs/session.md):
//
//   expect tip wire in ascending aorta at least 30 mm
//   expect iodine in left main at least 60 %
//   expect residual stenosis below 20 %
//   expect apposition at least 95 %
//   expect inserted wire at least 400 mm
//   expect turned catheter at least 170 deg
#pragma once
#include "host/script/tip_places.hpp"
#include "host/script/tool.hpp"
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>

namespace crn
{

class Patient;

struct Expectation {
    enum class Kind { tip, iodine, stenosis, apposition, inserted, turned };
    Kind kind = Kind::tip;
    std::size_t tool = 0; // for tip, inserted and turned
    VesselName vessel;    // for tip and iodine
    // Limits in mm, percent or degrees; `below` excludes the limit itself.
    double least = -std::numeric_limits<double>::infinity(), most = std::numeric_limits<double>::infinity();
    bool is_below = false;

    bool names_vessel() const { return kind == Kind::tip || kind == Kind::iodine; }
    bool allows(double value) const;
    std::string text() const; // as a script would write it
};

// Parses the rest of a line after "expect". Throws FileError with the line's place.
Expectation parse_expectation(LineParser &line, const ToolChoice &selected);

// The known figures of medium, lesions and stents, in percent; empty if not known.
class SessionWitness
{
  public:
    virtual ~SessionWitness() = default;
    virtual std::optional<double> iodine_pct(std::size_t vessel) const = 0;
    virtual std::optional<double> residual_stenosis_pct() const = 0;
    virtual std::optional<double> apposition_pct() const = 0;
};

// The witness that reads a patient.
class EffectsWitness final : public SessionWitness
{
  public:
    EffectsWitness(const VesselMap &map, Patient &patient) : map_(map), patient_(patient) {}
    std::optional<double> iodine_pct(std::size_t vessel) const override;
    std::optional<double> residual_stenosis_pct() const override;
    std::optional<double> apposition_pct() const override;

  private:
    const VesselMap &map_;
    Patient &patient_;
};

// The state that a script checks. Each span has one entry per tool, from the innermost; an empty one means
// not known.
struct SessionView {
    std::span<const double> inserted_m;
    std::span<const TipPlace> tips;
    const SessionWitness *witness = nullptr;
    std::uint32_t tick = 0;
};

// The result of one expectation.
struct ExpectationResult {
    int line = 0;
    std::uint32_t tick = 0; // tick of the judgement
    std::string text;
    bool is_held = false;
    std::string found; // the measured value, and where it was not held, a remedy
};

// `vessel` is the vessel that the expectation names. `turned_deg` belongs to its tool's hand.
ExpectationResult judge(const Expectation &expectation, int line, std::size_t vessel, const VesselMap &map,
                        const SessionView &view, double turned_deg);

} // namespace crn
