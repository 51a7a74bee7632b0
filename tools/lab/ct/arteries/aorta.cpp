#include "tools/lab/ct/arteries/aorta.hpp"
#include "host/base/format.hpp"
#include "tools/lab/ct/measures.hpp"
#include "tools/mesh/fault.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace crn::ct
{

namespace
{

using Eigen::Vector2d;

constexpr int rays = 32;
constexpr double blood_least_HU = 130, blood_most_HU = 900, beside_HU = 50;
constexpr double radius_least_mm = 4.5, radius_most_mm = 32.0, seed_step_mm = 4.0, core_mm = 2.5;
constexpr double on_circle = 0.2;     // of the radius: the edge of an oblique vessel is an ellipse
constexpr double share_least = 0.7;   // a neighbour may touch the vessel
constexpr double evenness_most = 0.2; // noise of a core, as a share of its contrast

// One slice of the scan, in which places are in voxels.
struct Slice {
    const Volume &scan;
    int index;

    bool holds(const Vector2d &at) const
    {
        return at.x() >= 0 && at.y() >= 0 && at.x() <= scan.size[0] - 1 && at.y() <= scan.size[1] - 1;
    }
    double value(const Vector2d &at) const
    {
        return static_cast<double>(
            scan.hu[scan.at(static_cast<int>(at.x() + 0.5), static_cast<int>(at.y() + 0.5), index)]);
    }
    Vector2d voxels(const Vector2d &mm) const { return mm.cwiseQuotient(scan.spacing_mm.head<2>()); }
};

struct Core {
    double mean_HU = 0.0, noise_HU = 0.0;
};

// Mean and standard deviation around a place.
Core core_at(const Slice &slice, const Vector2d &middle, double radius_mm)
{
    const double step_mm = std::max(slice.scan.spacing_mm[0], radius_mm / 5.0);
    double sum = 0, squares = 0, count = 0;
    for (double y = -radius_mm; y <= radius_mm; y += step_mm)
        for (double x = -radius_mm; x <= radius_mm; x += step_mm) {
            if (std::hypot(x, y) > radius_mm) continue;
            const Vector2d at = middle + slice.voxels({x, y});
            if (!slice.holds(at)) continue;
            const double value = slice.value(at);
            sum += value;
            squares += value * value;
            count += 1;
        }
    if (count == 0) return {};
    const double mean = sum / count;
    return {mean, std::sqrt(std::max(squares / count - mean * mean, 0.0))};
}

bool may_be_blood(const Core &core)
{
    return core.mean_HU > blood_least_HU && core.mean_HU < blood_most_HU &&
           core.noise_HU < std::max(evenness_most * (core.mean_HU - beside_HU), 30.0);
}

// Distance of the edge in each direction, where the value falls below the middle between blood and tissue;
// 0 if there is none.
std::array<double, rays> edges_around(const Slice &slice, const Vector2d &middle, double half_HU)
{
    std::array<double, rays> edge_mm{};
    const double step_mm = 0.5 * slice.scan.spacing_mm[0];
    for (int ray = 0; ray < rays; ++ray) {
        const double angle = 2 * std::numbers::pi * ray / rays;
        const Vector2d along(std::cos(angle), std::sin(angle));
        int below = 0;
        for (double at_mm = step_mm; at_mm < 1.5 * radius_most_mm; at_mm += step_mm) {
            const Vector2d at = middle + slice.voxels(at_mm * along);
            if (!slice.holds(at)) break;
            below = slice.value(at) < half_HU ? below + 1 : 0;
            if (below < 3) continue; // noise
            edge_mm[static_cast<std::size_t>(ray)] = at_mm - 2 * step_mm;
            break;
        }
    }
    return edge_mm;
}

// Moves a circle to the edges around it; nothing if too few of them lie on a circle.
std::optional<Disc> disc_at(const Slice &slice, Vector2d middle)
{
    Core core = core_at(slice, middle, core_mm);
    if (!may_be_blood(core)) return std::nullopt;
    Disc disc;
    for (int round = 0; round < 4; ++round) {
        const auto edge_mm = edges_around(slice, middle, 0.5 * (core.mean_HU + beside_HU));
        const double radius_mm = median({edge_mm.begin(), edge_mm.end()});
        if (radius_mm < radius_least_mm || radius_mm > radius_most_mm) return std::nullopt;
        // The first rounds begin beside the middle.
        const double allowed = (round < 2 ? 3.0 : round < 3 ? 1.5 : 1.0) * on_circle * radius_mm;
        Vector2d sum = Vector2d::Zero();
        double count = 0, spread = 0;
        for (int ray = 0; ray < rays; ++ray) {
            const double edge = edge_mm[static_cast<std::size_t>(ray)];
            if (edge == 0 || std::fabs(edge - radius_mm) > allowed) continue;
            const double angle = 2 * std::numbers::pi * ray / rays;
            sum += (edge - radius_mm) * Vector2d(std::cos(angle), std::sin(angle));
            spread += edge;
            count += 1;
        }
        if (count < 0.5 * rays) return std::nullopt;
        disc = {slice.index, middle, spread / count, 0, 0, count / rays};
        if (round == 3) break;
        middle += slice.voxels(2.0 / count * sum);
        if (!slice.holds(middle)) return std::nullopt;
    }
    if (disc.share < share_least) return std::nullopt;
    core = core_at(slice, middle, 0.75 * disc.radius_mm);
    if (!may_be_blood(core)) return std::nullopt;
    disc.mean_HU = core.mean_HU;
    disc.noise_HU = core.noise_HU;
    return disc;
}

std::vector<Disc> discs_of(const Volume &scan, int index)
{
    const Slice slice{scan, index};
    std::vector<Disc> discs;
    const Vector2d step = slice.voxels({seed_step_mm, seed_step_mm});
    const auto is_known = [&](const Vector2d &at, double reach) {
        return std::any_of(discs.begin(), discs.end(), [&](const Disc &disc) {
            return (at - disc.middle).cwiseProduct(scan.spacing_mm.head<2>()).norm() < reach * disc.radius_mm;
        });
    };
    for (double y = step.y(); y < scan.size[1] - 1; y += step.y())
        for (double x = step.x(); x < scan.size[0] - 1; x += step.x()) {
            const Vector2d seed(x, y);
            const double value = slice.value(seed);
            if (value < blood_least_HU || value > blood_most_HU || is_known(seed, 0.9)) continue;
            const std::optional<Disc> disc = disc_at(slice, seed);
            if (disc && !is_known(disc->middle, 0.5)) discs.push_back(*disc);
        }
    return discs;
}

// What a disc adds to a stack: its height, more for brighter blood, which tells arteries from veins.
double worth(const Disc &disc, double slice_mm)
{
    return slice_mm * disc.share * std::clamp((disc.mean_HU - beside_HU) / 300.0, 0.3, 1.0);
}

bool continues(const Volume &scan, const Disc &lower, const Disc &upper)
{
    const double rise_mm = (upper.slice - lower.slice) * scan.spacing_mm[2];
    const double aside_mm = (upper.middle - lower.middle).cwiseProduct(scan.spacing_mm.head<2>()).norm();
    const double ratio = upper.radius_mm / lower.radius_mm;
    return aside_mm < 1.0 + 0.8 * rise_mm && ratio > 0.8 && ratio < 1.25 &&
           std::fabs(upper.mean_HU - lower.mean_HU) < 0.15 * std::max(upper.mean_HU, lower.mean_HU);
}

struct Link {
    Disc disc;
    long before = -1;
    double sum = 0;
    bool is_used = false;
};

// Links every disc with the best stack that ends below it.
std::vector<Link> links_of(const Volume &scan)
{
    constexpr double gap_mm = 8.0;
    const double slice_mm = scan.spacing_mm[2];
    std::vector<Link> links;
    const int step = std::max(1, static_cast<int>(1.5 / slice_mm));
    std::size_t oldest = 0;
    for (int k = 0; k < scan.size[2]; k += step) {
        const std::size_t first = links.size();
        while (oldest < first && (k - links[oldest].disc.slice) * slice_mm > gap_mm) ++oldest;
        for (const Disc &disc : discs_of(scan, k)) {
            Link link{disc, -1, worth(disc, slice_mm * step), false};
            for (std::size_t other = oldest; other < first; ++other) {
                const double sum = links[other].sum + worth(disc, slice_mm * step);
                if (sum > link.sum && continues(scan, links[other].disc, disc))
                    link.before = static_cast<long>(other), link.sum = sum;
            }
            links.push_back(link);
        }
    }
    return links;
}

} // namespace

std::vector<Stack> round_stacks(const Volume &scan, double least_mm)
{
    std::vector<Link> links = links_of(scan);
    std::vector<std::size_t> order(links.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return links[a].sum > links[b].sum; });
    std::vector<Stack> stacks;
    for (const std::size_t top : order) {
        Stack stack;
        for (long at = static_cast<long>(top); at >= 0 && !links[static_cast<std::size_t>(at)].is_used;
             at = links[static_cast<std::size_t>(at)].before) {
            links[static_cast<std::size_t>(at)].is_used = true;
            stack.push_back(links[static_cast<std::size_t>(at)].disc);
        }
        if (stack.empty() || (stack.front().slice - stack.back().slice) * scan.spacing_mm[2] < least_mm)
            continue;
        std::reverse(stack.begin(), stack.end());
        stacks.push_back(std::move(stack));
    }
    return stacks;
}

Stack descending_aorta(const std::vector<Stack> &stacks, const std::string &name)
{
    if (stacks.empty())
        throw Fault(
            name +
            ": no aorta is found: no bright round vessel goes through 12 mm of axial slices. Either the "
            "scan has no arterial contrast medium, or the aorta is not in it: give another series, a "
            "label map (--labels, --names), or a click into an artery of 3 mm or more (--click "
            "artery:x,y,z)");
    return stacks.front();
}

Contrast contrast_of(const Stack &stack)
{
    std::vector<double> means, noises;
    for (const Disc &disc : stack) {
        means.push_back(disc.mean_HU);
        noises.push_back(disc.noise_HU);
    }
    return {median(means), std::max(median(noises), 5.0)};
}

Eigen::Vector3d place_of(const Volume &scan, const Disc &disc)
{
    return scan.scene({disc.middle.x(), disc.middle.y(), 1.0 * disc.slice});
}

} // namespace crn::ct
