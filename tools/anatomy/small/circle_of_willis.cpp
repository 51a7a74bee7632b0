#include "tools/anatomy/small/circle_of_willis.hpp"
#include "tools/anatomy/chance.hpp"
#include <algorithm>
#include <stdexcept>

namespace anatomy
{

namespace
{

constexpr const char *SIDES[2] = {"right", "left"};
constexpr double NARROW_MM = 0.8; // of a hypoplastic artery; below 1 mm by definition

Vessel &named_in(std::vector<Vessel> &arteries, const std::string &name)
{
    const auto found =
        std::find_if(arteries.begin(), arteries.end(), [&](const Vessel &one) { return one.name == name; });
    if (found == arteries.end())
        throw std::logic_error("the circle of Willis needs the artery '" + name + "'");
    return *found;
}

/* Divides an artery at one of its points. What lies beyond keeps its name, and begins at the end of `feeder`;
 * what lies before becomes a narrow artery of its own, which joins it. */
void feed_from(std::vector<Vessel> &arteries, const std::string &name, size_t point,
               const std::string &feeder, const std::string &narrow_name)
{
    Vessel &artery = named_in(arteries, name);
    Vessel stump = artery;
    stump.name = narrow_name;
    stump.joins = name;
    stump.flow_ml_min = 1.0;
    stump.winding = 1.0;
    stump.stations.resize(point + 1);
    for (Station &station : stump.stations) station.diameter_mm = NARROW_MM;
    const Vec3 end = named_in(arteries, feeder).stations.back().position_mm;
    artery.parent = feeder;
    artery.stations.erase(artery.stations.begin(),
                          artery.stations.begin() + static_cast<std::ptrdiff_t>(point));
    artery.stations.front().position_mm = end;
    arteries.push_back(stump);
}

void change_front(std::vector<Vessel> &arteries, CircleOfWillis::Front front)
{
    constexpr size_t END_OF_A1 = 2;
    const std::string joint = "anterior communicating artery";
    if (front == CircleOfWillis::Front::complete) return;
    if (front == CircleOfWillis::Front::without_communicating) {
        std::erase_if(arteries, [&](const Vessel &one) { return one.name == joint; });
        return;
    }
    const size_t narrow = front == CircleOfWillis::Front::right_narrow ? 0 : 1;
    const auto cerebral = [](size_t side) { return std::string(SIDES[side]) + " anterior cerebral artery"; };
    Vessel &bridge = named_in(arteries, joint);
    if (bridge.parent != cerebral(1 - narrow)) {
        std::reverse(bridge.stations.begin(), bridge.stations.end());
        bridge.parent = cerebral(1 - narrow);
    }
    bridge.flow_ml_min = 0.0; // it is continued
    bridge.joins.clear();
    for (Station &station : bridge.stations) station.diameter_mm = 2.0;
    feed_from(arteries, cerebral(narrow), END_OF_A1, joint, std::string(SIDES[narrow]) + " narrow A1");
}

void change_back(std::vector<Vessel> &arteries, size_t side, Communicating variant)
{
    constexpr size_t END_OF_P1 = 1;
    constexpr double FETAL_MM = 2.0;
    const std::string joint = std::string(SIDES[side]) + " posterior communicating";
    if (variant == Communicating::usual) return;
    if (variant == Communicating::absent) {
        std::erase_if(arteries, [&](const Vessel &one) { return one.name == joint; });
        return;
    }
    Vessel &bridge = named_in(arteries, joint);
    bridge.flow_ml_min = 0.0;
    bridge.joins.clear();
    for (Station &station : bridge.stations) station.diameter_mm = FETAL_MM;
    feed_from(arteries, std::string(SIDES[side]) + " posterior cerebral artery", END_OF_P1, joint,
              std::string(SIDES[side]) + " narrow P1");
}

/* Puts each artery behind its parent. Parents that are not in the list are vessels of the lumen. */
std::vector<Vessel> in_order(std::vector<Vessel> arteries)
{
    std::vector<Vessel> ordered;
    const auto waits = [&](const Vessel &one) {
        return std::any_of(arteries.begin(), arteries.end(),
                           [&](const Vessel &other) { return other.name == one.parent; });
    };
    while (!arteries.empty()) {
        const auto next = std::find_if_not(arteries.begin(), arteries.end(), waits);
        if (next == arteries.end()) throw std::logic_error("small arteries feed each other in a circle");
        ordered.push_back(*next);
        arteries.erase(next);
    }
    return ordered;
}

} // namespace

CircleOfWillis drawn_circle(std::uint64_t seed)
{
    // MRA of 300: complete in 17 %, the front in 77 %; so 22 % of the backs are complete if both are
    // independent. A fetal posterior cerebral artery: 15.9 % of 923. Where front or back are not complete,
    // the shares are assumed.
    constexpr double FRONT = 0.77, BACK = 0.17 / FRONT, FETAL = 0.159, BOTH = 0.2, NO_BRIDGE = 0.6;
    Chance chance(seed, 3000);
    CircleOfWillis circle;
    const double front = chance.uniform(0, 1), front_kind = chance.uniform(0, 1), back = chance.uniform(0, 1),
                 side = chance.uniform(0, 1), both = chance.uniform(0, 1);
    if (front > FRONT)
        circle.front = front_kind < NO_BRIDGE                 ? CircleOfWillis::Front::without_communicating
                       : front_kind < 0.5 * (1.0 + NO_BRIDGE) ? CircleOfWillis::Front::right_narrow
                                                              : CircleOfWillis::Front::left_narrow;
    if (back < BACK) return circle;
    const bool is_fetal = back < BACK + FETAL;
    const Communicating kind = is_fetal ? Communicating::fetal : Communicating::absent;
    const bool is_both = both < (is_fetal ? BOTH : 1.0 / 3.0);
    if (is_both || side < 0.5) circle.back[0] = kind;
    if (is_both || side >= 0.5) circle.back[1] = kind;
    return circle;
}

std::vector<Vessel> with_circle(std::vector<Vessel> arteries, const CircleOfWillis &circle)
{
    change_front(arteries, circle.front);
    for (size_t side = 0; side < 2; side++) change_back(arteries, side, circle.back[side]);
    return in_order(std::move(arteries));
}

} // namespace anatomy
