/* The muscle of the shipped heart as tissue for small arteries: the walls under the heart's surface (layer 0,
 * depth from the surface) and the septum (layer 1, depth from the cavity of the left ventricle). */
#pragma once
#include "tools/anatomy/small/grow.hpp"

namespace anatomy
{

constexpr int OUTER_LAYER = 0, SEPTUM_LAYER = 1;

class HeartTissue
{
  public:
    HeartTissue();

    TissuePlace onto(const TissuePlace &place) const;
    TissuePlace place(double height, double angle_deg, double depth_mm, int layer) const;
    double height(const Vec3 &at) const;
    double angle_deg(const Vec3 &at) const;
    /* The angle of the anterior groove between the ventricles, in which the LAD lies. */
    static double groove_deg(double height);
    static constexpr double POSTERIOR_GROOVE_DEG = 228.0;

    /* Returns places in the muscle, about evenly spread, in random order. */
    std::vector<TissuePlace> scattered(double apart_mm, unsigned tries, std::uint64_t seed) const;

  private:
    double radius_mm(const std::vector<double> &table, double height, double angle_deg) const;
    std::vector<double> outer_mm_, cavity_mm_; // from the axis, of heights and angles
};

} // namespace anatomy
