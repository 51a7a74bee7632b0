#include "host/script/expect.hpp"
#include "host/base/number_text.hpp"
#include "host/effects/lesion_figures.hpp"
#include "host/patient/patient.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{

namespace
{

const std::vector<Unit> percent_units = {{"%", 1.0}};
const std::vector<Unit> lost_units = {{"ml", 1.0}};
const std::vector<std::string> kinds = {"tip",    "iodine",       "residual",    "apposition", "inserted",
                                        "turned", "perforations", "dissections", "blood"};

std::string rounded(double value)
{
    return decimals_text(value, std::fabs(value) < 9.95 ? 1 : 0);
}

const char *unit_of(Expectation::Kind kind)
{
    using Kind = Expectation::Kind;
    if (kind == Kind::turned) return "deg";
    if (kind == Kind::blood_loss) return "ml";
    if (kind == Kind::perforations || kind == Kind::dissections) return "";
    return kind == Kind::tip || kind == Kind::inserted ? "mm" : "%";
}

double bound(LineParser &line, Expectation::Kind kind)
{
    using Kind = Expectation::Kind;
    if (kind == Kind::turned) return line.quantity("angle", angle_units, -36000.0, 36000.0);
    if (kind == Kind::tip || kind == Kind::inserted)
        return line.quantity("length", length_units, 0.0, 1.6) * 1e3;
    if (kind == Kind::blood_loss) return line.quantity("volume", lost_units, 0.0, 10'000.0);
    if (kind == Kind::perforations || kind == Kind::dissections) return line.number("a number of injuries");
    return line.quantity("share", percent_units, -100.0, 100.0);
}

// Returns a unit with a space before it, or nothing for a number without unit.
std::string spaced(const std::string &unit)
{
    return unit.empty() ? "" : " " + unit;
}

// Reads the limits "at least", "at most" or "below"; if `needs_one` is true, the line must contain at least
// one limit.
void parse_bounds(LineParser &line, Expectation &expectation, bool needs_one)
{
    while (!line.is_at_end() || needs_one) {
        if (line.choice("bound", {"at", "below"}) == "below") {
            expectation.most = bound(line, expectation.kind);
            expectation.is_below = true;
        } else if (line.choice("bound", {"least", "most"}) == "least") {
            expectation.least = bound(line, expectation.kind);
        } else {
            expectation.most = bound(line, expectation.kind);
            expectation.is_below = false;
        }
        needs_one = false;
    }
}

std::string remedy_of(const Expectation &expectation)
{
    switch (expectation.kind) {
    case Expectation::Kind::tip:
        return "steer it there (steer or engage), or mend what the script expects";
    case Expectation::Kind::iodine:
        return "bring the tip into the vessel (engage) and inject through that device";
    case Expectation::Kind::stenosis:
        return "bring the balloon's middle to the narrowest place and inflate further";
    case Expectation::Kind::apposition:
        return "inflate the stent further, or choose one of the vessel's size";
    case Expectation::Kind::inserted:
        return "see which push ended early (given up)";
    case Expectation::Kind::perforations:
    case Expectation::Kind::dissections:
        return "push less against resistance, or choose a balloon of the vessel's size "
               "(docs/complications.md)";
    case Expectation::Kind::blood_loss:
        return "inflate a balloon of the vessel's size where it bleeds";
    case Expectation::Kind::turned:
        break;
    }
    return "turn the hand before";
}

} // namespace

bool Expectation::allows(double value) const
{
    return value >= least && (is_below ? value < most : value <= most);
}

std::string Expectation::text() const
{
    std::string said;
    switch (kind) {
    case Kind::tip:
        said = "tip " + tool_name(tool) + " in " + vessel.text;
        break;
    case Kind::iodine:
        said = "iodine in " + vessel.text;
        break;
    case Kind::stenosis:
        said = "residual stenosis";
        break;
    case Kind::apposition:
        said = "apposition";
        break;
    case Kind::inserted:
    case Kind::turned:
        said = (kind == Kind::turned ? "turned " : "inserted ") + tool_name(tool);
        break;
    case Kind::perforations:
        said = "perforations";
        break;
    case Kind::dissections:
        said = "dissections";
        break;
    case Kind::blood_loss:
        said = "blood loss";
        break;
    }
    const std::string unit = spaced(unit_of(kind));
    if (std::isfinite(least)) said += " at least " + rounded(least) + unit;
    if (std::isfinite(most)) said += (is_below ? " below " : " at most ") + rounded(most) + unit;
    return said;
}

std::string Expectation::plain_text() const
{
    const std::string unit = kind == Kind::turned ? " degrees" : spaced(unit_of(kind));
    std::string amount;
    if (std::isfinite(least)) amount = "at least " + rounded(least) + unit;
    if (std::isfinite(most)) {
        if (!amount.empty()) amount += " and ";
        amount += (is_below ? "less than " : "at most ") + rounded(most) + unit;
    }
    switch (kind) {
    case Kind::tip:
        return "the tip of the " + tool_name(tool) + " is " + (amount.empty() ? "" : amount + " ") +
               "inside the " + vessel.text;
    case Kind::iodine:
        return amount + " of the contrast medium has reached the " + vessel.text;
    case Kind::stenosis:
        return "the remaining stenosis is " + amount;
    case Kind::apposition:
        return amount + " of the stent's struts lie on the wall";
    case Kind::inserted:
        return "the " + tool_name(tool) + " is inserted by " + amount;
    case Kind::perforations:
        return amount + " perforations of vessels have happened";
    case Kind::dissections:
        return amount + " dissections of vessels have happened";
    case Kind::blood_loss:
        return "the patient has lost " + amount + " of blood through the walls of vessels";
    case Kind::turned:
        break;
    }
    return "the " + tool_name(tool) + " has been turned by " + amount;
}

Expectation parse_expectation(LineParser &line, const ToolChoice &selected)
{
    using Kind = Expectation::Kind;
    Expectation expectation;
    const std::string what = line.choice("expectation", kinds);
    const bool has_tool = what == "tip" || what == "inserted" || what == "turned";
    if (has_tool) expectation.tool = accept_one_tool(line, selected);
    if (what == "residual") line.expect("stenosis");
    if (what == "blood") line.expect("loss");
    expectation.kind = what == "tip"            ? Kind::tip
                       : what == "iodine"       ? Kind::iodine
                       : what == "residual"     ? Kind::stenosis
                       : what == "apposition"   ? Kind::apposition
                       : what == "inserted"     ? Kind::inserted
                       : what == "perforations" ? Kind::perforations
                       : what == "dissections"  ? Kind::dissections
                       : what == "blood"        ? Kind::blood_loss
                                                : Kind::turned;
    if (expectation.names_vessel()) {
        line.expect("in");
        expectation.vessel = vessel_name(line);
    }
    parse_bounds(line, expectation, expectation.kind != Kind::tip);
    return expectation;
}

// --- the witness ---

std::optional<double> EffectsWitness::iodine_pct(std::size_t vessel) const
{
    const PatientContrast &contrast = patient_.contrast();
    if (!contrast.was_used()) return {};
    const double injected_mg = contrast.flow().budget().injected_mg;
    if (injected_mg <= 0.0) return {};
    return 100.0 * contrast.received_mg(map_.vessels()[vessel].branch) / injected_mg;
}

// Returns the largest remaining stenosis among the lesions that were narrow at the start of the session.
std::optional<double> EffectsWitness::residual_stenosis_pct() const
{
    const PatientContrast &contrast = patient_.contrast();
    const double viscosity_mPa_s = ContrastSettings{}.viscosity_mPa_s;
    const VesselTree opened = contrast.opened_vessels();
    std::optional<double> worst;
    for (const LesionFigures &figures : lesion_figures(contrast.vessels(), viscosity_mPa_s, &opened))
        worst = std::max(worst.value_or(-100.0), figures.diameter_percent());
    return worst;
}

std::optional<double> EffectsWitness::apposition_pct() const
{
    std::optional<double> worst;
    if (!patient_.stents()) return worst;
    for (const StentResult &stent : patient_.stents()->results()) {
        if (stent.stage != StentStage::deployed) continue;
        const double apposed_pct = stent.figures.apposed_share * 100.0;
        worst = std::min(worst.value_or(100.0), apposed_pct);
    }
    return worst;
}

std::optional<double> EffectsWitness::perforations() const
{
    return static_cast<double>(patient_.complications().count(InjuryKind::perforation));
}

std::optional<double> EffectsWitness::dissections() const
{
    return static_cast<double>(patient_.complications().count(InjuryKind::dissection));
}

std::optional<double> EffectsWitness::blood_loss_ml() const
{
    return patient_.contrast().flow().wounds().leaked_ml();
}

// --- judgement ---

namespace
{

struct Finding {
    std::optional<double> value; // empty: not held
    std::string text;
};

Finding find_tip(const Expectation &expectation, std::size_t vessel, const VesselMap &map,
                 const SessionView &view)
{
    if (expectation.tool >= view.tips.size() || !view.tips[expectation.tool].is_known)
        return {{}, "where the tip is was not known"};
    const TipPlace &tip = view.tips[expectation.tool];
    const double inside_mm = tip.inside_m * 1e3;
    const std::string found =
        "the tip is " + rounded(inside_mm) + " mm inside " + map.vessels()[tip.place.vessel].name;
    if (tip.place.vessel != vessel) return {{}, found};
    return {inside_mm, found};
}

Finding find_share(const std::optional<double> &share, const char *none)
{
    if (!share) return {{}, none};
    return {share, "it is " + rounded(*share) + " %"};
}

Finding find_number(const std::optional<double> &number, const char *unit)
{
    if (!number) return {{}, "it was not known"};
    return {number, "it is " + rounded(*number) + spaced(unit)};
}

Finding find(const Expectation &expectation, std::size_t vessel, const VesselMap &map,
             const SessionView &view, double turned_deg)
{
    using Kind = Expectation::Kind;
    const SessionWitness *witness = view.witness;
    const auto none = std::optional<double>();
    switch (expectation.kind) {
    case Kind::tip:
        return find_tip(expectation, vessel, map, view);
    case Kind::iodine:
        return find_share(witness ? witness->iodine_pct(vessel) : none, "no medium was injected");
    case Kind::stenosis:
        return find_share(witness ? witness->residual_stenosis_pct() : none, "the scene has no lesion");
    case Kind::apposition:
        return find_share(witness ? witness->apposition_pct() : none, "no stent was deployed");
    case Kind::inserted:
        if (expectation.tool >= view.inserted_m.size()) return {{}, "the device's length was not known"};
        return {view.inserted_m[expectation.tool] * 1e3,
                "it is " + rounded(view.inserted_m[expectation.tool] * 1e3) + " mm"};
    case Kind::perforations:
        return find_number(witness ? witness->perforations() : none, "");
    case Kind::dissections:
        return find_number(witness ? witness->dissections() : none, "");
    case Kind::blood_loss:
        return find_number(witness ? witness->blood_loss_ml() : none, "ml");
    case Kind::turned:
        break;
    }
    return {turned_deg, "it is " + rounded(turned_deg) + " deg"};
}

} // namespace

ExpectationResult judge(const Expectation &expectation, int line, std::size_t vessel, const VesselMap &map,
                        const SessionView &view, double turned_deg)
{
    const Finding finding = find(expectation, vessel, map, view, turned_deg);
    ExpectationResult result{line, view.tick, expectation.text(),
                             finding.value && expectation.allows(*finding.value), finding.text};
    if (!result.is_held) result.found += "; remedy: " + remedy_of(expectation);
    return result;
}

} // namespace crn
