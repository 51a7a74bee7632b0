// Lists the experiments of `literature`. An experiment repeats a published measurement with the simulator,
// and gives one figure for every row of the published table.
#pragma once
#include "tools/lab/validate/plot.hpp"

#include <functional>
#include <map>
#include <string>
#include <vector>

namespace crn::literature
{

struct Figures {
    std::map<std::string, double> values; // by the names of the table's rows
    std::vector<validate::Plot> curves;   // more to see than the figures, such as a force over the way
};

struct Experiment {
    std::string table; // name of the published table
    std::function<Figures()> run;
};

// Returns all experiments.
std::vector<Experiment> all_experiments();

// Each of the following functions returns the experiments of one source file.
std::vector<Experiment> bending_experiments();
std::vector<Experiment> path_experiments();
std::vector<Experiment> motion_experiments();
std::vector<Experiment> coronary_experiments();
std::vector<Experiment> stenosis_experiments();
std::vector<Experiment> beam_experiments();
std::vector<Experiment> stent_experiments();
std::vector<Experiment> flush_experiments();

} // namespace crn::literature
