// Injures the vessels in which blood and medium flow, and draws the medium in such wounds.
#include "host/patient/contrast.hpp"
#include "host/xray/paths/tube_faint.hpp"
#include <algorithm>
#include <numbers>

namespace crn
{
namespace
{

using Eigen::Vector3d;

constexpr double visible_mg = 0.05;       // of a wound; less is not drawn
constexpr double visible_mg_per_ml = 5.0; // of a jet
constexpr double flap_share = 0.05;       // thickness of the flap, in radii of the vessel
constexpr double thinnest_share = 0.05;   // radius of a pocket, in radii of the vessel

// Returns the third root of a positive number by Newton's method, so that every machine draws the same
// picture.
double third_root(double x)
{
    double root = std::max(x, 1.0);
    for (int i = 0; i < 60; ++i) root -= (root - x / (root * root)) / 3.0;
    return root;
}

} // namespace

void PatientContrast::set_hole(std::size_t index, const WallHole &hole, std::uint32_t tick)
{
    new_holes_.emplace_back(index, hole);
    wake(tick);
}

void PatientContrast::set_flap(std::size_t index, const WallFlap &flap, std::uint32_t tick)
{
    new_flaps_.emplace_back(index, flap);
    wake(tick);
}

void PatientContrast::wake(std::uint32_t tick)
{
    if (state_ == State::flows || wake_tick_ != UINT32_MAX) return; // a look is due anyway
    wake_tick_ = (tick / look_every_ticks + 1) * look_every_ticks;
}

// The flow has been advanced to the frame of the look; an injury acts from there on, whichever other frames
// were requested since the wall was injured.
void PatientContrast::take_injuries()
{
    for (const auto &[index, hole] : new_holes_) flow_.set_hole(index, hole);
    for (const auto &[index, flap] : new_flaps_) flow_.set_flap(index, flap);
    new_holes_.clear();
    new_flaps_.clear();
}

void PatientContrast::follow_wounds(double pressure_share)
{
    flow_.take_wounds();
    pressure_share_ = pressure_share;
}

const FlowCells &PatientContrast::cells_at(const WireFrame &wire)
{
    if (moved_.can_move())
        flow_.place(moved_.at({wire.heart_phase32, wire.breath_phase32}, opening_, flow_open_));
    return flow_.cells();
}

// Medium in the tissue is a soft ball beside the vessel. Its middle has the concentration of the blush, so
// that its radius grows with the third root of the iodine that has leaked.
void PatientContrast::make_wounds()
{
    const FlowCells &cells = flow_.cells();
    for (const WallHole &hole : flow_.wounds().holes()) {
        if (hole.iodine_mg < visible_mg) continue;
        const double share = contrast_share(hole.blush_mg_per_ml);
        const double medium_mm3 = hole.iodine_mg / iodine_default_mg_per_ml * 1e3;
        const double radius_m = third_root(medium_mm3 / (soft_ball_cubes * share)) * 1e-3;
        const double from_axis_m = cells[hole.cell].radius_mm * 1e-3 + 0.5 * radius_m;
        const Vector3d ball_m = cells.middle_m(hole.cell) + from_axis_m * hole.outward;
        curves_.push_back({Material::iohexol_350, {{ball_m, radius_m, share}}});
        if (hole.is_jet && hole.flow_ml_s > 0.0) make_jet(hole, ball_m);
    }
    for (const WallFlap &flap : flow_.wounds().flaps())
        if (flap.iodine_mg >= visible_mg) make_pocket(flap);
}

void PatientContrast::make_jet(const WallHole &hole, const Vector3d &ball_m)
{
    const double mg_per_ml = flow_.iodine_mg_per_ml(hole.cell);
    if (mg_per_ml < visible_mg_per_ml) return;
    const double share = contrast_share(mg_per_ml), radius_m = 0.5e-3 * hole.diameter_mm;
    curves_.push_back(
        {Material::iohexol_350,
         {{flow_.cells().middle_m(hole.cell), radius_m, share}, {ball_m, 2.0 * radius_m, share}}});
}

// The pocket is a thin column beside the lumen; the flap between both is free of medium.
void PatientContrast::make_pocket(const WallFlap &flap)
{
    const FlowCells &cells = flow_.cells();
    const double width = std::max(flap.narrowing - flap_share, thinnest_share);
    double drawn_mm3 = 0.0;
    for (std::size_t i = flap.begin; i < flap.end; ++i) {
        const double radius_mm = width * cells[i].radius_mm;
        drawn_mm3 += std::numbers::pi * radius_mm * radius_mm * cells[i].length_mm;
    }
    const double share = std::min(flap.iodine_mg / iodine_default_mg_per_ml * 1e3 / drawn_mm3,
                                  contrast_share(curves_mg_per_ml_));
    SweptCurve curve{Material::iohexol_350, {}};
    const auto add = [&](std::size_t cell, const Vector3d &at_m) {
        const double radius_m = cells[cell].radius_mm * 1e-3;
        curve.points.push_back({at_m + (1.0 - width) * radius_m * flap.side, width * radius_m, share});
    };
    add(flap.begin, cells.first_face_m(flap.begin));
    for (std::size_t i = flap.begin; i < flap.end; ++i) add(i, cells.middle_m(i));
    add(flap.end - 1, cells.last_face_m(flap.end - 1));
    curves_.push_back(curve);
}

// A flap presses the lumen to the other side.
void PatientContrast::narrow(std::size_t cell, SweptPoint &point) const
{
    for (const WallFlap &flap : flow_.wounds().flaps()) {
        if (cell < flap.begin || cell >= flap.end) continue;
        point.at_m -= flap.narrowing * point.radius_m * flap.side;
        point.radius_m *= 1.0 - flap.narrowing;
    }
}

} // namespace crn
