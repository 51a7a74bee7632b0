// cournand info
#include "host/base/terminal.hpp"
#include "host/base/text.hpp"
#include "host/command/cli.hpp"
#include "host/model/units.hpp"
#include "host/picture/path_choice.hpp"
#include "host/script/session.hpp"
#include "host/session/recording.hpp"
#include "host/session/scene_file.hpp"
#include <cstdio>
#include <filesystem>

namespace crn
{

namespace
{

void print_recording(const std::string &path)
{
    const Recording recording = read_recording(path);
    const RecordingHeader &header = recording.header;
    say(stdout, "recording     %s\n", printable(path).c_str());
    say(stdout, "length        %zu ticks (%.3f s), %s\n", recording.ticks.size(),
        recording.ticks.size() * 1e-3, recording.is_complete ? "complete" : "cut off");
    say(stdout, "core version  %u, schema %016llx\n", unsigned{header.core_version},
        static_cast<unsigned long long>(header.schema_hash));
    say(stdout, "scene         %s (%u bytes, CRC-32 %08x)\n",
        header.scene_bytes == 0 ? "free space" : printable(header.scene_path).c_str(),
        unsigned{header.scene_bytes}, unsigned{header.scene_crc32});
    for (std::size_t k = 0; k < header.tools.size(); k++) {
        say(stdout, "tool %zu        %s, %.0f mm, starts with %.1f mm inserted\n", k + 1,
            printable(header.tools[k].name).c_str(), header.tools[k].length_m * 1e3,
            header.entry.inserted_um[k] * 1e-3);
    }
    say(stdout, "session       %s\n", printable(header.session_path).c_str());
    say(stdout, "snapshots     %zu, full hashes %zu, commands to the room %zu\n", recording.snapshots.size(),
        recording.hashes.size(), recording.commands.size());
    if (recording.is_complete) {
        say(stdout, "final hash    %016llx\n", static_cast<unsigned long long>(recording.hashes.back().hash));
    }
}

void print_scene(const std::string &path)
{
    const SceneFile scene = read_scene(path);
    const crn_wire_entry &entry = scene.entry;
    say(stdout, "scene         %s\n", printable(scene.name).c_str());
    say(stdout, "size          %zu bytes, CRC-32 %08x\n", scene.bytes.size(), unsigned{scene.crc32});
    say(stdout, "entry         (%.1f, %.1f, %.1f) mm towards (%.3f, %.3f, %.3f)\n",
        units::metres(entry.position_x_m_q30) * 1e3, units::metres(entry.position_y_m_q30) * 1e3,
        units::metres(entry.position_z_m_q30) * 1e3, units::ratio(entry.direction_x_q30),
        units::ratio(entry.direction_y_q30), units::ratio(entry.direction_z_q30));
    say(stdout, "start         %.1f mm inserted\n", scene.start_um * 1e-3);
}

void print_instrument(const std::string &path)
{
    const Instrument instrument = read_instrument(path);
    say(stdout, "instrument    %s, %.0f mm, %u knots\n", printable(instrument.name).c_str(),
        instrument.length_m * 1e3, unsigned{instrument.table.knots_count});
    if (instrument.table.material_kind != CRN_WIRE_MATERIAL_ELASTIC)
        say(stdout, "material      %s, from a strain of %.2f %% on (docs/instruments.md)\n",
            instrument.table.material_kind == CRN_WIRE_MATERIAL_SUPERELASTIC ? "superelastic"
                                                                             : "metal that yields",
            instrument.table.yield_strain_micro * 1e-4);
    say(stdout, "%10s %14s %14s %10s %8s %8s %14s %14s\n", "arc mm", "EI N m^2", "GJ N m^2", "g/m", "R mm",
        "r mm", "curvature 1/m", "curvature 2/m");
    for (std::uint16_t i = 0; i < instrument.table.knots_count; i++) {
        const crn_wire_knot &knot = instrument.table.knots[i];
        say(stdout, "%10.1f %14.3e %14.3e %10.2f %8.3f %8.3f %14.1f %14.1f\n", knot.arc_um * 1e-3,
            knot.bend_stiffness_nN_m2 * 1e-9, knot.twist_stiffness_nN_m2 * 1e-9, knot.mass_mg_per_m * 1e-3,
            knot.radius_outer_um * 1e-3, knot.radius_inner_um * 1e-3, knot.rest_curvature1_per_m_milli * 1e-3,
            knot.rest_curvature2_per_m_milli * 1e-3);
    }
}

void print_session(const std::string &path)
{
    const Session session = read_session(path);
    say(stdout, "session       %zu statements, needs %zu tool%s, starts with", session.statements.size(),
        session.tools_named, session.tools_named == 1 ? "" : "s");
    for (std::size_t k = 0; k < session.tools_named; k++) {
        say(stdout, "%s", k == 0 ? " " : " / ");
        if (session.inserted_um[k] == inserted_unstated)
            say(stdout, "the scene's start");
        else
            say(stdout, "%.1f mm", session.inserted_um[k] * 1e-3);
    }
    say(stdout, " inserted\n");
    const SessionNeeds &needs = session.needs;
    if (!needs.scene.empty()) say(stdout, "scene         %s\n", needs.scene.c_str());
    for (const std::string &tool : needs.tools) say(stdout, "tool          %s\n", tool.c_str());
    for (const std::string &stent : needs.stents) say(stdout, "stent         %s\n", stent.c_str());
}

} // namespace

int command_info_opengl()
{
    return print_opengl() ? 0 : 1;
}

int command_info(const std::string &path)
{
    const std::string extension = std::filesystem::path(split_preset(path).first).extension().string();
    if (extension == ".toml") {
        print_instrument(path);
    } else if (extension == ".session") {
        print_session(path);
    } else if (extension == ".scene") {
        print_scene(path);
    } else if (extension == ".rec") {
        print_recording(path);
    } else {
        throw FileError(path, 0, 0, "has none of the endings .rec .scene .toml .session");
    }
    return 0;
}

} // namespace crn
