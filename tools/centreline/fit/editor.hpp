// The editor's window: clicks set points in a vessel, and spheres are fitted between them.
#pragma once
#include "tools/centreline/fit/automatic.hpp"
#include "tools/centreline/fit/project.hpp"
#include "tools/centreline/flow.hpp"

namespace crn::centreline
{

struct EditorWish {
    std::string output;     // the tree is written here with every save; empty: not written
    std::string screenshot; // picture of the last screen; empty: none
    int frames = 0;         // for tests: ends after this many screens; 0: runs until Esc
    AutoWish automatic;
    FlowSettings flow;
};

// The place that a click at these pixels selects: the middle of the vessel, halfway between the first two
// walls behind the click; or nothing.
struct View;
std::optional<Eigen::Vector3d> picked(const Lumen &lumen, const View &view, double x, double y);

// Runs until the user ends it. The project is saved then, also after Ctrl-C. Returns 0, or 1 when a signal
// ended it. Throws std::runtime_error where there is no display.
int run_editor(const Lumen &lumen, Project &project, const EditorWish &wish, bake::Progress &progress);

} // namespace crn::centreline
