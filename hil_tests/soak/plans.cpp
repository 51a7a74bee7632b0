#include "hil_tests/soak/plans.hpp"
#include "hil_tests/soak/draw.hpp"
#include <algorithm>

namespace soak
{

namespace
{

constexpr int bar_kPa = 100;

// Holds one step of a route (plan), in which wire, catheter and guiding catheter move at the same time to the
// stated depths. A depth of -1 means that the tool does not move in this step.
struct Step {
    int wire_mm, catheter_mm, guide_mm;
    int mm_s;
    int off_mm = 10; // either way
};

void walk(Scribe &scribe, const Step &step, double hurry)
{
    const int target_mm[] = {step.wire_mm, step.catheter_mm, step.guide_mm};
    const int mm_s = std::clamp(static_cast<int>(step.mm_s * hurry), 1, speed_max_mm_s);
    bool moves = false;
    for (std::size_t k = 0; k < scribe.tool_count(); k++) {
        if (target_mm[k] < 0) continue;
        const int off_mm = scribe.dice().between(-step.off_mm, step.off_mm);
        scribe.push_until(k, std::clamp(target_mm[k] + off_mm, 1, scribe.depth_max_mm(k)), mm_s);
        moves = true;
    }
    if (moves) scribe.end();
}

// Returns a random factor between 1 and 3, by which the hands move faster than in the shipped session.
double some_hurry(Scribe &scribe)
{
    return scribe.dice().between(10, 30) * 0.1;
}

void turn_by_about(Scribe &scribe, std::size_t k, int deg)
{
    scribe.turn(k, deg + scribe.dice().between(-60, 60), scribe.some_turn_deg_s());
    scribe.end();
}

// Returns the burst pressure of a balloon and the rated pressure on its label; both are rounded down to whole
// bar.
int burst_bar(const SoakTool &tool)
{
    return tool.instrument.balloon ? static_cast<int>(tool.instrument.balloon->rated_burst_kPa / bar_kPa)
                                   : 10;
}

int some_bar(Scribe &scribe, const SoakTool &tool)
{
    const int rated = burst_bar(tool);
    if (scribe.dice().chance(6)) return std::min(rated * 2, 40); // it bursts
    return scribe.dice().between(1, rated);
}

void move_while_inflated(Scribe &scribe, std::size_t balloon)
{
    Dice &dice = scribe.dice();
    const std::size_t k = dice.chance(50) ? balloon : dice.below(scribe.tool_count());
    switch (dice.weighted({30, 30, 20, 20})) {
    case 0:
        scribe.push(k, dice.between(1, 30), dice.between(1, 60));
        break;
    case 1:
        scribe.push(k, -dice.between(1, 30), dice.between(1, 60));
        break;
    case 2:
        scribe.turn(k, dice.between(-360, 360), scribe.some_turn_deg_s());
        break;
    default:
        scribe.wait_ms(dice.between(100, 2000));
        return;
    }
    scribe.end();
}

} // namespace

void plan_deep(Scribe &scribe)
{
    const int depth_mm = scribe.depth_max_mm(0);
    scribe.push_until(0, scribe.dice().between(depth_mm / 3, depth_mm),
                      scribe.dice().between(60, speed_max_mm_s));
    scribe.end();
}

void plan_over_the_wire(Scribe &scribe)
{
    Dice &dice = scribe.dice();
    const int legs = dice.between(1, 4);
    const int goal_mm = dice.between(scribe.depth_max_mm(0) / 4, scribe.depth_max_mm(0));
    for (int leg = 1; leg <= legs; leg++) {
        int mm = goal_mm * leg / legs;
        for (std::size_t k = 0; k < scribe.tool_count(); k++) {
            scribe.push_until(k, std::clamp(mm, 1, scribe.depth_max_mm(k)),
                              std::max(30, scribe.some_speed_mm_s()));
            scribe.end();
            mm = std::max(mm - dice.between(5, 120), 5);
        }
    }
}

void plan_coronary(Scribe &scribe)
{
    const double hurry = some_hurry(scribe);
    turn_by_about(scribe, 0, 45);
    walk(scribe, {620, 590, -1, 80}, hurry);
    walk(scribe, {-1, -1, 560, 60}, hurry);
    walk(scribe, {760, 740, -1, 60}, hurry);
    walk(scribe, {-1, -1, 740, 60}, hurry);
    walk(scribe, {620, 620, -1, 100}, hurry);
    walk(scribe, {-1, -1, 890, 40, 20}, hurry);
    walk(scribe, {880, -1, -1, 120}, hurry);
    turn_by_about(scribe, 0, 225);
    walk(scribe, {980, -1, -1, 25, 25}, hurry);
    walk(scribe, {-1, 880, -1, 100}, hurry);
    walk(scribe, {-1, 945, -1, 25, 20}, hurry);
}

void plan_coronary_guide(Scribe &scribe)
{
    const double hurry = some_hurry(scribe);
    walk(scribe, {560, -1, -1, 70}, hurry);
    walk(scribe, {740, -1, -1, 55, 30}, hurry);
    walk(scribe, {-1, 640, -1, 100}, hurry);
    walk(scribe, {-1, 740, -1, 60}, hurry);
    walk(scribe, {420, -1, -1, 100}, hurry);
    walk(scribe, {-1, 850, -1, 40, 45}, hurry);
}

void plan_renal(Scribe &scribe)
{
    const double hurry = some_hurry(scribe);
    walk(scribe, {100, -1, -1, 60}, hurry);
    walk(scribe, {370, 300, -1, 60}, hurry);
    walk(scribe, {-1, -1, 330, 60}, hurry);
    walk(scribe, {270, 230, -1, 100}, hurry);
    turn_by_about(scribe, 2, 110);
    walk(scribe, {-1, -1, 310, 8, 5}, hurry);
    walk(scribe, {300, -1, -1, 60}, hurry);
    walk(scribe, {350, -1, -1, 12}, hurry);
    walk(scribe, {-1, 331, -1, 30, 6}, hurry);
    walk(scribe, {-1, -1, 298, 20, 6}, hurry);
}

void plan_balloon(Scribe &scribe, std::size_t balloon, bool load)
{
    Dice &dice = scribe.dice();
    const SoakTool &tool = scribe.tool(balloon);
    if (load) {
        const int back_mm = scribe.inserted_mm(balloon);
        scribe.push_until(balloon, 3, speed_max_mm_s);
        scribe.end();
        scribe.say("load stent");
        scribe.push_until(balloon, std::max(back_mm, 4), std::max(60, scribe.some_speed_mm_s()));
        scribe.end();
    } else if (dice.chance(60)) {
        // The balloon moves along the wire; in some sessions the balloon is filled while it is still in its
        // sheath.
        const int most_mm = std::max(scribe.inserted_mm(0), 20);
        scribe.push_until(balloon, std::clamp(dice.between(5, most_mm), 1, scribe.depth_max_mm(balloon)),
                          std::max(20, scribe.some_speed_mm_s()));
        scribe.end();
    }
    scribe.inflate(some_bar(scribe, tool), dice.between(1, 20));
    for (int k = dice.between(0, 4); k > 0; k--) move_while_inflated(scribe, balloon);
    if (dice.chance(25)) {
        scribe.inflate(some_bar(scribe, tool), dice.between(1, 10));
        move_while_inflated(scribe, balloon);
    }
    if (dice.chance(90)) scribe.inflate(0, dice.between(2, 20));
}

} // namespace soak
