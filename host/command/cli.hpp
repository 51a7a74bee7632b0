// The command line `cournand`. The program's exit code is 0 for success, 1 for a failure, 2 for wrong usage,
// or 3 if the physics left its valid range (range_watch.hpp).
#pragma once
#include "host/base/output_files.hpp"
#include "host/cases/goals.hpp"
#include "host/command/cli_assess.hpp"
#include "host/command/view_options.hpp"
#include "host/picture/session_pictures.hpp"
#include "host/picture/surface_file.hpp"
#include "host/script/tip_places.hpp"
#include "host/session/replay.hpp"
#include "host/session/run.hpp"
#include <optional>
#include <string>
#include <vector>

namespace crn
{

struct RunOptions {
    std::string scene, instrument, session, record, json, score, timing, hands;
    std::string device = "sim"; // as parse_device
    std::vector<std::string> tools, stents;
    std::string complications;     // file of limits, or "off"; empty: as they ship
    std::vector<std::string> line; // as WindowOptions::line; replaces the script's `begin with`
    PictureSettings pictures;
    PlanOptions plan; // without a plan the session is not assessed
    bool quiet = false;
    std::optional<double>
        free_run_s; // FREE_RUN for so many seconds, 0: until Ctrl-C; empty: the script controls the session
    bool motors = false, yes = false; // FREE_RUN: with power; without confirmation
    std::vector<double> inserted_mm;  // FREE_RUN: none, one for all tools, or one each
    const Case *lesson = nullptr;     // the session plays this case, and gets its marks
    std::string igtl;                 // address of the OpenIGTLink server; empty: none
    std::string card;                 // file for the picture that stands for the session (card_picture)
};

struct ReplayOptions {
    std::string recording, scene, speed = "fast", json, score;
    bool verify = false;
    bool upgrades = false; // nothing is played: an older recording is written in this version as `upgraded`
    std::string upgraded;
    double from_s = 0.0;
    std::string igtl; // address of the OpenIGTLink server; empty: none
    PictureSettings pictures;
    const Case *lesson = nullptr; // the recorded session plays this case, and gets its marks
};

struct SurfaceOptions {
    std::string recording, scene;
    std::vector<double> at_s;
    bool stages = false; // stages of the balloon, in addition to at_s
    SurfaceSettings surface;
};

struct InstrumentsOptions {
    std::vector<std::string> files; // or folders; empty: the shipped ones
    std::string preset, json, png, table;
};

int command_run(const RunOptions &options);
int command_replay(const ReplayOptions &options);
int command_surface(const SurfaceOptions &options);
// Prints which OpenGL library --xray opengl would use; returns 1 if there is none.
int command_info_opengl();
int command_info(const std::string &path);
int command_instruments(const InstrumentsOptions &options);

// Returns the commands that the option --complications asks for at the start. Throws FileError.
std::vector<RoomCommand> complication_commands(const std::string &complications);

// Returns the tools from the innermost to the outermost: the tool of the option --instrument first, then the
// tool of every option --tool. Throws UsageError if there is no tool, or more tools than `most`; throws
// FileError for a bad file.
std::vector<Instrument> read_tools(const std::string &instrument, const std::vector<std::string> &tools,
                                   std::size_t most = CRN_WIRE_TOOL_MAX);
// Returns the names by which a script and the option --line refer to the tools; these are the file names
// without folder and ending.
std::vector<std::string> tool_words(const std::string &instrument, const std::vector<std::string> &tools);
// Returns the tools that the option --line names. If no words are given, the result is empty, which stands
// for all tools. Throws UsageError if a word names no tool, or if the option --line is missing although the
// session has too many tools to nest all of them.
LineNumbers line_numbers(const std::vector<std::string> &words, const std::string &instrument,
                         const std::vector<std::string> &tools);
// Returns the point where the tools enter the patient, with their inserted lengths. The user may give no
// length (then the default applies), one length for all tools, or one length per tool. Throws UsageError if
// there are more lengths than tools.
crn_wire_entry entry_with(const SceneFile &scene, std::size_t tool_count,
                          const std::vector<double> &inserted_mm);
// Returns commands for the X-ray room that move the table so that the entry point is in view, and then make
// the table follow the tip.
std::vector<RoomCommand> entry_commands(const SceneFile &scene);
// Returns the device for a session in FREE_RUN mode. If `motors` is set, the function first prints which
// motors will get power. Before the motors get power, the function asks the user for confirmation, unless
// `yes` is set. Throws RigStopped when the user does not confirm.
DeviceChoice free_run_device(const std::string &device, bool motors, bool yes);
// Reads the stent files `paths`, and stores the stents in `settings`. Throws FileError if there are too many
// stent files, if a file is not a valid stent file, or if no tool has a balloon on which the stent fits.
void take_stents(PictureSettings &settings, const std::vector<std::string> &paths,
                 const std::vector<Instrument> &tools);
// Returns the file paths of the tools, as input files for check_outputs.
std::vector<NamedPath> tool_inputs(const std::string &instrument, const std::vector<std::string> &tools);

// The function recorded_scene() looks for a scene file with exactly the recorded contents, at the path in the
// recording and at the user's path. The function check_core() checks that the device's core can replay the
// recording. Both throw std::runtime_error.
SceneFile recorded_scene(const RecordingHeader &header, const std::string &given_path);
void check_core(const RecordingHeader &header, const crn_wire_hello_reply &identity);
// Returns the result of a replay in the form of the result of a session, for reports.
RunResult run_result(const ReplayResult &replayed);

// Adds the name of the vessel branch to the place at which the physics left its valid range; the names come
// from the scene's bodies. If the physics stayed in its valid range, or if the bodies cannot be read, `range`
// stays unchanged.
void name_range_branch(RangeWatch &range, const std::string &bodies_path);
// If the physics left its valid range, prints a message about this on stderr and returns the exit code 3;
// otherwise returns 0.
int exit_of_range(const RangeWatch &range);

// Fills in what `cournand view` needs if the user has named nothing: the scene that comes with the program,
// and a J wire. If the user has named only a scene, the function adds only the J wire; if the user has named
// a tool, it adds nothing.
void choose_defaults(WindowOptions &options);

// If `run_window` is empty, the command `view` is refused. If the command line has no further word, and there
// is a display, `open_start` is called. Without a display, or if `open_start` is empty, the program prints
// what the user can do without a window (start.hpp).
int command_line(int argc, char **argv, const RunWindow &run_window, const OpenStart &open_start = {});

} // namespace crn
