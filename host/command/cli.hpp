// The command line `cournand`. The program's exit codes are: 0 done, 1 failed, 2 wrong usage, 3 physics left
// its range (range_watch.hpp).
#pragma once
#include "host/base/output_files.hpp"
#include "host/command/view_options.hpp"
#include "host/picture/session_pictures.hpp"
#include "host/picture/surface_file.hpp"
#include "host/script/tip_places.hpp"
#include "host/session/device.hpp"
#include <optional>
#include <string>
#include <vector>

namespace crn
{

struct RunOptions {
    std::string scene, instrument, session, record, json, score, timing;
    std::string device = "sim"; // as parse_device
    std::vector<std::string> tools, stents;
    PictureSettings pictures;
    bool quiet = false;
    std::optional<double>
        free_run_s; // FREE_RUN for so many seconds, 0: until Ctrl-C; empty: the script controls the session
    bool motors = false, yes = false; // FREE_RUN: with power; without confirmation
    std::vector<double> inserted_mm;  // FREE_RUN: none, one for all tools, or one each
};

struct ReplayOptions {
    std::string recording, scene, speed = "fast", json, score;
    bool verify = false;
    bool upgrades = false; // nothing is played: an older recording is written in this version as `upgraded`
    std::string upgraded;
    double from_s = 0.0;
    PictureSettings pictures;
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
// Prints which OpenGL --xray opengl would use; returns 1 when there is none.
int command_info_opengl();
int command_info(const std::string &path);
int command_instruments(const InstrumentsOptions &options);

// Returns the tools from the innermost to the outermost: --instrument first, then every --tool. Throws
// UsageError for no tool or for more tools than a line can hold, and FileError for a bad file.
std::vector<Instrument> read_tools(const std::string &instrument, const std::vector<std::string> &tools);
// Returns where the tools enter, with their inserted lengths. The user gives no length (the default), one
// length for all tools, or one for each. Throws UsageError for more lengths than tools.
crn_wire_entry entry_with(const SceneFile &scene, std::size_t tool_count,
                          const std::vector<double> &inserted_mm);
// Returns the commands that place the table so that the entry is in view, and make the table follow the tip.
std::vector<RoomCommand> entry_commands(const SceneFile &scene);
// Returns the device for a session in FREE_RUN. With `motors` it prints which motors will be powered and
// requests a confirmation, unless `yes` is set. Throws RigStopped when the user does not confirm.
DeviceChoice free_run_device(const std::string &device, bool motors, bool yes);
// Reads stents for these tools into the settings of a session's pictures. Throws FileError.
void take_stents(PictureSettings &settings, const std::vector<std::string> &paths,
                 const std::vector<Instrument> &tools);
// With this command the first stent is on its balloon when the session begins.
inline constexpr RoomCommand first_stent{RoomAction::load_stent, {}};
// Returns the paths of a set of tools, as inputs for check_outputs.
std::vector<NamedPath> tool_inputs(const std::string &instrument, const std::vector<std::string> &tools);

// recorded_scene() finds the exact scene of a recording, at the path in the recording or at the user's path.
// check_core() checks that the device's core can replay the recording. Both throw std::runtime_error.
SceneFile recorded_scene(const RecordingHeader &header, const std::string &given_path);
void check_core(const RecordingHeader &header, const crn_wire_hello_reply &identity);

// Adds, from the scene's bodies, the name of the branch to the place where physics left its range. Does
// nothing when physics did not leave its range, or when the bodies cannot be read.
void name_range_branch(RangeWatch &range, const std::string &bodies_path);
// Prints on stderr that physics left its range and returns the exit code for that; returns 0 when it did not.
int exit_of_range(const RangeWatch &range);

// Returns the bodies beside a scene: for "x.scene" it returns "x.bodies" when that file exists, otherwise an
// empty path.
std::string bodies_beside(const std::string &scene);

// Without `run_window` the command `view` is refused.
int command_line(int argc, char **argv, const RunWindow &run_window);

} // namespace crn
