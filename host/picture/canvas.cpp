#include "host/picture/canvas.hpp"
#include "host/picture/font.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{

namespace
{

double distance(const SheetPoint &a, const SheetPoint &b, double x, double y)
{
    const double dx = b.x - a.x, dy = b.y - a.y, square = dx * dx + dy * dy;
    const double u = square > 0.0 ? std::clamp(((x - a.x) * dx + (y - a.y) * dy) / square, 0.0, 1.0) : 0.0;
    return std::hypot(a.x + u * dx - x, a.y + u * dy - y);
}

// Divides a line into dashes: returns the drawn pieces, `dash` pixels long, which alternate with gaps of the
// same length.
std::vector<std::vector<SheetPoint>> dashes(const std::vector<SheetPoint> &points, double dash)
{
    std::vector<std::vector<SheetPoint>> parts(1);
    double left = dash;
    bool is_ink = true;
    for (std::size_t i = 0; i + 1 < points.size(); i++) {
        SheetPoint from = points[i];
        double length = std::hypot(points[i + 1].x - from.x, points[i + 1].y - from.y);
        while (length > 0.0) {
            const double step = std::min(length, left), u = step / length;
            const SheetPoint to = {from.x + u * (points[i + 1].x - from.x),
                                   from.y + u * (points[i + 1].y - from.y)};
            if (is_ink && parts.back().empty()) parts.back().push_back(from);
            if (is_ink) parts.back().push_back(to);
            length -= step;
            left -= step;
            from = to;
            if (left > 1e-9) continue;
            left = dash;
            is_ink = !is_ink;
            if (is_ink) parts.emplace_back();
        }
    }
    return parts;
}

} // namespace

Sheet::Sheet(int width, int height)
    : image_{width, height, 3, std::vector<std::uint8_t>(3u * static_cast<std::size_t>(width) * height, 255)}
{
    unclip();
}

void Sheet::clip(int x0, int y0, int x1, int y1)
{
    x0_ = std::max(0, x0);
    y0_ = std::max(0, y0);
    x1_ = std::min(image_.width, x1);
    y1_ = std::min(image_.height, y1);
}

void Sheet::unclip()
{
    clip(0, 0, image_.width, image_.height);
}

void Sheet::blend(int x, int y, Ink ink, double share)
{
    if (x < x0_ || x >= x1_ || y < y0_ || y >= y1_) return;
    std::uint8_t *pixel = image_.bytes.data() + 3 * (static_cast<std::size_t>(y) * image_.width + x);
    const std::uint8_t inks[3] = {ink.red, ink.green, ink.blue};
    for (int c = 0; c < 3; c++) {
        pixel[c] = static_cast<std::uint8_t>(std::lround(pixel[c] + share * (inks[c] - pixel[c])));
    }
}

void Sheet::box(int x0, int y0, int x1, int y1, Ink ink)
{
    for (int y = y0; y < y1; y++) {
        for (int x = x0; x < x1; x++) blend(x, y, ink, 1.0);
    }
}

void Sheet::stroke(const std::vector<SheetPoint> &points, double width, Ink ink, double dash)
{
    if (dash <= 0.0) return cover(points, width, ink);
    for (const std::vector<SheetPoint> &part : dashes(points, dash)) cover(part, width, ink);
}

// Draws every pixel of the line once, with a strength that depends on the pixel's distance from the line.
void Sheet::cover(const std::vector<SheetPoint> &points, double width, Ink ink)
{
    if (points.empty()) return;
    const double reach = 0.5 * width + 0.5;
    const std::size_t columns = static_cast<std::size_t>(std::max(0, x1_ - x0_));
    std::vector<float> shares(columns * static_cast<std::size_t>(std::max(0, y1_ - y0_)), 0.0f);
    for (std::size_t i = 0; i < points.size(); i++) {
        const SheetPoint &a = points[i], &b = points[std::min(i + 1, points.size() - 1)];
        const int left = std::max(x0_, static_cast<int>(std::floor(std::min(a.x, b.x) - reach)));
        const int right = std::min(x1_, static_cast<int>(std::ceil(std::max(a.x, b.x) + reach)));
        const int top = std::max(y0_, static_cast<int>(std::floor(std::min(a.y, b.y) - reach)));
        const int bottom = std::min(y1_, static_cast<int>(std::ceil(std::max(a.y, b.y) + reach)));
        for (int y = top; y < bottom; y++) {
            for (int x = left; x < right; x++) {
                const double share = std::clamp(reach - distance(a, b, x + 0.5, y + 0.5), 0.0, 1.0);
                float &held =
                    shares[static_cast<std::size_t>(y - y0_) * columns + static_cast<std::size_t>(x - x0_)];
                held = std::max(held, static_cast<float>(share));
            }
        }
    }
    for (int y = y0_; y < y1_; y++) {
        for (int x = x0_; x < x1_; x++) {
            const float share =
                shares[static_cast<std::size_t>(y - y0_) * columns + static_cast<std::size_t>(x - x0_)];
            if (share > 0.0f) blend(x, y, ink, share);
        }
    }
}

void Sheet::text(int x, int y, std::string_view text, int scale, Ink ink)
{
    for (char letter : text) {
        const auto rows = glyph(letter);
        for (int row = 0; row < glyph_rows; row++) {
            for (int column = 0; column < glyph_columns; column++) {
                if (!(rows[static_cast<std::size_t>(row)] >> (glyph_columns - 1 - column) & 1)) continue;
                const int left = x + column * scale, top = y + row * scale;
                box(left, top, left + scale, top + scale, ink);
            }
        }
        x += (glyph_columns + 1) * scale;
    }
}

int Sheet::text_width(std::string_view text, int scale)
{
    return text.empty() ? 0 : (static_cast<int>(text.size()) * (glyph_columns + 1) - 1) * scale;
}

} // namespace crn
