#include "tools/anatomy/sheet.hpp"
#include <algorithm>

namespace anatomy
{

Sheet::Sheet(const std::vector<std::vector<SheetPoint>> &rows)
{
    constexpr size_t PATCH = 3; // quadrangles along each side
    auto plates = std::make_shared<std::vector<Plate>>();
    const auto add = [&](const SheetPoint &a, const SheetPoint &b, const SheetPoint &c) {
        plates->emplace_back(a.position_mm, b.position_mm, c.position_mm,
                             Vec3(a.half_thickness_mm, b.half_thickness_mm, c.half_thickness_mm));
        patches_.back().bounds.include(plates->back().bounds);
    };
    for (size_t top = 0; top + 1 < rows.size(); top += PATCH)
        for (size_t left = 0; left + 1 < rows[top].size(); left += PATCH) {
            patches_.push_back({plates->size(), 0, {}});
            for (size_t row = top; row < std::min(top + PATCH, rows.size() - 1); row++)
                for (size_t i = left; i < std::min(left + PATCH, rows[row].size() - 1); i++) {
                    add(rows[row][i], rows[row][i + 1], rows[row + 1][i]);
                    add(rows[row][i + 1], rows[row + 1][i], rows[row + 1][i + 1]);
                }
            patches_.back().last = plates->size();
            bounds.include(patches_.back().bounds);
        }
    plates_ = plates;
}

double Sheet::nearest_in(const Patch &patch, const Vec3 &point, double best) const
{
    for (size_t i = patch.first; i < patch.last; i++) {
        const Plate &plate = (*plates_)[i];
        // Inside, the deepest of the plates that overlap counts: the marrow lies at a depth below the
        // surface.
        if (best > 0.0 ? !plate.is_beyond(point, best) : plate.may_be_below(point, best))
            best = std::min(best, plate.distance(point));
    }
    return best;
}

double Sheet::distance(const Vec3 &point) const
{
    // The code evaluates the nearest patch of the bone's surface first, so that it can skip most of the other
    // patches.
    thread_local std::vector<double> squared_mm; // from the point to each patch's box
    squared_mm.clear();
    for (const Patch &patch : patches_) squared_mm.push_back(patch.bounds.squared_distance(point));
    if (squared_mm.empty()) return 1e9;
    const auto nearest =
        static_cast<size_t>(std::min_element(squared_mm.begin(), squared_mm.end()) - squared_mm.begin());
    double best = nearest_in(patches_[nearest], point, 1e9);
    for (size_t i = 0; i < patches_.size(); i++)
        if (i != nearest && (best > 0.0 ? squared_mm[i] < best * best : squared_mm[i] == 0.0))
            best = nearest_in(patches_[i], point, best);
    return best;
}

std::shared_ptr<Shape> Sheet::near(const Box &box, double reach_mm) const
{
    const auto trimmed = std::make_shared<Sheet>(*this);
    std::erase_if(trimmed->patches_,
                  [&](const Patch &patch) { return patch.bounds.distance(box) > reach_mm; });
    trimmed->bounds = {};
    for (const Patch &patch : trimmed->patches_) trimmed->bounds.include(patch.bounds);
    return trimmed;
}

std::vector<Vec3> evenly_along(const std::vector<Vec3> &points, size_t count)
{
    const Curve curve = sample_curve(points, std::vector<double>(points.size(), 1.0), 0.5);
    std::vector<Vec3> even;
    size_t k = 1;
    for (size_t i = 0; i < count; i++) {
        const double arc = curve.back().arc_mm * static_cast<double>(i) / static_cast<double>(count - 1);
        while (k + 1 < curve.size() && curve[k].arc_mm < arc) k++;
        const CurvePoint &before = curve[k - 1], &behind = curve[k];
        const double share = (arc - before.arc_mm) / (behind.arc_mm - before.arc_mm);
        even.push_back(before.position_mm + share * (behind.position_mm - before.position_mm));
    }
    return even;
}

} // namespace anatomy
