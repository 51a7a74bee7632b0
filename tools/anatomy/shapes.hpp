/* Declares the solids from which the bodies of an anatomy are built. Each solid has a bounding box and
 * returns an approximate signed distance in millimetres, which is negative inside the solid. The class Part
 * joins several shapes smoothly into one bone, and the class Solid is the plain union of several parts. Each
 * shape of a bone also stores the thickness of its cortical shell, so the bone's Solid can compute the marrow
 * space inside the shell. */
#pragma once
#include "tools/anatomy/spline.hpp"
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <vector>

namespace anatomy
{

struct Box {
    Vec3 low = Vec3::Constant(1e9), high = Vec3::Constant(-1e9);
    void include(const Vec3 &point, double margin_mm);
    void include(const Box &other);
    bool is_empty() const { return low.x() > high.x(); }
    double distance(const Vec3 &point) const; // 0 inside
    double squared_distance(const Vec3 &point) const
    {
        double sum = 0.0;
        for (int axis = 0; axis < 3; axis++) {
            const double off = std::max({low[axis] - point[axis], point[axis] - high[axis], 0.0});
            sum += off * off;
        }
        return sum;
    }
    /* Returns whether the distance to the point is at least `limit_mm`; faster than distance(). */
    bool is_beyond(const Vec3 &point, double limit_mm) const
    {
        return limit_mm <= 0.0 || squared_distance(point) >= limit_mm * limit_mm;
    }
    double distance(const Box &other) const; // 0 where they touch or overlap
};

using Distance = std::function<double(const Vec3 &)>; // signed distance at a point, millimetres

class Shape
{
  public:
    virtual ~Shape() = default;
    virtual double distance(const Vec3 &point) const = 0;
    /* Returns whether the distance to the point is at least `limit_mm`, if a quick look can tell. */
    virtual bool is_beyond(const Vec3 &point, double limit_mm) const
    {
        return bounds.is_beyond(point, limit_mm);
    }
    /* Returns a shape that has the same distances near the box but needs less computation than this shape;
     * returns null when there is no such shape. The bounds of the returned shape are empty where nothing of
     * this shape is near. */
    virtual std::shared_ptr<Shape> near(const Box &, double) const { return nullptr; }
    Box bounds;
    double cortex_mm = 1.0;        // thickness of the shell around the marrow space
    std::shared_ptr<Shape> marrow; // the marrow space, where it is not the shape less its shell
};

/* A tube around a curve. Without the parameter `flat`, the tube's cross-section is a circle with the curve's
 * radius. With the parameter `flat`, the tube's cross-section is an ellipse. The ellipse's half-axis along
 * the direction `flat` is the curve's radius, and its other half-axis is the curve's radius times
 * `thinness`. */
class Tube : public Shape
{
  public:
    explicit Tube(const Curve &curve);
    Tube(const Curve &curve, const Vec3 &flat, double thinness);
    /* A twisted band: every sample of the curve has its own section. */
    struct Section {
        Vec3 flat;
        double thinness;
    };
    Tube(const Curve &curve, const std::vector<Section> &sections);
    double distance(const Vec3 &point) const override;
    std::shared_ptr<Shape> near(const Box &box, double reach_mm) const override;
    /* Inside a tube, distances are usually those of the first segment found, which is enough for its surface.
     * Layers at a depth below the surface need the true ones. */
    bool is_exact_inside = false;

  private:
    struct Segment { // start, vector to the end, 1 / |axis|^2, radius at the start, and change of the radius
                     // to the end
        Vec3 start, axis;
        double inverse_squared, radius_mm, radius_change_mm;
        Section section, section_change;
    };
    struct Chunk {
        size_t first, last;
        Box bounds;
    };
    void build(const Curve &curve, const std::vector<Section> &sections);
    double section_distance(const Vec3 &point, const Segment &segment, double t) const;
    std::shared_ptr<const std::vector<Segment>> segments_;
    bool is_round_ = true;
    std::vector<Chunk> chunks_;
};

/* An ellipsoid. `rotation` maps the ellipsoid's own axes to the patient frame. */
class Ellipsoid : public Shape
{
  public:
    Ellipsoid(const Vec3 &centre, const Vec3 &half_axes_mm,
              const Eigen::Matrix3d &rotation = Eigen::Matrix3d::Identity());
    double distance(const Vec3 &point) const override;

  private:
    Vec3 centre_, half_axes_;
    Eigen::Matrix3d inverse_;
};

/* Describes a flat bone, such as ilium, scapula or laminae, as a triangle that is thickened by
 * half_thickness_mm on both sides. Each corner of the plate may have a different thickness. */
class Plate : public Shape
{
  public:
    Plate(const Vec3 &a, const Vec3 &b, const Vec3 &c, double half_thickness_mm);
    Plate(const Vec3 &a, const Vec3 &b, const Vec3 &c, const Vec3 &half_thickness_mm);
    double distance(const Vec3 &point) const override;
    bool is_beyond(const Vec3 &point, double limit_mm) const override
    {
        return std::abs(normal_.dot(point - edges_[0].start)) - thickest_mm_ >= limit_mm ||
               bounds.is_beyond(point, limit_mm);
    }
    /* Returns whether the distance to a point inside may be less than `depth_mm`, which is negative. */
    bool may_be_below(const Vec3 &point, double depth_mm) const
    {
        return std::abs(normal_.dot(point - edges_[0].start)) - thickest_mm_ < depth_mm &&
               bounds.squared_distance(point) == 0.0;
    }

  private:
    struct Edge {                // from corner i to corner i + 1
        Vec3 start, along, foot; // foot: the share of the opposite corner grows along it
        double inverse_squared, thickness, thickness_change;
    };
    std::array<Edge, 3> edges_;
    Vec3 normal_, half_thickness_mm_; // normal of length one
    double thickest_mm_;
};

/* Describes a shape that is defined by an arbitrary distance function and a bounding box. */
class Formula : public Shape
{
  public:
    Formula(std::function<double(const Vec3 &)> function, const Box &where);
    double distance(const Vec3 &point) const override { return function_(point); }

  private:
    std::function<double(const Vec3 &)> function_;
};

/* The functions smooth_min and smooth_max return the minimum and the maximum of two distances, with a smooth
 * transition over a width of `blend_mm`. */
double smooth_min(double a, double b, double blend_mm);
double smooth_max(double a, double b, double blend_mm);

/* Returns 0 if `value` is below `low`, 1 if `value` is above `high`, and a number that rises smoothly from 0
 * to 1 between these limits. */
double smooth_step(double low, double high, double value);

/* Returns the distance to an ellipsoid from a point in the ellipsoid's own frame. The returned distance from
   the ellipsoid is exact to first order near its surface. */
double ellipsoid_distance(const Vec3 &local, const Vec3 &half_axes_mm);

class Part
{
  public:
    explicit Part(double blend) : blend_mm(blend) {}
    template <typename T, typename... Arguments> T &add(Arguments &&...arguments)
    {
        auto shape = std::make_shared<T>(std::forward<Arguments>(arguments)...);
        bounds.include(shape->bounds);
        added.push_back(shape);
        return *shape;
    }
    template <typename T, typename... Arguments> void cut(Arguments &&...arguments)
    {
        removed.push_back(std::make_shared<T>(std::forward<Arguments>(arguments)...));
    }
    /* Adds a tube of varying radius that runs through a few points. Most of the smaller bones consist of
     * tubes with a varying radius. */
    Tube &rod(const std::vector<Vec3> &points, const std::vector<double> &radii_mm, double cortex_mm = 1.0);
    Plate &plate(const Vec3 &a, const Vec3 &b, const Vec3 &c, double half_thickness_mm,
                 double cortex_mm = 1.0);
    Plate &plate(const Vec3 &a, const Vec3 &b, const Vec3 &c, const Vec3 &half_thickness_mm,
                 double cortex_mm);
    double distance(const Vec3 &point) const;
    double marrow_distance(const Vec3 &point) const;
    /* Returns a copy of this part of a bone that takes less time to evaluate for points inside `box`. The
     * distance to the copy is correct wherever it is below reach_mm. */
    Part near(const Box &box, double reach_mm) const;
    double blend_mm; // smooth joints may bulge so far outside `bounds`
    Box bounds;
    std::vector<std::shared_ptr<Shape>> added, removed;
    bool is_exact_inside = false; // for layers below the surface; rods added later have it too

  private:
    double evaluate(const Vec3 &point, double cortex_scale) const;
};

class Solid
{
  public:
    void add(Part part);
    void add(const Solid &other);
    double distance(const Vec3 &point) const;
    double marrow_distance(const Vec3 &point) const;
    Solid near(const Box &box, double reach_mm) const;
    bool is_empty() const { return parts_.empty(); }
    Box bounds;

  private:
    std::vector<Part> parts_;
};

/* Returns the point (x, y, z) on the patient's left (sign +1), or its mirror image on the right (sign -1). */
inline Vec3 side(double sign, double x, double y, double z)
{
    return {sign * x, y, z};
}

} // namespace anatomy
