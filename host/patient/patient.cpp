#include "host/patient/patient.hpp"
#include "host/patient/pushed_vessels.hpp"
#include <algorithm>
#include <stdexcept>

namespace crn
{
namespace
{

std::shared_ptr<const XrayScene> xray_scene(const SceneAnatomy &anatomy, const PatientSettings &settings)
{
    if (settings.xray_scene) return settings.xray_scene;
    auto scene = std::make_shared<XrayScene>();
    std::string error;
    if (!scene->set_bodies(anatomy.bodies, error))
        throw std::runtime_error((settings.bodies_path.empty() ? "" : settings.bodies_path + ": ") + error);
    return scene;
}

} // namespace

Patient::Patient(const SceneAnatomy &anatomy, const std::vector<Instrument> &tools,
                 const PatientSettings &settings)
    : table_(tools), line_(line_or_table(settings.line, tools.size())), tools_(tools_on(table_, line_)),
      scene_(xray_scene(anatomy, settings)), poses_(anatomy), meter_(*scene_, settings.threads),
      contrast_(anatomy.bodies.vessels, tools_, anatomy.motion_or_null(),
                LesionOpening(anatomy.bodies.vessels, anatomy.stations)),
      catheter_pressure_(anatomy.bodies.vessels, tools_, anatomy.motion_or_null(),
                         LesionOpening(anatomy.bodies.vessels, anatomy.stations)),
      complications_(anatomy.bodies.vessels, tools_), catheter_air_(tools_)
{
    if (settings.stents.empty()) return;
    stents_ =
        std::make_unique<PatientStents>(settings.stents, anatomy.bodies.vessels, anatomy.motion_or_null(),
                                        anatomy.stations, tools_, !settings.line.empty());
}

Patient::~Patient() = default;

void Patient::command(std::uint32_t tick, const RoomCommand &command)
{
    const std::string why = room_.give(tick, command);
    if (!why.empty()) throw std::runtime_error("the X-ray room cannot do this: " + why);
    asked_.push_back({tick, command});
    carry_out_due();
}

// Contrast medium and stents carry out each command at its own tick, with the tools at their positions in
// that tick. The moment at which the program passes the command to this class makes no difference.
void Patient::carry_out_due()
{
    for (; !asked_.empty() && asked_.front().tick <= state_.tick; asked_.pop_front())
        carry_out(asked_.front().tick, asked_.front().command);
}

void Patient::carry_out(std::uint32_t tick, const RoomCommand &command)
{
    const std::size_t refused_injections = contrast_.refusals().size();
    std::string refused = contrast_.command(tick, command);
    if (contrast_.refusals().size() > refused_injections) refused = contrast_.refusals().back().why;
    const std::size_t refused_loads = stents_ ? stents_->refusals().size() : 0;
    if (stents_) stents_->command(tick, command);
    complications_.command(command);
    if (stents_ && stents_->refusals().size() > refused_loads) refused = stents_->refusals().back();
    if (command.action == RoomAction::load_stent && !stents_) refused = "NO STENT - name one with --stent";
    if (command.action == RoomAction::aspirate) refused = aspirate(tick, command.values[0]);
    if (command.action == RoomAction::inject && command.values[0] > 0 && refused.empty())
        note_injection(tick);
    if (!refused.empty()) notice_ = {refused, tick};
}

// Draws blood into the syringe. Blood flows into the syringe only if the tip does not block the vessel.
std::string Patient::aspirate(std::uint32_t tick, std::int32_t volume_ul)
{
    const auto refuse = [&](const char *why) {
        refused_aspirations_.push_back({tick, why});
        return std::string(why);
    };
    if (!catheter_pressure_.is_measuring())
        return refuse("NO CATHETER IN THE VESSELS - nothing to aspirate from");
    if (catheter_pressure_.is_blocked())
        return refuse("NO BLOOD - the tip is blocked: withdraw the catheter");
    catheter_air_.aspirate(volume_ul);
    return "";
}

// A dangerous injection is not prevented, as in a real catheter laboratory. The assessment counts it.
void Patient::note_injection(std::uint32_t tick)
{
    if (catheter_pressure_.is_damped()) damped_injections_.push_back(tick);
    catheter_air_.inject(tick);
}

// Contrast medium, pressure, air and stents use the tools that are in use in the core.
void Patient::follow_line(const crn_wire_tick_state &state)
{
    if (state.line_count == 0) return;
    LineNumbers now = line_of(state);
    if (now == line_) return;
    const ChangedPositions changed = changed_positions(line_, now);
    line_ = std::move(now);
    tools_ = tools_on(table_, line_);
    contrast_.set_tools(tools_, changed, state.tick);
    catheter_pressure_.set_tools(tools_, changed);
    complications_.set_tools(tools_, changed);
    catheter_air_.set_tools(tools_, changed);
    if (stents_) stents_->set_tools(tools_, changed);
}

void Patient::tick(const crn_wire_tick_input &input, const crn_wire_tick_state &state)
{
    follow_line(state);
    if (state.exchange > CRN_WIRE_EXCHANGE_DONE)
        notice_ = {std::string("NO EXCHANGE - ") + crn_wire_exchange_text(state.exchange) + ": " +
                       crn_wire_exchange_remedy(state.exchange),
                   state.tick};
    monitor_.advance(state);
    double aortic_mmHg = monitor_.pressure_mmHg();
    if (contrast_.pressure_share() < 1.0)
        aortic_mmHg = CatheterPressure::venous_mmHg +
                      contrast_.pressure_share() * (aortic_mmHg - CatheterPressure::venous_mmHg);
    catheter_pressure_.tick(aortic_mmHg, state);
    complications_.tick(state);
    catheter_air_.tick(state);
    monitor_.show(catheter_pressure_.pressure_mmHg());
    const std::size_t refusals = contrast_.refusals().size();
    contrast_.tick(state);
    if (contrast_.refusals().size() > refusals) notice_ = {contrast_.refusals().back().why, state.tick};
    if (stents_) stents_->tick(input, state);
    state_ = state;
    carry_out_due();
}

std::uint32_t Patient::next_vessel_look() const
{
    return std::min({contrast_.next_tick(), catheter_pressure_.next_tick(), complications_.next_tick(),
                     stents_ ? stents_->next_tick() : UINT32_MAX});
}

std::uint32_t Patient::next_look() const
{
    return std::min(next_vessel_look(), room_.next_tick());
}

void Patient::look_at_vessels(const WireFrame &wire)
{
    const WireFrame rest = at_rest(wire);
    const bool was_looked_at = contrast_.advance(rest);
    if (was_looked_at && !contrast_.flow().wounds().is_empty()) {
        contrast_.follow_wounds(complications_.pressure_left(contrast_.flow()));
        take_wounds();
    }
    catheter_pressure_.advance(rest);
    if (stents_) stents_->advance(rest);
    if (complications_.advance(rest, contrast_)) note_injury(wire.tick);
}

bool Patient::can_be_injured() const
{
    return complications_.limits().is_on && !contrast_.vessels().branches.empty();
}

void Patient::locate(const WireFrame &wire)
{
    if (complications_.locate(at_rest(wire), contrast_)) note_injury(wire.tick);
}

// The user learns of a new injury, but not of an old one that has grown.
void Patient::note_injury(std::uint32_t tick)
{
    if (complications_.injuries().back().tick == tick) notice_ = {complications_.notice(), tick};
}

// The catheter's pressure follows the wounds.
void Patient::take_wounds()
{
    const Wounds &wounds = contrast_.flow().wounds();
    catheter_pressure_.set_wounds(wounds.open_holes(), wounds.open_shares(contrast_.flow().cells().size()));
}

void Patient::look(const WireFrame &wire)
{
    look_at_vessels(wire);
    room_.forget_events();
    while (has_begun_ && room_.next_tick() < wire.tick) advance_room(room_.next_tick(), wire);
    advance_room(wire.tick, wire);
    has_begun_ = true;
}

// Advances the X-ray room to `tick`, and simulates the X-ray pulse that is due then.
void Patient::advance_room(std::uint32_t tick, const WireFrame &wire)
{
    room_.advance(tick, wire.nodes.empty() ? nullptr : &wire.nodes.front().position_m);
    if (!room_.is_pulse_due()) return;
    const PulseRequest request = room_.pulse();
    XraySettings settings;
    settings.carm = request.carm;
    settings.beam = request.beam;
    room_.expose(meter_.expose(settings, bodies_at(wire),
                               request.settles_at_once ? MeterPace::settles : MeterPace::follows));
}

void Patient::give_orders(crn_wire_order_list &orders)
{
    if (stents_) stents_->give_orders(orders);
}

std::vector<Refusal> Patient::refusals() const
{
    std::vector<Refusal> all = room_.refusals();
    all.insert(all.end(), contrast_.refusals().begin(), contrast_.refusals().end());
    all.insert(all.end(), refused_aspirations_.begin(), refused_aspirations_.end());
    std::stable_sort(all.begin(), all.end(),
                     [](const Refusal &a, const Refusal &b) { return a.tick < b.tick; });
    return all;
}

// --- snapshots ---

void Patient::archive(StateArchive &state, std::uint32_t now, const crn_wire_tick_state &last)
{
    constexpr std::uint32_t format = 2;
    std::uint32_t saved_format = format;
    state.integer<std::uint32_t>(saved_format, format, format);
    archive_line(state);
    if (state.restores()) state_ = last;
    meter_.archive(state);
    room_.archive(state, now);
    contrast_.archive(state, now, tools_, last);
    catheter_pressure_.archive(state, now, tools_);
    complications_.archive(state, now, tools_);
    const std::size_t cells = contrast_.flow().cells().size();
    for (const Injury &injury : complications_.injuries())
        if (state.restores()) state.require(injury.cell < cells && injury.cells <= cells - injury.cell);
    if (state.restores() && !state.is_refused()) take_wounds();
    catheter_air_.archive(state, tools_);
    bool has_stents = stents_ != nullptr;
    state.flag(has_stents);
    state.require(has_stents == (stents_ != nullptr));
    if (stents_ && !state.is_refused()) stents_->archive(state, tools_);
    monitor_.archive(state);
    state.list(refused_aspirations_, [&](Refusal &one) { archive_refusal(state, one); });
    state.list(damped_injections_, [&](std::uint32_t &tick) { state.integer(tick); });
    state.list(asked_, [&](Asked &one) {
        state.integer(one.tick);
        archive_command(state, one.command);
    });
    state.text(notice_.text);
    state.integer<std::int64_t>(notice_.from, -1, UINT32_MAX);
    state.flag(has_begun_);
}

void Patient::archive_line(StateArchive &state)
{
    LineNumbers line = line_;
    state.list(line, [&](std::uint8_t &number) {
        state.integer<std::uint8_t>(number, 0, static_cast<std::uint8_t>(table_.size()));
    });
    state.require(line.size() == line_.size());
    for (std::size_t k = 0; k < line.size(); ++k) // no tool is at two positions
        state.require(line[k] == 0 || std::count(line.begin(), line.end(), line[k]) == 1);
    if (!state.restores() || state.is_refused() || line == line_) return;
    line_ = std::move(line);
    tools_ = tools_on(table_, line_);
}

} // namespace crn
