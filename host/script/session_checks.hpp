// Checks before a session begins that its script can be carried out with the given tools, stents and scene.
#pragma once
#include "host/patient/patient.hpp"
#include "host/script/session.hpp"
#include <vector>

namespace crn
{

// The next three functions throw FileError with the line of the script: for an injection that is impossible
// with these tools or this scene, for an inflation without a balloon, and for loading more than `stents`
// stents.
void check_injections(const Session &session, const PatientContrast &contrast);
void check_inflations(const Session &session, const std::vector<Instrument> &tools);
void check_loads(const Session &session, std::size_t stents);

// This command puts the first stent on its balloon.
inline constexpr RoomCommand first_stent{RoomAction::load_stent, {}};
// Returns the commands for the X-ray room before the first statement: a session with stents whose script
// loads none begins with the first stent on its balloon.
std::vector<RoomCommand> begin_commands(const Session &session, const Patient &patient);

} // namespace crn
