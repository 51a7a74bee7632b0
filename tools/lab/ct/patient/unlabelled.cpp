#include "tools/lab/ct/patient/unlabelled.hpp"
#include "host/base/format.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/text.hpp"
#include "tools/lab/ct/commands.hpp"
#include "tools/lab/ct/volume/volume_io.hpp"
#include <nlohmann/json.hpp>

namespace crn::ct
{

namespace
{

namespace fs = std::filesystem;

struct Shot {
    const char *name, *what;
};
constexpr Shot shots[] = {
    {"aorta_front.png", "The aorta that was found, from the front: the middles of its round sections in the "
                        "descending (yellow) and ascending part (green), over the brightest voxels."},
    {"aorta_side.png", "The same from the left."},
    {"no_bone_front.png",
     "The brightest voxels without what was taken for bone or undiluted medium, and the outline "
     "of the arteries (red). What is bright and has no outline was left out: chambers of the "
     "heart, kidneys, veins, and arteries behind a gap. A click mends the latter."},
    {"no_bone_side.png", "The same from the left."}};

void draw_stack(Picture &picture, const Volume &scan, const Stack &stack, Ink ink)
{
    for (const Disc &disc : stack) picture.dot(place_of(scan, disc), ink, 4);
}

void draw(const Volume &scan, const FoundArteries &found, const fs::path &folder)
{
    Volume rest = scan, outline = scan.like(1);
    for (std::size_t at = 0; at < rest.count(); ++at) {
        const auto label = static_cast<int>(found.labels.volume.hu[at]);
        if (label == label_bone) rest.hu[at] = -1000;
        if (label == label_aorta || label == label_artery) outline.hu[at] = -1;
    }
    for (const int axis : {1, 0}) {
        Picture aorta(scan, axis, -1, 0, 900, 0.8);
        draw_stack(aorta, scan, found.descending, yellow);
        draw_stack(aorta, scan, found.ascending, green);
        aorta.save(folder / shots[axis == 1 ? 0 : 1].name);
        Picture arteries(rest, axis, -1, 0, 600, 0.8);
        arteries.outline(outline, red);
        arteries.save(folder / shots[axis == 1 ? 2 : 3].name);
    }
}

nlohmann::json list_of(const Eigen::Vector3d &place_mm)
{
    return {place_mm.x(), place_mm.y(), place_mm.z()};
}

void describe(const Volume &scan, const FoundArteries &found, Findings &findings)
{
    const auto tell = [&](const char *name, const Stack &stack) {
        const Eigen::Vector3d low = place_of(scan, stack.front()), high = place_of(scan, stack.back());
        findings.facts.push_back(formatted(
            "%s: found in %zu slices from (%.0f, %.0f, %.0f) to (%.0f, %.0f, %.0f) mm, radius %.1f to "
            "%.1f mm",
            name, stack.size(), low.x(), low.y(), low.z(), high.x(), high.y(), high.z(),
            stack.front().radius_mm, stack.back().radius_mm));
    };
    if (found.has_aorta)
        tell("descending aorta", found.descending);
    else
        findings.facts.push_back("no aorta is in the scan: the arteries begin at the first click into one");
    if (!found.ascending.empty()) tell("ascending aorta", found.ascending);
    findings.assumed.push_back(found.has_aorta
                                   ? "the longest bright round vessel through the axial slices is the aorta"
                                   : "blood enters where the arteries are widest");
    findings.assumed.push_back(
        "a bright region that is 1.5 times as wide as the narrowest place before it, and 1 mm, is no artery: "
        "the arteries end at that place (heart, kidney, vein, bone)");
    findings.check.push_back(
        "arteries without an outline in the pictures without bone (--click artery or bridge), and "
        "outlines around what is no artery (--click cut)");
}

} // namespace

Unlabelled unlabelled_arteries(const Volume &scan, const Mask &body, const std::vector<Click> &clicks,
                               Steps &steps, const std::string &inputs, Page &page, Findings &findings)
{
    const fs::path map = page.folder() / "arteries.nii.gz", notes = page.folder() / "arteries.json";
    std::vector<fs::path> files = {map, notes};
    for (const Shot &shot : shots) files.push_back(page.folder() / shot.name);
    Unlabelled result;
    // A map or notes that somebody has changed are made again.
    const auto with_files = [&] {
        return fs::exists(map) && fs::exists(notes) ? inputs + " " + checksum(map) + " " + checksum(notes)
                                                    : inputs;
    };
    if (!steps.is_done("arteries", with_files(), files)) {
        Findings own;
        FoundArteries found = find_arteries(scan, body, clicks, own, terminal_report());
        describe(scan, found, own);
        draw(scan, found, page.folder());
        write_volume(found.labels.volume, map);
        const nlohmann::json text = {
            {"names", {{"1", "aorta"}, {"2", "artery"}, {"3", "heart"}, {"4", "bone"}}},
            {"root_mm", list_of(found.root_mm)},
            {"has_aorta", found.has_aorta},
            {"facts", own.facts},
            {"assumed", own.assumed},
            {"check", own.check}};
        write_whole_file(notes.string(), text.dump(2) + "\n");
        steps.finish("arteries", with_files());
        result.labels = std::move(found.labels);
    } else {
        result.labels = {along_patient_axes(read_volume(map)), artery_names()};
        result.labels.volume.name = "arteries";
    }
    const nlohmann::json text = nlohmann::json::parse(read_text_file(notes.string()));
    const auto add = [&](const char *key, std::vector<std::string> &to) {
        for (const auto &line : text.at(key)) to.push_back(line.get<std::string>());
    };
    add("facts", findings.facts);
    add("assumed", findings.assumed);
    add("check", findings.check);
    for (int axis = 0; axis < 3; ++axis)
        result.root_mm[axis] = text.at("root_mm").at(static_cast<std::size_t>(axis)).get<double>();
    result.has_aorta = text.at("has_aorta").get<bool>();
    for (const Shot &shot : shots)
        if (result.has_aorta || std::string(shot.name).find("aorta") != 0) page.add(shot.name, shot.what);
    return result;
}

} // namespace crn::ct
