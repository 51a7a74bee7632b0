#include "host/library/world.hpp"
#include "host/patient/pulse_shot.hpp"
#include "host/script/session.hpp"
#include "host/session/device.hpp"
#include <cmath>

namespace crn::library
{

namespace
{

// A device in this process answers at once, but a debugger or a busy machine may stop it for a long time.
constexpr Patience::Span patience = std::chrono::hours(24);

std::uint64_t fnv(std::uint64_t hash, std::span<const std::uint8_t> bytes)
{
    for (const std::uint8_t byte : bytes) hash = (hash ^ byte) * 0x100000001b3ull;
    return hash;
}

template <class Message, class Put> std::uint64_t fnv_of(std::uint64_t hash, const Message &message, Put put)
{
    std::vector<std::uint8_t> bytes(CRN_WIRE_PAYLOAD_MAX);
    crn_wire_writer writer = crn_wire_writer_make(bytes.data(), bytes.size());
    put(&writer, &message);
    return fnv(hash, {bytes.data(), writer.length});
}

void take_line(WorldSettings &settings, const cournand_world_options &options)
{
    require(options.line_count <= COURNAND_POSITIONS_MAX, "options: line_count is above 3");
    std::uint32_t seen = 0;
    for (std::uint32_t k = 0; k < options.line_count; k++) {
        const std::uint32_t number = options.line[k];
        require(number <= settings.tools.size(), "options: line names a tool that is not in `tools`");
        require(number == 0 || !(seen >> number & 1u), "options: line names a tool twice");
        seen |= number == 0 ? 0u : 1u << number;
        settings.line.push_back(static_cast<std::uint8_t>(number));
    }
    require(options.line_count == 0 || seen != 0, "options: line names no tool");
}

std::vector<std::uint32_t> inserted_um(const cournand_world_options &options)
{
    require(options.inserted_count <= COURNAND_POSITIONS_MAX, "options: inserted_count is above 3");
    std::vector<std::uint32_t> lengths;
    for (std::uint32_t k = 0; k < options.inserted_count; k++) {
        const double length_m = options.inserted_m[k];
        require(std::isnan(length_m) || (length_m >= 0.0 && length_m <= 2.0),
                "options: inserted_m is not within 0 and 2 m");
        lengths.push_back(std::isnan(length_m) ? inserted_unstated
                                               : static_cast<std::uint32_t>(std::llround(length_m * 1e6)));
    }
    return lengths;
}

void take_stents(WorldSettings &settings, const cournand_world_options &options)
{
    require(options.stent_count <= COURNAND_STENTS_MAX, "options: stent_count is above 8");
    if (options.stent_count == 0) return;
    require(settings.has_patient, "options: stents need COURNAND_WITH_PATIENT");
    require(options.stents != nullptr, "options: stents is NULL");
    std::vector<std::string> paths;
    for (std::uint32_t i = 0; i < options.stent_count; i++) {
        require(options.stents[i] != nullptr, "options: a path of stents is NULL");
        paths.emplace_back(options.stents[i]);
    }
    settings.stents = with_files([&] { return read_stents(paths, settings.tools); });
}

} // namespace

WorldSettings world_settings(std::shared_ptr<const Scene> scene, std::vector<Instrument> tools,
                             const cournand_world_options *given)
{
    cournand_world_options options{};
    if (given) options = read_struct(given, "options");
    require((options.flags & ~std::uint32_t{COURNAND_WITH_PATIENT}) == 0,
            "options: flags has an unknown bit");
    require(options.contact_ticks <= 1000, "options: contact_ticks is above 1000");
    WorldSettings settings{.scene = std::move(scene), .tools = std::move(tools)};
    take_line(settings, options);
    require(!settings.line.empty() || settings.tools.size() <= COURNAND_POSITIONS_MAX,
            "there are more than three tools: options.line says which are on the line");
    settings.line = line_or_table(settings.line, settings.tools.size());
    settings.entry = entry_of(settings.scene->file(), settings.line.size(), inserted_um(options));
    settings.rig = host_rig();
    settings.has_patient = (options.flags & COURNAND_WITH_PATIENT) != 0;
    settings.contact_ticks = options.contact_ticks;
    take_stents(settings, options);
    return settings;
}

std::uint64_t fingerprint(const SceneFile &scene, const std::vector<Instrument> &tools,
                          const LineNumbers &line, const crn_wire_entry &entry, const crn_wire_rig &rig)
{
    std::uint64_t hash = 0xcbf29ce484222325ull;
    const std::uint64_t numbers[] = {crn_wire_schema_hash(), scene.bytes.size(), scene.crc32, tools.size()};
    for (const std::uint64_t number : numbers)
        for (int i = 0; i < 8; i++) {
            const auto byte = static_cast<std::uint8_t>(number >> (8 * i));
            hash = fnv(hash, {&byte, 1});
        }
    for (const Instrument &tool : tools) hash = fnv_of(hash, tool.table, crn_wire_put_instrument);
    hash = fnv(hash, line);
    hash = fnv_of(hash, entry, crn_wire_put_entry);
    return fnv_of(hash, rig, crn_wire_put_rig);
}

World::World(WorldSettings settings)
    : settings_(std::move(settings)), pipe_(0), link_(pipe_, patience), line_now_(settings_.line)
{
    const SceneFile &scene = settings_.scene->file();
    fingerprint_ = fingerprint(scene, settings_.tools, settings_.line, settings_.entry, settings_.rig);
    core_version_ = link_.hello().core_version;
    // All worlds of a scene share its bytes, so a new world needs neither an upload of the scene nor memory
    // for it.
    if (!scene.bytes.empty() && !pipe_.share_scene(scene.bytes, scene.crc32))
        throw Refused(COURNAND_INTERNAL, scene.path + ": the device refuses the scene");
    try {
        set_up_session(link_, {scene, settings_.tools, settings_.line, settings_.entry, settings_.rig});
    } catch (const LinkError &error) {
        throw with_tool_names(error, settings_.tools, settings_.line);
    }
    tools_now_ = tools_on(settings_.tools, line_now_);
    reserve_views();
    if (!settings_.has_patient) return;
    PatientSettings of_patient;
    of_patient.bodies_path = settings_.scene->bodies_path();
    of_patient.stents = settings_.stents;
    of_patient.threads = 1;
    of_patient.xray_scene = std::shared_ptr<const XrayScene>(settings_.scene, &settings_.scene->xray());
    of_patient.line = settings_.line == whole_table(settings_.tools.size()) ? LineNumbers{} : settings_.line;
    patient_ = std::make_unique<Patient>(settings_.scene->anatomy(), settings_.tools, of_patient);
}

// The views (arrays that callers read) stay at the same addresses while the world exists, so that an outdated
// pointer still refers to memory of this world.
void World::reserve_views()
{
    for (std::vector<float> *rows : {&arcs_m_, &radii_m_}) rows->reserve(CRN_WIRE_MAX_nodes_positions);
    positions_m_.reserve(3 * CRN_WIRE_MAX_nodes_positions);
    for (std::vector<float> *of_positions : {&tip_arcs_m_, &inserted_m_})
        of_positions->reserve(CRN_WIRE_MAX_nodes_inserted_m_q30);
    contact_nodes_.reserve(CRN_WIRE_MAX_contacts_contacts);
    forces_N_.reserve(3 * CRN_WIRE_MAX_contacts_contacts);
}

void World::check_alive() const
{
    if (!stopped_.empty())
        throw Refused(COURNAND_BAD_STATE, "the world has stopped: " + stopped_ + "; make another world");
}

void World::check_free() const
{
    if (is_led_)
        throw Refused(COURNAND_BAD_STATE, "a script leads this world, so it can only be read: make another "
                                          "world, which can restore its snapshot");
}

Patient &World::need_patient()
{
    if (!patient_)
        throw Refused(COURNAND_BAD_STATE, "this world has no patient: make it with COURNAND_WITH_PATIENT");
    return *patient_;
}

void World::command(const RoomCommand &command)
{
    const std::string why = refusal(command);
    if (!why.empty()) throw Refused(COURNAND_BAD_ARGUMENT, why);
    recording_work([&](Recorder &recorder) { recorder.command(tick(), command); });
    need_patient().command(tick(), command);
    was_commanded_ = true;
}

void World::inject(double volume_ml, double flow_ml_per_s, std::int32_t position, double iodine_mg_per_ml)
{
    check_free();
    const Patient &patient = need_patient();
    require(volume_ml >= 0.0 && volume_ml <= 200.0, "the volume is not within 0 and 200 ml");
    require(flow_ml_per_s >= 0.001 && flow_ml_per_s <= 50.0, "the flow is not within 0.001 and 50 ml/s");
    require(iodine_mg_per_ml >= 10.0 && iodine_mg_per_ml <= 350.0,
            "the strength is not within 10 and 350 mg/ml");
    require(position >= -1 && position < static_cast<std::int32_t>(positions()),
            "the position is not on the line, nor -1");
    const RoomCommand strength{RoomAction::contrast_strength,
                               {static_cast<std::int32_t>(std::lround(iodine_mg_per_ml)), 0, 0}};
    const RoomCommand injection{RoomAction::inject,
                                {static_cast<std::int32_t>(std::lround(volume_ml * 1e3)),
                                 static_cast<std::int32_t>(std::lround(flow_ml_per_s * 1e3)), position + 1}};
    const std::string why = patient.contrast().refusal(injection, strength.values[0]);
    if (!why.empty()) throw Refused(COURNAND_REFUSED, why);
    command(strength);
    command(injection);
}

void World::load_stent()
{
    check_free();
    PatientStents *stents = need_patient().stents();
    if (!stents) throw Refused(COURNAND_BAD_STATE, "the world has no stents: name them in options.stents");
    const std::size_t refused = stents->refusals().size();
    command({RoomAction::load_stent, {}});
    if (stents->refusals().size() > refused) throw Refused(COURNAND_REFUSED, stents->refusals().back());
}

const std::vector<Instrument> &World::tools_on_line()
{
    nodes();
    return tools_now_;
}

const std::vector<RadiopaqueInstrument> &World::looks_on_line()
{
    nodes();
    if (looks_.empty())
        for (const Instrument &tool : settings_.tools) looks_.push_back(instrument_look(tool));
    looks_now_ = looks_on(looks_, line_now_);
    return looks_now_;
}

} // namespace crn::library
