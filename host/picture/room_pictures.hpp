// Computes the pictures of the X-ray room: one picture for every pulse, the screen that shows them, and the
// DICOM files of the runs. The pictures are computed from copies of the patient's state at each pulse, so a
// thread other than the patient's may compute them.
//
//   RoomPictures pictures(settings, tools, patient.scene(), anatomy, room);
//   PulseShot shot = shot_of(patient, shape, tick, settings);       in the patient's thread
//   pictures.take(event, &shot);                                    every event in order
//   pictures.screen().compose(size, grey);
#pragma once
#include "host/model/instrument.hpp"
#include "host/model/scene_anatomy.hpp"
#include "host/patient/patient.hpp"
#include "host/patient/pulse_shot.hpp"
#include "host/picture/dicom_export.hpp"
#include "host/picture/path_choice.hpp"
#include "host/room/room_screen.hpp"
#include "host/xray/style/vcsim3.hpp"
#include "host/xray/xray.hpp"
#include <memory>
#include <string>
#include <vector>

namespace crn
{

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
    LineNumbers line{};                      // tools on the line at the start (tool_line.hpp); empty: all
};

// Returns what a pulse at `tick` sees; the settings state the filling of balloons (pulse_shot.hpp).
inline PulseShot shot_of(Patient &patient, const WireFrame &shape, std::uint32_t tick,
                         const PictureSettings &settings)
{
    return shot_of(patient, shape, tick, settings.balloon_iodine_mg_per_ml);
}

class RoomPictures
{
  public:
    // `tools` is the table of the session's tools; each PulseShot says which of them are in use. `scene` and
    // `room` must live longer than this object. Throws std::runtime_error.
    RoomPictures(const PictureSettings &settings, const std::vector<Instrument> &tools,
                 const XrayScene &scene, const SceneAnatomy &anatomy, const Room &room);
    ~RoomPictures();

    // Receives the events of the X-ray room in order. `shot` holds what an X-ray pulse sees; for every other
    // event, `shot` is null.
    void take(const RoomEvent &event, const PulseShot *shot);
    const RoomScreen &screen() const { return room_screen_; }
    RoomScreen &screen() { return room_screen_; }
    const XrayPicture &pulse() const { return pulse_; } // of the last pulse
    int size() const { return settings_.size; }
    // Writes the DICOM files of the runs, if the settings name a folder for them. Returns false if the user
    // pressed Ctrl-C during the export, so that some files are missing. Adds the names of the written files
    // to `files`.
    bool finish_export(const Patient &patient, std::vector<std::string> &files);

  private:
    void expose(const RoomEvent &pulse, const PulseShot &shot);
    void tell_failure();
    void export_pulse(const RoomEvent &pulse);

    PictureSettings settings_;
    std::vector<RadiopaqueInstrument> looks_; // of the table
    std::unique_ptr<Xray> xray_;
    std::unique_ptr<Vcsim3Look> thesis_look_; // when that style is selected
    RoomScreen room_screen_;
    XrayMemory memory_;
    XrayPicture pulse_;
    bool told_failure_ = false;
    std::unique_ptr<DicomExport> export_;
    // Holds, for each exported run, the index of its pedal press in the dose meter's list.
    std::vector<std::size_t> exported_presses_;
};

} // namespace crn
