// Command line of `ct` (docs/ct.md).
#include "host/base/command_values.hpp"
#include "host/base/output_files.hpp"
#include "host/base/terminal.hpp"
#include "host/base/text.hpp"
#include "host/base/version.hpp"
#include "host/cases/programs.hpp"
#include "tools/lab/ct/arteries/clicks.hpp"
#include "tools/lab/ct/commands.hpp"
#include "tools/lab/ct/cta/cta.hpp"
#include "tools/lab/ct/patient/label_map.hpp"
#include "tools/lab/ct/patient/patient.hpp"
#include "tools/lab/ct/review/review_window.hpp"
#include "tools/lab/reference_rod/truth_options.hpp"
#include "tools/patient/options.hpp"

#include <cstdio>
#include <thread>

namespace
{

using namespace crn::ct;

constexpr const char *examples =
    "Examples:\n"
    "  ct simulate out/case                                 scans every depth of a case that has its truth\n"
    "  ct simulate out/case --instrument rosen.toml --scene out/access.scene --surface out/access.ply \\\n"
    "      --depth iliac:240:0 --depth aortic:300:0 --depth renal:362:0 --tip-factor 0.7   makes the truth "
    "first\n"
    "  ct segment scan.nrrd -o out/seg                      lumen, instrument, centreline, report and "
    "pictures\n"
    "  ct segment out/case && ct check out/case             every depth of a case; how far from its truth\n"
    "  ct scan lumen.ply wire.csv -o scan.nrrd              one scan of a steel wire in a phantom\n"
    "  ct scan lumen.ply wire.csv -o series --material nitinol      the same as a DICOM series\n"
    "  ct patient scan.nii.gz -o patient                    a scene from a patient's CT\n"
    "  ct labels map.nii.gz --table names.csv -o mine       a scene from a label map alone\n"
    "ct SUBCOMMAND --help has the options.\n"
    "Volumes: .nrrd, .nii, .nii.gz, .mha, or a folder with a DICOM series. Places are in the scene's axes "
    "(+x patient left, +y head, +z front), in mm.\n"
    "Ctrl-C keeps what was finished. Exit codes: 0 done, 1 the input is unusable (the message says why), 2 "
    "usage.\n";

constexpr const char *scan_footer =
    "Examples:\n"
    "  ct scan lumen.ply wire.csv -o scan.nrrd                      a steel wire of 0.035 inch\n"
    "  ct scan lumen.ply wire.csv --instrument rosen.toml -o series     as the file describes it, a DICOM "
    "series\n"
    "  ct scan lumen.ply -o empty.nii.gz --views 300                without an instrument, coarser and "
    "faster\n"
    "docs/ct.md, \"The scanner\", says what is modelled.\n";

constexpr const char *simulate_footer =
    "Examples:\n"
    "  ct simulate out/case                                 scans every depth of a case that has its truth\n"
    "  ct simulate out/case --format dicom --noise-HU 30    as DICOM series, noisier\n"
    "  ct simulate out/case --instrument rosen.toml --scene out/access.scene --surface out/access.ply \\\n"
    "      --depth iliac:240:0 --depth aortic:300:0 --shaft-factor 1.3 --tip-factor 0.7    makes the case "
    "first\n"
    "Written: CASE/scan_N, and their names into CASE/case.toml (docs/ct.md).\n";

constexpr const char *segment_footer =
    "Examples:\n"
    "  ct segment scan.nrrd -o out/seg                  one scan\n"
    "  ct segment series --seed 12,-40,3 -o out/seg     the instrument at this place, of a DICOM series\n"
    "  ct segment out/case                              every scan of a case; the lumen is that of all\n"
    "A case without scene and mouth_mm gets them: the lumen is baked, and the mouth is where so much of the "
    "instrument\n"
    "is inserted as its depths say. calibrate CASE comes next. docs/ct.md has the files and how far to trust "
    "them.\n";

constexpr const char *patient_footer =
    "Examples:\n"
    "  ct patient scan.nii.gz -o patient                                     finds the arteries\n"
    "  ct patient scan.nii.gz -o patient --click bridge:31,-240,8            again: mends a gap, repeats "
    "what "
    "changed\n"
    "  ct patient scan.nii.gz --labels map.nii.gz --names names.csv -o patient      with a label map\n"
    "  ct patient dicom_folder --check                                       can it be used?\n"
    "  cournand view patient/patient.scene                                   plays the scene\n"
    "Clicks: artery:x,y,z is in an artery; cut:x,y,z:RADIUS is none; bridge:x,y,z joins two ends;\n"
    "entry:x,y,z is where instruments enter; name:x,y,z:NAME names a branch.\n"
    "A label map has the scan's grid and TotalSegmentator's names; one structure must be the aorta.\n"
    "Written: patient.scene, patient.bodies, patient.ct, scene.toml, lumen.ply, tree.csv, report.json, "
    "index.html.\n"
    "Nothing of the scan but its voxels and its grid is kept. docs/own_ct.md says what is assumed and "
    "checked.\n";

constexpr const char *cta_footer =
    "Examples:\n"
    "  anatomy person --seed 7 -o seven && ct cta seven -o cta.nii.gz        from the groins to the arch\n"
    "  ct cta seven -o series --slice-mm 2 --noise-HU 30 --pulse-mm 2        a DICOM series, noisier\n"
    "  ct cta seven -o cta.nrrd --labels map.nrrd --truth truth.csv          with the true arteries\n"
    "docs/own_ct.md, \"Virtual angiograms\", says what is modelled.\n";

constexpr const char *check_footer = "Example:\n"
                                     "  ct check out/case      after ct segment; exit code 1 where a mean or "
                                     "a greatest distance is over its bar\n"
                                     "Bars (docs/ct.md): centreline mean 0.2 mm, most 0.6 mm; lumen mean 0.3 "
                                     "mm; from found to true and back.\n";

void add_scanner_options(CLI::App &command, ScannerSettings &scanner, PhantomMaterials &phantom)
{
    const auto number = [&](const char *name, double &value, const char *what, double low, double high) {
        command.add_option(name, value, what)->check(CLI::Range(low, high))->capture_default_str();
    };
    number("--pixel-mm", scanner.spacing_mm[0], "side of a pixel", 0.1, 2);
    number("--slice-mm", scanner.spacing_mm[2], "distance of slices", 0.2, 5);
    number("--blur-mm", scanner.blur_mm, "sigma of the point spread in a slice", 0.2, 2);
    number("--blur-slice-mm", scanner.blur_slice_mm, "sigma across it", 0.1, 5);
    number("--noise-HU", scanner.noise_HU, "standard deviation in the phantom's middle", 0, 200);
    number("--highest-HU", scanner.highest_HU, "of the scanner's numbers: 3071 with 12 bits", 500, 32767);
    number("--tube-kV", scanner.tube_kV, "voltage of the tube", 60, 125);
    command.add_option("--views", scanner.views, "over half a turn")
        ->check(CLI::Range(60, 3000))
        ->capture_default_str();
    command.add_option("--seed", scanner.seed, "of the noise")->capture_default_str();
    command.add_option("--threads", scanner.threads, "the volume does not depend on it")
        ->check(CLI::Range(1, 256))
        ->capture_default_str();
    number("--fluid-HU", phantom.fluid_HU, "of the fluid in the lumen", -200, 2000);
    number("--silicone-HU", phantom.silicone_HU, "of the wall", -200, 2000);
    number("--gel-HU", phantom.gel_HU, "of what holds the vessels; -1000: air", -1000, 2000);
    number("--wall-mm", phantom.wall_mm, "thickness of the wall", 0.5, 20);
}

void add_scan(CLI::App &app, ScanOptions &options)
{
    CLI::App &command = *app.add_subcommand("scan", "one virtual scan of a phantom with instruments in it");
    command.footer(scan_footer);
    command.add_option("MESH", options.mesh, "the lumen as a closed surface in mm: PLY, STL, OBJ or glTF")
        ->required();
    command.add_option("LINE", options.lines,
                       "centrelines (CSV) from the mouth to the tip; none: an empty phantom");
    command.add_option("-o,--output", options.output, "the volume")->required();
    command.add_option("--instrument", options.instrument,
                       "instrument file, with :PRESET if it is not physical");
    command.add_option("--radius-mm", options.radius_mm, "without a file: of the instrument")
        ->check(CLI::Range(0.05, 5.0))
        ->capture_default_str();
    command.add_option("--bore-mm", options.bore_mm, "radius of its own lumen")
        ->check(CLI::Range(0.0, 5.0))
        ->capture_default_str();
    command.add_option("--material", options.material, "as in docs/xray.md")->capture_default_str();
    command.add_option("--box", options.box_mm, "of the gel and the picture: low x y z, high x y z")
        ->expected(6);
    add_scanner_options(command, options.scanner, options.phantom);
    command.callback([&options] {
        options.scanner.spacing_mm[1] = options.scanner.spacing_mm[0];
        command_scan(options);
    });
}

void add_simulate(CLI::App &app, SimulateOptions &options, std::vector<std::string> &depths)
{
    CLI::App &command =
        *app.add_subcommand("simulate", "virtual scans of every depth of a case; with --instrument the case "
                                        "is made first, by an independent rod");
    command.footer(simulate_footer);
    command.add_option("CASE", options.folder, "a case's folder with truth/, or the one to be made")
        ->required();
    crn::reference::add_truth_options(command, options.truth, depths);
    command.add_option("--format", options.format, "of the volumes")
        ->check(CLI::IsMember({"nrrd", "nii.gz", "mha", "dicom"}))
        ->capture_default_str();
    add_scanner_options(command, options.scanner, options.phantom);
    command.callback([&] {
        options.scanner.spacing_mm[1] = options.scanner.spacing_mm[0];
        for (const std::string &text : depths)
            options.truth.depths.push_back(crn::reference::depth_from(text));
        command_simulate(options);
    });
}

void add_segment(CLI::App &app, SegmentCommand &options, std::vector<double> &seed,
                 std::vector<double> &mouth, std::vector<double> &direction)
{
    CLI::App &command = *app.add_subcommand(
        "segment", "lumen, instrument and centreline from a scan, or from every scan of a case");
    command.footer(segment_footer);
    command.add_option("SCAN", options.input, "a volume, a folder with a DICOM series, or a case's folder")
        ->required();
    command.add_option("-o,--output", options.output,
                       "folder; default: CASE/segmentation, or out/segmentation");
    command.add_option("--seed", seed, "a place on the instrument: x y z")->expected(3)->delimiter(',');
    command
        .add_option("--threshold", options.options.line.threshold_HU,
                    "HU of the instrument; 0: half-way to the brightest")
        ->check(CLI::Range(0.0, 32767.0))
        ->capture_default_str();
    command.add_option("--mouth", mouth, "where the centreline begins: x y z; a case knows it")
        ->expected(3)
        ->delimiter(',');
    command.add_option("--direction", direction, "into the vessel there")->expected(3)->delimiter(',');
    command
        .add_option("--fluid-HU", options.options.lumen.fluid_HU,
                    "of the fluid; below -1500: the commonest around the instrument")
        ->capture_default_str();
    command.add_flag("!--no-lumen", options.options.wants_lumen, "the instrument alone");
    command.callback([&] {
        const auto vector = [](const std::vector<double> &v) { return Eigen::Vector3d(v[0], v[1], v[2]); };
        if (!seed.empty()) options.options.line.seed_mm = vector(seed);
        if (!mouth.empty()) options.options.line.mouth_mm = vector(mouth);
        if (!direction.empty() && vector(direction).norm() > 0)
            options.options.line.direction = vector(direction).normalized();
        command_segment(options);
    });
}

// The command that the window runs: this one, without its window.
std::vector<std::string> command_of(const PatientOptions &options)
{
    std::vector<std::string> words = {crn::sibling_program("ct"), "patient", options.scan.string()};
    if (!options.labels.empty())
        words.insert(words.end(), {"--labels", options.labels.string(), "--names", options.names.string()});
    words.insert(words.end(), {"--output", options.output.string()});
    return words;
}

void patient_in_window(const PatientOptions &options, ReviewOptions review)
{
    if (!review.runs_at_once && !std::filesystem::exists(options.scan))
        throw std::runtime_error(options.scan.string() +
                                 ": there is none: name a folder that `cournand patient new` has made");
    crn::check_output_folder({"--output", options.output.string()});
    std::filesystem::create_directories(options.output);
    review.folder = options.output;
    review.command = command_of(options);
    // Clicks of the command line belong to the first run; later the file of clicks has them.
    review.first_command = review.command;
    for (const std::string &click : options.clicks)
        review.first_command.insert(review.first_command.end(), {"--click", click});
    switch (review_patient(review)) {
    case ReviewEnd::interrupted:
        throw std::runtime_error("interrupted; finished steps are kept in " + options.output.string());
    case ReviewEnd::wants_play:
        crn::become_program({crn::sibling_program("cournand"), "view", "--scene",
                             (options.output / "patient.scene").string(), "--tool", "j_wire", "--inserted",
                             "20"});
    case ReviewEnd::closed:
        break;
    }
}

struct WindowChoice {
    bool is_wanted = false;
    ReviewOptions review;
};

void add_patient(CLI::App &app, PatientOptions &options, WindowChoice &window)
{
    CLI::App &command = *app.add_subcommand("patient", "a playable scene from a patient's CT");
    command.footer(patient_footer);
    command.add_option("SCAN", options.scan, "a volume, or a folder with a DICOM series, in HU")->required();
    CLI::Option *labels = command.add_option(
        "--labels", options.labels,
        "label map of organs and arteries on the scan's grid; none: the arteries are found");
    labels->needs(command.add_option("--names", options.names, "table of the labels' numbers and names")
                      ->needs(labels));
    command
        .add_option("--click", options.clicks,
                    "mends the arteries: artery, cut, bridge, entry or name, and a place in mm, as in "
                    "artery:12,-230,4; kept in clicks.toml of the folder")
        ->check([](const std::string &text) {
            try {
                click_of(text);
                return std::string();
            } catch (const std::exception &error) {
                return std::string(error.what());
            }
        });
    command.add_option("-o,--output", options.output, "folder of the scene and its report");
    CLI::Option *check = command.add_flag(
        "--check", options.is_check,
        "only reads the inputs, without -o, and says what is wrong with them or must be checked");
    command
        .add_flag("--window", window.is_wanted,
                  "look at every step, mend the arteries by clicks, and play the scene")
        ->excludes(check);
    command.add_flag("!--look", window.review.runs_at_once,
                     "with --window: make nothing until it is asked for");
    command.add_option("--screenshot", window.review.screenshot, "PNG of the window at its end")
        ->group("Window");
    command.add_option("--frames", window.review.frames, "end the window after so many frames")
        ->check(CLI::Range(1, 10000))
        ->group("Window");
    command.add_option("--layout", window.review.layout, "places of the window's controls, for tests")
        ->group("Window");
    command.callback([&options, &window] {
        if (!options.is_check && options.output.empty()) throw CLI::RequiredError("--output");
        if (window.is_wanted)
            patient_in_window(options, window.review);
        else
            command_patient(options);
    });
}

void add_labels(CLI::App &app, LabelWish &labels, crn::patient::SceneOptions &options)
{
    CLI::App &command =
        *app.add_subcommand("labels", "a playable scene from a label map alone, without a scan");
    command.footer("Examples:\n"
                   "  ct labels vessels.nii.gz -o mine                     every label is a vessel\n"
                   "  ct labels map.nii.gz --table names.csv -o mine       the arteries by their names\n"
                   "  ct labels map.nrrd --label 52 --label 65 -o mine     these labels\n"
                   "docs/own_mesh.md has what is decided, and how to decide otherwise.\n");
    command.add_option("MAP", labels.map, "the label map: .nrrd, .nii, .nii.gz or .mha")->required();
    command.add_option("--table", labels.table, "the labels' numbers and names");
    command.add_option("--label", labels.labels, "this label is a vessel; may be repeated");
    crn::patient::add_scene_options(command, options);
    command.callback([&labels, &options] {
        std::vector<crn::NamedPath> inputs = {{"MAP", labels.map.string()}};
        if (!labels.table.empty()) inputs.push_back({"--table", labels.table.string()});
        crn::check_outputs(inputs, {});
        const crn::patient::SceneWish wish = crn::patient::wish_of(options);
        crn::patient::make_and_tell(
            [&](crn::patient::Choices &choices, crn::bake::Progress &progress) {
                make_label_scene(labels, wish, choices, progress);
            },
            wish);
    });
}

void add_cta(CLI::App &app, CtaOptions &options)
{
    CLI::App &command =
        *app.add_subcommand("cta", "a virtual CT angiogram of a person whom `anatomy person` has made");
    command.footer(cta_footer);
    const auto number = [&](const char *name, double &value, const char *what, double low, double high) {
        command.add_option(name, value, what)->check(CLI::Range(low, high))->capture_default_str();
    };
    command.add_option("PERSON", options.person, "the folder that `anatomy person` has made")->required();
    command.add_option("-o,--output", options.output, "the volume")->required();
    command.add_option("--labels", options.labels,
                       "also a label map of the true arteries, and beside it a table, .csv");
    command.add_option("--truth", options.truth, "also a table of the true centrelines and radii, .csv");
    number("--pixel-mm", options.pixel_mm, "side of a pixel", 0.3, 2);
    number("--slice-mm", options.slice_mm, "distance and thickness of slices", 0.3, 5);
    number("--low-mm", options.low_mm, "lower end, in the scene's heights; equal to --high-mm: the groins",
           -900, 900);
    number("--high-mm", options.high_mm, "upper end; equal to --low-mm: above the arch", -900, 900);
    number("--artery-HU", options.artery_HU, "medium in the arteries", 60, 800);
    number("--blur-mm", options.blur_mm, "sigma of the point spread in a slice", 0, 3);
    number("--blur-slice-mm", options.blur_slice_mm, "sigma across it", 0, 5);
    number("--noise-HU", options.noise_HU, "standard deviation", 0, 200);
    number("--breath-mm", options.breath_mm, "by which breath moves slices up and down", 0, 10);
    number("--pulse-mm", options.pulse_mm, "by which the heart moves slices to the sides", 0, 10);
    command.add_option("--seed", options.seed, "of the noise")->capture_default_str();
    command.callback([&options] { command_cta(options); });
}

} // namespace

int main(int argc, char **argv)
{
    CLI::App app{
        "ct: reads CT scans of patients and of instruments in vessel phantoms, and makes virtual ones"};
    app.footer(examples);
    app.require_subcommand(1);
    ScanOptions scan;
    SimulateOptions simulate;
    scan.scanner.threads = simulate.scanner.threads =
        static_cast<int>(std::clamp(std::thread::hardware_concurrency(), 1u, 256u));
    add_scan(app, scan);
    std::vector<std::string> depths;
    add_simulate(app, simulate, depths);
    SegmentCommand segment;
    std::vector<double> seed, mouth, direction;
    add_segment(app, segment, seed, mouth, direction);
    PatientOptions patient;
    WindowChoice window;
    add_patient(app, patient, window);
    LabelWish labels;
    crn::patient::SceneOptions scene;
    add_labels(app, labels, scene);
    CtaOptions cta;
    add_cta(app, cta);
    std::filesystem::path checked;
    bool is_good = true;
    CLI::App &check =
        *app.add_subcommand("check", "distances of a case's centrelines and lumen from its truth");
    check.footer(check_footer);
    check.add_option("CASE", checked, "a case's folder with truth/")->required();
    check.callback([&] { is_good = command_check(checked); });
    crn::refuse_empty_values(app);
    app.set_version_flag("--version", crn::version_of("ct"));
    try {
        app.parse(argc, argv);
        return is_good ? 0 : 1;
    } catch (const CLI::ParseError &error) {
        return app.exit(error) == 0 ? 0 : 2;
    } catch (const crn::UsageError &error) {
        crn::say(stderr, "ct: %s\n", error.what());
        return 2;
    } catch (const std::invalid_argument &error) {
        crn::say(stderr, "ct: %s\n", error.what());
        return 2;
    } catch (const std::exception &error) {
        crn::say(stderr, "ct: %s\n", error.what());
        return 1;
    }
}
