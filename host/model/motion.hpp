// Computes the motion of a scene's vessels in SI doubles, from the same lattice that the core evaluates in
// fixed point (docs/heart.md).
//
//   const auto motion = read_motion("heart.scene", error);     // nullopt with an empty error: it does not move
//   X = motion->pull(x, moment); x = motion->push(X, moment);
//   MovingBodies bodies(*motion, all_bodies);
//   bodies.at({wire.heart_phase32, wire.breath_phase32});       // vertices of the moving bodies
//   MovingPoints points(*motion, places); points.at(moment);
#pragma once
#include "host/model/bodies.hpp"
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

struct crn_scene;
struct crn_scene_motion;

namespace crn
{

inline constexpr int motion_keyframes = 24;

// Holds the phases of heart and breath as the core gives them.
struct MotionMoment {
    std::uint32_t heart_phase32 = 0, breath_phase32 = 0;
    bool operator==(const MotionMoment &) const = default;
};

// Holds the weights of three consecutive keyframe columns in a row (quadratic B-spline, periodic), and the
// depth of breath, 0 .. 1.
struct MotionWeights {
    int first = 0;
    double weights[3] = {0.125, 0.75, 0.125};
    double breath = 0.0;
};
MotionWeights motion_weights(const MotionMoment &moment);

// Computes coefficients c, one per keyframe, of the periodic spline that passes through w: (c[k-1] + 6 c[k] +
// c[k+1]) / 8 = w[k]. The method is Gauss-Seidel with 20 rounds, each of which reduces the error by a factor
// of 9.
void motion_prefilter(const double *w, double *c);

// Returns the weight of a cell's corner (bits x, y, z) at a place in the cell (0 .. 1). The displacement is
// linear in each of the six tetrahedra into which the cell is divided. The path from corner 0 follows first
// the axis with the largest fraction (Kuhn's division; the breath's field uses it).
double motion_plane_weight(int corner, const Eigen::Vector3d &place);

class Motion
{
  public:
    explicit Motion(const crn_scene &scene); // requires a checked scene with motion; copies its lattices
    bool breathes() const { return breath_.has_value(); }

    // Returns where the material that is at x now lies in the reference pose.
    Eigen::Vector3d pull(const Eigen::Vector3d &x_m, const MotionMoment &moment) const;
    // Returns where the material at X in the reference pose is now. The error is below 1 um where the lattice
    // does not fold over itself.
    Eigen::Vector3d push(const Eigen::Vector3d &X_m, const MotionMoment &moment) const;

  private:
    // Holds one lattice of nodes; each node has `row` numbers for each of three components.
    struct Lattice {
        explicit Lattice(const crn_scene_motion &scene, std::size_t row);
        // Finds the node at corner 0 of the cell that contains a place, the strides to the other corners, and
        // the place inside the cell. Returns false outside the lattice.
        bool find(const Eigen::Vector3d &x_m, std::size_t &node, Eigen::Vector3d &place) const;
        std::size_t corner(std::size_t node, unsigned corner) const;

        std::array<double, 3> origin_m{};
        std::array<int, 3> count{};
        double spacing_m = 1.0;
        std::vector<std::int16_t> rows;
    };
    Eigen::Vector3d beat_way(const Eigen::Vector3d &x_m, const MotionWeights &weights) const;
    Eigen::Vector3d breath_way(const Eigen::Vector3d &x_m, double depth) const;

    Lattice beat_;
    std::optional<Lattice> breath_;
};

// Reads the MOTION section of a scene file. Returns nothing when there is no such section. When it cannot be
// read, `error` has a message too.
std::optional<Motion> read_motion(const std::string &scene_path, std::string &error);

// Holds places that move with the lattice. The lattice is evaluated at each place only once, for all
// keyframes, at rest and inhaled. After that, the place at a moment costs a few products. Between keyframes
// the result is a spline through the moved places; it is within 0.05 mm of the lattice's own map.
class MovingPoints
{
  public:
    MovingPoints(const Motion &motion, std::vector<Eigen::Vector3d> reference_m);
    std::size_t size() const { return reference_m_.size(); }
    bool moves(std::size_t i) const { return moves_[i]; }
    // Returns the displacement of place i from the reference pose, um; 0 0 0 for a place that never moves.
    Eigen::Vector3f way_um(std::size_t i, const MotionWeights &weights) const;
    Eigen::Vector3d at(std::size_t i, const MotionWeights &weights) const
    {
        return reference_m_[i] + way_um(i, weights).cast<double>() * 1e-6;
    }

  private:
    Eigen::Vector3f blend(const float *first, std::size_t step, const MotionWeights &weights) const;

    std::vector<Eigen::Vector3d> reference_m_;
    std::vector<bool> moves_;
    bool breathes_;
    // Holds the displacements of each place at keyframes 23, 0 .. 23, 0: at rest and, if the place moves with
    // breath, the difference that a full breath adds. The keyframes of one place are adjacent in memory,
    // because a moment needs three neighbouring ones.
    std::vector<float> coefficients_um_;
};

// Holds bodies whose vertices move with the lattice.
class MovingBodies
{
  public:
    MovingBodies(const Motion &motion, const Bodies &bodies);
    bool is_empty() const { return moving_.empty(); }

    struct Moved {
        int body = 0; // index in Bodies
        std::span<const Eigen::Vector3i> vertices_um;
    };
    // The returned list is valid until the next call.
    const std::vector<Moved> &at(const MotionMoment &moment);

  private:
    struct Body {
        int index;
        MovingPoints points;
        std::vector<Eigen::Vector3i> reference_um, vertices_um;
    };
    std::vector<Body> moving_;
    std::vector<Moved> moved_;
};

} // namespace crn
