#include "host/app/session.hpp"
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

SessionPlayer::SessionPlayer(const Session &session) : session_(session)
{
    enter_statement();
}

// Views take effect at once; the first statement that takes time becomes the present one.
void SessionPlayer::enter_statement()
{
    for (; !is_done(); statement_++) {
        const Statement &statement = session_.statements[statement_];
        if (statement.view) view_ = *statement.view;
        tick_in_statement_ = 0;
        active_.clear();
        for (const HandMove &move : statement.moves) {
            Active active{move, position_counts_[static_cast<int>(move.axis)], {}, {}, 0};
            if (move.until_inserted_um) {
                active.steady.emplace(move.speed_counts_per_s * sign_of(move.distance_counts));
            } else {
                const std::int64_t whole = std::llabs(move.distance_counts);
                const std::int64_t stroke =
                    move.stroke_counts > 0 ? move.stroke_counts : std::max<std::int64_t>(whole, 1);
                for (std::int64_t done = 0; done < whole; done += stroke) {
                    const std::int64_t length =
                        std::min(stroke, whole - done) * sign_of(move.distance_counts);
                    const Stroke next{active.ticks, done * sign_of(move.distance_counts),
                                      Move(length, move.speed_counts_per_s)};
                    active.ticks += next.move.ticks() + (done + stroke < whole ? regrasp_ticks : 0);
                    active.strokes.push_back(next);
                }
            }
            active_.push_back(std::move(active));
        }
        if (!statement.moves.empty() || statement.wait_ticks > 0) return;
    }
}

// The present statement is over when its pause and all its moves are.
void SessionPlayer::finish_statement()
{
    const Statement &statement = session_.statements[statement_];
    bool is_over = tick_in_statement_ >= statement.wait_ticks;
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
        position_counts_[static_cast<int>(active.what.axis)] = active.begin_counts + moved;
    }
    seld_wire_encoders input{};
    input.translation_counts = static_cast<std::int32_t>(static_cast<std::uint32_t>(position_counts_[0]));
    input.rotation_counts = static_cast<std::int32_t>(static_cast<std::uint32_t>(position_counts_[1]));
    input.buttons = view_.is_fluoro_on ? SELD_WIRE_BUTTON_XRAY : 0;
    if (!is_done()) finish_statement();
    return input;
}

void SessionPlayer::observe(double inserted_m)
{
    const auto inserted_um = static_cast<std::int64_t>(std::llround(inserted_m * 1e6));
    for (Active &active : active_) {
        if (!active.steady || active.steady->is_stopping()) continue;
        const std::int64_t left = *active.what.until_inserted_um - inserted_um;
        const bool is_reached = active.what.distance_counts > 0 ? left <= 0 : left >= 0;
        const bool is_given_up = tick_in_statement_ >= until_limit_ticks;
        if (is_reached || is_given_up) active.steady->stop(tick_in_statement_);
        if (!is_reached && is_given_up) given_up_lines_.push_back(session_.statements[statement_].line);
    }
}

} // namespace seld
