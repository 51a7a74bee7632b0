// How well each number is determined: how far it can go, the others as they are or as the search has varied
// them, while the objective rises by less than what noise explains.
#pragma once
#include "tools/lab/calibrate/search.hpp"

namespace crn::calibrate
{

struct IdentifySettings {
    bool is_wanted = true;  // false: ranges are those of the search's trials alone
    double noise_mm = 0.05; // rise of the objective that says nothing
    double spans_share =
        0.8; // of the range between the bounds: more says that the data leave the number open
};

struct Identified {
    double low = 0.0, high = 0.0; // values; the optimum lies between them
    double span_share = 0.0;      // of the range between the bounds
    bool is_determined = false;
};

// One per parameter. Trials go to `evaluate` in a few batches. `trials` are those of the search.
std::vector<Identified> identify(const std::vector<Parameter> &parameters, const Trial &best,
                                 const std::vector<Trial> &trials, const EvaluateShares &evaluate,
                                 const IdentifySettings &settings);

} // namespace crn::calibrate
