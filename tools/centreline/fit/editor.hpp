// The editor's window: points set by clicks into a vessel, spheres fitted between them.
#pragma once
#include "tools/centreline/fit/automatic.hpp"
#include "tools/centreline/fit/project.hpp"
#include "tools/centreline/flow.hpp"

namespace crn::centreline
{

struct EditorWish {
    std::string output;     // the tree, written with every save; empty: none
    std::string screenshot; // of the last screen; empty: none
    int frames = 0;         // for tests: end after so many screens; 0: until Esc
    AutoWish automatic;
    FlowSettings flow;
};

// What a click at these pixels means: the middle of the vessel, halfway between the first two walls behind
// it, or nothing.
struct View;
std::optional<Eigen::Vector3d> picked(const Lumen &lumen, const View &view, double x, double y);

// Runs until the user ends it; the project is saved then, also after Ctrl-C. 0, or 1 when a signal ended it.
// Throws std::runtime_error where there is no display.
int run_editor(const Lumen &lumen, Project &project, const EditorWish &wish, bake::Progress &progress);

} // namespace crn::centreline
