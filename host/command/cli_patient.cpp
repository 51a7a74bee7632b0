#include "host/command/cli_patient.hpp"
#include "host/base/output_files.hpp"
#include "host/cases/programs.hpp"
#include "host/command/start.hpp"

namespace crn
{

namespace
{

struct PassedOption {
    const char *name, *type, *what;
    int values; // 0: a flag; -1: may be repeated
};

// The options of `centreline patient` and `ct labels`, which check their values.
constexpr PassedOption passed_options[] = {
    {"--part", "NAME", "Only this part of the meshes; may end in *, may be repeated", -1},
    {"--label", "N", "This label of a map is a vessel; may be repeated", -1},
    {"--unit", "m|cm|mm|um", "Of the meshes; else found", 1},
    {"--axes", "AXES",
     "lps, ras, or the file's axes that are left, head and front, like +x,+z,-y; else found", 1},
    {"--walls", "auto|lumen|wall", "Whether meshes are lumens, or walls of two sheets (default auto)", 1},
    {"--solid-mm", "N", "Voxel in which parts become one; else by the vessels' size", 1},
    {"--bridge-mm", "N", "Gaps between parts that are bridged (default 3)", 1},
    {"--shortest-mm", "N", "Branches that are kept (default 5)", 1},
    {"--inlet", "X Y Z", "In the scene, mm: where the blood comes in; else found", 3},
    {"--entry", "X Y Z", "In the scene, mm: instruments enter at the end nearest to it; else found", 3},
    {"--branches", "auto|aorta|parts|numbers", "What branches are named by (default auto)", 1},
    {"--name", "TEXT", "Of the scene", 1},
    {"--body", "MATERIAL:FILE", "A body for the picture, like cortical_bone:pelvis.stl; may be repeated", -1},
    {"--no-bodies", "", "No tissue and no blood in the picture", 0},
};

void add_choices(CLI::App &command, PatientCommandOptions &options)
{
    for (const PassedOption &option : passed_options) {
        const std::string name = option.name;
        const auto keep = [&options, name](const std::vector<std::string> &values) {
            options.choices.emplace_back(name, values);
        };
        if (option.values == 0) {
            command
                .add_flag_callback(
                    name, [keep] { keep({}); }, option.what)
                ->group("Meshes and label maps");
            continue;
        }
        CLI::Option *added = command.add_option_function<std::vector<std::string>>(name, keep, option.what)
                                 ->type_name(option.type)
                                 ->group("Meshes and label maps");
        if (option.values > 0)
            added->expected(option.values);
        else
            added->allow_extra_args(false);
    }
}

CLI::App *add_new(CLI::App &patient, PatientCommandOptions &options)
{
    CLI::App *command = patient.add_subcommand(
        "new",
        "Make a scene of vessel meshes, of a label map, or of a CT with contrast medium in the arteries");
    CLI::Option *mesh =
        command
            ->add_option("--mesh", options.meshes,
                         "Vessels as .stl, .obj, .ply, .vtp, .gltf or .glb; one file or several")
            ->type_name("FILE");
    command
        ->add_option("--ct", options.scan, "Folder with one DICOM series, or a .nrrd, .nii(.gz) or .mha file")
        ->excludes(mesh)
        ->type_name("SCAN");
    CLI::Option *labels =
        command
            ->add_option("--labels", options.labels,
                         "Label map of a program that segments scans, with the scan or alone")
            ->excludes(mesh)
            ->type_name("FILE");
    command->add_option("--names", options.names, "Table of the label map's numbers and names")
        ->type_name("FILE")
        ->needs(labels);
    command
        ->add_option("--click", options.clicks,
                     "A place in the scan, such as artery:12,-230,4; kinds: artery, cut, bridge, entry, name")
        ->type_name("KIND:X,Y,Z");
    command->add_option("-o,--output", options.folder, "Folder of the scene and its report")
        ->required()
        ->type_name("FOLDER");
    add_choices(*command, options);
    command->footer(
        "Examples:\n  cournand patient new --mesh aorta.stl -o mine\n"
        "  cournand patient new --labels map.nii.gz --names names.csv -o mine\n"
        "  cournand patient new --ct dicom_folder -o patient\n"
        "  cournand patient new --ct scan.nii.gz --labels map.nii.gz --names names.csv -o patient "
        "--no-window");
    return command;
}

// Which program and which of its commands makes the scene.
bool is_of_scan(const PatientCommandOptions &options)
{
    return !options.scan.empty();
}

} // namespace

void add_patient(CLI::App &app, PatientCommandOptions &options)
{
    CLI::App *patient =
        app.add_subcommand("patient", "Practise in your own vessels: docs/own_mesh.md, docs/own_ct.md");
    patient->require_subcommand(1);
    CLI::App *made = add_new(*patient, options);
    made->add_flag("!--no-window", options.shows_window, "Show no window, even if there is a display");
    CLI::App *review =
        patient->add_subcommand("review", "Look at a patient that was made, mend its arteries, and play it");
    review->add_option("folder", options.folder, "Folder that `cournand patient new` has made")
        ->required()
        ->type_name("FOLDER");
    review->footer("Examples:\n  cournand patient review patient");
    patient->footer("Examples:\n  cournand patient new --mesh aorta.stl -o mine\n"
                    "  cournand patient new --ct dicom_folder -o patient\n"
                    "  cournand patient review patient");
}

static void add_passed(std::vector<std::string> &words, const PatientCommandOptions &options)
{
    for (const auto &[name, values] : options.choices) {
        for (std::size_t n = 0; n < values.size(); ++n)
            // Numbers may begin with a minus, so they stand behind their option; names are repeated with it.
            if (n == 0 || name == "--part" || name == "--label" || name == "--body")
                words.insert(words.end(), {name, values[n]});
            else
                words.push_back(values[n]);
        if (values.empty()) words.push_back(name);
    }
}

std::vector<std::string> patient_words(const std::string &program, const PatientCommandOptions &options,
                                       bool is_review, bool has_display)
{
    if (is_review)
        return {program, "patient", options.folder + "/scan.ct", "-o", options.folder, "--window", "--look"};
    std::vector<std::string> words;
    if (is_of_scan(options)) {
        words = {program, "patient", options.scan, "-o", options.folder};
        if (!options.labels.empty()) words.insert(words.end(), {"--labels", options.labels});
        if (!options.names.empty()) words.insert(words.end(), {"--names", options.names});
        for (const std::string &click : options.clicks) words.insert(words.end(), {"--click", click});
        if (options.shows_window && has_display) words.push_back("--window");
        return words;
    }
    if (!options.meshes.empty()) {
        words = {program, "patient"};
        words.insert(words.end(), options.meshes.begin(), options.meshes.end());
    } else {
        words = {program, "labels", options.labels};
        if (!options.names.empty()) words.insert(words.end(), {"--table", options.names});
    }
    words.insert(words.end(), {"-o", options.folder});
    add_passed(words, options);
    return words;
}

static void check_inputs(const PatientCommandOptions &options)
{
    if (options.meshes.empty() && options.labels.empty() && options.scan.empty())
        throw UsageError("patient new: nothing to make a scene of: give --mesh, --labels or --ct");
    if (is_of_scan(options) && !options.choices.empty())
        throw UsageError("patient new: " + options.choices.front().first +
                         " belongs to meshes and label maps without a scan; a scan is mended by --click");
    if (!is_of_scan(options) && !options.clicks.empty())
        throw UsageError(
            "patient new: --click belongs to a scan (--ct): give --inlet, --entry or --bridge-mm");
}

int command_patient(const CLI::App &app, const PatientCommandOptions &options)
{
    check_output_folder({"--output", options.folder});
    const bool is_review = app.get_subcommand("patient")->got_subcommand("review");
    if (!is_review) check_inputs(options);
    const bool is_mesh = !is_review && !options.meshes.empty();
    const std::string program =
        is_mesh ? sibling_program("centreline", "`make` builds it, and `make install` installs it")
                : sibling_program("ct", "`make lab` builds it, with the library ITK, which reads scans");
    become_program(patient_words(program, options, is_review, has_display()));
}

} // namespace crn
