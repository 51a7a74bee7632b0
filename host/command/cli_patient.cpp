#include "host/command/cli_patient.hpp"
#include "host/base/output_files.hpp"
#include "host/cases/programs.hpp"
#include "host/command/start.hpp"

namespace crn
{

namespace
{

CLI::App *add_new(CLI::App &patient, PatientCommandOptions &options)
{
    CLI::App *command =
        patient.add_subcommand("new", "Make a scene of a CT with contrast medium in the arteries");
    command
        ->add_option("--ct", options.scan, "Folder with one DICOM series, or a .nrrd, .nii(.gz) or .mha file")
        ->required()
        ->type_name("SCAN");
    CLI::Option *labels =
        command->add_option("--labels", options.labels, "Label map of a program that segments scans")
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
    command->footer(
        "Examples:\n  cournand patient new --ct dicom_folder -o patient\n"
        "  cournand patient new --ct scan.nii.gz --labels map.nii.gz --names names.csv -o patient "
        "--no-window");
    return command;
}

} // namespace

void add_patient(CLI::App &app, PatientCommandOptions &options)
{
    CLI::App *patient = app.add_subcommand("patient", "Practise in your own CT (docs/own_ct.md)");
    patient->require_subcommand(1);
    CLI::App *made = add_new(*patient, options);
    made->add_flag("!--no-window", options.shows_window, "Show no window, even if there is a display");
    CLI::App *review =
        patient->add_subcommand("review", "Look at a patient that was made, mend its arteries, and play it");
    review->add_option("folder", options.folder, "Folder that `cournand patient new` has made")
        ->required()
        ->type_name("FOLDER");
    review->footer("Examples:\n  cournand patient review patient");
    patient->footer("Examples:\n  cournand patient new --ct dicom_folder -o patient\n"
                    "  cournand patient review patient");
}

std::vector<std::string> patient_words(const std::string &ct, const PatientCommandOptions &options,
                                       bool is_review, bool has_display)
{
    if (is_review)
        return {ct, "patient", options.folder + "/scan.ct", "-o", options.folder, "--window", "--look"};
    std::vector<std::string> words = {ct, "patient", options.scan, "-o", options.folder};
    if (!options.labels.empty()) words.insert(words.end(), {"--labels", options.labels});
    if (!options.names.empty()) words.insert(words.end(), {"--names", options.names});
    for (const std::string &click : options.clicks) words.insert(words.end(), {"--click", click});
    if (options.shows_window && has_display) words.push_back("--window");
    return words;
}

int command_patient(const CLI::App &app, const PatientCommandOptions &options)
{
    check_output_folder({"--output", options.folder});
    const bool is_review = app.get_subcommand("patient")->got_subcommand("review");
    const std::string ct =
        sibling_program("ct", "`make lab` builds it, with the library ITK, which reads scans");
    become_program(patient_words(ct, options, is_review, has_display()));
}

} // namespace crn
