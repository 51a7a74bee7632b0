#include "host/session/device.hpp"
#include "host/model/timeline.hpp"
#include "host/model/units.hpp"
#include "host/script/hand_motion.hpp"
#include "host/script/session.hpp"
#include "host/session/set_up.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{

crn_wire_rig host_rig()
{
    crn_wire_rig rig{};
    rig.tracks_count = CRN_WIRE_TOOL_MAX;
    for (crn_wire_track &track : rig.tracks) {
        track.translation_pm_per_count = static_cast<std::uint32_t>(1'000'000'000'000 / counts_per_m);
        track.rotation_counts_per_turn = static_cast<std::uint32_t>(counts_per_turn);
        track.force_gain_milli = 1000;
        track.force_limit_mN = 8000;
        track.torque_limit_uN_m = 20000;
    }
    return rig;
}

RecordingHeader Device::recording_header(const std::string &session,
                                         const std::vector<StentDesign> &stents) const
{
    return {identity_.core_version,
            identity_.schema_hash,
            static_cast<std::uint32_t>(scene_.bytes.size()),
            scene_.crc32,
            scene_.path,
            session,
            tools_,
            line_ == whole_table(tools_.size()) ? LineNumbers{} : line_,
            entry_,
            rig_,
            stents};
}

Device::Device(const SceneFile &scene, std::vector<Instrument> tools, const crn_wire_entry &entry,
               const crn_wire_rig &rig, const DeviceChoice &choice, const LineNumbers &line)
    : scene_(scene), tools_(std::move(tools)), line_(line_or_table(line, tools_.size())), entry_(entry),
      rig_(rig), choice_(choice)
{
    try {
        open();
        set_up();
        has_started_ = true;
        call_witness();
    } catch (const LinkError &error) {
        throw with_tool_names(error, tools_, line_);
    }
    if (!choice_.free_run) return;
    try {
        link_->stop();
        start_free_run();
    } catch (const LinkError &) {
        leave(); // no destructor runs for an object that was not made
        throw;
    }
}

crn_wire_entry entry_of(const SceneFile &scene, std::size_t tool_count,
                        std::span<const std::uint32_t> inserted_um)
{
    crn_wire_entry entry = scene.entry;
    entry.inserted_um_count =
        static_cast<std::uint16_t>(std::min<std::size_t>(tool_count, CRN_WIRE_TOOL_MAX));
    for (std::size_t k = 0; k < entry.inserted_um_count; k++)
        entry.inserted_um[k] =
            k < inserted_um.size() && inserted_um[k] != inserted_unstated ? inserted_um[k] : scene.start_um;
    return entry;
}

SessionFrame session_frame(SteppedDevice &device, const crn_wire_tick_state &state,
                           const crn_wire_tick_input &input)
{
    const Link &link = device.link();
    const crn_wire_nodes &shape = link.nodes();
    const std::span<const std::uint8_t> line(shape.line, shape.line_count);
    const std::vector<Instrument> tools =
        tools_on(device.tools(), shape.line_count > 0 ? line : std::span(device.line()));
    SessionFrame frame;
    frame.wire = wire_frame(link.nodes(), link.node_table(), tools);
    frame.tools.resize(tools.size());
    for (std::size_t k = 0; k < frame.tools.size(); k++) {
        ToolReading &reading = frame.tools[k];
        if (k < link.nodes().inserted_m_q30_count)
            reading.inserted_m = units::metres(link.nodes().inserted_m_q30[k]);
        if (k < input.hands_count)
            reading.turned_deg = input.hands[k].rotation_counts * 360.0 / counts_per_turn;
        if (k >= state.tools_count) continue;
        reading.axial_N = units::newtons(state.tools[k].handle_axial_N_q22);
        reading.torque_N_m = units::newton_metres(state.tools[k].handle_torque_N_m_q24);
    }
    return frame;
}

void SessionFigures::take(const crn_wire_tick_state &state)
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
    contact_count_max = std::max<std::uint32_t>(contact_count_max, state.contact_count);
    balloon.take(state);
    range.take(state);
    heart.monitor.tick(state);
    heart.pressure_max_mmHg = std::max(heart.pressure_max_mmHg, heart.monitor.pressure_mmHg());
    heart.pressure_min_mmHg = std::min(heart.pressure_min_mmHg, heart.monitor.pressure_mmHg());
    tools.resize(state.tools_count);
    for (std::size_t k = 0; k < tools.size(); k++) {
        const crn_wire_tool_state &now = state.tools[k];
        ToolFigures &tool = tools[k];
        tool.inserted_m = units::metres(now.inserted_m_q30);
        tool.inserted_max_m = std::max(tool.inserted_max_m, tool.inserted_m);
        tool.axial_max_N = std::max(tool.axial_max_N, std::abs(units::newtons(now.handle_axial_N_q22)));
        tool.torque_max_N_m =
            std::max(tool.torque_max_N_m, std::abs(units::newton_metres(now.handle_torque_N_m_q24)));
    }
}

} // namespace crn
