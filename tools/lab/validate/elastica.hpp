// Reference solutions in double precision, made without the core: shooting, closed forms and characteristic
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

// Inextensible elastica under a dead tip load and a dead load per length, both across (towards -y), by
// shooting: theta' = M, M' = (P + w (1 - s)) cos(theta), M(1) = 0. Loads are raised in steps from zero.
PlaneShape elastica(double tip_load, double line_load);

// Cantilever pressed at its tip towards the clamp by a dead load above Euler's: closed form with elliptic
// integrals.
struct Buckled {
    double x, y, angle; // of the tip
};
Buckled buckled_cantilever(double load); // load > pi^2 / 4

// Root of f between two values of opposite sign.
double root(const std::function<double(double)> &f, double low, double high);

double beam_mode(unsigned number);         // beta of a cantilever's mode 1, 2, 3: cos b cosh b = -1
double euler_clamped_pinned();             // u = L sqrt(P/EI): tan u = u
double euler_spring_pinned(double spring); // the same with a turning spring k L / EI at the other end
// Thrust through two spans: clamped, a support after `a`, another at the end after `d` more, both free to
// turn. sqrt(P/EI).
double euler_two_spans(double a, double d);
double greenhill(); // M L / B of a rod clamped at both ends

// Writhing of a long twisted rod with clamped ends, slack d = 1 - distance / L and R radians of end turn, B /
// C = `bend_over_twist` (van der Heijden and Thompson 2000; van der Heijden, Neukirch, Goss, Thompson 2003):
// end moment over B/L and tension over B/L^2.
struct Writhe {
    double moment, tension;
};
Writhe writhe(double slack, double turn_rad, double bend_over_twist);

} // namespace crn::validate
