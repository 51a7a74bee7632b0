#include "tools/anatomy/shapes.hpp"
#include <algorithm>
#include <cmath>
#include <limits>

namespace anatomy
{

void Box::include(const Vec3 &point, double margin_mm)
{
    low = low.cwiseMin(point - Vec3::Constant(margin_mm));
    high = high.cwiseMax(point + Vec3::Constant(margin_mm));
}

void Box::include(const Box &other)
{
    low = low.cwiseMin(other.low);
    high = high.cwiseMax(other.high);
}

double Box::distance(const Vec3 &point) const
{
    return std::sqrt(squared_distance(point));
}

double Box::distance(const Box &other) const
{
    return (low - other.high).cwiseMax(other.low - high).cwiseMax(0.0).norm();
}

double smooth_min(double a, double b, double blend_mm)
{
    if (blend_mm <= 0.0) return std::min(a, b);
    const double overlap = std::max(blend_mm - std::abs(a - b), 0.0) / blend_mm;
    return std::min(a, b) - overlap * overlap * blend_mm * 0.25;
}

double smooth_max(double a, double b, double blend_mm)
{
    return -smooth_min(-a, -b, blend_mm);
}

double smooth_step(double low, double high, double value)
{
    const double t = std::clamp((value - low) / (high - low), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

// --- tube ---

Tube::Tube(const Curve &curve)
{
    build(curve, std::vector<Section>(curve.size(), {Vec3::Zero(), 1.0}));
}

Tube::Tube(const Curve &curve, const Vec3 &flat, double thinness)
    : Tube(curve, std::vector<Section>(curve.size(), {flat.normalized(), thinness}))
{
}

Tube::Tube(const Curve &curve, const std::vector<Section> &sections) : is_round_(false)
{
    build(curve, sections);
}

void Tube::build(const Curve &curve, const std::vector<Section> &sections)
{
    constexpr size_t SEGMENTS_PER_CHUNK = 6;
    std::vector<Segment> segments;
    for (size_t i = 0; i + 1 < curve.size(); i++) {
        const Vec3 axis = curve[i + 1].position_mm - curve[i].position_mm;
        const Section &from = sections[i], &to = sections[i + 1];
        segments.push_back({curve[i].position_mm,
                            axis,
                            1.0 / axis.squaredNorm(),
                            curve[i].radius_mm,
                            curve[i + 1].radius_mm - curve[i].radius_mm,
                            from,
                            {to.flat - from.flat, to.thinness - from.thinness}});
    }
    segments_ = std::make_shared<const std::vector<Segment>>(std::move(segments));
    for (size_t first = 0; first + 1 < curve.size(); first += SEGMENTS_PER_CHUNK) {
        Chunk chunk{first, std::min(first + SEGMENTS_PER_CHUNK, curve.size() - 1), {}};
        for (size_t i = chunk.first; i <= chunk.last; i++)
            chunk.bounds.include(curve[i].position_mm,
                                 curve[i].radius_mm * std::max(1.0, sections[i].thinness));
        bounds.include(chunk.bounds);
        chunks_.push_back(chunk);
    }
}

std::shared_ptr<Shape> Tube::near(const Box &box, double reach_mm) const
{
    auto trimmed = std::make_shared<Tube>(*this);
    std::erase_if(trimmed->chunks_,
                  [&](const Chunk &chunk) { return chunk.bounds.distance(box) > reach_mm; });
    if (marrow) trimmed->marrow = marrow->near(box, reach_mm);
    trimmed->bounds = {};
    for (const Chunk &chunk : trimmed->chunks_) trimmed->bounds.include(chunk.bounds);
    return trimmed;
}

double Tube::section_distance(const Vec3 &point, const Segment &segment, double t) const
{
    const double radius = segment.radius_mm + t * segment.radius_change_mm;
    const double thin = radius * (segment.section.thinness + t * segment.section_change.thinness);
    const Vec3 flat = segment.section.flat + t * segment.section_change.flat;
    const Vec3 offset = point - segment.start - t * segment.axis;
    const Vec3 along = segment.axis * std::sqrt(segment.inverse_squared);
    const Vec3 height = (flat - along * flat.dot(along)).normalized(), across = along.cross(height);
    return ellipsoid_distance({offset.dot(height), offset.dot(across), offset.dot(along)},
                              {radius, thin, thin});
}

double Tube::distance(const Vec3 &point) const
{
    // If the tube's cross-section is flat, the distance is computed only at the axis point nearest to
    // `point`. If the tube's cross-section is round, the distance is the smallest distance to any segment of
    // the tube.
    constexpr double FAR = 1e9;
    double best = FAR, best_t = 0.0;
    const Segment *nearest = nullptr;
    for (const Chunk &chunk : chunks_) {
        if (is_exact_inside && best <= 0.0 ? chunk.bounds.squared_distance(point) > 0.0
                                           : chunk.bounds.is_beyond(point, best))
            continue;
        for (size_t i = chunk.first; i < chunk.last; i++) {
            const Segment &segment = (*segments_)[i];
            const Vec3 offset = point - segment.start;
            const double t = std::clamp(offset.dot(segment.axis) * segment.inverse_squared, 0.0, 1.0);
            const double squared = (offset - t * segment.axis).squaredNorm();
            const double radius = is_round_ ? segment.radius_mm + t * segment.radius_change_mm : 0.0;
            const double limit = best + radius; // the root is taken only for nearer segments
            if (limit <= 0.0 || squared >= limit * limit) continue;
            // The radius is subtracted in two steps, so that the last bits of the lumen stay what they were.
            best = is_round_ ? std::sqrt(squared) - segment.radius_mm - t * segment.radius_change_mm
                             : std::sqrt(squared);
            best_t = t;
            nearest = &segment;
        }
    }
    return is_round_ || !nearest ? best : section_distance(point, *nearest, best_t);
}

// --- other shapes ---

double ellipsoid_distance(const Vec3 &local, const Vec3 &half_axes_mm)
{
    const Vec3 scaled = local.cwiseQuotient(half_axes_mm);
    const double length = scaled.norm(), gradient = scaled.cwiseQuotient(half_axes_mm).norm();
    if (gradient < 1e-9) return -half_axes_mm.minCoeff();
    return length * (length - 1.0) / gradient;
}

Ellipsoid::Ellipsoid(const Vec3 &centre, const Vec3 &half_axes_mm, const Eigen::Matrix3d &rotation)
    : centre_(centre), half_axes_(half_axes_mm), inverse_(rotation.transpose())
{
    const Vec3 reach = (rotation.cwiseAbs() * half_axes_mm).eval();
    bounds.include(centre - reach, 0.0);
    bounds.include(centre + reach, 0.0);
}

double Ellipsoid::distance(const Vec3 &point) const
{
    return ellipsoid_distance(inverse_ * (point - centre_), half_axes_);
}

Plate::Plate(const Vec3 &a, const Vec3 &b, const Vec3 &c, double half_thickness_mm)
    : Plate(a, b, c, Vec3::Constant(half_thickness_mm))
{
}

Plate::Plate(const Vec3 &a, const Vec3 &b, const Vec3 &c, const Vec3 &half_thickness_mm)
    : half_thickness_mm_(half_thickness_mm), thickest_mm_(half_thickness_mm.maxCoeff())
{
    const Vec3 corners[3] = {a, b, c}, normal = (b - a).cross(c - a);
    normal_ = normal.normalized();
    for (int i = 0; i < 3; i++) {
        const int next = (i + 1) % 3;
        const Vec3 along = corners[next] - corners[i];
        edges_[static_cast<size_t>(i)] = {corners[i],
                                          along,
                                          normal.cross(along) / normal.squaredNorm(),
                                          1.0 / along.squaredNorm(),
                                          half_thickness_mm[i],
                                          half_thickness_mm[next] - half_thickness_mm[i]};
        bounds.include(corners[i], half_thickness_mm.maxCoeff());
    }
}

double Plate::distance(const Vec3 &point) const
{
    Vec3 share; // barycentric shares: for each edge, that of the opposite corner, where the point's foot lies
                // over the face
    Vec3 offsets[3];
    for (int i = 0; i < 3; i++) {
        const Edge &edge = edges_[static_cast<size_t>(i)];
        offsets[i] = point - edge.start;
        share[(i + 2) % 3] = offsets[i].dot(edge.foot);
    }
    if (share.minCoeff() >= 0.0) return std::abs(normal_.dot(offsets[0])) - share.dot(half_thickness_mm_);
    double edge_squared = std::numeric_limits<double>::max(), thickness = 0.0;
    for (int i = 0; i < 3; i++) {
        const Edge &edge = edges_[static_cast<size_t>(i)];
        const double t = std::clamp(offsets[i].dot(edge.along) * edge.inverse_squared, 0.0, 1.0);
        const double squared = (offsets[i] - t * edge.along).squaredNorm();
        if (squared >= edge_squared) continue;
        edge_squared = squared;
        thickness = edge.thickness + t * edge.thickness_change;
    }
    return std::sqrt(edge_squared) - thickness;
}

Formula::Formula(std::function<double(const Vec3 &)> function, const Box &where)
    : function_(std::move(function))
{
    bounds = where;
}

// --- part and solid ---

Tube &Part::rod(const std::vector<Vec3> &points, const std::vector<double> &radii_mm, double cortex_mm)
{
    Tube &tube = add<Tube>(sample_curve(points, radii_mm, 4.0));
    tube.is_exact_inside = is_exact_inside;
    tube.cortex_mm = cortex_mm;
    return tube;
}

Plate &Part::plate(const Vec3 &a, const Vec3 &b, const Vec3 &c, double half_thickness_mm, double cortex_mm)
{
    Plate &flat = add<Plate>(a, b, c, half_thickness_mm);
    flat.cortex_mm = cortex_mm;
    return flat;
}

Plate &Part::plate(const Vec3 &a, const Vec3 &b, const Vec3 &c, const Vec3 &half_thickness_mm,
                   double cortex_mm)
{
    Plate &flat = add<Plate>(a, b, c, half_thickness_mm);
    flat.cortex_mm = cortex_mm;
    return flat;
}

double Part::evaluate(const Vec3 &point, double cortex_scale) const
{
    constexpr double CUT_ROUND_MM = 1.0;
    double total = 1e9;
    for (const auto &shape : added) {
        const double reach =
            (is_exact_inside ? std::max(0.0, total) : total) + blend_mm + cortex_scale * shape->cortex_mm;
        if (reach < 0.0 || (reach < 1e8 && shape->is_beyond(point, reach))) continue;
        const bool own_marrow = cortex_scale > 0.0 && shape->marrow;
        const double distance = own_marrow ? shape->marrow->distance(point)
                                           : shape->distance(point) + cortex_scale * shape->cortex_mm;
        total = smooth_min(total, distance, blend_mm);
    }
    for (const auto &shape : removed) {
        if (shape->is_beyond(point, CUT_ROUND_MM + cortex_scale + std::max(0.0, -total))) continue;
        total = smooth_max(total, cortex_scale * shape->cortex_mm - shape->distance(point), CUT_ROUND_MM);
    }
    return total;
}

double Part::distance(const Vec3 &point) const
{
    return evaluate(point, 0.0);
}

double Part::marrow_distance(const Vec3 &point) const
{
    // Where two shapes of a bone are joined smoothly, the bone's shell may become thinner. The shell never
    // becomes thinner than SHELL_LEAST_MM, so that the marrow stays inside the bone.
    constexpr double SHELL_LEAST_MM = 0.7;
    const double inner = evaluate(point, 1.0);
    constexpr double FAR_MM = 5.0; // so far from the surface of the marrow, only the sign matters
    if (std::abs(inner) > FAR_MM) return inner;
    return std::max(inner, evaluate(point, 0.0) + SHELL_LEAST_MM);
}

Part Part::near(const Box &box, double reach_mm) const
{
    Part part(blend_mm);
    for (const auto &shape : added) {
        const double reach = reach_mm + blend_mm + shape->cortex_mm;
        if (shape->bounds.distance(box) > reach) continue;
        const auto trimmed = shape->near(box, reach);
        if (trimmed && trimmed->bounds.is_empty()) continue;
        part.added.push_back(trimmed ? trimmed : shape);
        part.bounds.include(part.added.back()->bounds);
    }
    for (const auto &shape : removed)
        if (shape->bounds.distance(box) <= reach_mm) part.removed.push_back(shape);
    return part;
}

void Solid::add(Part part)
{
    bounds.include(part.bounds);
    parts_.push_back(std::move(part));
}

void Solid::add(const Solid &other)
{
    for (const Part &part : other.parts_) add(part);
}

double Solid::distance(const Vec3 &point) const
{
    double best = 1e9;
    for (const Part &part : parts_)
        if (!part.bounds.is_beyond(point, best + part.blend_mm)) best = std::min(best, part.distance(point));
    return best;
}

double Solid::marrow_distance(const Vec3 &point) const
{
    double best = 1e9;
    for (const Part &part : parts_)
        if (!part.bounds.is_beyond(point, best + part.blend_mm))
            best = std::min(best, part.marrow_distance(point));
    return best;
}

Solid Solid::near(const Box &box, double reach_mm) const
{
    Solid solid;
    solid.bounds = bounds;
    for (const Part &part : parts_) {
        if (part.bounds.distance(box) > reach_mm + part.blend_mm) continue;
        Part trimmed = part.near(box, reach_mm);
        if (!trimmed.added.empty()) solid.parts_.push_back(std::move(trimmed));
    }
    // The least distance does not depend on the order; if the nearest part comes first, most others are
    // skipped.
    const Vec3 middle = 0.5 * (box.low + box.high);
    std::stable_sort(solid.parts_.begin(), solid.parts_.end(), [&](const Part &a, const Part &b) {
        return a.bounds.squared_distance(middle) < b.bounds.squared_distance(middle);
    });
    return solid;
}

} // namespace anatomy
