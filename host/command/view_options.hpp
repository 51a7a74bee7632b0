// Holds the options of `cournand view`. Only the main program for machines with a display contains the
// window; it passes the function that opens the window to command_line().
#pragma once
#include "host/cases/case.hpp"
#include "host/igtl/server.hpp"
#include "host/picture/session_pictures.hpp"
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace crn
{

struct WindowOptions {
    std::string scene;              // empty: free space
    std::string instrument;         // file of the innermost tool, or empty
    std::vector<std::string> tools; // files of the others, towards the outermost
    // Names the tools in the vessels at the start, from the innermost. A tool has the name of its file or its
    // number in the table; `nothing` stands for a position without a tool. Empty: all tools. Tools that are
    // not in the vessels at the start can be loaded during the session.
    std::vector<std::string> line;
    std::vector<std::string> stents; // files, in the order of loading
    std::string complications;       // file of limits, or "off"; empty: as they ship
    std::string device = "sim";      // as parse_device
    // Holds the paths of two files that are written at the end of each session: the report with its figures,
    // and the page of the score. A file whose path is empty is not written. After a reset of the session, the
    // files get numbers in their names, as for `record`.
    std::string json, score;
    bool keeps_recording =
        true; // without `record`: keep it in a folder of the user, named by date and time (docs/session.md)
    // Empty: none. A reset starts "name.2.rec", "name.3.rec" ..., and for pictures.dicom the folder "name.2"
    // ...
    std::string record;
    PictureSettings pictures;
    std::vector<double> inserted_mm;  // inserted lengths at the start: none, one for all tools, or one each
    bool free_run = false;            // the rig's own encoders are the hands
    bool motors = false, yes = false; // FREE_RUN: with power; without confirmation
    bool starts_with_fluoro = false;
    bool shows_help = true;
    // In tests the GUI window closes after it has drawn the number of frames that this option states. Every
    // frame counts as 1/60 s of session time, however long the drawing takes. If the number of frames is 0,
    // the window runs in real time until the user presses Esc.
    int frames = 0;
    std::string screenshot;                       // PNG of the window's last screen; empty: none
    int window_width = 1600, window_height = 900; // at the start, in pixels of the desktop
    std::string font;                             // TrueType file; empty: the installed DejaVu Sans
    bool opens_start = false;                     // begin with the cards instead of a session
    // Holds the case that the session plays. The window shows the goals of the case during the session, and
    // the marks at the end. At first the GUI window shows the preparation of the case. Null: no case.
    std::shared_ptr<const Case> lesson{};
    std::string replays; // begin with the replay of this recording; empty: no
    std::string timing;  // file of the figures of this machine: punctuality, pictures, delays; empty: none
    std::string igtl;    // address of the OpenIGTLink server; empty: none
    std::shared_ptr<IgtlServer> watched{}; // this server, for all sessions of the window
    std::string layout; // file with the names and places of the controls, for tests; empty: none
};

// Opens the window and returns the exit code.
using RunWindow = std::function<int(WindowOptions)>;
// Opens the window that the program shows if it is called without arguments, and returns the exit code.
using OpenStart = std::function<int()>;

} // namespace crn
