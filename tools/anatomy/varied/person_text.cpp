/* Writes what was drawn of a person: person.toml, vessels.toml and a line for the terminal. */
#include "host/base/format.hpp"
#include "host/base/number_text.hpp"
#include "tools/anatomy/varied/file_text.hpp"
#include "tools/anatomy/varied/persons.hpp"

namespace anatomy
{

namespace
{

const char *sex_name(Sex sex)
{
    return sex == Sex::woman ? "woman" : "man";
}

std::string clutter_text(const Clutter &clutter)
{
    std::string kinds;
    for (const auto &[is_there, kind] : {std::pair{clutter.leads, "leads"},
                                         {clutter.table, "table"},
                                         {clutter.wires, "wires"},
                                         {clutter.pacemaker, "pacemaker"}})
        if (is_there) kinds += std::string(kinds.empty() ? "" : ",") + kind;
    return kinds.empty() ? "" : " --clutter " + kinds;
}

/* Returns the options that were given, as on the command line. */
std::string options_text(const DrawnPerson &drawn, const PersonWish &wish)
{
    const auto number = [](const char *option, const std::optional<double> &value) {
        return value ? std::string(" ") + option + " " + crn::trimmed_text(*value, 4) : std::string();
    };
    std::string text = crn::formatted("--seed %llu", static_cast<unsigned long long>(drawn.seed));
    if (wish.sex) text += *wish.sex == Sex::woman ? " --sex f" : " --sex m";
    text += number("--age", wish.age_years) + number("--height", wish.height_cm) +
            number("--weight", wish.weight_kg);
    if (wish.arch) text += std::string(" --arch ") + arch_type_name(*wish.arch);
    if (wish.has_common_trunk) text += " --arch bovine";
    text += number("--tortuosity", wish.tortuosity) + number("--calcium", wish.calcium);
    if (wish.arms == Arms::beside) text += " --arms beside";
    text += clutter_text(wish.clutter);
    return text + (wish.has_coronaries ? " --coronary" : "");
}

/* Leaves out points of a course that are closer together than a vessel file allows. */
std::vector<Station> thinned(const std::vector<Station> &stations)
{
    constexpr double APART_MM = 1.5;
    std::vector<Station> kept;
    for (size_t i = 0; i < stations.size(); ++i) {
        const bool is_last = i + 1 == stations.size();
        if (is_last && kept.size() > 1 &&
            (stations[i].position_mm - kept.back().position_mm).norm() < APART_MM)
            kept.pop_back();
        if (kept.empty() || is_last || !stations[i].name.empty() ||
            (stations[i].position_mm - kept.back().position_mm).norm() >= APART_MM)
            kept.push_back(stations[i]);
    }
    return kept;
}

std::string line(const char *key, double value, int decimals, const char *what)
{
    return std::string(key) + " = " + crn::decimals_text(value, decimals) + " # " + what + "\n";
}

} // namespace

std::string person_text(const DrawnPerson &drawn, const PersonWish &wish, const std::string &making)
{
    const Person &person = drawn.person;
    const SoftShape soft = soft_shape(person);
    std::string text = "# What `anatomy person` drew. The same command makes the same person again:\n";
    text += "#     anatomy person " + options_text(drawn, wish) + making + " -o FOLDER\n";
    text += crn::formatted("seed = %llu\nsex = \"%s\"\n", static_cast<unsigned long long>(drawn.seed),
                           sex_name(person.sex));
    text += line("age_years", person.age_years, 0, "widens arch and aorta; calcium, osteophytes");
    text += line("height_cm", 100 * person.height_m, 0, "scales everything; the shipped man has 178");
    text += line("weight_kg", person.weight_kg, 0, "sets the layers of fat");
    text += line("scale", person.scale(), 4, "of all bodies, from the shipped frame");
    text += line("fat", soft.fat, 2, "under the skin, in parts of the shipped man's");
    text += line("belly_mm", soft.belly_mm, 1, "by which the wall of the belly lies farther out");
    text += line("osteophytes", person.osteophytes, 2, "0 none, 1 severe");
    text += line("kyphosis_deg", person.bend.kyphosis_deg, 1, "added to the shipped man's");
    text += line("scoliosis_deg", person.bend.scoliosis_deg, 1, "bulges to the right at the chest");
    text += line("cartilage_calcium", person.cartilage_calcium, 2, "share of the costal cartilages");
    text +=
        line("wall_calcium", person.wall_calcium, 2, "plaques of aorta and iliac arteries: 0 none, 1 many");
    text += std::string("arms = \"") + (person.arms == Arms::raised ? "raised" : "beside") + "\"\n";
    text += std::string("arch = \"") + arch_type_name(drawn.aorta.arch.type) + "\"\n";
    text += std::string("common_trunk = ") + (drawn.aorta.arch.has_common_trunk ? "true" : "false") + "\n";
    text += line("arch_width_mm", drawn.arch_width_mm, 1, "between the ascending and the descending aorta");
    text += line("arch_width_drawn_mm", drawn.arch_width_wanted_mm, 1, "what sex, age and chance asked for");
    text += line("tortuosity_right", drawn.aorta.right_tortuosity, 3, "iliac arteries: length over distance");
    text += line("tortuosity_left", drawn.aorta.left_tortuosity, 3, "");
    if (drawn.coronaries)
        text += "coronary = \"" + std::string(dominance_name(drawn.coronaries->dominance)) +
                " dominant, LAD ends " + end_of_lad(*drawn.coronaries) + "\"\n";
    return text;
}

std::string person_vessels_text(const DrawnPerson &drawn)
{
    const VesselTree tree = drawn.tree();
    std::string text =
        "# The vessels of a drawn person in the frame of the shipped man. In this folder, all meshes and\n"
        "# centrelines are scaled by " +
        crn::decimals_text(drawn.person.scale(), 4) +
        ". How they are drawn: docs/anatomy.md\nformat = 1\ntitle = " + quoted_text(tree.title) +
        "\nframe = \"patient\"\nfillet_mm = " + crn::trimmed_text(tree.fillet_mm, 2) + "\n";
    if (tree.coronary_count > 0)
        text += "coronary_fillet_mm = " + crn::trimmed_text(tree.coronary_fillet_mm, 2) + "\n";
    text += "\n[entry]\nvessel = " + quoted_text(drawn.aorta.draft.entry->vessel) +
            "\ny_mm = " + crn::trimmed_text(*drawn.aorta.draft.entry->y_mm, 2) + "\n";
    for (size_t i = 0; i < tree.vessels.size(); ++i) {
        const Vessel &vessel = tree.vessels[i];
        const bool is_coronary = i + tree.coronary_count >= tree.vessels.size();
        text += std::string(is_coronary ? "\n[[coronary]]" : "\n[[vessel]]") +
                "\nname = " + quoted_text(vessel.name) + "\n";
        if (!vessel.parent.empty()) text += "parent = " + quoted_text(vessel.parent) + "\n";
        if (is_coronary && vessel.parent == tree.vessels.front().name)
            text += vessel.bed == Bed::right_coronary ? "side = \"right\"\n" : "side = \"left\"\n";
        if (vessel.flow_ml_min > 0)
            text += "flow_ml_min = { value = " + crn::trimmed_text(vessel.flow_ml_min, 2) +
                    ", source = \"that of the shipped man\" }\n";
        text += "stations = [\n";
        for (const Station &station : thinned(vessel.stations)) text += station_text(station);
        text += "]\n";
    }
    return text;
}

std::string person_line(const DrawnPerson &drawn)
{
    const Person &person = drawn.person;
    std::string text = crn::formatted(
        "%s, %.0f years, %.0f cm, %.0f kg, arch of type %s%s, %.0f mm wide, ascending aorta %.1f mm",
        sex_name(person.sex), person.age_years, 100 * person.height_m, person.weight_kg,
        arch_type_name(drawn.aorta.arch.type),
        drawn.aorta.arch.has_common_trunk ? " with a common trunk" : "", drawn.arch_width_mm,
        person.scale() * drawn.aorta.aorta_scale * mean_calibre(person).ascending_mm);
    if (drawn.coronaries)
        text +=
            crn::formatted(", %s dominant coronary arteries", dominance_name(drawn.coronaries->dominance));
    return text;
}

} // namespace anatomy
