#include "host/stent/relaxation.hpp"
#include "host/stent/contact.hpp"
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace crn
{

namespace
{

using Eigen::Vector3d;

constexpr double bed_N_per_mm =
    6.0; // stiffness of the wall's lining for a point in it, in every direction ...
constexpr double bed_limit_N = 1.0; // ... until the point slides
constexpr double drag_N_per_mm =
    0.02; // of a point outside the lining: pulls it to the place where the nearest wall would carry it
constexpr double wall_N_per_mm = 60.0;     // resists penetration of the wall
constexpr double balloon_N_per_mm = 300.0; // resists penetration of a balloon
constexpr double step_max_mm = 0.2;
constexpr double enough_mm = 0.0005; // a sweep that moves every point by less is the last
constexpr int sweeps_max = 6;
constexpr double slop_mm =
    0.01; // penetration of struts in the wall that is tolerated before libccd is called
constexpr int strut_rounds = 2;
constexpr double touch_mm = 0.002;
constexpr double near_mm = 0.4; // distance around a strut in which its contact candidates are listed

} // namespace

StentRelaxation::StentRelaxation(Stent &stent, const StentSurroundings &around)
    : stent_(stent), state_(stent.state_), around_(around),
      wall_(around.wall && around.wall->is_placed() ? around.wall : nullptr),
      half_mm_(stent.design().strut_thickness_mm / 2), loads_(stent.points().size())
{
}

void StentRelaxation::run()
{
    load_points();
    load_balloons();
    for (int k = 0; k < sweeps_max; ++k)
        if (sweep() < enough_mm) break;
    if (wall_) push_struts();
    yield();
    if (wall_) bed();
    if (state_.stage != StentStage::stripped) stent_.settle_stage();
}

void StentRelaxation::load_points()
{
    for (std::size_t i = 0; i < loads_.size(); ++i) {
        const StentPoint &point = state_.points[i];
        Load &load = loads_[i];
        load.anchor_mm = load.carried_mm = point.place_mm;
        load.hold_N_per_mm = drag_N_per_mm;
        if (!wall_ || !point.foot.is_known()) continue;
        load.wall_out = wall_->normal(static_cast<std::size_t>(point.foot.triangle));
        load.wall_mm = wall_->on_plane(point.foot);
        load.wall_gap_mm = half_mm_ + point.layer_mm;
        load.has_wall = point.foot.distance_mm > -tissue_limit_mm;
        if (!point.is_bedded) continue;
        load.anchor_mm = wall_->place(point.foot);
        load.hold_N_per_mm = bed_N_per_mm;
    }
}

void StentRelaxation::load_balloons()
{
    const auto push = [&](const BalloonPose &pose, double layer_mm) {
        double widest = 0.0, narrowest = std::numeric_limits<double>::infinity();
        for (const BalloonPoint &ball : pose.points) widest = std::max(widest, ball.radius_mm);
        for (const StentPoint &point : state_.points)
            narrowest = std::min(narrowest, stent_.free_radius_mm(point));
        const double beyond = layer_mm + half_mm_;
        if (widest + beyond < 0.9 * narrowest) return; // folded
        const BalloonAxis axis(pose, Vector3d::UnitX());
        if (!axis.is_known()) return;
        for (std::size_t i = 0; i < loads_.size(); ++i) {
            double distance = 0.0;
            const double arc = axis.nearest_arc_mm(state_.points[i].place_mm, distance);
            if (distance > widest + beyond || arc <= axis.first_arc_mm() || arc >= axis.last_arc_mm())
                continue;
            const BalloonAxis::Place at = axis.at(arc);
            Load &load = loads_[i];
            if (load.has_balloon && load.balloon_radius_mm >= at.radius_mm + beyond) continue;
            load.has_balloon = true;
            load.balloon_mm = at.centre_mm;
            load.balloon_along = at.tangent;
            load.balloon_radius_mm = at.radius_mm + beyond;
        }
    };
    if (around_.own) push(*around_.own, 0.0);
    for (const StentBalloon &balloon : around_.balloons)
        if (balloon.pose) push(*balloon.pose, balloon.layer_mm);
}

namespace
{

// Represents a symmetric 3 x 3 matrix by six numbers instead of nine, because the innermost loop uses such
// matrices.
struct Symmetric {
    double xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;
    void add(double k, const Vector3d &v) // k v v^T
    {
        const double x = k * v.x(), y = k * v.y(), z = k * v.z();
        xx += x * v.x();
        yy += y * v.y();
        zz += z * v.z();
        xy += x * v.y();
        xz += x * v.z();
        yz += y * v.z();
    }
    void add_diagonal(double k)
    {
        xx += k;
        yy += k;
        zz += k;
    }
    Vector3d solve(const Vector3d &f) const // positive definite: by Cramer's rule
    {
        const double a = yy * zz - yz * yz, b = xz * yz - xy * zz, c = xy * yz - xz * yy;
        const double d = xx * zz - xz * xz, e = xy * xz - xx * yz, g = xx * yy - xy * xy;
        const double scale = 1 / (xx * a + xy * b + xz * c);
        return Vector3d(a * f.x() + b * f.y() + c * f.z(), b * f.x() + d * f.y() + e * f.z(),
                        c * f.x() + e * f.y() + g * f.z()) *
               scale;
    }
};

} // namespace

// Returns the Newton step of one point while all other points are fixed: the force divided by that part of
// its derivative which is never negative.
Vector3d StentRelaxation::newton_step(std::size_t i) const
{
    const StentLattice &lattice = stent_.lattice_;
    const Vector3d &x = state_.points[i].place_mm;
    const Load &load = loads_[i];
    Symmetric change;
    double along = load.hold_N_per_mm; // of the unit matrix
    Vector3d force = load.hold_N_per_mm * (load.anchor_mm - x);
    for (std::uint32_t k = lattice.bar_begin[i]; k < lattice.bar_begin[i + 1]; ++k) {
        const StentLattice::Bar &bar = lattice.bars[k];
        const Vector3d way = state_.points[bar.other].place_mm - x;
        const double per_length = 1 / std::sqrt(way.squaredNorm() + 1e-18);
        const double tension = bar.stiffness_N_per_mm * (1 - state_.rest_mm[bar.spring] * per_length);
        force += tension * way;
        const double across = std::max(tension, 0.0);
        change.add((bar.stiffness_N_per_mm - across) * per_length * per_length, way);
        along += across;
    }
    change.add_diagonal(along);
    if (load.has_wall) {
        const double depth = load.wall_gap_mm + load.wall_out.dot(x - load.wall_mm);
        if (depth > 0) {
            force -= wall_N_per_mm * depth * load.wall_out;
            change.add(wall_N_per_mm, load.wall_out);
        }
    }
    if (load.has_balloon) {
        Vector3d out = x - load.balloon_mm;
        out -= out.dot(load.balloon_along) * load.balloon_along;
        const double radius = out.norm();
        if (radius < load.balloon_radius_mm && radius > 1e-9) {
            out /= radius;
            force += balloon_N_per_mm * (load.balloon_radius_mm - radius) * out;
            change.add(balloon_N_per_mm, out);
        }
    }
    const Vector3d step = change.solve(force);
    const double far2 = step.squaredNorm();
    return far2 > step_max_mm * step_max_mm ? Vector3d(step * (step_max_mm / std::sqrt(far2))) : step;
}

double StentRelaxation::sweep()
{
    double farthest = 0.0;
    for (std::size_t i = 0; i < loads_.size(); ++i) {
        const Vector3d step = newton_step(i);
        state_.points[i].place_mm += step;
        farthest = std::max(farthest, step.squaredNorm());
    }
    return std::sqrt(farthest);
}

// --- struts against triangles ---

// At each step, a grid finds the triangles of the wall that a strut can touch before the strut has slid far.
// The triangles that a strut can touch are stored by index, so that they move with the wall.
void StentRelaxation::list_near()
{
    const StentLattice &lattice = stent_.lattice_;
    WallGrid grid;
    Vector3d low = state_.points[0].place_mm, high = low;
    for (const StentPoint &point : state_.points) {
        low = low.cwiseMin(point.place_mm);
        high = high.cwiseMax(point.place_mm);
    }
    const Vector3d margin = Vector3d::Constant(near_mm);
    grid.build(*wall_, state_.patch, low - margin, high + margin);
    state_.near_begin.assign(1, 0);
    state_.near.clear();
    for (const auto &[a, b] : lattice.struts) {
        const Vector3d &from = state_.points[a].place_mm, &to = state_.points[b].place_mm;
        grid.query(from.cwiseMin(to) - margin, from.cwiseMax(to) + margin, state_.near);
        state_.near_begin.push_back(static_cast<std::uint32_t>(state_.near.size()));
    }
    for (StentPoint &point : state_.points) point.slid_mm = 0.0;
}

void StentRelaxation::push_struts()
{
    const StentLattice &lattice = stent_.lattice_;
    const bool slid_far = std::any_of(state_.points.begin(), state_.points.end(),
                                      [](const StentPoint &point) { return point.slid_mm > near_mm / 2; });
    if (state_.near_begin.empty() || slid_far) list_near();
    planes_.resize(state_.patch.size());
    for (std::size_t k = 0; k < planes_.size(); ++k) {
        planes_[k].out = wall_->normal(state_.patch[k]);
        planes_[k].offset_mm = planes_[k].out.dot(wall_->corner_mm(state_.patch[k], 0));
    }
    ring_centre_.clear();
    ring_axis_.clear();
    for (int ring = 0; ring < lattice.rings; ++ring) {
        ring_centre_.push_back(stent_.ring_centre_mm(ring));
        ring_axis_.push_back(stent_.ring_axis(ring));
    }
    for (int round = 0; round < strut_rounds; ++round) {
        bool is_clear = true;
        for (std::size_t strut = 0; strut < lattice.struts.size(); ++strut)
            is_clear = !push_strut(strut) && is_clear;
        if (is_clear) break;
    }
}

// Returns the deepest contact of one capsule (half a strut) with the triangles in its strut's list.
StrutContact StentRelaxation::deepest(std::size_t strut, const StrutCapsule &capsule) const
{
    StrutContact worst;
    const double reach = slop_mm - capsule.radius_mm;
    for (std::uint32_t k = state_.near_begin[strut]; k < state_.near_begin[strut + 1]; ++k) {
        const Plane &plane = planes_[state_.near[k]];
        const double from = plane.out.dot(capsule.from_mm) - plane.offset_mm;
        const double to = plane.out.dot(capsule.to_mm) - plane.offset_mm;
        // Skips a capsule (half a strut) that lies entirely in front of the triangle's plane, or entirely
        // behind the tissue there.
        if (std::max(from, to) <= reach || std::min(from, to) > tissue_limit_mm) continue;
        const std::size_t triangle = state_.patch[state_.near[k]];
        const StrutContact contact = strut_contact(
            capsule,
            {wall_->corner_mm(triangle, 0), wall_->corner_mm(triangle, 1), wall_->corner_mm(triangle, 2)},
            plane.out);
        if (contact.depth_mm > worst.depth_mm) worst = contact;
    }
    return worst;
}

// A strut consists of two capsules (cylinders with round ends), which meet at its middle. Each capsule of a
// strut is moved out of the triangle into which it reaches deepest. Returns true if one of the strut's two
// capsules was moved.
bool StentRelaxation::push_strut(std::size_t strut)
{
    if (state_.near_begin[strut] == state_.near_begin[strut + 1]) return false;
    const auto [a, b] = stent_.lattice_.struts[strut];
    StentPoint *ends[2] = {&state_.points[a], &state_.points[b]};
    const auto ring = static_cast<std::size_t>(stent_.lattice_.ring_of(a));
    Vector3d bulge = (ends[0]->place_mm + ends[1]->place_mm) / 2 - ring_centre_[ring];
    bulge -= bulge.dot(ring_axis_[ring]) * ring_axis_[ring];
    bulge *= stent_.lattice_.bulge_share;
    const double radius = half_mm_ + std::min(ends[0]->layer_mm, ends[1]->layer_mm);
    bool was_pushed = false;
    for (std::size_t half = 0; half < 2; ++half) {
        const Vector3d middle = (ends[0]->place_mm + ends[1]->place_mm) / 2 + bulge;
        const StrutContact worst = deepest(strut, {ends[half]->place_mm, middle, radius});
        if (worst.depth_mm <= slop_mm) continue;
        // The middle of a capsule (half a strut) lies at a quarter of the strut's length. The two ends of the
        // strut move by 3/4 and 1/4 of the capsule's displacement, divided by (3/4)^2 + (1/4)^2 = 10/16, so
        // that the capsule moves by its whole displacement.
        const Vector3d way = (worst.depth_mm - slop_mm / 2) * worst.direction / 0.625;
        ends[half]->place_mm += 0.75 * way;
        ends[1 - half]->place_mm += 0.25 * way;
        loads_[half == 0 ? a : b].is_pushed = loads_[half == 0 ? b : a].is_pushed = true;
        was_pushed = true;
    }
    return was_pushed;
}

// --- permanent changes ---

// A spring that is stretched or compressed beyond its elastic range yields permanently. After a spring has
// yielded, its length would change only by the recoil if the load were removed.
void StentRelaxation::yield()
{
    const double recoil = stent_.design_.recoil;
    const StentLattice &lattice = stent_.lattice_;
    for (std::size_t i = 0; i < lattice.springs.size(); ++i) {
        const StentSpring &spring = lattice.springs[i];
        if (!spring.yields()) continue;
        const double length =
            (state_.points[spring.ends[0]].place_mm - state_.points[spring.ends[1]].place_mm).norm();
        double &rest = state_.rest_mm[i];
        rest = std::clamp(rest, length * (1 - recoil), length / (1 - recoil));
    }
}

// Updates the point of the wall that each point of the stent follows from now on.
void StentRelaxation::bed()
{
    for (std::size_t i = 0; i < loads_.size(); ++i) {
        StentPoint &point = state_.points[i];
        if (!point.foot.is_known()) continue;
        const double gap_mm = half_mm_ + point.layer_mm;
        const Load &load = loads_[i];
        const bool is_on_balloon =
            load.has_balloon && (point.place_mm - load.balloon_mm).norm() < load.balloon_radius_mm + touch_mm;
        const bool is_pushed = load.is_pushed || is_on_balloon;
        if (is_on_balloon) point.peak_mm = std::max(point.peak_mm, load.balloon_radius_mm);
        const Vector3d off = point.place_mm - load.anchor_mm;
        const double pull_N = bed_N_per_mm * off.norm();
        if (point.is_bedded && !is_pushed && pull_N <= bed_limit_N) {
            point.offset_mm = off;
            continue;
        }
        // If a point of the stent slides, is pushed or touches nothing, its foot (the wall point that it
        // follows) moves to the nearest point of the wall. A point that slides stops where the load on the
        // spring between point and wall no longer exceeds the limit.
        const bool slides = point.is_bedded && !is_pushed;
        const Vector3d place =
            slides ? Vector3d(point.place_mm - off * (bed_limit_N / pull_N)) : point.place_mm;
        point.slid_mm += (place - load.carried_mm).norm();
        point.foot = wall_->walk(place, point.foot.triangle);
        const double reach = point.is_bedded || is_on_balloon ? bed_reach_mm : touch_mm;
        const bool may_bed = state_.stage == StentStage::deployed || is_on_balloon;
        point.is_bedded =
            may_bed && point.foot.distance_mm < gap_mm + reach && point.foot.distance_mm > -tissue_limit_mm;
        if (slides && !point.is_bedded) point.foot = wall_->walk(point.place_mm, point.foot.triangle);
        if (point.is_bedded)
            point.foot.height_mm = std::max(point.foot.height_mm, gap_mm); // not behind the wall
        point.offset_mm = point.place_mm - wall_->place(point.foot);
        if (std::abs(point.foot.distance_mm) > wall_reach_mm) point.foot = {};
    }
}

} // namespace crn
