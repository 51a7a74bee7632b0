// Reference solutions in double precision that do not use the core: shooting, closed forms and characteristic
// equations.
#pragma once
#include <functional>
#include <vector>

namespace crn::validate
{

// A plane rod clamped at s = 0 along x, lengths over L, forces over EI/L^2.
struct PlaneShape {
    std::vector<double> x, y, angle; // at s = i / (size - 1)
};

// The inextensible elastica under a dead tip load and a dead load per length, both transverse (towards -y),
// by shooting: theta' = M, M' = (P + w (1 - s)) cos(theta), M(1) = 0. Loads are raised in steps from zero.
PlaneShape elastica(double tip_load, double line_load);

// A cantilever pressed at its tip towards the clamp by a dead load above Euler's, in closed form with
// elliptic integrals.
struct Buckled {
    double x, y, angle; // of the tip
};
Buckled buckled_cantilever(double load); // load > pi^2 / 4

// A root of f between two values of opposite sign.
double root(const std::function<double(double)> &f, double low, double high);

double beam_mode(unsigned number);         // beta of a cantilever's mode 1, 2, 3: cos b cosh b = -1
double euler_clamped_pinned();             // u = L sqrt(P/EI): tan u = u
double euler_spring_pinned(double spring); // the same with a torsional spring k L / EI at the other end
// Computes the thrust through two spans: a clamp, a support after `a`, and another at the end after `d` more,
// both free to turn. Returns sqrt(P/EI).
double euler_two_spans(double a, double d);
double greenhill(); // M L / B of a rod clamped at both ends

// Writhing of a long twisted rod with clamped ends, slack d = 1 - distance / L and end turn R radians, with B
// / C = `bend_over_twist` (van der Heijden and Thompson 2000; van der Heijden, Neukirch, Goss, Thompson
// 2003). The results are the end moment over B/L and the tension over B/L^2.
struct Writhe {
    double moment, tension;
};
Writhe writhe(double slack, double turn_rad, double bend_over_twist);

} // namespace crn::validate
