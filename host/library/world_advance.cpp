// Advances a world by new inputs or by the inputs of a recording. Device and patient are called in the same
// order as in `cournand run` and `cournand replay`.
#include "host/base/number_text.hpp"
#include "host/library/world.hpp"
#include "host/session/contact_figures.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace crn::library
{

namespace
{

constexpr std::int64_t parts_per_count = 1'000'000;
constexpr std::int64_t push_step_max = 5000, turn_step_max = 16384; // counts in one tick
constexpr double push_max_m_per_s = 1.0, turn_max_rad_per_s = 100.0;

// Rounds down, so that steps of equal size give the same numbers of counts for negative and for positive
// positions. The counts may wrap around, as those of real encoders do.
std::int32_t counts(std::int64_t parts)
{
    const std::int64_t whole = parts / parts_per_count - (parts % parts_per_count < 0);
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(whole));
}

float entry(std::span<const float> action, std::size_t index, double least, double most, const char *name)
{
    const double value = action[index];
    if (value >= least && value <= most) return action[index]; // refuses NaN, too
    throw Refused(COURNAND_BAD_ARGUMENT, std::string("action[") + std::to_string(index) + "], " + name +
                                             ", is " + std::to_string(value) + ", not within " +
                                             std::to_string(least) + " and " + std::to_string(most));
}

std::int32_t checked(std::int32_t value, std::int32_t most, const char *name)
{
    if (value >= 0 && value <= most) return value;
    throw Refused(COURNAND_BAD_ARGUMENT, std::string("the order's value ") + name + " is " +
                                             std::to_string(value) + ", not within 0 and " +
                                             std::to_string(most));
}

void check_unused(const cournand_order &order, std::size_t from)
{
    for (std::size_t i = from; i < std::size(order.values); i++)
        require(order.values[i] == 0, "a value that the order does not have is not 0");
}

crn_wire_order wire_order(const cournand_order &order)
{
    const std::int32_t *v = order.values;
    const auto u8 = [&](int i, const char *name) {
        return static_cast<std::uint8_t>(checked(v[i], 255, name));
    };
    const auto u16 = [&](int i, const char *name) {
        return static_cast<std::uint16_t>(checked(v[i], 65535, name));
    };
    switch (order.kind) {
    case COURNAND_ORDER_RHYTHM:
        check_unused(order, 2);
        return crn_wire_order_of_rhythm({u8(0, "action"), u16(1, "value")});
    case COURNAND_ORDER_SCAFFOLD:
        check_unused(order, 4);
        return crn_wire_order_of_scaffold(
            {u8(0, "lesion"), u8(1, "first"), u8(2, "last"), u16(3, "open_q15")});
    case COURNAND_ORDER_STRUT:
        return crn_wire_order_of_strut({u8(0, "number"), u8(1, "joined"), v[2], v[3], v[4],
                                        u16(5, "inside_um"), u16(6, "thickness_um")});
    case COURNAND_ORDER_EXCHANGE:
        check_unused(order, 2);
        return crn_wire_order_of_exchange({u8(0, "position"), u8(1, "tool")});
    default:
        throw Refused(COURNAND_BAD_ARGUMENT, "there is no order of kind " + std::to_string(order.kind));
    }
}

// Gives the highest speeds of a hand; a faster hand would stop the device, which takes such a motion for a
// broken encoder (docs/faults.md).
void check_step(const crn_wire_hand &from, const crn_wire_hand &to)
{
    const auto way = [](std::int32_t a, std::int32_t b) { // counts may wrap
        return std::abs(std::int64_t{
            static_cast<std::int32_t>(static_cast<std::uint32_t>(b) - static_cast<std::uint32_t>(a))});
    };
    require(way(from.translation_counts, to.translation_counts) <= push_step_max,
            "an input pushes by more than 5 mm in one tick");
    require(way(from.rotation_counts, to.rotation_counts) <= turn_step_max,
            "an input turns by more than a quarter turn in one tick");
}

crn_wire_order_list wire_orders(const cournand_input &input)
{
    crn_wire_order_list list{};
    require(input.order_count <= COURNAND_ORDERS_MAX, "an input has more than four orders");
    for (std::uint32_t i = 0; i < input.order_count; i++) {
        const crn_wire_order order = wire_order(input.orders[i]);
        require(order_of(list, order.kind) == nullptr, "an input has two orders of one kind");
        list.items[list.items_count++] = order;
    }
    return list;
}

} // namespace

void World::check_ticks(std::size_t ticks) const
{
    require(ticks >= 1 && ticks <= COURNAND_TICKS_MAX, "the number of ticks is not within 1 and 600000");
    if (tick() > (1u << 31) - COURNAND_TICKS_MAX)
        throw Refused(COURNAND_BAD_STATE, "the world is 24 days old, and ends here: make another world");
}

crn_wire_tick_input World::present_input() const
{
    crn_wire_tick_input input{};
    input.hands_count = static_cast<std::uint16_t>(positions());
    for (std::size_t k = 0; k < positions(); k++) input.hands[k] = {counts(push_[k]), counts(turn_[k])};
    input.inflator_raw = inflator_kPa_;
    return input;
}

void World::take_hands(const crn_wire_tick_input &input)
{
    for (std::size_t k = 0; k < positions(); k++) {
        push_[k] = input.hands[k].translation_counts * parts_per_count;
        turn_[k] = input.hands[k].rotation_counts * parts_per_count;
    }
    inflator_kPa_ = input.inflator_raw;
}

World::Speeds World::checked_speeds(std::span<const float> action, std::uint32_t ticks) const
{
    check_free();
    check_ticks(ticks);
    Speeds speeds;
    for (std::size_t k = 0; k < COURNAND_POSITIONS_MAX; k++) {
        const bool has = k < positions();
        const double push_m_per_s =
            entry(action, k, has ? -push_max_m_per_s : 0.0, has ? push_max_m_per_s : 0.0, "a push in m/s");
        const double turn_rad_per_s =
            entry(action, COURNAND_POSITIONS_MAX + k, has ? -turn_max_rad_per_s : 0.0,
                  has ? turn_max_rad_per_s : 0.0, "a turn in rad/s");
        speeds.push[k] = std::llround(push_m_per_s * 1e3 * parts_per_count);
        speeds.turn[k] = std::llround(turn_rad_per_s * (65.536 / (2.0 * std::numbers::pi)) * parts_per_count);
    }
    const float kPa = entry(action, 6, 0.0, 4000.0, "a pressure in kPa");
    entry(action, 7, 0.0, 0.0, "unused");
    speeds.inflator_kPa = static_cast<std::int32_t>(std::lround(kPa));
    return speeds;
}

void World::move(std::span<const float> action, std::uint32_t ticks)
{
    const Speeds speeds = checked_speeds(action, ticks);
    inflator_kPa_ = speeds.inflator_kPa;
    const Fill fill = [&](std::uint32_t, crn_wire_tick_input &input) {
        for (std::size_t k = 0; k < positions(); k++) {
            push_[k] += speeds.push[k];
            turn_[k] += speeds.turn[k];
        }
        input = present_input();
    };
    run(ticks, {fill, nullptr, false});
}

// The device tries the order in a separate tick, which is then undone, so that a refusal changes nothing.
void World::try_orders(const crn_wire_order_list &orders)
{
    std::vector<std::uint8_t> before(SimTransport::snapshot_bytes());
    if (!pipe_.take_snapshot(before)) throw Refused(COURNAND_INTERNAL, "the device gives no snapshot");
    const std::uint32_t now = tick();
    crn_wire_tick_input input = present_input();
    input.orders = orders;
    const auto undo = [&] { put_device(before, now); };
    std::uint8_t answer = CRN_WIRE_EXCHANGE_NONE;
    try {
        answer = link_.step({&input, 1}, false).back().exchange;
    } catch (...) {
        undo();
        throw;
    }
    undo();
    if (answer > CRN_WIRE_EXCHANGE_DONE)
        throw Refused(COURNAND_REFUSED, std::string("exchange: ") + crn_wire_exchange_text(answer) + "; " +
                                            crn_wire_exchange_remedy(answer));
}

void World::order(const cournand_order &order)
{
    check_free();
    crn_wire_order_list list{1, {wire_order(order)}};
    try_orders(list);
    orders_.add(list.items[0]);
}

void World::advance(std::span<const cournand_input> given)
{
    check_free();
    check_ticks(given.size());
    crn_wire_tick_input before = present_input();
    bool has_before = tick() > 0; // the first input of a world gives the zero of the hands
    for (const cournand_input &input : given) {
        for (std::size_t k = 0; k < positions(); k++) {
            const crn_wire_hand hand = {input.push_um[k], input.turn_counts[k]};
            if (has_before) check_step(before.hands[k], hand);
            before.hands[k] = hand;
        }
        has_before = true;
        require(input.inflator_kPa >= 0 && input.inflator_kPa <= 4000,
                "inflator_kPa is not within 0 and 4000");
        require(input.buttons <= 255, "buttons has a bit that is reserved");
        require(input.reserved == 0, "`reserved` of an input is not 0");
        for (std::size_t k = positions(); k < COURNAND_POSITIONS_MAX; k++)
            require(input.push_um[k] == 0 && input.turn_counts[k] == 0,
                    "an input moves a position that the line does not have");
        crn_wire_order_list orders = wire_orders(input);
        for (std::uint8_t i = 0; i < orders.items_count; i++) {
            const crn_wire_order &order = orders.items[i];
            if (order.kind != CRN_WIRE_KIND_exchange) {
                try_orders({1, {order}});
                continue;
            }
            // The core decides only in the tick of an exchange whether the exchange is possible; the reading
            // after that tick contains the answer.
            require(order.exchange.position < positions() && order.exchange.tool <= settings_.tools.size(),
                    "an exchange names a position or a tool that the world does not have");
        }
    }
    const Fill fill = [&](std::uint32_t i, crn_wire_tick_input &input) {
        const cournand_input &from = given[i];
        input.hands_count = static_cast<std::uint16_t>(positions());
        for (std::size_t k = 0; k < positions(); k++) input.hands[k] = {from.push_um[k], from.turn_counts[k]};
        input.buttons = from.buttons;
        input.inflator_raw = from.inflator_kPa;
        input.orders = wire_orders(from);
    };
    run(static_cast<std::uint32_t>(given.size()), {fill, nullptr, true});
}

std::uint32_t World::batch_size(std::uint32_t left, const Recording *recording) const
{
    const std::uint32_t now = tick();
    std::uint32_t count = std::min<std::uint32_t>(left, Link::steps_max);
    if (patient_ && patient_->next_look() > now) count = std::min(count, patient_->next_look() - now);
    if (patient_ && patient_->can_be_injured())
        count = std::min(count, Patient::feel_every_ticks - now % Patient::feel_every_ticks);
    if (settings_.contact_ticks > 0)
        count = std::min(count, settings_.contact_ticks - now % settings_.contact_ticks);
    if (recorder_)
        count = std::min(count, Recorder::snapshot_every_ticks - now % Recorder::snapshot_every_ticks);
    if (!recording) return count;
    count = std::min(count, recording->ticks_to_resume(now));
    if (patient_ && replayed_command_ < recording->commands.size())
        count = std::min(count, std::max(recording->commands[replayed_command_].tick, now + 1) - now);
    return count;
}

void World::run(std::uint32_t ticks, const Source &source)
{
    wall_peak_N_ = 0.0;
    recorder_failure_.clear();
    try {
        for (std::uint32_t done = 0; done < ticks;) {
            if (source.recording) resume_recorded(*source.recording);
            if (source.recording) pass_recorded(*source.recording);
            settle();
            const std::uint32_t count = batch_size(ticks - done, source.recording);
            batch(done, count, source);
            done += count;
        }
    } catch (const Refused &) {
        throw;
    } catch (const std::exception &error) {
        stopped_ = error.what();
        throw;
    }
    if (!recorder_failure_.empty())
        throw Refused(COURNAND_BAD_FILE,
                      "the world has advanced, but its recording has ended: " + recorder_failure_);
}

void World::batch(std::uint32_t done, std::uint32_t count, const Source &source)
{
    inputs_.clear();
    for (std::uint32_t i = 0; i < count; i++) {
        crn_wire_tick_input input{};
        source.fill(done + i, input);
        if (!source.recording) {
            orders_.move_into(input.orders);
            if (patient_) patient_->give_orders(input.orders);
        } else if (patient_) { // the recording has the patient's orders
            crn_wire_order_list recorded = {};
            patient_->give_orders(recorded);
        }
        inputs_.push_back(input);
    }
    forget_views();
    const auto states = link_.step(inputs_, false);
    for (std::size_t i = 0; i < states.size(); i++) take(inputs_[i], states[i]);
    if (source.sets_hands) take_hands(inputs_.back());
    record_state();
    sample_contacts();
    feel();
    if (source.recording)
        for (const crn_wire_tick_state &state : states) compare(state, *source.recording);
}

void World::take(const crn_wire_tick_input &input, const crn_wire_tick_state &state)
{
    note(state);
    recording_work([&](Recorder &recorder) { recorder.tick(input, state); });
    if (patient_) patient_->tick(input, state);
}

void World::note(const crn_wire_tick_state &state)
{
    range_.take(state);
    if (range_.is_left() && !out_of_range_tick_) out_of_range_tick_ = range_.left()->tick;
    state_ = state;
}

void World::sample_contacts()
{
    if (settings_.contact_ticks == 0 || tick() % settings_.contact_ticks != 0) return;
    wall_N_ = contact_sum_N(link_.read_contacts());
    wall_peak_N_ = std::max(wall_peak_N_, wall_N_);
    has_contacts_ = false; // the views are made when they are asked for
}

// A script's session passes the forces of the walls to the patient itself.
void World::feel()
{
    if (!patient_ || is_led_ || !patient_->can_be_injured() || tick() % Patient::feel_every_ticks != 0)
        return;
    has_contacts_ = false; // the views are made when they are asked for
    if (!patient_->feel(link_.read_contacts())) return;
    nodes();
    patient_->locate(frame_);
}

// --- replay ---

void World::replay(std::shared_ptr<const Recording> recording, std::uint32_t until)
{
    check_free();
    const RecordingHeader &header = recording->header;
    const LineNumbers line = line_or_table(header.line, header.tools.size());
    if (header.scene_bytes != settings_.scene->file().bytes.size() ||
        fingerprint(settings_.scene->file(), header.tools, line, header.entry, header.rig) != fingerprint_)
        throw Refused(COURNAND_BAD_ARGUMENT,
                      "the world does not have the set-up of this recording: use cournand_recording_world()");
    if (header.core_version != core_version_)
        throw Refused(COURNAND_REFUSED, "the recording was made by core version " +
                                            std::to_string(header.core_version) +
                                            ", and the library has version " + std::to_string(core_version_) +
                                            ": use the release that recorded it");
    require(until <= recording->ticks.size(), "the tick is beyond the end of the recording");
    require(until >= tick(), "the tick is before that of the world: make another world");
    if (recorder_) throw Refused(COURNAND_BAD_STATE, "the world is being recorded: end its recording first");
    if (replayed_ != recording) {
        const auto &commands = recording->commands;
        replayed_command_ = static_cast<std::size_t>(
            std::lower_bound(commands.begin(), commands.end(), tick(),
                             [](const RecordedCommand &a, std::uint32_t now) { return a.tick < now; }) -
            commands.begin());
        replayed_ = recording;
    }
    orders_.clear();
    const RecordedSnapshot *snapshot = patient_ ? nullptr : recording->snapshot_before(until);
    if (snapshot && snapshot->tick > tick()) {
        put_device(snapshot->bytes, snapshot->tick);
        state_ = {};
    }
    if (until == tick()) return;
    const std::uint32_t begin = tick();
    const Fill fill = [&](std::uint32_t i, crn_wire_tick_input &input) {
        input = recording->ticks[begin + i].input;
    };
    run(until - begin, {fill, recording.get(), true});
}

void World::pass_recorded(const Recording &recording)
{
    const auto &commands = recording.commands;
    for (; replayed_command_ < commands.size() && commands[replayed_command_].tick <= tick();
         replayed_command_++)
        if (patient_)
            patient_->command(commands[replayed_command_].tick, commands[replayed_command_].command);
}

// In the recorded session, the device was disconnected and came back at this tick with another state, which
// is restored here.
void World::resume_recorded(const Recording &recording)
{
    const RecordedSnapshot *resumed = recording.resumed_at(tick());
    if (resumed) put_device(resumed->bytes, tick());
}

void World::compare(const crn_wire_tick_state &state, const Recording &recording) const
{
    const RecordedTick &recorded = recording.ticks[state.tick - 1];
    if (recorded.hash_lane[0] == state.hash_lane0 && recorded.hash_lane[1] == state.hash_lane1) return;
    const auto text = [](std::uint32_t lane0, std::uint32_t lane1) {
        return hex_text(std::uint64_t{lane0} << 32 | lane1);
    };
    throw Refused(COURNAND_DIFFERENT, "the replay differs first at tick " + std::to_string(state.tick) +
                                          ": hash lanes " + text(state.hash_lane0, state.hash_lane1) +
                                          ", recorded " + text(recorded.hash_lane[0], recorded.hash_lane[1]));
}

void World::put_device(std::span<const std::uint8_t> bytes, std::uint32_t tick)
{
    if (!pipe_.put_snapshot(bytes))
        throw Refused(COURNAND_BAD_SNAPSHOT,
                      "the device refuses the snapshot: it is damaged, or of another set-up");
    link_.continue_at(tick);
    forget_views();
}

void World::settle()
{
    if (!patient_ || is_led_ || patient_->next_look() > tick()) return; // a script's session looks itself
    nodes();
    patient_->look(frame_);
}

} // namespace crn::library
