#include "hil_tests/soak/draw.hpp"
#include "hil_tests/soak/plans.hpp"
#include "host/patient/stents.hpp"
#include <algorithm>
#include <stdexcept>

namespace soak
{

namespace
{

constexpr int begin_max_mm = 15;          // every shipped sheath is straight this far into its vessel
constexpr double injecting_bore_mm = 0.9; // a narrower bore belongs to a balloon catheter on a coronary wire
constexpr double guide_bore_mm = 1.5;
constexpr int statements_max = 200;

struct Cast {
    std::vector<const SoakTool *> tools;
    std::vector<const SoakStent *> stents;
    std::optional<std::size_t> balloon; // index into tools
};

// Chooses an instrument at random and then a random set that contains this instrument, so that all
// instruments occur about equally often. About three of ten random sessions have only one tool.
Cast draw_tools(const Catalogue &catalogue, const SoakScene &scene, Dice &dice)
{
    const bool is_treated = !scene.stations.empty(); // there is a lesion for a balloon
    const std::size_t count =
        1 + dice.weighted(is_treated ? std::vector<int>{10, 25, 65} : std::vector<int>{35, 40, 25});
    const bool wants_balloon = is_treated && dice.chance(70);
    std::vector<const std::vector<std::size_t> *> fitting;
    for (int attempt = 0; attempt < 100 && fitting.empty(); attempt++) {
        const std::size_t first = dice.below(catalogue.tools.size());
        if (wants_balloon && !catalogue.tools[first].has_balloon()) continue;
        for (const std::vector<std::size_t> &set : catalogue.sets)
            if (set.size() == count && std::find(set.begin(), set.end(), first) != set.end())
                fitting.push_back(&set);
    }
    const std::vector<std::size_t> &set = fitting.empty() ? dice.of(catalogue.sets) : *dice.of(fitting);
    Cast cast;
    for (std::size_t k : set) {
        if (catalogue.tools[k].has_balloon()) cast.balloon = cast.tools.size();
        cast.tools.push_back(&catalogue.tools[k]);
    }
    return cast;
}

void draw_stents(const Catalogue &catalogue, Cast &cast, Dice &dice)
{
    if (!cast.balloon || !dice.chance(50)) return;
    std::vector<crn::Instrument> tools;
    for (const SoakTool *tool : cast.tools) tools.push_back(tool->instrument);
    std::vector<const SoakStent *> fitting;
    for (const SoakStent &stent : catalogue.stents)
        if (crn::mount_refusal(stent.design, tools).empty()) fitting.push_back(&stent);
    if (fitting.empty()) return;
    for (int k = dice.between(1, 2); k > 0; k--) cast.stents.push_back(dice.of(fitting));
}

// --- single statements ---

void move_hands(Scribe &scribe)
{
    Dice &dice = scribe.dice();
    const std::size_t k = dice.below(scribe.tool_count());
    const int ahead_mm = scribe.depth_max_mm(k) - scribe.inserted_mm(k);
    const bool goes_in = ahead_mm > 0 && dice.chance(scribe.inserted_mm(k) < 60 ? 85 : 55);
    const int way_mm = goes_in ? dice.between(1, std::clamp(ahead_mm, 1, 250))
                               : -dice.between(1, std::clamp(scribe.inserted_mm(k), 1, 200));
    const int mm_s = scribe.some_speed_mm_s();
    switch (dice.weighted({40, 15, 15, 20, 10})) {
    case 0:
        scribe.push(k, way_mm, mm_s);
        break;
    case 1:
        scribe.push(k, way_mm, mm_s, dice.between(10, 80));
        break;
    case 2:
        scribe.push(k, way_mm, mm_s);
        scribe.turn(k, dice.between(-1440, 1440), scribe.some_turn_deg_s());
        break;
    case 3:
        scribe.turn(k, dice.between(-1080, 1080), scribe.some_turn_deg_s());
        break;
    default:
        scribe.push_together(goes_in ? std::min(way_mm, 60) : way_mm, mm_s);
        break;
    }
    scribe.end();
}

// Writes a statement that moves two hands at the same time, possibly in opposite directions.
void move_two_hands(Scribe &scribe)
{
    Dice &dice = scribe.dice();
    if (scribe.tool_count() < 2) return move_hands(scribe);
    const std::size_t a = dice.below(scribe.tool_count());
    const std::size_t b = (a + 1 + dice.below(scribe.tool_count() - 1)) % scribe.tool_count();
    const auto some_way_mm = [&](std::size_t k) {
        const int in_mm = std::clamp(scribe.depth_max_mm(k) - scribe.inserted_mm(k), 1, 150);
        return dice.chance(50) ? dice.between(1, in_mm)
                               : -dice.between(1, std::clamp(scribe.inserted_mm(k), 1, 150));
    };
    scribe.push(a, some_way_mm(a), scribe.some_speed_mm_s());
    if (dice.chance(60))
        scribe.push(b, some_way_mm(b), scribe.some_speed_mm_s());
    else
        scribe.turn(b, dice.between(-720, 720), scribe.some_turn_deg_s());
    scribe.end();
}

// Writes a statement that injects contrast medium through the lumen of a tool. The injected flow is at most
// what a hand or a pump can achieve while a wire is in the lumen.
void inject(Scribe &scribe)
{
    Dice &dice = scribe.dice();
    std::vector<std::size_t> open;
    for (std::size_t k = 0; k < scribe.tool_count(); k++)
        if (scribe.tool(k).tightest_mm >= injecting_bore_mm && !scribe.tool(k).has_balloon())
            open.push_back(k);
    if (open.empty() || scribe.scene().vessels.branches.empty())
        return scribe.wait_ms(dice.between(100, 500));
    const std::size_t k = dice.of(open);
    const int rate_max = scribe.tool(k).tightest_mm >= guide_bore_mm ? 5 : 2;
    if (dice.chance(25)) scribe.say("contrast " + std::to_string(dice.between(100, 350)) + " mg/ml");
    scribe.say("inject " + std::to_string(dice.between(1, 10)) + " ml at " +
               std::to_string(dice.between(1, rate_max)) + " ml/s through tool " + std::to_string(k + 1));
    if (dice.chance(10)) scribe.say("inject stop");
    scribe.wait_ms(dice.between(200, 2500));
}

void rhythm(Scribe &scribe)
{
    Dice &dice = scribe.dice();
    switch (dice.below(6)) {
    case 0:
        scribe.say("heart rate " + std::to_string(dice.between(40, 160)) + " /min");
        break;
    case 1:
        scribe.say("heart variability " + std::to_string(dice.between(0, 10)) + " %");
        break;
    case 2:
        scribe.say("premature beat at " + std::to_string(dice.between(40, 90)) + " %");
        break;
    case 3:
        scribe.say(dice.chance(50) ? "asystole on" : "asystole off");
        break;
    case 4:
        scribe.say("breath rate " + std::to_string(dice.between(10, 20)) + " /min");
        break;
    default:
        scribe.say(dice.chance(50) ? "breath hold on" : "breath hold off");
        break;
    }
}

void room(Scribe &scribe)
{
    Dice &dice = scribe.dice();
    const auto angle = [&](int most) { return std::to_string(dice.between(0, most)); };
    switch (dice.below(5)) {
    case 0:
        scribe.say(dice.chance(60) ? "fluoro on rate 7.5 p/s" : "fluoro off");
        break;
    case 1:
        scribe.say(std::string("c-arm ") + (dice.chance(50) ? "LAO " : "RAO ") + angle(90) +
                   (dice.chance(50) ? " CRA " : " CAU ") + angle(40));
        break;
    case 2:
        scribe.say(dice.chance(50) ? "follow tip" : "follow off");
        break;
    case 3:
        scribe.say("field " + std::to_string(dice.between(10, 45)) + " cm");
        break;
    default:
        scribe.say("collimate width " + std::to_string(dice.between(20, 100)) + " %");
        break;
    }
}

// --- whole sessions ---

void go_in(Scribe &scribe, const Cast &cast)
{
    Dice &dice = scribe.dice();
    const SoakScene &scene = scribe.scene();
    const bool is_heart = scene.has_branch("LAD");
    if (cast.tools.size() == 3 && is_heart && dice.chance(45)) return plan_coronary(scribe);
    if (cast.tools.size() == 2 && is_heart && dice.chance(35)) return plan_coronary_guide(scribe);
    if (cast.tools.size() == 3 && scene.has_branch("left_renal_artery") && dice.chance(40))
        return plan_renal(scribe);
    if (cast.tools.size() > 1 && dice.chance(60)) return plan_over_the_wire(scribe);
    if (dice.chance(50)) plan_deep(scribe);
}

void wander(Scribe &scribe, const Cast &cast, std::size_t &loads_left)
{
    Dice &dice = scribe.dice();
    switch (dice.weighted({52, 18, 6, 8, 8, 8, cast.balloon ? 25 : 0})) {
    case 0:
        return move_hands(scribe);
    case 1:
        return move_two_hands(scribe);
    case 2:
        return scribe.wait_ms(dice.between(50, 2000));
    case 3:
        return inject(scribe);
    case 4:
        return rhythm(scribe);
    case 5:
        return room(scribe);
    default:
        break;
    }
    const bool loads = loads_left > 0 && dice.chance(50);
    loads_left -= loads ? 1 : 0;
    plan_balloon(scribe, *cast.balloon, loads);
}

} // namespace

DrawnSession draw_session(const Catalogue &catalogue, std::uint64_t seed, std::uint32_t index,
                          const DrawSettings &settings)
{
    if (catalogue.scenes.empty() || catalogue.sets.empty())
        throw std::runtime_error("there is no scene or no instrument to draw sessions from");
    Dice dice(seed, index);
    const SoakScene &scene = dice.of(catalogue.scenes);
    Cast cast = draw_tools(catalogue, scene, dice);
    draw_stents(catalogue, cast, dice);
    Scribe scribe(scene, cast.tools, dice);
    int begin_mm = begin_max_mm + 4;
    for (std::size_t k = 0; k < cast.tools.size(); k++) {
        begin_mm = dice.chance(80) ? dice.between(1, std::max(begin_mm, 1)) : dice.between(1, begin_max_mm);
        scribe.begin(k, std::min(begin_mm, begin_max_mm));
    }
    go_in(scribe, cast);
    // If the script is to load the first stent, the balloon has no stent on it when the session begins.
    std::size_t loads_left = cast.stents.empty() || dice.chance(50) ? 0 : cast.stents.size();
    const int seconds = dice.between(settings.seconds_min, settings.seconds_max);
    for (int k = 0; scribe.seconds() < seconds && k < statements_max; k++) wander(scribe, cast, loads_left);

    DrawnSession session{seed, index, scene.path, {}, {}, scribe.take()};
    for (const SoakTool *tool : cast.tools) session.tools.push_back(tool->path);
    for (const SoakStent *stent : cast.stents) session.stents.push_back(stent->path);
    return session;
}

} // namespace soak
