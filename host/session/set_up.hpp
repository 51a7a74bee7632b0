// Sets a device up for a session in LOCKSTEP, up to the message START. Sessions, replays, the class Witness
// and the simulated sessions ("worlds") of the C library use this code.
#pragma once
#include "host/link/link.hpp"
#include "host/model/tool_line.hpp"
#include "host/session/scene_file.hpp"
#include <vector>

namespace crn
{

// Holds everything that determines a session, except its inputs.
struct SessionSetUp {
    const SceneFile &scene;
    const std::vector<Instrument> &tools; // the table
    const LineNumbers &line;              // the tool at each position from the innermost (tool_line.hpp)
    const crn_wire_entry &entry;
    const crn_wire_rig &rig;
};

// Sends the set-up to a device that has answered HELLO, and starts the session. Throws LinkError.
void set_up_session(Link &link, const SessionSetUp &set_up);

// Returns the error, with the names of the tools that caused the refusal added as they are in the tools'
// files. If no tool caused the refusal, the error is returned unchanged.
LinkError with_tool_names(const LinkError &error, const std::vector<Instrument> &tools,
                          const LineNumbers &line);

} // namespace crn
