// A ray consists of the points t d for all numbers t, with the direction d = (u, v, focal length) in pixels;
// the middle of the cylinder lies at t0 d0, on the ray with the direction d0. Single precision is enough,
// because all values computed in it are small: the distances in pixels from d0, and t - t0.
#include "host/xray/paths/tube_painter.hpp"
#include "host/xray/paths/lanes.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{

using Eigen::Vector3d;

namespace
{

constexpr int grid = 3; // rays along each edge of a pixel
static_assert(grid * grid == tool_rays);
constexpr double wide_pixels = 6.0; // of radius; from here on one ray per pixel is as accurate as nine

struct Vector3 {
    float x, y, z;
};

Vector3 single(const Vector3d &v)
{
    return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

// Holds the values that are constant for all rays through one piece of a tool.
struct Chords {
    Vector3 axis, normal_a, normal_b;
    float middle_u, middle_v, focal, t0; // pixels; mm per pixel
    float beyond_a, beyond_b;            // (a - middle) normal_a, (b - middle) normal_b
    float outer_square, inner_square;    // mm2
    float q10;                           // 1/1024 mm of material per mm of chord
};

float least(float a, float b)
{
    return a < b ? a : b;
}

float greatest(float a, float b)
{
    return a > b ? a : b;
}

// Computes path lengths in the uncut cylinder, in 1/1024 mm, for `count` rays in a row: (u + i step, v), in
// pixels from the middle of the cylinder.
CRN_WIDE void chords_of_row(const Chords &c, float u, float v, float step, int count, std::int32_t *out)
{
    const float dy = c.middle_v + v, dz = c.focal, ey = -c.t0 * v;
    for (int i = 0; i < count; ++i) {
        const float from_middle = u + step * static_cast<float>(i);
        const float dx = c.middle_u + from_middle, ex = -c.t0 * from_middle;
        const float nx = dy * c.axis.z - dz * c.axis.y, ny = dz * c.axis.x - dx * c.axis.z,
                    nz = dx * c.axis.y - dy * c.axis.x; // d x axis
        const float square = greatest(nx * nx + ny * ny + nz * nz, 1e-3f);
        const float beside = ex * nx + ey * ny; // distance from the axis times |n|
        const float middle =
            (nx * (ey * c.axis.z) - ny * (ex * c.axis.z) + nz * (ex * c.axis.y - ey * c.axis.x)) / square;
        // The cylinder's two end planes limit the ray's path in it; a small slope replaces a slope of 0, to
        // avoid a division by zero.
        float slope_a = dx * c.normal_a.x + dy * c.normal_a.y + dz * c.normal_a.z;
        float slope_b = dx * c.normal_b.x + dy * c.normal_b.y + dz * c.normal_b.z;
        slope_a = std::fabs(slope_a) > 1e-6f ? slope_a : 1e-6f;
        slope_b = std::fabs(slope_b) > 1e-6f ? slope_b : 1e-6f;
        const float at_a = (ex * c.normal_a.x + ey * c.normal_a.y + c.beyond_a) / slope_a;
        const float at_b = (ex * c.normal_b.x + ey * c.normal_b.y + c.beyond_b) / slope_b;
        const float low = greatest(slope_a > 0.0f ? at_a : -1e9f, slope_b < 0.0f ? at_b : -1e9f);
        const float high = least(slope_a < 0.0f ? at_a : 1e9f, slope_b > 0.0f ? at_b : 1e9f);
        const float under_outer = c.outer_square * square - beside * beside;
        const float under_inner = c.inner_square * square - beside * beside;
        const float outer = std::sqrt(greatest(under_outer, 0.0f)) / square;
        const float inner = std::sqrt(greatest(under_inner, 0.0f)) / square;
        const float filled = greatest(least(middle + outer, high) - greatest(middle - outer, low), 0.0f);
        const float hollow = greatest(least(middle + inner, high) - greatest(middle - inner, low), 0.0f);
        const float chord = under_outer > 0.0f ? (under_inner > 0.0f ? filled - hollow : filled) : 0.0f;
        const float length = std::sqrt(dx * dx + dy * dy + dz * dz);
        const float scaled = chord * length * c.q10;
        out[i] = static_cast<std::int32_t>(least(scaled, 1e9f) + 0.5f);
    }
}

// Finds those columns [first, second) of the rows [y, y + 1] that are nearer than `pad` to the line from (ax,
// ay) to (bx, by).
struct Extent {
    double ax, ay, bx, by, pad;

    std::pair<double, double> columns(double y) const
    {
        const double low = y - pad, high = y + 1.0 + pad, dy = by - ay;
        double begin = 0.0, end = 1.0;
        if (std::fabs(dy) > 1e-9) {
            const double first = (low - ay) / dy, second = (high - ay) / dy;
            begin = std::max(begin, std::min(first, second));
            end = std::min(end, std::max(first, second));
        }
        if (begin > end) return {0.0, -1.0};
        const double x0 = ax + begin * (bx - ax), x1 = ax + end * (bx - ax);
        return {std::min(x0, x1) - pad, std::max(x0, x1) + pad};
    }
};

} // namespace

struct TubePainter::Line {
    Chords chords;
    int rays; // per pixel along each edge: grid or 1
    std::size_t material;
    float contrast; // in the displaced material
};

TubePainter::TubePainter(const View &view, std::span<const Material> materials, Material displaced,
                         ToolPaths &paths)
    : paths_(paths), focal_pixels_(view.source_detector_m / view.pixel_m), half_(0.5 * view.size),
      size_(view.size)
{
    if (paths.size == size_)
        for (std::int32_t pixel : paths.pixels) paths.entry[pixel] = -1;
    else
        paths.entry.assign(static_cast<std::size_t>(size_) * size_, -1);
    paths.size = size_;
    paths.pixels.clear();
    paths.q10mm.clear();
    paths.materials = {displaced};
    auto add = [&](Material material) {
        auto &known = paths.materials;
        if (std::find(known.begin(), known.end(), material) == known.end()) known.push_back(material);
    };
    add(Material::iohexol_350);
    for (Material material : materials) add(material);
    displaced_ = slot(displaced);
    contrast_ = slot(Material::iohexol_350);
}

std::size_t TubePainter::slot(Material material) const
{
    return std::find(paths_.materials.begin(), paths_.materials.end(), material) - paths_.materials.begin();
}

std::int32_t *TubePainter::entry(int pixel)
{
    std::int32_t &place = paths_.entry[pixel];
    if (place < 0) {
        place = static_cast<std::int32_t>(paths_.pixels.size());
        paths_.pixels.push_back(pixel);
        paths_.q10mm.resize(paths_.q10mm.size() + paths_.ints_per_pixel(), 0);
    }
    return paths_.q10mm.data() + static_cast<std::size_t>(place) * paths_.ints_per_pixel();
}

void TubePainter::label(TubeLabels *labels, std::uint8_t bit, bool is_summed)
{
    labels_ = bit != 0 ? labels : nullptr;
    bit_ = bit;
    is_summed_ = is_summed;
}

void TubePainter::mark(int pixel, const std::int32_t *rays)
{
    if (!is_summed_) {
        labels_->pixels[static_cast<std::size_t>(pixel)] |= bit_;
        return;
    }
    std::int32_t &sum = labels_->sums_q10mm[static_cast<std::size_t>(pixel)];
    if (sum == 0) labels_->summed.push_back(pixel);
    for (int k = 0; k < tool_rays; ++k) sum += rays[k];
}

void TubePainter::paint_row(const Line &line, int y, int x0, int x1)
{
    const int count = (x1 - x0) * line.rays;
    rows_.resize(static_cast<std::size_t>(line.rays) * count);
    const double step = 1.0 / line.rays;
    const auto u = static_cast<float>(x0 + 0.5 * step - half_ - static_cast<double>(line.chords.middle_u));
    for (int j = 0; j < line.rays; ++j) {
        const auto v =
            static_cast<float>(half_ - y - (j + 0.5) * step - static_cast<double>(line.chords.middle_v));
        chords_of_row(line.chords, u, v, static_cast<float>(step), count, rows_.data() + j * count);
    }
    for (int x = 0; x < x1 - x0; ++x) {
        std::int32_t rays[tool_rays], any = 0;
        for (int j = 0; j < grid; ++j)
            for (int i = 0; i < grid; ++i) {
                const int row = line.rays == grid ? j : 0, column = line.rays == grid ? x * grid + i : x;
                rays[j * grid + i] = rows_[row * count + column];
                any |= rays[j * grid + i];
            }
        if (any == 0) continue;
        if (labels_ != nullptr) mark(y * size_ + x0 + x, rays);
        std::int32_t *of_pixel = entry(y * size_ + x0 + x);
        std::int32_t *own = of_pixel + line.material * tool_rays;
        std::int32_t *blood = of_pixel + displaced_ * tool_rays, *contrast = of_pixel + contrast_ * tool_rays;
        for (int k = 0; k < tool_rays; ++k) {
            const auto mixed = static_cast<std::int32_t>(static_cast<float>(rays[k]) * line.contrast);
            own[k] += rays[k];
            blood[k] -= rays[k] - mixed;
            contrast[k] -= mixed;
        }
    }
}

void TubePainter::paint(const TubePiece &piece)
{
    const Vector3d middle = 0.5 * (piece.a_mm + piece.b_mm);
    double outer = piece.outer_mm, inner = std::min(piece.inner_mm, outer), share = piece.share;
    const double near_mm = std::min(piece.a_mm.z(), piece.b_mm.z()) - outer;
    if (!(near_mm > 1.0) || !(outer > 0.0) || !(share > 0.0)) return;
    // A cylinder whose radius is below the distance between rays is drawn with this distance as its radius,
    // but with the same amount of material in its cross-section.
    const double apart_mm = middle.z() / focal_pixels_ / grid;
    if (outer < apart_mm) {
        share *= (outer * outer - inner * inner) / (apart_mm * apart_mm);
        outer = apart_mm;
        inner = 0.0;
    }
    auto pixel_x = [&](const Vector3d &p) { return half_ + focal_pixels_ * p.x() / p.z(); };
    auto pixel_y = [&](const Vector3d &p) { return half_ - focal_pixels_ * p.y() / p.z(); };
    // `pad` includes an allowance for the rim of the cylinder, for its oblique ends at the bisecting planes,
    // and for half a pixel's diagonal.
    const double pad = 1.6 * outer * focal_pixels_ / near_mm + 1.0;
    const Extent extent{pixel_x(piece.a_mm), pixel_y(piece.a_mm), pixel_x(piece.b_mm), pixel_y(piece.b_mm),
                        pad};

    Line line;
    Chords &c = line.chords;
    c.axis = single((piece.b_mm - piece.a_mm).normalized());
    c.normal_a = single(piece.normal_a);
    c.normal_b = single(piece.normal_b);
    c.middle_u = static_cast<float>(focal_pixels_ * middle.x() / middle.z());
    c.middle_v = static_cast<float>(focal_pixels_ * middle.y() / middle.z());
    c.focal = static_cast<float>(focal_pixels_);
    c.t0 = static_cast<float>(middle.z() / focal_pixels_);
    c.beyond_a = static_cast<float>((piece.a_mm - middle).dot(piece.normal_a));
    c.beyond_b = static_cast<float>((piece.b_mm - middle).dot(piece.normal_b));
    c.outer_square = static_cast<float>(outer * outer);
    c.inner_square = static_cast<float>(inner * inner);
    c.q10 = static_cast<float>(std::min(share, 1.0) * 1024.0);
    line.rays = outer * focal_pixels_ > wide_pixels * middle.z() ? 1 : grid;
    line.material = slot(piece.material);
    line.contrast = static_cast<float>(std::clamp(piece.displaced_contrast, 0.0, 1.0));

    auto pixel = [&](double at) { return static_cast<int>(std::clamp(std::floor(at), -1.0, 1.0 * size_)); };
    const int y0 = std::max(pixel(std::min(extent.ay, extent.by) - pad), 0);
    const int y1 = std::min(pixel(std::max(extent.ay, extent.by) + pad), size_ - 1);
    for (int y = y0; y <= y1; ++y) {
        const auto [from, to] = extent.columns(y);
        const int x0 = std::max(pixel(from), 0), x1 = std::min(pixel(to) + 1, size_);
        if (x0 < x1) paint_row(line, y, x0, x1);
    }
}

} // namespace crn
