#include "tools/anatomy/small/grow.hpp"
#include <algorithm>
#include <cmath>

namespace anatomy
{

namespace
{

constexpr size_t CANDIDATES = 16;
constexpr double SHORTEST_MM = 0.7;
constexpr int ROUND_PASSES = 3;

double foot_share(const Vec3 &a, const Vec3 &b, const Vec3 &p)
{
    const Vec3 way = b - a;
    return std::clamp((p - a).dot(way) / std::max(way.squaredNorm(), 1e-9), 0.0, 1.0);
}

TissuePlace between(const TissuePlace &a, const TissuePlace &b, double share)
{
    return {a.at + share * (b.at - a.at), a.depth_mm + share * (b.depth_mm - a.depth_mm), b.layer};
}

} // namespace

double Growth::radius_mm(int ends) const
{
    return rules_.end_radius_mm * std::pow(std::max(ends, 1), 1.0 / rules_.exponent);
}

int Growth::add_segment(const Segment &segment)
{
    segments_.push_back(segment);
    return static_cast<int>(segments_.size()) - 1;
}

void Growth::add_stem(const std::string &name, const std::vector<TissuePlace> &places,
                      const std::vector<double> &radii_mm, double closed_mm)
{
    stems_.push_back(name);
    Segment segment;
    segment.is_stem = true;
    segment.stem = static_cast<int>(stems_.size()) - 1;
    for (size_t i = 0; i + 1 < places.size(); i++) {
        segment.from = places[i];
        segment.to = places[i + 1];
        segment.is_closed = (places[i].at - places.back().at).norm() < closed_mm;
        segment.stem_radius_mm = 0.5 * (radii_mm[i] + radii_mm[i + 1]);
        add_segment(segment);
    }
}

void Growth::add_trunk(const std::vector<TissuePlace> &places)
{
    Segment segment;
    segment.stem = static_cast<int>(stems_.size()) - 1;
    double nearest = 1e300;
    for (size_t i = 0; i < segments_.size(); i++) {
        const Segment &stem = segments_[i];
        if (!stem.is_stem || stem.stem != segment.stem) continue;
        const double share = foot_share(stem.from.at, stem.to.at, places[0].at);
        const double apart = (stem.from.at + share * (stem.to.at - stem.from.at) - places[0].at).norm();
        if (apart >= nearest) continue;
        nearest = apart;
        segment.parent = static_cast<int>(i);
    }
    for (size_t i = 0; i + 1 < places.size(); i++) {
        segment.from = places[i];
        segment.to = places[i + 1];
        const int index = add_segment(segment);
        segments_[static_cast<size_t>(segment.parent)].children.push_back(index);
        segment.parent = index;
    }
    count_ends(segment.parent);
}

/* Adds one end to the segment and to all segments before it. */
void Growth::count_ends(int index)
{
    for (; index >= 0 && !segments_[static_cast<size_t>(index)].is_stem;
         index = segments_[static_cast<size_t>(index)].parent)
        segments_[static_cast<size_t>(index)].ends++;
}

std::vector<int> Growth::nearest(const TissuePlace &end) const
{
    std::vector<std::pair<double, int>> found;
    for (size_t i = 0; i < segments_.size(); i++) {
        const Segment &s = segments_[i];
        if (s.to.layer != end.layer || s.is_closed) continue;
        const double share = foot_share(s.from.at, s.to.at, end.at);
        const double square = (s.from.at + share * (s.to.at - s.from.at) - end.at).squaredNorm();
        if (square < rules_.reach_mm * rules_.reach_mm) found.emplace_back(square, static_cast<int>(i));
    }
    const size_t count = std::min(CANDIDATES, found.size());
    std::partial_sort(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(count), found.end());
    std::vector<int> indices;
    for (size_t i = 0; i < count; i++) indices.push_back(found[i].second);
    return indices;
}

/* One more end makes all arteries upstream wider. Returns the volume that this adds, over pi. */
double Growth::cost_upstream(int index) const
{
    double sum = 0.0;
    while (!segments_[static_cast<size_t>(index)].is_stem) {
        const Segment &s = segments_[static_cast<size_t>(index)];
        const double now = radius_mm(s.ends), then = radius_mm(s.ends + 1);
        sum += (then * then - now * now) * (s.to.at - s.from.at).norm();
        index = s.parent;
    }
    return sum;
}

void Growth::try_segment(int index, const TissuePlace &end, Joint &best) const
{
    const Segment &s = segments_[static_cast<size_t>(index)];
    const double length = (s.to.at - s.from.at).norm(), foot = foot_share(s.from.at, s.to.at, end.at);
    const double thin = std::pow(rules_.end_radius_mm, 2);
    const double now = std::pow(radius_mm(s.ends), 2), then = std::pow(radius_mm(s.ends + 1), 2);
    const double before = s.is_stem ? 0.0 : cost_upstream(s.parent);
    for (const double share : {foot, 0.75 * foot, 0.5 * foot, 0.25, 0.5, 0.75})
        for (const double towards : {0.0, 0.12, 0.25}) {
            if (s.is_stem && towards > 0.0) break;
            TissuePlace at = between(between(s.from, s.to, share), end, towards);
            if (!s.is_stem && towards > 0.0) at = onto_(at);
            const double own = (end.at - at.at).norm(), first = (at.at - s.from.at).norm(),
                         second = (s.to.at - at.at).norm();
            if (own < SHORTEST_MM || (!s.is_stem && std::min(first, second) < SHORTEST_MM)) continue;
            double cost = thin * own;
            if (!s.is_stem) cost += then * first + now * second - now * length + before;
            if (cost < best.cost) best = {index, at, cost};
        }
}

bool Growth::grow_to(const TissuePlace &end)
{
    Joint best;
    for (int index : nearest(end)) try_segment(index, end, best);
    if (best.segment < 0) return false;
    const Segment old = segments_[static_cast<size_t>(best.segment)];
    Segment added;
    added.from = best.at;
    added.to = end;
    added.stem = old.stem;
    added.parent = best.segment;
    added.ends = 0;
    if (!old.is_stem) {
        Segment rest = old;
        rest.from = best.at;
        rest.parent = best.segment;
        const int index = add_segment(rest);
        for (int child : old.children) segments_[static_cast<size_t>(child)].parent = index;
        segments_[static_cast<size_t>(best.segment)].to = best.at;
        segments_[static_cast<size_t>(best.segment)].children = {index};
    }
    const int index = add_segment(added);
    segments_[static_cast<size_t>(best.segment)].children.push_back(index);
    count_ends(index);
    return true;
}

/* From one end of a segment to the other, the radius changes linearly. */
void Growth::add_points(const Segment &s, double to_radius_mm, std::vector<CurvePoint> &points) const
{
    const double from_radius_mm = points.back().radius_mm;
    const int pieces =
        std::max(1, static_cast<int>(std::lround((s.to.at - s.from.at).norm() / rules_.step_mm)));
    const bool is_in_layer = s.from.layer == s.to.layer;
    for (int k = 1; k <= pieces; k++) {
        const double share = static_cast<double>(k) / pieces;
        TissuePlace place = between(s.from, s.to, share);
        if (k < pieces && is_in_layer) place = onto_(place);
        points.push_back({place.at, from_radius_mm + share * (to_radius_mm - from_radius_mm), 0.0});
    }
}

void Growth::trace(int first, const Start &start, std::vector<Twig> &twigs) const
{
    const size_t own = twigs.size();
    twigs.push_back({start.stem, start.parent, {}});
    std::vector<std::pair<int, size_t>> others; // each with the point at which it leaves
    const Segment *s = &segments_[static_cast<size_t>(first)];
    double radius = radius_mm(s->ends);
    if (!start.stem.empty())
        radius =
            std::min(radius, rules_.widest_share * segments_[static_cast<size_t>(s->parent)].stem_radius_mm);
    std::vector<CurvePoint> &points = twigs[own].points;
    points.push_back({start.at, radius, 0.0});
    while (true) {
        int widest = -1;
        for (int child : s->children)
            if (widest < 0 ||
                segments_[static_cast<size_t>(child)].ends > segments_[static_cast<size_t>(widest)].ends)
                widest = child;
        const int ends = widest < 0 ? 1 : segments_[static_cast<size_t>(widest)].ends;
        add_points(*s, std::min(radius_mm(ends), points.back().radius_mm), points);
        for (int child : s->children)
            if (child != widest) others.emplace_back(child, points.size() - 1);
        if (widest < 0) break;
        s = &segments_[static_cast<size_t>(widest)];
    }
    round_corners(points, ROUND_PASSES);
    const std::vector<CurvePoint> course = points; // `twigs` moves its contents
    for (const auto &[child, point] : others) trace(child, {"", own, course[point].position_mm}, twigs);
}

std::vector<Twig> Growth::twigs() const
{
    std::vector<Twig> twigs;
    for (const Segment &s : segments_)
        if (s.is_stem)
            for (int child : s.children)
                trace(child, {stem_name(s.stem), 0, segments_[static_cast<size_t>(child)].from.at}, twigs);
    return twigs;
}

} // namespace anatomy
