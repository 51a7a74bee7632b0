// Runs the commands of the program cournand that communicate with a device. Each command runs in this process
// from its command line to its exit code, with a device on the simulated bus that sends false messages
// (lies). The header also declares a function that compares the recordings of these commands with the results
// of this machine's core.
#pragma once
#include "hil_tests/lies/lie.hpp"
#include <functional>
#include <string>
#include <vector>

namespace hil
{

struct LiedTo {
    const char *name;      // in tables
    unsigned frames;       // an honest device sends about this many
    bool is_by_hid;        // the lie is about the HID interface; otherwise about the wire
    const char *recording; // its name in the folder; empty: there is none
};
const std::vector<LiedTo> &lied_to();

// Writes scene, tool and session into the folder. The session is `ticks` long.
void write_inputs(const std::string &folder, unsigned ticks);
// Runs the command and returns its exit code. The caller must end the process after this call, because
// threads of the simulated bus continue to run.
int run_command(const LiedTo &command, const Lie &lie, const std::string &folder,
                const std::function<void()> &struck);

// Checks whether a recording is true, and returns an empty text if it is. A recording is true if every tick,
// full hash and snapshot in it equals the result of this machine's core. If the command reported success, the
// recording must also be complete. If the recording is false, the returned text states the difference.
std::string falsehood(const std::string &recording, bool has_to_be_complete);

} // namespace hil
