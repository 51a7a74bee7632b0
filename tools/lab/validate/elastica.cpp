#include "tools/lab/validate/elastica.hpp"

#include <cmath>
#include <stdexcept>

namespace crn::validate
{

namespace
{

constexpr int steps = 2000;
constexpr int ramp = 40;

// Integrates the elastica's equations from the tip, where the angle is `tip`, to the clamp; returns the angle
// at the clamp.
double shoot(double tip, double tip_load, double line_load, std::vector<double> *angles)
{
    double h = 1.0 / steps, theta = tip, moment = 0;
    if (angles) angles->assign(steps + 1, tip);
    auto slope = [&](double from_tip, double angle) {
        return -(tip_load + line_load * from_tip) * std::cos(angle);
    };
    for (int i = 0; i < steps; i++) { // u = 1 - s: theta_u = -M, M_u = -(P + w u) cos theta
        double u = i * h;
        double k1t = -moment, k1m = slope(u, theta);
        double k2t = -(moment + h / 2 * k1m), k2m = slope(u + h / 2, theta + h / 2 * k1t);
        double k3t = -(moment + h / 2 * k2m), k3m = slope(u + h / 2, theta + h / 2 * k2t);
        double k4t = -(moment + h * k3m), k4m = slope(u + h, theta + h * k3t);
        theta += h / 6 * (k1t + 2 * k2t + 2 * k3t + k4t);
        moment += h / 6 * (k1m + 2 * k2m + 2 * k3m + k4m);
        if (angles) (*angles)[std::size_t(steps - 1 - i)] = theta;
    }
    return theta;
}

} // namespace

PlaneShape elastica(double tip_load, double line_load)
{
    double tip = 0;
    for (int part = 1; part <= ramp; part++) {
        double p = tip_load * part / ramp, w = line_load * part / ramp;
        for (int newton = 0; newton < 20; newton++) {
            double miss = shoot(tip, p, w, nullptr);
            double change = miss * 1e-6 / (shoot(tip + 1e-6, p, w, nullptr) - miss);
            tip -= change;
            if (std::fabs(change) < 1e-12) break;
        }
    }
    PlaneShape shape;
    if (std::fabs(shoot(tip, tip_load, line_load, &shape.angle)) > 1e-9) {
        throw std::runtime_error("elastica: shooting did not converge");
    }
    shape.x.assign(1, 0);
    shape.y.assign(1, 0);
    for (int i = 0; i < steps; i++) { // the angle at half a step from its neighbours' cubic
        double a = shape.angle[std::size_t(i)], b = shape.angle[std::size_t(i) + 1];
        double before = i > 0 ? shape.angle[std::size_t(i) - 1] : a;
        double after = i + 2 <= steps ? shape.angle[std::size_t(i) + 2] : b;
        double middle = (9 * (a + b) - before - after) / 16;
        shape.x.push_back(shape.x.back() + (std::cos(a) + 4 * std::cos(middle) + std::cos(b)) / (6 * steps));
        shape.y.push_back(shape.y.back() + (std::sin(a) + 4 * std::sin(middle) + std::sin(b)) / (6 * steps));
    }
    return shape;
}

// Load = K(k)^2 with k = sin(alpha / 2), where alpha is the tip's angle; x / L = 2 E / K - 1, y / L = 2 k /
// K.
Buckled buckled_cantilever(double load)
{
    double k = root([&](double m) { return std::pow(std::comp_ellint_1(m), 2) - load; }, 0, 0.999999);
    double K = std::comp_ellint_1(k), E = std::comp_ellint_2(k);
    return {2 * E / K - 1, 2 * k / K, 2 * std::asin(k)};
}

double root(const std::function<double(double)> &f, double low, double high)
{
    double at_low = f(low);
    if (at_low * f(high) > 0) throw std::runtime_error("root: no change of sign");
    for (int i = 0; i < 200; i++) {
        double middle = (low + high) / 2;
        if (f(middle) * at_low > 0) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return (low + high) / 2;
}

double beam_mode(unsigned number)
{
    double middle = (number - 0.5) * M_PI;
    return root([](double b) { return std::cos(b) + 1 / std::cosh(b); }, middle - 0.5, middle + 0.5);
}

double euler_clamped_pinned()
{
    return root([](double u) { return std::sin(u) - u * std::cos(u); }, M_PI, 1.5 * M_PI);
}

// The load parameter u follows from EI u^2 sin u = k L (u cos u - sin u), where k is the stiffness of the
// torsional spring; this results from the shape w = A sin(u s) + D s with w(1) = 0 and EI w'' = -k w' at s =
// 1.
double euler_spring_pinned(double spring)
{
    return root([&](double u) { return u * u * std::sin(u) - spring * (u * std::cos(u) - std::sin(u)); }, 2,
                1.5 * M_PI);
}

// The slope-deflection method gives s(u) / a + s''(v) / d = 0 for two spans of the lengths a and d, where
// s(u) and s''(v) are the stability functions of the axial load in each span. The far end of one span is
// clamped, and that of the other is free to turn.
double euler_two_spans(double a, double d)
{
    auto stiffness = [&](double q) {
        double u = a * q, v = d * q;
        double clamped = u * (std::sin(u) - u * std::cos(u)) / (2 - 2 * std::cos(u) - u * std::sin(u));
        double turning = v * v * std::sin(v) / (std::sin(v) - v * std::cos(v));
        return clamped / a + turning / d;
    };
    return root(stiffness, euler_clamped_pinned() / a, 2 * M_PI / a * 0.999999);
}

double greenhill()
{
    return 2 * euler_clamped_pinned(); // tan(x) = x with x = M L / 2 B
}

Writhe writhe(double slack, double turn_rad, double bend_over_twist)
{
    // The unknowns m and t follow from slack = sqrt(16 / t (1 - m^2 / 4t)) and turn = m B/C + 4 acos(m / (2
    // sqrt t)), where m is the end moment, t the tension, and B/C the ratio of bending to torsional
    // stiffness. The second equation gives m for a given t.
    auto moment = [&](double t) {
        return root(
            [&](double m) { return m * bend_over_twist + 4 * std::acos(m / (2 * std::sqrt(t))) - turn_rad; },
            0, 2 * std::sqrt(t));
    };
    auto miss = [&](double t) {
        double m = moment(t);
        return std::sqrt(16 / t * (1 - m * m / (4 * t))) - slack;
    };
    double least =
        std::pow(turn_rad / bend_over_twist / 2, 2); // tension at which the straight rod would buckle
    double t = root(miss, least * 1.0001, least * 1.5);
    return {moment(t), t};
}

} // namespace crn::validate
