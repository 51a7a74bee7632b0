// Finds the rod's equilibrium by Newton's method with a shifted band Cholesky factor and backtracking. Each
// Newton iteration uses the friction forces of the previous one.
#include "tools/lab/reference_rod/equilibrium.hpp"
#include <algorithm>
#include <cmath>

namespace crn::reference
{
namespace
{

// Holds the energy, force and stiffness of the wall per length of the rod, as functions of the penetration
// depth and divided by the wall's stiffness k.
struct Press {
    double energy, force, stiffness;
};

Press press(double depth_m, double onset_m)
{
    if (depth_m <= 0.0) return {0.0, 0.0, 0.0};
    if (depth_m < onset_m)
        return {depth_m * depth_m * depth_m / (6.0 * onset_m), depth_m * depth_m / (2.0 * onset_m),
                depth_m / onset_m};
    return {0.5 * depth_m * depth_m - 0.5 * depth_m * onset_m + onset_m * onset_m / 6.0,
            depth_m - 0.5 * onset_m, 1.0};
}

class Potential
{
  public:
    Potential(const Rod &rod, const Physics &physics, int free, int count, std::vector<Anchor> &anchors)
        : rod_(rod), physics_(physics), anchors_(anchors), free_(free), count_(count)
    {
    }

    // Moves every node's friction limit towards its value in the given state, by the fraction `share` of the
    // difference. Returns the largest difference between old and new friction limits before the change.
    double renew_friction(const State &state, double share)
    {
        double most_N = 0.0;
        if (!physics_.wall || physics_.friction == 0.0) return most_N;
        for (int i = 0; i < free_; i++) {
            Anchor &anchor = anchors_[i];
            const lumen::LumenField field = physics_.wall(state.x[i]);
            const double steep = field.gradient.norm();
            const double line_N = press(field.distance_m + rod_.radius_m[i], physics_.onset_m).force * steep;
            const double limit_N = physics_.friction * physics_.wall_N_per_m2 * rod_.cell_m[i] * line_N;
            if (limit_N > 0.0) anchor.normal = field.gradient / steep;
            most_N = std::max(most_N, std::abs(limit_N - anchor.limit_N));
            anchor.limit_N += share * (limit_N - anchor.limit_N);
        }
        return most_N;
    }

    double energy(const State &state, Eigen::VectorXd *slope, Band *second)
    {
        if (slope) slope->setZero(4 * count_);
        if (second) second->reset(4 * count_);
        double sum = elastic_energy(rod_, state, count_, slope, second);
        for (int i = 0; i < free_; i++) {
            if (physics_.wall) sum += wall(i, state.x[i], slope, second);
            if (anchors_[i].limit_N > 0.0) sum += friction(i, state.x[i], slope, second);
            if (!physics_.load_N.empty()) {
                sum -= physics_.load_N[i].dot(state.x[i]);
                if (slope) slope->segment<3>(4 * i) -= physics_.load_N[i];
            }
        }
        return sum;
    }

    double depth_m = 0.0; // deepest contact at the last evaluation with a slope

  private:
    void add(int i, const Vector &g, const Eigen::Matrix3d &h, Eigen::VectorXd *slope, Band *second)
    {
        if (slope) slope->segment<3>(4 * i) += g;
        if (second)
            for (int a = 0; a < 3; a++)
                for (int b = 0; b <= a; b++) second->at(4 * i + a, 4 * i + b) += h(a, b);
    }

    double wall(int i, const Vector &x, Eigen::VectorXd *slope, Band *second)
    {
        const lumen::LumenField field = physics_.wall(x);
        const double depth = field.distance_m + rod_.radius_m[i];
        if (slope) depth_m = std::max(i == 0 ? 0.0 : depth_m, depth);
        if (depth <= 0.0) return 0.0;
        const Press p = press(depth, physics_.onset_m);
        const double k = physics_.wall_N_per_m2 * rod_.cell_m[i];
        add(i, k * p.force * field.gradient,
            k * (p.stiffness * field.gradient * field.gradient.transpose() + p.force * field.second_per_m),
            slope, second);
        return k * p.energy;
    }

    double friction(int i, const Vector &x, Eigen::VectorXd *slope, Band *second)
    {
        const Anchor &lag = anchors_[i];
        const double e = physics_.slip_m;
        const Eigen::Matrix3d tangential = Eigen::Matrix3d::Identity() - lag.normal * lag.normal.transpose();
        const Vector u = tangential * (x - lag.at);
        const double way = u.norm();
        const bool sticks = way < e;
        // `secant` is the force divided by the displacement, and `tangent` is the slope of the force.
        const double secant = lag.limit_N * (sticks ? (2.0 - way / e) / e : 1.0 / way);
        const double tangent = sticks ? lag.limit_N * 2.0 * (1.0 - way / e) / e : 0.0;
        Eigen::Matrix3d h = secant * tangential;
        if (way > 1e-15) h += (tangent - secant) / (way * way) * u * u.transpose();
        add(i, secant * u, h, slope, second);
        return lag.limit_N * (sticks ? way * way / e - way * way * way / (3.0 * e * e) + e / 3.0 : way);
    }

    const Rod &rod_;
    const Physics &physics_;
    std::vector<Anchor> &anchors_;
    int free_, count_;
};

double residual(const Eigen::VectorXd &slope, int free)
{
    double most = 0.0;
    for (int i = 0; i < free; i++) most = std::max(most, slope.segment<3>(4 * i).norm());
    return most;
}

// Solves (H + shift D) d = -g for the free unknowns d, where H is the matrix of second derivatives, D holds
// the magnitudes of its diagonal, and g is the gradient of the energy. The shift is the smallest of a series
// of values that makes the matrix positive definite.
void newton_direction(const Band &whole, const Eigen::VectorXd &slope, int unknowns, double &shift,
                      Eigen::VectorXd &direction)
{
    constexpr double least = 1e-6;
    Band band;
    for (double trial = shift < least ? 0.0 : shift;; trial = std::max(least, trial * 3.0)) {
        band.reset(unknowns);
        for (int i = 0; i < unknowns; i++)
            for (int j = std::max(0, i - Band::reach); j <= i; j++) band.at(i, j) = whole.at(i, j);
        for (int i = 0; i < unknowns; i++) band.at(i, i) += trial * std::abs(whole.at(i, i)) + trial * 1e-9;
        if (!band.factor()) continue;
        shift = trial;
        break;
    }
    direction = -slope.head(unknowns);
    band.solve(direction);
}

// Returns the longest permitted step along `direction`, as a factor of `direction`. No iteration moves a node
// by more than 2 mm or turns an edge of the rod by more than 0.7 rad.
double longest(const Eigen::VectorXd &direction, int free)
{
    constexpr double way_m = 2e-3, turn_rad = 0.7;
    double scale = 1.0;
    for (int i = 0; i < free; i++) {
        scale = std::min(scale, way_m / std::max(1e-30, direction.segment<3>(4 * i).norm()));
        scale = std::min(scale, turn_rad / std::max(1e-30, std::abs(direction[4 * i + 3])));
    }
    return scale;
}

} // namespace

Outcome find_rest(const Rod &rod, const Physics &physics, int free, int count, std::vector<Anchor> &anchors,
                  State &state)
{
    constexpr int whole_renewals = 4; // later renewals go half-way, so that oscillations decay
    Potential potential(rod, physics, free, count, anchors);
    Outcome out;
    Eigen::VectorXd direction;
    Band second;
    double shift = 0.0, inner_N = 100.0 * physics.residual_N;
    int renewals = 0;
    State trial = state;
    for (;; out.iterations++) {
        double energy = potential.energy(state, &out.slope, &second);
        out.residual_N = residual(out.slope, free);
        out.depth_m = potential.depth_m;
        if (out.residual_N < inner_N) {
            const double off_N = potential.renew_friction(state, renewals++ < whole_renewals ? 1.0 : 0.5);
            out.at_rest = out.residual_N < physics.residual_N && off_N < physics.residual_N;
            inner_N = std::clamp(0.1 * off_N, physics.residual_N, inner_N);
            if (!out.at_rest) energy = potential.energy(state, &out.slope, &second);
        }
        if (out.at_rest || out.iterations >= physics.iterations_max) return out;

        newton_direction(second, out.slope, 4 * free, shift, direction);
        const double slope_along = out.slope.head(4 * free).dot(direction);
        double share = longest(direction, free);
        for (int cut = 0; cut < 40; cut++, share *= 0.5) {
            std::vector<Vector> x = state.x;
            std::vector<double> angle = state.angle;
            for (int i = 0; i < free; i++) {
                x[i] += share * direction.segment<3>(4 * i);
                angle[i] += share * direction[4 * i + 3];
            }
            move_state(state, x, angle, count, trial);
            const double now = potential.energy(trial, nullptr, nullptr);
            if (now <= energy + 1e-4 * share * slope_along + 1e-13 * std::abs(energy)) break;
        }
        std::swap(state, trial);
        shift *= 0.3;
    }
}

void drag_anchors(const Rod &rod, const Physics &physics, int free, const State &state,
                  std::vector<Anchor> &anchors)
{
    for (int i = 0; i < static_cast<int>(state.x.size()); i++) {
        Anchor &anchor = anchors[i];
        if (i >= free || wall_force_N(rod, physics, i, state) == 0.0) {
            anchor = {state.x[i], Vector::Zero(), 0.0};
            continue;
        }
        Vector u = state.x[i] - anchor.at;
        u -= u.dot(anchor.normal) * anchor.normal;
        const double way = u.norm();
        anchor.at = state.x[i] - (way > physics.slip_m ? physics.slip_m / way : 1.0) * u;
    }
}

double wall_force_N(const Rod &rod, const Physics &physics, int node, const State &state)
{
    if (!physics.wall) return 0.0;
    const lumen::LumenField field = physics.wall(state.x[node]);
    const double depth = field.distance_m + rod.radius_m[node];
    return physics.wall_N_per_m2 * rod.cell_m[node] * press(depth, physics.onset_m).force *
           field.gradient.norm();
}

} // namespace crn::reference
