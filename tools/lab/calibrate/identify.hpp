// Determines, for each fitted number, the range within which the objective rises by no more than the
// measurement noise explains. The other numbers stay constant while one number varies, or they vary as in the
// trials of the search.
#pragma once
#include "tools/lab/calibrate/search.hpp"

namespace crn::calibrate
{

struct IdentifySettings {
    bool is_wanted = true;  // false: ranges come from the search's trials alone
    double noise_mm = 0.05; // a smaller rise of the objective is not significant
    double spans_share =
        0.8; // share of the range between the bounds: above it, the data leave the number undetermined
};

struct Identified {
    double low = 0.0, high = 0.0; // values; the optimum lies between them
    double span_share = 0.0;      // of the range between the bounds
    bool is_determined = false;
};

// Returns one entry per parameter. The function `evaluate` receives the trials in a few large groups.
// `trials` holds all trials that the search has evaluated.
std::vector<Identified> identify(const std::vector<Parameter> &parameters, const Trial &best,
                                 const std::vector<Trial> &trials, const EvaluateShares &evaluate,
                                 const IdentifySettings &settings);

} // namespace crn::calibrate
