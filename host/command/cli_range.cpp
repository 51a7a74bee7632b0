// Defines what the commands `run` and `replay` print and return if the physics of the session has left its
// valid range.
#include "host/base/terminal.hpp"
#include "host/command/cli.hpp"
#include "host/model/bodies.hpp"

namespace crn
{

void name_range_branch(RangeWatch &range, const std::string &bodies_path)
{
    if (!range.is_left() || bodies_path.empty()) return;
    Bodies bodies;
    std::string error; // a picture would report this error; the place is known without its name
    if (read_bodies(bodies_path, bodies, error)) range.name_branch(bodies.vessels);
}

int exit_of_range(const RangeWatch &range)
{
    if (!range.is_left()) return 0;
    say(stderr, "cournand: %s\n", range_text(*range.left()).c_str());
    return exit_out_of_range;
}

} // namespace crn
