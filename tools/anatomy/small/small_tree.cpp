#include "tools/anatomy/small/small_tree.hpp"
#include "host/base/format.hpp"
#include "host/base/number_text.hpp"
#include "tools/anatomy/chance.hpp"
#include "tools/anatomy/organs.hpp"
#include "tools/anatomy/output.hpp"
#include "tools/anatomy/small/brain.hpp"
#include "tools/anatomy/small/heart_tissue.hpp"
#include "tools/anatomy/small/twigs.hpp"
#include "tools/anatomy/small/veins.hpp"
#include <algorithm>
#include <map>
#include <optional>

namespace anatomy
{

namespace
{

constexpr std::uint64_t SEED = 1;

// --- the heart ---

struct Stem {
    std::vector<TissuePlace> places;
    std::vector<double> radii_mm;
};

Stem stem_on_heart(const Vessel &artery, const HeartTissue &heart)
{
    constexpr double STEP_MM = 3.0, LIFT_MM = -0.5, TOP = 1.03;
    Stem stem;
    for (const CurvePoint &point : vessel_curve(artery, STEP_MM)) {
        if (heart.height(point.position_mm) > TOP) continue;
        stem.places.push_back({point.position_mm, LIFT_MM, OUTER_LAYER});
        stem.radii_mm.push_back(point.radius_mm);
    }
    return stem;
}

/* Beyond the end of an artery, a small one goes on in the same direction. */
std::vector<TissuePlace> tail_of(const Stem &stem, const HeartTissue &heart)
{
    constexpr double STEP_MM = 5.0, APEX_HEIGHT = 0.08;
    constexpr int STEPS = 4;
    std::vector<TissuePlace> places = {stem.places.back()};
    const double height = heart.height(places[0].at), angle = heart.angle_deg(places[0].at);
    if (height < APEX_HEIGHT) { // round the apex to the lower side
        for (const double on : {0.02, 0.06, 0.12})
            places.push_back(heart.place(height + on, angle - 600.0 * on, 0.8, OUTER_LAYER));
        return places;
    }
    const size_t before = stem.places.size() - std::min<size_t>(stem.places.size(), 4);
    const Vec3 way = (places[0].at - stem.places[before].at).normalized();
    for (int i = 0; i < STEPS; i++) {
        const TissuePlace next = heart.onto({places.back().at + STEP_MM * way, 0.5 + 0.5 * i, OUTER_LAYER});
        if (heart.height(next.at) < 0.03 || (next.at - places.back().at).norm() < 0.5 * STEP_MM) break;
        places.push_back(next);
    }
    return places;
}

/* Septal arteries leave the LAD at right angles and run in the middle of the septum. The first one leaves 10
 * to 25 mm behind the left main artery; 8 to 13 are usual. */
void add_septals(Growth &growth, const Stem &lad, const HeartTissue &heart)
{
    constexpr double FIRST_MM = 14.0, APART_MM = 8.5, DEPTH_MM = 5.0;
    constexpr int MOST = 10;
    double arc_mm = 0.0, next_mm = FIRST_MM;
    int count = 0;
    for (size_t i = 1; i < lad.places.size() && count < MOST; i++) {
        arc_mm += (lad.places[i].at - lad.places[i - 1].at).norm();
        const double height = heart.height(lad.places[i].at);
        if (arc_mm < next_mm || height < 0.12) continue;
        next_mm += APART_MM;
        count++;
        std::vector<TissuePlace> places = {lad.places[i]};
        const double angle = heart.angle_deg(lad.places[i].at);
        const double reach_deg = count == 1 ? 75.0 : count < 4 ? 65.0 : 50.0;
        for (const double share : {0.12, 0.4, 0.7, 1.0})
            places.push_back(
                heart.place(height - 0.05 * share, angle - share * reach_deg, DEPTH_MM, SEPTUM_LAYER));
        growth.add_trunk(places);
    }
}

bool feeds_muscle(const Vessel &artery)
{
    return artery.name != "LM";
}

/* Grows the arteries of the heart below the coronary arteries of the tree. */
std::vector<SmallVessel> grown_heart_arteries(const VesselTree &tree, const HeartTissue &heart)
{
    constexpr double APART_MM = 4.0, CLOSED_MM = 18.0;
    constexpr unsigned TRIES = 14000;
    Growth growth([&](const TissuePlace &place) { return heart.onto(place); }, {});
    std::vector<Vessel> stems = coronary_arteries(tree);
    std::erase_if(stems, [](const Vessel &artery) { return !feeds_muscle(artery); });
    for (const Vessel &artery : stems) {
        const Stem stem = stem_on_heart(artery, heart);
        if (stem.places.size() < 2) continue;
        const bool ends_here = std::none_of(stems.begin(), stems.end(), [&](const Vessel &other) {
            return other.parent == artery.name &&
                   (other.stations.front().position_mm - artery.stations.back().position_mm).norm() < 1.0;
        });
        growth.add_stem(artery.name, stem.places, stem.radii_mm, ends_here ? CLOSED_MM : 0.0);
        if (artery.name == "LAD") add_septals(growth, stem, heart);
        if (ends_here) growth.add_trunk(tail_of(stem, heart));
    }
    for (const TissuePlace &end : heart.scattered(APART_MM, TRIES, SEED)) growth.grow_to(end);
    std::vector<SmallVessel> vessels;
    add_twigs(growth, stems, Bed::body, vessels);
    return vessels;
}

/* Grows interlobar and arcuate arteries from the end of a renal artery to the border of cortex and medulla.
 */
void grow_kidney(const Vessel &artery, std::uint64_t seed, std::vector<SmallVessel> &vessels)
{
    constexpr double STEM_MM = 5.0, APART_MM = 5.5, ARCUATE_MM = 4.5, OUTSIDE_MM = 9.0, CLOSE_MM = 95.0;
    constexpr int TRIES = 30000;
    static const Solid organ = kidneys();
    Growth growth([](const TissuePlace &place) { return place; },
                  {.exponent = 3.0, .end_radius_mm = 0.18, .step_mm = 4.0, .reach_mm = CLOSE_MM});
    const Curve curve = vessel_curve(artery, 2.0);
    std::vector<TissuePlace> places;
    std::vector<double> radii_mm;
    for (const CurvePoint &point : curve)
        if (point.arc_mm > curve.back().arc_mm - STEM_MM) {
            places.push_back({point.position_mm});
            radii_mm.push_back(point.radius_mm);
        }
    growth.add_stem(artery.name, places, radii_mm);
    Chance chance(seed, 0);
    std::vector<Vec3> taken;
    const Vec3 size = organ.bounds.high - organ.bounds.low;
    const double side = artery.stations.back().position_mm.x() > 0 ? 1.0 : -1.0;
    for (int i = 0; i < TRIES; i++) {
        const Vec3 at(organ.bounds.low.x() + chance.uniform(0, 1) * size.x(),
                      organ.bounds.low.y() + chance.uniform(0, 1) * size.y(),
                      organ.bounds.low.z() + chance.uniform(0, 1) * size.z());
        const double depth = -organ.distance(at);
        if (side * at.x() < 0 || depth < ARCUATE_MM || depth > OUTSIDE_MM) continue;
        if (std::any_of(taken.begin(), taken.end(),
                        [&](const Vec3 &other) { return (other - at).norm() < APART_MM; }))
            continue;
        taken.push_back(at);
        growth.grow_to({at});
    }
    add_twigs(growth, {artery}, Bed::kidney, vessels);
}

std::vector<SmallVessel> given_vessels(const VesselTree &tree)
{
    constexpr double STEP_MM = 5.0;
    std::vector<SmallVessel> vessels;
    for (const Vessel &vessel : tree.small)
        vessels.push_back({file_stem(vessel.name), file_stem(vessel.parent), vessel.bed, false,
                           vessel.flow_ml_min * 1e3 / 60.0, vessel_curve(vessel, STEP_MM),
                           vessel.joins.empty() ? "" : file_stem(vessel.joins)});
    return vessels;
}

const char *bed_name(Bed bed)
{
    switch (bed) {
    case Bed::left_coronary:
        return "left_coronary";
    case Bed::right_coronary:
        return "right_coronary";
    case Bed::kidney:
        return "kidney";
    case Bed::gut:
        return "gut";
    case Bed::body:
        break;
    }
    return "systemic";
}

/* What lies behind the vessel's end: tissue, or another artery. */
std::string bed_text(const SmallVessel &vessel)
{
    if (!vessel.joins.empty()) return "into " + vessel.joins;
    return std::string(bed_name(vessel.bed)) + (vessel.is_vein ? "_vein" : "");
}

} // namespace

std::vector<SmallVessel> small_vessels_of(const VesselTree &tree)
{
    std::vector<SmallVessel> vessels = given_vessels(tree);
    if (!tree.is_in_patient) return vessels;
    std::optional<HeartTissue> heart;
    if (tree.coronary_count > 0) append(grown_heart_arteries(tree, heart.emplace()), vessels);
    for (const char *name : {"right renal artery", "left renal artery"}) {
        std::vector<SmallVessel> grown;
        if (const Vessel *artery = named(tree.vessels, name)) grow_kidney(*artery, SEED, grown);
        append(grown, vessels);
    }
    append(brain_arteries(tree), vessels);
    if (heart) append(coronary_veins(*heart), vessels);
    append(renal_veins(), vessels);
    return vessels;
}

std::vector<Curve> wide_arteries(const VesselTree &tree, const std::vector<SmallVessel> &vessels,
                                 double diameter_mm)
{
    constexpr double OFF_MM = 1.0; // a branch may begin a little beside its parent's course
    std::map<std::string, Curve> courses;
    for (const Vessel &vessel : tree.vessels) courses[file_stem(vessel.name)] = vessel_curve(vessel, 1.0);
    std::vector<Curve> wide;
    for (const SmallVessel &vessel : vessels) {
        const auto parent = courses.find(file_stem(vessel.parent));
        if (vessel.is_vein || parent == courses.end()) continue;
        const auto end =
            std::find_if(vessel.points.begin(), vessel.points.end(),
                         [&](const CurvePoint &point) { return 2.0 * point.radius_mm < diameter_mm; });
        const Curve curve(vessel.points.begin(), end);
        if (curve.size() < 2) continue;
        if (std::none_of(parent->second.begin(), parent->second.end(), [&](const CurvePoint &point) {
                return (point.position_mm - curve.front().position_mm).norm() < point.radius_mm + OFF_MM;
            }))
            continue;
        courses[file_stem(vessel.name)] = curve;
        wide.push_back(curve);
    }
    return wide;
}

std::string small_vessels_text(const std::vector<SmallVessel> &vessels)
{
    std::string text = "vessel,parent,bed,flow_ul_s,x_mm,y_mm,z_mm,radius_mm\n";
    for (const SmallVessel &vessel : vessels)
        for (size_t i = 0; i < vessel.points.size(); i++) {
            const CurvePoint &point = vessel.points[i];
            text += vessel.name;
            text += i == 0 ? "," + vessel.parent + "," + bed_text(vessel) + "," +
                                 crn::decimals_text(vessel.flow_ul_s, 3)
                           : ",,,";
            for (int axis = 0; axis < 3; axis++) text += "," + crn::decimals_text(point.position_mm[axis], 3);
            text += "," + crn::decimals_text(point.radius_mm, 3) + "\n";
        }
    return text;
}

} // namespace anatomy
