// Tests the motion of a cantilever: the frequencies and damping of its oscillations.
#include "tools/lab/validate/cases.hpp"
#include "tools/lab/validate/elastica.hpp"
#include "tools/lab/validate/support.hpp"

#include <cmath>
#include <complex>

namespace crn::validate
{

namespace
{

constexpr double step_s = 1e-3, drag_per_s = 20; // the core's tick and its mass-proportional drag

// Returns, at position s, the eigenshape of a rod that is clamped at s = 0 and free at s = 1. The value of
// the eigenshape at the free end is 2.
double eigenshape(double beta, double s)
{
    double ratio = (std::cosh(beta) + std::cos(beta)) / (std::sinh(beta) + std::sin(beta));
    double u = beta * s;
    return std::cosh(u) - std::cos(u) - ratio * (std::sinh(u) - std::sin(u));
}

struct Oscillation {
    double omega, decay; // rad/s, 1/s
};

// The samples q[n] of every decaying oscillation satisfy q[n+1] = a q[n] + b q[n-1] with two constants a and
// b. We fit the constants a and b by least squares and take the complex root z of the equation z^2 = a z + b.
Oscillation fit(const std::vector<double> &q, double interval_s)
{
    double pp = 0, pr = 0, rr = 0, pq = 0, rq = 0;
    for (std::size_t n = 1; n + 1 < q.size(); n++) {
        pp += q[n] * q[n];
        pr += q[n] * q[n - 1];
        rr += q[n - 1] * q[n - 1];
        pq += q[n] * q[n + 1];
        rq += q[n - 1] * q[n + 1];
    }
    double det = pp * rr - pr * pr, a = (pq * rr - rq * pr) / det, b = (rq * pp - pq * pr) / det;
    std::complex<double> root = (a + std::sqrt(std::complex<double>(a * a + 4 * b))) / 2.0;
    std::complex<double> rate = std::log(root) / interval_s;
    return {std::fabs(rate.imag()), -rate.real()};
}

// Computes how implicit Euler integration with the step h changes an oscillation's angular frequency w and
// drag g, from the roots z of (1 + w^2 h^2) z^2 - (2 - g h) z + (1 - g h) = 0.
Oscillation implicit_euler(double omega)
{
    double a = 1 + omega * omega * step_s * step_s, b = 2 - drag_per_s * step_s, c = 1 - drag_per_s * step_s;
    std::complex<double> z = (b + std::sqrt(std::complex<double>(b * b - 4 * a * c))) / (2 * a);
    std::complex<double> rate = std::log(z) / step_s;
    return {rate.imag(), -rate.real()};
}

// Releases the rod from an eigenshape, and records the amplitude of the eigenshape over time.
std::vector<double> released(double length_m, double bend, double mass, double beta, double stride_s,
                             double for_s)
{
    double element = element_length(length_m, 128);
    Knot knot{.bend_N_m2 = bend, .twist_N_m2 = bend / 1.3, .mass_kg_per_m = mass};
    Rig rig({uniform_tool(knot, element * 140, element)}, nullptr, {{length_m}});
    std::vector<Vector3d> shape;
    std::vector<double> mode;
    for (unsigned i = 0; i < rig.free_count(); i++) {
        double s = 1 - rig.arc(i) / rig.inserted();
        mode.push_back(eigenshape(beta, s));
        shape.push_back({rig.position(i)[0], 0, 0.002 * length_m * mode.back()});
    }
    rig.place(shape);
    std::vector<double> amplitudes;
    int stride = std::max(1, int(std::lround(stride_s / step_s)));
    for (int n = 0; n < for_s / (stride * step_s); n++) {
        double sum = 0, square = 0;
        for (unsigned i = 0; i < rig.free_count(); i++) {
            sum += rig.position(i)[2] * mode[i];
            square += mode[i] * mode[i];
        }
        amplitudes.push_back(sum / square / (0.002 * length_m));
        rig.step(stride);
    }
    return amplitudes;
}

void modes(Result &result, bool quick)
{
    result.title = "Cantilever modes: frequency and damping";
    result.setup = "EI 1.85e-3 N m2, 5 g/m, L 0.25, 0.4, 0.5 m for modes 1, 2, 3, 128 elements, released "
                   "from the eigenshape (0.2 % of L); amplitude fitted "
                   "by a decaying oscillation. The drag of 20/s lets an amplitude decay at 10/s; implicit "
                   "Euler adds about "
                   "omega^2 h / 2, stated per mode. frequency: against the beam; decay: against drag and "
                   "implicit Euler together.";
    result.formula = "f = beta^2 / 2 pi sqrt(EI / rho A L^4), cos beta cosh beta = -1; decay = ln((1 + w^2 "
                     "h^2) / (1 - g h)) / 2h";
    result.source = "Euler-Bernoulli beam; roots of the implicit Euler recursion";
    const double bend = 1.85e-3, mass = 0.005;
    Plot plot{"Amplitude of the first mode", "time (s)", "amplitude / start", {}};
    for (unsigned number : {1u, 2u, 3u}) {
        if (quick && number == 3) continue;
        const double length = number == 1 ? 0.25 : number == 2 ? 0.4 : 0.5;
        double beta = beam_mode(number), omega = beta * beta * std::sqrt(bend / mass) / (length * length);
        double stride = std::floor(0.6 / omega / step_s) * step_s;
        stride = std::max(stride, step_s);
        std::vector<double> q = released(length, bend, mass, beta, stride, 0.25);
        Oscillation ours = fit(q, stride), expected = implicit_euler(omega);
        double damped = std::sqrt(omega * omega - drag_per_s * drag_per_s / 4);
        std::string name = "mode_" + std::to_string(number);
        result.relative("frequency." + name, "Hz", damped / 2 / M_PI, ours.omega / 2 / M_PI, 1.5);
        result.relative("decay." + name, "1/s", expected.decay, ours.decay, 3);
        double numerical = std::log(1 + omega * omega * step_s * step_s) / 2 / step_s;
        result.absolute("decay_by_drag." + name, "1/s", drag_per_s / 2, ours.decay - numerical, 0.5);
        result.reported("numerical_damping." + name, "1/s", omega * omega * step_s / 2,
                        ours.decay - drag_per_s / 2);
        if (number > 1) continue;
        Series dots{"ours", {}, {}, true}, line{"beam with 20/s drag and implicit Euler", {}, {}};
        for (std::size_t n = 0; n < q.size(); n++) {
            double t = double(n) * stride;
            dots.x.push_back(t);
            dots.y.push_back(q[n]);
        }
        for (double t = 0; t < 0.25; t += 0.001) {
            line.x.push_back(t);
            line.y.push_back(std::exp(-expected.decay * t) *
                             (std::cos(expected.omega * t) +
                              expected.decay / expected.omega * std::sin(expected.omega * t)));
        }
        plot.series = {line, dots};
    }
    result.plots.push_back(plot);
}

} // namespace

std::vector<Case> motion_cases()
{
    return {{"modes", modes}};
}

} // namespace crn::validate
