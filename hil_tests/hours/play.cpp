#include "hil_tests/hours/play.hpp"
#include "hil_tests/cases/conversation.hpp"
#include "hil_tests/hours/twin.hpp"
#include "hil_tests/soak/dice.hpp"
#include "hil_tests/soak/draw.hpp"
#include "host/base/interrupt.hpp"
#include "host/link/link.hpp"
#include "host/link/sim_transport.hpp"
#include "host/model/units.hpp"
#include "host/script/hand_motion.hpp"
#include "host/script/session.hpp"
#include "host/session/run.hpp"
#include <algorithm>
#include <optional>

namespace hours
{

namespace
{

constexpr std::uint32_t host_every_ms = 8, picture_every_ticks = 33, fault_lasts_ms = 300,
                        stop_ahead_ticks = 24, stop_limit_ms = 200, settle_ms = 3;
constexpr int arms_max = 3;
constexpr double two_pi = 6.283185307179586;

struct Fault {
    const char *name;
    std::uint16_t code; // 0: the session goes on, or the conversation ends
};

constexpr Fault faults[] = {
    {"none", 0},
    {"stop_button", CRN_FAULT_CODE_EMERGENCY_STOP},
    {"supply", CRN_FAULT_CODE_SUPPLY_LOST},
    {"encoder", CRN_FAULT_CODE_ENCODER_LOST},
    {"force_sensor", CRN_FAULT_CODE_FORCE_SENSOR_LOST},
    {"stall", CRN_FAULT_CODE_TICK_STALLED},
    {"silence", 0},
    {"cable", 0},
    {"power", 0},
};
static_assert(std::size(faults) == static_cast<std::size_t>(Disturbance::count));

const Fault &fault_of(Disturbance disturbance)
{
    return faults[static_cast<std::size_t>(disturbance)];
}

class Player
{
  public:
    Player(Station &station, const soak::Catalogue &catalogue, const Plan &plan)
        : station_(station), plan_(plan), scene_(catalogue.scene(plan.drawn.scene)),
          script_(crn::parse_session(soak::script_of(plan.drawn), soak::name_of(plan.drawn))),
          link_(station.pipe())
    {
        for (const std::string &path : plan.drawn.tools) {
            tools_.push_back(catalogue.tool(path).instrument);
            tables_.push_back(tools_.back().table);
        }
        entry_ = crn::entry_of(scene_.file, tools_.size(), script_.inserted_um);
    }

    Played play()
    {
        greet();
        run(plan_.disturbance);
        if (plan_.disturbance != Disturbance::none) run(Disturbance::none);
        played_.faults_unplanned = faults_unplanned_;
        return played_;
    }

  private:
    // --- set-up ---

    void greet()
    {
        link_.hello();
        if (link_.read_status().state != CRN_WIRE_STATE_READY) link_.reset();
        link_.load_scene(scene_.file.bytes, scene_.file.crc32);
        link_.load_tools(tables_);
        link_.set_entry(entry_);
        link_.set_rig(hil::plant_rig());
        crn_wire_stream stream{};
        stream.events = 1;
        stream.nodes_every_ticks = picture_every_ticks;
        link_.set_stream(stream);
    }

    void start()
    {
        if (plan_.wraps_encoders) wrap_encoders();
        for (int k = 0; !is_armed(); k++) {
            hil::check(k < arms_max, "the device cannot be armed: %s", played_.why_unplanned.c_str());
            station_.pass_ms(fault_lasts_ms);
        }
        link_.arm_motors();
        link_.take_notices();
        twin_.reset();
        if (plan_.is_repeated) twin_.emplace(scene_.file, tools_, entry_);
        link_.start();
        tick_ = 0;
        tick_given_ = 0;
        played_.runs++;
    }

    // A force that is left from the run before may be a fault (ACTUATOR_STUCK_ON) of the armed device; a
    // person waits and arms it again.
    bool is_armed()
    {
        link_.reset();
        link_.use_free_run();
        link_.arm();
        played_.arms++;
        station_.pass_ms(settle_ms); // the device has sampled the rig
        const crn_wire_status status = link_.read_status();
        if (status.state == CRN_WIRE_STATE_FAULT) note_unplanned(status);
        return status.state == CRN_WIRE_STATE_ARMED;
    }

    void note_unplanned(const crn_wire_status &status)
    {
        played_.faults++;
        faults_unplanned_++;
        played_.why_unplanned = crn_wire_fault_name(status.fault_code);
    }

    // A counter that stands a few millimetres before its end passes it during the session.
    void wrap_encoders()
    {
        constexpr std::int64_t end = INT64_C(1) << 31, before = 20000;
        for (std::size_t k = 0; k < tools_.size(); k++) {
            hil::Plant::Track &track = station_.plant().track(static_cast<int>(k));
            for (hil::Encoder *encoder : {&track.translation_encoder, &track.rotation_encoder})
                encoder->set_fault(hil::SensorFault::jump, end - before - encoder->counts());
            for (hil::Encoder *encoder : {&track.translation_encoder, &track.rotation_encoder})
                encoder->set_fault(hil::SensorFault::none);
        }
        station_.pass_ms(settle_ms);
    }

    // --- one run ---

    void run(Disturbance disturbance)
    {
        start();
        is_stopped_ = false;
        player_.emplace(script_, tools_.size());
        for (crn_wire_hand &hand : before_) hand = {};
        for (std::uint32_t ms = 0; ms < plan_.run_ms && !is_stopped_; ms++) {
            if (disturbance != Disturbance::none && ms == plan_.disturb_ms) {
                talk(); // a fault of the last few milliseconds comes before the disturbance
                if (is_stopped_) break;
                if (!disturb(disturbance)) return;
                continue;
            }
            if (crn::is_interrupted()) throw crn::LinkError("interrupted");
            move_hands();
            station_.pass_ms(1);
            if (ms % host_every_ms == 0) talk();
        }
        rest_hands();
        if (!is_stopped_) talk();
        if (is_stopped_)
            recover(0);
        else
            stop();
    }

    void move_hands()
    {
        if (player_->is_done()) {
            player_.emplace(script_, tools_.size());
            for (crn_wire_hand &hand : before_) hand = {};
        }
        const crn_wire_tick_input input = player_->next();
        hil::Plant &plant = station_.plant();
        for (std::size_t k = 0; k < tools_.size(); k++) {
            const crn_wire_hand &hand = input.hands[k];
            hil::Plant::Track &track = plant.track(static_cast<int>(k));
            track.translation.move_hand((hand.translation_counts - before_[k].translation_counts) * 1e3 /
                                        crn::counts_per_m);
            track.rotation.move_hand((hand.rotation_counts - before_[k].rotation_counts) * 1e3 * two_pi /
                                     crn::counts_per_turn);
            before_[k] = hand;
        }
        plant.inflator_raw = input.inflator_raw;
        plant.buttons = input.buttons;
        crn::send_orders(link_, input.orders);
    }

    void rest_hands()
    {
        for (int k = 0; k < CRN_PORT_TOOL_MAX; k++) {
            station_.plant().track(k).translation.move_hand(0.0);
            station_.plant().track(k).rotation.move_hand(0.0);
        }
    }

    // Says that the host is there, takes the ticks that have come, and shows the script where its tools are.
    void talk()
    {
        crn_wire_tick_input present{};
        present.hands_count = static_cast<std::uint16_t>(tools_.size());
        link_.send_input(present);
        link_.free_run(0);
        take_ticks();
        for (const crn_wire_notice &notice : link_.take_notices())
            is_stopped_ =
                is_stopped_ || (notice.kind == CRN_WIRE_EVENT_STATE && notice.code == CRN_WIRE_STATE_FAULT);
    }

    void take_ticks()
    {
        double inserted_m[crn::session_tools_max] = {};
        for (const crn_wire_live_tick &tick : link_.live_ticks()) {
            if (tick.state.tick <= tick_) continue;
            hil::check(tick.state.tick == tick_ + 1, "tick %u follows tick %u in the stream",
                       unsigned{tick.state.tick}, unsigned{tick_});
            tick_ = tick.state.tick;
            played_.live_ticks++;
            played_.late_ticks += (tick.flags & CRN_WIRE_LIVE_LATE) != 0;
            if (twin_) twin_->take(tick);
            for (std::size_t k = 0; k < tools_.size(); k++)
                inserted_m[k] = crn::units::metres(tick.state.tools[k].inserted_m_q30);
        }
        if (tick_ / crn::SessionPlayer::observe_every_ticks == tick_given_) return;
        tick_given_ = tick_ / crn::SessionPlayer::observe_every_ticks;
        player_->observe({inserted_m, tools_.size()});
    }

    // --- ends ---

    void stop()
    {
        crn_wire_status status = link_.stop_at(status_tick() + stop_ahead_ticks);
        for (std::uint32_t ms = 0; status.state == CRN_WIRE_STATE_RUNNING; ms += host_every_ms) {
            hil::check(ms < stop_limit_ms, "the device does not stop at its tick");
            station_.pass_ms(host_every_ms);
            status = link_.read_status();
        }
        finish_run(status);
    }

    std::uint32_t status_tick() { return link_.read_status().tick; }

    void finish_run(const crn_wire_status &status)
    {
        link_.free_run(1); // the last ticks
        take_ticks();
        hil::check(tick_ == status.tick, "the device did %u ticks, and %u arrived", unsigned{status.tick},
                   unsigned{tick_});
        played_.ticks += status.tick;
        if (status.state != CRN_WIRE_STATE_ARMED) {
            if (twin_) played_.repeated_ticks += twin_->finish(std::nullopt);
            return;
        }
        played_.hash = link_.read_hash64().hash;
        if (twin_) played_.repeated_ticks += twin_->finish(played_.hash);
    }

    // The device is in the state FAULT by itself. `code`: by this fault; 0: nobody caused it.
    void recover(std::uint16_t code)
    {
        const crn_wire_status status = link_.read_status();
        hil::check(status.state == CRN_WIRE_STATE_FAULT, "after %s the device is %s",
                   name_of(plan_.disturbance), crn_wire_state_name(status.state));
        if (code == 0) {
            note_unplanned(status);
        } else {
            played_.faults++;
            const std::string found = crn_wire_fault_name(status.fault_code);
            hil::check(status.fault_code == code, "%s led to the fault %s", name_of(plan_.disturbance),
                       found.c_str());
        }
        finish_run(status);
        link_.reset();
    }

    // --- disturbances: false if the run is over ---

    bool disturb(Disturbance disturbance)
    {
        hil::Plant &plant = station_.plant();
        hil::Plant::Track &track = plant.track(0);
        switch (disturbance) {
        case Disturbance::stop_button:
            plant.emergency_stop = true;
            break;
        case Disturbance::supply:
            plant.supply_good = false;
            break;
        case Disturbance::encoder:
            track.translation_encoder.set_fault(hil::SensorFault::silent);
            break;
        case Disturbance::force_sensor:
            track.force_fault = hil::SensorFault::range;
            break;
        case Disturbance::stall:
            rest_hands();
            station_.stall(plan_.disturbed_ms);
            break;
        case Disturbance::silence:
            rest_hands();
            station_.pass_ms(plan_.disturbed_ms);
            talk();
            return true;
        case Disturbance::cable:
            return lose_cable();
        case Disturbance::power:
            return lose_power();
        default:
            return true;
        }
        rest_hands();
        station_.pass_ms(fault_lasts_ms);
        plant.emergency_stop = false;
        plant.supply_good = true;
        track.translation_encoder.set_fault(hil::SensorFault::none);
        track.force_fault = hil::SensorFault::none;
        station_.pass_ms(fault_lasts_ms);
        recover(fault_of(disturbance).code);
        return false;
    }

    // Ticks from while the cable is out may be lost; the device must know how many it did.
    bool lose_cable()
    {
        rest_hands();
        talk();
        station_.pull_cable(plan_.disturbed_ms);
        link_.hello();
        const crn_wire_status status = link_.read_status();
        hil::check(status.state == CRN_WIRE_STATE_RUNNING, "without a cable the device went to the state %s",
                   crn_wire_state_name(status.state));
        played_.ticks += link_.stop().tick;
        if (twin_) played_.repeated_ticks += twin_->finish(std::nullopt);
        greet();
        return false;
    }

    bool lose_power()
    {
        rest_hands();
        talk();
        const std::uint32_t ticks = link_.read_status().tick;
        station_.restart(plan_.disturbed_ms);
        played_.ticks += ticks; // no edge comes between the answer and the loss
        if (twin_) played_.repeated_ticks += twin_->finish(std::nullopt);
        greet();
        return false;
    }

    Station &station_;
    const Plan &plan_;
    const soak::SoakScene &scene_;
    const crn::Session script_;
    std::vector<crn::Instrument> tools_;
    std::vector<crn_wire_instrument> tables_;
    crn_wire_entry entry_{};
    crn::Link link_;
    std::optional<crn::SessionPlayer> player_;
    std::optional<Twin> twin_;
    crn_wire_hand before_[crn::session_tools_max] = {};
    std::uint32_t tick_ = 0, tick_given_ = 0, faults_unplanned_ = 0;
    bool is_stopped_ = false;
    Played played_;
};

} // namespace

const char *name_of(Disturbance disturbance)
{
    return fault_of(disturbance).name;
}

void coarsen(soak::Catalogue &catalogue, std::uint32_t element_um)
{
    for (soak::SoakTool &tool : catalogue.tools) {
        crn_wire_instrument &table = tool.instrument.table;
        table.element_shaft_um = std::max(table.element_shaft_um, crn_wire_u32{element_um});
        table.element_tip_um = std::max(table.element_tip_um, crn_wire_u32{element_um} / 2);
    }
    crn::SimTransport pipe(0);
    crn::Link link(pipe);
    link.hello();
    std::erase_if(catalogue.sets, [&](const std::vector<std::size_t> &set) {
        std::vector<crn_wire_instrument> tables;
        for (std::size_t k : set) tables.push_back(catalogue.tools[k].instrument.table);
        try {
            link.load_tools(tables);
            return false;
        } catch (const crn::LinkError &) {
            return true;
        }
    });
}

Plan draw_plan(const soak::Catalogue &catalogue, std::uint64_t seed, std::uint32_t index,
               std::uint32_t seconds_max)
{
    // Every `repeated_every`-th session has a twin; a session that lasts for a long time has none.
    constexpr std::uint32_t repeated_every = 50, tries = 128;
    constexpr int disturbed_pct = 60, seconds_min = 5;
    soak::Dice dice(seed ^ 0x5ca1ab1e, index);
    Plan plan;
    // Most sessions have one tool, because a tick with one tool is the cheapest.
    const std::size_t tools = 1 + dice.weighted({85, 12, 3});
    for (std::uint32_t i = 0; i < tries && plan.drawn.tools.size() != tools; i++)
        plan.drawn = soak::draw_session(catalogue, seed, index * tries + i);
    if (dice.chance(disturbed_pct))
        plan.disturbance =
            static_cast<Disturbance>(dice.between(1, static_cast<int>(Disturbance::count) - 1));
    const int seconds = dice.between(seconds_min, std::max<int>(seconds_min, static_cast<int>(seconds_max)));
    plan.run_ms = static_cast<std::uint32_t>(seconds) * 1000;
    plan.disturb_ms = static_cast<std::uint32_t>(dice.between(500, seconds * 1000 - 1));
    plan.disturbed_ms = static_cast<std::uint32_t>(
        plan.disturbance == Disturbance::stall ? dice.between(7, 40) : dice.between(50, 1500));
    plan.wraps_encoders = dice.chance(20);
    plan.is_repeated = index % repeated_every == 0;
    return plan;
}

Played play(Station &station, const soak::Catalogue &catalogue, const Plan &plan)
{
    return Player(station, catalogue, plan).play();
}

} // namespace hours
