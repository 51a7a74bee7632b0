// Computes, draws and writes the pictures that the patient's X-ray room takes in a session. Computing a
// picture reads the patient's state and does not change it. The pictures depend only on the patient, on the
// shapes of the tools at the requested ticks, and on the seed of the noise. In a replay that starts later
// (--from S), C-arm and table still apply all earlier commands; dose, runs and following of the tip begin at
// S.
#pragma once
#include "host/model/instrument.hpp"
#include "host/model/scene_anatomy.hpp"
#include "host/patient/patient.hpp"
#include "host/picture/dicom_export.hpp"
#include "host/picture/overlay.hpp"
#include "host/picture/path_choice.hpp"
#include "host/picture/picture.hpp"
#include "host/room/room_screen.hpp"
#include "host/session/frame_sink.hpp"
#include "host/xray/style/vcsim3.hpp"
#include "host/xray/xray.hpp"
#include <memory>
#include <optional>
#include <string>

namespace crn
{

// Throws std::runtime_error if a material is unknown; the message names the section and the known materials.
RadiopaqueInstrument instrument_look(const Instrument &instrument);

struct PictureSettings {
    std::string bodies_path;    // empty: air
    std::string scene_path;     // the scene with their motion; empty: they do not move
    std::string png_path;       // file for the last picture; empty: none
    std::string png16_path;     // file for the values of the last X-ray; empty: none
    std::string mp4_path;       // empty: none
    DicomSettings dicom;        // files for the runs
    bool shows_progress = true; // during long exports, on standard error
    int size = 512;
    std::uint32_t pictures_per_second = 15;
    std::uint64_t seed = 1;
    int threads = 0;
    std::string style =
        "physical"; // docs/xray.md, or vcsim3: docs/xray-style.md; doses and counts stay physical
    std::string xray = "raster";             // one of path_choices
    GlOpener window_context;                 // set if there is a window
    std::vector<StentDesign> stents;         // stents that a session may load, in this order
    double balloon_iodine_mg_per_ml = 175.0; // filling of balloons
};

// read_anatomy() reads the anatomy from the files that the settings name. make_patient() makes a patient with
// that anatomy and with the stents of the settings. Throws std::runtime_error.
SceneAnatomy read_anatomy(const PictureSettings &settings);
std::unique_ptr<Patient> make_patient(const PictureSettings &settings, const SceneAnatomy &anatomy,
                                      const std::vector<Instrument> &tools);

// Returns true if the settings request any picture file.
bool writes_pictures(const PictureSettings &settings);

class SessionPictures final : public FrameSink
{
  public:
    // `tools` lists the tools from the innermost outwards. `patient` must live longer than this object.
    // Throws std::runtime_error.
    SessionPictures(const PictureSettings &settings, const std::vector<Instrument> &tools, Patient &patient,
                    const SceneAnatomy &anatomy);
    ~SessionPictures() override;
    std::uint32_t next_tick() const override;
    void frame(const SessionFrame &frame) override;
    void finish() override;
    const RoomScreen &screen() const { return room_screen_; }
    std::uint32_t count() const { return count_; } // pictures of the screen, at the settings' rate
    const std::vector<std::string> &files() const { return files_; } // the files written by finish()
    void show_refusal(std::uint32_t tick, const std::string &why);   // shown in the display for a while
    bool was_stopped() const
    {
        return was_stopped_;
    }                                             // Ctrl-C came while finish() wrote runs: some are missing
    const Image &image() const { return image_; } // the last picture with its display
    Image plain_image() const { return {settings_.size, settings_.size, 1, screen_.grey}; } // without it
    // Sets the notice and the help panel for the following pictures; empty texts remove them.
    void annotate(const std::string &notice, const std::vector<std::string> &panel);
    // From the next picture on, the display marks the tool that the user moves with the keys, or marks all
    // tools.
    void choose_tool(std::size_t tool, bool all)
    {
        chosen_tool_ = tool;
        chooses_all_ = all;
    }
    void redraw(const SessionFrame
                    &frame); // draws the display again over the last X-ray, after a change of annotation

  private:
    void tell_failure();
    OverlayInfo display(const SessionFrame &frame) const;
    bool see_events(const WireFrame &wire);
    void expose(const RoomEvent &pulse, const WireFrame &wire);
    std::vector<SweptCurve> curves_at(const WireFrame &shape);
    OverlayBalloon balloon_display() const;
    void export_pulse(const RoomEvent &pulse);
    void finish_export();

    PictureSettings settings_;
    std::vector<RadiopaqueInstrument> looks_;
    std::vector<std::string> names_;
    std::optional<std::size_t> chosen_tool_;
    bool chooses_all_ = false;
    std::string notice_;
    RoomNotice refused_; // key commands that could not be carried out
    std::vector<std::string> panel_;
    Patient &patient_;
    std::unique_ptr<Xray> xray_;
    std::unique_ptr<Vcsim3Look> thesis_look_; // when that style is selected
    RoomScreen room_screen_;
    const std::vector<Instrument> tools_;
    XrayMemory memory_;
    XrayPicture pulse_;  // of the last pulse
    XrayPicture screen_; // its grey values are shown
    bool told_failure_ = false;
    Image image_;
    VideoWriter movie_;
    std::unique_ptr<DicomExport> export_;
    std::vector<std::string> files_;
    bool was_stopped_ = false;
    std::vector<std::size_t>
        exported_presses_; // the pedal press of each run: index into the dose meter's list
    std::uint32_t count_ = 0;
};

} // namespace crn
