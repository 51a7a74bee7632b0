#include "tools/lab/ct/patient/patient.hpp"
#include "host/base/format.hpp"
#include "host/base/output_files.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/text.hpp"
#include "host/picture/picture.hpp"
#include "tools/bake/bake.hpp"
#include "tools/centreline/formats.hpp"
#include "tools/lab/ct/arteries/scan_copy.hpp"
#include "tools/lab/ct/commands.hpp"
#include "tools/lab/ct/patient/unlabelled.hpp"
#include "tools/lab/ct/patient/vessels.hpp"
#include "tools/lab/ct/patient/xray_pictures.hpp"
#include "tools/lab/ct/surface.hpp"
#include "tools/lab/ct/volume/volume_io.hpp"
#include "tools/patient/coronary.hpp"
#include "tools/patient/entry.hpp"
#include "tools/patient/naming.hpp"
#include <algorithm>
#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

namespace crn::ct
{

namespace
{

namespace fs = std::filesystem;

// The checksum of a table's text, however its file is written.
std::string names_checksum(const NamesTable &names)
{
    std::string text;
    for (const auto &[number, name] : names) text += std::to_string(number) + " " + name + "\n";
    return checksum(text.data(), text.size());
}

constexpr const char *steps_version = "15"; // another number: every step is made again

struct Patient {
    Volume scan;
    Mask body;
    LabelMap labels;
    std::optional<Eigen::Vector3d> root_mm; // where the blood enters, if it was found without a label map
    Contrast contrast;
    std::vector<Click> clicks;
    Findings findings;
    fs::path folder;
    std::string inputs; // checksum of scan, labels and names

    bool has_map = false; // a label map was given
    bool has_aorta = true;
};

fs::path in(const Patient &patient, const char *name)
{
    return patient.folder / name;
}

fs::path clicks_file(const PatientOptions &options)
{
    return options.output / "clicks.toml";
}

// The text of the clicks of some kinds: the part of a step's inputs that they are.
std::string text_of(const std::vector<Click> &clicks, const std::vector<ClickKind> &kinds)
{
    std::vector<Click> some;
    for (const Click &click : clicks)
        if (std::find(kinds.begin(), kinds.end(), click.kind) != kinds.end()) some.push_back(click);
    const std::string text = some.empty() ? "" : clicks_text(some);
    return " " + checksum(text.data(), text.size());
}

void find_vessels(const PatientOptions &options, Patient &patient, Steps &steps, Page &page)
{
    const std::string scan =
        std::string(steps_version) + " " + checksum(patient.scan) + (patient.has_map ? " map" : " no map");
    if (patient.has_map) {
        keep_labels(patient.labels, options.labels, options.output);
        mend_arteries(patient.scan, patient.body, patient.contrast, patient.clicks, patient.labels,
                      patient.findings);
    } else {
        const std::string mends =
            text_of(patient.clicks, {ClickKind::artery, ClickKind::cut, ClickKind::bridge});
        Unlabelled found = unlabelled_arteries(patient.scan, patient.body, patient.clicks, steps,
                                               scan + mends, page, patient.findings);
        patient.labels = std::move(found.labels);
        patient.root_mm = found.root_mm;
        patient.has_aorta = found.has_aorta;
        patient.contrast = (found.has_aorta ? contrast_in : contrast_in_arteries)(
            patient.scan, patient.labels, patient.findings);
    }
    patient.inputs =
        scan + " " + checksum(patient.labels.volume) + " " + names_checksum(patient.labels.names);
}

// Reads and checks the scan, or the copy of it that an earlier run has kept. Writes nothing.
Patient opened_scan(const PatientOptions &options)
{
    Patient patient;
    patient.folder = options.output;
    patient.has_map = !options.labels.empty();
    if (is_copy(options.scan)) {
        ScanCopy copy = read_copy(options.scan);
        patient.scan = std::move(copy.scan);
        patient.scan.notes = std::move(copy.notes);
    } else {
        patient.scan = along_patient_axes(read_volume(options.scan));
    }
    for (const std::string &note : patient.scan.notes) patient.findings.check.push_back("the scan " + note);
    check_scan(patient.scan, patient.findings);
    // Only voxels and grid remain of the scan. No tag of a DICOM file goes any further.
    patient.scan.name = "scan";
    return patient;
}

// A run with the kept copy of the scan also uses the label map that is kept beside it.
PatientOptions with_kept_labels(PatientOptions options)
{
    if (!options.labels.empty() || !is_copy(options.scan)) return options;
    if (const std::optional<LabelFiles> files = kept_labels(options.scan.parent_path())) {
        options.labels = files->map;
        options.names = files->names;
    }
    return options;
}

Patient read_patient(const PatientOptions &given, Steps &steps, Page &page)
{
    const PatientOptions options = with_kept_labels(given);
    Patient patient = opened_scan(options);
    // Inputs are read and checked before anything is written.
    if (patient.has_map) {
        patient.labels = read_labels(options.labels, options.names, patient.scan);
        patient.contrast = contrast_in(patient.scan, patient.labels, patient.findings);
    }
    recentre(patient.scan, patient.findings);
    patient.clicks = clicks_with(clicks_file(options), options.clicks);
    check_clicks(patient.clicks, patient.scan);
    patient.scan = keep_copy(patient.scan, options.output, steps);
    // The map was checked against the scan's own grid; from here on both have that of the copy.
    patient.labels.volume.origin_mm = patient.scan.origin_mm;
    patient.labels.volume.spacing_mm = patient.scan.spacing_mm;
    patient.labels.volume.direction = patient.scan.direction;
    if (!patient.has_map) forget_labels(options.output); // of an earlier run
    patient.body = body_of(patient.scan);
    find_vessels(options, patient, steps, page);
    // A click that could not be obeyed is not kept.
    if (patient.clicks.size() > read_clicks(clicks_file(options)).size())
        write_clicks(clicks_file(options), patient.clicks);
    return patient;
}

void make_picture(Patient &patient, Steps &steps, Page &page)
{
    const fs::path file = in(patient, "patient.ct");
    const Mask &body = patient.body;
    const CtVolume ct =
        picture_volume(patient.scan, body, patient.labels, patient.contrast, patient.findings);
    if (!steps.is_done("picture", patient.inputs, {file})) {
        write_ct_volume(file.string(), ct);
        steps.finish("picture", patient.inputs);
    }
    Volume outline = patient.scan.like(1);
    for (std::size_t at = 0; at < body.size(); ++at)
        if (body[at]) outline.hu[at] = -1;
    Picture slice(patient.scan, 2, patient.scan.size[2] / 2, -200, 400, 0.8);
    slice.outline(outline, green);
    page.show(slice, "body.png", "The body (green). Everything outside, such as the table, becomes air.");
}

bake::Mesh make_lumen(Patient &patient, Steps &steps, Page &page)
{
    const fs::path file = in(patient, "lumen.ply");
    patient.findings.assumed.push_back(
        "the wall is half-way between the blood's HU and what is beside it; calcium is no lumen");
    const std::array<fs::path, 3> pictures = {in(patient, "lumen_side.png"), in(patient, "lumen_front.png"),
                                              in(patient, "lumen_slice.png")};
    if (!steps.is_done("lumen", patient.inputs, {file, pictures[0], pictures[1], pictures[2]})) {
        const Volume level = artery_level(patient.scan, patient.labels, patient.contrast, terminal_report());
        const bake::Mesh mesh = lumen_of(level);
        write_surface(mesh, {}, file);
        Volume around = level.like(0);
        for (int k = 0; k < level.size[2]; ++k)
            for (int j = 0; j < level.size[1]; ++j)
                for (int i = 0; i < level.size[0]; ++i)
                    around.hu[around.at(i, j, k)] = static_cast<float>(
                        patient.scan.value(patient.scan.voxel(level.scene({1.0 * i, 1.0 * j, 1.0 * k}))));
        for (int axis = 0; axis < 3; ++axis) {
            Picture picture(around, axis, axis == 2 ? around.size[2] / 2 : -1, -100, 500, 0.6);
            picture.outline(level, red);
            picture.save(pictures[static_cast<std::size_t>(axis)]);
        }
        steps.finish("lumen", patient.inputs);
    }
    page.add("lumen_front.png",
             "The arteries from the front: brightest voxels, and the outline of the lumen (red).");
    page.add("lumen_side.png", "The same from the left.");
    page.add("lumen_slice.png", "A slice through the middle of the arteries, with the wall that was found.");
    bake::MeshText text;
    text.file = file;
    text.placement.unit = "mm";
    return bake::load_mesh(text);
}

void write_scene_text(const Patient &patient, const centreline::Tree &tree, const patient::Entry &entry)
{
    const std::string text = formatted(
        "# Made by `ct patient`. It may be changed and baked again: bake scene.toml -o patient.scene\n"
        "[scene]\nname = \"Patient\"\nsource = \"ct patient, from a CT; de-identified\"\n\n"
        "[lumen]\nmesh = \"lumen.ply\"\nunit = \"mm\"\n\n"
        "[tree]\ncentrelines = [\"tree.csv\"]\ninlet = \"%s\"\ninlet_end = \"first\"\n%s\n"
        "[entry]\nposition_mm = [%.3f, %.3f, %.3f]\ndirection = [%.5f, %.5f, %.5f]\n",
        tree.branches.front().name.c_str(), patient::coronary_branches(tree, "").scene_text().c_str(),
        entry.place_mm.x(), entry.place_mm.y(), entry.place_mm.z(), entry.direction.x(), entry.direction.y(),
        entry.direction.z());
    write_whole_file(in(patient, "scene.toml").string(), text);
}

void make_scene(Patient &patient, const centreline::Tree &tree, Steps &steps)
{
    const auto click = std::find_if(patient.clicks.rbegin(), patient.clicks.rend(),
                                    [](const Click &c) { return c.kind == ClickKind::entry; });
    const bool is_clicked = click != patient.clicks.rend();
    const patient::Entry entry = patient::inside_end(tree, is_clicked ? patient::end_near(tree, click->at_mm)
                                                                      : patient::low_end(tree));
    patient.findings.assumed.push_back(formatted(
        "instruments enter at (%.0f, %.0f, %.0f) mm, at the end of %s nearest to the %s", entry.place_mm.x(),
        entry.place_mm.y(), entry.place_mm.z(), entry.branch.c_str(), is_clicked ? "click" : "feet"));
    patient.findings.assumed.push_back(
        "the vessels neither beat nor breathe, and flow divides by Murray's law");
    const std::vector<fs::path> files = {in(patient, "scene.toml"), in(patient, "patient.scene"),
                                         in(patient, "patient.bodies")};
    const std::string inputs = patient.inputs + text_of(patient.clicks, {ClickKind::entry, ClickKind::name});
    if (steps.is_done("scene", inputs, files)) return;
    write_scene_text(patient, tree, entry);
    bake::Options options;
    options.scene = files[0];
    options.output = files[1];
    options.points = 20000;
    options.poses = 1000;
    bake::Progress progress;
    // The name of the folder may be that of the patient, so no output repeats it.
    std::string text = bake::bake(options, progress);
    const std::string folder = (patient.folder / "").string();
    for (std::size_t at = 0; (at = text.find(folder, at)) != std::string::npos;)
        text.erase(at, folder.size());
    write_whole_file(in(patient, "bake.txt").string(), text);
    steps.finish("scene", inputs);
}

centreline::Tree make_tree(Patient &patient, const bake::Mesh &lumen, Steps &steps, Page &page)
{
    const fs::path file = in(patient, "tree.csv"), notes = in(patient, "tree.json");
    const std::string inputs = patient.inputs + text_of(patient.clicks, {ClickKind::name});
    if (!steps.is_done("tree", inputs, {file, notes})) {
        Findings of_tree;
        const Eigen::Vector3d root_mm = patient.root_mm ? *patient.root_mm : root_of(patient.labels);
        centreline::Tree tree = tree_of(lumen, patient.labels, root_mm, of_tree);
        if (!patient.has_map && patient.has_aorta) patient::propose_names(tree);
        name_branches(tree, patient.clicks);
        describe_branches(tree, of_tree);
        centreline::write_tree(file, tree);
        write_whole_file(notes.string(), nlohmann::json(of_tree.facts).dump(2) + "\n");
        steps.finish("tree", inputs);
    }
    const centreline::Tree tree = centreline::read_tree(file);
    for (const auto &fact : nlohmann::json::parse(read_text_file(notes.string())))
        patient.findings.facts.push_back(fact.get<std::string>());
    patient.findings.check.push_back(std::string("names of branches are ") +
                                     (!patient.has_aorta ? "only numbers, without an aorta"
                                      : patient.has_map  ? "proposals from the label map"
                                                         : "proposals from where they leave the aorta") +
                                     ": --click name:x,y,z:NAME changes one");
    for (const int axis : {1, 0}) {
        Picture picture(patient.scan, axis, -1, 0, 900, 0.8);
        for (const centreline::Branch &branch : tree.branches) {
            std::vector<Eigen::Vector3d> line;
            for (const centreline::Sphere &sphere : branch.spheres) line.push_back(sphere.centre_mm);
            picture.line(line, yellow, 2);
            picture.dot(line.front(), red, 5);
        }
        page.show(picture, axis == 1 ? "tree_front.png" : "tree_side.png",
                  "Centrelines (yellow) and their beginnings (red) over the brightest voxels.");
    }
    return tree;
}

nlohmann::json report_of(const Patient &patient)
{
    return {{"format", 1},
            {"facts", patient.findings.facts},
            {"assumed", patient.findings.assumed},
            {"check", patient.findings.check},
            {"kept_of_the_scan", {"voxels", "spacing", "position and direction of the grid"}}};
}

std::string text_of(const Findings &findings)
{
    std::string text;
    const auto list = [&](const char *head, const std::vector<std::string> &lines) {
        text += std::string(head) + "\n";
        for (const std::string &line : lines) text += "  - " + line + "\n";
    };
    list("What a person must check", findings.check);
    list("What was assumed", findings.assumed);
    list("What was measured", findings.facts);
    return text;
}

// Reads scan, label map and table, and writes nothing.
void check_inputs(const PatientOptions &options)
{
    Patient patient = opened_scan(options);
    if (patient.has_map) {
        patient.labels = read_labels(options.labels, options.names, patient.scan);
        patient.contrast = contrast_in(patient.scan, patient.labels, patient.findings);
    }
    std::fputs(text_of(patient.findings).c_str(), stdout);
}

} // namespace

void command_patient(const PatientOptions &options)
{
    std::vector<NamedPath> inputs = {{"SCAN", options.scan.string()}};
    if (!options.labels.empty()) {
        inputs.push_back({"--labels", options.labels.string()});
        inputs.push_back({"--names", options.names.string()});
    }
    check_outputs(inputs, {});
    if (options.is_check) return check_inputs(options);
    check_output_folder({"--output", options.output.string()});
    Page page(options.output);
    Steps steps(options.output);
    Patient patient = read_patient(options, steps, page);
    patient.findings.check.push_back("look at every picture below; this is no medical device");
    make_picture(patient, steps, page);
    const bake::Mesh lumen = make_lumen(patient, steps, page);
    const centreline::Tree tree = make_tree(patient, lumen, steps, page);
    make_scene(patient, tree, steps);
    show_xray(options.output / "patient.bodies", page);
    write_whole_file((options.output / "report.json").string(), report_of(patient).dump(2) + "\n");
    const std::string text = text_of(patient.findings);
    page.write("Patient", text);
    std::fputs(text.c_str(), stdout);
    std::printf("%s: patient.scene, patient.bodies, patient.ct; look at index.html\n",
                options.output.string().c_str());
}

} // namespace crn::ct
