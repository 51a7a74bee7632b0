// Pictures of a session: C-arm and table that follow what was asked for, X-ray per frame, last image hold, files.
// The X-ray of a frame is a pure function of wire, C-arm, bodies, instrument, seed and tick. Gliding table, turning C-arm
// and dose sums have a history: they begin where playing begins, so a replay --from S shows them from S on.
// May include: xray, picture, frame_sink. Called by: cli.
#pragma once
#include "host/app/frame_sink.hpp"
#include "host/app/path_choice.hpp"
#include "host/app/picture.hpp"
#include "host/app/picture_overlay.hpp"
#include "host/model/instrument.hpp"
#include "host/xray/xray.hpp"
#include <memory>
#include <optional>
#include <string>

namespace seld
{

// C-arm turns at 40 deg/s, the table glides at 100 mm/s; following the tip, it is caught up with in about half a second.
class ViewMotion
{
  public:
    // The C-arm `seconds` after the last call; the first call jumps.
    CArm advance(const ViewState &wanted, const WireFrame &wire, double seconds);

  private:
    CArm carm_;
    bool is_first_ = true;
};

// Throws std::runtime_error naming the section and the known materials when a material is unknown.
RadiopaqueInstrument instrument_look(const Instrument &instrument);

struct PictureSettings {
    std::string bodies_path; // empty: air
    std::string png_path;    // last picture; empty: none
    std::string mp4_path;    // empty: none
    int size = 512;
    std::uint32_t pictures_per_second = 15;
    std::uint64_t seed = 1;
    int threads = 0;
    std::string xray = "raster"; // of path_choices
    GlOpener window_context;     // where there is a window
};

class SessionPictures final : public FrameSink
{
  public:
    // `tools` from the innermost. Throws std::runtime_error.
    SessionPictures(const PictureSettings &settings, const std::vector<Instrument> &tools);
    ~SessionPictures() override;
    void frame(const SessionFrame &frame) override;
    void finish() override;
    std::uint32_t count() const { return count_; }
    const Image &image() const { return image_; } // the last picture with its display
    // Notice and help panel from the next picture on; empty for none.
    void annotate(const std::string &notice, const std::vector<std::string> &panel);
    // The tool that the keys move, or all, marked in the display from the next picture on.
    void choose_tool(std::size_t tool, bool all)
    {
        chosen_tool_ = tool;
        chooses_all_ = all;
    }
    void
    redraw(const SessionFrame &frame); // the display again over the last X-ray, for a change of annotation

  private:
    void tell_failure();
    OverlayInfo display(const SessionFrame &frame, bool is_beam_on) const;

    PictureSettings settings_;
    std::vector<RadiopaqueInstrument> looks_;
    std::vector<std::string> names_;
    std::optional<std::size_t> chosen_tool_;
    bool chooses_all_ = false;
    std::string notice_;
    std::vector<std::string> panel_;
    XrayScene scene_;
    std::unique_ptr<Xray> xray_; // after the scene has its bodies
    ViewMotion motion_;
    CArm carm_;
    bool is_beam_on_ = false;
    XrayPicture picture_; // held while fluoroscopy is off
    bool has_picture_ = false;
    bool told_failure_ = false;
    Image image_;
    VideoWriter movie_;
    std::uint32_t count_ = 0;
    double fluoro_s_ = 0.0, kerma_mGy_ = 0.0;
};

} // namespace seld
