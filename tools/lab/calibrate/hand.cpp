#include "tools/lab/calibrate/hand.hpp"
#include "host/base/number_text.hpp"
#include <algorithm>
#include <cmath>
#include <limits>

namespace crn::calibrate
{
namespace
{

constexpr int turn_ticks = 200; // to turn the tip into its first plane before the hand feeds
constexpr double force_every_mm =
    0.1; // of travel, so that a slow stretch does not outweigh a fast one in a median
constexpr int still_in_a_row =
    2; // consecutive windows within the limit; a single one may be where a swing turns back
constexpr int sample_every =
    5; // ticks between samples of a rod at rest: odd, since a contact may occur in every second tick
constexpr double arrived_mm = 0.01, turn_step_deg = 0.5;

// One insertion in progress.
class Hand
{
  public:
    Hand(HeldRod &rod, const insertion::Case &c, const InsertionSettings &settings, Insertion &result)
        : rod_(rod), case_(c), settings_(settings), result_(result), hand_mm_(rod.inserted_mm())
    {
    }

    // Turns the hand to the angle that the case states for the first depth, without advancing the hand.
    void turn_first()
    {
        const double to_deg = case_.depths.front().turn_deg;
        const int ticks = std::max(turn_ticks, static_cast<int>(std::abs(to_deg) / turn_step_deg));
        for (int i = 1; i <= ticks; i++) tick(hand_mm_, to_deg * i / ticks);
    }

    void feed_to(double inserted_mm)
    {
        while (hand_mm_ < inserted_mm) {
            const bool is_near = inserted_mm - hand_mm_ <= settings_.approach_mm;
            const double speed_mm_per_s = is_near ? near_speed_mm_per_s() : settings_.speed_mm_per_s;
            hand_mm_ = std::min(inserted_mm, hand_mm_ + speed_mm_per_s * 1e-3);
            tick(hand_mm_, case_.turn_deg_at(hand_mm_));
        }
    }

    // We use mean positions at rest, because the tip may oscillate about its mean position.
    std::vector<Vector3d> rest()
    {
        const double still_mm = settings_.still_um_per_tick * settings_.rest_window_ticks * 1e-3;
        std::vector<Vector3d> before;
        int ticks = 0, still = 0;
        while (still < still_in_a_row && ticks < settings_.settle_max_ticks) {
            std::vector<Vector3d> mean = mean_over_window();
            ticks += settings_.rest_window_ticks;
            const bool is_still =
                hand_mm_ - rod_.inserted_mm() < arrived_mm && largest_way(before, mean) <= still_mm;
            still = is_still ? still + 1 : 0;
            before = std::move(mean);
        }
        if (still < still_in_a_row) result_.is_settled = false;
        result_.settle_ticks.push_back(ticks);
        return before.empty() ? rod_.nodes_mm() : before;
    }

  private:
    // Returns the speed at which the hand approaches a depth: the faster of the slow approach speed and the
    // case's speed, but at most the normal speed.
    double near_speed_mm_per_s() const
    {
        return std::min(settings_.speed_mm_per_s,
                        std::max(settings_.approach_mm_per_s, case_.speed_mm_per_s));
    }

    // Returns the mean position of each node over the next time interval. The returned list of positions is
    // empty if the number of nodes changes during the averaging, which happens while the rod still follows
    // the hand.
    std::vector<Vector3d> mean_over_window()
    {
        const double turn_deg = case_.turn_deg_at(hand_mm_);
        std::vector<Vector3d> sum;
        int samples = 0;
        bool is_one_set = true;
        for (int i = 1; i <= settings_.rest_window_ticks; i++) {
            tick(hand_mm_, turn_deg);
            if (i % sample_every != 0) continue;
            const std::vector<Vector3d> nodes = rod_.nodes_mm();
            if (sum.empty()) sum.assign(nodes.size(), Vector3d::Zero());
            is_one_set = is_one_set && nodes.size() == sum.size();
            for (std::size_t k = 0; is_one_set && k < nodes.size(); k++) sum[k] += nodes[k];
            samples++;
        }
        if (!is_one_set) return {};
        for (Vector3d &node : sum) node /= samples;
        return sum;
    }

    static double largest_way(const std::vector<Vector3d> &from, const std::vector<Vector3d> &to)
    {
        if (from.empty() || from.size() != to.size()) return std::numeric_limits<double>::infinity();
        double most = 0.0;
        for (std::size_t i = 0; i < to.size(); i++) most = std::max(most, (to[i] - from[i]).norm());
        return most;
    }

    void tick(double hand_mm, double turn_deg)
    {
        rod_.tick(hand_mm, turn_deg);
        if (!rod_.is_sound()) throw TrialRefused("the instrument left the vessel or the rod's number range");
        const double inserted_mm = rod_.inserted_mm();
        result_.ticks++;
        if (result_.force.empty() || inserted_mm >= result_.force.back().inserted_mm + force_every_mm)
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
    return "start " + number_text(start_mm, insertion::file_digits) + " speed " +
           number_text(speed_mm_per_s, insertion::file_digits) + " last " +
           number_text(approach_mm, insertion::file_digits) + " at " +
           number_text(approach_mm_per_s, insertion::file_digits) + " still " +
           number_text(still_um_per_tick, insertion::file_digits) + " over " +
           std::to_string(rest_window_ticks) + " at most " + std::to_string(settle_max_ticks) + " elements " +
           number_text(element_factor, insertion::file_digits);
}

Insertion insert_by_hand(HeldRod &rod, const insertion::Case &c, const InsertionSettings &settings,
                         std::size_t depth_count)
{
    Insertion result;
    Hand hand(rod, c, settings, result);
    hand.turn_first();
    for (std::size_t i = 0; i < depth_count && i < c.depths.size(); i++) {
        hand.feed_to(c.depths[i].inserted_mm);
        result.nodes_mm.push_back(hand.rest());
    }
    return result;
}

} // namespace crn::calibrate
