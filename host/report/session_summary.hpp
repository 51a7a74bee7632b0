// Summarises a session that a script, a rig or the keyboard controlled: figures on the terminal, a JSON file
// and a score. The commands `run`, `view` and `replay` print the same summary.
#pragma once
#include "host/picture/picture.hpp"
#include "host/room/room_screen.hpp"
#include "host/session/run.hpp"
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace crn
{

// Prints one line per tool with its name, lengths, force and torque; `tips` holds the positions of the tools'
// tips.
void print_tools(const std::vector<Instrument> &tools, const SessionFigures &figures,
                 const std::vector<TipPlace> &tips = {});
// Prints "written NAME" for each file, one per line.
void print_files(const std::vector<std::string> &files);
// Prints all figures of the session.
void print_session(const RunResult &result, const std::vector<Instrument> &tools, Patient &patient);

struct SessionFiles {
    std::string json, score, timing; // empty: none
    nlohmann::ordered_json case_entry =
        nullptr; // entry "case" of the report; null: the session plays no case
};
// `session` names what controlled the session, for example the script. `screen` has the pictures for the page
// of the score; if `screen` is null, the page has no pictures. Throws OutputError.
void write_session_files(const SessionFiles &files, const RunResult &result, const std::string &scene,
                         const std::vector<Instrument> &tools, const std::string &session, Patient &patient,
                         const RoomScreen *screen);

// Returns a picture that represents a session: the cine frame with the most visible contrast medium, or
// `last` (the last picture) if the session has no cine run.
Image card_picture(const RoomScreen &screen, const Image &last);

} // namespace crn
