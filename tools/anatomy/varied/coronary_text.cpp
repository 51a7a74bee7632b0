/* Writes drawn coronary arteries as a vessel file (docs/vessels.md). */
#include "host/base/format.hpp"
#include "host/base/number_text.hpp"
#include "tools/anatomy/varied/coronaries.hpp"
#include "tools/anatomy/varied/file_text.hpp"

namespace anatomy
{

namespace
{

std::string mark_text(const HeartMark &mark)
{
    std::string text = "    { height = " + crn::trimmed_text(mark.height, 4) +
                       ", angle_deg = " + crn::trimmed_text(mark.angle_deg, 2);
    if (mark.diameter_mm > 0) text += ", diameter_mm = " + crn::trimmed_text(mark.diameter_mm, 2);
    return text + name_text(mark.name, mark.source) + " },\n";
}

} // namespace

std::string coronary_file_text(const DrawnCoronaries &drawn)
{
    std::string text = crn::formatted(
        "# Drawn by `anatomy draw --coronary --seed %llu`: coronary arteries on the heart that ships. The "
        "LAD ends %s.\n"
        "# How such arteries are drawn: docs/vessels.md\n",
        static_cast<unsigned long long>(drawn.seed), end_of_lad(drawn).c_str());
    text += "format = 1\nextends = \"shipped:aorta.toml\"\ntitle = " + quoted_text(drawn.draft.title) +
            "\ncoronary_fillet_mm = " + crn::trimmed_text(*drawn.draft.coronary_fillet_mm, 2) + "\n";
    for (const CoronaryArtery &artery : drawn.arteries) {
        text += "\n[[coronary]]\nname = " + quoted_text(artery.name) +
                "\nparent = " + quoted_text(artery.parent) + "\n";
        if (artery.side)
            text += std::string("side = ") + (artery.side == Bed::left_coronary ? "\"left\"" : "\"right\"") +
                    "\n";
        if (artery.flow_ml_min > 0)
            text += "flow_ml_min = { value = " + crn::trimmed_text(artery.flow_ml_min, 2) +
                    ", source = \"drawn: shared by the power 7/3 of the diameters\" }\n";
        text += "stations = [\n";
        for (const Station &station : artery.stations) text += station_text(station);
        for (const HeartMark &mark : artery.marks) text += mark_text(mark);
        text += "]\n";
    }
    return text;
}

} // namespace anatomy
