// A device with everything set up for a session: sim port, handshake, scene, instrument, entry, rig, armed and started.
// May include: link, model. Called by: run, replay, view.
#pragma once
#include "host/app/frame_sink.hpp"
#include "host/app/recording.hpp"
#include "host/app/scene_file.hpp"
#include "host/link/link.hpp"
#include "host/link/sim_transport.hpp"

namespace seld
{

// The rig that scripts and keyboard drive: 1 um and 1/65 536 turn per count, true force.
seld_wire_rig host_rig();

class Device
{
  public:
    // Throws LinkError with the device's reason and remedy.
    Device(const SceneFile &scene, const Instrument &instrument, const seld_wire_entry &entry,
           const seld_wire_rig &rig);
    Link &link() { return link_; }
    const seld_wire_hello_reply &identity() const { return identity_; }
    // Continue from a snapshot of the same session.
    void restore(std::span<const std::uint8_t> snapshot);

  private:
    SimTransport pipe_;
    Link link_;
    seld_wire_hello_reply identity_{};
};

// The moment after a batch of steps, from the link's last nodes, the last tick's result and the input that led to it.
SessionFrame session_frame(const Link &link, const seld_wire_tick_state &state,
                           const seld_wire_encoders &input, const ViewState &view);

// The worst of a session, over every tick.
struct SessionFigures {
    std::uint32_t ticks = 0;
    double penetration_max_m = 0.0;
    std::uint32_t penetration_max_tick = 0;
    double strain_max = 0.0; // relative length error
    std::uint32_t strain_max_tick = 0;
    double inserted_m = 0.0;
    double inserted_max_m = 0.0;
    double handle_axial_max_N = 0.0;
    std::uint32_t contact_count_max = 0;
    void take(const seld_wire_tick_state &state);
};

} // namespace seld
