#include "tools/lab/ct/patient/patient.hpp"
#include "host/base/format.hpp"
#include "host/base/output_files.hpp"
#include "host/base/pending_file.hpp"
#include "host/base/text.hpp"
#include "host/picture/picture.hpp"
#include "shared/wire/wire_frame.h"
#include "tools/bake/bake.hpp"
#include "tools/centreline/formats.hpp"
#include "tools/lab/ct/commands.hpp"
#include "tools/lab/ct/patient/vessels.hpp"
#include "tools/lab/ct/patient/xray_pictures.hpp"
#include "tools/lab/ct/surface.hpp"
#include "tools/lab/ct/volume/volume_io.hpp"
#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace crn::ct
{

namespace
{

namespace fs = std::filesystem;

constexpr const char *steps_version = "2"; // another number: every step is made again

// Remembers, per step, the checksum of its inputs. A step whose files are there and whose inputs are the same
// is not repeated.
class Steps
{
  public:
    explicit Steps(const fs::path &folder) : file_(folder / "steps.json")
    {
        try {
            done_ = nlohmann::json::parse(read_text_file(file_.string()), nullptr, false);
        } catch (const FileError &) { // the first run
        }
        if (!done_.is_object()) done_ = nlohmann::json::object();
    }
    bool is_done(const std::string &step, const std::string &inputs, const std::vector<fs::path> &files) const
    {
        for (const fs::path &file : files)
            if (!fs::exists(file)) return false;
        return done_.contains(step) && done_[step] == inputs;
    }
    void finish(const std::string &step, const std::string &inputs)
    {
        done_[step] = inputs;
        write_whole_file(file_.string(), done_.dump(2) + "\n");
    }

  private:
    fs::path file_;
    nlohmann::json done_ = nlohmann::json::object();
};

std::string checksum(const void *bytes, std::size_t count)
{
    return formatted(
        "%08x", static_cast<unsigned>(crn_wire_crc32(0, static_cast<const std::uint8_t *>(bytes), count)));
}

std::string checksum(const Volume &volume)
{
    return checksum(volume.hu.data(), volume.hu.size() * sizeof(float)) +
           formatted(" %.6g %.6g %.6g %.6g %.6g %.6g", volume.spacing_mm[0], volume.spacing_mm[1],
                     volume.spacing_mm[2], volume.origin_mm[0], volume.origin_mm[1], volume.origin_mm[2]);
}

std::string checksum(const fs::path &file)
{
    const std::vector<unsigned char> bytes = read_binary_file(file.string());
    return checksum(bytes.data(), bytes.size());
}

struct Patient {
    Volume scan;
    LabelMap labels;
    Contrast contrast;
    Findings findings;
    fs::path folder;
    std::string inputs; // checksum of scan, labels and names
};

fs::path in(const Patient &patient, const char *name)
{
    return patient.folder / name;
}

Patient read_patient(const PatientOptions &options)
{
    Patient patient;
    patient.folder = options.output;
    patient.scan = along_patient_axes(read_volume(options.scan));
    for (const std::string &note : patient.scan.notes) patient.findings.check.push_back("the scan " + note);
    check_scan(patient.scan, patient.findings);
    // Only voxels and grid remain of the scan. No tag of a DICOM file goes any further.
    patient.scan.name = "scan";
    if (options.labels.empty()) return patient; // only the scan is checked
    patient.labels = read_labels(options.labels, options.names, patient.scan);
    patient.contrast = contrast_in(patient.scan, patient.labels, patient.findings);
    patient.inputs = std::string(steps_version) + " " + checksum(patient.scan) + " " +
                     checksum(patient.labels.volume) + " " + checksum(options.names);
    return patient;
}

void make_picture(Patient &patient, Steps &steps, Page &page)
{
    const fs::path file = in(patient, "patient.ct");
    const Mask body = body_of(patient.scan);
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
    patient.findings.assumed.push_back("the lumen begins as the arteries of the label map; a geodesic active "
                                       "contour moves it to the edges of the scan");
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

void write_scene_text(const Patient &patient, const centreline::Tree &tree, const Entry &entry)
{
    const std::string text = formatted(
        "# Made by `ct patient`. It may be changed and baked again: bake scene.toml -o patient.scene\n"
        "[scene]\nname = \"Patient\"\nsource = \"ct patient, from a CT; de-identified\"\n\n"
        "[lumen]\nmesh = \"lumen.ply\"\nunit = \"mm\"\n\n"
        "[tree]\ncentrelines = [\"tree.csv\"]\ninlet = \"%s\"\ninlet_end = \"first\"\n\n"
        "[entry]\nposition_mm = [%.3f, %.3f, %.3f]\ndirection = [%.5f, %.5f, %.5f]\n",
        tree.branches.front().name.c_str(), entry.place_mm.x(), entry.place_mm.y(), entry.place_mm.z(),
        entry.direction.x(), entry.direction.y(), entry.direction.z());
    write_whole_file(in(patient, "scene.toml").string(), text);
}

void make_scene(Patient &patient, const centreline::Tree &tree, Steps &steps)
{
    const Entry entry = entry_of(tree, patient.scan.name);
    patient.findings.assumed.push_back(
        formatted("instruments enter at (%.0f, %.0f, %.0f) mm, at the end of %s nearest to the "
                  "feet",
                  entry.place_mm.x(), entry.place_mm.y(), entry.place_mm.z(), entry.branch.c_str()));
    patient.findings.assumed.push_back(
        "the vessels neither beat nor breathe, and flow divides by Murray's law");
    const std::vector<fs::path> files = {in(patient, "scene.toml"), in(patient, "patient.scene"),
                                         in(patient, "patient.bodies")};
    if (steps.is_done("scene", patient.inputs, files)) return;
    write_scene_text(patient, tree, entry);
    bake::Options options;
    options.scene = files[0];
    options.output = files[1];
    options.points = 20000;
    options.poses = 1000;
    bake::Progress progress;
    write_whole_file(in(patient, "bake.txt").string(), bake::bake(options, progress));
    steps.finish("scene", patient.inputs);
}

centreline::Tree make_tree(Patient &patient, const bake::Mesh &lumen, Steps &steps, Page &page)
{
    const fs::path file = in(patient, "tree.csv"), notes = in(patient, "tree.json");
    if (!steps.is_done("tree", patient.inputs, {file, notes})) {
        Findings of_tree;
        const centreline::Tree tree = tree_of(lumen, patient.labels, of_tree);
        centreline::write_tree(file, tree);
        write_whole_file(notes.string(), nlohmann::json(of_tree.facts).dump(2) + "\n");
        steps.finish("tree", patient.inputs);
    }
    const centreline::Tree tree = centreline::read_tree(file);
    for (const auto &fact : nlohmann::json::parse(read_text_file(notes.string())))
        patient.findings.facts.push_back(fact.get<std::string>());
    patient.findings.check.push_back("names of branches are proposals from the label map");
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

} // namespace

void command_patient(const PatientOptions &options)
{
    check_outputs({{"SCAN", options.scan.string()},
                   {"--labels", options.labels.string()},
                   {"--names", options.names.string()}},
                  {});
    if (options.is_check) {
        std::fputs(text_of(read_patient(options).findings).c_str(), stdout);
        return;
    }
    check_output_folder({"--output", options.output.string()});
    Patient patient = read_patient(options);
    Page page(options.output);
    Steps steps(options.output);
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
