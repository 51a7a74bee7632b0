#include "tools/anatomy/soft/lung_vessels.hpp"
#include "tools/anatomy/soft/tube_mesh.hpp"
#include "tools/mesh/spread.hpp"
#include <algorithm>
#include <cmath>
#include <cstdint>

namespace anatomy
{

namespace
{

constexpr double MURRAY_EXPONENT = 2.4, WIDE_RADIUS_MM = 2.2, LUNG_STEP_MM = 5.0;
constexpr int ROUND_PASSES = 4;

// --- where the vessels end ---

/* Returns evenly spread points in the lung, those nearest to the hilum first. Vessels of a radiograph fade
 * before they reach the pleura. */
std::vector<Vec3> vessel_ends(const LungSpace &space, const Box &box, const Vec3 &hilum, uint32_t first)
{
    constexpr double PLEURA_MM = 9.0;
    constexpr uint32_t CANDIDATES = 4600; // a quarter to a third of them lie in the lung
    using crn::mesh::spread;
    std::vector<Vec3> ends;
    for (uint32_t i = first; i < first + CANDIDATES; i++) {
        const Vec3 share(spread(i, 2), spread(i, 3), spread(i, 5));
        const Vec3 point = box.low + share.cwiseProduct(box.high - box.low);
        if (space.distance(point) < -PLEURA_MM) ends.push_back(point);
    }
    std::stable_sort(ends.begin(), ends.end(), [&](const Vec3 &a, const Vec3 &b) {
        return (a - hilum).squaredNorm() < (b - hilum).squaredNorm();
    });
    return ends;
}

// --- growth ---

struct LungNode {
    Vec3 at;
    int parent;
    double path_mm;
    int ends = 0; // behind it
    std::vector<int> children;
};

class LungGrowth
{
  public:
    LungGrowth(const LungSpace &space, const Vec3 &hilum) : space_(space), hilum_(hilum)
    {
        nodes_.push_back({hilum, -1, 0.0, 0, {}});
    }
    /* Adds a stem of a given course from the hilum. */
    void add_stem(const std::vector<Vec3> &points);
    bool grow_to(const Vec3 &end);
    LungTree tree();

  private:
    bool is_free(const Vec3 &from, const Vec3 &to) const;
    int add_branch(int parent, const Vec3 &end);
    void count_ends();
    double radius_mm(int node) const;
    int widest_child(int node) const;
    LungVessel trace(int from, int first, std::vector<std::pair<int, int>> &others) const;

    const LungSpace &space_;
    Vec3 hilum_;
    std::vector<LungNode> nodes_;
};

/* Returns whether the straight way stays inside the lung. Near the hilum, vessels run outside of it. */
bool LungGrowth::is_free(const Vec3 &from, const Vec3 &to) const
{
    constexpr double MARGIN_MM = 4.5, SAMPLE_MM = 4.0, HILUM_MM = 45.0;
    const int samples = static_cast<int>(std::ceil((to - from).norm() / SAMPLE_MM));
    for (int i = 0; i < samples; i++) {
        const Vec3 point = from + (to - from) * i / samples;
        if ((point - hilum_).norm() > HILUM_MM && space_.distance(point) > -MARGIN_MM) return false;
    }
    return true;
}

/* Adds nodes on the straight way from a node, and returns the last one. */
int LungGrowth::add_branch(int parent, const Vec3 &end)
{
    const Vec3 start = nodes_[static_cast<size_t>(parent)].at;
    const double length = (end - start).norm();
    const int steps = std::max(1, static_cast<int>(std::lround(length / LUNG_STEP_MM)));
    for (int k = 1; k <= steps; k++) {
        const double path = nodes_[static_cast<size_t>(parent)].path_mm + length / steps;
        const int own = static_cast<int>(nodes_.size());
        nodes_[static_cast<size_t>(parent)].children.push_back(own);
        nodes_.push_back({start + (end - start) * k / steps, parent, path, 0, {}});
        parent = own;
    }
    return parent;
}

void LungGrowth::add_stem(const std::vector<Vec3> &points)
{
    constexpr double STEM_PATH = 0.3; // ends join a stem rather than the hilum
    const size_t first = nodes_.size();
    int node = 0;
    for (const Vec3 &point : points) node = add_branch(node, point);
    for (size_t i = first; i < nodes_.size(); i++) nodes_[i].path_mm *= STEM_PATH;
}

/* Joins an end to the node with the smallest sum of two lengths: the new branch, and the weighted path from
 * the node back to the hilum. */
bool LungGrowth::grow_to(const Vec3 &end)
{
    constexpr double WAY_BACK = 0.55;
    constexpr size_t TRIES = 12;
    std::vector<std::pair<double, int>> costs;
    for (size_t i = 0; i < nodes_.size(); i++)
        costs.emplace_back((end - nodes_[i].at).norm() + WAY_BACK * nodes_[i].path_mm, static_cast<int>(i));
    const size_t tries = std::min(TRIES, costs.size());
    std::partial_sort(costs.begin(), costs.begin() + static_cast<std::ptrdiff_t>(tries), costs.end());
    for (size_t i = 0; i < tries; i++) {
        const int parent = costs[i].second;
        if (!is_free(nodes_[static_cast<size_t>(parent)].at, end)) continue;
        nodes_[static_cast<size_t>(add_branch(parent, end))].ends = 1;
        return true;
    }
    return false;
}

/* A child always comes after its parent. */
void LungGrowth::count_ends()
{
    for (size_t i = nodes_.size(); i-- > 1;)
        nodes_[static_cast<size_t>(nodes_[i].parent)].ends += nodes_[i].ends;
}

double LungGrowth::radius_mm(int node) const
{
    const int ends = std::max(1, nodes_[static_cast<size_t>(node)].ends);
    return LUNG_END_RADIUS_MM * std::pow(ends, 1.0 / MURRAY_EXPONENT);
}

int LungGrowth::widest_child(int node) const
{
    int widest = -1;
    for (int child : nodes_[static_cast<size_t>(node)].children)
        if (widest < 0 || nodes_[static_cast<size_t>(child)].ends > nodes_[static_cast<size_t>(widest)].ends)
            widest = child;
    return widest;
}

/* Follows the wider branch at every fork, and notes the others with the index of the point where they leave.
 */
LungVessel LungGrowth::trace(int from, int first, std::vector<std::pair<int, int>> &others) const
{
    LungVessel vessel;
    vessel.course.push_back({nodes_[static_cast<size_t>(from)].at, radius_mm(first), 0.0});
    for (int node = first; node >= 0;) {
        vessel.course.push_back({nodes_[static_cast<size_t>(node)].at, radius_mm(node), 0.0});
        const int widest = widest_child(node);
        for (int child : nodes_[static_cast<size_t>(node)].children)
            if (child != widest) others.emplace_back(child, static_cast<int>(vessel.course.size()) - 1);
        node = widest;
    }
    round_corners(vessel.course, ROUND_PASSES);
    return vessel;
}

LungTree LungGrowth::tree()
{
    struct Start {
        int node, from;
        size_t vessel, point;
    };
    count_ends();
    LungTree tree;
    tree.ends = static_cast<size_t>(nodes_.front().ends);
    std::vector<Start> starts;
    for (int child : nodes_.front().children) starts.push_back({child, 0, 0, 0});
    for (size_t i = 0; i < starts.size(); i++) {
        const Start start = starts[i];
        std::vector<std::pair<int, int>> others;
        LungVessel vessel = trace(start.from, start.node, others);
        if (start.from != 0) {
            const Curve &parent = tree.vessels[start.vessel].course;
            vessel.course.front().position_mm = parent[start.point].position_mm;
            vessel.parent_radius_mm = parent[start.point].radius_mm;
            vessel.parent_direction = curve_tangent(parent, start.point);
        }
        for (const auto &[child, point] : others)
            starts.push_back({child, nodes_[static_cast<size_t>(child)].parent, tree.vessels.size(),
                              static_cast<size_t>(point)});
        tree.vessels.push_back(std::move(vessel));
    }
    return tree;
}

struct Hilum {
    Vec3 at;
    std::vector<std::vector<Vec3>> stems;
};

LungTree grown_tree(const LungSpace &space, const Box &box, const Hilum &hilum, uint32_t first)
{
    LungGrowth growth(space, hilum.at);
    for (const std::vector<Vec3> &stem : hilum.stems) growth.add_stem(stem);
    for (const Vec3 &end : vessel_ends(space, box, hilum.at, first)) growth.grow_to(end);
    return growth.tree();
}

/* Returns the number of points before the vessel becomes narrow. */
size_t wide_points(const Curve &course)
{
    const auto narrow = std::find_if(course.begin(), course.end(), [](const CurvePoint &point) {
        return point.radius_mm < WIDE_RADIUS_MM;
    });
    return static_cast<size_t>(narrow - course.begin());
}

// --- narrow vessels ---

/* Takes `length_mm` from the beginning of a course. */
Curve shortened(const Curve &course, double length_mm)
{
    for (size_t i = 0; i + 1 < course.size(); i++) {
        const Vec3 step = course[i + 1].position_mm - course[i].position_mm;
        const double share = length_mm / std::max(step.norm(), 1e-9);
        if (share < 1.0) {
            Curve rest(course.begin() + static_cast<std::ptrdiff_t>(i), course.end());
            rest.front().position_mm += share * step;
            return rest;
        }
        length_mm -= step.norm();
    }
    return {};
}

/* Returns the narrow part of a vessel, from the surface of the wider one before it. */
Curve narrow_part(const LungVessel &vessel)
{
    constexpr double INTO_WALL = 0.85, STEEPEST_SINE = 0.35, END_CAP = 0.7;
    const Curve &course = vessel.course;
    const size_t wide = wide_points(course);
    if (wide == course.size()) return {};
    if (wide > 1)
        return shortened(Curve(course.begin() + static_cast<std::ptrdiff_t>(wide) - 1, course.end()),
                         END_CAP * course[wide - 1].radius_mm);
    const Vec3 direction = curve_tangent(course, 0);
    const double sine = direction.cross(vessel.parent_direction).norm();
    return shortened(course, INTO_WALL * vessel.parent_radius_mm / std::max(sine, STEEPEST_SINE));
}

/* Returns the longest piece of a course, from its first point that is deep enough in the lung. */
Curve within(const LungSpace &space, const Curve &course)
{
    constexpr double INSET_MM = 2.0;
    const auto is_deep = [&](const CurvePoint &point) {
        return space.distance(point.position_mm) < -INSET_MM - point.radius_mm;
    };
    const auto first = std::find_if(course.begin(), course.end(), is_deep);
    return Curve(first, std::find_if_not(first, course.end(), is_deep));
}

int sides_of(double radius_mm)
{
    return radius_mm < 1.0 ? 3 : radius_mm < 1.6 ? 4 : 6;
}

} // namespace

/* The stems are the artery of the upper lobe and that of the lower lobe, which runs down beside the bronchus.
 * The left pulmonary artery lies higher. */
LungTree lung_arteries(LungSide side_of, const LungSpace &space, const Box &box)
{
    const double sign = side_of == LungSide::left ? 1.0 : -1.0, up = side_of == LungSide::left ? 8.0 : 0.0;
    const auto at = [&](double x, double y, double z) { return side(sign, x, y + up, z); };
    return grown_tree(space, box,
                      {at(38, 165, -16),
                       {{at(46, 182, -10), at(50, 204, -10)},
                        {at(47, 156, -20), at(52, 138, -26), at(56, 116, -32), at(60, 94, -38)}}},
                      1);
}

/* The stems are the superior vein, which comes down before the artery, and the inferior one, which lies
 * lower, farther back and flatter than the arteries. */
LungTree lung_veins(LungSide side_of, const LungSpace &space, const Box &box)
{
    constexpr uint32_t OTHER_ENDS = 20011;
    const double sign = side_of == LungSide::left ? 1.0 : -1.0;
    const auto at = [&](double x, double y, double z) { return side(sign, x, y, z); };
    return grown_tree(space, box,
                      {at(34, 138, -16),
                       {{at(44, 148, -2), at(52, 166, 6), at(58, 188, 8)},
                        {at(46, 131, -28), at(58, 120, -40), at(72, 106, -48)}}},
                      OTHER_ENDS);
}

Solid wide_lung_vessels(const std::vector<LungTree> &trees)
{
    Solid solid;
    for (const LungTree &tree : trees) {
        Part part(1.0);
        for (const LungVessel &vessel : tree.vessels) {
            const size_t count = wide_points(vessel.course);
            if (count < 2) continue;
            part.add<Tube>(
                Curve(vessel.course.begin(), vessel.course.begin() + static_cast<std::ptrdiff_t>(count)));
        }
        solid.add(part);
    }
    return solid;
}

Mesh narrow_lung_vessels(const std::vector<LungTree> &trees, const LungSpace &space)
{
    constexpr double ERROR_MM = 0.4, SHORTEST_MM = 4.0;
    Mesh mesh;
    for (const LungTree &tree : trees)
        for (const LungVessel &vessel : tree.vessels) {
            Curve course = within(space, narrow_part(vessel));
            if (course.size() < 2 ||
                (course.back().position_mm - course.front().position_mm).norm() < SHORTEST_MM)
                continue;
            course = simplified_course(course, ERROR_MM);
            add_tube(mesh, course, sides_of(course.front().radius_mm));
        }
    return mesh;
}

} // namespace anatomy
