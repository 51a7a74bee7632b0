#include "hil_tests/campaign/judge.hpp"
#include "hil_tests/plant/random.hpp"
#include "host/model/instrument.hpp"
#include "shared/wire/wire_frame.h"

namespace hil
{

namespace
{

crn_wire_instrument short_wire()
{
    crn_wire_instrument wire = crn::read_instrument("shared/examples/instruments/j_wire.toml").table;
    crn_wire_knot shaft = wire.knots[wire.knots_count - 1];
    shaft.rest_curvature1_per_m_milli = shaft.rest_curvature2_per_m_milli = 0;
    wire.knots_count = 2;
    wire.knots[0] = wire.knots[1] = shaft;
    wire.knots[0].arc_um = 0;
    wire.knots[1].arc_um = 240000;
    wire.element_tip_um = wire.element_shaft_um = 8000;
    wire.element_fine_um = 0;
    return wire;
}

// Sends a message in a valid frame, although no host of this project would send this message.
void send_raw(crn::Transport &pipe, std::uint16_t type, std::span<const std::uint8_t> payload)
{
    const crn_wire_header header = {1, 0, type};
    std::vector<std::uint8_t> frame(CRN_WIRE_FRAME_MAX);
    frame.resize(crn_wire_frame_encode(&header, payload.data(), payload.size(), frame.data(), frame.size()));
    pipe.write(frame);
}

void send_hello(crn::Transport &pipe, std::uint64_t schema)
{
    const crn_wire_hello hello = {CRN_WIRE_PROTOCOL_MAJOR, CRN_WIRE_PROTOCOL_MINOR, schema};
    std::uint8_t payload[CRN_WIRE_BYTES_hello];
    crn_wire_writer writer = crn_wire_writer_make(payload, sizeof payload);
    crn_wire_put_hello(&writer, &hello);
    send_raw(pipe, CRN_WIRE_TYPE_hello, {payload, writer.length});
}

void send_hostile(crn::Transport &pipe, std::uint32_t message, Random &random)
{
    static constexpr std::uint16_t types[hostile_types] = {
        CRN_WIRE_TYPE_scene_begin,    CRN_WIRE_TYPE_scene_chunk,
        CRN_WIRE_TYPE_scene_end,      CRN_WIRE_TYPE_tools,
        CRN_WIRE_TYPE_entry,          CRN_WIRE_TYPE_rig,
        CRN_WIRE_TYPE_step,           CRN_WIRE_TYPE_input,
        CRN_WIRE_TYPE_stream,         CRN_WIRE_TYPE_get,
        CRN_WIRE_TYPE_snapshot_begin, CRN_WIRE_TYPE_snapshot_chunk,
        CRN_WIRE_TYPE_snapshot_end,   0x7777};
    std::vector<std::uint8_t> payload(random.below(700));
    for (std::uint8_t &byte : payload) byte = static_cast<std::uint8_t>(random.next());
    send_raw(pipe, types[message % hostile_types], payload);
}

} // namespace

const char *name_of(SafeClass which)
{
    static constexpr const char *names[safe_classes] = {"no power at stake",      "host silent or cut off",
                                                        "sensors, forces, stop",  "supply",
                                                        "processor stands still", "told by a host"};
    return names[static_cast<std::size_t>(which)];
}

int bar_ms(SafeClass which)
{
    if (which == SafeClass::processor)
        return 8; // the stage drops power after 5 ms by itself, and the current decays
    return which == SafeClass::host_silence ? 50 : 5;
}

// If the fault is a motor that no longer obeys the firmware, only the motor driver's current limit, which the
// builder of the rig sets, limits the force. For all faults except a stuck motor, the driver's current limit
// corresponds to 1.5 times the firmware's force limit, so the firmware's limit acts first.
PlantSettings campaign_plant(bool has_stuck_motor)
{
    const double above = has_stuck_motor ? 1.0 : 1.5;
    PlantSettings settings;
    settings.translation.motor_limit = above * force_limit_N;
    settings.rotation.motor_limit = above * torque_limit_N_m;
    return settings;
}

void campaign_set_up(crn::Link &link)
{
    static const crn_wire_instrument wire = short_wire();
    link.hello();
    if (link.read_status().state != CRN_WIRE_STATE_READY) link.reset();
    link.load_scene(tube_scene());
    link.load_tools({&wire, 1});
    crn_wire_entry entry{};
    entry.direction_x_q30 = 1 << 30;
    entry.inserted_um_count = 1;
    entry.inserted_um[0] = 30000;
    link.set_entry(entry);
    crn_wire_rig rig = plant_rig();
    for (crn_wire_track &track : rig.tracks) {
        track.seal_mN = 2000; // the seal holds the wire, so that a push is felt at once
        track.seal_uN_m = 1000;
    }
    link.set_rig(rig);
}

bool same_state(const crn_wire_tick_state &a, const crn_wire_tick_state &b)
{
    return a.tick == b.tick && a.hash_lane0 == b.hash_lane0 && a.hash_lane1 == b.hash_lane1;
}

void strange_host(const Fault &fault, crn::Transport &pipe)
{
    Random random(fault.seed * 1009u + fault.at * 31u + fault.value);
    if (fault.is("host.hostile")) {
        send_hostile(pipe, fault.value, random);
        return;
    }
    if (fault.is("host.wrong_schema")) {
        send_hello(pipe, random.next());
        return;
    }
    send_hello(pipe, crn_wire_schema_hash());
    static constexpr std::uint8_t actions[second_actions] = {0,
                                                             CRN_WIRE_ACTION_ARM,
                                                             CRN_WIRE_ACTION_START,
                                                             CRN_WIRE_ACTION_STOP,
                                                             CRN_WIRE_ACTION_RESET,
                                                             CRN_WIRE_ACTION_FREE_RUN,
                                                             CRN_WIRE_ACTION_CONFIRM};
    const std::uint8_t action = actions[fault.value % second_actions];
    const std::uint8_t payload[CRN_WIRE_BYTES_command] = {action};
    if (action != 0) send_raw(pipe, CRN_WIRE_TYPE_command, payload);
}

Undisturbed run_undisturbed(Level &level)
{
    Undisturbed undisturbed;
    const auto bench = level.make(campaign_plant());
    crn::Link link(bench->pipe());
    campaign_set_up(link);
    const Ending ending = lockstep_session(link, lockstep_ticks, 1);
    undisturbed.lockstep = ending.states;
    undisturbed.lockstep_hash = ending.hash;
    free_run_undisturbed(level, undisturbed);
    return undisturbed;
}

Outcome run_fault(Level &level, const Fault &fault, const Undisturbed &undisturbed)
{
    Outcome outcome;
    try {
        if (fault.session == Session::free_run)
            run_free(level, fault, undisturbed, outcome);
        else
            run_asked(level, fault, undisturbed, outcome);
    } catch (const std::exception &error) {
        outcome.failure = error.what();
    }
    return outcome;
}

} // namespace hil
