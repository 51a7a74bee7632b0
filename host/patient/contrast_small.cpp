// Draws the medium beyond the lumen: small vessels, veins, and the blush of tissue.
#include "host/patient/contrast.hpp"
#include "host/xray/paths/tube_faint.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{
namespace
{

constexpr double fine_radius_m = 1.5e-3;     // narrower vessels are drawn as lines
constexpr double invisible_mg_per_cm2 = 0.1; // concentration times diameter: 0.003 mm of undiluted medium
constexpr double invisible_ball_mm = 0.0002; // the same of one ball of a blush; many of them overlap
// Radius of the tissue behind a coronary artery, behind a small vessel of the heart, and of another organ.
constexpr double end_ball_m = 14e-3, heart_ball_m = 7e-3, organ_ball_m = 9e-3;
constexpr double mm3_per_ml = 1e3;

// Returns the radius of the tissue around the end of a vessel in which its blush is drawn; 0: it is not
// drawn, because the tissue's place is not known.
double blush_radius_m(VesselBed kind, bool is_small)
{
    switch (kind) {
    case VesselBed::systemic:
        return 0.0;
    case VesselBed::left_coronary:
    case VesselBed::right_coronary:
        return is_small ? heart_ball_m : end_ball_m;
    case VesselBed::kidney:
    case VesselBed::gut:
        break;
    }
    return organ_ball_m;
}

} // namespace

void PatientContrast::make_small_curves(const VesselTree &now)
{
    for (std::size_t v = 0; v < now.small.size(); ++v) make_small_curve(now.small[v], v);
}

// The concentration at a point of a small vessel is the mean of those in the pieces before and behind it.
void PatientContrast::make_small_curve(const VesselBranch &vessel, std::size_t index)
{
    SweptCurve curve{Material::iohexol_350, {}, vessel.radii_m.front() < fine_radius_m};
    const auto end_curve = [&] {
        if (curve.points.size() >= 2) curves_.push_back(curve);
        curve.points.clear();
    };
    // Where a vein leads out of the simulation, its medium spreads in blood that is not simulated.
    const bool fades = vessel.is_vein && vessel.parent < 0;
    const auto point = [&](std::size_t i, double mg_per_ml) {
        const double left = fades ? std::min(0.25 * static_cast<double>(i), 1.0) : 1.0;
        curve.points.push_back({vessel.points_m[i], vessel.radii_m[i], left * contrast_share(mg_per_ml)});
    };
    double before = 0.0;
    for (std::size_t piece = 0; piece + 1 < vessel.points_m.size(); ++piece) {
        const double here = flow_.distal().piece_mg_per_ml(index, piece);
        if (here * vessel.radii_m[piece] * 2e2 < invisible_mg_per_cm2) {
            end_curve();
            continue;
        }
        if (curve.points.empty())
            point(piece, here);
        else
            curve.points.back().share *= before > 0.0 ? 0.5 * (1.0 + here / before) : 1.0;
        point(piece + 1, here);
        before = here;
    }
    end_curve();
}

// The medium of a bed is a soft ball about the end of its vessel.
void PatientContrast::make_blush(const VesselTree &now)
{
    const std::vector<DistalFlow::Bed> &beds = flow_.distal().beds();
    for (std::size_t i = 0; i < beds.size(); ++i) {
        const auto vessel = static_cast<std::size_t>(beds[i].vessel);
        const bool is_small = vessel >= now.branches.size();
        const double radius_m = blush_radius_m(beds[i].kind, is_small);
        if (!(radius_m > 0.0)) continue;
        const VesselBranch &branch = now.numbered(vessel);
        const double medium_mm3 = flow_.distal().bed_mg(i) / iodine_default_mg_per_ml * mm3_per_ml;
        const double radius_mm = radius_m * 1e3;
        const double share = medium_mm3 / (soft_ball_cubes * radius_mm * radius_mm * radius_mm);
        if (share * radius_mm < invisible_ball_mm) continue;
        curves_.push_back(
            {Material::iohexol_350, {{branch.points_m.back(), radius_m, std::min(share, 1.0)}}});
    }
}

// Refluxed medium is a soft ball before the ostium, in the aorta.
void PatientContrast::make_sinuses()
{
    constexpr double ball_mm = 11.0;
    const FlowCells &cells = flow_.cells();
    for (std::size_t branch = 0; branch < cells.branch_count(); ++branch) {
        const double medium_mm3 = flow_.sinus_mg(branch) / iodine_default_mg_per_ml * mm3_per_ml;
        const double share = medium_mm3 / (soft_ball_cubes * ball_mm * ball_mm * ball_mm);
        if (share * ball_mm < invisible_ball_mm) continue;
        const std::size_t cell = cells.branch_begin(branch);
        const Eigen::Vector3d way = (cells.last_face_m(cell) - cells.first_face_m(cell)).normalized();
        curves_.push_back(
            {Material::iohexol_350,
             {{column_begin_m(cell) - 0.5e-3 * ball_mm * way, ball_mm * 1e-3, std::min(share, 1.0)}}});
    }
}

} // namespace crn
