#include "host/app/device.hpp"
#include "host/app/hand_motion.hpp"
#include "host/model/timeline.hpp"
#include "host/model/units.hpp"
#include <algorithm>
#include <cmath>

namespace seld
{

seld_wire_rig host_rig()
{
    seld_wire_rig rig{};
    rig.translation_pm_per_count = static_cast<std::uint32_t>(1'000'000'000'000 / counts_per_m);
    rig.rotation_counts_per_turn = static_cast<std::uint32_t>(counts_per_turn);
    rig.force_gain_milli = 1000;
    rig.force_limit_mN = 8000;
    rig.torque_limit_uN_m = 20000;
    return rig;
}

Device::Device(const SceneFile &scene, const Instrument &instrument, const seld_wire_entry &entry,
               const seld_wire_rig &rig)
    : link_(pipe_)
{
    identity_ = link_.hello();
    link_.load_scene(scene.bytes);
    link_.load_instrument(instrument.table);
    link_.set_entry(entry);
    link_.set_rig(rig);
    link_.use_lockstep();
    link_.arm();
    link_.start();
}

void Device::restore(std::span<const std::uint8_t> snapshot)
{
    link_.stop();
    link_.write_snapshot(snapshot);
    link_.start();
}

SessionFrame session_frame(const Link &link, const seld_wire_tick_state &state,
                           const seld_wire_encoders &input, const ViewState &view)
{
    SessionFrame frame;
    frame.wire = wire_frame(link.nodes(), link.node_table());
    frame.view = view;
    frame.inserted_m = units::metres(state.inserted_m_q30);
    frame.turned_deg = input.rotation_counts * 360.0 / counts_per_turn;
    frame.axial_N = units::newtons(state.handle_axial_N_q22);
    frame.torque_N_m = units::newton_metres(state.handle_torque_N_m_q24);
    return frame;
}

void SessionFigures::take(const seld_wire_tick_state &state)
{
    ticks++;
    const double depth_m = units::metres(state.penetration_max_m_q30);
    if (depth_m > penetration_max_m) {
        penetration_max_m = depth_m;
        penetration_max_tick = state.tick;
    }
    const double strain = std::abs(units::ratio(state.strain_max_q30));
    if (strain > strain_max) {
        strain_max = strain;
        strain_max_tick = state.tick;
    }
    inserted_m = units::metres(state.inserted_m_q30);
    inserted_max_m = std::max(inserted_max_m, inserted_m);
    handle_axial_max_N = std::max(handle_axial_max_N, std::abs(units::newtons(state.handle_axial_N_q22)));
    contact_count_max = std::max<std::uint32_t>(contact_count_max, state.contact_count);
}

} // namespace seld
