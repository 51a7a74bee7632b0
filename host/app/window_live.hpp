// A session led by hand: one device, its recording and its pictures. One object is one session; reset makes a new one.
// A device in FREE_RUN leads itself: its encoders are the hands, its first button the X-ray pedal beside the key.
// May include: device, recording, session_pictures. Called by: window.
#pragma once
#include "host/app/device.hpp"
#include "host/app/hand_motion.hpp"
#include "host/app/session_pictures.hpp"
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace seld
{

class LiveSession final : private FreeRunSink
{
  public:
    // `tools` from the innermost. `record` empty: none. Throws what Device, Recorder and SessionPictures throw.
    LiveSession(const SceneFile &scene, const std::vector<Instrument> &tools, const seld_wire_entry &entry,
                const std::string &record, const PictureSettings &pictures, const ViewState &view,
                const DeviceChoice &choice = {});

    std::span<LiveHand> hands() { return hands_; } // one per tool
    void choose_tool(std::size_t tool, bool all);  // marked in the display
    void set_view(const ViewState &view);          // in force from the present tick on; recorded
    const ViewState &view() const { return view_; }
    // `ticks` ticks; pictures are made when they are due. False when the device stopped: fault() says why.
    bool advance(std::uint32_t ticks);
    const std::string &fault() const { return fault_; }
    void annotate(const std::string &notice, const std::vector<std::string> &panel);
    const Image &image() const { return pictures_.image(); }
    void finish(); // closes the recording

  private:
    std::uint32_t batch_size(std::uint32_t wanted);
    void batch(std::uint32_t count);
    void advance_rig(std::uint32_t ticks);
    void tick(const seld_wire_live_tick &tick) override;
    void snapshot(std::uint32_t tick, std::span<const std::uint8_t> bytes) override;
    void resumed(std::uint32_t tick, std::span<const std::uint8_t> bytes) override;
    void record_state();
    void picture();

    PictureSettings settings_;
    DeviceChoice choice_;
    Device device_;
    std::unique_ptr<Recorder> recorder_;
    SessionPictures pictures_;
    std::vector<LiveHand> hands_;
    ViewState view_, wanted_view_; // in force; asked for by keys
    std::vector<seld_wire_encoders> inputs_;
    seld_wire_tick_state state_{};
    SessionFrame frame_;
    std::uint32_t picture_index_ = 0;
    std::uint32_t hash_tick_ = 0;
    std::uint32_t led_tick_ = 0; // FREE_RUN: the last tick that came
    bool is_pedal_down_ = false; // of the rig
    std::string fault_;
};

} // namespace seld
