// The end of a session, however it was led: figures on the terminal, as JSON and as a score. `run`, `view`
// and `replay` say the same.
#pragma once
#include "host/room/room_screen.hpp"
#include "host/session/run.hpp"
#include <string>
#include <vector>

namespace crn
{

// Name, lengths, force and torque of every tool, one below the other; `tips`: where they are.
void print_tools(const std::vector<Instrument> &tools, const SessionFigures &figures,
                 const std::vector<TipPlace> &tips = {});
// "written  NAME", a line each.
void print_files(const std::vector<std::string> &files);
// Everything that is known of the session.
void print_session(const RunResult &result, const std::vector<Instrument> &tools, Patient &patient);

struct SessionFiles {
    std::string json, score, timing; // empty: none
};
// `session`: the script's name, or who led. `screen`: of whoever made pictures, which go onto the score's
// page; null: nobody. Throws OutputError.
void write_session_files(const SessionFiles &files, const RunResult &result, const std::string &scene,
                         const std::vector<Instrument> &tools, const std::string &session, Patient &patient,
                         const RoomScreen *screen);

} // namespace crn
