#include "tools/patient/naming.hpp"
#include "tools/mesh/median.hpp"
#include <algorithm>
#include <cmath>
#include <map>

namespace crn::patient
{

namespace
{

using centreline::Branch;
using centreline::Tree;
using Eigen::Vector3d;

// The shape of one branch beyond its parent's wall.
struct Shape {
    double radius_mm, length_mm; // median; beyond the parent's wall
    Vector3d start, end, leaves; // `leaves`: direction of the first 15 mm
    std::vector<std::size_t> children;
};

class Namer
{
  public:
    explicit Namer(Tree &tree) : tree_(tree)
    {
        for (std::size_t i = 0; i < tree.branches.size(); ++i) shapes_.push_back(shape_of(i));
        for (std::size_t i = 0; i < tree.branches.size(); ++i) {
            tree.branches[i].name.clear();
            if (tree.branches[i].parent >= 0)
                shapes_[static_cast<std::size_t>(tree.branches[i].parent)].children.push_back(i);
        }
        for (std::size_t i = tree.branches.size(); i-- > 0;)
            look_ahead(i); // parents come before their branches
    }
    void name_all()
    {
        if (shapes_.empty()) return;
        find_trunk();
        for (const std::size_t i : trunk_) give(i, "aorta");
        name_arch();
        name_abdomen();
        name_iliacs();
        int number = 0;
        for (Branch &branch : tree_.branches)
            if (branch.name.empty()) branch.name = "branch_" + std::to_string(++number);
    }

  private:
    static constexpr double takeoff_mm = 15, vessel_least_mm = 1.2, length_least_mm = 12;

    Shape shape_of(std::size_t i) const
    {
        const Branch &branch = tree_.branches[i];
        const std::size_t first = std::min(centreline::first_own_sphere(tree_, i), branch.spheres.size() - 1);
        Shape shape{0, 0, branch.spheres[first].centre_mm, branch.spheres.back().centre_mm, {}, {}};
        std::vector<double> radii;
        for (std::size_t n = first; n < branch.spheres.size(); ++n) {
            radii.push_back(branch.spheres[n].radius_mm);
            if (n > first)
                shape.length_mm += (branch.spheres[n].centre_mm - branch.spheres[n - 1].centre_mm).norm();
        }
        shape.radius_mm = mesh::median(radii);
        return shape;
    }
    // A branch that a junction cuts soon has the radius and direction of the long, wide vessel that it leads
    // to.
    void look_ahead(std::size_t i)
    {
        Shape &shape = shapes_[i];
        double passed_mm = 0;
        Vector3d ahead = shape.start;
        for (std::size_t at = i;;) {
            const std::vector<centreline::Sphere> &spheres = tree_.branches[at].spheres;
            const std::size_t first = std::min(centreline::first_own_sphere(tree_, at), spheres.size() - 1);
            for (std::size_t n = first; n < spheres.size() && passed_mm < takeoff_mm; ++n) {
                if (n > first) passed_mm += (spheres[n].centre_mm - spheres[n - 1].centre_mm).norm();
                ahead = spheres[n].centre_mm;
            }
            const std::vector<std::size_t> &children = shapes_[at].children;
            if (passed_mm >= takeoff_mm || children.empty()) break;
            at = main_child(at);
            if (at != i && shapes_[i].length_mm < 0.5 * takeoff_mm) shape.radius_mm = shapes_[at].radius_mm;
        }
        shape.leaves = (ahead - tree_.branches[i].spheres.front().centre_mm).normalized();
    }

    // The child that is longest, with all that it gives off, and widest.
    std::size_t main_child(std::size_t i) const
    {
        const std::vector<std::size_t> &children = shapes_[i].children;
        return *std::max_element(children.begin(), children.end(), [&](std::size_t a, std::size_t b) {
            return reach_mm(a) * shapes_[a].radius_mm < reach_mm(b) * shapes_[b].radius_mm;
        });
    }

    // Gives a vessel its name, with a number if it is there already.
    void give(std::size_t i, const std::string &name)
    {
        const int number = ++used_[name];
        tree_.branches[i].name = number > 1 ? name + "_" + std::to_string(number) : name;
    }
    // The same for the branches that go on straight and as wide.
    void give_along(std::size_t i, const std::string &name)
    {
        give(i, name);
        for (;;) {
            const Shape &shape = shapes_[i];
            if (shape.children.empty()) return;
            const std::size_t next = main_child(i);
            if (shapes_[next].radius_mm < 0.75 * shape.radius_mm || !tree_.branches[next].name.empty())
                return;
            i = next;
            give(i, name);
        }
    }

    double lowest_below(std::size_t i) const
    {
        double lowest = INFINITY;
        for (const centreline::Sphere &sphere : tree_.branches[i].spheres)
            lowest = std::min(lowest, sphere.centre_mm.y());
        for (const std::size_t child : shapes_[i].children) lowest = std::min(lowest, lowest_below(child));
        return lowest;
    }
    double reach_mm(std::size_t i) const // of the branch with all that it gives off
    {
        double most = 0;
        for (const std::size_t child : shapes_[i].children) most = std::max(most, reach_mm(child));
        return shapes_[i].length_mm + most;
    }

    // Follows the widest child until the aorta divides into two alike, or ends.
    void find_trunk()
    {
        for (std::size_t i = 0;;) {
            trunk_.push_back(i);
            const double radius_mm = shapes_[i].radius_mm;
            std::vector<std::size_t> wide = shapes_[i].children;
            std::sort(wide.begin(), wide.end(), [&](std::size_t a, std::size_t b) {
                return shapes_[a].radius_mm > shapes_[b].radius_mm;
            });
            if (wide.empty() || shapes_[wide[0]].radius_mm < 0.4 * radius_mm) return;
            if (wide.size() > 1 && is_bifurcation(radius_mm, shapes_[wide[0]], shapes_[wide[1]])) {
                iliacs_ = {wide[0], wide[1]};
                return;
            }
            i = wide[0];
        }
    }
    static bool is_bifurcation(double radius_mm, const Shape &a, const Shape &b)
    {
        const bool are_alike = b.radius_mm > 0.6 * a.radius_mm && a.radius_mm < 0.85 * radius_mm;
        return are_alike && a.end.y() < a.start.y() - 15 && b.end.y() < b.start.y() - 15 &&
               (a.end.x() - a.start.x()) * (b.end.x() - b.start.x()) < 0;
    }

    // Branches that leave the aorta, in the order of the blood.
    std::vector<std::size_t> side_branches() const
    {
        std::vector<std::size_t> found;
        for (const std::size_t i : trunk_)
            for (const std::size_t child : shapes_[i].children)
                if (std::find(trunk_.begin(), trunk_.end(), child) == trunk_.end() &&
                    std::find(iliacs_.begin(), iliacs_.end(), child) == iliacs_.end() &&
                    shapes_[child].radius_mm >= vessel_least_mm && reach_mm(child) >= length_least_mm)
                    found.push_back(child);
        return found;
    }
    double top_mm() const
    {
        double top = -INFINITY;
        for (const std::size_t i : trunk_)
            for (const centreline::Sphere &sphere : tree_.branches[i].spheres)
                top = std::max(top, sphere.centre_mm.y());
        return top;
    }

    // Where the aorta begins at its root and goes over the arch: brachiocephalic trunk, left common carotid
    // and left subclavian artery leave it upwards near its top, in this order.
    void name_arch()
    {
        const Vector3d root = tree_.branches[trunk_.front()].spheres.front().centre_mm,
                       end = tree_.branches[trunk_.back()].spheres.back().centre_mm;
        const double top = top_mm();
        if (top - root.y() < 25 || top - end.y() < 25 || root.z() < end.z()) return;
        std::vector<std::size_t> arch, heart;
        for (const std::size_t i : side_branches()) {
            const Vector3d from = tree_.branches[i].spheres.front().centre_mm;
            if (from.y() > top - 45 && shapes_[i].leaves.y() > 0.2 && reach_mm(i) > 20)
                arch.push_back(i);
            else if ((from - root).norm() < 45)
                heart.push_back(i);
        }
        if (arch.size() > 3) // a left vertebral artery of its own, or a small branch
            arch.erase(std::min_element(arch.begin() + 1, arch.end() - 1, [&](std::size_t a, std::size_t b) {
                return shapes_[a].radius_mm < shapes_[b].radius_mm;
            }));
        if (!arch.empty()) name_brachiocephalic(arch.front());
        if (arch.size() > 2) give_along(arch[1], "left_common_carotid_artery");
        if (arch.size() == 2) name_left_of_arch(arch.back());
        if (arch.size() > 2) give_along(arch.back(), "left_subclavian_artery");
        std::sort(heart.begin(), heart.end(),
                  [&](std::size_t a, std::size_t b) { return shapes_[a].radius_mm > shapes_[b].radius_mm; });
        for (const std::size_t i : heart) {
            const char *name =
                shapes_[i].end.x() > root.x() ? "left_coronary_artery" : "right_coronary_artery";
            if (!used_.count(name)) give_along(i, name);
        }
    }
    // The second of two branches is the subclavian artery, or leads to it and to the carotid artery.
    void name_left_of_arch(std::size_t i)
    {
        std::vector<std::size_t> children;
        for (const std::size_t child : shapes_[i].children)
            if (reach_mm(child) > 30) children.push_back(child);
        if (children.size() < 2 || shapes_[i].length_mm > 20) {
            give_along(i, "left_subclavian_artery");
            return;
        }
        const auto [right, left] = outermost(children);
        give_along(left, "left_subclavian_artery");
        give_along(right, "left_common_carotid_artery");
    }
    // Those whose ends lie farthest to the patient's right and left.
    std::pair<std::size_t, std::size_t> outermost(const std::vector<std::size_t> &branches) const
    {
        const auto [right, left] =
            std::minmax_element(branches.begin(), branches.end(), [&](std::size_t a, std::size_t b) {
                return shapes_[a].end.x() < shapes_[b].end.x();
            });
        return {*right, *left};
    }
    void name_brachiocephalic(std::size_t i)
    {
        give(i, "brachiocephalic_trunk");
        const std::vector<std::size_t> &children = shapes_[i].children;
        if (children.size() < 2) return;
        const auto [right, left] = outermost(children);
        // In the bovine arch, the left carotid artery leaves the brachiocephalic trunk, which goes on.
        if (shapes_[i].length_mm < 20 && shapes_[left].end.x() > shapes_[i].start.x() + 10 &&
            !used_.count("left_common_carotid_artery")) {
            give_along(left, "left_common_carotid_artery");
            name_brachiocephalic(right);
            return;
        }
        give_along(right, "right_subclavian_artery");
        give_along(left, "right_common_carotid_artery");
    }

    // Below the arch: renal arteries leave sideways; coeliac trunk, superior and inferior mesenteric artery
    // to the front, from above downwards.
    void name_abdomen()
    {
        std::vector<std::size_t> front;
        std::array<std::vector<std::size_t>, 2> side; // right, left
        for (const std::size_t i : side_branches()) {
            if (!tree_.branches[i].name.empty() ||
                tree_.branches[i].spheres.front().centre_mm.y() > top_mm() - 60)
                continue;
            const Vector3d &to = shapes_[i].leaves;
            if (to.z() > 0.35 && to.z() > std::fabs(to.x()))
                front.push_back(i);
            else if (std::fabs(to.x()) > std::fabs(to.y()) && to.z() > -0.6 && shapes_[i].radius_mm > 1.4 &&
                     reach_mm(i) > 25)
                side[to.x() > 0 ? 1 : 0].push_back(i);
        }
        const double renal_y = name_renals(side);
        name_front(front, renal_y);
    }
    // The widest of each side; returns their mean height.
    double name_renals(const std::array<std::vector<std::size_t>, 2> &side)
    {
        double sum = 0, count = 0;
        for (std::size_t n = 0; n < 2; ++n) {
            if (side[n].empty()) continue;
            std::vector<std::size_t> sorted = side[n];
            std::sort(sorted.begin(), sorted.end(), [&](std::size_t a, std::size_t b) {
                return shapes_[a].radius_mm > shapes_[b].radius_mm;
            });
            for (const std::size_t i : sorted) {
                if (std::fabs(shapes_[i].start.y() - shapes_[sorted.front()].start.y()) > 50) continue;
                give_along(i, n == 1 ? "left_renal_artery" : "right_renal_artery");
            }
            sum += shapes_[sorted.front()].start.y();
            count += 1;
        }
        return count > 0 ? sum / count : NAN;
    }
    void name_front(const std::vector<std::size_t> &front, double renal_y)
    {
        for (const std::size_t i : front) {
            const double y = shapes_[i].start.y();
            const bool is_low = !std::isnan(renal_y) && y < renal_y - 20;
            if (is_low) {
                if (!used_.count("inferior_mesenteric_artery")) give_along(i, "inferior_mesenteric_artery");
            } else if (lowest_below(i) < y - 45 || used_.count("coeliac_trunk")) {
                if (!used_.count("superior_mesenteric_artery")) give_along(i, "superior_mesenteric_artery");
            } else {
                name_coeliac(i);
            }
        }
    }
    void name_coeliac(std::size_t i)
    {
        give(i, "coeliac_trunk");
        const std::vector<std::size_t> &children = shapes_[i].children;
        if (children.size() < 2) return;
        const auto [right, left] = outermost(children);
        give_along(right, "common_hepatic_artery");
        give_along(left, "splenic_artery");
    }

    // Each common iliac artery divides into the internal one, to the back, and the external one, which goes
    // on.
    void name_iliacs()
    {
        for (const std::size_t i : iliacs_) {
            const std::string side = shapes_[i].end.x() > shapes_[i].start.x() ? "left" : "right";
            give(i, side + "_common_iliac_artery");
            std::size_t at = i;
            for (;;) {
                std::vector<std::size_t> wide;
                for (const std::size_t child : shapes_[at].children)
                    if (shapes_[child].radius_mm > 0.35 * shapes_[at].radius_mm && reach_mm(child) > 20)
                        wide.push_back(child);
                if (wide.empty()) break;
                const auto [back, front] =
                    std::minmax_element(wide.begin(), wide.end(), [&](std::size_t a, std::size_t b) {
                        return shapes_[a].end.z() < shapes_[b].end.z();
                    });
                if (wide.size() == 1) { // a small branch cut the vessel in two
                    give(at = wide.front(), side + "_common_iliac_artery");
                    continue;
                }
                give_along(*back, side + "_internal_iliac_artery");
                give_along(*front, side + "_external_iliac_artery");
                break;
            }
        }
    }

    Tree &tree_;
    std::vector<Shape> shapes_;
    std::vector<std::size_t> trunk_, iliacs_;
    std::map<std::string, int> used_;
};

} // namespace

void propose_names(centreline::Tree &tree)
{
    Namer(tree).name_all();
}

} // namespace crn::patient
