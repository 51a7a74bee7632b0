// Computes curvature and twist at a joint of a discrete rod, with their first and second derivatives.
#pragma once
#include <Eigen/Core>

namespace crn::reference
{

// The 11 unknowns of a joint are, in order: rear node (3), angle of the rear edge, middle node (3), angle of
// the front edge, front node (3).
using Slope = Eigen::Matrix<double, 11, 1>;
using Second = Eigen::Matrix<double, 11, 11>;

struct Measure {
    double value = 0.0;
    Slope slope = Slope::Zero();
    Second second = Second::Zero();
};

// Holds the two edges of a joint as vectors that point forward, and the material axes d1 of these edges.
struct Joint {
    Eigen::Vector3d rear, front, rear_d1, front_d1;
    double twist = 0.0; // of the material frames
};

// Computes the curvature of a joint towards d1, its curvature towards t x d1, and its twist. `with_second`
// requests second derivatives too. The formulas hold for frames that follow their tangents by the smallest
// rotation (Bergou et al. 2010, appendix). For the twist, see Panetta et al., X-Shells, 2019.
void joint_measures(const Joint &joint, bool with_second, Measure &curvature1, Measure &curvature2,
                    Measure &twist);

} // namespace crn::reference
