#include "tools/lab/literature/experiments.hpp"

namespace crn::literature
{

std::vector<Experiment> all_experiments()
{
    std::vector<Experiment> all;
    for (auto list : {bending_experiments, path_experiments, motion_experiments, coronary_experiments,
                      stenosis_experiments, beam_experiments, stent_experiments, flush_experiments}) {
        for (Experiment &one : list()) all.push_back(std::move(one));
    }
    return all;
}

} // namespace crn::literature
