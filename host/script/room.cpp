#include "host/script/room.hpp"
#include "host/base/format.hpp"
#include "host/room/presets.hpp"
#include <algorithm>
#include <iterator>

namespace crn
{
namespace
{

const std::vector<Unit> frame_rate_units = {{"p/s", 1.0}, {"f/s", 1.0}, {"/s", 1.0}};
const std::vector<Unit> share_units = {{"%", 0.01}};
const std::vector<Unit> volume_units = {{"ml", 1.0}};
const std::vector<Unit> flow_units = {{"ml/s", 1.0}, {"ml/min", 1.0 / 60.0}};
const std::vector<Unit> strength_units = {{"mg/ml", 1.0}};
const std::vector<Unit> pixel_units = {{"px", 1.0}, {"pixels", 1.0}};

std::int32_t nearest(double value)
{
    return static_cast<std::int32_t>(std::lround(value));
}

std::int32_t um_between(LineParser &line, const std::string &what, std::int32_t low_um, std::int32_t high_um)
{
    // The limits of a statement's numbers are divided by 1e6, not multiplied by 1e-6: 450000 * 1e-6 is
    // slightly less than 0.45, so that "45 cm" would be out of range.
    return nearest(line.quantity(what, length_units, low_um / 1e6, high_um / 1e6) * 1e6);
}

// Reads a rate and returns it in hundredths per second; the rate must be a member of the list `rates`.
template <std::size_t count> std::int32_t rate(LineParser &line, const std::int32_t (&rates)[count])
{
    const LineParser before = line;
    const std::int32_t asked = nearest(line.quantity("rate", frame_rate_units, 0.0, 1000.0) * 100.0);
    if (std::find(std::begin(rates), std::end(rates), asked) != std::end(rates)) return asked;
    std::string known;
    for (std::int32_t one : rates) {
        known += formatted("%s%g", known.empty() ? "" : ", ", one * 0.01);
    }
    before.fail("no such rate; there are " + known + " per second");
}

// Reads the number of a frame or of a run; these numbers count from 1.
std::int32_t ordinal(LineParser &line, const std::string &what)
{
    const LineParser before = line;
    const double value = line.number("number of a " + what);
    if (value != std::floor(value) || value < 1.0 || value > 1e6)
        before.fail("a " + what + " is 1, 2, 3 ...");
    return static_cast<std::int32_t>(value);
}

} // namespace

const std::vector<std::string> &room_verbs()
{
    static const std::vector<std::string> verbs = {
        "fluoro",      "cine",   "dsa",    "c-arm",    "view",    "table",    "field",
        "collimate",   "follow", "mask",   "shift",    "roadmap", "review",   "store",
        "acknowledge", "stop",   "inject", "contrast", "load",    "aspirate", "complications"};
    return verbs;
}

void RoomParser::add(RoomAction action, std::int32_t a, std::int32_t b, std::int32_t c)
{
    commands_.push_back({action, {a, b, c}});
}

std::vector<RoomCommand> RoomParser::parse(LineParser &line, const std::string &verb)
{
    commands_.clear();
    if (verb == "fluoro" || verb == "cine" || verb == "dsa") {
        pedal(line, verb);
    } else if (verb == "c-arm") {
        c_arm(line);
    } else if (verb == "view") {
        preset(line);
    } else if (verb == "table") {
        table(line);
    } else if (verb == "field") {
        add(RoomAction::field, um_between(line, "field", field_min_um, field_max_um));
    } else if (verb == "collimate") {
        blades(line);
    } else if (verb == "follow") {
        add(RoomAction::follow, line.choice("thing to follow", {"tip", "off"}) == "tip" ? 1 : 0);
    } else if (verb == "mask") {
        mask(line);
    } else if (verb == "shift") {
        shift(line);
    } else if (verb == "roadmap") {
        roadmap(line);
    } else if (verb == "review") {
        review(line);
    } else if (verb == "store") {
        line.accept("fluoro");
        const double seconds =
            line.is_at_end() ? 10.0
                             : line.quantity("time", time_units, store_min_ms * 1e-3, store_max_ms * 1e-3);
        add(RoomAction::store, nearest(seconds * 1e3));
    } else if (verb == "aspirate") {
        add(RoomAction::aspirate,
            nearest(line.quantity("volume", volume_units, 0.1, aspirate_max_ul * 1e-3) * 1e3));
    } else if (verb == "inject") {
        inject(line);
    } else if (verb == "contrast") {
        add(RoomAction::contrast_strength,
            nearest(line.quantity("strength", strength_units, strength_min_mg_ml, strength_max_mg_ml)));
    } else if (verb == "complications") {
        add(RoomAction::complications, line.choice("switch", {"on", "off"}) == "on" ? 1 : 0);
    } else if (verb == "load") {
        line.expect("stent");
        add(RoomAction::load_stent);
    } else if (verb == "acknowledge") {
        line.accept("dose");
        add(RoomAction::acknowledge);
    } else {
        add(RoomAction::halt);
    }
    return commands_;
}

// Reads statements such as "fluoro on", "cine off", "dsa rate 3 f/s", "fluoro on rate 7.5 p/s".
void RoomParser::pedal(LineParser &line, const std::string &verb)
{
    do {
        const std::string what = line.choice("switch", {"on", "off", "rate"});
        if (what == "rate") {
            if (verb == "fluoro") add(RoomAction::fluoro_rate, rate(line, fluoro_rates_centihertz));
            if (verb == "cine") add(RoomAction::cine_rate, rate(line, cine_rates_centihertz));
            if (verb == "dsa") add(RoomAction::dsa_rate, rate(line, dsa_rates_centihertz));
            continue;
        }
        if (verb == "fluoro") {
            add(RoomAction::fluoro_pedal, what == "on" ? 1 : 0);
            continue;
        }
        if (what == "on") add(RoomAction::program, verb == "dsa" ? 1 : 0);
        add(RoomAction::acquire_pedal, what == "on" ? 1 : 0);
    } while (!line.is_at_end());
    // A rate applies to the pedal press on the same line of the script, so commands for rates are returned
    // before commands for pedals.
    std::stable_sort(commands_.begin(), commands_.end(), [](const RoomCommand &a, const RoomCommand &b) {
        const auto is_pedal = [](RoomAction action) {
            return action == RoomAction::fluoro_pedal || action == RoomAction::acquire_pedal;
        };
        return !is_pedal(a.action) && is_pedal(b.action);
    });
}

void RoomParser::c_arm(LineParser &line)
{
    bool has_angles = false, has_distances = false;
    do {
        const std::string word =
            line.choice("direction of the C-arm", {"LAO", "RAO", "CRA", "CAU", "AP", "SID", "SOD"});
        if (word == "SID" || word == "SOD") {
            has_distances = true;
            if (word == "SID") sid_um_ = um_between(line, "SID", sid_min_um, sid_max_um);
            if (word == "SOD") sod_um_ = um_between(line, "SOD", sod_min_um, sod_max_um);
            continue;
        }
        has_angles = true;
        if (word == "AP") {
            primary_mdeg_ = secondary_mdeg_ = 0;
            continue;
        }
        const bool is_primary = word == "LAO" || word == "RAO";
        const std::int32_t limit_mdeg = is_primary ? primary_max_mdeg : secondary_max_mdeg;
        const double angle = line.number("angle in degrees");
        line.accept("deg");
        if (!(std::fabs(angle) * 1e3 <= limit_mdeg))
            line.fail("the angle is outside +-" + std::to_string(limit_mdeg / 1000) + " deg");
        const double sign = word == "LAO" || word == "CRA" ? 1.0 : -1.0;
        (is_primary ? primary_mdeg_ : secondary_mdeg_) = nearest(sign * angle * 1e3);
    } while (!line.is_at_end());
    if (has_distances) add(RoomAction::distance, sid_um_, sod_um_);
    if (has_angles) add(RoomAction::angles, primary_mdeg_, secondary_mdeg_);
}

void RoomParser::preset(LineParser &line)
{
    std::vector<std::string> names;
    for (const ViewPreset &one : view_presets()) names.emplace_back(one.name);
    const ViewPreset &chosen = *view_preset(line.choice("view", names));
    primary_mdeg_ = chosen.primary_mdeg;
    secondary_mdeg_ = chosen.secondary_mdeg;
    sid_um_ = chosen.sid_um;
    add(RoomAction::distance, sid_um_, sod_um_);
    add(RoomAction::angles, primary_mdeg_, secondary_mdeg_);
    add(RoomAction::field, chosen.field_um);
}

void RoomParser::table(LineParser &line)
{
    do {
        const std::string axis = line.choice("axis of the table", {"x", "y", "z"});
        table_um_[axis[0] - 'x'] = um_between(line, "position", -table_max_um, table_max_um);
    } while (!line.is_at_end());
    add(RoomAction::table, table_um_[0], table_um_[1], table_um_[2]);
}

// Reads statements such as "collimate width 60 % height 80 %", "collimate round", "collimate open".
void RoomParser::blades(LineParser &line)
{
    bool has_blades = false;
    do {
        const std::string word =
            line.choice("part of the collimator", {"width", "height", "round", "rectangular", "open"});
        if (word == "round" || word == "rectangular") {
            add(RoomAction::iris, word == "round" ? 1 : 0);
            continue;
        }
        has_blades = true;
        if (word == "open") {
            width_permille_ = height_permille_ = 1000;
            continue;
        }
        const double share =
            line.quantity("opening", share_units, blade_min_permille * 1e-3, blade_max_permille * 1e-3);
        (word == "width" ? width_permille_ : height_permille_) = nearest(share * 1e3);
    } while (!line.is_at_end());
    if (has_blades) add(RoomAction::blades, width_permille_, height_permille_);
}

// Reads statements such as "mask frame 3" and "mask frames 2 to 5".
void RoomParser::mask(LineParser &line)
{
    line.choice("word", {"frame", "frames"});
    const std::int32_t first = ordinal(line, "frame");
    std::int32_t last = first;
    if (line.accept("to")) {
        const LineParser before = line;
        last = ordinal(line, "frame");
        if (last < first) before.fail("the last frame of a mask comes after its first");
    }
    add(RoomAction::mask, first - 1, last - 1);
}

// Reads statements such as "shift mask right 0.5 px up 1 px" and "shift mask none".
void RoomParser::shift(LineParser &line)
{
    line.accept("mask");
    double right = 0.0, up = 0.0;
    do {
        const std::string way = line.choice("direction", {"right", "left", "up", "down", "none"});
        if (way == "none") {
            right = up = 0.0;
            continue;
        }
        const double limit = shift_max_centipixels * 0.01;
        const double pixels = line.quantity("shift", pixel_units, 0.0, limit);
        (way == "right" || way == "left" ? right : up) = way == "right" || way == "up" ? pixels : -pixels;
    } while (!line.is_at_end());
    add(RoomAction::shift, nearest(right * 100.0), nearest(up * 100.0));
}

void RoomParser::roadmap(LineParser &line)
{
    const std::string what = line.choice("roadmap", {"off", "new", "from"});
    if (what == "from") line.expect("run");
    add(RoomAction::roadmap, what == "off" ? 0 : what == "from" ? 1 : 2);
}

// Reads statements such as "inject 8 ml at 4 ml/s", "inject 30 ml at 15 ml/s through tool 2", "inject stop".
void RoomParser::inject(LineParser &line)
{
    if (line.accept("stop")) return add(RoomAction::inject);
    const double volume_ml = line.quantity("volume", volume_units, 0.1, inject_max_ul * 1e-3);
    line.expect("at");
    const double rate_ml_s = line.quantity("rate", flow_units, 0.05, inject_rate_max_ul_s * 1e-3);
    std::int32_t tool = 0; // the outermost with a lumen
    if (line.accept("through")) {
        const std::string name = line.choice("tool", {"catheter", "guide", "tool"});
        const LineParser before = line;
        tool = name == "catheter" ? 2 : name == "guide" ? 3 : ordinal(line, "tool");
        if (tool > 3) before.fail("a tool is 1 to 3, from the innermost");
    }
    add(RoomAction::inject, nearest(volume_ml * 1e3), nearest(rate_ml_s * 1e3), tool);
}

// Reads statements such as "review", "review run 2", "review frame 12", "review run 2 frame 12", "review
// off".
void RoomParser::review(LineParser &line)
{
    std::int32_t mode = 1, run = 0, frame = 0;
    while (!line.is_at_end()) {
        const std::string word = line.choice("review", {"off", "loop", "run", "frame"});
        if (word == "off") mode = 0;
        if (word == "run") run = ordinal(line, "run");
        if (word != "frame") continue;
        mode = 2;
        frame = ordinal(line, "frame") - 1;
    }
    add(RoomAction::review, mode, run, frame);
}

} // namespace crn
