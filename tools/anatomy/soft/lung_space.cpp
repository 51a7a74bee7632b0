#include "tools/anatomy/soft/lung_space.hpp"
#include <algorithm>
#include <cmath>

namespace anatomy
{

namespace
{

constexpr double LATTICE_MM = 6.0;
constexpr int NODES_SHARED = 4; // nodes of a block share what is near them

} // namespace

LungSpace::LungSpace(const LocalDistance &lung, const Box &box) : first_mm_(box.low)
{
    for (int axis = 0; axis < 3; axis++)
        nodes_[axis] = static_cast<int>(std::ceil((box.high[axis] - box.low[axis]) / LATTICE_MM)) + 1;
    distances_mm_.resize(index_of(0, 0, nodes_[2]));
    int first[3];
    for (first[2] = 0; first[2] < nodes_[2]; first[2] += NODES_SHARED)
        for (first[1] = 0; first[1] < nodes_[1]; first[1] += NODES_SHARED)
            for (first[0] = 0; first[0] < nodes_[0]; first[0] += NODES_SHARED) fill_block(lung, first);
}

size_t LungSpace::index_of(int x, int y, int z) const
{
    return (static_cast<size_t>(z) * static_cast<size_t>(nodes_[1]) + static_cast<size_t>(y)) *
               static_cast<size_t>(nodes_[0]) +
           static_cast<size_t>(x);
}

/* Far from the surface, all nodes of a block get the distance at its middle. */
void LungSpace::fill_block(const LocalDistance &lung, const int (&first)[3])
{
    int last[3];
    for (int axis = 0; axis < 3; axis++) last[axis] = std::min(first[axis] + NODES_SHARED, nodes_[axis]) - 1;
    const auto at = [&](int x, int y, int z) { return Vec3(first_mm_ + LATTICE_MM * Vec3(x, y, z)); };
    Box box;
    box.include(at(first[0], first[1], first[2]), 0.0);
    box.include(at(last[0], last[1], last[2]), 0.0);
    const Distance distance = lung(box, REACH_MM);
    const double middle = distance(0.5 * (box.low + box.high));
    const bool is_far = std::abs(middle) > REACH_MM + 0.5 * (box.high - box.low).norm();
    for (int z = first[2]; z <= last[2]; z++)
        for (int y = first[1]; y <= last[1]; y++)
            for (int x = first[0]; x <= last[0]; x++)
                distances_mm_[index_of(x, y, z)] =
                    static_cast<float>(is_far ? middle : distance(at(x, y, z)));
}

double LungSpace::distance(const Vec3 &point) const
{
    const Vec3 place = (point - first_mm_) / LATTICE_MM;
    int cell[3];
    Vec3 share;
    for (int axis = 0; axis < 3; axis++) {
        const double inside = std::clamp(place[axis], 0.0, nodes_[axis] - 1.001);
        cell[axis] = static_cast<int>(inside);
        share[axis] = inside - cell[axis];
    }
    double sum = 0.0;
    for (int corner = 0; corner < 8; corner++) {
        const int x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
        const double weight = (x ? share[0] : 1.0 - share[0]) * (y ? share[1] : 1.0 - share[1]) *
                              (z ? share[2] : 1.0 - share[2]);
        sum += weight * static_cast<double>(distances_mm_[index_of(cell[0] + x, cell[1] + y, cell[2] + z)]);
    }
    return sum;
}

} // namespace anatomy
