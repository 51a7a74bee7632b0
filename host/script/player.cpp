#include "host/base/text.hpp"
#include "host/script/session.hpp"
#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace crn
{

namespace
{

constexpr std::int64_t regrasp_ticks = 150; // between strokes the hand releases the tool and grips it again

std::int64_t sign_of(std::int64_t value)
{
    return value < 0 ? -1 : 1;
}

} // namespace

SessionPlayer::SessionPlayer(const Session &session, std::size_t tool_count, const VesselMap *vessels)
    : session_(session), tool_count_(std::min(tool_count, session_tools_max)),
      map_(vessels ? *vessels : VesselMap())
{
    if (session.tools_named > tool_count) {
        throw FileError(session.file, session.tools_named_line, 1,
                        "moves tool " + std::to_string(session.tools_named) + ", but there " +
                            (tool_count == 1 ? "is only one" : "are only " + std::to_string(tool_count)) +
                            "; name the tools with --tool from the innermost to the outermost");
    }
    for (const Statement &statement : session.statements) {
        const VesselName *name = statement.steering ? &statement.steering->vessel : nullptr;
        if (statement.expectation && statement.expectation->names_vessel())
            name = &statement.expectation->vessel;
        vessels_.push_back(name ? vessel_named(*name, statement.line) : 0);
    }
    enter_statement();
}

std::size_t SessionPlayer::vessel_named(const VesselName &name, int line) const
{
    if (map_.is_empty())
        throw FileError(
            session_.file, line, name.column,
            "names the vessel '" + name.text +
                "', but this scene has none; bake it with a [tree] and keep its .bodies file beside it");
    if (const auto vessel = map_.find(name.text)) return *vessel;
    throw FileError(session_.file, line, name.column,
                    "unknown vessel '" + name.text + "'" + map_.suggestion(name.text));
}

// Starts the move from the present position of the hand that holds the tool, and divides it into strokes if
// the statement demands strokes.
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
    const std::uint32_t pedal = command.action == RoomAction::fluoro_pedal    ? CRN_WIRE_BUTTON_XRAY
                                : command.action == RoomAction::acquire_pedal ? CRN_WIRE_BUTTON_CINE
                                                                              : 0;
    buttons_ = command.values[0] == 1 ? buttons_ | pedal : buttons_ & ~pedal;
}

// Executes all following statements that take no time, such as commands to the X-ray room, the heart and the
// breath. The first following statement that takes time then becomes the present statement.
void SessionPlayer::enter_statement()
{
    for (; !is_done(); statement_++) {
        const Statement &statement = session_.statements[statement_];
        for (const RoomCommand &command : statement.room) ask(command);
        if (statement.order) orders_.add(*statement.order);
        tick_in_statement_ = 0;
        active_.clear();
        inflating_ = {inflator_kPa_, 0, 0};
        if (statement.inflation) begin_inflation(*statement.inflation);
        for (const HandMove &move : statement.moves) {
            const std::size_t first = move.moves_all ? 0 : move.tool,
                              last = move.moves_all ? tool_count_ - 1 : move.tool;
            for (std::size_t tool = first; tool <= last; tool++) begin_move(move, tool);
        }
        steerer_.reset();
        if (statement.steering) {
            steerer_.emplace(*statement.steering, map_, vessels_[statement_]);
            std::copy_n(position_counts_[statement.steering->tool], 2, steer_begin_counts_);
        }
        if (!statement.moves.empty() || statement.wait_ticks > 0 || inflating_.ticks > 0 || steerer_ ||
            statement.expectation)
            return;
    }
}

// The present statement of the script ends when its pause and all its moves have ended.
void SessionPlayer::finish_statement()
{
    const Statement &statement = session_.statements[statement_];
    if (steerer_ || statement.expectation) return; // these end after their observation
    bool is_over = tick_in_statement_ >= statement.wait_ticks && tick_in_statement_ >= inflating_.ticks;
    for (const Active &active : active_) {
        is_over = is_over && (active.steady ? active.steady->is_done(tick_in_statement_)
                                            : tick_in_statement_ >= active.ticks);
    }
    if (!is_over) return;
    statement_++;
    enter_statement();
}

crn_wire_tick_input SessionPlayer::next()
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
    if (steerer_) {
        const Steerer::Counts moved = steerer_->next();
        std::int64_t(&hand)[2] = position_counts_[session_.statements[statement_].steering->tool];
        hand[0] = steer_begin_counts_[0] + moved.translation;
        hand[1] = steer_begin_counts_[1] + moved.rotation;
    }
    if (inflating_.ticks > 0) {
        const std::int64_t done = std::min(tick_in_statement_, inflating_.ticks);
        inflator_kPa_ =
            static_cast<std::int32_t>(inflating_.begin_kPa + inflating_.way_kPa * done / inflating_.ticks);
    }
    crn_wire_tick_input input{};
    input.hands_count = static_cast<std::uint16_t>(tool_count_);
    for (std::size_t k = 0; k < tool_count_; k++) {
        const auto counts = [&](int axis) {
            return static_cast<std::int32_t>(static_cast<std::uint32_t>(position_counts_[k][axis]));
        };
        input.hands[k] = {counts(0), counts(1)};
    }
    input.buttons = buttons_;
    input.inflator_raw = inflator_kPa_;
    orders_.move_into(input.orders);
    if (!is_done()) finish_statement();
    return input;
}

// An exchange of tools takes more ticks than one batch, so its answer arrives while its statement is still
// the current one.
void SessionPlayer::answer_exchange(std::uint8_t answer)
{
    if (answer <= CRN_WIRE_EXCHANGE_DONE || is_done() || !session_.statements[statement_].exchange) return;
    fail(std::string("exchange: ") + crn_wire_exchange_text(answer) + "; " +
         crn_wire_exchange_remedy(answer));
}

bool SessionPlayer::wants_tips() const
{
    return steerer_.has_value() || expects();
}

bool names_vessels(const Session &session)
{
    for (const Statement &statement : session.statements)
        if (statement.steering || (statement.expectation && statement.expectation->names_vessel()))
            return true;
    return false;
}

void SessionPlayer::observe(const SessionView &view)
{
    if (is_done()) return;
    if (steerer_) return look_at_steering(view);
    if (expects()) return look_at_expectation(view);
    const std::span<const double> inserted_m = view.inserted_m;
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

void SessionPlayer::look_at_steering(const SessionView &view)
{
    const Statement &statement = session_.statements[statement_];
    const std::size_t tool = statement.steering->tool;
    if (tool < view.tips.size() && tool < view.inserted_m.size())
        steerer_->observe(view.tips[tool], std::llround(view.inserted_m[tool] * 1e6));
    if (!steerer_->is_done() && !steerer_->has_failed()) return;
    steered_.push_back({statement.line, tool, map_.vessels()[vessels_[statement_]].name, steerer_->tries(),
                        static_cast<std::uint32_t>(steerer_->ticks()), steerer_->is_done()});
    if (steerer_->has_failed()) {
        fail((statement.steering->engages ? "engage: " : "steer: ") + steerer_->failure());
        return;
    }
    statement_++;
    enter_statement();
}

// Consecutive expectations of a script are checked at one tick, and every expectation that is not met is
// reported.
void SessionPlayer::look_at_expectation(const SessionView &view)
{
    while (expects()) {
        const Statement &statement = session_.statements[statement_];
        expected_.push_back(judge(*statement.expectation, statement.line, vessels_[statement_], map_, view,
                                  turned_deg(statement.expectation->tool)));
        const ExpectationResult &result = expected_.back();
        if (!result.is_held)
            failures_.push_back(session_.file + ":" + std::to_string(result.line) + ": expected " +
                                result.text + ", but " + result.found);
        statement_++;
    }
    if (failures_.empty())
        enter_statement();
    else
        statement_ = session_.statements.size();
}

// The script ends here.
void SessionPlayer::fail(const std::string &text)
{
    failures_.push_back(session_.file + ":" + std::to_string(session_.statements[statement_].line) + ": " +
                        text);
    statement_ = session_.statements.size();
    steerer_.reset();
}

double SessionPlayer::turned_deg(std::size_t tool) const
{
    return static_cast<double>(position_counts_[tool][1]) * 360.0 / counts_per_turn;
}

} // namespace crn
