#include "host/stent/stent.hpp"
#include "host/stent/relaxation.hpp"
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace crn
{

namespace
{

using Eigen::Vector3d;

constexpr double opened_share = 1.2;   // of the crimped radius: beyond it a ring has left the folded balloon
constexpr double separation_mm = 0.01; // between balloon and struts
constexpr double least_height = 0.05;  // of a strut's length: height of a fully opened ring
constexpr double narrow_N_per_mm = 10.0; // of a ring in a place that is too narrow: its struts catch
constexpr double held_share = 0.05;      // share of points in the wall below which a stent is not held

} // namespace

bool StentSleeve::covers(const Vector3d &place_mm) const
{
    for (std::size_t i = 1; i < centres_mm.size(); ++i) {
        const Vector3d way = centres_mm[i] - centres_mm[i - 1];
        const double length = way.norm();
        if (length < 1e-9) continue;
        const double along = (place_mm - centres_mm[i - 1]).dot(way) / length;
        const double from = i == 1 ? -overhang_mm : 0.0;
        const double to = length + (i + 1 == centres_mm.size() ? overhang_mm : 0.0);
        if (along >= from && along <= to &&
            (place_mm - centres_mm[i - 1] - along / length * way).norm() < 4 * length + 10)
            return true;
    }
    return false;
}

Stent::Stent(const StentDesign &design, double mount_arc_mm)
    : design_(design), lattice_(design), mount_arc_mm_(mount_arc_mm)
{
    state_.points.resize(lattice_.point_count());
    state_.rest_mm.assign(lattice_.springs.size(), 0.0);
    state_.ring_centre_mm.assign(static_cast<std::size_t>(design.rings), Vector3d::Zero());
    for (StentPoint &point : state_.points) point.peak_mm = design.crimped_radius_mm() / (1 - design.recoil);
}

double Stent::free_radius_mm(const StentPoint &point) const
{
    return point.peak_mm * (1 - design_.recoil);
}

bool Stent::is_opened(int ring) const
{
    double sum = 0.0;
    const int around = 2 * design_.crowns;
    for (int k = 0; k < around; ++k) sum += free_radius_mm(state_.points[lattice_.point(ring, k)]);
    return sum / around > opened_share * design_.crimped_radius_mm();
}

// --- on the balloon ---

double Stent::radius_on(const BalloonAxis &axis, double arc_mm, int ring, int side) const
{
    const int place = lattice_.side_of(lattice_.point(ring, 0)) == side ? 0 : 1;
    const double free = free_radius_mm(state_.points[lattice_.point(ring, place)]);
    return std::max(free, design_.radius_on_mm(axis.at(arc_mm).radius_mm));
}

// The radii of the rings determine their heights, the heights determine the positions of the crowns along the
// balloon, and these positions determine the radii. A few iterations converge.
Stent::Layout Stent::lay_out(const BalloonAxis &axis) const
{
    constexpr int rounds = 3;
    const auto rings = static_cast<std::size_t>(design_.rings);
    const double turn = std::cos(std::numbers::pi / design_.crowns), strut = design_.strut_length_mm;
    const double link = design_.link_length_mm();
    Layout layout;
    layout.tip_radius_mm.assign(rings, design_.crimped_radius_mm());
    layout.hub_radius_mm = layout.tip_radius_mm;
    layout.tip_arc_mm.resize(rings);
    layout.hub_arc_mm.resize(rings);
    for (int round = 0; round <= rounds; ++round) {
        double at = 0.0;
        for (std::size_t j = 0; j < rings; ++j) {
            const double a = layout.tip_radius_mm[j], b = layout.hub_radius_mm[j];
            const double chord2 = a * a + b * b - 2 * a * b * turn;
            const double height =
                std::sqrt(std::max(strut * strut - chord2, std::pow(least_height * strut, 2)));
            if (lattice_.mirrors || j == 0) {
                layout.tip_arc_mm[j] = at;
                layout.hub_arc_mm[j] = at + height;
                at += height + link;
            } else {
                layout.hub_arc_mm[j] = layout.hub_arc_mm[j - 1] + link;
                layout.tip_arc_mm[j] = layout.hub_arc_mm[j] - height;
            }
        }
        const double shift = mount_arc_mm() - (layout.tip_arc_mm.front() + layout.hub_arc_mm.back()) / 2;
        for (std::size_t j = 0; j < rings; ++j) {
            layout.tip_arc_mm[j] += shift;
            layout.hub_arc_mm[j] += shift;
            if (round == rounds) continue;
            layout.tip_radius_mm[j] = radius_on(axis, layout.tip_arc_mm[j], static_cast<int>(j), -1);
            layout.hub_radius_mm[j] = radius_on(axis, layout.hub_arc_mm[j], static_cast<int>(j), 1);
        }
    }
    return layout;
}

// A crimped stent stays behind in a narrow vessel if the vessel holds the stent with more force than the
// balloon does.
void Stent::slide(const BalloonAxis &axis)
{
    double moved_mm = 0.0, held_N = 0.0, pull_mm = 0.0;
    const Layout layout = lay_out(axis);
    const double outside = design_.crimped_diameter_mm / 2;
    for (std::size_t j = 0; j < layout.tip_arc_mm.size(); ++j) {
        if (is_opened(static_cast<int>(j))) return;
        const BalloonAxis::Place place = axis.at((layout.tip_arc_mm[j] + layout.hub_arc_mm[j]) / 2);
        const double along = (place.centre_mm - state_.ring_centre_mm[j]).dot(place.tangent);
        state_.ring_centre_mm[j] = place.centre_mm;
        const double depth = outside - place.room_mm;
        if (!state_.was_placed || !(depth > 0)) continue;
        held_N += narrow_N_per_mm * depth;
        pull_mm += narrow_N_per_mm * depth * along;
    }
    if (held_N <= design_.retention_N) return;
    moved_mm = pull_mm / held_N;
    state_.slip_mm -= moved_mm;
    for (std::size_t j = 0; j < layout.tip_arc_mm.size(); ++j)
        state_.ring_centre_mm[j] -= moved_mm * axis.at(layout.tip_arc_mm[j]).tangent;
    if (std::abs(state_.slip_mm) > design_.length_mm / 2) state_.stage = StentStage::stripped;
}

void Stent::follow(const StentSurroundings &around, const BalloonAxis &axis)
{
    slide(axis);
    const Layout layout = lay_out(axis);
    for (std::size_t i = 0; i < state_.points.size(); ++i) {
        StentPoint &point = state_.points[i];
        const auto ring = static_cast<std::size_t>(lattice_.ring_of(i));
        const bool is_hub = lattice_.side_of(i) > 0;
        const double radius = is_hub ? layout.hub_radius_mm[ring] : layout.tip_radius_mm[ring];
        const BalloonAxis::Place at = axis.at(is_hub ? layout.hub_arc_mm[ring] : layout.tip_arc_mm[ring]);
        const double angle = lattice_.angle(i);
        point.place_mm = at.centre_mm + radius * (std::cos(angle) * at.across + std::sin(angle) * at.third);
        point.peak_mm = std::max(point.peak_mm, radius);
    }
    state_.across = axis.across();
    state_.was_placed = true;
    if (state_.stage == StentStage::stripped || has_separated(axis)) deploy(around);
}

// Returns true if the balloon no longer touches any ring of the stent that the balloon has opened.
bool Stent::has_separated(const BalloonAxis &axis) const
{
    const Layout layout = lay_out(axis);
    bool has_opened = false;
    for (int ring = 0; ring < design_.rings; ++ring) {
        if (!is_opened(ring)) continue;
        has_opened = true;
        const auto j = static_cast<std::size_t>(ring);
        for (const auto &[arc, radius] : {std::pair{layout.tip_arc_mm[j], layout.tip_radius_mm[j]},
                                          std::pair{layout.hub_arc_mm[j], layout.hub_radius_mm[j]}})
            if (design_.radius_on_mm(axis.at(arc).radius_mm) > radius - separation_mm) return false;
    }
    return has_opened;
}

// Returns the triangles of the wall around the stent, found from the middles of the rings.
std::vector<std::uint32_t> Stent::patch_of(const StentWall &wall) const
{
    std::vector<Vector3d> middles;
    double widest = 0.0;
    for (int ring = 0; ring < design_.rings; ++ring) middles.push_back(ring_centre_mm(ring));
    for (const StentPoint &point : state_.points) widest = std::max(widest, point.peak_mm);
    return wall.near(middles, widest + wall_reach_mm);
}

// When the stent is deployed, its springs begin to hold its shape. At the deployment the springs carry no
// load, because the elastic part of their stretch is lost when the balloon is deflated.
void Stent::deploy(const StentSurroundings &around)
{
    if (state_.stage == StentStage::on_balloon) state_.stage = StentStage::deployed;
    const bool has_wall = around.wall && around.wall->is_placed();
    state_.near_begin.clear();
    state_.near.clear();
    if (has_wall) state_.patch = patch_of(*around.wall);
    std::int32_t beside = -1; // the triangle at the previous point
    for (std::size_t i = 0; i < state_.points.size(); ++i) {
        StentPoint &point = state_.points[i];
        for (const StentSleeve &sleeve : around.sleeves)
            if (sleeve.covers(point.place_mm)) point.layer_mm = std::max(point.layer_mm, sleeve.thickness_mm);
        if (!has_wall) continue;
        if (beside < 0 || lattice_.place_of(i) == 0)
            beside = around.wall->nearest(point.place_mm, state_.patch, wall_reach_mm).triangle;
        point.foot = around.wall->walk(point.place_mm, beside);
        if (std::abs(point.foot.distance_mm) > wall_reach_mm) point.foot = {};
        beside = point.foot.triangle;
        const double least = design_.strut_thickness_mm / 2 + point.layer_mm;
        const double gap = point.foot.distance_mm - least;
        point.is_bedded = state_.stage == StentStage::deployed && point.foot.is_known() &&
                          gap < bed_reach_mm && gap > -tissue_limit_mm;
        if (!point.is_bedded) continue;
        point.foot.height_mm = std::max(point.foot.height_mm, least);
        point.offset_mm = point.place_mm - around.wall->place(point.foot);
    }
    for (std::size_t i = 0; i < lattice_.springs.size(); ++i) {
        const auto [a, b] = lattice_.springs[i].ends;
        state_.rest_mm[i] = (state_.points[a].place_mm - state_.points[b].place_mm).norm();
    }
    if (state_.stage == StentStage::deployed) settle_stage();
}

// A deployed stent that the wall does not hold counts as adrift until another balloon presses it to the wall.
void Stent::settle_stage()
{
    const auto bedded = std::count_if(state_.points.begin(), state_.points.end(),
                                      [](const StentPoint &point) { return point.is_bedded; });
    const bool is_held =
        static_cast<double>(bedded) >= held_share * static_cast<double>(state_.points.size());
    state_.stage = is_held ? StentStage::deployed : StentStage::adrift;
}

// --- a step ---

void Stent::carry(const StentWall &wall)
{
    const auto around = static_cast<Eigen::Index>(2 * design_.crowns);
    Eigen::Matrix3Xd before(3, around), carried(3, around);
    for (int ring = 0; ring < design_.rings; ++ring) {
        bool is_known = true, is_bedded = true;
        for (Eigen::Index k = 0; k < around; ++k) {
            const StentPoint &point = state_.points[lattice_.point(ring, static_cast<int>(k))];
            before.col(k) = carried.col(k) = point.place_mm;
            is_known = is_known && point.foot.is_known();
            is_bedded = is_bedded && point.is_bedded;
            if (point.foot.is_known()) carried.col(k) = wall.place(point.foot) + point.offset_mm;
        }
        // Points of the stent that the wall does not hold move together as a rigid body: a vessel that widens
        // around them does not widen the stent.
        Eigen::Matrix4d way = Eigen::Matrix4d::Identity();
        if (is_known && !is_bedded) way = Eigen::umeyama(before, carried, false);
        for (Eigen::Index k = 0; k < around; ++k) {
            StentPoint &point = state_.points[lattice_.point(ring, static_cast<int>(k))];
            point.place_mm =
                point.is_bedded || !is_known
                    ? Vector3d(carried.col(k))
                    : Vector3d(way.topLeftCorner<3, 3>() * before.col(k) + way.topRightCorner<3, 1>());
        }
    }
}

void Stent::step(const StentSurroundings &around)
{
    const bool has_wall = around.wall && around.wall->is_placed();
    if (!is_on_balloon() && has_wall) carry(*around.wall);
    if (is_on_balloon() && around.own) {
        const BalloonAxis axis(*around.own, state_.across);
        if (axis.is_known()) follow(around, axis);
    }
    if (is_on_balloon() || !state_.was_placed) return;
    StentRelaxation(*this, around).run();
}

// --- shape ---

Vector3d Stent::ring_centre_mm(int ring) const
{
    Vector3d sum = Vector3d::Zero();
    const int around = 2 * design_.crowns;
    for (int k = 0; k < around; ++k) sum += state_.points[lattice_.point(ring, k)].place_mm;
    return sum / around;
}

Vector3d Stent::ring_axis(int ring) const
{
    Vector3d way = Vector3d::Zero();
    for (int k = 0; k < 2 * design_.crowns; ++k) {
        const std::uint32_t i = lattice_.point(ring, k);
        way += lattice_.side_of(i) * state_.points[i].place_mm;
    }
    return way.norm() > 1e-9 ? way.normalized() : Vector3d::UnitX();
}

// The middle of a strut lies on the circle through the strut's ends, whereas the middle of the chord lies at
// R cos(pi / 2N) from the axis of the ring.
Vector3d Stent::strut_middle_mm(std::size_t strut) const
{
    const auto [a, b] = lattice_.struts[strut];
    const int ring = lattice_.ring_of(a);
    const Vector3d middle = (state_.points[a].place_mm + state_.points[b].place_mm) / 2;
    const Vector3d axis = ring_axis(ring), from = middle - ring_centre_mm(ring);
    const Vector3d out = from - from.dot(axis) * axis;
    return middle + lattice_.bulge_share * out;
}

StentSleeve Stent::sleeve() const
{
    StentSleeve sleeve;
    if (is_on_balloon() || !state_.was_placed) return sleeve;
    for (int ring = 0; ring < design_.rings; ++ring) sleeve.centres_mm.push_back(ring_centre_mm(ring));
    sleeve.overhang_mm = design_.strut_length_mm / 2;
    sleeve.thickness_mm = design_.strut_thickness_mm;
    return sleeve;
}

double Stent::energy_N_mm() const
{
    double sum = 0.0;
    for (std::size_t i = 0; i < lattice_.springs.size(); ++i) {
        const StentSpring &spring = lattice_.springs[i];
        const double longer =
            (state_.points[spring.ends[0]].place_mm - state_.points[spring.ends[1]].place_mm).norm() -
            state_.rest_mm[i];
        sum += spring.stiffness_N_per_mm / 2 * longer * longer;
    }
    return sum;
}

} // namespace crn
