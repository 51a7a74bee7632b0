// Computes powers and logarithms of two with sums and products only. With sums and products alone, every
// compiler gives results that are equal bit for bit, and can vectorise loops with these functions.
#pragma once
#include <bit>
#include <cstdint>

namespace crn
{

// Returns 2^f for f in [0, 1) with a relative error of 1.2e-7. The polynomial for 2^f is nearly minimax (a
// Taylor polynomial of degree 6 about 1/2).
inline float exp2_fraction(float f)
{
    const float x = (f - 0.5f) * 0.69314718f;
    float sum =
        1.0f + x * (1.0f + x * (0.5f + x * (0.16666667f +
                                            x * (0.041666668f + x * (0.0083333338f + x * 0.0013888889f)))));
    return sum * 1.41421356f;
}

// Returns 2^-x for x >= 0, and 2^-126 from x = 126 on; relative error <= 4e-6.
inline float exp2_negative(float x)
{
    x = x < 126.0f ? x : 126.0f;
    const float y = 126.0f - x; // 2^-x = 2^y 2^-126
    const auto whole = static_cast<std::int32_t>(y);
    const float fraction = y - static_cast<float>(whole);
    const float scale = std::bit_cast<float>((whole + 1) << 23);
    return exp2_fraction(fraction) * scale;
}

// Returns log2(x) for normal x > 0; absolute error <= 2e-5. The logarithm of the mantissa m in [1, 2) is
// computed as an atanh of s = (m - q)/(m + q), with q = sqrt 2.
inline float log2_positive(float x)
{
    const auto bits = std::bit_cast<std::int32_t>(x);
    const float exponent = static_cast<float>((bits >> 23) - 127);
    const float m = std::bit_cast<float>((bits & 0x7fffff) | 0x3f800000);
    const float s = (m - 1.41421356f) / (m + 1.41421356f), s2 = s * s;
    return exponent + 0.5f + s * (2.8853901f + s2 * (0.96179669f + s2 * (0.57707802f + s2 * 0.41219859f)));
}

// The next functions compute tables in double precision with a relative error <= 1e-12: 2^x for -1000 < x <
// 1000, and log2(x) for normal x > 0.
inline double exp2_double(double x)
{
    const auto whole = static_cast<std::int64_t>(x < 0.0 ? x - 1.0 : x); // floor, or one less
    const double t = (x - static_cast<double>(whole) - 0.5) * 0.69314718055994530942;
    constexpr double inverse[] = {1.0,     1.0 / 2, 1.0 / 3,  1.0 / 4,  1.0 / 5,  1.0 / 6, 1.0 / 7,
                                  1.0 / 8, 1.0 / 9, 1.0 / 10, 1.0 / 11, 1.0 / 12, 1.0 / 13};
    double sum = 1.0; // Taylor series about the middle, |t| <= 0.35
    for (int k = 12; k >= 0; --k) sum = 1.0 + sum * t * inverse[k];
    return sum * 1.41421356237309504880 * std::bit_cast<double>((whole + 1023) << 52);
}

inline double log2_double(double x)
{
    const auto bits = std::bit_cast<std::int64_t>(x);
    const double exponent = static_cast<double>((bits >> 52) - 1023);
    const double m = std::bit_cast<double>((bits & 0xfffffffffffffll) | 0x3ff0000000000000ll);
    const double s = (m - 1.41421356237309504880) / (m + 1.41421356237309504880), s2 = s * s;
    double sum = 0.0; // atanh(s)/s, |s| <= 0.172
    for (int k = 17; k > 0; k -= 2) sum = 1.0 / k + sum * s2;
    return exponent + 0.5 + s * sum * 2.88539008177792681472;
}

inline double exp_double(double x)
{
    return exp2_double(x * 1.44269504088896340736);
}

// The next functions return sin(pi x) and cos(pi x) for |x| <= 1; absolute error <= 1e-13.
inline double sin_pi(double x)
{
    const double a = x * 3.14159265358979323846 / 8.0, a2 = a * a; // three doublings of the angle
    double s = 0.0, c = 0.0;
    for (int k = 6; k > 0; --k) {
        s = (1.0 - s * a2 / ((2 * k + 2) * (2 * k + 3)));
        c = (1.0 - c * a2 / ((2 * k + 1) * (2 * k + 2)));
    }
    s = a * (1.0 - s * a2 / 6.0);
    c = 1.0 - c * a2 / 2.0;
    for (int k = 0; k < 3; ++k) {
        const double twice = 2.0 * s * c;
        c = c * c - s * s;
        s = twice;
    }
    return s;
}

inline double cos_pi(double x)
{
    const double s = sin_pi(0.5 * x);
    return 1.0 - 2.0 * s * s;
}

} // namespace crn
