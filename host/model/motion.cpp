#include "host/model/motion.hpp"
#include "host/model/text.hpp"
#include "shared/scene/scene.h"
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace seld
{
namespace
{

constexpr double q30 = 0x1p-30;
constexpr double unit_m = 0x1p-19; // of a coefficient: 2^11 / 2^30
constexpr int row_numbers = SELD_SCENE_MOTION_ROW, row_breath = SELD_SCENE_MOTION_ROW_BREATH;
constexpr int kept = motion_keyframes + 3; // of a moved vertex's component: keyframes 23, 0 .. 23, 0, breath

} // namespace

void motion_prefilter(const double *w, double *c)
{
    constexpr int n = motion_keyframes, rounds = 20;
    std::copy_n(w, n, c);
    for (int round = 0; round < rounds; ++round)
        for (int k = 0; k < n; ++k) c[k] = (8 * w[k] - c[(k + n - 1) % n] - c[(k + 1) % n]) / 6;
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

Motion::Motion(const seld_scene_motion &scene)
{
    std::size_t nodes = 1;
    for (int k = 0; k < 3; ++k) {
        origin_m_[static_cast<std::size_t>(k)] = scene.origin_m_q30[k] * q30;
        count_[static_cast<std::size_t>(k)] = scene.node_count_xyz[k];
        nodes *= scene.node_count_xyz[k];
    }
    spacing_m_ = std::ldexp(q30, scene.spacing_log2_q30);
    rows_.assign(scene.rows, scene.rows + nodes * 3 * row_numbers);
}

Eigen::Vector3d Motion::way(const Eigen::Vector3d &x_m, const MotionWeights &at) const
{
    std::size_t cell[3];
    double place[3];
    for (std::size_t k = 0; k < 3; ++k) {
        const double from = (x_m[static_cast<int>(k)] - origin_m_[k]) / spacing_m_;
        if (!(from >= 0 && from < count_[k] - 1)) return Eigen::Vector3d::Zero();
        cell[k] = static_cast<std::size_t>(from);
        place[k] = from - static_cast<double>(cell[k]);
    }
    const auto nx = static_cast<std::size_t>(count_[0]), ny = static_cast<std::size_t>(count_[1]);
    double sum[3] = {0, 0, 0};
    for (unsigned corner = 0; corner < 8; ++corner) {
        const std::size_t dx = corner & 1u, dy = corner >> 1 & 1u, dz = corner >> 2;
        const double weight =
            (dx ? place[0] : 1 - place[0]) * (dy ? place[1] : 1 - place[1]) * (dz ? place[2] : 1 - place[2]);
        const std::size_t node = ((cell[2] + dz) * ny + cell[1] + dy) * nx + cell[0] + dx;
        const std::int16_t *row = rows_.data() + node * 3 * row_numbers;
        for (int k = 0; k < 3; ++k, row += row_numbers) {
            const std::int16_t *taps = row + at.first;
            sum[k] += weight * (taps[0] * at.weights[0] + taps[1] * at.weights[1] + taps[2] * at.weights[2] +
                                row[row_breath] * at.breath);
        }
    }
    return {sum[0] * unit_m, sum[1] * unit_m, sum[2] * unit_m};
}

Eigen::Vector3d Motion::pull(const Eigen::Vector3d &x_m, const MotionMoment &moment) const
{
    return x_m + way(x_m, motion_weights(moment));
}

// x = X - w(x): w changes from place to place by less than places do, so that it goes to the fixed point; each round gains the
// lattice's steepness, a third in a heart.
Eigen::Vector3d Motion::push(const Eigen::Vector3d &X_m, const MotionWeights &at) const
{
    constexpr int rounds_max = 40;
    constexpr double enough_m = 2e-7;
    Eigen::Vector3d x = X_m;
    for (int round = 0; round < rounds_max; ++round) {
        const Eigen::Vector3d next = X_m - way(x, at);
        const double step = (next - x).cwiseAbs().maxCoeff();
        x = next;
        if (step < enough_m) break;
    }
    return x;
}

Eigen::Vector3d Motion::push(const Eigen::Vector3d &X_m, const MotionMoment &moment) const
{
    return push(X_m, motion_weights(moment));
}

std::optional<Motion> read_motion(const std::string &scene_path, std::string &error)
{
    error.clear();
    if (scene_path.empty()) return {};
    try {
        const std::vector<unsigned char> bytes = read_binary_file(scene_path);
        seld_scene scene;
        std::uint32_t where_byte = 0;
        const seld_scene_status status = seld_scene_open(bytes.data(), bytes.size(), &scene, &where_byte);
        if (status == SELD_SCENE_OK && scene.has_motion) return Motion(scene.motion);
        if (status != SELD_SCENE_OK)
            error =
                scene_path + ": byte " + std::to_string(where_byte) + ": " + seld_scene_status_text(status);
    } catch (const FileError &fault) {
        error = fault.what();
    }
    return {};
}

MovingPoints::MovingPoints(const Motion &motion, std::vector<Eigen::Vector3d> reference_m)
    : reference_m_(std::move(reference_m))
{
    coefficients_um_.reserve(reference_m_.size() * 3 * kept);
    for (const Eigen::Vector3d &X_m : reference_m_) {
        double way[3][motion_keyframes], c[motion_keyframes];
        bool moves = false;
        for (int key = 0; key < motion_keyframes; ++key) {
            MotionMoment moment;
            moment.heart_phase32 = static_cast<std::uint32_t>((std::uint64_t(key) << 32) / motion_keyframes);
            const Eigen::Vector3d moved = motion.push(X_m, moment) - X_m;
            moves = moves || !moved.isZero(0.0);
            for (int k = 0; k < 3; ++k) way[k][key] = moved[k] * 1e6;
        }
        const Eigen::Vector3d inhaled = motion.push(X_m, MotionMoment{0, 1u << 31}) - X_m;
        moves_.push_back(moves || !inhaled.isZero(0.0));
        for (int k = 0; k < 3; ++k) {
            motion_prefilter(way[k], c);
            for (int i = 0; i < motion_keyframes + 2; ++i)
                coefficients_um_.push_back(
                    static_cast<float>(c[(i + motion_keyframes - 1) % motion_keyframes]));
            coefficients_um_.push_back(static_cast<float>(inhaled[k] * 1e6 - way[k][0]));
        }
    }
}

Eigen::Vector3f MovingPoints::way_um(std::size_t i, const MotionWeights &weights) const
{
    if (!moves_[i]) return Eigen::Vector3f::Zero();
    const auto a = static_cast<float>(weights.weights[0]), b = static_cast<float>(weights.weights[1]),
               c = static_cast<float>(weights.weights[2]), depth = static_cast<float>(weights.breath);
    Eigen::Vector3f way;
    const float *row = coefficients_um_.data() + i * 3 * kept;
    for (int k = 0; k < 3; ++k, row += kept) {
        const float *taps = row + weights.first;
        way[k] = taps[0] * a + taps[1] * b + taps[2] * c + row[kept - 1] * depth;
    }
    return way;
}

MovingBodies::MovingBodies(const Motion &motion, const Bodies &bodies)
{
    for (std::size_t index = 0; index < bodies.bodies.size(); ++index) {
        const seld::Body &body = bodies.bodies[index];
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
        for (std::size_t i = 0; i < body.points.size(); ++i) {
            const Eigen::Vector3f way_um = body.points.way_um(i, weights);
            for (int k = 0; k < 3; ++k)
                body.vertices_um[i][k] = body.reference_um[i][k] + static_cast<int>(std::lround(way_um[k]));
        }
        moved_.push_back({body.index, body.vertices_um});
    }
    return moved_;
}

} // namespace seld
