// Models an instrument as a discrete elastic rod (Bergou et al., Discrete Elastic Rods, 2008, and Discrete
// Viscous Threads, 2010). The rod has nodes, and each edge between two nodes has an angle from its reference
// frame to its material frame. SI units, doubles.
//
//     tip                                     hand
//      0 --- 1 --- 2 ---  ...  --- k --- k+1      node i, position x_i, arc s_i from the tip
//         0     1            k-1      k           edge i joins nodes i and i+1; its tangent points forward, to the tip
//
//   bending   1/2 EI / l |kappa - kappa_rest|^2   at a joint; kappa = 2 tan(turn / 2) along the material axes
//   twist     1/2 GJ / l twist^2                  at a joint; twist of the material frames from edge to edge
//   stretch   1/2 EA l (|e| / l - 1)^2            of an edge
#pragma once
#include "shared/wire/wire.h"
#include "tools/lab/reference_rod/band.hpp"
#include <Eigen/Core>
#include <vector>

namespace crn::reference
{

using Vector = Eigen::Vector3d;

// The constants of a rod. The nodes are numbered 0 .. n-1; each of the nodes 1 .. n-2 is a joint between two
// edges.
struct Rod {
    std::vector<double> arc_m;                            // per node, from 0
    std::vector<double> cell_m;                           // per node: half of each edge beside it
    std::vector<double> bend_N_m2, twist_N_m2;            // per node, for its cell
    std::vector<double> rest_curvature1, rest_curvature2; // per node: 2 tan(turn / 2), towards d1 and t x d1
    std::vector<double> radius_m;                         // per node, outer
    std::vector<double>
        joint_m; // per node: the part of its cell that can bend; less than the cell at the end of a sheath
    std::vector<double> stretch_N; // per edge: EA

    int nodes() const { return static_cast<int>(arc_m.size()); }
    double length_m(int edge) const { return arc_m[edge + 1] - arc_m[edge]; }
};

// States the lengths of the edges into which an instrument is divided.
struct Cut {
    double tip_m = 0.25e-3, shaft_m = 0.75e-3; // longest edge at the tip, and elsewhere
    double fine_m = 0.0; // length from the tip; 0: to 5 mm behind the tip's curves, at least 20 mm
    // The axial stiffness EA is stretch * EI / edge^2, where `edge` is the edge's length, and EI is the
    // smaller one of the values at its two ends. In a bend of radius R the axial force is EI / R^2, which
    // shortens an edge of length h by the fraction (h / R)^2 / stretch of its length, where `stretch` is the
    // factor between EA and EI / h^2. The fraction (h / R)^2 / stretch by which the force shortens an edge is
    // 3e-5 for an edge of h = 2 mm and a bend of R = 50 mm. A higher value of `stretch` would only increase
    // the number of iterations.
    double stretch = 64.0;
};

// Makes a rod from the first `length_m` of the instrument, plus two edges that stay inside the sheath. Throws
// std::invalid_argument when the instrument is shorter than the needed length.
Rod cut_rod(const crn_wire_instrument &table, double length_m, const Cut &cut);
// Returns the outer radius of an instrument, in m, at a given distance from its tip.
double radius_at_m(const crn_wire_instrument &table, double arc_m);
// Makes a uniform straight rod.
Rod uniform_rod(double bend_N_m2, double twist_N_m2, double radius_m, double length_m, double edge_m);

// The shape of the rod.
struct State {
    std::vector<Vector> x;       // per node
    std::vector<double> angle;   // per edge, from the reference axis to d1
    std::vector<Vector> tangent; // per edge, unit, forward
    std::vector<Vector> axis;    // per edge: first reference axis, unit, across the tangent
    std::vector<double>
        reference; // per joint (index of its node): twist of the reference frames, rear to front edge

    // Makes a straight rod with its tip at x, along the unit vector `forward`; the material axis d1 of every
    // edge is the unit vector `d1`.
    static State straight(const Rod &rod, const Vector &tip, const Vector &forward, const Vector &d1);
    Vector d1(int edge) const;
};

// Computes the rod's state for new positions and angles; the reference frame of each edge follows the edge's
// tangent by the smallest rotation.
void move_state(const State &from, const std::vector<Vector> &x, const std::vector<double> &angle, int nodes,
                State &to);

// Returns the elastic energy, in J, of the nodes 0 .. nodes-1 and of the joints between them. The function
// adds the energy's first derivatives (4 per node: x, y, z, and the angle of the edge behind the node) and,
// if requested, its second derivatives.
double elastic_energy(const Rod &rod, const State &state, int nodes, Eigen::VectorXd *slope, Band *second);

} // namespace crn::reference
