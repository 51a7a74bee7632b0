// Declares the commands of the program `centreline`; each command takes the parsed options.
#pragma once
#include "tools/centreline/fit/automatic.hpp"
#include "tools/centreline/fit/guided.hpp"
#include "tools/centreline/flow.hpp"

#include <string>
#include <vector>

namespace crn::centreline
{

struct Options {
    // The next members name the mesh file and define how the mesh is read.
    std::string mesh, unit = "mm", cap = "any";
    std::vector<std::string> parts;
    std::string data = "../shared/anatomy", shipped = "build/anatomy/aorta";
    double voxel_mm = 0;

    std::string points, output, project, screenshot;
    std::string tree; // for carry and show
    std::vector<std::string> inputs;
    std::string folder, radii_from, axes;
    std::vector<double> inlet_mm;
    double radii_times = 1;
    double turn_deg = 0, tilt_deg = 0;
    int size = 1000, frames = 0;
    bool as_is = false, split = false, with_names = false, wireframe = false;
    AutoWish automatic;
    FlowSettings flow;
};

// Each command returns the exit code and throws Fault, UsageError or OutputError.
int command_fit(const Options &options);
int command_auto(const Options &options);
int command_convert(const Options &options);
int command_carry(const Options &options);
int command_show(const Options &options);
int command_edit(const Options &options);

} // namespace crn::centreline
