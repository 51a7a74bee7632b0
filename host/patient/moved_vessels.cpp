#include "host/patient/moved_vessels.hpp"
#include <vector>

namespace crn
{

using Eigen::Vector3d;

MovedVessels::MovedVessels(const VesselTree &reference, const Motion *motion, const LesionOpening &opening)
{
    if (!motion) return;
    std::vector<Vector3d> points_m;
    for (const std::vector<VesselBranch> *part : {&reference.branches, &reference.small})
        for (const VesselBranch &branch : *part)
            points_m.insert(points_m.end(), branch.points_m.begin(), branch.points_m.end());
    points_.emplace(*motion, std::move(points_m));
    std::vector<Vector3d> healthy_m;
    for (std::size_t k = 0; k < opening.lesion_count(); ++k)
        healthy_m.insert(healthy_m.end(), reference.lesions[k].healthy_points_m.begin(),
                         reference.lesions[k].healthy_points_m.end());
    healthy_points_.emplace(*motion, std::move(healthy_m));
    reference_ = reference;
    moved_ = reference;
}

const VesselTree &MovedVessels::at(const MotionMoment &moment, const LesionOpening &opening,
                                   std::span<const double> lesions_open)
{
    const MotionWeights now = motion_weights(moment);
    std::size_t i = 0;
    for (std::vector<VesselBranch> *part : {&moved_.branches, &moved_.small})
        for (VesselBranch &branch : *part)
            for (Vector3d &point_m : branch.points_m) point_m = points_->at(i++, now);
    i = 0;
    for (std::size_t k = 0; k < opening.lesion_count(); ++k) {
        const VesselLesion &lesion = reference_.lesions[k];
        for (std::size_t point = 0; point < lesion.size(); ++point, ++i) {
            Vector3d &place_m = moved_.branches[lesion.branch].points_m[lesion.first_point + point];
            const double share = opening.at_point(k, point, lesions_open);
            if (share > 0.0) place_m += share * (healthy_points_->at(i, now) - place_m);
        }
    }
    return moved_;
}

} // namespace crn
