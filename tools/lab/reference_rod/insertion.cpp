// Feeds the reference rod step by step through the introducer sheath.
#include "tools/lab/reference_rod/insertion.hpp"
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace crn::reference
{
namespace
{

constexpr double degree = 3.14159265358979323846 / 180.0;

} // namespace

Vector zero_turn_axis(const Vector &direction)
{
    int least = 0;
    for (int k = 1; k < 3; k++)
        if (std::abs(direction[k]) < std::abs(direction[least])) least = k;
    return Vector::Unit(least).cross(direction).normalized();
}

Insertion::Insertion(const Rod &rod, const Physics &physics, const Sheath &sheath, double start_m,
                     double turn_rad)
    : rod_(rod), physics_(physics), sheath_(sheath), inserted_m_(start_m), turn_rad_(turn_rad)
{
    state_ = State::straight(rod, sheath.mouth_m + start_m * sheath.direction, sheath.direction,
                             zero_turn_axis(sheath.direction));
    std::fill(state_.angle.begin(), state_.angle.end(), turn_rad);
    for (const Vector &x : state_.x) anchors_.push_back({x, Vector::Zero(), 0.0});
    for (int i = 0; i + 2 < rod.nodes(); i++)
        if (rod.rest_curvature1[i] != 0.0 || rod.rest_curvature2[i] != 0.0) curved_ = i + 1;
    step(start_m, turn_rad);
}

// Returns the position of a node after the rod has moved along its own curve by `feed_m`. The new position of
// a node is a point of the rod's curve before the step.
Vector Insertion::followed(int node, double feed_m) const
{
    const double arc_m = rod_.arc_m[node] - feed_m;
    if (arc_m <= 0.0) return state_.x[0] - arc_m * state_.tangent[0];
    int edge = std::min(node, rod_.nodes() - 2);
    while (edge > 0 && rod_.arc_m[edge] > arc_m) edge--;
    const double u = (arc_m - rod_.arc_m[edge]) / rod_.length_m(edge);
    return (1.0 - u) * state_.x[edge] + u * state_.x[edge + 1];
}

// Moves the rod along its own curve, with its curved tip as a rigid body in front; the whole rod turns with
// the hand.
void Insertion::place(double inserted_m, double turn_rad)
{
    const double feed_m = inserted_m - inserted_m_;
    const int n = rod_.nodes();
    std::vector<Vector> x = state_.x;
    std::vector<double> angle = state_.angle;
    for (int i = curved_; i < n; i++) {
        const double behind_m = rod_.arc_m[i] - inserted_m;
        x[i] =
            behind_m >= -1e-12 ? Vector(sheath_.mouth_m - behind_m * sheath_.direction) : followed(i, feed_m);
    }
    if (curved_ > 0) {
        const Vector forward = (x[curved_] - x[curved_ + 1]).normalized();
        const auto turn = Eigen::Quaterniond::FromTwoVectors(state_.tangent[curved_], forward);
        for (int i = 0; i < curved_; i++) {
            const double behind_m = rod_.arc_m[i] - inserted_m;
            x[i] = behind_m >= -1e-12 ? Vector(sheath_.mouth_m - behind_m * sheath_.direction)
                                      : Vector(x[curved_] + turn * (state_.x[i] - state_.x[curved_]));
        }
    }
    for (double &a : angle) a += turn_rad - turn_rad_;
    const State from = state_;
    move_state(from, x, angle, n, state_);
    free_ = static_cast<int>(std::lower_bound(rod_.arc_m.begin(), rod_.arc_m.end(), inserted_m - 1e-12) -
                             rod_.arc_m.begin());
    inserted_m_ = inserted_m;
    turn_rad_ = turn_rad;
    stiffen_mouth();
}

// A joint represents the rod over half an edge to either side (its cell). The two joints next to the
// introducer sheath's end may bend only where their cells are outside the sheath. If the two joints next to
// the sheath's end could bend over their whole cells, the rod would behave as if it were clamped up to one
// edge behind the sheath's end.
void Insertion::stiffen_mouth()
{
    constexpr double least = 0.02; // of a cell
    rod_.joint_m = rod_.cell_m;
    for (int j = std::max(1, free_ - 1); j <= std::min(free_, rod_.nodes() - 2); j++)
        rod_.joint_m[j] = std::clamp(inserted_m_ - cell_front_m(j), least * rod_.cell_m[j], rod_.cell_m[j]);
}

double Insertion::cell_front_m(int joint) const
{
    return rod_.arc_m[joint] - 0.5 * rod_.length_m(joint - 1);
}

// Returns the sum of two forces on the rod at the sheath's end. One force holds the nodes in the sheath. The
// other force is EI kappa^2 / 2, with which a sleeve pushes on a rod of curvature kappa that is bent where it
// leaves the sleeve (Bigoni et al., Eshelby-like forces acting on elastic structures, 2015). The push of the
// sleeve arises because every step frees a further part of the rod, which can then bend. Without the push of
// the sleeve, the work of the hand would not equal the energy that the rod stores. The computed push includes
// bending alone. Twist at the sheath's end would add the force GJ m^2 / 2, where m is the twist per metre;
// this force is below 1 mN here.
double Insertion::held_N() const
{
    double force_N = 0.0;
    for (int i = free_; i < std::min(free_ + 2, rod_.nodes()); i++)
        force_N += outcome_.slope.segment<3>(4 * i).dot(sheath_.direction);
    int mouth = std::clamp(free_, 1, rod_.nodes() - 2); // the joint whose cell the sheath's end divides
    while (mouth > 1 && cell_front_m(mouth) > inserted_m_) mouth--;
    const Vector &front = state_.tangent[mouth - 1], &rear = state_.tangent[mouth];
    const double curvature_per_m =
        2.0 * rear.cross(front).norm() / (1.0 + rear.dot(front)) / rod_.joint_m[mouth];
    return force_N - 0.5 * rod_.bend_N_m2[mouth] * curvature_per_m * curvature_per_m;
}

bool Insertion::step(double inserted_m, double turn_rad)
{
    place(inserted_m, turn_rad);
    const int held = std::min(free_ + 2, rod_.nodes());
    outcome_ = find_rest(rod_, physics_, free_, held, anchors_, state_);
    iterations_ += outcome_.iterations;
    return outcome_.at_rest;
}

bool Insertion::advance(double inserted_m, double turn_rad)
{
    constexpr int halvings_max = 6;
    const double from_m = inserted_m_, from_rad = turn_rad_;
    double done = 0.0, share = 1.0;
    bool at_rest = true;
    while (done < 1.0 - 1e-9) {
        const State before = state_;
        const std::vector<Anchor> anchors_before = anchors_;
        const double before_m = inserted_m_, before_rad = turn_rad_;
        const double next = std::min(1.0, done + share);
        const bool good =
            step(from_m + next * (inserted_m - from_m), from_rad + next * (turn_rad - from_rad));
        if (!good && share > std::ldexp(1.0, -halvings_max)) {
            state_ = before;
            anchors_ = anchors_before;
            inserted_m_ = before_m;
            turn_rad_ = before_rad;
            share *= 0.5;
            continue;
        }
        at_rest = at_rest && good;
        drag_anchors(rod_, physics_, free_, state_, anchors_);
        depth_m_ = std::max(depth_m_, outcome_.depth_m);
        residual_N_ = std::max(residual_N_, outcome_.residual_N);
        done = next;
    }
    hand_N_ = held_N();
    return at_rest;
}

std::vector<Vector> Insertion::centreline_m() const
{
    std::vector<Vector> points = {sheath_.mouth_m};
    for (int i = free_ - 1; i >= 0; i--) points.push_back(state_.x[i]);
    return points;
}

Run insert(const insertion::Case &c, const crn_wire_instrument &table, const Wall &wall, double friction,
           const Cut &cut, const Step &step, const std::function<void(const std::string &)> &progress)
{
    const Rod rod = cut_rod(table, c.depths.back().inserted_mm * 1e-3, cut);
    Physics physics;
    physics.wall = wall;
    physics.friction = friction;
    const double start_mm = 2.0;
    Insertion line(rod, physics, {c.mouth_mm * 1e-3, c.direction}, start_mm * 1e-3,
                   c.turn_deg_at(start_mm) * degree);
    Run run;
    double at_mm = start_mm;
    for (const insertion::Depth &depth : c.depths) {
        const int steps = std::max(
            1, static_cast<int>(std::ceil((depth.inserted_mm - at_mm) / (step.feed_m * 1e3) - 1e-9)));
        const double from_mm = at_mm;
        for (int i = 1; i <= steps; i++) {
            at_mm = from_mm + (depth.inserted_mm - from_mm) * i / steps;
            if (!line.advance(at_mm * 1e-3, c.turn_deg_at(at_mm) * degree)) run.unsettled++;
            run.force.push_back({at_mm, line.hand_N() * 1e3});
            run.steps++;
        }
        std::vector<Vector> points = line.centreline_m();
        for (Vector &p : points) p *= 1e3;
        run.centrelines_mm.push_back(std::move(points));
        if (progress) progress(depth.name);
    }
    run.iterations = line.iterations();
    run.depth_mm = line.depth_m() * 1e3;
    run.residual_mN = line.residual_N() * 1e3;
    return run;
}

} // namespace crn::reference
