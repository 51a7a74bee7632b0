#include "host/suite/user_input.hpp"
#include "host/script/hand_motion.hpp"
#include "host/script/rhythm.hpp"
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <algorithm>
#include <cmath>
#include <iterator>

namespace crn
{
namespace
{

constexpr std::int64_t push_um_per_s = 30'000, push_slow_um_per_s = 6'000;
constexpr std::int64_t turn_counts_per_s = counts_per_turn / 2, turn_slow_counts_per_s = counts_per_turn / 12;
constexpr std::int32_t injection_rates_ul_s[] = {1000, 2000, 4000, 8000, 15000, 25000};
constexpr std::int32_t inflate_kPa_per_s = 100, deflate_kPa_per_s = -400;

std::size_t index_of(ControlId id)
{
    return static_cast<std::size_t>(id);
}

bool is_of_window(ControlId id)
{
    return id >= ControlId::help || (id >= ControlId::to_reference && id <= ControlId::pixels);
}

} // namespace

void UserInput::key(int key, int action, int modifiers)
{
    is_slow_ = (modifiers & GLFW_MOD_SHIFT) != 0;
    if (key == GLFW_KEY_LEFT_SHIFT || key == GLFW_KEY_RIGHT_SHIFT) is_slow_ = action != GLFW_RELEASE;
    const auto down = keys_.find(key);
    if (action == GLFW_RELEASE) {
        if (down == keys_.end()) return;
        release(down->second);
        keys_.erase(down);
        return;
    }
    const Control *found = control_of_key(key, modifiers);
    if (!found) return;
    if (action == GLFW_REPEAT) return repeat(found->id);
    if (down != keys_.end()) release(down->second);
    keys_[key] = found->id;
    press(found->id);
}

void UserInput::press(ControlId id)
{
    ++held_[index_of(id)];
    is_fresh_[index_of(id)] = true;
    if (control(id).kind != ControlKind::hold) act(id);
}

void UserInput::repeat(ControlId id)
{
    if (control(id).kind == ControlKind::repeat) act(id);
}

void UserInput::release(ControlId id)
{
    int &held = is_fresh_[index_of(id)] ? to_release_[index_of(id)] : held_[index_of(id)];
    if (&held == &to_release_[index_of(id)])
        ++held;
    else
        held = std::max(held - 1, 0);
}

void UserInput::release_all()
{
    held_.fill(0);
    to_release_.fill(0);
    is_fresh_.fill(false);
    keys_.clear();
    push_stick_ = turn_stick_ = 0.0;
    is_slow_ = false;
}

void UserInput::analog(double push, double turn)
{
    push_stick_ = std::clamp(push, -1.0, 1.0);
    turn_stick_ = std::clamp(turn, -1.0, 1.0);
}

void UserInput::choose(std::size_t tool)
{
    if (tool >= tool_count_) return;
    chosen_tool_ = tool;
    moves_all_ = false;
}

void UserInput::act(ControlId id)
{
    if (act_on_tools(id) || act_on_rack(id) || act_on_heart(id)) return;
    if (id == ControlId::fluoro_latch)
        is_latched_ = !is_latched_;
    else if (id == ControlId::inject_rate)
        injection_rate_ = (injection_rate_ + 1) % std::size(injection_rates_ul_s);
    else if (is_of_window(id))
        own_.push_back(id);
    else
        actions_.push_back(id);
}

bool UserInput::act_on_tools(ControlId id)
{
    switch (id) {
    case ControlId::tool_1:
    case ControlId::tool_2:
    case ControlId::tool_3:
        choose(index_of(id) - index_of(ControlId::tool_1));
        return true;
    case ControlId::tool_next:
        choose((chosen_tool_ + 1) % tool_count_);
        return true;
    case ControlId::tool_previous:
        choose((chosen_tool_ + tool_count_ - 1) % tool_count_);
        return true;
    case ControlId::move_all:
        moves_all_ = tool_count_ > 1 && !moves_all_;
        return true;
    default:
        return false;
    }
}

bool UserInput::is_on_line(std::size_t number) const
{
    return std::find(line_.begin(), line_.end(), number) != line_.end();
}

// Selects the next tool that is not in use, in steps of `step` numbers through the table.
void UserInput::step_to_load(std::size_t step)
{
    for (std::size_t i = 1; i <= table_count_; ++i) {
        const std::size_t number = (to_load_ + table_count_ - 1 + i * step) % table_count_ + 1;
        if (is_on_line(number)) continue;
        to_load_ = static_cast<std::uint8_t>(number);
        return;
    }
    to_load_ = 0;
}

void UserInput::see_line(const LineNumbers &line, std::size_t table_count)
{
    if (line == line_ && table_count == table_count_) return;
    // The tool that has just been removed is selected, because it is the one that is most often loaded again.
    LineNumbers left = line_;
    std::erase_if(left, [&](std::uint8_t number) {
        return number == 0 || std::find(line.begin(), line.end(), number) != line.end();
    });
    line_ = line;
    table_count_ = table_count;
    if (to_load_ != 0 && to_load_ <= table_count && !is_on_line(to_load_)) return;
    if (left.empty())
        step_to_load(1);
    else
        to_load_ = left.front();
}

void UserInput::select_to_load(std::uint8_t number)
{
    if (number >= 1 && number <= table_count_ && !is_on_line(number)) to_load_ = number;
}

// An exchange of tools is one order to the core, which states the reason if it refuses the exchange.
bool UserInput::act_on_rack(ControlId id)
{
    const auto position = static_cast<std::uint8_t>(chosen_tool_);
    switch (id) {
    case ControlId::rack_next:
        step_to_load(1);
        return true;
    case ControlId::rack_previous:
        if (table_count_ > 0) step_to_load(table_count_ - 1);
        return true;
    case ControlId::load_tool:
        // If no tool can be loaded, the core is asked for the tool that is already at this position, and
        // answers that this tool is there.
        orders_.push_back(crn_wire_order_of_exchange(
            {position, to_load_ != 0 || chosen_tool_ >= line_.size() ? to_load_ : line_[chosen_tool_]}));
        return true;
    case ControlId::take_off:
        orders_.push_back(crn_wire_order_of_exchange({position, 0}));
        return true;
    default:
        return false;
    }
}

bool UserInput::act_on_heart(ControlId id)
{
    const auto order = [&](std::uint8_t action, int value) {
        orders_.push_back(crn_wire_order_of_rhythm({action, static_cast<std::uint16_t>(value)}));
        return true;
    };
    switch (id) {
    case ControlId::heart_slower:
    case ControlId::heart_faster:
        heart_rate_per_min_ =
            std::clamp(heart_rate_per_min_ + (id == ControlId::heart_faster ? 10 : -10), 40, 160);
        return order(CRN_WIRE_RHYTHM_HEART_RATE, heart_rate_per_min_);
    case ControlId::premature:
        return order(CRN_WIRE_RHYTHM_PREMATURE, premature_usual_milli);
    case ControlId::asystole:
        is_asystole_ = !is_asystole_;
        return order(CRN_WIRE_RHYTHM_ASYSTOLE, is_asystole_);
    case ControlId::breath_hold:
        holds_breath_ = !holds_breath_;
        return order(CRN_WIRE_RHYTHM_BREATH_HOLD, holds_breath_);
    default:
        return false;
    }
}

double UserInput::injection_ml_s() const
{
    return injection_rates_ul_s[injection_rate_] * 1e-3;
}

// Each pedal whose state has changed gives one command.
void UserInput::add_pedals(UserWishes &wishes)
{
    const auto change = [](bool now, bool &before) {
        const bool has_changed = now != before;
        before = now;
        return has_changed;
    };
    const bool is_fluoro = is_held(ControlId::fluoro) || is_latched_;
    if (change(is_fluoro, was_fluoro_))
        wishes.commands.push_back({RoomAction::fluoro_pedal, {is_fluoro, 0, 0}});
    const bool is_acquire = is_held(ControlId::acquire);
    if (change(is_acquire, was_acquire_))
        wishes.commands.push_back({RoomAction::acquire_pedal, {is_acquire, 0, 0}});
    const bool is_injecting = is_held(ControlId::inject);
    if (change(is_injecting, was_injecting_))
        wishes.commands.push_back(
            {RoomAction::inject,
             {is_injecting ? inject_max_ul : 0, injection_rates_ul_s[injection_rate_], 0}});
}

std::vector<HandSpeed> UserInput::hand_speeds() const
{
    const auto difference = [&](ControlId plus, ControlId minus) {
        return static_cast<double>(is_held(plus)) - static_cast<double>(is_held(minus));
    };
    const double push = std::clamp(difference(ControlId::push, ControlId::pull) + push_stick_, -1.0, 1.0);
    const double turn =
        std::clamp(difference(ControlId::turn_right, ControlId::turn_left) + turn_stick_, -1.0, 1.0);
    const HandSpeed speed = {
        std::llround(push * static_cast<double>(is_slow_ ? push_slow_um_per_s : push_um_per_s)),
        std::llround(turn * static_cast<double>(is_slow_ ? turn_slow_counts_per_s : turn_counts_per_s))};
    std::vector<HandSpeed> speeds(tool_count_);
    for (std::size_t k = 0; k < tool_count_; ++k)
        if (moves_all_ || k == chosen_tool_) speeds[k] = speed;
    return speeds;
}

UserWishes UserInput::take()
{
    UserWishes wishes;
    wishes.actions = std::exchange(actions_, {});
    wishes.orders = std::exchange(orders_, {});
    add_pedals(wishes);
    const std::vector<HandSpeed> hands = hand_speeds();
    if (hands != last_hands_) wishes.hands = last_hands_ = hands;
    const std::int32_t inflation = is_held(ControlId::deflate)   ? deflate_kPa_per_s
                                   : is_held(ControlId::inflate) ? inflate_kPa_per_s
                                                                 : 0;
    if (inflation != last_inflation_) wishes.inflation_kPa_per_s = last_inflation_ = inflation;
    for (std::size_t i = 0; i < control_count; ++i) {
        held_[i] = std::max(held_[i] - to_release_[i], 0);
        to_release_[i] = 0;
        is_fresh_[i] = false;
    }
    return wishes;
}

void UserInput::begin_session()
{
    was_fluoro_ = was_acquire_ = was_injecting_ = false;
    last_hands_.clear();
    last_inflation_ = 0;
    heart_rate_per_min_ = 70;
    is_asystole_ = holds_breath_ = false;
    actions_.clear();
    orders_.clear();
}

} // namespace crn
