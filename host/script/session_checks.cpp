#include "host/script/session_checks.hpp"
#include "host/patient/balloon.hpp"
#include "host/patient/contrast.hpp"

namespace crn
{

void check_injections(const Session &session, const PatientContrast &contrast)
{
    double iodine_mg_per_ml = iodine_default_mg_per_ml;
    for (const Statement &statement : session.statements)
        for (const RoomCommand &command : statement.room) {
            if (command.action == RoomAction::contrast_strength) iodine_mg_per_ml = command.values[0];
            const std::string why = contrast.refusal(command, iodine_mg_per_ml);
            if (!why.empty()) throw FileError(session.file, statement.line, 0, why);
        }
}

void check_inflations(const Session &session, const std::vector<Instrument> &tools)
{
    if (balloon_tool(tools)) return;
    for (const Statement &statement : session.statements)
        if (statement.inflation)
            throw FileError(session.file, statement.line, 0,
                            std::string(no_balloon_text) + ": name a balloon catheter with --tool");
}

static std::size_t count_loads(const Session &session)
{
    std::size_t count = 0;
    for (const Statement &statement : session.statements)
        for (const RoomCommand &command : statement.room) count += command.action == RoomAction::load_stent;
    return count;
}

void check_loads(const Session &session, std::size_t stents)
{
    std::size_t count = 0;
    for (const Statement &statement : session.statements)
        for (const RoomCommand &command : statement.room) {
            count += command.action == RoomAction::load_stent;
            if (count > stents)
                throw FileError(session.file, statement.line, 0,
                                "loads stent " + std::to_string(count) + ", but " + std::to_string(stents) +
                                    " are given: name each with --stent");
        }
}

std::vector<RoomCommand> begin_commands(const Session &session, const Patient &patient)
{
    if (!patient.stents() || count_loads(session) > 0) return {};
    return {first_stent};
}

} // namespace crn
