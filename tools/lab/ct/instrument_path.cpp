#include "tools/lab/ct/instrument_path.hpp"
#include "host/base/format.hpp"
#include "tools/mesh/fault.hpp"
#include <algorithm>
#include <cmath>
#include <functional>
#include <queue>

namespace crn::ct
{

using Eigen::Vector3d;

namespace
{

constexpr double branch_mm = 6; // length of voxels off the path that show a second instrument

// The instrument's voxels, and bridges across gaps between them, form a graph. The shortest paths of the
// graph of voxels follow the brightest line through the voxels.
class Ways
{
  public:
    Ways(const Volume &volume, const Volume &mask, double threshold) : volume_(volume), mask_(mask)
    {
        step_ = volume.scene_per_voxel();
        bridge_ = 0.35 * threshold;
        top_ = static_cast<double>(*std::max_element(volume.hu.begin(), volume.hu.end()));
        for (std::size_t i = 0; i < mask.hu.size(); ++i)
            if (mask.hu[i] > 0) inside_.push_back(i);
        depth_ = depths();
    }

    const std::vector<std::size_t> &voxels() const { return inside_; }

    // Computes the costs of the cheapest paths from one voxel to all others; `before` stores the preceding
    // voxel on each path. The search does not stop early, because the costs of all voxels of the instrument
    // are needed.
    void spread(std::size_t start, std::vector<double> &cost, std::vector<std::size_t> &before) const
    {
        using Entry = std::pair<double, std::size_t>;
        cost.assign(volume_.count(), 1e30);
        before.assign(volume_.count(), start);
        std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
        cost[start] = 0;
        open.push({0, start});
        while (!open.empty()) {
            const auto [so_far, at] = open.top();
            open.pop();
            if (so_far > cost[at]) continue;
            const std::array<int, 3> c = index(at);
            for (int n = 0; n < 27; ++n) {
                const int d[3] = {n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
                if (n == 13 || !volume_.holds(c[0] + d[0], c[1] + d[1], c[2] + d[2])) continue;
                const std::size_t next = volume_.at(c[0] + d[0], c[1] + d[1], c[2] + d[2]);
                const double price = price_of(next);
                if (price > 1e9) continue;
                const double there = so_far + price * (step_ * Vector3d(d[0], d[1], d[2])).norm();
                if (there < cost[next]) {
                    cost[next] = there;
                    before[next] = at;
                    open.push({there, next});
                }
            }
        }
    }

    std::array<int, 3> index(std::size_t at) const
    {
        const auto row = static_cast<std::size_t>(volume_.size[0]),
                   slice = row * static_cast<std::size_t>(volume_.size[1]);
        return {static_cast<int>(at % row), static_cast<int>(at % slice / row), static_cast<int>(at / slice)};
    }
    Vector3d place(std::size_t at) const
    {
        const std::array<int, 3> c = index(at);
        return volume_.scene({double(c[0]), double(c[1]), double(c[2])});
    }

  private:
    // Numbers the layers of voxels from the border of the instrument inwards, so that the innermost layer of
    // a saturated region has the highest number.
    std::vector<std::uint8_t> depths() const
    {
        std::vector<std::uint8_t> depth(volume_.count(), 0);
        for (const std::size_t at : inside_) depth[at] = 1;
        for (std::uint8_t shell = 1; shell < 6; ++shell) {
            std::vector<std::size_t> deeper;
            for (const std::size_t at : inside_) {
                if (depth[at] != shell) continue;
                const std::array<int, 3> c = index(at);
                bool is_deeper = true;
                for (int axis = 0; axis < 3; ++axis)
                    for (const int sign : {-1, 1}) {
                        std::array<int, 3> n = c;
                        n[static_cast<std::size_t>(axis)] += sign;
                        is_deeper = is_deeper && (!volume_.holds(n[0], n[1], n[2]) ||
                                                  depth[volume_.at(n[0], n[1], n[2])] >= shell);
                    }
                if (is_deeper) deeper.push_back(at);
            }
            for (const std::size_t at : deeper) depth[at] = static_cast<std::uint8_t>(shell + 1);
        }
        return depth;
    }

    double price_of(std::size_t at) const
    {
        const double hu = static_cast<double>(volume_.hu[at]);
        if (mask_.hu[at] <= 0)
            return hu > bridge_ ? 40 : 1e10; // crosses a gap where something bright leads through it
        const double dimness = 1 - std::clamp(hu / top_, 0.0, 1.0);
        return 1 + 6 * dimness * dimness + 4.0 / (depth_[at] * depth_[at]);
    }

    const Volume &volume_, &mask_;
    Eigen::Matrix3d step_;
    double bridge_, top_;
    std::vector<std::size_t> inside_;
    std::vector<std::uint8_t> depth_;
};

bool is_at_border(const Volume &volume, const std::array<int, 3> &index)
{
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (index[axis] < 2 || index[axis] >= volume.size[axis] - 2) return true;
    return false;
}

std::string middle_text(const Vector3d &p)
{
    return formatted("(%.0f, %.0f, %.0f) mm", p.x(), p.y(), p.z());
}

// Voxels away from the path belong to another object if they extend over more than a certain length.
void refuse_branches(const Ways &ways, const std::vector<Vector3d> &path, const Volume &volume)
{
    Eigen::AlignedBox3d stray;
    std::size_t count = 0;
    for (const std::size_t at : ways.voxels()) {
        const Vector3d place = ways.place(at);
        if (distance_from(path, place).distance_mm < 3) continue;
        stray.extend(place);
        ++count;
    }
    if (count > 20 && stray.sizes().norm() > branch_mm)
        throw Fault(volume.name +
                    ": two instruments that touch, or one that crosses itself: bright voxels around " +
                    middle_text(stray.center()) +
                    " lie beside the way from end to end; scan one alone, or raise --threshold");
}

} // namespace

std::vector<Vector3d> path_through(const Volume &volume, const Volume &mask, const LineOptions &options,
                                   std::vector<std::string> &notes)
{
    const Ways ways(volume, mask, options.threshold_HU);
    std::vector<double> cost;
    std::vector<std::size_t> before;
    const auto farthest = [&] {
        std::size_t far = ways.voxels().front();
        double most = -1;
        for (const std::size_t at : ways.voxels())
            if (cost[at] < 1e29 && cost[at] > most) {
                most = cost[at];
                far = at;
            }
        return far;
    };
    ways.spread(ways.voxels().front(), cost, before);
    const std::size_t one = farthest();
    ways.spread(one, cost, before);
    const std::size_t other = farthest();
    std::vector<Vector3d> path;
    for (std::size_t at = other;; at = before[at]) {
        path.push_back(ways.place(at));
        if (at == one) break;
    }
    refuse_branches(ways, path, volume);
    // If mouth_mm is given, the path begins at the end of the instrument that is nearest to mouth_mm. If
    // mouth_mm is not given, the path begins at the end of the instrument that leaves the scanned region. If
    // both ends or no end of the instrument leave the scanned region, the path begins at the lower end.
    bool begins_at_mouth = path.front().y() < path.back().y();
    if (options.mouth_mm) {
        begins_at_mouth = (path.front() - *options.mouth_mm).dot(options.direction) <
                          (path.back() - *options.mouth_mm).dot(options.direction);
    } else if (const bool front = is_at_border(volume, ways.index(other)),
               back = is_at_border(volume, ways.index(one));
               front != back) {
        begins_at_mouth = front;
    } else {
        notes.push_back("both ends of the instrument may be its tip: the lower one is taken as the mouth's; "
                        "give --mouth");
    }
    if (!begins_at_mouth) std::reverse(path.begin(), path.end());
    return path;
}

} // namespace crn::ct
