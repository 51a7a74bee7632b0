// Computes the motion of a scene's vessels in SI units with double precision, from the same lattice that the
// core evaluates in fixed point (docs/heart.md).
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

// Holds the phases of heartbeat and breath as the core reports them.
struct MotionMoment {
    std::uint32_t heart_phase32 = 0, breath_phase32 = 0;
    bool operator==(const MotionMoment &) const = default;
};

// Holds the weights of three consecutive keyframes of the heartbeat for one moment (quadratic B-spline,
// periodic), and the depth of breath, 0 .. 1.
struct MotionWeights {
    int first = 0;
    double weights[3] = {0.125, 0.75, 0.125};
    double breath = 0.0;
};
MotionWeights motion_weights(const MotionMoment &moment);

// Computes coefficients c, one per keyframe, of the periodic spline through w: (c[k-1] + 6 c[k] + c[k+1]) / 8
// = w[k]. Each of the 20 Gauss-Seidel rounds reduces the error by a factor of 9.
void motion_prefilter(const double *w, double *c);

// Does the same for six sequences at once, which takes a sixth of the time: the processor need not wait for a
// quotient of one sequence before it begins the next. Each sequence gets the same bits as alone.
inline constexpr int motion_ways = 6; // the three coordinates without breath, and what a full breath adds
using MotionWays = std::array<std::array<double, motion_ways>, motion_keyframes>; // by keyframe
MotionWays motion_prefilter(const MotionWays &w);

// Returns the weight of one corner of a lattice cell (bits x, y, z of `corner`) for a position in the cell (0
// .. 1 along each axis). The lattice's displacement is linear in each of the six tetrahedra into which a cell
// is divided. In each tetrahedron, a path of cell edges leads from corner 0 along the axes, beginning with
// the axis of the largest coordinate (Kuhn's division, which is used for the breath's lattice).
double motion_plane_weight(int corner, const Eigen::Vector3d &place);

class Motion
{
  public:
    explicit Motion(const crn_scene &scene); // requires a checked scene with motion; copies its lattices
    bool breathes() const { return breath_.has_value(); }

    // Returns the position in the reference pose of the material that is now at x.
    Eigen::Vector3d pull(const Eigen::Vector3d &x_m, const MotionMoment &moment) const;
    // Returns the present position of the material that lies at X in the reference pose. The error of the
    // returned position is below 1 um where the lattice does not fold over itself.
    Eigen::Vector3d push(const Eigen::Vector3d &X_m, const MotionMoment &moment) const;

  private:
    // Holds a lattice of nodes. At each node of the lattice, `row` numbers are stored for each of the three
    // components of the displacement.
    struct Lattice {
        explicit Lattice(const crn_scene_motion &scene, std::size_t row);
        // Finds the lattice node at corner 0 of the cell that contains a position, the strides to the other
        // corners, and the position inside the cell. Returns false outside the lattice.
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

// Reads the MOTION section of a scene file, which describes how vessels move. Returns no motion when the file
// has no MOTION section. If the MOTION section cannot be read, the function returns no motion, and `error`
// has a message.
std::optional<Motion> read_motion(const std::string &scene_path, std::string &error);

// Holds points that move with the lattice of heart and breath. The lattice is evaluated at each point only
// once, for all keyframes, without breath and with a full breath. After the lattice has been evaluated,
// computing the position of a point at a moment takes only a few products. Between keyframes the position
// follows a spline through the moved positions, which is within 0.05 mm of the lattice's own map.
class MovingPoints
{
  public:
    MovingPoints(const Motion &motion, std::vector<Eigen::Vector3d> reference_m);
    std::size_t size() const { return reference_m_.size(); }
    bool moves(std::size_t i) const { return moves_[i]; }
    // Returns the displacement of point i from the reference pose, in um; the result is 0 for a point that
    // never moves.
    Eigen::Vector3f way_um(std::size_t i, const MotionWeights &weights) const;
    // Writes the present positions of all points, in whole um: `reference_um` plus the rounded displacements.
    // Both lists have size() points.
    void place(const MotionWeights &weights, std::span<const Eigen::Vector3i> reference_um,
               std::span<Eigen::Vector3i> to_um) const;
    Eigen::Vector3d at(std::size_t i, const MotionWeights &weights) const
    {
        return reference_m_[i] + way_um(i, weights).cast<double>() * 1e-6;
    }

  private:
    std::size_t parts() const { return breathes_ ? 2 : 1; }
    std::size_t plane(std::size_t keyframe, std::size_t part) const;
    auto blend(std::size_t point, std::size_t count, std::size_t part, const MotionWeights &weights) const;

    std::vector<Eigen::Vector3d> reference_m_;
    std::vector<bool> moves_;
    bool breathes_;
    // Holds the displacements at keyframe 23, at keyframes 0 to 23, and at keyframe 0 again, because the
    // heartbeat is periodic. The list begins with the displacements of all points without breath, followed by
    // the difference that a full breath makes. The points of one keyframe are adjacent in memory, because
    // each moment needs three keyframes of all points.
    std::vector<float> ways_um_;
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
    // The list that this function returns is valid until the next call.
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
