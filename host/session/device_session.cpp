// Implements the class Device: opens and sets up the device, steps it, and continues after the device
// disappeared and returned.
#include "host/base/interrupt.hpp"
#include "host/link/usb_devices.hpp"
#include "host/session/device.hpp"
#include "host/session/set_up.hpp"
#include <algorithm>
#include <cstdio>

namespace crn
{

namespace
{

// A force or torque limit of a rig can only be lowered, so the host requests no limit above the device's own.
crn_wire_rig within_limits(crn_wire_rig rig, const crn_wire_rig &present)
{
    for (std::uint16_t k = 0; k < std::min(rig.tracks_count, present.tracks_count); k++) {
        rig.tracks[k].force_limit_mN =
            std::min(rig.tracks[k].force_limit_mN, present.tracks[k].force_limit_mN);
        rig.tracks[k].torque_limit_uN_m =
            std::min(rig.tracks[k].torque_limit_uN_m, present.tracks[k].torque_limit_uN_m);
    }
    return rig;
}

} // namespace

void Device::open()
{
    pipe_ = open_device(choice_);
    link_.emplace(*pipe_);
    const crn_wire_hello_reply reply = link_->hello();
    check_identity(reply);
    if (has_started_ && (reply.core_version != identity_.core_version ||
                         !std::equal(reply.serial, reply.serial + reply.serial_count, identity_.serial,
                                     identity_.serial + identity_.serial_count))) {
        throw LinkError("another device has replaced the disconnected one; the session cannot continue. "
                        "Remedy: begin it again; the recording is complete up to where it stopped");
    }
    identity_ = reply;
    if (link_->read_status().state != CRN_WIRE_STATE_READY) link_->reset();
    if (has_started_) return;
    rig_before_ = link_->read_rig();
    if (choice_.free_run) {
        rig_ = free_run_rig(rig_before_);
    } else if (choice_.is_usb) {
        rig_ = within_limits(rig_, rig_before_);
    }
}

// A recording contains the device's versions of core and protocol schema; only a host of these versions can
// replay the recording.
void Device::check_identity(const crn_wire_hello_reply &reply) const
{
    if (!choice_.may_return()) return;
    const std::uint32_t own = own_core_version();
    if (reply.core_version == own && reply.schema_hash == crn_wire_schema_hash()) return;
    throw LinkError(
        pipe_->name() + " computes with core version " + std::to_string(reply.core_version) +
        (reply.core_version == own ? " of another schema" : "") + ", this host has version " +
        std::to_string(own) +
        ": its session could neither be checked nor replayed here. Remedy: install the same release "
        "on both");
}

// A device in this process already uses this machine's core, so no second computation (class Witness) needs
// to check its results.
void Device::call_witness()
{
    if (!choice_.may_return()) return;
    witness_ = std::make_unique<Witness>(scene_, tools_, line_, entry_, rig_, pipe_->name());
}

void Device::set_up()
{
    set_up_session(*link_, {scene_, tools_, line_, entry_, rig_});
}

Device::~Device()
{
    leave();
}

void Device::leave()
{
    if (!choice_.may_return() || !pipe_ || !has_started_) return;
    try {
        link_->reset();
        if (choice_.free_run) {
            link_->set_stream({});
            link_->use_lockstep();
        }
        link_->set_rig(rig_before_);
    } catch (const std::exception &) {
        // If the device has disappeared or refuses a request, the error is ignored, because the next user of
        // the device sets it up anyway.
    }
}

void Device::restore(std::span<const std::uint8_t> snapshot)
{
    link_->stop();
    link_->write_snapshot(snapshot);
    link_->start();
    snapshot_.assign(snapshot.begin(), snapshot.end());
    inputs_.clear();
    hashes_.clear();
    if (witness_) witness_->restore(snapshot);
}

// --- verification ---

Hash64 Device::read_hash64()
{
    Hash64 hash;
    ask([&](Link &link) { hash = link.read_hash64(); });
    if (witness_ && hash.tick != witness_->tick()) {
        throw LinkError(pipe_->name() + " gives the hash of tick " + std::to_string(hash.tick) +
                        ", not of tick " + std::to_string(witness_->tick()) +
                        ". Remedy: install the same release on both");
    }
    if (witness_) witness_->hash(hash);
    return hash;
}

std::optional<Hash64> Device::last_hash64()
{
    const std::optional<Hash64> hash = link_->last_hash64();
    if (!witness_ || !hash || (hash_ && hash_->tick == hash->tick && hash_->hash == hash->hash)) return hash;
    // In FREE_RUN a hash may arrive before the ticks to which it belongs.
    if (choice_.free_run && hash->tick > witness_->tick()) return hash_;
    witness_->hash(*hash);
    hash_ = hash;
    return hash;
}

std::vector<std::uint8_t> Device::read_snapshot()
{
    std::vector<std::uint8_t> snapshot;
    ask([&](Link &link) { snapshot = link.read_snapshot(); });
    if (witness_) witness_->snapshot(link_->tick(), snapshot, true);
    return snapshot;
}

// --- resuming ---

// A device in this process cannot disappear, so no snapshot or input is kept for it.
void Device::keep_up()
{
    if (!choice_.may_return() || inputs_.size() < inputs_kept_max) return;
    snapshot_ = link_->read_snapshot();
    inputs_.clear();
    hashes_.clear();
}

void Device::go_back_to_snapshot()
{
    if (!snapshot_.empty()) {
        link_->stop();
        link_->write_snapshot(snapshot_);
        link_->start();
    }
    for (std::size_t done = 0; done < inputs_.size();) {
        const std::size_t count = std::min(Link::steps_max, inputs_.size() - done);
        const auto states = link_->step(std::span(inputs_).subspan(done, count), false);
        for (const crn_wire_tick_state &state : states) {
            const Hash &before = hashes_[done++];
            if (state.hash_lane0 == before.lane0 && state.hash_lane1 == before.lane1) continue;
            throw LinkError("the device came back and does not repeat the session: tick " +
                            std::to_string(state.tick) +
                            " has another hash. Remedy: begin it again; report the recording, which is "
                            "complete up to the disconnection");
        }
    }
}

// If a device disappears again and again, the session must end after a limited number of returns.
void Device::count_resume(std::uint32_t tick)
{
    if (resumes_here_ == 0 || tick >= resumes_from_tick_ + resumes_within_ticks) {
        resumes_here_ = 0;
        resumes_from_tick_ = tick;
    }
    if (resumes_here_++ == resumes_max) {
        throw LinkError("the device went away " + std::to_string(resumes_max) + " times within " +
                        std::to_string(resumes_within_ticks) + " ticks, up to tick " + std::to_string(tick) +
                        ". Remedy: check cable and power, then begin the session again; the recording is "
                        "complete up to that tick");
    }
    resumes_++;
}

void Device::resume()
{
    const std::uint32_t tick = choice_.free_run ? given_tick_ : link_->tick();
    count_resume(tick);
    std::fprintf(stderr, "cournand: the device went away at tick %u; waiting up to %u s for it\n",
                 unsigned{tick}, unsigned{choice_.return_limit_ms / 1000});
    pipe_.reset(); // the Link holds a reference to it, and is replaced before its next use
    if (!wait_for_device(choice_)) {
        throw LinkError("the device went away at tick " + std::to_string(tick) +
                        " and did not come back. Remedy: check cable and power, then begin the session "
                        "again; the recording is complete up to that tick");
    }
    open();
    set_up();
    go_back_to_snapshot();
    std::fprintf(stderr, "cournand: the device is back, and the session continues at tick %u\n",
                 unsigned{link_->tick()});
}

void Device::ask(const std::function<void(Link &)> &request)
{
    bool has_link = true;
    if (!pipe_)
        throw LinkError("the device was disconnected, and the session is lost. Remedy: begin it again");
    for (std::uint32_t attempt = 0;; attempt++) {
        try {
            if (!has_link) resume();
            has_link = true;
            request(*link_);
            return;
        } catch (const DeviceLost &) {
            if (!choice_.may_return() || is_interrupted() || attempt >= resumes_max) throw;
            has_link = false;
        }
    }
}

std::span<const crn_wire_tick_state> Device::step(std::span<const crn_wire_tick_input> inputs,
                                                  bool want_nodes)
{
    std::span<const crn_wire_tick_state> states;
    ask([&](Link &link) {
        keep_up();
        states = link.step(inputs, want_nodes);
    });
    if (witness_) witness_->step(inputs, states, want_nodes ? &link_->nodes() : nullptr);
    if (choice_.may_return()) {
        inputs_.insert(inputs_.end(), inputs.begin(), inputs.end());
        for (const crn_wire_tick_state &state : states)
            hashes_.push_back({state.hash_lane0, state.hash_lane1});
    }
    return states;
}

} // namespace crn
