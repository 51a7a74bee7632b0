/* How dense the spongy bone of a person is (docs/anatomy.md, "Density of spongy bone"). */
#include "tools/anatomy/skeleton.hpp"
#include <algorithm>
#include <cmath>

namespace anatomy
{

/* 226 HU below 30 years, and 2.5 HU less each year (Jang 2019, CTs of 20,374 persons). Women have more until
 * the menopause and less after it; the differences are assumed. */
double lumbar_hu(Sex sex, double age_years)
{
    constexpr double YOUNG_HU = 226.0, YOUNG_YEARS = 30.0, LOSS_HU = 2.5, LEAST_HU = 60.0, MORE_HU = 8.0,
                     LESS_HU = 15.0, MENOPAUSE_YEARS = 50.0, SETTLED_YEARS = 65.0;
    double hu = YOUNG_HU - LOSS_HU * std::max(0.0, age_years - YOUNG_YEARS);
    if (sex == Sex::woman)
        hu += std::lerp(
            MORE_HU, -LESS_HU,
            std::clamp((age_years - MENOPAUSE_YEARS) / (SETTLED_YEARS - MENOPAUSE_YEARS), 0.0, 1.0));
    return std::max(hu, LEAST_HU);
}

std::string spongy_material(double density, const SkeletonShape &shape)
{
    // Yellow marrow has -100 HU and compact bone 1650 HU at 120 kV, so that the nominal material of 19.5 %
    // has 240 HU.
    constexpr double MARROW_HU = -100.0, BONE_HU = 1650.0;
    constexpr long NOMINAL_PERCENT = 20, LEAST_PERCENT = 1, MOST_PERCENT = 60;
    const double hu = density * lumbar_hu(shape.sex, shape.age_years);
    const long percent = std::lround(100.0 * (hu - MARROW_HU) / (BONE_HU - MARROW_HU));
    if (density <= 0.0 || percent == NOMINAL_PERCENT) return "trabecular_bone";
    return "spongy_" + std::to_string(std::clamp(percent, LEAST_PERCENT, MOST_PERCENT));
}

} // namespace anatomy
