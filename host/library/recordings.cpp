#include "host/library/recordings.hpp"
#include "host/base/number_text.hpp"

namespace crn::library
{

namespace
{

// Returns an order of the wire protocol as the C struct of the API, with the fields in the same sequence.
cournand_order order_of_wire(const crn_wire_order &order)
{
    switch (order.kind) {
    case CRN_WIRE_KIND_rhythm:
        return {order.kind, {order.rhythm.action, order.rhythm.value}};
    case CRN_WIRE_KIND_scaffold:
        return {order.kind,
                {order.scaffold.lesion, order.scaffold.first, order.scaffold.last, order.scaffold.open_q15}};
    case CRN_WIRE_KIND_strut:
        return {order.kind,
                {order.strut.number, order.strut.joined, order.strut.x_um, order.strut.y_um, order.strut.z_um,
                 order.strut.inside_um, order.strut.thickness_um}};
    default:
        return {order.kind, {order.exchange.position, order.exchange.tool}};
    }
}

} // namespace

void describe(const Recording &recording, cournand_recording_info &info)
{
    const RecordingHeader &header = recording.header;
    info.core_version = header.core_version;
    info.tick_count = static_cast<std::uint32_t>(recording.ticks.size());
    info.is_complete = recording.is_complete;
    info.tool_count = static_cast<std::uint32_t>(header.tools.size());
    info.position_count = static_cast<std::uint32_t>(header.positions());
    info.scene_crc32 = header.scene_crc32;
    info.scene_path = header.scene_path.c_str();
    info.session = header.session_path.c_str();
    if (recording.hashes.empty()) return;
    info.last_hash = recording.hashes.back().hash;
    info.last_hash_tick = recording.hashes.back().tick;
}

void copy_inputs(const Recording &recording, std::uint32_t first, std::span<cournand_input> inputs)
{
    const std::size_t count = recording.ticks.size();
    require(first <= count && inputs.size() <= count - first,
            "the ticks are beyond the end of the recording");
    for (std::size_t i = 0; i < inputs.size(); i++) {
        const crn_wire_tick_input &from = recording.ticks[first + i].input;
        cournand_input &to = inputs[i];
        to = {};
        for (std::uint16_t k = 0; k < from.hands_count; k++) {
            to.push_um[k] = from.hands[k].translation_counts;
            to.turn_counts[k] = from.hands[k].rotation_counts;
        }
        to.inflator_kPa = from.inflator_raw;
        to.buttons = from.buttons;
        to.order_count = from.orders.items_count;
        for (std::uint8_t k = 0; k < from.orders.items_count; k++)
            to.orders[k] = order_of_wire(from.orders.items[k]);
    }
}

WorldSettings settings_of(const Recording &recording, std::shared_ptr<const Scene> scene, std::uint32_t flags)
{
    const RecordingHeader &header = recording.header;
    require((flags & ~std::uint32_t{COURNAND_WITH_PATIENT}) == 0, "flags has an unknown bit");
    const SceneFile &file = scene->file();
    if (header.scene_bytes != file.bytes.size() || header.scene_crc32 != file.crc32)
        throw Refused(COURNAND_BAD_ARGUMENT, "the scene is not that of the recording: it has " +
                                                 std::to_string(file.bytes.size()) + " bytes and checksum " +
                                                 hex_text(file.crc32) + ", recorded was one of " +
                                                 std::to_string(header.scene_bytes) + " bytes, " +
                                                 hex_text(header.scene_crc32) + ", " + header.scene_path);
    WorldSettings settings{.scene = std::move(scene), .tools = header.tools};
    settings.line = line_or_table(header.line, header.tools.size());
    settings.entry = header.entry;
    settings.rig = header.rig;
    settings.has_patient = (flags & COURNAND_WITH_PATIENT) != 0;
    if (settings.has_patient) settings.stents = header.stents;
    return settings;
}

} // namespace crn::library
