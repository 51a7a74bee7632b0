// A device with everything set up for a session: sim port, handshake, scene, tools, entry, rig, armed and started.
// May include: link, model. Called by: run, replay, view.
#pragma once
#include "host/app/frame_sink.hpp"
#include "host/app/recording.hpp"
#include "host/app/scene_file.hpp"
#include "host/link/link.hpp"
#include "host/link/sim_transport.hpp"
#include <span>
#include <vector>

namespace seld
{

// The rig that scripts and keyboard drive: 1 um and 1/65 536 turn per count, true force.
seld_wire_rig host_rig();

class Device
{
  public:
    // `tools` from the innermost to the outermost. Throws LinkError with the device's reason and remedy, and the name of
    // the tool at fault.
    Device(const SceneFile &scene, std::vector<Instrument> tools, const seld_wire_entry &entry,
           const seld_wire_rig &rig);
    Link &link() { return link_; }
    const std::vector<Instrument> &tools() const { return tools_; }
    const seld_wire_hello_reply &identity() const { return identity_; }
    // Continue from a snapshot of the same session.
    void restore(std::span<const std::uint8_t> snapshot);

  private:
    void set_up(const SceneFile &scene, const seld_wire_entry &entry, const seld_wire_rig &rig);

    std::vector<Instrument> tools_;
    SimTransport pipe_;
    Link link_;
    seld_wire_hello_reply identity_{};
};

// The scene's entry with one length per tool; lengths that are not given are the default of a session.
seld_wire_entry entry_of(const SceneFile &scene, std::size_t tool_count,
                         std::span<const std::uint32_t> inserted_um);
inline constexpr std::uint32_t inserted_default_um = 20000;

// The moment after a batch of steps, from the link's last nodes, the last tick's result and the input that led to it.
// Before the first tick `state` is empty: no forces yet.
SessionFrame session_frame(Device &device, const seld_wire_tick_state &state, const seld_wire_encoders &input,
                           const ViewState &view);

// The worst of one tool.
struct ToolFigures {
    double inserted_m = 0.0;
    double inserted_max_m = 0.0;
    double axial_max_N = 0.0; // size of the force on the hand
    double torque_max_N_m = 0.0;
};

// The worst of a session, over every tick.
struct SessionFigures {
    std::uint32_t ticks = 0;
    double penetration_max_m = 0.0;
    std::uint32_t penetration_max_tick = 0;
    double strain_max = 0.0; // relative length error
    std::uint32_t strain_max_tick = 0;
    std::uint32_t contact_count_max = 0;
    std::vector<ToolFigures> tools; // from the innermost; empty before the first tick
    void take(const seld_wire_tick_state &state);
};

} // namespace seld
