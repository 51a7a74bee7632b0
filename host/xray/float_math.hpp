// Powers and logarithms of two by sums and products only: equal bytes from every compiler, and loops over them vectorise.
#pragma once
#include <bit>
#include <cstdint>

namespace seld
{

// 2^f on [0, 1): minimax-like polynomial (Taylor of degree 6 about 1/2), relative error 1.2e-7.
inline float exp2_fraction(float f)
{
    const float x = (f - 0.5f) * 0.69314718f;
    float sum =
        1.0f + x * (1.0f + x * (0.5f + x * (0.16666667f +
                                            x * (0.041666668f + x * (0.0083333338f + x * 0.0013888889f)))));
    return sum * 1.41421356f;
}

// 2^-x for x >= 0 (from 126 on: 2^-126); relative error <= 4e-6.
inline float exp2_negative(float x)
{
    x = x < 126.0f ? x : 126.0f;
    const float y = 126.0f - x; // 2^-x = 2^y 2^-126
    const auto whole = static_cast<std::int32_t>(y);
    const float fraction = y - static_cast<float>(whole);
    const float scale = std::bit_cast<float>((whole + 1) << 23);
    return exp2_fraction(fraction) * scale;
}

// log2(x) for normal x > 0; absolute error <= 2e-5. Mantissa m in [1, 2) through atanh: s = (m - q)/(m + q), q = sqrt 2.
inline float log2_positive(float x)
{
    const auto bits = std::bit_cast<std::int32_t>(x);
    const float exponent = static_cast<float>((bits >> 23) - 127);
    const float m = std::bit_cast<float>((bits & 0x7fffff) | 0x3f800000);
    const float s = (m - 1.41421356f) / (m + 1.41421356f), s2 = s * s;
    return exponent + 0.5f + s * (2.8853901f + s2 * (0.96179669f + s2 * (0.57707802f + s2 * 0.41219859f)));
}

} // namespace seld
