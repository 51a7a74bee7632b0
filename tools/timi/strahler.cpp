#include "tools/timi/strahler.hpp"
#include <algorithm>
#include <stdexcept>

namespace anatomy
{

namespace
{

struct Fork {
    size_t point; // of the vessel, at which another one leaves
    int order;
};

/* Elements of one vessel, from its end to its beginning. */
class Orders
{
  public:
    explicit Orders(int lowest) : lowest_(lowest) {}

    int of_vessel(const crn::VesselBranch &vessel, std::vector<Fork> forks)
    {
        std::sort(forks.begin(), forks.end(), [](const Fork &a, const Fork &b) { return a.point > b.point; });
        int order = lowest_;
        bool is_end = true; // an order at the very end is that of the fork there
        size_t to = vessel.points_m.size() - 1;
        for (const Fork &fork : forks) {
            const int higher = is_end && fork.point == to ? std::max(order, fork.order)
                               : fork.order == order      ? order + 1
                                                          : std::max(order, fork.order);
            is_end = false;
            if (higher == order) continue;
            add(vessel, fork.point, to, order);
            to = fork.point;
            order = higher;
        }
        add(vessel, 0, to, order);
        return order;
    }

    std::vector<StrahlerOrder> means() const
    {
        std::vector<StrahlerOrder> means = sums_;
        for (StrahlerOrder &one : means) {
            one.diameter_mm /= static_cast<double>(std::max<size_t>(one.elements, 1));
            one.length_mm /= static_cast<double>(std::max<size_t>(one.elements, 1));
        }
        return means;
    }

  private:
    void add(const crn::VesselBranch &vessel, size_t from, size_t to, int order)
    {
        double length_mm = 0.0, area_mm2 = 0.0;
        for (size_t i = from; i < to; i++) {
            const double step_mm = (vessel.points_m[i + 1] - vessel.points_m[i]).norm() * 1e3;
            length_mm += step_mm;
            area_mm2 += step_mm * (vessel.radii_m[i] + vessel.radii_m[i + 1]) * 1e3;
        }
        if (!(length_mm > 0.0)) return;
        while (lowest_ + static_cast<int>(sums_.size()) <= order)
            sums_.push_back({lowest_ + static_cast<int>(sums_.size()), 0, 0.0, 0.0});
        StrahlerOrder &sum = sums_[static_cast<size_t>(order - lowest_)];
        sum.elements++;
        sum.length_mm += length_mm;
        sum.diameter_mm += area_mm2 / length_mm;
    }

    int lowest_;
    std::vector<StrahlerOrder> sums_;
};

} // namespace

std::vector<StrahlerOrder> strahler_orders(const crn::VesselTree &tree, const std::string &branch, int lowest)
{
    const size_t count = tree.branches.size() + tree.small.size();
    const auto vessel = [&](size_t i) -> const crn::VesselBranch & { return tree.numbered(i); };
    size_t root = 0;
    while (root < tree.branches.size() && tree.branches[root].name != branch) root++;
    if (root == tree.branches.size()) throw std::invalid_argument("the tree has no vessel '" + branch + "'");
    std::vector<bool> is_in(count, false);
    is_in[root] = true;
    for (size_t i = root + 1; i < count; i++)
        is_in[i] =
            !vessel(i).is_vein && vessel(i).parent >= 0 && is_in[static_cast<size_t>(vessel(i).parent)];
    std::vector<std::vector<Fork>> forks(count);
    Orders orders(lowest);
    for (size_t i = count; i-- > root;) {
        if (!is_in[i]) continue;
        const int order = orders.of_vessel(vessel(i), forks[i]);
        if (i != root)
            forks[static_cast<size_t>(vessel(i).parent)].push_back({vessel(i).parent_point, order});
    }
    return orders.means();
}

} // namespace anatomy
