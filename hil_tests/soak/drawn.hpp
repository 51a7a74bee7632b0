// A drawn session is a session made at random: its scene, its tools, its stents, and an ordinary session
// script (docs/session.md) as lines. A session that was made at random can therefore be printed, and the
// command `cournand run` can repeat it.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace soak
{

struct DrawnSession {
    std::uint64_t seed = 0;
    std::uint32_t index = 0;
    std::string scene;              // path; empty: free space
    std::vector<std::string> tools; // paths, from the innermost
    std::vector<std::string> stents;
    std::vector<std::string> lines; // of the script, a statement each
};

// "seed 1 session 17"
std::string name_of(const DrawnSession &session);
std::string script_of(const DrawnSession &session);
// Returns the `cournand run` command that repeats the session; `script_path` names the file with the
// session's script.
std::string command_of(const DrawnSession &session, const std::string &script_path);
// Returns the names of the tools without the scene, such as "j_wire + beacon_5f".
std::string tools_of(const DrawnSession &session);

} // namespace soak
