#include "tools/lab/ct/patient/wall.hpp"
#include "tools/lab/ct/arteries/blocks.hpp"
#include "tools/lab/ct/arteries/bright.hpp"
#include "tools/lab/ct/snake.hpp"
#include <algorithm>
#include <cmath>

namespace crn::ct
{

namespace
{

using Eigen::Vector3d;

constexpr float in_artery = 1, in_bridge = 2, in_thread = 3; // what the mask says
constexpr double cube_min_mm = 0.7, cube_max_mm = 1.0, margin_mm = 8.0;

// The brightest blood within 2 mm: partial volume makes thin arteries darker. It is at most the mean of the
// aorta.
float blood_near(const Cut &cut, const Contrast &contrast, int i, int j, int k)
{
    constexpr double reach_mm = 2.0;
    const int at[3] = {i, j, k};
    int low[3], high[3];
    for (int axis = 0; axis < 3; ++axis) {
        const int reach = std::max(1, static_cast<int>(reach_mm / cut.scan.spacing_mm[axis]));
        low[axis] = std::max(at[axis] - reach, 0);
        high[axis] = std::min(at[axis] + reach, cut.scan.size[static_cast<std::size_t>(axis)] - 1);
    }
    const auto noise_HU = static_cast<float>(contrast.noise_HU),
               mean_HU = static_cast<float>(contrast.mean_HU);
    float most_HU = 0.5f * mean_HU + noise_HU;
    for (int z = low[2]; z <= high[2]; ++z)
        for (int y = low[1]; y <= high[1]; ++y)
            for (int x = low[0]; x <= high[0]; ++x) {
                const std::size_t other = cut.scan.at(x, y, z);
                if (cut.mask.hu[other] > 0) most_HU = std::max(most_HU, cut.scan.hu[other]);
            }
    return std::min(most_HU - noise_HU, mean_HU); // the brightest of some voxels is a noise above their mean
}

// Linear interpolation on a grid of spacing h smooths by the variance h^2 / 6 per axis. This shrinks a tube
// of radius r by h^2 / (12 r). The level is interpolated twice: on the cubes, and where the surface crosses
// their edges. Both are undone beforehand, to first order.
void sharpen(Volume &level, double cube_mm)
{
    const Volume before = level;
    std::size_t step = 1;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double ratio = cube_mm / level.spacing_mm[static_cast<Eigen::Index>(axis)];
        const auto share = static_cast<float>((1.0 + ratio * ratio) / 12.0);
        const auto size = static_cast<std::size_t>(level.size[axis]);
        for (std::size_t at = 0; at < level.count(); ++at) {
            const std::size_t index = at / step % size;
            if (index == 0 || index + 1 == size) continue;
            level.hu[at] -= share * (before.hu[at + step] - 2 * before.hu[at] + before.hu[at - step]);
        }
        step *= size;
    }
}

// The voxels that are brighter than blood, but for single ones, which are noise.
Mask calcium_of(const Volume &scan, float calcium_HU)
{
    constexpr double noise_most_mm3 = 3;
    Mask mask(scan.count());
    for (std::size_t at = 0; at < mask.size(); ++at) mask[at] = scan.hu[at] > calcium_HU;
    keep_pieces(scan, Pieces::large, noise_most_mm3, mask);
    return mask;
}

// Whether there is calcium within reach, farther inside the artery than the voxel or beside it. Then the
// voxel lies in the calcium's blur, which is as bright as blood, and not in the lumen.
bool is_behind_calcium(const Mask &plaques, const Volume &depth, int i, int j, int k)
{
    constexpr double reach_mm = 1.8, beside = -0.2; // the cosine against the way to the middle
    const int at[3] = {i, j, k};
    Vector3d inward = Vector3d::Zero();
    int reach[3];
    for (int axis = 0; axis < 3; ++axis) {
        int low[3] = {i, j, k}, high[3] = {i, j, k};
        low[axis] = std::max(at[axis] - 2, 0);
        high[axis] = std::min(at[axis] + 2, depth.size[static_cast<std::size_t>(axis)] - 1);
        inward[axis] = static_cast<double>(depth.hu[depth.at(low[0], low[1], low[2])] -
                                           depth.hu[depth.at(high[0], high[1], high[2])]) /
                       depth.spacing_mm[axis];
        reach[axis] = static_cast<int>(reach_mm / depth.spacing_mm[axis]);
    }
    inward.normalize();
    for (int z = std::max(k - reach[2], 0); z <= std::min(k + reach[2], depth.size[2] - 1); ++z)
        for (int y = std::max(j - reach[1], 0); y <= std::min(j + reach[1], depth.size[1] - 1); ++y)
            for (int x = std::max(i - reach[0], 0); x <= std::min(i + reach[0], depth.size[0] - 1); ++x) {
                if (!plaques[depth.at(x, y, z)]) continue;
                const Vector3d way = Vector3d(x - i, y - j, z - k).cwiseProduct(depth.spacing_mm);
                if (way.norm() <= reach_mm && way.dot(inward) >= beside * way.norm()) return true;
            }
    return false;
}

// 1 at the walls of arteries wider than 6 mm, and 0 from some 2 mm outside them on. These walls can be
// smoothed without closing the mouths of thin branches.
Volume near_wide(const Volume &depth)
{
    constexpr float deep_mm = 3.0f, beyond_mm = 2.5f, over_mm = 1.5f;
    Volume core = depth;
    for (float &value : core.hu) value = value < -deep_mm ? 1.0f : 0.0f;
    if (std::none_of(core.hu.begin(), core.hu.end(), [](float value) { return value > 0; })) return core;
    Volume near = signed_distance(core);
    for (float &value : near.hu) value = std::clamp((deep_mm + beyond_mm - value) / over_mm, 0.0f, 1.0f);
    return near;
}

} // namespace

Cut cut_arteries(const Volume &scan, const LabelMap &labels)
{
    const std::vector<int> wanted = labels.numbers(is_artery);
    const auto kind_of = [&](int label) {
        const std::string &name = labels.names.at(label);
        return name == bridge_name ? in_bridge : name == thread_name ? in_thread : in_artery;
    };
    std::array<int, 3> low = scan.size, high = {0, 0, 0};
    Volume mask = scan.like(0);
    for (int k = 0; k < scan.size[2]; ++k)
        for (int j = 0; j < scan.size[1]; ++j)
            for (int i = 0; i < scan.size[0]; ++i) {
                const std::size_t at = scan.at(i, j, k);
                if (std::find(wanted.begin(), wanted.end(), labels.label(at)) == wanted.end()) continue;
                mask.hu[at] = kind_of(labels.label(at));
                const int here[3] = {i, j, k};
                for (std::size_t axis = 0; axis < 3; ++axis) {
                    low[axis] = std::min(low[axis], here[axis]);
                    high[axis] = std::max(high[axis], here[axis] + 1);
                }
            }
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const int more =
            static_cast<int>(std::ceil(margin_mm / scan.spacing_mm[static_cast<Eigen::Index>(axis)]));
        low[axis] = std::max(low[axis] - more, 0);
        high[axis] = std::min(high[axis] + more, scan.size[axis]);
    }
    return {cut_out(scan, low, high), cut_out(mask, low, high)};
}

Volume in_cubes(const Volume &from, double cube_mm)
{
    Volume cubes;
    cubes.name = from.name;
    cubes.origin_mm = from.origin_mm;
    cubes.direction = from.direction;
    cubes.spacing_mm = Vector3d::Constant(cube_mm);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double length_mm = from.spacing_mm[static_cast<Eigen::Index>(axis)] * (from.size[axis] - 1);
        cubes.size[axis] = static_cast<int>(std::floor(length_mm / cube_mm)) + 1;
    }
    cubes.hu.resize(cubes.count());
    for (int k = 0; k < cubes.size[2]; ++k)
        for (int j = 0; j < cubes.size[1]; ++j)
            for (int i = 0; i < cubes.size[0]; ++i)
                cubes.hu[cubes.at(i, j, k)] = static_cast<float>(
                    from.value((Vector3d(i, j, k) * cube_mm).cwiseQuotient(from.spacing_mm)));
    return cubes;
}

double cube_of(const Volume &scan)
{
    return std::clamp(scan.spacing_mm.minCoeff(), cube_min_mm, cube_max_mm);
}

Volume wall_level(const Volume &scan, const LabelMap &labels, const Contrast &contrast, const Report &report)
{
    constexpr float edge_mm = 1.6f, half_mm = 0.8f; // width of the edge, from a scanner's blur
    constexpr float thread_mm = -0.2f;              // the same where a click says that an artery is
    constexpr float near_mm = 3.0f;                 // of the labelled voxels' border
    constexpr float inside_mm = 2.0f;               // deeper, dark voxels are noise or streaks
    constexpr float air_HU = -200, fat_HU = -50;    // of what is beside: lungs tell nothing about the wall
    report("find the wall", 0);
    const Cut cut = cut_arteries(scan, labels);
    const Volume depth = signed_distance(cut.mask);
    report("find the wall", 0.4);
    const BrightRange range = bright_range(contrast);
    const auto outside_mm = static_cast<float>(std::clamp(0.75 * scan.spacing_mm.maxCoeff(), 0.7, 1.5));
    const BlockMeans beside(cut.scan, 3.5, 0.02, fat_HU, [&](std::size_t at) {
        return depth.hu[at] > 1.8f && depth.hu[at] < 5.0f && cut.scan.hu[at] > air_HU &&
               cut.scan.hu[at] < range.low_HU;
    });
    const Volume wide = near_wide(depth);
    const Mask calcium = calcium_of(cut.scan, range.high_HU);
    // Larger pieces are bone, which may lie beside the mouth of a thin branch of the aorta.
    Mask plaques = calcium;
    keep_pieces(cut.scan, Pieces::small, piece_least_mm3, plaques);
    Volume level = depth;
    for (int k = 0; k < level.size[2]; ++k)
        for (int j = 0; j < level.size[1]; ++j)
            for (int i = 0; i < level.size[0]; ++i) {
                const std::size_t at = level.at(i, j, k);
                float &value = level.hu[at];
                value = std::clamp(value, -near_mm, near_mm);
                if (std::fabs(value) == near_mm) {
                    value = std::copysign(half_mm, value);
                    continue;
                }
                const float blood = blood_near(cut, contrast, i, j, k), other = beside.at(i, j, k);
                // Calcium is no lumen: above the blood's range, brighter is farther outside.
                const float hu = std::min(cut.scan.hu[at],
                                          calcium[at] ? 2 * range.high_HU - cut.scan.hu[at] : range.high_HU);
                const float edge = edge_mm * (0.5f * (blood + other) - hu) / (blood - other);
                const float deepest = cut.mask.hu[at] == in_thread ? thread_mm : inside_mm;
                if (cut.mask.hu[at] != in_bridge)
                    value = std::clamp(edge, value - outside_mm, value + deepest);
                // Only where the artery is wide: in a thin one, a plaque reaches across.
                if (value < half_mm && wide.hu[at] > 0.5f && cut.mask.hu[at] <= in_artery &&
                    is_behind_calcium(plaques, depth, i, j, k))
                    value = half_mm;
                value = std::clamp(value, -half_mm, half_mm); // alike on both sides, for the smoothing
            }
    report("find the wall", 0.6);
    sharpen(level, cube_of(scan));
    const Volume fine = in_cubes(level, cube_of(scan)), wide_fine = in_cubes(wide, cube_of(scan));
    Volume result = fine;
    report("find the wall", 0.8);
    const Volume even = smoothed(fine, 0.8);
    for (std::size_t at = 0; at < result.count(); ++at)
        result.hu[at] += wide_fine.hu[at] * (even.hu[at] - result.hu[at]);
    report("find the wall", 1);
    return result;
}

} // namespace crn::ct
