#include "host/script/rhythm.hpp"

namespace crn
{
namespace
{

const std::vector<Unit> per_minute = {{"/min", 1.0}, {"bpm", 1.0}};
const std::vector<Unit> percent = {{"%", 10.0}}; // 1/1000

// Reads a number and returns it as a whole number in the unit of the wire protocol; if it is out of range,
// the error message gives the range.
std::uint16_t whole(LineParser &line, const std::string &what, const std::vector<Unit> &units, double low,
                    double high, const char *range)
{
    const LineParser before = line;
    const double value = std::round(line.quantity(what, units, 0.0, 1e6));
    if (!(value >= low && value <= high)) before.fail(what + " must be " + range);
    return static_cast<std::uint16_t>(value);
}

std::uint16_t on_or_off(LineParser &line)
{
    return line.choice("switch", {"on", "off"}) == "on" ? 1 : 0;
}

crn_wire_rhythm parse_heart(LineParser &line)
{
    if (line.choice("word", {"rate", "variability"}) == "rate")
        return {CRN_WIRE_RHYTHM_HEART_RATE, whole(line, "heart rate", per_minute, 40, 160, "40 to 160 /min")};
    return {CRN_WIRE_RHYTHM_VARIABILITY, whole(line, "variability", percent, 0, 100, "0 to 10 %")};
}

crn_wire_rhythm parse_breath(LineParser &line)
{
    if (line.choice("word", {"rate", "hold"}) == "rate")
        return {CRN_WIRE_RHYTHM_BREATH_RATE, whole(line, "breath rate", per_minute, 10, 20, "10 to 20 /min")};
    return {CRN_WIRE_RHYTHM_BREATH_HOLD, on_or_off(line)};
}

crn_wire_rhythm parse_premature(LineParser &line)
{
    line.expect("beat");
    if (!line.accept("at")) return {CRN_WIRE_RHYTHM_PREMATURE, premature_usual_milli};
    return {CRN_WIRE_RHYTHM_PREMATURE,
            whole(line, "coupling", percent, 400, 900, "40 to 90 % of the interval")};
}

} // namespace

const std::vector<std::string> &rhythm_verbs()
{
    static const std::vector<std::string> verbs = {"heart", "premature", "asystole", "breath"};
    return verbs;
}

crn_wire_order parse_rhythm(LineParser &line, const std::string &verb)
{
    if (verb == "heart") return crn_wire_order_of_rhythm(parse_heart(line));
    if (verb == "breath") return crn_wire_order_of_rhythm(parse_breath(line));
    if (verb == "premature") return crn_wire_order_of_rhythm(parse_premature(line));
    return crn_wire_order_of_rhythm({CRN_WIRE_RHYTHM_ASYSTOLE, on_or_off(line)});
}

} // namespace crn
