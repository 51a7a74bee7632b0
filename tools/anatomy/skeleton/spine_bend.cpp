/* The curve of a person's spine relative to the shipped man's. Whatever has no source here is assumed. */
#include "tools/anatomy/skeleton/spine_bend.hpp"
#include "tools/anatomy/chance.hpp"
#include "tools/anatomy/skeleton/levels.hpp"
#include <algorithm>
#include <cmath>

namespace anatomy
{

namespace
{

/* A bump that rises from 0 at `low` to 1 in the middle and falls to 0 at `high`, without a bend in its ends.
 */
struct Bump {
    double low_mm, high_mm;
    double at(double y_mm) const
    {
        if (y_mm <= low_mm || y_mm >= high_mm) return 0.0;
        const double sine = std::sin(std::numbers::pi * (y_mm - low_mm) / (high_mm - low_mm));
        return sine * sine;
    }
    /* Its steepest slopes lie a quarter of its length from both ends, and are pi over its length, for a
     * height of 1. So this height gives the angle between the two tangents there. */
    double height_mm(double angle_deg) const
    {
        return (high_mm - low_mm) / std::numbers::pi * std::tan(0.5 * angle_deg * DEGREE);
    }
};

/* The spine bulges backwards between L3 and C6, most at T8. Its tangents differ most between T4 and T12,
 * whose outer end plates are measured; their angle grows by ENDS of that of the tangents. */
constexpr Bump BACK{-60.0, 290.0};
constexpr double ENDS = 0.86;
/* A scoliosis bulges to one side at T8, and less to the other side at L2. */
constexpr Bump CHEST{5.0, 215.0}, LOINS{-160.0, 5.0};
constexpr double LOINS_SHARE = 0.7;

/* The share of the spine's shift that a point takes part in, by how far it lies in front of the middle of the
 * spine, and by how far it lies aside. */
double share_ahead(double ahead_mm)
{
    return 1.0 - smooth_step(20.0, 62.0, ahead_mm);
}

double share_aside(double aside_mm)
{
    return 1.0 - smooth_step(45.0, 110.0, aside_mm);
}

} // namespace

Vec3 spine_shift_mm(const SpineBend &bend, double y_mm)
{
    if (bend == SpineBend{}) return Vec3::Zero();
    const double right_mm = CHEST.height_mm(bend.scoliosis_deg) * CHEST.at(y_mm) -
                            LOINS.height_mm(LOINS_SHARE * bend.scoliosis_deg) * LOINS.at(y_mm);
    return {-right_mm, 0.0, -BACK.height_mm(bend.kyphosis_deg / ENDS) * BACK.at(y_mm)};
}

double deepest_shift_mm(const SpineBend &bend)
{
    return std::max(0.0, -spine_shift_mm(bend, 0.5 * (BACK.low_mm + BACK.high_mm)).z());
}

Vec3 moved_with_spine(const SpineBend &bend, const Vec3 &p)
{
    if (bend == SpineBend{}) return p;
    const Vec3 shift = spine_shift_mm(bend, p.y());
    const double share = share_ahead(p.z() - spine_course_z_mm(p.y()));
    return p + Vec3(share * share_aside(std::abs(p.x())) * shift.x(), 0.0, share * shift.z());
}

Vec3 before_bend(const SpineBend &bend, const Vec3 &p)
{
    constexpr int ROUNDS = 6; // each one leaves at most 0.6 of the error
    if (bend == SpineBend{}) return p;
    const Vec3 shift = spine_shift_mm(bend, p.y());
    const double course_mm = spine_course_z_mm(p.y());
    double z_mm = p.z(), share = 0.0;
    for (int round = 0; round < ROUNDS; round++) {
        share = share_ahead(z_mm - course_mm);
        z_mm = p.z() - share * shift.z();
    }
    return {p.x() - share * share_aside(std::abs(p.x())) * shift.x(), p.y(), z_mm};
}

double usual_added_kyphosis_deg(Sex sex, double age_years)
{
    // Fon 1980, AJR 134:979, means by decade of 159 men and 157 women who stood; the figures are from memory.
    // Bartynski 2005 (AJNR 26:2077) agrees: 26.8 degrees from 18 to 35 years, 41.9 degrees above 65.
    constexpr double FIRST_YEARS = 25.0, DECADE = 10.0;
    constexpr double MEANS_DEG[2][6] = {{26.3, 29.0, 29.8, 33.0, 34.7, 40.7},
                                        {27.4, 28.4, 33.7, 40.7, 44.9, 44.9}}; // women above 70: as below
    constexpr double LYING = 0.8; // less of a person who lies on the back; assumed
    const auto mean_deg = [&](Sex one, double years) {
        const double(&means)[6] = MEANS_DEG[one == Sex::woman ? 1 : 0];
        const double at = std::clamp((years - FIRST_YEARS) / DECADE, 0.0, 5.0);
        const size_t i = std::min<size_t>(4, static_cast<size_t>(at));
        return std::lerp(means[i], means[i + 1], at - static_cast<double>(i));
    };
    return LYING * (mean_deg(sex, age_years) - mean_deg(Sex::man, 60.0));
}

SideDifference side_difference(std::uint32_t seed, size_t level)
{
    SideDifference left;
    if (level < T1) return left; // the neck is its own mirror image
    // The tips of many spinous processes lie aside even where the vertebra is not turned (PMID 2781411, CT of
    // 200 lumbar vertebrae). The amounts are assumed.
    Chance chance(seed, level);
    const double size = level < T12 ? 0.5 : 1.0; // the processes of the chest lie between the ribs
    left.pedicle_wider = chance.normal(0, 0.04);
    left.transverse_longer_mm = size * chance.normal(0, 1.2);
    left.transverse_higher_mm = size * chance.normal(0, 1.2);
    left.facet_turned_deg = size * chance.normal(0, 2.2);
    left.spinous_left_mm = size * chance.normal(0, 1.5);
    return left;
}

} // namespace anatomy
