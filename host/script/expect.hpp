// A session script states conditions that must hold (docs/session.md):
//
//   expect tip wire in ascending aorta at least 30 mm
//   expect iodine in left main at least 60 %
//   expect residual stenosis below 20 %
//   expect apposition at least 95 %
//   expect inserted wire at least 400 mm
//   expect turned catheter at least 170 deg
//   expect perforations at most 0
//   expect dissections at least 1
//   expect blood loss below 20 ml
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
    enum class Kind {
        tip,
        iodine,
        stenosis,
        apposition,
        inserted,
        turned,
        perforations,
        dissections,
        blood_loss
    };
    Kind kind = Kind::tip;
    std::size_t tool = 0; // for tip, inserted and turned
    VesselName vessel;    // for tip and iodine
    // The limits of an expected value are in mm, percent, degrees, ml or numbers; if `is_below` is true, the
    // value must be less than `most`, not equal to it.
    double least = -std::numeric_limits<double>::infinity(), most = std::numeric_limits<double>::infinity();
    bool is_below = false;

    bool names_vessel() const { return kind == Kind::tip || kind == Kind::iodine; }
    bool allows(double value) const;
    std::string text() const;       // as a script would write it
    std::string plain_text() const; // as a sentence for people
};

// Parses the words after "expect" in a line of a script. Throws FileError; the message gives the line's
// position in the file.
Expectation parse_expectation(LineParser &line, const ToolChoice &selected);

// Provides the values of iodine, remaining stenosis and stent apposition, in percent, the numbers of
// injuries, and the lost blood; a value is absent if it is not known.
class SessionWitness
{
  public:
    virtual ~SessionWitness() = default;
    virtual std::optional<double> iodine_pct(std::size_t vessel) const = 0;
    virtual std::optional<double> residual_stenosis_pct() const = 0;
    virtual std::optional<double> apposition_pct() const = 0;
    virtual std::optional<double> perforations() const { return {}; }
    virtual std::optional<double> dissections() const { return {}; }
    virtual std::optional<double> blood_loss_ml() const { return {}; }
};

// Computes these values from the simulated patient.
class EffectsWitness final : public SessionWitness
{
  public:
    EffectsWitness(const VesselMap &map, Patient &patient) : map_(map), patient_(patient) {}
    std::optional<double> iodine_pct(std::size_t vessel) const override;
    std::optional<double> residual_stenosis_pct() const override;
    std::optional<double> apposition_pct() const override;
    std::optional<double> perforations() const override;
    std::optional<double> dissections() const override;
    std::optional<double> blood_loss_ml() const override;

  private:
    const VesselMap &map_;
    Patient &patient_;
};

// Holds the state against which a script's conditions are checked. Every span has one entry per tool, from
// the innermost tool outwards; an empty span means that the values are not known.
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

// `vessel` is the number of the vessel that the expectation names. `turned_deg` is the angle by which the
// hand has turned the tool that the expectation names.
ExpectationResult judge(const Expectation &expectation, int line, std::size_t vessel, const VesselMap &map,
                        const SessionView &view, double turned_deg);

} // namespace crn
