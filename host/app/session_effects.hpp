// What a session does in the vessels when nobody makes pictures of it: contrast medium and stents, the same as with pictures.
// May include: session_contrast, session_stents, frame_sink. Called by: cli_run, tests.
#pragma once
#include "host/app/frame_sink.hpp"
#include "host/app/run.hpp"
#include "host/app/session.hpp"
#include "host/app/session_contrast.hpp"
#include "host/app/session_pictures.hpp"
#include "host/app/session_stents.hpp"
#include <memory>

namespace crn
{

class SessionEffects final : public FrameSink
{
  public:
    // Vessels, motion and lesions from the files that the settings name. Throws std::runtime_error.
    SessionEffects(const PictureSettings &settings, const std::vector<Instrument> &tools);

    void command(std::uint32_t tick, const RoomCommand &command) override;
    void tick(const crn_wire_encoders &input, const crn_wire_tick_state &state) override;
    std::uint32_t next_tick() const override { return next_look(); }
    void frame(const SessionFrame &frame) override { look(frame); }
    std::uint32_t next_look() const override;
    void look(const SessionFrame &frame) override;
    bool needs_beginning() const override { return true; }
    std::optional<crn_wire_scaffold> order() override;
    std::optional<crn_wire_strut> strut_order() override;
    void finish() override {}

    const SessionContrast *contrast() const { return contrast_.get(); } // null: the scene has no vessels
    SessionStents *stents() const { return stents_.get(); }             // null: the session has none

  private:
    std::unique_ptr<SessionContrast> contrast_;
    std::unique_ptr<SessionStents> stents_;
};

ReportSources report_sources(const SessionPictures &pictures);

// Who looks at a session: pictures where some are wanted, else what it does in the vessels where somebody asks for that.
struct SessionSinks {
    std::unique_ptr<SessionPictures> pictures; // at most one of the two
    std::unique_ptr<SessionEffects> unseen;

    FrameSink *sink() const; // null: nobody looks
    const SessionContrast *contrast() const;
    SessionStents *stents() const;
    ReportSources sources() const;
};
// A score needs the dose, and so the pictures.
SessionSinks make_sinks(const PictureSettings &settings, const std::vector<Instrument> &tools,
                        bool wants_score, bool wants_effects);

// The script injects, or expects something of medium, lesions or stents.
bool needs_effects(const Session &session);

} // namespace crn
