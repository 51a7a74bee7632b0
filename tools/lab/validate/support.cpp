#include "tools/lab/validate/support.hpp"
#include "host/base/number_text.hpp"

#include <algorithm>
#include <cmath>

namespace crn::validate
{

double element_length(double length_m, unsigned count)
{
    return (std::floor(length_m * 1e6 / count) + 1) * 1e-6;
}

int settle(Rig &rig, double still_m, int ticks_max)
{
    constexpr int block = 200;
    std::vector<Vector3d> before = rig.shape();
    for (int ticks = block; ticks <= ticks_max; ticks += block) {
        rig.step(block);
        std::vector<Vector3d> now = rig.shape();
        double moved = 0;
        for (std::size_t i = 0; i < std::min(now.size(), before.size()); i++) {
            moved = std::max(moved, (now[i] - before[i]).norm());
        }
        if (ticks >= 2 * block && moved <= still_m) return ticks;
        before = now;
    }
    return ticks_max;
}

std::string power_text(double value)
{
    int power = int(std::floor(std::log10(value) + 1e-9));
    return number_text(value / std::pow(10, power)) + "e" + std::to_string(power);
}

double zero_of_line(const std::vector<double> &x, const std::vector<double> &y)
{
    std::size_t b = x.size() - 1, a = b - 1;
    return x[b] - y[b] * (x[b] - x[a]) / (y[b] - y[a]);
}

double heading(const Rig &rig, unsigned node)
{
    std::vector<Vector3d> points = rig.shape();
    Vector3d tangent = -Vector3d::UnitX(), axis = Vector3d::UnitY();
    for (std::size_t i = points.size() - 1; i-- > node;) {
        Vector3d ahead = (points[i + 1] - points[i]).normalized();
        axis = (axis - axis.dot(ahead) / (1 + tangent.dot(ahead)) * (tangent + ahead)).normalized();
        tangent = ahead;
    }
    Vector3d chord = points[0] - points[node];
    chord -= chord.dot(tangent) * tangent;
    return -std::atan2(tangent.dot(axis.cross(chord)), axis.dot(chord));
}

double unwrapped(double angle, double near)
{
    return angle + 2 * M_PI * std::round((near - angle) / (2 * M_PI));
}

} // namespace crn::validate
