// A ray consists of the points t d for all numbers t, with the direction d = (u, v, focal length) in pixels;
// the middle of the cylinder lies at t0 d0, on the ray with the direction d0. Single precision is enough,
// because all values computed in it are small: the distances in pixels from d0, and t - t0.
#include "host/xray/paths/tube_painter.hpp"
#include "host/xray/paths/lanes.hpp"
#include "host/xray/paths/tube_outline.hpp"
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

// Computes path lengths in the cylinder, in 1/1024 mm, for `count` rays in a row: (u + i step, v), in pixels
// from the middle of the cylinder.
inline __attribute__((always_inline)) void chords_of_row(const Chords &c, bool is_hollow, float u, float v,
                                                         float step, int count, std::int32_t *out)
{
    const float dy = c.middle_v + v, dz = c.focal, ey = -c.t0 * v;
    const float nx = dy * c.axis.z - dz * c.axis.y, nx_square = nx * nx, yz_square = dy * dy + dz * dz;
    const float slope_row_a = dy * c.normal_a.y + dz * c.normal_a.z,
                slope_row_b = dy * c.normal_b.y + dz * c.normal_b.z;
    const float end_row_a = ey * c.normal_a.y + c.beyond_a, end_row_b = ey * c.normal_b.y + c.beyond_b;
    for (int i = 0; i < count; ++i) {
        const float from_middle = u + step * static_cast<float>(i);
        const float dx = c.middle_u + from_middle, ex = -c.t0 * from_middle;
        const float ny = dz * c.axis.x - dx * c.axis.z, nz = dx * c.axis.y - dy * c.axis.x; // d x axis
        const float share = 1.0f / greatest(nx_square + ny * ny + nz * nz, 1e-3f);
        const float beside = ex * nx + ey * ny; // distance from the axis times |n|
        const float middle =
            (nx * (ey * c.axis.z) - ny * (ex * c.axis.z) + nz * (ex * c.axis.y - ey * c.axis.x)) * share;
        // The cylinder's two end planes limit the ray's path in it; a small slope replaces a slope of 0, to
        // avoid a division by zero.
        float slope_a = dx * c.normal_a.x + slope_row_a, slope_b = dx * c.normal_b.x + slope_row_b;
        slope_a = std::fabs(slope_a) > 1e-6f ? slope_a : 1e-6f;
        slope_b = std::fabs(slope_b) > 1e-6f ? slope_b : 1e-6f;
        const float at_a = (ex * c.normal_a.x + end_row_a) / slope_a;
        const float at_b = (ex * c.normal_b.x + end_row_b) / slope_b;
        const float low = greatest(slope_a > 0.0f ? at_a : -1e9f, slope_b < 0.0f ? at_b : -1e9f);
        const float high = least(slope_a < 0.0f ? at_a : 1e9f, slope_b > 0.0f ? at_b : 1e9f);
        const float beside_square = beside * beside * share;
        const float outer = std::sqrt(greatest((c.outer_square - beside_square) * share, 0.0f));
        float chord = greatest(least(middle + outer, high) - greatest(middle - outer, low), 0.0f);
        if (is_hollow) {
            const float inner = std::sqrt(greatest((c.inner_square - beside_square) * share, 0.0f));
            chord -= greatest(least(middle + inner, high) - greatest(middle - inner, low), 0.0f);
        }
        const float length = std::sqrt(dx * dx + yz_square);
        const float scaled = chord * length * c.q10;
        out[i] = static_cast<std::int32_t>(least(scaled, 1e9f) + 0.5f);
    }
}

CRN_WIDE void chords_of_solid(const Chords &c, float u, float v, float step, int count, std::int32_t *out)
{
    chords_of_row(c, false, u, v, step, count, out);
}

CRN_WIDE void chords_of_hollow(const Chords &c, float u, float v, float step, int count, std::int32_t *out)
{
    chords_of_row(c, true, u, v, step, count, out);
}

} // namespace

struct TubePainter::Line {
    Chords chords;
    bool is_wide; // one ray per pixel, not grid * grid
    std::size_t material;
    float contrast; // in the displaced material
};

TubePainter::TubePainter(const View &view, std::span<const Material> materials, Material displaced,
                         ToolPaths &paths)
    : paths_(paths), focal_pixels_(view.source_detector_m / view.pixel_m), half_(0.5 * view.size),
      size_(view.size)
{
    if (paths.size == size_)
        for (int y = 0; y < size_; ++y)
            for (int x = paths.touched[y].begin; x < paths.touched[y].end; ++x) row_of(y)[x] = -1;
    else
        paths.entry.assign(static_cast<std::size_t>(size_) * size_, -1);
    paths.size = size_;
    paths.touched.assign(size_, {size_, 0});
    paths.pixels.clear();
    paths.wide_q10mm.clear();
    paths.narrow_entry.clear();
    paths.narrow_q10mm.clear();
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

std::int32_t *TubePainter::row_of(int y)
{
    return paths_.entry.data() + static_cast<std::size_t>(y) * size_;
}

// The list of path lengths is longer than its entries: it grows by parts of its length, and finish() cuts it.
std::size_t TubePainter::entry(std::int32_t &place)
{
    if (place < 0) {
        const std::size_t count = paths_.narrow_entry.size(), materials = paths_.materials.size();
        if ((count + 1) * materials > paths_.wide_q10mm.size())
            paths_.wide_q10mm.resize((count + count / 2 + 1024) * materials, 0);
        paths_.narrow_entry.push_back(-1);
        place = static_cast<std::int32_t>(count);
    }
    return static_cast<std::size_t>(place);
}

std::int32_t *TubePainter::narrow(std::int32_t &of_pixel)
{
    std::int32_t &place = paths_.narrow_entry[entry(of_pixel)];
    const std::size_t ints = paths_.materials.size() * tool_rays;
    if (place < 0) {
        place = static_cast<std::int32_t>(paths_.narrow_q10mm.size() / ints);
        paths_.narrow_q10mm.resize(paths_.narrow_q10mm.size() + ints, 0);
    }
    return paths_.narrow_q10mm.data() + static_cast<std::size_t>(place) * ints;
}

void TubePainter::label(TubeLabels *labels, std::uint8_t bit, bool is_summed)
{
    labels_ = bit != 0 ? labels : nullptr;
    bit_ = bit;
    is_summed_ = is_summed;
}

void TubePainter::mark(int pixel, std::int32_t sum_of_rays)
{
    if (!is_summed_) {
        labels_->pixels[static_cast<std::size_t>(pixel)] |= bit_;
        return;
    }
    std::int32_t &sum = labels_->sums_q10mm[static_cast<std::size_t>(pixel)];
    if (sum == 0) labels_->summed.push_back(pixel);
    sum += sum_of_rays;
}

// Traces the rays of one row of pixels, `rays` rays per pixel along each edge, into rows_.
void TubePainter::trace(const Line &line, int rays, int y, int x0, int x1)
{
    const int count = (x1 - x0) * rays;
    rows_.resize(static_cast<std::size_t>(rays) * count);
    const Chords &c = line.chords;
    const double step = 1.0 / rays;
    const auto u = static_cast<float>(x0 + 0.5 * step - half_ - static_cast<double>(c.middle_u));
    for (int j = 0; j < rays; ++j) {
        const auto v = static_cast<float>(half_ - y - (j + 0.5) * step - static_cast<double>(c.middle_v));
        std::int32_t *row = rows_.data() + static_cast<std::size_t>(j) * count;
        if (c.inner_square > 0.0f)
            chords_of_hollow(c, u, v, static_cast<float>(step), count, row);
        else
            chords_of_solid(c, u, v, static_cast<float>(step), count, row);
    }
}

void TubePainter::paint_wide(const Line &line, int y, int x0, int x1)
{
    trace(line, 1, y, x0, x1);
    const std::int32_t *lengths = rows_.data();
    const std::size_t materials = paths_.materials.size();
    std::int32_t *places = row_of(y);
    for (int x = x0; x < x1; ++x) {
        const std::int32_t length = lengths[x - x0];
        if (length == 0) continue;
        if (labels_ != nullptr) mark(y * size_ + x, tool_rays * length);
        if (places[x] < 0) entry(places[x]); // may move wide_q10mm
        const std::size_t at = static_cast<std::size_t>(places[x]) * materials;
        std::int32_t *of_pixel = paths_.wide_q10mm.data() + at;
        const auto mixed = static_cast<std::int32_t>(static_cast<float>(length) * line.contrast);
        of_pixel[line.material] += length;
        of_pixel[displaced_] -= length - mixed;
        of_pixel[contrast_] -= mixed;
    }
}

void TubePainter::paint_narrow(const Line &line, int y, int x0, int x1)
{
    trace(line, grid, y, x0, x1);
    const std::size_t count = static_cast<std::size_t>(x1 - x0) * grid;
    for (int x = x0; x < x1; ++x) {
        std::int32_t rays[tool_rays], sum = 0;
        for (int j = 0; j < grid; ++j)
            for (int i = 0; i < grid; ++i) {
                rays[j * grid + i] = rows_[j * count + static_cast<std::size_t>(x - x0) * grid + i];
                sum += rays[j * grid + i];
            }
        if (sum == 0) continue;
        if (labels_ != nullptr) mark(y * size_ + x, sum);
        std::int32_t *of_pixel = narrow(row_of(y)[x]);
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
    line.is_wide = outer * focal_pixels_ > wide_pixels * middle.z();
    line.material = slot(piece.material);
    line.contrast = static_cast<float>(std::clamp(piece.displaced_contrast, 0.0, 1.0));

    const TubeOutline outline(piece, outer, focal_pixels_, half_);
    auto pixel = [&](double at) { return static_cast<int>(std::clamp(std::floor(at), -1.0, 1.0 * size_)); };
    const auto [top, bottom] = outline.rows();
    const int y0 = std::max(pixel(top), 0), y1 = std::min(pixel(bottom), size_ - 1);
    for (int y = y0; y <= y1; ++y) {
        const auto [from, to] = outline.columns(y);
        const int x0 = std::max(pixel(from), 0), x1 = std::min(pixel(to) + 1, size_);
        if (x0 >= x1) continue;
        ToolPaths::Columns &touched = paths_.touched[y];
        touched = {std::min(touched.begin, x0), std::max(touched.end, x1)};
        if (line.is_wide)
            paint_wide(line, y, x0, x1);
        else
            paint_narrow(line, y, x0, x1);
    }
}

void TubePainter::finish()
{
    paths_.wide_q10mm.resize(paths_.narrow_entry.size() * paths_.materials.size());
    paths_.pixels.reserve(paths_.narrow_entry.size());
    for (int y = 0; y < size_; ++y) {
        const std::int32_t *row = row_of(y);
        for (int x = paths_.touched[y].begin; x < paths_.touched[y].end; ++x)
            if (row[x] >= 0) paths_.pixels.push_back(y * size_ + x);
    }
}

} // namespace crn
