#include "hil_tests/soak/drawn.hpp"
#include <filesystem>

namespace soak
{

std::string name_of(const DrawnSession &session)
{
    return "seed " + std::to_string(session.seed) + " session " + std::to_string(session.index);
}

std::string script_of(const DrawnSession &session)
{
    std::string text;
    for (const std::string &line : session.lines) text += line + "\n";
    return text;
}

std::string command_of(const DrawnSession &session, const std::string &script_path)
{
    std::string command = "build/bin/cournand run";
    if (!session.scene.empty()) command += " --scene " + session.scene;
    for (const std::string &tool : session.tools) command += " --tool " + tool;
    for (const std::string &stent : session.stents) command += " --stent " + stent;
    return command + " --session " + script_path;
}

std::string tools_of(const DrawnSession &session)
{
    std::string text;
    for (const std::string &tool : session.tools)
        text += (text.empty() ? "" : " + ") + std::filesystem::path(tool).stem().string();
    return text;
}

} // namespace soak
