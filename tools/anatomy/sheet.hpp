/* Describes thin curved bones, such as the iliac wing and the shoulder blade, by grids of points. */
#pragma once
#include "tools/anatomy/shapes.hpp"

namespace anatomy
{

struct SheetPoint {
    Vec3 position_mm;
    double half_thickness_mm;
};

/* Describes a curved bone by a grid of points, with equally many points in every row and at least two in each
 * direction. Two triangular plates fill each cell of the grid. Points should lie 2 to 3 mm apart, so that
 * neighbouring plates form almost one plane. X-rays that pass along the bone show a kink of a few degrees as
 * a streak. */
class Sheet : public Shape
{
  public:
    explicit Sheet(const std::vector<std::vector<SheetPoint>> &rows);
    /* Returns the distance to the union of the plates, whose joints are not smoothed. If neighbouring plates
     * were blended smoothly, a ridge would appear at every common edge. */
    double distance(const Vec3 &point) const override;
    std::shared_ptr<Shape> near(const Box &box, double reach_mm) const override;

  private:
    struct Patch { // plates that lie close together
        size_t first, last;
        Box bounds;
    };
    double nearest_in(const Patch &patch, const Vec3 &point, double best) const;
    std::shared_ptr<const std::vector<Plate>> plates_;
    std::vector<Patch> patches_;
};

/* Returns `count` points at equal distances along the smooth curve through `points`. */
std::vector<Vec3> evenly_along(const std::vector<Vec3> &points, size_t count);

} // namespace anatomy
