// The command line `cournand`: exit codes 0 done, 1 failed, 2 wrong usage, 3 physics left its range
// (range_watch.hpp).
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
    std::optional<double> free_run_s; // the rig leads for so long, 0: until Ctrl-C; empty: the script does
    bool motors = false, yes = false; // FREE_RUN: with power; without being asked
    std::vector<double> inserted_mm;  // FREE_RUN: none, one for all tools, or one each
};

struct ReplayOptions {
    std::string recording, scene, speed = "fast", json, score;
    bool verify = false;
    double from_s = 0.0;
    PictureSettings pictures;
};

struct SurfaceOptions {
    std::string recording, scene;
    std::vector<double> at_s;
    bool stages = false; // of the balloon, besides at_s
    SurfaceSettings surface;
};

struct InstrumentsOptions {
    std::vector<std::string> files; // or folders; empty: those that ship
    std::string preset, json, png, table;
};

int command_run(const RunOptions &options);
int command_replay(const ReplayOptions &options);
int command_surface(const SurfaceOptions &options);
// The OpenGL that --xray opengl would find; 1 when there is none.
int command_info_opengl();
int command_info(const std::string &path);
int command_instruments(const InstrumentsOptions &options);

// Tools from the innermost to the outermost: --instrument first, then every --tool. Throws UsageError for
// none or more than a line holds, FileError for a bad file.
std::vector<Instrument> read_tools(const std::string &instrument, const std::vector<std::string> &tools);
// Where they enter: no length (the default), one for all, or one each. Throws UsageError for more lengths
// than tools.
crn_wire_entry entry_with(const SceneFile &scene, std::size_t tool_count,
                          const std::vector<double> &inserted_mm);
// The table over the entry, following the tip.
std::vector<RoomCommand> entry_commands(const SceneFile &scene);
// The device of a session that the rig leads. With `motors` it shows what will be powered and asks, unless
// `yes`; throws RigStopped when that is not confirmed.
DeviceChoice free_run_device(const std::string &device, bool motors, bool yes);
// Stents for these tools into the settings of a session's pictures. Throws FileError.
void take_stents(PictureSettings &settings, const std::vector<std::string> &paths,
                 const std::vector<Instrument> &tools);
// The first one is on its balloon when the session begins.
inline constexpr RoomCommand first_stent{RoomAction::load_stent, {}};
// The paths of a set of tools as inputs for check_outputs.
std::vector<NamedPath> tool_inputs(const std::string &instrument, const std::vector<std::string> &tools);

// The very scene of a recording, from where it or the user says, and a core that can play it. Throw
// std::runtime_error.
SceneFile recorded_scene(const RecordingHeader &header, const std::string &given_path);
void check_core(const RecordingHeader &header, const crn_wire_hello_reply &identity);

// Where physics left its range: the branch it was in, from the scene's bodies; nothing when it did not, or
// when they cannot be read.
void name_range_branch(RangeWatch &range, const std::string &bodies_path);
// Says on stderr that physics left its range and gives the exit code for it; 0: it did not.
int exit_of_range(const RangeWatch &range);

// Bodies beside a scene: "x.scene" -> "x.bodies" when that file exists, else empty.
std::string bodies_beside(const std::string &scene);

// Without `run_window` the command `view` is refused.
int command_line(int argc, char **argv, const RunWindow &run_window);

} // namespace crn
