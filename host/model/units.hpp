// Converts physical values to the number formats of the byte protocol and back. No other file of the host
// depends on the Q30 number format. Values are rounded to nearest. A value outside a number format's range
// causes an exception, so that no value wraps around silently.
#pragma once
#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <stdexcept>

namespace crn::units
{

inline double from_q(std::int32_t value, int bits)
{
    return std::ldexp(static_cast<double>(value), -bits);
}

inline std::int32_t to_q(double value, int bits)
{
    const double scaled = std::nearbyint(std::ldexp(value, bits));
    if (!(scaled >= -2147483648.0 && scaled <= 2147483647.0)) {
        throw std::range_error("a value does not fit its number format");
    }
    return static_cast<std::int32_t>(scaled);
}

inline double metres(std::int32_t m_q30)
{
    return from_q(m_q30, 30);
}
inline double newtons(std::int32_t N_q22)
{
    return from_q(N_q22, 22);
}
inline double newton_metres(std::int32_t N_m_q24)
{
    return from_q(N_m_q24, 24);
}
inline double ratio(std::int32_t ratio_q30)
{
    return from_q(ratio_q30, 30);
}
inline Eigen::Vector3d metres(std::int32_t x, std::int32_t y, std::int32_t z)
{
    return {metres(x), metres(y), metres(z)};
}
inline std::int32_t metres_to_q30(double m)
{
    return to_q(m, 30);
}
inline std::int32_t unit_to_q30(double component)
{
    return to_q(component, 30);
}

} // namespace crn::units
