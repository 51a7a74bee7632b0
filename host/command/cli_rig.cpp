#include "host/command/cli_rig.hpp"
#include "host/base/command_values.hpp"
#include <CLI/CLI.hpp>

namespace crn
{

namespace
{

CLI::App *add(CLI::App &rig, RigOptions &options, const std::string &name, const std::string &text,
              const std::string &examples)
{
    CLI::App *command = rig.add_subcommand(name, text);
    command->callback([&options, name] { options.command = name; });
    command->footer("Examples:\n" + examples);
    if (name == "list") return command;
    command->add_option("--device", options.device, "usb, usb:SERIAL, or sim (a rig in this program)")
        ->capture_default_str();
    return command;
}

void add_track(CLI::App &command, RigOptions &options)
{
    command.add_option("--track", options.track, "Track, 1: the innermost tool")
        ->capture_default_str()
        ->check(CLI::Range(1, 3));
    command.add_flag("--reset", options.reset, "RESET the rig first when it is not in READY");
}

void add_calibrate(CLI::App &rig, RigOptions &options)
{
    CLI::App *command = add(
        rig, options, "calibrate", "Measure what one count of an encoder or force sensor is, and write it",
        "  cournand rig calibrate --track 1\n  cournand rig calibrate --what translation --distance 200\n"
        "  cournand rig calibrate --save rig.json      (measured or not: what the rig has at the end)\n"
        "  cournand rig calibrate --load rig.json");
    add_track(*command, options);
    command->add_option("--what", options.what, "translation, rotation, force or all")
        ->capture_default_str()
        ->check(one_of({"translation", "rotation", "force", "all"}));
    command->add_option("--distance", options.distance_mm, "Distance between the two marks, mm")
        ->capture_default_str()
        ->check(CLI::Range(1.0, 2000.0));
    command->add_option("--turns", options.turns, "Turns between the two marks")
        ->capture_default_str()
        ->check(CLI::Range(0.25, 100.0));
    command->add_option("--weight", options.weight_g, "Weight that pulls the hand back out, g")
        ->capture_default_str()
        ->check(CLI::Range(1.0, 800.0));
    command
        ->add_option("--save", options.save,
                     "Write the rig's calibration to a file; a rig forgets at power-off")
        ->type_name("FILE")
        ->group("Outputs");
    command->add_option("--load", options.load, "Write a file's calibration to the rig instead of measuring")
        ->type_name("FILE");
    command->add_flag("--yes", options.yes, "Write without asking");
}

} // namespace

void add_rig(CLI::App &app, RigOptions &options)
{
    CLI::App *rig = app.add_subcommand("rig", "Find, look at, test, calibrate and feel a rig");
    rig->require_subcommand(1);
    CLI::App *list = add(*rig, options, "list", "Rigs on USB: serial number, product, firmware, state, place",
                         "  cournand rig list\n  cournand rig list --json");
    list->add_flag("--json", options.json, "As JSON");
    CLI::App *info = add(*rig, options, "info", "Version, abilities, state, calibration and limits",
                         "  cournand rig info\n  cournand rig info --device usb:RIG-0001 --json");
    info->add_flag("--json", options.json, "As JSON");
    CLI::App *watch = add(*rig, options, "monitor", "State, encoders and forces, live",
                          "  cournand rig monitor\n  cournand rig monitor --seconds 10 --csv out/rig.csv");
    watch->add_option("--seconds", options.seconds, "End after so long; default: Ctrl-C")
        ->check(CLI::Range(0.001, 1e6));
    watch->add_option("--csv", options.csv, "Write every report, one line each")
        ->type_name("FILE")
        ->group("Outputs");
    watch->add_option("--hid", options.hid, "Back end of hidapi: hidraw or libusb")
        ->capture_default_str()
        ->check(one_of({"hidraw", "libusb"}));
    CLI::App *test =
        add(*rig, options, "selftest", "Test every sensor and limit; one line each, pass or FAIL",
            "  cournand rig selftest\n  cournand rig selftest --motors --track 2");
    test->add_flag("--motors", options.motors,
                   "Also power the track's motor for a second, after confirmation");
    test->add_flag("--yes", options.yes, "Do not ask for confirmation");
    test->add_option("--damping", options.damping_N_s_per_m,
                     "The rig's own damping, N s/m; default: its configuration");
    add_track(*test, options);
    add_calibrate(*rig, options);
    CLI::App *force = add(*rig, options, "force", "Feel a small force: push the carriage, it resists",
                          "  cournand rig force --track 1 --mN 300 --seconds 10");
    add_track(*force, options);
    force->add_option("--mN", options.force_mN, "Largest resistance to a slow push, mN")
        ->capture_default_str()
        ->check(CLI::Range(50, 1000));
    force->add_option("--seconds", options.seconds, "How long, at most 60; default 10")
        ->check(CLI::Range(0.1, 60.0));
    force->add_option("--damping", options.damping_N_s_per_m,
                      "The rig's own damping, N s/m; default: its configuration");
    force->add_flag("--yes", options.yes, "Do not ask for confirmation");
    add(*rig, options, "log", "Faults since power-up: cause, ticks, remedy", "  cournand rig log");
}

} // namespace crn
