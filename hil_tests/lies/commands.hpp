// The commands that talk to a device, each in this process from its command line to its exit code, with a
// liar on the bus; and whether what they recorded is true.
#pragma once
#include "hil_tests/lies/lie.hpp"
#include <functional>
#include <string>
#include <vector>

namespace hil
{

struct LiedTo {
    const char *name;      // in tables
    unsigned frames;       // about so many come from an honest device
    bool is_by_hid;        // lies about the HID interface; else about the wire
    const char *recording; // its name in the folder; empty: none
};
const std::vector<LiedTo> &lied_to();

// Scene, tool and session into the folder. `ticks` long.
void write_inputs(const std::string &folder, unsigned ticks);
// Does the command and returns its exit code. Ends with the process: threads of the bus go on.
int run_command(const LiedTo &command, const Lie &lie, const std::string &folder,
                const std::function<void()> &struck);

// Empty: every tick, full hash and snapshot of the recording, as far as it goes, is what this machine's core
// has; and where the command said that all is well, it is complete. Else what is false.
std::string falsehood(const std::string &recording, bool has_to_be_complete);

} // namespace hil
