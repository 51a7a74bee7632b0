#include "host/app/session_effects.hpp"
#include <algorithm>

namespace crn
{

SessionEffects::SessionEffects(const PictureSettings &settings, const std::vector<Instrument> &tools)
{
    const SceneAnatomy anatomy = read_scene_anatomy(settings.scene_path, settings.bodies_path);
    stents_ = stents_of(anatomy, settings.stents, tools);
    if (!anatomy.bodies.vessels.branches.empty()) contrast_ = contrast_of(anatomy, tools);
}

void SessionEffects::command(std::uint32_t tick, const RoomCommand &command)
{
    if (contrast_) contrast_->command(tick, command);
    if (stents_) stents_->command(tick, command);
}

void SessionEffects::tick(const crn_wire_encoders &input, const crn_wire_tick_state &state)
{
    if (contrast_) contrast_->tick(state);
    if (stents_) stents_->tick(input, state);
}

std::uint32_t SessionEffects::next_look() const
{
    return std::min(contrast_ ? contrast_->next_tick() : UINT32_MAX,
                    stents_ ? stents_->next_tick() : UINT32_MAX);
}

void SessionEffects::look(const SessionFrame &frame)
{
    if (contrast_) contrast_->advance(frame.wire);
    if (stents_) stents_->advance(frame.wire);
}

std::optional<crn_wire_scaffold> SessionEffects::order()
{
    return stents_ ? stents_->order() : std::optional<crn_wire_scaffold>();
}

std::optional<crn_wire_strut> SessionEffects::strut_order()
{
    return stents_ ? stents_->strut_order() : std::optional<crn_wire_strut>();
}

ReportSources report_sources(const SessionPictures &pictures)
{
    return {&pictures.room(), &pictures.contrast(), pictures.stents(), pictures.refusals()};
}

SessionSinks make_sinks(const PictureSettings &settings, const std::vector<Instrument> &tools,
                        bool wants_score, bool wants_effects)
{
    SessionSinks sinks;
    if (writes_pictures(settings) || wants_score)
        sinks.pictures = std::make_unique<SessionPictures>(settings, tools);
    else if (wants_effects)
        sinks.unseen = std::make_unique<SessionEffects>(settings, tools);
    return sinks;
}

FrameSink *SessionSinks::sink() const
{
    return pictures ? static_cast<FrameSink *>(pictures.get()) : unseen.get();
}

const SessionContrast *SessionSinks::contrast() const
{
    return pictures ? &pictures->contrast() : unseen ? unseen->contrast() : nullptr;
}

SessionStents *SessionSinks::stents() const
{
    return pictures ? pictures->stents() : unseen ? unseen->stents() : nullptr;
}

ReportSources SessionSinks::sources() const
{
    if (pictures) return report_sources(*pictures);
    return {nullptr, contrast(), stents(), contrast() ? contrast()->refusals() : std::vector<Refusal>()};
}

bool needs_effects(const Session &session)
{
    using Kind = Expectation::Kind;
    for (const Statement &statement : session.statements) {
        for (const RoomCommand &command : statement.room)
            if (command.action == RoomAction::inject) return true;
        if (!statement.expectation) continue;
        const Kind kind = statement.expectation->kind;
        if (kind == Kind::iodine || kind == Kind::stenosis || kind == Kind::apposition) return true;
    }
    return false;
}

} // namespace crn
