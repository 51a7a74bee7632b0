// The window of `cournand view`: hand, pedal and C-arm by keyboard, the same pictures as everywhere else.
// Live input is recorded like a session; the recording replays bit for bit.
#pragma once
#include "host/picture/session_pictures.hpp"
#include <string>
#include <vector>

namespace crn
{

struct WindowOptions {
    std::string scene;               // empty: free space
    std::string instrument;          // file of the innermost tool, or empty
    std::vector<std::string> tools;  // files of the others, towards the outermost
    std::vector<std::string> stents; // files, in the order of loading
    std::string device = "sim";      // as parse_device
    std::string json,
        score; // figures and page at the end of each session; empty: none. A reset as for `record`
    bool keeps_recording =
        true; // without `record`: in a folder of the user, under date and time (docs/session.md)
    // Empty: none. A reset starts "name.2.rec", "name.3.rec" ..., and for pictures.dicom the folder "name.2"
    // ...
    std::string record;
    PictureSettings pictures;
    std::vector<double>
        inserted_mm;       // outside the inserter at the start: none, one for all tools, or one each
    bool free_run = false; // the rig's own encoders are the hands
    bool motors = false, yes = false; // FREE_RUN: with power; without being asked
    bool starts_with_fluoro = false;
    bool shows_help = true;
    // For tests: end after so many screens, each 1/60 s of session time however long it takes; 0: until Esc,
    // real time.
    int frames = 0;
    std::string screenshot; // PNG of the window's last screen; empty: none
};

// 0; 1 when a signal ended it or it was left in a fault; or throws std::runtime_error (no display, no
// OpenGL 3.3, a bad file) for exit code 1.
int run_window(const WindowOptions &options);

} // namespace crn
