#include "tools/anatomy/small/brain.hpp"
#include "tools/anatomy/chance.hpp"
#include "tools/anatomy/small/twigs.hpp"
#include <algorithm>
#include <cmath>

namespace anatomy
{

namespace
{

/* The brain fills the hollow of the skull (skeleton/head.cpp) but for 3 mm. */
const Vec3 BRAIN(0, 490, -20), BRAIN_HALF_MM(61, 58.5, 82);

/* A depth is measured along the ray from the middle of the brain. */
Vec3 at_depth(const Vec3 &near, double depth_mm)
{
    const Vec3 from_middle = near - BRAIN, way = from_middle.normalized();
    const double surface_mm = 1.0 / way.cwiseQuotient(BRAIN_HALF_MM).norm();
    return BRAIN + (surface_mm - depth_mm) * way;
}

/* Above the floor of the skull in front, and above the cerebellum behind. */
bool is_in_cerebrum(const Vec3 &at)
{
    return at.y() > (at.z() > -30.0 ? 452.0 : 464.0) && std::abs(at.x()) > 4.0;
}

/* Returns places over one half of the brain, about evenly spread. */
std::vector<TissuePlace> scattered(double side, int layer, std::uint64_t seed)
{
    constexpr double APART_MM = 8.0, DEPTH_LEAST_MM = 1.0, DEPTH_MOST_MM = 9.0;
    constexpr int TRIES = 12000;
    Chance chance(seed, 5000 + static_cast<std::uint64_t>(layer));
    std::vector<TissuePlace> places;
    for (int i = 0; i < TRIES; i++) {
        const Vec3 way(side * chance.uniform(0, 1), chance.uniform(-1, 1), chance.uniform(-1, 1));
        const double depth_mm = chance.uniform(DEPTH_LEAST_MM, DEPTH_MOST_MM);
        if (way.norm() > 1.0 || way.norm() < 0.1) continue; // evenly over all directions
        const Vec3 at = at_depth(BRAIN + way.cwiseProduct(BRAIN_HALF_MM), depth_mm);
        const bool is_free = std::none_of(places.begin(), places.end(), [&](const TissuePlace &other) {
            return (other.at - at).norm() < APART_MM;
        });
        if (is_in_cerebrum(at) && is_free) places.push_back({at, depth_mm, layer});
    }
    return places;
}

/* Names such as "right anterior division" occur in the pelvis, too. */
bool is_in_head(const VesselTree &tree, const Vessel &artery)
{
    for (const Vessel *one = &artery; one; one = named(tree.small, one->parent))
        if (one->name == "basilar artery" || one->name.ends_with("internal carotid artery")) return true;
    return false;
}

/* Those that run over the brain; the short arteries of the circle feed nothing here. */
bool feeds_brain(const Vessel &artery)
{
    for (const char *part : {"division", "frontal branch", "parietal", "temporal branch", "callosomarginal",
                             "frontopolar", "anterior cerebral artery", "posterior cerebral artery"})
        if (artery.name.find(part) != std::string::npos) return true;
    return false;
}

} // namespace

std::vector<SmallVessel> brain_arteries(const VesselTree &tree)
{
    constexpr double STEP_MM = 4.0, FIRST_MM = 30.0; // over A1 and P1, which give off only deep branches
    const std::uint64_t seed = tree.seed.value_or(0);
    std::vector<Vessel> stems;
    std::copy_if(tree.small.begin(), tree.small.end(), std::back_inserter(stems),
                 [&](const Vessel &artery) { return feeds_brain(artery) && is_in_head(tree, artery); });
    std::vector<SmallVessel> vessels;
    if (stems.empty()) return vessels;
    Growth growth(
        [](const TissuePlace &place) {
            return TissuePlace{at_depth(place.at, place.depth_mm), place.depth_mm, place.layer};
        },
        {.exponent = 3.0, .end_radius_mm = 0.16, .step_mm = 4.0, .reach_mm = 60.0});
    for (const Vessel &stem : stems) {
        const bool is_cerebral = stem.name.ends_with("cerebral artery");
        std::vector<TissuePlace> places;
        std::vector<double> radii_mm;
        for (const CurvePoint &point : vessel_curve(stem, STEP_MM)) {
            if (is_cerebral && point.arc_mm < FIRST_MM) continue;
            places.push_back({point.position_mm, 5.0, point.position_mm.x() < 0 ? 0 : 1});
            radii_mm.push_back(point.radius_mm);
        }
        if (places.size() > 1) growth.add_stem(stem.name, places, radii_mm);
    }
    std::vector<TissuePlace> right = scattered(-1.0, 0, seed), left = scattered(1.0, 1, seed);
    for (const std::vector<TissuePlace> &half : {right, left})
        for (const TissuePlace &end : half) growth.grow_to(end);
    add_twigs(growth, stems, Bed::body, vessels);
    return vessels;
}

} // namespace anatomy
