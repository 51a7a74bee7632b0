#include "tools/lab/ct/patient/label_map.hpp"
#include "host/base/format.hpp"
#include "tools/lab/ct/arteries/body.hpp"
#include "tools/lab/ct/commands.hpp"
#include "tools/lab/ct/patient/vessels.hpp"
#include "tools/lab/ct/surface.hpp"
#include "tools/lab/ct/volume/volume_io.hpp"

#include <algorithm>
#include <cmath>

namespace crn::ct
{

namespace
{

std::map<int, std::size_t> counts_of(const Volume &volume)
{
    std::map<int, std::size_t> counts;
    for (const float value : volume.hu) {
        if (value != std::round(value))
            throw Fault(volume.name +
                        formatted(": has the value %g, which is no whole number: export the labels, not "
                                  "probabilities or a resampled picture",
                                  static_cast<double>(value)));
        if (value != 0.0f) ++counts[static_cast<int>(value)];
    }
    if (counts.empty())
        throw Fault(volume.name + ": has no label: all voxels are 0; export the segmentation");
    return counts;
}

std::string list_of(const std::map<int, std::size_t> &counts)
{
    std::string text;
    for (const auto &[number, count] : counts) {
        if (text.size() > 200) return text + " ...";
        text += (text.empty() ? "" : ", ") + std::to_string(number);
    }
    return text;
}

} // namespace

VesselLabels read_vessel_labels(const LabelWish &wish, patient::Choices &choices)
{
    LabelMap map{along_patient_axes(read_volume(wish.map)), {}};
    map.volume.name = wish.map.string();
    if (!wish.table.empty()) map.names = read_names(wish.table);
    const std::map<int, std::size_t> counts = counts_of(map.volume);
    std::vector<int> chosen;
    std::string why = "as stated";
    if (!wish.labels.empty()) {
        for (const int number : wish.labels) {
            if (!counts.count(number))
                throw Fault(map.volume.name + formatted(": has no voxel of label %d: it has ", number) +
                            list_of(counts));
            chosen.push_back(number);
        }
    } else {
        for (const auto &[number, count] : counts) {
            const auto name = map.names.find(number);
            if (name != map.names.end() && (is_artery(name->second) || patient::is_artery_name(name->second)))
                chosen.push_back(number);
        }
        why = "they have the names of arteries";
        if (chosen.empty()) {
            if (!map.names.empty())
                throw Fault(map.volume.name + ": no label is an artery by its name in " +
                            wish.table.string() + ": state the vessels by --label; it has " +
                            list_of(counts));
            for (const auto &[number, count] : counts) chosen.push_back(number);
            why = "there is no table of names, so every label is taken for a vessel";
        }
    }
    VesselLabels vessels;
    std::vector<std::string> names;
    for (const int number : chosen)
        names.push_back(map.names.count(number) ? map.names[number] : "label_" + std::to_string(number));
    names = patient::short_names(names, &choices);
    std::string list;
    for (std::size_t n = 0; n < chosen.size(); ++n) {
        vessels.names[chosen[n]] = names[n];
        vessels.map.names[chosen[n]] = "artery_" + std::to_string(chosen[n]);
        if (n < 6) list += (n ? ", " : "") + std::to_string(chosen[n]) + " " + names[n];
    }
    choices.add("labels", list + (chosen.size() > 6 ? " and more" : ""), why, "--label N");
    choices.add("unit", "mm",
                formatted("%d x %d x %d voxels of %.2f x %.2f x %.2f mm, in the patient's axes",
                          map.volume.size[0], map.volume.size[1], map.volume.size[2],
                          map.volume.spacing_mm.x(), map.volume.spacing_mm.y(), map.volume.spacing_mm.z()),
                "");
    for (const std::string &note : map.volume.notes) choices.add("map", note, "", "");
    vessels.map.volume = std::move(map.volume);
    return vessels;
}

bake::Mesh surface_of_labels(const VesselLabels &labels)
{
    // Without contrast medium, artery_level() smooths the surface of the labels.
    const Volume level = artery_level(labels.map.volume, labels.map, Contrast{}, terminal_report());
    bake::Mesh mesh = surface_of(level, labels.map.volume.name);
    if (mesh.triangles.empty())
        throw Fault(
            labels.map.volume.name +
            ": no lumen remains of the labels: they are thinner than two voxels, or in scattered pieces; "
            "segment again");
    return mesh;
}

void make_label_scene(const LabelWish &labels, const patient::SceneWish &wish, patient::Choices &choices,
                      bake::Progress &progress)
{
    const VesselLabels vessels = read_vessel_labels(labels, choices);
    patient::SceneWish own = wish;
    own.lumen.walls = "lumen"; // the voxels between two sheets of a wall would have labels of their own
    own.structure_at = [&vessels](const Eigen::Vector3d &place_mm) -> std::string {
        const Eigen::Vector3d voxel = vessels.map.volume.voxel(place_mm);
        const auto i = static_cast<int>(std::lround(voxel.x())), j = static_cast<int>(std::lround(voxel.y())),
                   k = static_cast<int>(std::lround(voxel.z()));
        if (!vessels.map.volume.holds(i, j, k)) return "";
        const auto name = vessels.names.find(vessels.map.label(vessels.map.volume.at(i, j, k)));
        return name == vessels.names.end() ? "" : name->second;
    };
    patient::Frame frame;
    frame.unit = "mm";
    frame.axes = "+x,+z,-y";
    frame.placement.unit = "mm";
    patient::make_scene_folder({{"labels", surface_of_labels(vessels)}}, frame, own, choices, progress);
}

} // namespace crn::ct
