// The rod at rest among its wall, friction and loads: the minimum of an incremental potential (Li et al.,
// Incremental Potential Contact, 2020, section 5), by Newton's method.
//
//   wall       k l p^2 / 2 per node, p = depth of its surface in the wall, l = its cell; the first `onset` is cubic, so
//              that second derivatives are continuous. k per length is far above what bends the rod into the
//              wall.
//   friction   mu N f(u), u = the node's way along the wall from its anchor, f = smoothed |u|: mu N (2u/e - u^2/e^2) in force
//              below e, mu N above. N and the wall's normal are held (lagged) while Newton's method finds the
//              minimum, then renewed, until they are those of the minimum. An anchor is dragged along where u
//              > e, so that a rod at rest does not creep.
#pragma once
#include "tools/lab/reference_rod/rod.hpp"
#include "tools/lab/vcsim3/lumen.hpp"
#include <functional>

namespace crn::reference
{

namespace lumen = vcsim3; // the baked field in doubles is all that is shared with that rod

// The wall's distance (negative inside), gradient and second derivatives at a place.
using Wall = std::function<lumen::LumenField(const Vector &)>;

struct Physics {
    Wall wall;                  // empty: free space
    double friction = 0.0;      // Coulomb's, of every node against the wall
    double wall_N_per_m2 = 5e7; // k
    double onset_m = 1e-5;      // of the wall
    double slip_m = 2e-5;       // e
    std::vector<Vector> load_N; // dead loads per node; empty: none
    double residual_N = 1e-5;   // at rest when no node's force is above this
    int iterations_max = 600;
};

// What friction remembers of a node.
struct Anchor {
    Vector at = Vector::Zero();
    Vector normal = Vector::Zero(); // of the wall, outward
    double limit_N = 0.0;           // mu N
};

struct Outcome {
    bool at_rest = false;
    int iterations = 0;
    double residual_N = 0.0; // largest force left over at a free node
    double depth_m = 0.0;    // deepest contact
    Eigen::VectorXd slope;   // of the energy at every unknown, also the held ones: what holds them
};

// Brings nodes 0 .. free-1 and edges 0 .. free-1 to rest. Nodes free .. count-1 and their edges stay where
// they are.
Outcome find_rest(const Rod &rod, const Physics &physics, int free, int count, std::vector<Anchor> &anchors,
                  State &state);

// After a step: anchors follow their nodes where those slid or are off the wall.
void drag_anchors(const Rod &rod, const Physics &physics, int free, const State &state,
                  std::vector<Anchor> &anchors);

// Wall's normal force on a node, N.
double wall_force_N(const Rod &rod, const Physics &physics, int node, const State &state);

} // namespace crn::reference
