#include "host/command/cli_records.hpp"
#include "host/records/exchange.hpp"
#include <CLI/CLI.hpp>

namespace crn
{

namespace
{

CLI::App *add(CLI::App &records, RecordsOptions &options, const std::string &name, const std::string &what,
              const std::string &examples)
{
    CLI::App *command = records.add_subcommand(name, what);
    command->callback([&options, name] { options.command = name; });
    command
        ->add_option(
            "--records", options.place,
            "File of the records, or a server (postgresql://USER@HOST/DATABASE); default: COURNAND_RECORDS, "
            "else records.db in ~/.local/share/cournand")
        ->allow_extra_args(false);
    command->footer("Examples:\n" + examples);
    return command;
}

void add_json(CLI::App &command, RecordsOptions &options)
{
    command.add_flag("--json", options.json, "As JSON, on standard output");
}

void add_filters(CLI::App &command, RecordsOptions &options)
{
    command.add_option("--trainee", options.trainee, "Only sessions of this pseudonym");
    command.add_option("--case", options.case_id, "Only sessions of this case");
}

void add_reading(CLI::App &records, RecordsOptions &options)
{
    CLI::App *list = add(records, options, "list", "Sessions, or trainees, one line each",
                         "  cournand records list\n  cournand records list --trainees --json");
    add_filters(*list, options);
    list->add_flag("--trainees", options.lists_trainees, "Instead: the trainees");
    add_json(*list, options);
    CLI::App *show = add(records, options, "show", "All of one session, or of one trainee",
                         "  cournand records show 0193ab12-77f0\n  cournand records show otter --json");
    show->add_option("what", options.what, "Begin of a session's id, or a pseudonym")->required();
    add_json(*show, options);
    CLI::App *send =
        add(records, options, "export", "Sessions as CSV, JSON or xAPI statements",
            "  cournand records export --format csv -o sessions.csv\n"
            "  cournand records export --format xapi --trainee otter --home-page https://hospital.example");
    send->add_option("--format", options.format, "csv, json (for import), or xapi (docs/records.md)")
        ->capture_default_str()
        ->check(CLI::IsMember({"csv", "json", "xapi"}));
    send->add_option("-o,--output", options.output, "File; default: standard output");
    send->add_option("--home-page", options.home_page,
                     std::string("With xapi: address that the pseudonyms belong to; default: ") +
                         records_home_page);
    add_filters(*send, options);
}

void add_learning(CLI::App &records, RecordsOptions &options)
{
    CLI::App *curve =
        add(records, options, "curve", "A trainee's curve of learning in one case",
            "  cournand records curve otter --case lad_pci\n"
            "  cournand records curve otter --case lad_pci --metric fluoroscopy_min --html otter.html");
    curve->add_option("trainee", options.what, "Pseudonym")->required();
    curve
        ->add_option(
            "--pass-score", options.pass_score,
            "Sessions of a case that does not say passed or failed pass from this score on, per cent")
        ->capture_default_str()
        ->check(CLI::Range(0.0, 100.0));
    curve->add_option("--rate-good", options.rate_good, "CUSUM: acceptable rate of failures")
        ->capture_default_str()
        ->check(CLI::Range(0.01, 0.98));
    curve->add_option("--rate-bad", options.rate_bad, "CUSUM: unacceptable rate of failures")
        ->capture_default_str()
        ->check(CLI::Range(0.02, 0.99));
    CLI::App *cohort =
        add(records, options, "cohort", "The trainees of one case together; at least five people",
            "  cournand records cohort --case lad_pci\n"
            "  cournand records cohort --case lad_pci --group \"2026 fellows\" --html fellows.html");
    cohort->add_option("--group", options.cohort, "Only trainees of this group; default: all");
    for (CLI::App *command : {curve, cohort}) {
        command->add_option("--case", options.case_id, "The case")->required();
        command
            ->add_option("--metric", options.metrics,
                         "Metric; once per metric; default: score, errors, duration_s")
            ->allow_extra_args(false);
        command->add_option("--html", options.html, "Write a page that needs no network");
        add_json(*command, options);
    }
}

void add_trainees(CLI::App &records, RecordsOptions &options)
{
    CLI::App *trainee = add(records, options, "trainee", "Add a trainee, or change what is known of one",
                            "  cournand records trainee otter --name \"Ann Smith\" --group \"2026 fellows\"\n"
                            "  cournand records trainee otter --keep-until 2027-12-31\n  cournand records "
                            "trainee otter --no-name");
    trainee->add_option("pseudonym", options.what, "Pseudonym")->required();
    const auto pair = [&](const std::string &name, std::string &value, bool &is_removed,
                          const std::string &what, const std::string &removal) {
        CLI::Option *option = trainee->add_option("--" + name, value, what);
        trainee->add_flag("--no-" + name, is_removed, removal)->excludes(option);
    };
    pair("name", options.name, options.no_name, "Name; it never leaves this file", "Delete the name");
    pair("group", options.cohort, options.no_cohort, "Group for `cohort`", "No group");
    pair("keep-until", options.keep_until, options.no_keep_until,
         "Last day, such as 2027-12-31, after which `erase --expired` erases", "No such day");
    CLI::Option *expert =
        trainee->add_flag("--expert", options.is_expert, "An expert, whose runs are the example for others");
    trainee->add_flag("--no-expert", options.is_no_expert, "Not an expert")->excludes(expert);
    CLI::App *rename = add(records, options, "rename", "Give a trainee another pseudonym",
                           "  cournand records rename otter heron");
    rename->add_option("old", options.what, "Pseudonym of today")->required();
    rename->add_option("new", options.new_name, "New pseudonym")->required();
    CLI::App *erase =
        add(records, options, "erase", "Erase a trainee with all sessions, for good",
            "  cournand records erase otter\n  cournand records erase otter --recordings --yes\n"
            "  cournand records erase --expired --recordings --yes");
    CLI::Option *who = erase->add_option("trainee", options.what, "Pseudonym");
    erase->add_flag("--expired", options.expired, "Instead: all trainees whose keep-until date has passed")
        ->excludes(who);
    CLI::Option *recordings =
        erase->add_flag("--recordings", options.with_recordings, "Delete the recordings of the sessions too");
    erase->add_flag("--keep-recordings", options.keeps_recordings, "Leave the recordings")
        ->excludes(recordings);
    erase->add_flag("--yes", options.yes, "Do not ask for confirmation");
}

void add_upkeep(CLI::App &records, RecordsOptions &options)
{
    CLI::App *check =
        add(records, options, "check", "Test the file of the records, and the recordings it names",
            "  cournand records check\n  cournand records check --json");
    add_json(*check, options);
    CLI::App *import = add(records, options, "import", "Take sessions from files of `export --format json`",
                           "  cournand records import sessions.json");
    import->add_option("file", options.files, "Files")->required();
    CLI::App *ship = add(records, options, "ship", "Send this station's sessions to the centre's server",
                         "  cournand records ship --to postgresql://station@server/cournand");
    ship->add_option("--to", options.to, "URL of the server; default: COURNAND_RECORDS");
    add_json(*ship, options);
}

} // namespace

void add_records(CLI::App &app, RecordsOptions &options)
{
    CLI::App *records =
        app.add_subcommand("records", "Records of trainees: sessions, scores, curves of learning");
    records->require_subcommand(1);
    add_reading(*records, options);
    add_learning(*records, options);
    add_trainees(*records, options);
    add_upkeep(*records, options);
}

} // namespace crn
