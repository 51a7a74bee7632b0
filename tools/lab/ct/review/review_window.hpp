// The window in which a person looks at a patient's CT, mends the arteries by clicks, and lets `ct patient`
// run again (docs/own_ct.md, "The window"). The window runs the same command as a person would type, so it
// can do nothing that the command line cannot.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace crn::ct
{

struct ReviewOptions {
    std::filesystem::path folder;           // of the patient
    std::vector<std::string> command;       // `ct patient ...`, the words of the command that makes the scene
    std::vector<std::string> first_command; // the same for the first run; empty: no other
    bool runs_at_once = true;               // false: only look at what the folder holds
    std::string screenshot;                 // PNG of the window's last screen; empty: none
    std::string layout;                     // names and places of the controls, for tests; empty: none
    int width = 1600, height = 900;         // at the start
};

enum class ReviewEnd {
    closed,      // the user has closed the window
    wants_play,  // the user wants to play the scene
    interrupted, // by a signal
};

// Opens the window and returns when it ends. Throws std::runtime_error if there is no display.
ReviewEnd review_patient(const ReviewOptions &options);

} // namespace crn::ct
