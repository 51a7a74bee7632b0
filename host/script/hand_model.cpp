#include "host/script/hand_model.hpp"
#include "host/base/text.hpp"
#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>

namespace crn
{

namespace
{

// SplitMix64 makes the random numbers (Steele, Lea, Flood: Fast splittable pseudorandom number generators,
// OOPSLA 2014), so that every C++ standard library gives the same session.
class Chance
{
  public:
    explicit Chance(std::uint64_t seed) : state_(seed * 0x9e3779b97f4a7c15u + 1) {}

    double share() // 0 to 1, without 1
    {
        state_ += 0x9e3779b97f4a7c15u;
        std::uint64_t z = state_;
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
        z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
        return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1.0p-53;
    }
    bool happens(double probability) { return share() < probability; }
    double normal()
    {
        const double radius = std::sqrt(-2.0 * std::log(1.0 - share()));
        return radius * std::cos(2.0 * std::numbers::pi * share());
    }
    double exponential(double mean) { return -mean * std::log(1.0 - share()); }

  private:
    std::uint64_t state_;
};

constexpr double least_overpush_mm = 0.5;   // a hand does not correct less
constexpr std::int64_t correction_mm_s = 8; // slowly, so that the correction ends where it should

bool commands(const Statement &statement, RoomAction action, std::int32_t value)
{
    return std::any_of(statement.room.begin(), statement.room.end(), [&](const RoomCommand &command) {
        return command.action == action && command.values[0] == value;
    });
}

bool moves_table(const Statement &statement)
{
    return std::any_of(statement.room.begin(), statement.room.end(), [](const RoomCommand &command) {
        return command.action == RoomAction::table || command.action == RoomAction::follow;
    });
}

class HandModel
{
  public:
    HandModel(const Session &session, const Hands &hands)
        : session_(session), skill_(hands.skill), chance_(hands.seed)
    {
        for (std::size_t k = 0; k < session_tools_max; ++k) inserted_um_[k] = session.inserted_um[k];
        // Two people of the same skill have different tempos.
        tempo_ = std::exp(0.5 * skill_.speed_spread * chance_.normal());
    }

    Session run()
    {
        Session changed = session_;
        changed.statements.clear();
        out_ = &changed.statements;
        for (const Statement &statement : session_.statements) {
            if (statement.expectation) continue;
            if (!statement.moves.empty())
                motion(statement);
            else if (statement.inflation)
                inflation(statement);
            else if (!statement.room.empty())
                room(statement);
            else
                out_->push_back(statement);
        }
        catch_up();
        return changed;
    }

  private:
    void wait(int line, double seconds)
    {
        const auto ticks = static_cast<std::uint32_t>(std::lround(seconds * 1e3));
        if (ticks == 0) return;
        Statement pause;
        pause.line = line;
        pause.wait_ticks = ticks;
        out_->push_back(pause);
    }

    void command(int line, RoomAction action, std::int32_t value)
    {
        Statement statement;
        statement.line = line;
        statement.room.push_back({action, {value, 0, 0}});
        out_->push_back(statement);
    }

    void room(const Statement &statement)
    {
        if (moves_table(statement) && chance_.happens(skill_.late_table)) {
            late_.push_back(statement);
            return;
        }
        if (commands(statement, RoomAction::fluoro_pedal, 1)) {
            is_fluoro_on_ = true;
            if (chance_.happens(skill_.late_pedal)) {
                late_.push_back(statement);
                is_fluoro_on_ = false;
                return;
            }
        }
        if (commands(statement, RoomAction::fluoro_pedal, 0)) {
            catch_up();
            is_fluoro_on_ = false;
            wait(statement.line, chance_.exponential(skill_.held_pedal_s));
        }
        if (commands(statement, RoomAction::acquire_pedal, 1) && chance_.happens(skill_.empty_run)) {
            out_->push_back(statement);
            wait(statement.line, 1.0);
            command(statement.line, RoomAction::acquire_pedal, 0);
            wait(statement.line, 0.5);
        }
        if (commands(statement, RoomAction::acquire_pedal, 0))
            wait(statement.line, chance_.exponential(skill_.long_run_s));
        out_->push_back(statement);
    }

    void inflation(const Statement &statement)
    {
        Statement changed = statement;
        if (changed.inflation->kPa > 0 && chance_.happens(skill_.over_pressure))
            changed.inflation->kPa = std::min(changed.inflation->kPa * 115 / 100, 4000);
        wait(statement.line, chance_.exponential(skill_.pause_s));
        out_->push_back(changed);
    }

    // If the simulated person operates a pedal or the table late, this happens only after the first stroke of
    // the motion.
    void motion(const Statement &statement)
    {
        wait(statement.line, chance_.exponential(skill_.pause_s));
        if (is_fluoro_on_ && chance_.happens(skill_.lifted_pedal)) {
            command(statement.line, RoomAction::fluoro_pedal, 0);
            Statement again;
            again.line = statement.line;
            again.room.push_back({RoomAction::fluoro_pedal, {1, 0, 0}});
            late_.push_back(again);
        }
        if (statement.moves.size() == 1)
            single(statement);
        else
            out_->push_back(paced(statement));
        for (const HandMove &move : statement.moves) note(move);
        catch_up();
    }

    void catch_up()
    {
        for (const Statement &late : late_) {
            out_->push_back(late);
            is_fluoro_on_ |= commands(late, RoomAction::fluoro_pedal, 1);
        }
        late_.clear();
    }

    Statement paced(const Statement &statement)
    {
        Statement changed = statement;
        for (HandMove &move : changed.moves) {
            const double factor = skill_.speed * tempo_ * std::exp(skill_.speed_spread * chance_.normal());
            const double fastest =
                move.axis == HandAxis::translation ? 0.25 * counts_per_m : 3.0 * counts_per_turn;
            move.speed_counts_per_s = std::max<std::int64_t>(
                1, std::llround(std::min(static_cast<double>(move.speed_counts_per_s) * factor, fastest)));
            if (move.axis == HandAxis::rotation)
                move.distance_counts +=
                    std::llround(skill_.turn_spread_deg * chance_.normal() * counts_per_turn / 360.0);
            else if (!move.until_inserted_um && move.stroke_counts == 0)
                move.stroke_counts = std::llround(skill_.stroke_mm * 1e-3 * counts_per_m);
        }
        return changed;
    }

    void single(const Statement &statement)
    {
        const HandMove &move = statement.moves.front();
        const bool is_push =
            move.axis == HandAxis::translation && move.distance_counts > 0 && !move.moves_all;
        if (is_push && move.until_inserted_um) return push_until(statement, *move.until_inserted_um);
        out_->push_back(paced(statement));
        if (!is_push) return;
        const double over_mm = std::fabs(skill_.overpush_mm * chance_.normal());
        if (over_mm < least_overpush_mm) return;
        by(statement, over_mm);
        by(statement, -over_mm);
    }

    // A push to a stated length consists of strokes; the hand may search before the end, push too far and
    // pull back.
    void push_until(const Statement &statement, std::int64_t goal_um)
    {
        const std::size_t tool = statement.moves.front().tool;
        const double way_mm = static_cast<double>(goal_um - inserted_um_[tool]) * 1e-3;
        double here_mm = 0.0;
        while (here_mm + skill_.stroke_mm < way_mm) {
            here_mm += skill_.stroke_mm;
            until(statement, goal_um - std::llround((way_mm - here_mm) * 1e3));
            catch_up();
            if (!chance_.happens(skill_.search)) continue;
            const double back_mm = std::min(here_mm, skill_.search_mm * (0.3 + 0.7 * chance_.share()));
            by(statement, -back_mm);
            until(statement, goal_um - std::llround((way_mm - here_mm) * 1e3));
        }
        const double over_mm = way_mm > 0.0 ? std::fabs(skill_.overpush_mm * chance_.normal()) : 0.0;
        until(statement, goal_um + std::llround(over_mm * 1e3));
        until(statement, goal_um, -1); // also what the hand goes too far while it brakes
        out_->back().moves.front().speed_counts_per_s =
            std::min(out_->back().moves.front().speed_counts_per_s, correction_mm_s * counts_per_m / 1000);
    }

    void until(const Statement &statement, std::int64_t inserted_um, int sign = 1)
    {
        Statement part = paced(statement);
        part.moves.front().until_inserted_um = inserted_um;
        part.moves.front().distance_counts = sign;
        out_->push_back(part);
    }

    void by(const Statement &statement, double mm)
    {
        Statement part = paced(statement);
        part.moves.front().until_inserted_um.reset();
        part.moves.front().distance_counts = std::llround(mm * 1e-3 * counts_per_m);
        part.moves.front().stroke_counts = 0;
        out_->push_back(part);
    }

    void note(const HandMove &move)
    {
        if (move.axis != HandAxis::translation) return;
        for (std::size_t k = 0; k < session_tools_max; ++k) {
            if (!move.moves_all && k != move.tool) continue;
            inserted_um_[k] = move.until_inserted_um.value_or(inserted_um_[k] + move.distance_counts);
        }
    }

    const Session &session_;
    const HandSkill &skill_;
    Chance chance_;
    double tempo_ = 1.0;
    bool is_fluoro_on_ = false;
    std::int64_t inserted_um_[session_tools_max] = {}; // as the script wants it
    std::vector<Statement> late_;                      // follows the next motion
    std::vector<Statement> *out_ = nullptr;
};

} // namespace

const HandSkill &expert_hands()
{
    static const HandSkill skill = {.name = "expert",
                                    .speed = 1.0,
                                    .speed_spread = 0.15,
                                    .pause_s = 0.4,
                                    .stroke_mm = 60.0,
                                    .overpush_mm = 1.5,
                                    .search = 0.1,
                                    .search_mm = 15.0,
                                    .turn_spread_deg = 5.0,
                                    .late_pedal = 0.6,
                                    .lifted_pedal = 0.05,
                                    .held_pedal_s = 0.3,
                                    .late_table = 0.05,
                                    .empty_run = 0.1,
                                    .long_run_s = 0.5,
                                    .over_pressure = 0.05};
    return skill;
}

const HandSkill &novice_hands()
{
    static const HandSkill skill = {.name = "novice",
                                    .speed = 1.5,
                                    .speed_spread = 0.25,
                                    .pause_s = 0.4,
                                    .stroke_mm = 25.0,
                                    .overpush_mm = 7.0,
                                    .search = 0.7,
                                    .search_mm = 50.0,
                                    .turn_spread_deg = 25.0,
                                    .late_pedal = 0.9,
                                    .lifted_pedal = 0.25,
                                    .held_pedal_s = 2.0,
                                    .late_table = 0.6,
                                    .empty_run = 0.5,
                                    .long_run_s = 2.0,
                                    .over_pressure = 0.3};
    return skill;
}

const HandSkill &clumsy_hands()
{
    static const HandSkill skill = [] {
        HandSkill clumsy = novice_hands();
        clumsy.name = "clumsy";
        clumsy.overpush_mm = 12.0;
        clumsy.search = 0.6;
        clumsy.late_pedal = 1.0;
        clumsy.lifted_pedal = 0.6;
        clumsy.late_table = 0.8;
        clumsy.empty_run = 1.0;
        clumsy.long_run_s = 8.0;
        clumsy.over_pressure = 1.0;
        return clumsy;
    }();
    return skill;
}

Hands read_hands(const std::string &word)
{
    const std::size_t colon = word.find(':');
    const std::string name = word.substr(0, colon);
    const HandSkill *found = nullptr;
    std::vector<std::string> names;
    for (const HandSkill *skill : {&expert_hands(), &novice_hands(), &clumsy_hands()}) {
        names.push_back(skill->name);
        if (skill->name == name) found = skill;
    }
    if (!found) throw std::runtime_error("--hands '" + word + "': unknown skill" + suggestion(name, names));
    std::uint64_t seed = 0;
    const std::string number = colon == std::string::npos ? "" : word.substr(colon + 1);
    const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), seed);
    if (number.empty() || error != std::errc() || end != number.data() + number.size())
        throw std::runtime_error("--hands '" + word + "': write a skill and a seed, such as " + name + ":7");
    return {*found, seed};
}

Session with_hands(const Session &session, const Hands &hands)
{
    return HandModel(session, hands).run();
}

} // namespace crn
