// What a Device does while a session runs: open, set up, step, and go on after the device went and came back.
#include "host/app/device.hpp"
#include "host/app/interrupt.hpp"
#include "host/link/usb_devices.hpp"
#include <algorithm>
#include <cstdio>

namespace seld
{

namespace
{

// Limits go down only, so a host asks for no more than the device has.
seld_wire_rig within_limits(seld_wire_rig rig, const seld_wire_rig &present)
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
    const seld_wire_hello_reply reply = link_->hello();
    if (has_started_ && (reply.core_version != identity_.core_version ||
                         !std::equal(reply.serial, reply.serial + reply.serial_count, identity_.serial,
                                     identity_.serial + identity_.serial_count))) {
        throw LinkError("another device came in the place of the one that went; the session cannot go on. "
                        "Remedy: begin it again; the recording is complete up to where it stopped");
    }
    identity_ = reply;
    if (link_->read_status().state != SELD_WIRE_STATE_READY) link_->reset();
    if (has_started_) return;
    rig_before_ = link_->read_rig();
    if (choice_.free_run) {
        rig_ = free_run_rig(rig_before_);
    } else if (choice_.is_usb) {
        rig_ = within_limits(rig_, rig_before_);
    }
}

void Device::set_up()
{
    std::vector<seld_wire_instrument> tables;
    for (const Instrument &tool : tools_) tables.push_back(tool.table);
    link_->load_scene(scene_.bytes);
    link_->load_tools(tables);
    link_->set_entry(entry_);
    link_->set_rig(rig_);
    link_->use_lockstep();
    link_->arm();
    link_->start();
}

Device::~Device()
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
        // The device is gone or refuses; whoever uses it next sets it up anyway.
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
}

// --- going on ---

// A device in this process does not go away, so nothing is kept for it.
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
        for (const seld_wire_tick_state &state : states) {
            const Hash &before = hashes_[done++];
            if (state.hash_lane0 == before.lane0 && state.hash_lane1 == before.lane1) continue;
            throw LinkError("the device came back and does not repeat the session: tick " +
                            std::to_string(state.tick) +
                            " has another hash. Remedy: begin it again; report the recording, which is "
                            "complete up to where the device went");
        }
    }
}

void Device::resume()
{
    const std::uint32_t tick = choice_.free_run ? given_tick_ : link_->tick();
    resumes_++;
    std::fprintf(stderr, "seldinger: the device went away at tick %u; waiting up to %u s for it\n",
                 unsigned{tick}, unsigned{choice_.return_limit_ms / 1000});
    pipe_.reset(); // Link holds a reference to it and is replaced before it is used again
    if (!wait_for_device(choice_)) {
        throw LinkError("the device went away at tick " + std::to_string(tick) +
                        " and did not come back. Remedy: check cable and power, then begin the session "
                        "again; the recording is complete up to that tick");
    }
    open();
    set_up();
    go_back_to_snapshot();
    std::fprintf(stderr, "seldinger: it is back, and the session goes on at tick %u\n",
                 unsigned{link_->tick()});
}

void Device::ask(const std::function<void(Link &)> &request)
{
    bool has_link = true;
    if (!pipe_) throw LinkError("the device is gone, and the session with it. Remedy: begin it again");
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

std::span<const seld_wire_tick_state> Device::step(std::span<const seld_wire_encoders> inputs,
                                                   bool want_nodes)
{
    std::span<const seld_wire_tick_state> states;
    ask([&](Link &link) {
        keep_up();
        states = link.step(inputs, want_nodes);
    });
    if (choice_.may_return()) {
        inputs_.insert(inputs_.end(), inputs.begin(), inputs.end());
        for (const seld_wire_tick_state &state : states)
            hashes_.push_back({state.hash_lane0, state.hash_lane1});
    }
    return states;
}

} // namespace seld
