#include "tools/lab/ct/centreline.hpp"
#include "tools/lab/ct/instrument_path.hpp"
#include "tools/lab/ct/line_model.hpp"
#include "tools/lab/ct/measures.hpp"
#include "tools/mesh/fault.hpp"
#include <algorithm>
#include <cmath>

namespace crn::ct
{

using Eigen::Vector3d;

namespace
{

constexpr double step_mm = 0.5;    // spacing of the line's points
constexpr double trimmed_mm = 1.5; // cut off the voxels' ends, which bloom beyond the instrument's
constexpr double stiffness = 4.0;  // weight of the smoothing: third differences against measured places
constexpr int rounds = 5;
constexpr double beyond_mm = 3.0;    // range of the search for the tip beyond the line
constexpr double doubtful_mm = 0.09; // of bends and slices: above it the report states the reason

Vector3d place_at(const std::vector<Vector3d> &line, double arc_mm)
{
    for (std::size_t i = 1; i < line.size(); ++i) {
        const double length = (line[i] - line[i - 1]).norm();
        if (arc_mm <= length || i + 1 == line.size())
            return line[i - 1] + (line[i] - line[i - 1]) * (length > 0 ? arc_mm / length : 0);
        arc_mm -= length;
    }
    return line.back();
}

std::vector<Vector3d> part_of(const std::vector<Vector3d> &line, double begin_mm, double end_mm)
{
    const int parts = std::max(2, static_cast<int>(std::lround((end_mm - begin_mm) / step_mm)));
    std::vector<Vector3d> result;
    for (int i = 0; i <= parts; ++i)
        result.push_back(place_at(line, begin_mm + (end_mm - begin_mm) * i / parts));
    return result;
}

// Fits a smooth curve x to points m with the weights W, with a penalty k on the third differences D x of
// neighbouring points: (W + k D'D) x = W m. The matrix of the fit's equations has seven diagonals, and
// Cholesky's method solves the equations.
std::vector<Vector3d> smooth(const std::vector<Vector3d> &places, const std::vector<double> &weights,
                             double against)
{
    const auto count = static_cast<std::ptrdiff_t>(places.size());
    if (count < 5) return places;
    constexpr std::ptrdiff_t band = 4;
    constexpr double difference[4] = {-1, 3, -3, 1};
    std::vector<std::array<double, band>> rows(static_cast<std::size_t>(count),
                                               std::array<double, band>{}); // [i][d]: (i, i - d)
    const auto at = [&](std::ptrdiff_t i, std::ptrdiff_t d) -> double & {
        return rows[static_cast<std::size_t>(i)][static_cast<std::size_t>(d)];
    };
    for (std::ptrdiff_t i = 0; i < count; ++i) at(i, 0) += weights[static_cast<std::size_t>(i)];
    for (std::ptrdiff_t i = 0; i + 3 < count; ++i)
        for (std::ptrdiff_t a = 0; a < 4; ++a)
            for (std::ptrdiff_t b = 0; b <= a; ++b)
                at(i + a, a - b) += against * difference[a] * difference[b];
    std::vector<Vector3d> x(places.size());
    for (std::size_t i = 0; i < places.size(); ++i) x[i] = weights[i] * places[i];
    for (std::ptrdiff_t i = 0; i < count; ++i) {
        for (std::ptrdiff_t d = std::min(band - 1, i); d >= 0; --d) {
            double sum = at(i, d);
            for (std::ptrdiff_t k = d + 1; k < band && k <= i; ++k) sum -= at(i, k) * at(i - d, k - d);
            at(i, d) = d == 0 ? std::sqrt(std::max(sum, 1e-12)) : sum / at(i - d, 0);
        }
        for (std::ptrdiff_t k = 1; k < band && k <= i; ++k)
            x[static_cast<std::size_t>(i)] -= at(i, k) * x[static_cast<std::size_t>(i - k)];
        x[static_cast<std::size_t>(i)] /= at(i, 0);
    }
    for (std::ptrdiff_t i = count - 1; i >= 0; --i) {
        for (std::ptrdiff_t k = 1; k < band && i + k < count; ++k)
            x[static_cast<std::size_t>(i)] -= at(i + k, k) * x[static_cast<std::size_t>(i + k)];
        x[static_cast<std::size_t>(i)] /= at(i, 0);
    }
    return x;
}

// Extends the centreline with the mean curvature of its last three millimetres.
void extrapolate(std::vector<Vector3d> &line, double by_mm)
{
    const double length = length_of(line);
    const Vector3d a = place_at(line, length - std::min(3.0, length)),
                   b = place_at(line, length - std::min(1.5, length / 2)), c = line.back();
    const double span = (c - b).norm();
    if (span < 1e-6) return;
    const Vector3d turn = ((c - b).normalized() - (b - a).normalized()) / span;
    Vector3d tangent = ((c - b).normalized() + 0.5 * span * turn).normalized(), place = c;
    for (double done = 0; done < by_mm; done += 0.25) {
        const Vector3d next = (tangent + 0.25 * turn).normalized();
        place += 0.25 * (tangent + next).normalized();
        line.push_back(place);
        tangent = next;
    }
}

double median_height(const std::vector<LinePoint> &points)
{
    std::vector<double> heights;
    for (const LinePoint &point : points) heights.push_back(point.height_HU);
    const auto middle = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2);
    std::nth_element(heights.begin(), middle, heights.end());
    return *middle;
}

// Moves every point of the centreline to the middle of the instrument's cross-section, and repeats this step
// a few times.
std::vector<LinePoint> refine(const LineFit &fit, std::vector<Vector3d> line, LineModel &model,
                              const Report &report)
{
    std::vector<LinePoint> points;
    for (int round = 0; round < rounds; ++round) {
        line = resampled(line, step_mm);
        const std::vector<Frame> frames = frames_of(line);
        if (round == 1 || round == 3) fit.fit_blurs(frames, model);
        points.assign(line.size(), {});
        std::vector<Vector3d> measured;
        std::vector<double> weights, variances;
        for (std::size_t i = 0; i < frames.size(); ++i) {
            const AcrossFit across = fit.fit(frames, i, model);
            measured.push_back(line[i] + across.shift1_mm * frames[i].across1 +
                               across.shift2_mm * frames[i].across2);
            points[i].height_HU = across.height_HU;
            variances.push_back(across.variance_mm2);
            report("centreline",
                   (round + static_cast<double>(i) / static_cast<double>(frames.size())) / rounds);
        }
        std::vector<double> sorted = variances;
        std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2),
                         sorted.end());
        const double usual = sorted[sorted.size() / 2];
        for (const double variance : variances) weights.push_back(std::clamp(usual / variance, 0.02, 3.0));
        line = smooth(measured, weights, round + 1 == rounds ? stiffness : 4 * stiffness);
        for (std::size_t i = 0; i < line.size(); ++i) {
            points[i].place_mm = line[i];
            points[i].unsure_mm = std::hypot(std::sqrt(variances[i]), 0.5 * (line[i] - measured[i]).norm());
        }
    }
    report("centreline", 1);
    return points;
}

// Returns the centreline up to the instrument's end, with the uncertainty of each of its points.
std::vector<LinePoint> to_the_tip(const LineFit &fit, const std::vector<LinePoint> &points,
                                  const LineModel &model)
{
    std::vector<Vector3d> line;
    for (const LinePoint &point : points) line.push_back(point.place_mm);
    const double length = length_of(line);
    std::vector<LinePoint> before_end(points.end() - std::min<std::ptrdiff_t>(std::ssize(points), 12),
                                      points.end());
    extrapolate(line, beyond_mm);
    line = resampled(line, 0.25);
    const double end = fit.fit_end(frames_of(line), length - 1.2, length + beyond_mm - 0.5,
                                   median_height(before_end), model);
    std::vector<LinePoint> result = points;
    while (result.size() > 2 && length_of({result.begin()->place_mm}) == 0 &&
           static_cast<double>(result.size() - 1) * step_mm > end)
        result.pop_back();
    // The function computes the last points of the centreline again, so that the centreline ends exactly at
    // the tip.
    double from = 0;
    for (std::size_t i = 1; i < result.size(); ++i)
        from += (result[i].place_mm - result[i - 1].place_mm).norm();
    for (double arc = from + step_mm; arc < end - 0.25 * step_mm; arc += step_mm)
        result.push_back({place_at(line, arc), result.back().unsure_mm + 0.05, result.back().height_HU,
                          "extrapolated to the tip"});
    result.push_back({place_at(line, end), std::hypot(result.back().unsure_mm, 0.15), result.back().height_HU,
                      "the tip: along the line unsure by about 0.2 mm"});
    return result;
}

// The residuals of the fit do not show errors that shift a whole cross-section of the instrument. In a bend,
// blur displaces the cross-section of the instrument towards the inside of the bend. If the instrument lies
// in the plane of the slices, the height of its centreline follows from only one or two slices. The weights
// of the uncertainties in bends and in slices come from virtual scans of bends of 3 mm radius in 1 mm slices.
void doubt_bends_and_slices(std::vector<LinePoint> &points, const Volume &volume)
{
    constexpr double bend_mm2 = 0.4, slice_share = 0.12, flat = 0.5; // flat: sine of the angle to the slice
    const Vector3d across_slices = volume.scene_per_voxel().col(2).normalized();
    for (std::size_t i = 2; i + 2 < points.size(); ++i) {
        const Vector3d before = points[i].place_mm - points[i - 2].place_mm,
                       after = points[i + 2].place_mm - points[i].place_mm;
        const double span = 0.5 * (before.norm() + after.norm());
        if (span < 1e-6) continue;
        const double bend = (after.normalized() - before.normalized()).norm() / span,
                     steepness = std::abs((before + after).normalized().dot(across_slices)),
                     in_slice = std::max(0.0, 1 - steepness / flat);
        const double doubt = std::hypot(bend_mm2 * bend, slice_share * in_slice * volume.spacing_mm[2]);
        points[i].unsure_mm = std::hypot(points[i].unsure_mm, doubt);
        if (doubt > doubtful_mm && points[i].why.empty())
            points[i].why = in_slice > 0.5 ? "lies in the slice" : "bends sharply";
    }
    // The tip and the point next to it are assumed to be as uncertain as the points before them. If the last
    // piece of the instrument lies in the plane of a slice, the tip may be anywhere within the thickness of
    // this slice.
    const double leads = points[points.size() - std::min<std::size_t>(points.size(), 3)].unsure_mm;
    const Vector3d end = points.back().place_mm - points[points.size() - 2].place_mm;
    const double in_slice = std::max(0.0, 1 - std::abs(end.normalized().dot(across_slices)) / flat);
    points.back().unsure_mm =
        std::hypot(std::max(points.back().unsure_mm, leads), 0.5 * in_slice * volume.spacing_mm[2]);
}

void explain(std::vector<LinePoint> &points)
{
    const double usual = median_height(points);
    for (LinePoint &point : points) {
        if (!point.why.empty()) continue;
        if (point.height_HU < 0.3 * usual)
            point.why = "faint: less than a third of its usual brightness";
        else if (point.unsure_mm > 0.3)
            point.why = "streaks or a neighbour: the model fits badly";
    }
}

} // namespace

std::vector<Vector3d> InstrumentLine::places() const
{
    std::vector<Vector3d> result;
    for (const LinePoint &point : points) result.push_back(point.place_mm);
    return result;
}

std::vector<Vector3d> resampled(const std::vector<Vector3d> &line, double step)
{
    const double length = length_of(line);
    const int parts = std::max(2, static_cast<int>(std::lround(length / step)));
    std::vector<Vector3d> result{line.front()};
    std::size_t i = 1;
    double passed = 0;
    for (int part = 1; part < parts; ++part) {
        const double wanted = length * part / parts;
        while (i + 1 < line.size() && passed + (line[i] - line[i - 1]).norm() < wanted) {
            passed += (line[i] - line[i - 1]).norm();
            ++i;
        }
        const double piece = (line[i] - line[i - 1]).norm();
        result.push_back(line[i - 1] + (line[i] - line[i - 1]) * (piece > 0 ? (wanted - passed) / piece : 0));
    }
    result.push_back(line.back());
    return result;
}

LineDistance distance_from(const std::vector<Vector3d> &line, const Vector3d &place)
{
    LineDistance best{1e30, 0};
    double arc = 0;
    for (std::size_t i = 1; i < line.size(); ++i) {
        const Vector3d along = line[i] - line[i - 1];
        const double square = along.squaredNorm();
        const double share =
            square > 0 ? std::clamp((place - line[i - 1]).dot(along) / square, 0.0, 1.0) : 0.0;
        const double away = (place - line[i - 1] - share * along).norm();
        if (away < best.distance_mm) best = {away, arc + share * std::sqrt(square)};
        arc += std::sqrt(square);
    }
    return best;
}

InstrumentLine trace_instrument(const Volume &volume, const Volume &mask, const LineOptions &options,
                                const Report &report)
{
    InstrumentLine result;
    result.threshold_HU = options.threshold_HU;
    std::vector<Vector3d> path = path_through(volume, mask, options, result.notes);
    const double length = length_of(path);
    if (length < 4 * trimmed_mm + 2)
        throw Fault(volume.name + ": the instrument in the scan is too short to be followed");
    // The path through the voxels is stepped, so the function smooths the path first.
    path = part_of(path, 0, length);
    path = smooth(path, std::vector<double>(path.size(), 1.0), 60);
    const bool is_cut_off =
        (path.front() - volume.scene(volume.voxel(path.front()).cwiseMax(3.0))).norm() > 1e-9;
    path = part_of(path, is_cut_off ? 0 : trimmed_mm, length_of(path) - trimmed_mm);
    const LineFit fit(volume);
    LineModel model = fit.first_model(path);
    result.points = to_the_tip(fit, refine(fit, path, model, report), model);
    doubt_bends_and_slices(result.points, volume);
    explain(result.points);
    result.blur_mm = model.blur_mm;
    result.blur_slice_mm = model.blur_slice_mm;
    result.around_HU = model.around_HU;
    return result;
}

} // namespace crn::ct
