/* Writes a drawn tree as a vessel file (docs/vessels.md). */
#include "host/base/format.hpp"
#include "host/base/number_text.hpp"
#include "tools/anatomy/varied/file_text.hpp"
#include "tools/anatomy/varied/variety.hpp"

namespace anatomy
{

std::string quoted_text(const std::string &text)
{
    std::string result = "\"";
    for (const char c : text) {
        if (c == '"' || c == '\\') result += '\\';
        result += c;
    }
    return result + '"';
}

std::string name_text(const std::string &name, const std::string &source)
{
    return name.empty() ? "" : ", name = " + quoted_text(name) + ", source = " + quoted_text(source);
}

std::string station_text(const Station &station)
{
    const auto mm = [](double value) { return crn::trimmed_text(value, 2); };
    return "    { position_mm = [" + mm(station.position_mm.x()) + ", " + mm(station.position_mm.y()) + ", " +
           mm(station.position_mm.z()) + "], diameter_mm = " + mm(station.diameter_mm) +
           name_text(station.name, station.source) + " },\n";
}

std::string vessel_file_text(const DrawnAorta &drawn)
{
    const TreeDraft &draft = drawn.draft;
    std::string text =
        crn::formatted("# Drawn by `anatomy draw --seed %llu`. Arch: type %s, the brachiocephalic origin "
                       "lies %.2f widths of the left\n"
                       "# common carotid artery below the top%s. Iliac tortuosity: right %.3f, left %.3f. "
                       "Aorta: %.2f of the shipped\n"
                       "# diameters. How such trees are drawn: docs/vessels.md\n",
                       static_cast<unsigned long long>(drawn.seed), arch_type_name(drawn.arch.type),
                       drawn.arch.drop_widths, drawn.arch.has_common_trunk ? "; common trunk" : "",
                       drawn.right_tortuosity, drawn.left_tortuosity, drawn.aorta_scale);
    text += "format = 1\ntitle = " + quoted_text(draft.title) +
            "\nframe = \"patient\"\nfillet_mm = " + crn::trimmed_text(draft.fillet_mm, 2) +
            "\n\n[entry]\nvessel = " + quoted_text(draft.entry->vessel) +
            "\ny_mm = " + crn::trimmed_text(*draft.entry->y_mm, 2) + "\n";
    for (const GivenVessel &given : draft.vessels) {
        const Vessel &vessel = given.vessel;
        text += "\n[[vessel]]\nname = " + quoted_text(vessel.name) + "\n";
        if (!vessel.parent.empty()) text += "parent = " + quoted_text(vessel.parent) + "\n";
        if (vessel.flow_ml_min > 0)
            text += "flow_ml_min = { value = " + crn::trimmed_text(vessel.flow_ml_min, 2) +
                    ", source = \"that of the shipped aorta\" }\n";
        text += "stations = [\n";
        for (const Station &station : vessel.stations) text += station_text(station);
        text += "]\n";
    }
    return text;
}

} // namespace anatomy
