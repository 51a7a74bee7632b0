// In the editor's window a person clicks points in a vessel, and the editor fits spheres along the vessel
// from point to point.
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

// Returns the point of space that a click on a pixel selects, or nothing if the click hits no vessel. The
// selected point lies in the middle of the vessel, halfway between the first two walls along the line of
// sight.
struct View;
std::optional<Eigen::Vector3d> picked(const Lumen &lumen, const View &view, double x, double y);

// Shows the editor's window until the user closes this window. The editor saves the project when the window
// closes, and also when the user presses Ctrl-C in the terminal. Returns 1 when a signal (such as Ctrl-C)
// closed the window, and 0 otherwise. Throws std::runtime_error if there is no display.
int run_editor(const Lumen &lumen, Project &project, const EditorWish &wish, bake::Progress &progress);

} // namespace crn::centreline
