#include "tools/lab/figures/canvas.hpp"
#include "host/picture/font.hpp"
#include "host/picture/picture.hpp"
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace vcsim3
{
namespace
{

constexpr int fineness = 2;
constexpr int letter_advance = 6;

int to_fine(double pixels)
{
    return static_cast<int>(std::lround(pixels * fineness));
}

} // namespace

Canvas::Canvas(int width, int height, Colour background)
    : width_(width), height_(height),
      fine_(static_cast<std::size_t>(width) * height * fineness * fineness * 3)
{
    rectangle(0, 0, width, height, background);
}

void Canvas::put(int column, int row, Colour colour)
{
    if (column < 0 || row < 0 || column >= width_ * fineness || row >= height_ * fineness) return;
    std::uint8_t *at = &fine_[(static_cast<std::size_t>(row) * width_ * fineness + column) * 3];
    at[0] = colour.red;
    at[1] = colour.green;
    at[2] = colour.blue;
}

void Canvas::rectangle(double x0, double y0, double x1, double y1, Colour colour)
{
    for (int row = to_fine(y0); row < to_fine(y1); row++)
        for (int column = to_fine(x0); column < to_fine(x1); column++) put(column, row, colour);
}

void Canvas::disc(double x, double y, double radius, Colour colour)
{
    const double cx = x * fineness, cy = y * fineness, r = radius * fineness;
    for (int row = static_cast<int>(cy - r); row <= cy + r; row++)
        for (int column = static_cast<int>(cx - r); column <= cx + r; column++)
            if (std::hypot(column + 0.5 - cx, row + 0.5 - cy) <= r) put(column, row, colour);
}

void Canvas::line(double x0, double y0, double x1, double y1, double thickness, Colour colour)
{
    const double length = std::hypot(x1 - x0, y1 - y0);
    const int steps = std::max(1, static_cast<int>(length * fineness));
    for (int i = 0; i <= steps; i++)
        disc(x0 + (x1 - x0) * i / steps, y0 + (y1 - y0) * i / steps, thickness / 2, colour);
}

void Canvas::dashed(double x0, double y0, double x1, double y1, double thickness, Colour colour)
{
    const double dash = 8.0, length = std::hypot(x1 - x0, y1 - y0);
    for (double at = 0.0; at < length; at += 2 * dash) {
        const double a = at / length, b = std::min(1.0, (at + dash) / length);
        line(x0 + a * (x1 - x0), y0 + a * (y1 - y0), x0 + b * (x1 - x0), y0 + b * (y1 - y0), thickness,
             colour);
    }
}

void Canvas::blend(int x, int y, Colour colour, double share)
{
    for (int row = y * fineness; row < (y + 1) * fineness; row++) {
        for (int column = x * fineness; column < (x + 1) * fineness; column++) {
            if (x < 0 || y < 0 || x >= width_ || y >= height_) continue;
            std::uint8_t *at = &fine_[(static_cast<std::size_t>(row) * width_ * fineness + column) * 3];
            const std::uint8_t wanted[3] = {colour.red, colour.green, colour.blue};
            for (int k = 0; k < 3; k++)
                at[k] = static_cast<std::uint8_t>(at[k] + share * (wanted[k] - at[k]));
        }
    }
}

double Canvas::text_width(std::string_view letters, double size)
{
    return letters.empty() ? 0.0 : (static_cast<double>(letters.size()) * letter_advance - 1) * size;
}

void Canvas::text(double x, double y, std::string_view letters, double size, Colour colour, Align align)
{
    const double width = text_width(letters, size);
    const double left = align == Align::left ? x : align == Align::right ? x - width : x - width / 2;
    for (std::size_t i = 0; i < letters.size(); i++) {
        const auto rows = crn::glyph(letters[i]);
        for (int row = 0; row < crn::glyph_rows; row++)
            for (int column = 0; column < crn::glyph_columns; column++)
                if (rows[row] >> (crn::glyph_columns - 1 - column) & 1) {
                    const double px = left + (static_cast<double>(i) * letter_advance + column) * size;
                    rectangle(px, y + row * size, px + size, y + (row + 1) * size, colour);
                }
    }
}

void Canvas::text_upwards(double x, double y, std::string_view letters, double size, Colour colour)
{
    const double start = y + text_width(letters, size) / 2;
    for (std::size_t i = 0; i < letters.size(); i++) {
        const auto rows = crn::glyph(letters[i]);
        for (int row = 0; row < crn::glyph_rows; row++)
            for (int column = 0; column < crn::glyph_columns; column++)
                if (rows[row] >> (crn::glyph_columns - 1 - column) & 1) {
                    const double py = start - (static_cast<double>(i) * letter_advance + column + 1) * size;
                    rectangle(x + row * size, py, x + (row + 1) * size, py + size, colour);
                }
    }
}

void Canvas::write_png(const std::string &path) const
{
    crn::Image image;
    image.width = width_;
    image.height = height_;
    image.channels = 3;
    image.bytes.resize(static_cast<std::size_t>(width_) * height_ * 3);
    for (int y = 0; y < height_; y++) {
        for (int x = 0; x < width_; x++) {
            for (int k = 0; k < 3; k++) {
                int sum = 0;
                for (int i = 0; i < fineness * fineness; i++) {
                    const int row = y * fineness + i / fineness, column = x * fineness + i % fineness;
                    sum += fine_[(static_cast<std::size_t>(row) * width_ * fineness + column) * 3 + k];
                }
                image.bytes[(static_cast<std::size_t>(y) * width_ + x) * 3 + k] =
                    static_cast<std::uint8_t>(sum / (fineness * fineness));
            }
        }
    }
    std::string error;
    if (!crn::write_png(path, image, error)) throw std::runtime_error(error);
}

} // namespace vcsim3
