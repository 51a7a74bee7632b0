// Fits the lattice that describes the motion: for each keyframe, solves one sparse system for all three
// displacement components.
#include "tools/bake/motion.hpp"
#include "host/model/motion.hpp"
#include "shared/scene/scene.h"
#include "tools/bake/fault.hpp"

#include <Eigen/IterativeLinearSolvers>
#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>
#include <cstdio>

namespace crn::bake
{
namespace
{

using Sparse = Eigen::SparseMatrix<double, Eigen::RowMajor>;
using Ways = Eigen::MatrixX3d; // displacements: one row per node, mm

constexpr double unit_mm = 2048.0 * mm_per_q30;
constexpr double still_mm = 0.02;   // what moves less counts as still
constexpr double smoothness = 0.02; // weight of the squared Laplacian beside a vertex of the lumen ...
constexpr double tension =
    0.25; // ... and of the Laplacian: without it the motion overshoots towards the boundary
constexpr double guide_weight = 0.03; // of a vertex of the guides, where the lumen gives no data
constexpr double beat_reach_spacings = 6.0, breath_reach_spacings = 3.0, reach_ways = 2.5;

struct Lattice {
    Eigen::Vector3d origin_mm;
    Eigen::Vector3i count;
    double spacing_mm;
    std::uint32_t spacing_log2;
    bool is_plane = false; // interpolates in each of a cell's six tetrahedra (breath); otherwise trilinear

    int node(int x, int y, int z) const { return (z * count.y() + y) * count.x() + x; }
    int nodes() const { return count.prod(); }
    bool is_edge(int x, int y, int z) const
    {
        return x == 0 || y == 0 || z == 0 || x + 1 == count.x() || y + 1 == count.y() || z + 1 == count.z();
    }
    // Finds the cell of the lattice that contains a point, and the point's position within the cell; returns
    // false if the point lies outside the lattice.
    bool find(const Eigen::Vector3d &p_mm, Eigen::Vector3i &cell, Eigen::Vector3d &place) const
    {
        const Eigen::Vector3d at = (p_mm - origin_mm) / spacing_mm;
        for (int k = 0; k < 3; ++k) {
            cell[k] = static_cast<int>(std::floor(at[k]));
            if (cell[k] < 0 || cell[k] + 1 >= count[k]) return false;
            place[k] = at[k] - cell[k];
        }
        return true;
    }
    double weight(int corner, const Eigen::Vector3d &place) const
    {
        if (is_plane) return motion_plane_weight(corner, place);
        double product = 1;
        for (int k = 0; k < 3; ++k) product *= (corner >> k & 1) != 0 ? place[k] : 1 - place[k];
        return product;
    }
    int corner_node(int corner, const Eigen::Vector3i &cell) const
    {
        return node(cell.x() + (corner & 1), cell.y() + (corner >> 1 & 1), cell.z() + (corner >> 2));
    }
};

// Collects the moving points of a sequence of meshes, the box around these points, and the longest
// displacement of a point from the reference pose.
struct Moving {
    Eigen::AlignedBox3d box;
    double way_mm = 0;
    void take_beat(const Sequence &sequence)
    {
        for (const auto &moved_mm : sequence.moved_mm) take(sequence.reference_mm, moved_mm);
    }
    void take_breath(const Sequence &sequence)
    {
        if (!sequence.inhaled_mm.empty()) take(sequence.moved_mm[0], sequence.inhaled_mm);
    }

  private:
    void take(const std::vector<Eigen::Vector3d> &from_mm, const std::vector<Eigen::Vector3d> &moved_mm)
    {
        for (std::size_t i = 0; i < moved_mm.size(); ++i) {
            const double way = (moved_mm[i] - from_mm[i]).norm();
            if (way < still_mm) continue;
            box.extend(moved_mm[i]);
            box.extend(from_mm[i]);
            way_mm = std::max(way_mm, way);
        }
    }
};

// Makes a lattice around all moving points, with enough margin for the displacement to fall to zero. The
// coordinates of the lattice's corner are multiples of the lattice's spacing.
Lattice lattice_for(const Moving &moving, double spacing_mm, double reach_spacings)
{
    Lattice lattice;
    lattice.spacing_log2 = CRN_MOTION_SPACING_LOG2_MAX;
    while (lattice.spacing_log2 > CRN_MOTION_SPACING_LOG2_MIN &&
           std::ldexp(mm_per_q30, static_cast<int>(lattice.spacing_log2)) > spacing_mm * 1.005)
        --lattice.spacing_log2;
    lattice.spacing_mm = std::ldexp(mm_per_q30, static_cast<int>(lattice.spacing_log2));
    const Eigen::AlignedBox3d &box = moving.box;
    if (box.isEmpty()) throw Fault("[motion]: nothing moves in these frames: leave [motion] out");
    const double reach = std::max(reach_spacings * lattice.spacing_mm, reach_ways * moving.way_mm);
    for (int k = 0; k < 3; ++k) {
        const double low = std::floor((box.min()[k] - reach) / lattice.spacing_mm);
        const double high = std::ceil((box.max()[k] + reach) / lattice.spacing_mm);
        lattice.origin_mm[k] = low * lattice.spacing_mm;
        lattice.count[k] = static_cast<int>(high - low) + 1;
        if (lattice.count[k] > CRN_SCENE_MOTION_COUNT_MAX)
            throw Fault(
                "[motion]: the lattice would have more than 256 nodes along an axis: raise spacing_mm");
    }
    return lattice;
}

// Penalises bending and tension of the displacement field at the free nodes of the lattice. The graph
// Laplacian compares each node with the mean of its six neighbours; it takes the value at the boundary as 0.
Sparse smoothing(const Lattice &lattice)
{
    std::vector<Eigen::Triplet<double>> entries;
    for (int z = 0; z < lattice.count.z(); ++z)
        for (int y = 0; y < lattice.count.y(); ++y)
            for (int x = 0; x < lattice.count.x(); ++x) {
                if (lattice.is_edge(x, y, z)) continue;
                const int at = lattice.node(x, y, z);
                entries.emplace_back(at, at, 1.0);
                const int around[6][3] = {{x - 1, y, z}, {x + 1, y, z}, {x, y - 1, z},
                                          {x, y + 1, z}, {x, y, z - 1}, {x, y, z + 1}};
                for (const auto &n : around)
                    if (!lattice.is_edge(n[0], n[1], n[2]))
                        entries.emplace_back(at, lattice.node(n[0], n[1], n[2]), -1.0 / 6.0);
            }
    Sparse laplacian(lattice.nodes(), lattice.nodes());
    laplacian.setFromTriplets(entries.begin(), entries.end());
    Sparse energy = laplacian.transpose() * laplacian;
    energy += tension * laplacian; // the Laplacian is symmetric: every neighbour counts a sixth
    return energy;
}

// Finds those displacements w of the lattice's nodes that best fit the displacements of the given points.
class Fit
{
  public:
    Fit(const Lattice &lattice, const Sparse &smooth)
        : lattice_(lattice), smooth_(smooth), right_(Ways::Zero(lattice.nodes(), 3))
    {
    }

    // Adds a point, and the displacement `way_mm` that the lattice should give this point.
    void tell(const Eigen::Vector3d &at_mm, const Eigen::Vector3d &way_mm, double weight)
    {
        Eigen::Vector3i cell;
        Eigen::Vector3d place;
        if (!lattice_.find(at_mm, cell, place)) return;
        for (int a = 0; a < 8; ++a) {
            if (!is_free(a, cell)) continue;
            const double part = weight * lattice_.weight(a, place);
            right_.row(lattice_.corner_node(a, cell)) += part * way_mm.transpose();
            for (int b = 0; b < 8; ++b)
                if (is_free(b, cell))
                    entries_.emplace_back(lattice_.corner_node(a, cell), lattice_.corner_node(b, cell),
                                          part * lattice_.weight(b, place));
        }
    }

    Ways solve(const Ways &guess)
    {
        const int nodes = lattice_.nodes();
        Sparse matrix(nodes, nodes), boundary(nodes, nodes);
        matrix.setFromTriplets(entries_.begin(), entries_.end());
        boundary.setIdentity();
        matrix += smoothness * smooth_;
        matrix += 1e-9 * boundary; // the nodes of the boundary have no equation of their own
        Eigen::ConjugateGradient<Sparse, Eigen::Lower | Eigen::Upper> solver;
        solver.setTolerance(1e-6);
        solver.setMaxIterations(4000);
        solver.compute(matrix);
        Ways ways(nodes, 3);
        for (int k = 0; k < 3; ++k) ways.col(k) = solver.solveWithGuess(right_.col(k), guess.col(k));
        return ways;
    }

  private:
    bool is_free(int corner, const Eigen::Vector3i &cell) const
    {
        return !lattice_.is_edge(cell.x() + (corner & 1), cell.y() + (corner >> 1 & 1),
                                 cell.z() + (corner >> 2));
    }

    const Lattice &lattice_;
    const Sparse &smooth_;
    std::vector<Eigen::Triplet<double>> entries_;
    Ways right_;
};

// Adds the displacements that carry the moved vertices back to the reference pose.
void tell_all(Fit &fit, const std::vector<Eigen::Vector3d> &moved_mm,
              const std::vector<Eigen::Vector3d> &back_mm, double weight)
{
    for (std::size_t i = 0; i < moved_mm.size(); ++i) fit.tell(moved_mm[i], back_mm[i] - moved_mm[i], weight);
}

std::int16_t coefficient(double way_mm)
{
    const double value = std::round(way_mm / unit_mm);
    if (std::abs(value) > int{CRN_MOTION_COEFFICIENT_MAX})
        throw Fault("[motion]: a vessel moves by more than 31 mm from its reference pose: take a frame in "
                    "the middle of "
                    "the motion as the lumen's mesh");
    return static_cast<std::int16_t>(value);
}

crn_lattice stored(const Lattice &lattice)
{
    crn_lattice result{};
    result.spacing_log2_q30 = lattice.spacing_log2;
    for (int k = 0; k < 3; ++k) {
        result.origin_m_q30[k] = static_cast<std::int32_t>(std::lround(lattice.origin_mm[k] / mm_per_q30));
        result.count_xyz[k] = static_cast<std::uint32_t>(lattice.count[k]);
    }
    return result;
}

void put_node(const std::vector<Ways> &keys, int node, std::int16_t *rows)
{
    for (int k = 0; k < 3; ++k, rows += CRN_MOTION_ROW) {
        double w[CRN_MOTION_KEYFRAMES], c[CRN_MOTION_KEYFRAMES];
        for (std::size_t i = 0; i < keys.size(); ++i) w[i] = keys[i](node, k);
        motion_prefilter(w, c);
        for (int i = 0; i < CRN_MOTION_KEYFRAMES + 2; ++i)
            rows[i] = coefficient(c[(i + CRN_MOTION_KEYFRAMES - 1) % CRN_MOTION_KEYFRAMES]);
    }
}

// The nodes at the boundary of the heartbeat's lattice keep a displacement of 0.
void fit_beat(const Frames &frames, double spacing_mm, Motion &motion, Progress &progress)
{
    Moving moving;
    moving.take_beat(frames.lumen);
    moving.take_beat(frames.guides);
    const Lattice lattice = lattice_for(moving, spacing_mm, beat_reach_spacings);
    const Sparse smooth = smoothing(lattice);
    std::vector<Ways> keys;
    for (std::size_t k = 0; k < frames_count; ++k) {
        Fit fit(lattice, smooth);
        tell_all(fit, frames.lumen.moved_mm[k], frames.lumen.reference_mm, 1.0);
        if (!frames.guides.moved_mm.empty())
            tell_all(fit, frames.guides.moved_mm[k], frames.guides.reference_mm, guide_weight);
        keys.push_back(fit.solve(k == 0 ? Ways::Zero(lattice.nodes(), 3).eval() : keys.back()));
        progress.step(keys.size());
    }
    motion.lattices.beat = stored(lattice);
    motion.rows.assign(static_cast<std::size_t>(lattice.nodes()) * 3 * CRN_MOTION_ROW, 0);
    for (int node = 0; node < lattice.nodes(); ++node)
        put_node(keys, node, &motion.rows[static_cast<std::size_t>(node) * 3 * CRN_MOTION_ROW]);
}

// The heart beats inside a chest that moves with breath. Breath therefore displaces a point equally in every
// frame of the heartbeat, so we fit the lattice of breath to the first frame only.
void fit_breath(const Frames &frames, double spacing_mm, Motion &motion)
{
    Moving moving;
    moving.take_breath(frames.lumen);
    moving.take_breath(frames.guides);
    Lattice lattice = lattice_for(moving, spacing_mm, breath_reach_spacings);
    lattice.is_plane = true;
    const Sparse smooth = smoothing(lattice);
    Fit fit(lattice, smooth);
    tell_all(fit, frames.lumen.inhaled_mm, frames.lumen.moved_mm[0], 1.0);
    if (!frames.guides.inhaled_mm.empty())
        tell_all(fit, frames.guides.inhaled_mm, frames.guides.moved_mm[0], guide_weight);
    const Ways ways = fit.solve(Ways::Zero(lattice.nodes(), 3));
    motion.lattices.breath = stored(lattice);
    motion.inhaled.clear();
    for (int node = 0; node < lattice.nodes(); ++node)
        for (int k = 0; k < 3; ++k) motion.inhaled.push_back(coefficient(ways(node, k)));
}

} // namespace

void Sequence::retime(double end_systole)
{
    constexpr double wanted_end = 10.0, count = static_cast<double>(frames_count);
    if (end_systole == wanted_end) return;
    const std::vector<std::vector<Eigen::Vector3d>> recorded = moved_mm;
    for (std::size_t key = 0; key < moved_mm.size(); ++key) {
        const double k = static_cast<double>(key);
        const double source =
            k <= wanted_end ? k * end_systole / wanted_end
                            : end_systole + (k - wanted_end) * (count - end_systole) / (count - wanted_end);
        const auto at = static_cast<std::size_t>(source);
        const double t = source - std::floor(source);
        // Between two frames of the sequence, we interpolate by the Catmull-Rom cubic through the
        // neighbouring frames.
        const double weights[4] = {t * (-0.5 + t * (1 - 0.5 * t)), 1 + t * t * (-2.5 + 1.5 * t),
                                   t * (0.5 + t * (2 - 1.5 * t)), t * t * (-0.5 + 0.5 * t)};
        for (std::size_t i = 0; i < moved_mm[key].size(); ++i) {
            moved_mm[key][i].setZero();
            for (std::size_t tap = 0; tap < 4; ++tap)
                moved_mm[key][i] += weights[tap] * recorded[(at + frames_count - 1 + tap) % frames_count][i];
        }
    }
}

std::size_t middle_pose(const Sequence &sequence)
{
    const std::size_t count = sequence.moved_mm.front().size(), stride = count / 5000 + 1;
    std::size_t best = 0;
    double best_mm = 1e9;
    for (std::size_t pose = 0; pose < sequence.moved_mm.size(); ++pose) {
        double longest_mm = 0;
        for (const auto &moved : sequence.moved_mm)
            for (std::size_t i = 0; i < count; i += stride)
                longest_mm = std::max(longest_mm, (moved[i] - sequence.moved_mm[pose][i]).norm());
        if (longest_mm < best_mm) {
            best = pose;
            best_mm = longest_mm;
        }
    }
    return best;
}

Motion fit_motion(const Frames &frames, const MotionSpacing &spacing, Progress &progress)
{
    const bool breathes = !frames.lumen.inhaled_mm.empty();
    Motion motion;
    progress.stage("fitting the motion", frames_count + breathes);
    fit_beat(frames, spacing.beat_mm, motion, progress);
    if (breathes) fit_breath(frames, spacing.breath_mm, motion);
    progress.finish();
    motion.view();
    refuse_steep(motion);
    return motion;
}

} // namespace crn::bake
