// This header has the commands that talk to a device. Each command runs in this process from its command line
// to its exit code, with a lying device on the bus. The header also has a check whether the recordings of
// these commands are true.
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
// Runs the command and returns its exit code. The process must end afterwards, because threads of the
// simulated bus continue to run.
int run_command(const LiedTo &command, const Lie &lie, const std::string &folder,
                const std::function<void()> &struck);

// Returns an empty text when the recording is true. Then every tick, full hash and snapshot in it equals what
// this machine's core computes, and the recording is complete where the command reported success. Otherwise
// the function returns a text that says what is false.
std::string falsehood(const std::string &recording, bool has_to_be_complete);

} // namespace hil
