#include "tools/calibrate/hand.hpp"
#include <algorithm>
#include <cmath>

namespace seld::calibrate
{
namespace
{

constexpr int turn_ticks = 200; // to bring the tip into its first plane, before the hand feeds
constexpr int force_every = 4;  // ticks
constexpr double arrived_mm = 0.01, turn_step_deg = 0.5;

// One insertion under way.
class Hand
{
  public:
    Hand(HeldRod &rod, const insertion::Case &c, const InsertionSettings &settings, Insertion &result)
        : rod_(rod), case_(c), settings_(settings), result_(result), hand_mm_(rod.inserted_mm())
    {
    }

    // The tip comes into the plane of the first depth while the hand does not feed.
    void turn_first()
    {
        const double to_deg = case_.depths.front().turn_deg;
        const int ticks = std::max(turn_ticks, static_cast<int>(std::abs(to_deg) / turn_step_deg));
        for (int i = 1; i <= ticks; i++) tick(hand_mm_, to_deg * i / ticks);
    }

    void feed_to(double inserted_mm)
    {
        while (hand_mm_ < inserted_mm) {
            hand_mm_ = std::min(inserted_mm, hand_mm_ + settings_.speed_mm_per_s * 1e-3);
            tick(hand_mm_, case_.turn_deg_at(hand_mm_));
        }
    }

    // Until no node moves.
    void rest()
    {
        const double turn_deg = case_.turn_deg_at(hand_mm_);
        int still = 0, ticks = 0;
        while (still < settings_.still_ticks && ticks < settings_.settle_max_ticks) {
            tick(hand_mm_, turn_deg);
            ticks++;
            const bool is_still =
                rod_.motion_um() <= settings_.still_um_per_tick && hand_mm_ - rod_.inserted_mm() < arrived_mm;
            still = is_still ? still + 1 : 0;
        }
        if (still < settings_.still_ticks) result_.is_settled = false;
        result_.settle_ticks.push_back(ticks);
    }

  private:
    void tick(double hand_mm, double turn_deg)
    {
        rod_.tick(hand_mm, turn_deg);
        if (!rod_.is_sound()) throw TrialRefused("the instrument left the vessel or the rod's number range");
        const double inserted_mm = rod_.inserted_mm();
        const bool is_new = result_.force.empty() || inserted_mm > result_.force.back().inserted_mm;
        if (result_.ticks++ % force_every == 0 && is_new)
            result_.force.push_back({inserted_mm, rod_.handle_axial_mN()});
    }

    HeldRod &rod_;
    const insertion::Case &case_;
    const InsertionSettings &settings_;
    Insertion &result_;
    double hand_mm_;
};

} // namespace

std::string InsertionSettings::text() const
{
    const auto number = insertion::number_text;
    return "start " + number(start_mm) + " speed " + number(speed_mm_per_s) + " still " +
           number(still_um_per_tick) + " for " + std::to_string(still_ticks) + " at most " +
           std::to_string(settle_max_ticks) + " elements " + number(element_factor);
}

Insertion insert_by_hand(HeldRod &rod, const insertion::Case &c, const InsertionSettings &settings,
                         std::size_t depth_count)
{
    Insertion result;
    Hand hand(rod, c, settings, result);
    hand.turn_first();
    for (std::size_t i = 0; i < depth_count && i < c.depths.size(); i++) {
        hand.feed_to(c.depths[i].inserted_mm);
        hand.rest();
        result.nodes_mm.push_back(rod.nodes_mm());
    }
    return result;
}

} // namespace seld::calibrate
