// Finds the position in which the rod is at rest under wall forces, friction and loads. The search minimises
// an incremental potential (Li et al., Incremental Potential Contact, 2020, section 5) by Newton's method.
//
//   wall       k l p^2 / 2 per node; p = depth of its surface in the wall, l = its cell. The first `onset` is cubic, so
//              that second derivatives are continuous. k per length is far above what bends the rod into the
//              wall.
//   friction   mu N f(u); u = the node's displacement along the wall from its anchor, f = smoothed |u|: the force is
//              mu N (2u/e - u^2/e^2) below e, and mu N above. N and the wall's normal are held (lagged) while
//              Newton's method finds the minimum. They are renewed until they are those of the minimum. An
//              anchor is dragged along where u > e, so that a rod at rest does not creep.
#pragma once
#include "tools/lab/reference_rod/rod.hpp"
#include "tools/lab/vcsim3/lumen.hpp"
#include <functional>

namespace crn::reference
{

namespace lumen = vcsim3; // we share only the baked field in doubles with that rod

// Returns the distance of a point from the wall (negative inside the lumen), with its gradient and second
// derivatives.
using Wall = std::function<lumen::LumenField(const Vector &)>;

struct Physics {
    Wall wall;                  // empty: free space
    double friction = 0.0;      // Coulomb's coefficient of every node against the wall
    double wall_N_per_m2 = 5e7; // k
    double onset_m = 1e-5;      // depth over which the wall's force begins gradually
    double slip_m = 2e-5;       // e
    std::vector<Vector> load_N; // dead loads per node; empty: none
    double residual_N = 1e-5;   // the rod is at rest when no node's force is above this
    int iterations_max = 600;
};

// Holds the state of friction at one node of the rod between two steps of the insertion.
struct Anchor {
    Vector at = Vector::Zero();
    Vector normal = Vector::Zero(); // normal of the wall, outward
    double limit_N = 0.0;           // mu N
};

struct Outcome {
    bool at_rest = false;
    int iterations = 0;
    double residual_N = 0.0; // largest remaining force at a free node
    double depth_m = 0.0;    // depth of the deepest contact
    Eigen::VectorXd slope;   // slope of the energy at every unknown; at held ones it is the holding force
};

// Moves nodes 0 .. free-1 and edges 0 .. free-1 of the rod until they are at rest. Nodes free .. count-1 and
// their edges keep their positions.
Outcome find_rest(const Rod &rod, const Physics &physics, int free, int count, std::vector<Anchor> &anchors,
                  State &state);

// Moves the friction anchor of every node that slid along the wall or left the wall in this step of the
// insertion. The friction anchor is the point to which friction pulls a node back.
void drag_anchors(const Rod &rod, const Physics &physics, int free, const State &state,
                  std::vector<Anchor> &anchors);

// The wall's normal force on a node, N.
double wall_force_N(const Rod &rod, const Physics &physics, int node, const State &state);

} // namespace crn::reference
