// Computes reference solutions in double precision without the core: by shooting methods, closed forms and
// characteristic equations.
#pragma once
#include <functional>
#include <vector>

namespace crn::validate
{

// Holds the shape of a rod that bends in a plane and is clamped at s = 0 along x. Lengths are divided by the
// rod's length L, and forces by EI/L^2.
struct PlaneShape {
    std::vector<double> x, y, angle; // at s = i / (size - 1)
};

// Computes the inextensible elastica under a tip load and a load per length, which are constant and point
// towards -y. A shooting method solves theta' = M, M' = (P + w (1 - s)) cos(theta), M(1) = 0 for the angle
// theta and the moment M along the rod, with the tip load P and the load w per length. The function raises
// the loads in steps from zero.
PlaneShape elastica(double tip_load, double line_load);

// Computes the shape of a cantilever in closed form, with elliptic integrals. The constant tip load points
// towards the clamp and exceeds Euler's critical load.
struct Buckled {
    double x, y, angle; // of the tip
};
Buckled buckled_cantilever(double load); // load > pi^2 / 4

// Returns a root of the function f between two given values, at which f has opposite signs.
double root(const std::function<double(double)> &f, double low, double high);

double beam_mode(unsigned number);         // beta of a cantilever's mode 1, 2, 3: cos b cosh b = -1
double euler_clamped_pinned();             // u = L sqrt(P/EI): tan u = u
double euler_spring_pinned(double spring); // the same with a torsional spring k L / EI at the other end
// Computes the critical thrust of a rod with two spans. The first span reaches from a clamp to a support at
// distance `a`; the second span, of length `d`, ends at another support. The rod with two spans is free to
// turn at each of its two supports. Returns sqrt(P/EI).
double euler_two_spans(double a, double d);
double greenhill(); // M L / B of a rod clamped at both ends

// Computes how a long twisted rod with clamped ends coils (van der Heijden and Thompson 2000; van der
// Heijden, Neukirch, Goss, Thompson 2003). The inputs are the slack d = 1 - distance / L (from the distance
// of the ends and the rod's length L), the rotation of one end in radians, and `bend_over_twist`, the ratio B
// / C of the bending to the torsional stiffness. The function returns the end moment divided by B/L, and the
// tension divided by B/L^2, where B is the bending stiffness and L the rod's length.
struct Writhe {
    double moment, tension;
};
Writhe writhe(double slack, double turn_rad, double bend_over_twist);

} // namespace crn::validate
