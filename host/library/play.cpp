#include "host/library/play.hpp"
#include "host/report/figures/reported_tools.hpp"
#include "host/script/session_checks.hpp"
#include "host/session/contact_figures.hpp"
#include <nlohmann/json.hpp>

namespace crn::library
{

namespace
{

constexpr std::uint32_t exit_failed = 1, exit_range_left = 3; // of `cournand run`

std::vector<Instrument> table_of(const PlaySettings &settings)
{
    return {settings.tools.begin(), settings.tools.end()};
}

LineNumbers resolve(Session &session, const PlaySettings &settings)
{
    std::vector<std::string> words;
    for (const NamedTool &tool : settings.tools) words.push_back(tool.word);
    return resolve_tools(session, words);
}

// Makes the world of a script's session, with a patient. The replacements of tools in the script become
// orders.
std::shared_ptr<World> world_of(Session &session, const PlaySettings &settings)
{
    const LineNumbers line = resolve(session, settings);
    std::vector<const char *> stents;
    for (const std::string &path : settings.stents) stents.push_back(path.c_str());
    cournand_world_options options{};
    options.struct_bytes = sizeof options;
    options.flags = COURNAND_WITH_PATIENT;
    options.contact_ticks = ContactFigures::look_every_ticks;
    options.line_count = static_cast<std::uint32_t>(line.size());
    std::copy(line.begin(), line.end(), options.line);
    options.stent_count = static_cast<std::uint32_t>(stents.size());
    options.stents = stents.data();
    WorldSettings made = world_settings(settings.scene, table_of(settings), &options);
    made.entry = entry_of(settings.scene->file(), made.line.size(), session.inserted_um);
    check_loads(session, stents.size());
    check_inflations(session, made.tools);
    return std::make_shared<World>(std::move(made));
}

} // namespace

// --- the world as the device of a session ---

LedWorld::LedWorld(std::shared_ptr<World> world) : world_(std::move(world))
{
    world_->is_led_ = true;
}

Link &LedWorld::link()
{
    return world_->link_;
}

const std::vector<Instrument> &LedWorld::tools() const
{
    return world_->settings_.tools;
}

const LineNumbers &LedWorld::line() const
{
    return world_->settings_.line;
}

std::span<const crn_wire_tick_state> LedWorld::step(std::span<const crn_wire_tick_input> inputs,
                                                    bool want_nodes)
{
    World &world = *world_;
    world.forget_views();
    const auto states = world.link_.step(inputs, want_nodes);
    for (const crn_wire_tick_state &state : states) world.note(state);
    world.take_hands(inputs.back());
    world.sample_contacts();
    return states;
}

void LedWorld::ask(const std::function<void(Link &)> &request)
{
    request(world_->link_);
}

Hash64 LedWorld::read_hash64()
{
    return world_->link_.read_hash64();
}

std::optional<Hash64> LedWorld::last_hash64()
{
    return world_->link_.last_hash64();
}

std::vector<std::uint8_t> LedWorld::read_snapshot()
{
    return world_->link_.read_snapshot();
}

RecordingHeader LedWorld::recording_header(const std::string &session) const
{
    return world_->recording_header(session);
}

void LedWorld::begin_call()
{
    world_->wall_peak_N_ = 0.0;
}

void LedWorld::allow_saving(bool may)
{
    world_->may_be_saved_ = may;
}

// --- the play ---

Play::Play(const Session &session, PlaySettings settings)
    : session_(session), world_(world_of(session_, settings)), device_(world_)
{
    check_injections(session_, world_->patient()->contrast());
    if (!settings.record.empty())
        recorder_ = with_files([&] {
            return std::make_unique<Recorder>(settings.record, device_.recording_header(session_.file));
        });
    RunSettings run;
    run.begin = begin_commands(session_, *world_->patient());
    run.tips = &world_->scene().tips();
    witness_.emplace(world_->scene().tips().map(), *world_->patient());
    run.witness = &*witness_;
    run_.emplace(device_, *world_->patient(), session_, recorder_.get(), nullptr, run);
}

void Play::advance(std::uint32_t ticks, bool to_pulse)
{
    require(ticks >= 1 && ticks <= COURNAND_TICKS_MAX, "ticks is not within 1 and 600000");
    if (!broken_.empty())
        throw Refused(COURNAND_BAD_STATE, "the play has stopped: " + broken_ + "; make another play");
    if (!run_) throw Refused(COURNAND_BAD_STATE, "the script has ended: read its report");
    device_.begin_call();
    is_at_pulse_ = false;
    try {
        const std::uint32_t until = run_->tick() + ticks;
        if (to_pulse)
            is_at_pulse_ = run_->advance_to_pulse(until);
        else
            run_->advance_to(until);
        device_.allow_saving(run_->is_batch_done());
        if (run_->is_over()) make_report(run_->end());
    } catch (const std::exception &error) {
        broken_ = error.what();
        run_.reset();
        throw;
    }
}

void Play::make_report(RunResult result)
{
    const Patient &patient = *world_->patient();
    const Scene &scene = world_->scene();
    if (result.figures.range.is_left() && !scene.bodies_path().empty())
        result.figures.range.name_branch(scene.anatomy().bodies.vessels);
    for (const std::string &failure : result.failures) failures_ += failure + "\n";
    if (!failures_.empty() || !patient.refusals().empty()) exit_status_ = exit_failed;
    if (result.figures.range.is_left()) exit_status_ = exit_range_left;
    report_ = report_text(
        report_of(result, scene.file().path, reported_tools(patient), session_.file, *world_->patient()));
    run_.reset();
    recorder_.reset();
}

void Play::read(cournand_play_state &state) const
{
    state.tick = world_->tick();
    state.is_over = !run_;
    state.is_at_pulse = is_at_pulse_;
    state.exit_status = broken_.empty() ? exit_status_ : exit_failed;
    state.pulses = static_cast<std::uint32_t>(world_->patient()->room().dose().total().pulses);
    state.is_beam_on = world_->patient()->room().is_beam_on();
    state.failures = failures_.c_str();
}

void Play::read(cournand_view &view) const
{
    const CArm carm = world_->patient()->room().state().carm;
    view.primary_deg = carm.primary_deg;
    view.secondary_deg = carm.secondary_deg;
    for (int axis = 0; axis < 3; axis++) view.isocentre_m[axis] = carm.isocentre_m[axis];
    view.source_detector_m = carm.source_detector_m;
    view.source_isocentre_m = carm.source_isocentre_m;
    view.field_m = carm.field_m;
}

const std::string &Play::report() const
{
    if (report_.empty())
        throw Refused(COURNAND_BAD_STATE, broken_.empty()
                                              ? "the script has not ended: advance the play to its end first"
                                              : "the play has stopped: " + broken_ + "; it has no report");
    return report_;
}

void describe(const Session &session, cournand_script_info &info)
{
    info.statement_count = static_cast<std::uint32_t>(session.statements.size());
    info.path = session.file.c_str();
    info.scene = session.needs.scene.c_str();
    const auto list = [](const std::vector<std::string> &names, const char **to, std::size_t most) {
        const std::size_t count = std::min(names.size(), most);
        for (std::size_t i = 0; i < count; i++) to[i] = names[i].c_str();
        return static_cast<std::uint32_t>(count);
    };
    info.tool_count = list(session.needs.tools, info.tools, COURNAND_TOOLS_MAX);
    info.stent_count = list(session.needs.stents, info.stents, COURNAND_STENTS_MAX);
}

} // namespace crn::library
