// Gives the summary of a session, whether a script, a rig or keys controlled it: figures on the terminal, as
// JSON and as a score. `run`, `view` and `replay` print the same.
#pragma once
#include "host/room/room_screen.hpp"
#include "host/session/run.hpp"
#include <string>
#include <vector>

namespace crn
{

// Prints name, lengths, force and torque of every tool, one below the other; `tips` are the places of their
// tips.
void print_tools(const std::vector<Instrument> &tools, const SessionFigures &figures,
                 const std::vector<TipPlace> &tips = {});
// Prints "written  NAME", a line each.
void print_files(const std::vector<std::string> &files);
// Prints all figures of the session.
void print_session(const RunResult &result, const std::vector<Instrument> &tools, Patient &patient);

struct SessionFiles {
    std::string json, score, timing; // empty: none
};
// `session` is the script's name, or what controlled the session. `screen` belongs to the maker of pictures,
// which go onto the score's page; null: there are none. Throws OutputError.
void write_session_files(const SessionFiles &files, const RunResult &result, const std::string &scene,
                         const std::vector<Instrument> &tools, const std::string &session, Patient &patient,
                         const RoomScreen *screen);

} // namespace crn
