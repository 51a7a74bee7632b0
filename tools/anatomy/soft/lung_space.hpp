/* The distance to a lung's surface on a lattice, for code that asks for it at many places. */
#pragma once
#include "tools/anatomy/mesh.hpp"
#include <vector>

namespace anatomy
{

class LungSpace
{
  public:
    /* `lung` is the distance function of the lung, and `box` holds it. */
    LungSpace(const LocalDistance &lung, const Box &box);
    /* Returns the distance at a point, between nodes by linear interpolation. It is right within about 1 mm
     * near the surface; deeper than REACH_MM, only the sign matters. */
    double distance(const Vec3 &point) const;

    static constexpr double REACH_MM = 20.0;

  private:
    size_t index_of(int x, int y, int z) const;
    void fill_block(const LocalDistance &lung, const int (&first)[3]);

    Vec3 first_mm_;
    int nodes_[3];
    std::vector<float> distances_mm_; // x fastest
};

} // namespace anatomy
