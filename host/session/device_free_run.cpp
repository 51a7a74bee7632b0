// Runs sessions in FREE_RUN mode: the timer of the device makes the ticks, and the device's encoders measure
// the motion of the hands. The device sends every tick together with its input, so that the recording can be
// replayed in LOCKSTEP bit for bit.
//
// During a disconnection the device continues without the host, and some of its ticks are lost. After a
// disconnection the session returns to the last tick that the host received. The host sets up the device
// again, restores a snapshot, and repeats the inputs since that snapshot in LOCKSTEP, while it compares every
// hash. After the inputs are repeated, FREE_RUN continues, with the present positions of the hands as the new
// reference. The recording contains the state from which FREE_RUN continues after a disconnection.
#include "host/base/interrupt.hpp"
#include "host/link/usb_devices.hpp"
#include "host/session/device.hpp"
#include <algorithm>
#include <utility>

namespace crn
{

namespace
{

constexpr std::uint32_t look_ms = 5;         // the device has read its rig by then
constexpr std::uint32_t silent_max_ms = 500; // without a tick
constexpr std::uint32_t stop_ahead_ticks = 40, stop_limit_ms = 2000;
// With a virtual coupling of 800 N/m, the motors did not oscillate in any of the five situations that
// docs/haptics.md describes.
constexpr std::uint32_t coupling_N_per_m = 800, coupling_uN_m_per_rad = 2000;

// Returns the wanted coupling stiffness, but at most four fifths of the largest stiffness that the device
// accepts. The device accepts a coupling stiffness if (gain, if above one) x stiffness x (half a tick + lag
// of the actuator) <= damping of the track itself.
std::uint32_t passive(std::uint32_t damping, const crn_wire_track &track, std::uint32_t wanted)
{
    const std::uint64_t gain_milli = std::max<std::uint32_t>(track.force_gain_milli, 1000);
    const std::uint64_t stiffest =
        std::uint64_t{damping} * 1'000'000 / (gain_milli * (500 + track.actuator_lag_us));
    return static_cast<std::uint32_t>(std::min<std::uint64_t>(wanted, stiffest * 4 / 5));
}

// Sets the virtual coupling of a track (the part of the rig for one tool), unless the track has a coupling
// already.
void couple(crn_wire_track &track)
{
    if (track.coupling_N_per_m > 0 || track.coupling_uN_m_per_rad > 0) return;
    track.coupling_N_per_m = passive(track.damping_mN_s_per_m, track, coupling_N_per_m);
    track.coupling_uN_m_per_rad = passive(track.damping_nN_m_s_per_rad, track, coupling_uN_m_per_rad);
}

} // namespace

// The rig keeps its own calibration and limits. A track gets a virtual coupling only if its motors can apply
// the resulting forces.
crn_wire_rig Device::free_run_rig(const crn_wire_rig &own) const
{
    crn_wire_rig rig = own;
    bool has_coupling = false;
    for (std::uint16_t k = 0; k < rig.tracks_count; k++) {
        crn_wire_track &track = rig.tracks[k];
        if (choice_.powers_motors) {
            couple(track);
        } else {
            track.coupling_N_per_m = track.coupling_uN_m_per_rad = 0;
            track.coupling_mN_s_per_m = track.coupling_nN_m_s_per_rad = 0;
        }
        has_coupling = has_coupling || track.coupling_N_per_m > 0 || track.coupling_uN_m_per_rad > 0;
    }
    if (choice_.powers_motors && !has_coupling) {
        throw LinkError(
            "the rig does not report the damping of any track, so no safe coupling can be chosen. "
            "Remedy: cournand rig calibrate --load a rig.json with the damping as measured "
            "(docs/haptics.md), or leave --motors out");
    }
    return rig;
}

void Device::start_free_run()
{
    if (!(identity_.capabilities & CRN_WIRE_CAPABILITY_ENCODERS)) {
        throw LinkError(
            "the device has no encoders of its own, so FREE_RUN is impossible. Remedy: attach a rig, "
            "or give a --session");
    }
    crn_wire_stream stream{};
    stream.events = 1;
    stream.nodes_every_ticks = choice_.picture_every_ticks;
    link_->use_free_run();
    link_->set_stream(stream);
    link_->free_run(look_ms);
    if (choice_.powers_motors) link_->arm_motors();
    link_->take_notices();
    link_->start();
    given_tick_ = link_->tick();
    has_hands_ = false;
    silent_ms_ = 0;
}

void Device::give(const crn_wire_live_tick &tick, FreeRunSink &sink)
{
    if (witness_) witness_->tick(tick.input, tick.state);
    given_tick_ = tick.state.tick;
    silent_ms_ = 0;
    if (choice_.may_return()) {
        inputs_.push_back(tick.input);
        hashes_.push_back({tick.state.hash_lane0, tick.state.hash_lane1});
    }
    sink.tick(tick);
    if (snapshot_to_come_.empty() || snapshot_tick_ != given_tick_) return;
    if (witness_) witness_->snapshot(snapshot_tick_, snapshot_to_come_, false);
    sink.snapshot(snapshot_tick_, snapshot_to_come_);
    snapshot_ = std::exchange(snapshot_to_come_, {});
    inputs_.clear();
    hashes_.clear();
}

// Passes on the ticks that the device has sent; returns false if the next tick to be passed on is missing.
bool Device::take_live(FreeRunSink &sink)
{
    std::uint32_t expected = given_tick_ + static_cast<std::uint32_t>(without_hands_.size()) + 1;
    for (const crn_wire_live_tick &tick : link_->live_ticks()) {
        if (tick.state.tick < expected) continue; // given already
        if (tick.state.tick > expected) return false;
        expected++;
        has_hands_ = has_hands_ || (tick.flags & CRN_WIRE_LIVE_HANDS) != 0;
        if (!has_hands_) {
            silent_ms_ = 0;
            without_hands_.push_back(tick);
            continue;
        }
        // Before the device has read its encoders for the first time, nothing moves. A replay takes the first
        // encoder reading as the reference, so the ticks before it are recorded with that reading too.
        for (crn_wire_live_tick &early : without_hands_) {
            early.input = tick.input;
            give(early, sink);
        }
        without_hands_.clear();
        give(tick, sink);
    }
    return true;
}

// Waits for a snapshot of the device's state.
void Device::ask_snapshot()
{
    if (!choice_.may_return() || inputs_.size() < free_run_kept_max || !snapshot_to_come_.empty()) return;
    snapshot_to_come_ = link_->read_snapshot();
    crn_wire_reader reader = crn_wire_reader_make(snapshot_to_come_.data(), snapshot_to_come_.size());
    crn_wire_read(&reader, 4);
    snapshot_tick_ = static_cast<std::uint32_t>(crn_wire_read(&reader, 4));
    if (snapshot_tick_ <= given_tick_)
        snapshot_to_come_.clear(); // no tick came since; the next snapshot serves
}

void Device::check_running(FreeRunSink &sink)
{
    bool is_changed = silent_ms_ > silent_max_ms;
    for (const crn_wire_notice &notice : link_->take_notices())
        is_changed = is_changed || notice.kind == CRN_WIRE_EVENT_STATE;
    if (!is_changed) return;
    const crn_wire_status status = link_->read_status();
    if (status.state == CRN_WIRE_STATE_RUNNING && silent_ms_ <= silent_max_ms) return;
    link_->free_run(look_ms); // ticks that were still in transit
    take_live(sink);
    const std::string at = " at tick " + std::to_string(given_tick_);
    if (status.state == CRN_WIRE_STATE_FAULT) {
        throw LinkError("the rig stopped" + at + ": " + crn_wire_fault_name(status.fault_code) + ": " +
                        crn_wire_fault_text(status.fault_code) +
                        ". Remedy: " + crn_wire_fault_remedy(status.fault_code));
    }
    throw LinkError("the rig makes no more ticks" + at + "; it is " + crn_wire_state_name(status.state) +
                    ". Remedy: begin the session again; another program may have stopped it");
}

void Device::resume_free(FreeRunSink &sink)
{
    std::uint32_t attempt = 0;
    without_hands_.clear();
    snapshot_to_come_.clear();
    for (;;) {
        try {
            resume();
            link_->stop();
            link_->use_free_run();
            const std::vector<std::uint8_t> state = link_->read_snapshot();
            if (witness_) witness_->snapshot(given_tick_, state, false);
            snapshot_ = state;
            inputs_.clear();
            hashes_.clear();
            sink.resumed(given_tick_, state);
            start_free_run();
            return;
        } catch (const DeviceLost &) {
            if (is_interrupted() || ++attempt >= resumes_max) throw;
        }
    }
}

void Device::run_free(std::uint32_t milliseconds, FreeRunSink &sink)
{
    if (!pipe_)
        throw LinkError("the device was disconnected, and the session is lost. Remedy: begin it again");
    bool is_whole = true;
    try {
        ask_snapshot();
        link_->free_run(milliseconds);
        silent_ms_ += milliseconds;
        is_whole = take_live(sink);
        if (is_whole) check_running(sink);
    } catch (const DeviceLost &) {
        take_live(sink);
        if (!choice_.may_return() || is_interrupted()) throw;
        pipe_.reset();
        is_whole = false;
    }
    if (is_whole) return;
    if (!choice_.may_return())
        throw LinkError("ticks after tick " + std::to_string(given_tick_) + " were lost on the way");
    resume_free(sink);
}

void Device::stop_free(FreeRunSink &sink)
{
    const std::uint32_t last = link_->read_status().tick + stop_ahead_ticks;
    link_->stop_at(last);
    for (std::uint32_t ms = 0; ms < stop_limit_ms && given_tick_ < last; ms += look_ms) {
        link_->free_run(look_ms);
        if (!take_live(sink)) break;
    }
    for (crn_wire_live_tick &tick : without_hands_) give(tick, sink);
    without_hands_.clear();
    if (given_tick_ != last)
        throw LinkError("the rig's last ticks did not come; the recording is complete up to tick " +
                        std::to_string(given_tick_));
}

} // namespace crn
