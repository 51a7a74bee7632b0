#include "host/model/motion.hpp"
#include "host/model/scene_reading.hpp"
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace crn
{
namespace
{

constexpr double q30 = 0x1p-30;
constexpr double unit_m = 0x1p-19; // of a coefficient: 2^11 / 2^30
constexpr std::size_t row_numbers = CRN_SCENE_MOTION_ROW;
constexpr int rounds = 20;                         // of the prefilter
constexpr std::size_t kept = motion_keyframes + 2; // keyframes stored for a moved vertex: 23, 0 .. 23, 0

// Filters `ways` sequences at once, keyframe by keyframe.
template <std::size_t ways> void prefilter(const std::array<double, ways> *w, std::array<double, ways> *c)
{
    constexpr int n = motion_keyframes;
    std::copy_n(w, n, c);
    for (int round = 0; round < rounds; ++round)
        for (int k = 0; k < n; ++k) {
            const auto &before = c[(k + n - 1) % n], &after = c[(k + 1) % n];
            for (std::size_t way = 0; way < ways; ++way)
                c[k][way] = (8 * w[k][way] - before[way] - after[way]) / 6;
        }
}

} // namespace

void motion_prefilter(const double *w, double *c)
{
    std::array<std::array<double, 1>, motion_keyframes> in, out;
    for (int k = 0; k < motion_keyframes; ++k) in[k][0] = w[k];
    prefilter(in.data(), out.data());
    for (int k = 0; k < motion_keyframes; ++k) c[k] = out[k][0];
}

MotionWays motion_prefilter(const MotionWays &w)
{
    MotionWays c;
    prefilter(w.data(), c.data());
    return c;
}

MotionWeights motion_weights(const MotionMoment &moment)
{
    MotionWeights result;
    const double place = moment.heart_phase32 * 0x1p-32 * motion_keyframes + 0.5;
    const double f = place - std::floor(place);
    result.first = static_cast<int>(place) % motion_keyframes;
    result.weights[0] = 0.5 * (1 - f) * (1 - f);
    result.weights[2] = 0.5 * f * f;
    result.weights[1] = 1 - result.weights[0] - result.weights[2];
    const double sine = std::sin(std::numbers::pi * (moment.breath_phase32 * 0x1p-32));
    result.breath = sine * sine * sine * sine;
    return result;
}

double motion_plane_weight(int corner, const Eigen::Vector3d &place)
{
    // In Kuhn's division of a cell, each tetrahedron belongs to a path along the cell's edges from corner 0,
    // first along the axis on which the position has its largest coordinate. A corner of a cell therefore
    // belongs to the position's tetrahedron only if the position's coordinates along the axes that lead to
    // this corner are larger than its other coordinates. The weight of a corner is the smallest coordinate
    // along the axes that lead to it, minus the largest of the other coordinates.
    double least = 1, most = 0;
    for (int k = 0; k < 3; ++k) {
        if ((corner >> k & 1) != 0)
            least = std::min(least, place[k]);
        else
            most = std::max(most, place[k]);
    }
    return std::max(0.0, least - most);
}

Motion::Lattice::Lattice(const crn_scene_motion &scene, std::size_t row)
{
    std::size_t nodes = 1;
    for (std::size_t k = 0; k < 3; ++k) {
        origin_m[k] = scene.origin_m_q30[k] * q30;
        count[k] = scene.node_count_xyz[k];
        nodes *= scene.node_count_xyz[k];
    }
    spacing_m = std::ldexp(q30, scene.spacing_log2_q30);
    rows.assign(scene.rows, scene.rows + nodes * 3 * row);
}

bool Motion::Lattice::find(const Eigen::Vector3d &x_m, std::size_t &node, Eigen::Vector3d &place) const
{
    std::size_t cell[3];
    for (std::size_t k = 0; k < 3; ++k) {
        const double from = (x_m[static_cast<int>(k)] - origin_m[k]) / spacing_m;
        if (!(from >= 0 && from < count[k] - 1)) return false;
        cell[k] = static_cast<std::size_t>(from);
        place[static_cast<int>(k)] = from - static_cast<double>(cell[k]);
    }
    node = (cell[2] * static_cast<std::size_t>(count[1]) + cell[1]) * static_cast<std::size_t>(count[0]) +
           cell[0];
    return true;
}

std::size_t Motion::Lattice::corner(std::size_t node, unsigned corner) const
{
    const auto nx = static_cast<std::size_t>(count[0]), ny = static_cast<std::size_t>(count[1]);
    return node + (corner & 1u) + ((corner >> 1 & 1u) + (corner >> 2) * ny) * nx;
}

Motion::Motion(const crn_scene &scene) : beat_(scene.motion, row_numbers)
{
    if (scene.has_breath) breath_.emplace(scene.breath, 1);
}

Eigen::Vector3d Motion::beat_way(const Eigen::Vector3d &x_m, const MotionWeights &at) const
{
    std::size_t node = 0;
    Eigen::Vector3d place, sum = Eigen::Vector3d::Zero();
    if (!beat_.find(x_m, node, place)) return sum;
    for (unsigned corner = 0; corner < 8; ++corner) {
        double weight = 1;
        for (int k = 0; k < 3; ++k) weight *= (corner >> k & 1u) != 0 ? place[k] : 1 - place[k];
        const std::int16_t *taps =
            beat_.rows.data() + beat_.corner(node, corner) * 3 * row_numbers + at.first;
        for (int k = 0; k < 3; ++k, taps += row_numbers)
            sum[k] += weight * (taps[0] * at.weights[0] + taps[1] * at.weights[1] + taps[2] * at.weights[2]);
    }
    return sum * unit_m;
}

Eigen::Vector3d Motion::breath_way(const Eigen::Vector3d &x_m, double depth) const
{
    std::size_t node = 0;
    Eigen::Vector3d place, sum = Eigen::Vector3d::Zero();
    if (!breath_ || depth == 0 || !breath_->find(x_m, node, place)) return sum;
    for (unsigned corner = 0; corner < 8; ++corner) {
        const double weight = motion_plane_weight(static_cast<int>(corner), place);
        if (weight == 0) continue;
        const std::int16_t *inhaled = breath_->rows.data() + breath_->corner(node, corner) * 3;
        sum += weight * Eigen::Vector3d(inhaled[0], inhaled[1], inhaled[2]);
    }
    return sum * (depth * unit_m);
}

Eigen::Vector3d Motion::pull(const Eigen::Vector3d &x_m, const MotionMoment &moment) const
{
    const MotionWeights at = motion_weights(moment);
    const Eigen::Vector3d rest_m = x_m + breath_way(x_m, at.breath);
    return rest_m + beat_way(rest_m, at);
}

namespace
{

// Solves x = X - w(x) for the position x by fixed-point iteration, where X is the point in the reference pose
// and w the lattice's displacement. The iteration converges because the displacement w changes by less than x
// does. Each round of the iteration multiplies the error by the gradient of w, which is a third in the
// lattice of a heart.
template <typename Way> Eigen::Vector3d undo(const Eigen::Vector3d &X_m, const Way &way)
{
    constexpr int rounds_max = 40;
    constexpr double enough_m = 2e-7;
    Eigen::Vector3d x = X_m;
    for (int round = 0; round < rounds_max; ++round) {
        const Eigen::Vector3d next = X_m - way(x);
        const double step = (next - x).cwiseAbs().maxCoeff();
        x = next;
        if (step < enough_m) break;
    }
    return x;
}

} // namespace

Eigen::Vector3d Motion::push(const Eigen::Vector3d &X_m, const MotionMoment &moment) const
{
    const MotionWeights at = motion_weights(moment);
    const Eigen::Vector3d rest_m = undo(X_m, [&](const Eigen::Vector3d &x_m) { return beat_way(x_m, at); });
    return undo(rest_m, [&](const Eigen::Vector3d &x_m) { return breath_way(x_m, at.breath); });
}

std::optional<Motion> read_motion(const std::string &scene_path, std::string &error)
{
    using Read = std::optional<Motion>;
    return from_scene<Read>(scene_path, error, [](const crn_scene &scene) {
        return scene.has_motion ? Read(Motion(scene)) : Read();
    });
}

MovingPoints::MovingPoints(const Motion &motion, std::vector<Eigen::Vector3d> reference_m)
    : reference_m_(std::move(reference_m)), breathes_(motion.breathes())
{
    ways_um_.resize(kept * parts() * 3 * size());
    for (std::size_t point = 0; point < size(); ++point) {
        const Eigen::Vector3d &X_m = reference_m_[point];
        MotionWays way_um;
        bool moves = false;
        for (int key = 0; key < motion_keyframes; ++key) {
            MotionMoment moment;
            moment.heart_phase32 = static_cast<std::uint32_t>((std::uint64_t(key) << 32) / motion_keyframes);
            const Eigen::Vector3d rest = motion.push(X_m, moment);
            moment.breath_phase32 = 1u << 31;
            const Eigen::Vector3d inhaled = breathes_ ? motion.push(X_m, moment) : rest;
            moves = moves || rest != X_m || inhaled != X_m;
            for (int k = 0; k < 3; ++k) {
                way_um[key][k] = (rest[k] - X_m[k]) * 1e6;
                way_um[key][3 + k] = (inhaled[k] - rest[k]) * 1e6;
            }
        }
        moves_.push_back(moves);
        if (!moves) continue; // its ways are 0 already
        const MotionWays c = motion_prefilter(way_um);
        for (std::size_t column = 0; column < 3 * parts(); ++column)
            for (std::size_t i = 0; i < kept; ++i)
                ways_um_[plane(i, column / 3) + 3 * point + column % 3] =
                    static_cast<float>(c[(i + motion_keyframes - 1) % motion_keyframes][column]);
    }
}

// Returns the index at which the displacements of all points begin in the list, for a keyframe and a part.
// Part 0 is the displacement without breath, and part 1 is the difference that a full breath makes.
std::size_t MovingPoints::plane(std::size_t keyframe, std::size_t part) const
{
    return (keyframe * parts() + part) * 3 * size();
}

// Blends three consecutive keyframes of the displacements of `count` points.
auto MovingPoints::blend(std::size_t point, std::size_t count, std::size_t part,
                         const MotionWeights &weights) const
{
    using Ways = Eigen::Map<const Eigen::ArrayXf>;
    const auto ways = [&](int k) {
        const std::size_t keyframe = static_cast<std::size_t>(weights.first + k);
        return Ways(ways_um_.data() + plane(keyframe, part) + 3 * point,
                    static_cast<Eigen::Index>(3 * count));
    };
    return static_cast<float>(weights.weights[0]) * ways(0) +
           static_cast<float>(weights.weights[1]) * ways(1) +
           static_cast<float>(weights.weights[2]) * ways(2);
}

Eigen::Vector3f MovingPoints::way_um(std::size_t i, const MotionWeights &weights) const
{
    if (!moves_[i]) return Eigen::Vector3f::Zero();
    Eigen::Vector3f way = blend(i, 1, 0, weights);
    if (breathes_ && weights.breath > 0)
        way.array() += static_cast<float>(weights.breath) * blend(i, 1, 1, weights);
    return way;
}

// Returns the number that must be added before a truncation, so that the result is rounded half away from
// zero. Adding this number is faster than a call of std::lround, which matters because a heart has 100 000
// vertices. The added number is the largest float below 0.5, so that the sum does not round up a value just
// below a half. Requires a size below 2^23.
static float half_of(float value)
{
    return std::copysign(0x1.fffffep-2f, value);
}

// The numbers of all points are adjacent in memory, so the compiler can compute a block of constant size with
// vector instructions.
void MovingPoints::place(const MotionWeights &weights, std::span<const Eigen::Vector3i> reference_um,
                         std::span<Eigen::Vector3i> to_um) const
{
    constexpr int block = 16;
    const bool is_inhaled = breathes_ && weights.breath > 0;
    const auto breath = static_cast<float>(weights.breath);
    std::array<float, 3> weight;
    std::array<const float *, 3> rest, inhaled;
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t keyframe = static_cast<std::size_t>(weights.first) + k;
        weight[k] = static_cast<float>(weights.weights[k]);
        rest[k] = ways_um_.data() + plane(keyframe, 0);
        inhaled[k] = is_inhaled ? ways_um_.data() + plane(keyframe, 1) : nullptr;
    }
    const int *from = reference_um.data()->data();
    int *to = to_um.data()->data();
    const auto blended = [&](const std::array<const float *, 3> &ways, std::size_t i) {
        return weight[0] * ways[0][i] + weight[1] * ways[1][i] + weight[2] * ways[2][i];
    };
    const auto place_numbers = [&](std::size_t begin, std::size_t count) {
        std::array<float, block> way;
        for (std::size_t i = 0; i < count; ++i) way[i] = blended(rest, begin + i);
        if (is_inhaled)
            for (std::size_t i = 0; i < count; ++i) way[i] += breath * blended(inhaled, begin + i);
        for (std::size_t i = 0; i < count; ++i) way[i] += half_of(way[i]);
        if (count == block)
            Eigen::Array<int, block, 1>::Map(to + begin) =
                Eigen::Array<int, block, 1>::Map(from + begin) +
                Eigen::Array<float, block, 1>::Map(way.data()).cast<int>();
        else
            for (std::size_t i = 0; i < count; ++i)
                to[begin + i] = from[begin + i] + static_cast<int>(way[i]);
    };
    const std::size_t numbers = 3 * size();
    std::size_t begin = 0;
    for (; begin + block <= numbers; begin += block) place_numbers(begin, block);
    place_numbers(begin, numbers - begin);
}

MovingBodies::MovingBodies(const Motion &motion, const Bodies &bodies)
{
    for (std::size_t index = 0; index < bodies.bodies.size(); ++index) {
        const crn::Body &body = bodies.bodies[index];
        if (!body.moves) continue;
        std::vector<Eigen::Vector3d> places_m;
        for (const Eigen::Vector3i &vertex_um : body.vertices_um)
            places_m.push_back(vertex_um.cast<double>() * 1e-6);
        moving_.push_back({static_cast<int>(index), MovingPoints(motion, std::move(places_m)),
                           body.vertices_um, body.vertices_um});
    }
}

const std::vector<MovingBodies::Moved> &MovingBodies::at(const MotionMoment &moment)
{
    const MotionWeights weights = motion_weights(moment);
    moved_.clear();
    for (Body &body : moving_) {
        body.points.place(weights, body.reference_um, body.vertices_um);
        moved_.push_back({body.index, body.vertices_um});
    }
    return moved_;
}

} // namespace crn
