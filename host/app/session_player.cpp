#include "host/app/session.hpp"
#include "host/model/text.hpp"
#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace seld
{

namespace
{

constexpr std::int64_t regrasp_ticks = 150; // the hand lets go and takes hold again between strokes

std::int64_t sign_of(std::int64_t value)
{
    return value < 0 ? -1 : 1;
}

} // namespace

SessionPlayer::SessionPlayer(const Session &session, std::size_t tool_count)
    : session_(session), tool_count_(std::min(tool_count, session_tools_max))
{
    if (session.tools_named > tool_count) {
        throw FileError(session.file, session.tools_named_line, 1,
                        "moves tool " + std::to_string(session.tools_named) + ", but there " +
                            (tool_count == 1 ? "is only one" : "are only " + std::to_string(tool_count)) +
                            "; name the tools with --tool from the innermost to the outermost");
    }
    enter_statement();
}

// `move` cut into strokes, from where the tool's hand is now.
void SessionPlayer::begin_move(const HandMove &move, std::size_t tool)
{
    Active active{move, tool, position_counts_[tool][static_cast<int>(move.axis)], {}, {}, 0};
    const std::int64_t sign = sign_of(move.distance_counts);
    if (move.until_inserted_um) {
        active.steady.emplace(move.speed_counts_per_s * sign);
        active_.push_back(std::move(active));
        return;
    }
    const std::int64_t whole = std::llabs(move.distance_counts);
    const std::int64_t stroke =
        move.stroke_counts > 0 ? move.stroke_counts : std::max<std::int64_t>(whole, 1);
    for (std::int64_t done = 0; done < whole; done += stroke) {
        const std::int64_t length = std::min(stroke, whole - done) * sign;
        const Stroke next{active.ticks, done * sign, Move(length, move.speed_counts_per_s)};
        active.ticks += next.move.ticks() + (done + stroke < whole ? regrasp_ticks : 0);
        active.strokes.push_back(next);
    }
    active_.push_back(std::move(active));
}

void SessionPlayer::begin_inflation(const Inflation &inflation)
{
    inflating_.way_kPa = inflation.kPa - inflator_kPa_;
    inflating_.ticks =
        (std::llabs(inflating_.way_kPa) * 1000 + inflation.kPa_per_s - 1) / inflation.kPa_per_s;
}

void SessionPlayer::ask(const RoomCommand &command)
{
    commands_.push_back(command);
    const std::uint32_t pedal = command.action == RoomAction::fluoro_pedal    ? SELD_WIRE_BUTTON_XRAY
                                : command.action == RoomAction::acquire_pedal ? SELD_WIRE_BUTTON_CINE
                                                                              : 0;
    buttons_ = command.values[0] == 1 ? buttons_ | pedal : buttons_ & ~pedal;
}

// Commands to the room and to heart and breath take effect at once; the first statement that takes time becomes the present one.
void SessionPlayer::enter_statement()
{
    for (; !is_done(); statement_++) {
        const Statement &statement = session_.statements[statement_];
        for (const RoomCommand &command : statement.room) ask(command);
        if (statement.rhythm) rhythm_.add(*statement.rhythm);
        tick_in_statement_ = 0;
        active_.clear();
        inflating_ = {inflator_kPa_, 0, 0};
        if (statement.inflation) begin_inflation(*statement.inflation);
        for (const HandMove &move : statement.moves) {
            const std::size_t first = move.moves_all ? 0 : move.tool,
                              last = move.moves_all ? tool_count_ - 1 : move.tool;
            for (std::size_t tool = first; tool <= last; tool++) begin_move(move, tool);
        }
        if (!statement.moves.empty() || statement.wait_ticks > 0 || inflating_.ticks > 0) return;
    }
}

// The present statement is over when its pause and all its moves are.
void SessionPlayer::finish_statement()
{
    const Statement &statement = session_.statements[statement_];
    bool is_over = tick_in_statement_ >= statement.wait_ticks && tick_in_statement_ >= inflating_.ticks;
    for (const Active &active : active_) {
        is_over = is_over && (active.steady ? active.steady->is_done(tick_in_statement_)
                                            : tick_in_statement_ >= active.ticks);
    }
    if (!is_over) return;
    statement_++;
    enter_statement();
}

seld_wire_encoders SessionPlayer::next()
{
    tick_in_statement_++;
    for (const Active &active : active_) {
        std::int64_t moved = 0;
        if (active.steady) moved = active.steady->at(tick_in_statement_);
        for (const Stroke &stroke : active.strokes) {
            if (tick_in_statement_ > stroke.begin_tick) {
                moved = stroke.begin_counts + stroke.move.at(tick_in_statement_ - stroke.begin_tick);
            }
        }
        position_counts_[active.tool][static_cast<int>(active.what.axis)] = active.begin_counts + moved;
    }
    if (inflating_.ticks > 0) {
        const std::int64_t done = std::min(tick_in_statement_, inflating_.ticks);
        inflator_kPa_ =
            static_cast<std::int32_t>(inflating_.begin_kPa + inflating_.way_kPa * done / inflating_.ticks);
    }
    seld_wire_encoders input{};
    input.hands_count = static_cast<std::uint16_t>(tool_count_);
    for (std::size_t k = 0; k < tool_count_; k++) {
        const auto counts = [&](int axis) {
            return static_cast<std::int32_t>(static_cast<std::uint32_t>(position_counts_[k][axis]));
        };
        input.hands[k] = {counts(0), counts(1)};
    }
    input.buttons = buttons_;
    input.inflator_raw = inflator_kPa_;
    rhythm_.put_next(input);
    if (!is_done()) finish_statement();
    return input;
}

void SessionPlayer::observe(std::span<const double> inserted_m)
{
    for (Active &active : active_) {
        if (!active.steady || active.steady->is_stopping() || active.tool >= inserted_m.size()) continue;
        const auto inserted_um = static_cast<std::int64_t>(std::llround(inserted_m[active.tool] * 1e6));
        const std::int64_t left = *active.what.until_inserted_um - inserted_um;
        const bool is_reached = active.what.distance_counts > 0 ? left <= 0 : left >= 0;
        const bool is_given_up = tick_in_statement_ >= until_limit_ticks;
        if (is_reached || is_given_up) active.steady->stop(tick_in_statement_);
        const int line = session_.statements[statement_].line;
        const bool is_new = given_up_lines_.empty() || given_up_lines_.back() != line;
        if (!is_reached && is_given_up && is_new) given_up_lines_.push_back(line);
    }
}

} // namespace seld
