#include "host/picture/room_pictures.hpp"
#include "host/base/interrupt.hpp"
#include "host/base/progress_line.hpp"
#include "host/base/terminal.hpp"
#include <cstdio>

namespace crn
{
namespace
{

constexpr int shown_bits = 12; // of XrayPicture::shown

} // namespace

RoomPictures::RoomPictures(const PictureSettings &settings, const std::vector<Instrument> &tools,
                           const XrayScene &scene, const SceneAnatomy &anatomy, const Room &room)
    : settings_(settings), room_screen_(room)
{
    std::string session;
    for (const Instrument &tool : tools) {
        looks_.push_back(instrument_look(tool));
        session += tool.name + "\n";
    }
    settings_.size = held_size(settings.size);
    xray_ = std::make_unique<Xray>(scene, settings_.threads,
                                   paths_maker(settings_.xray, settings_.window_context));
    if (settings_.style == "vcsim3")
        thesis_look_ = std::make_unique<Vcsim3Look>(anatomy.bodies, settings_.threads);
    if (!settings_.dicom.folder.empty()) export_ = std::make_unique<DicomExport>(settings_.dicom, session);
}

RoomPictures::~RoomPictures() = default;

void RoomPictures::take(const RoomEvent &event, const PulseShot *shot)
{
    if (shot) expose(event, *shot);
    room_screen_.take(event, shot ? &pulse_ : nullptr);
}

// Computes the picture of an X-ray pulse, with the exposure technique that automatic exposure control has
// chosen.
void RoomPictures::expose(const RoomEvent &pulse, const PulseShot &shot)
{
    XraySettings xray;
    xray.carm = pulse.request.carm;
    xray.beam = pulse.request.beam;
    xray.beam.fixed_technique = pulse.exposure.technique;
    xray.size = settings_.size;
    const std::vector<RadiopaqueInstrument> on_line = looks_on(looks_, shot.line);
    const XrayFrame seen{on_line, shot.shape, shot.curves, shot.bodies};
    xray_->render(xray, seen, settings_.seed, pulse.request.settles_at_once ? nullptr : &memory_, pulse_);
    tell_failure();
    if (export_) export_pulse(pulse); // exported data stay physical
    if (thesis_look_) thesis_look_->draw(xray, seen, settings_.seed, pulse_);
}

// If a graphics driver fails, the session goes on, and the rasteriser computes the path lengths.
void RoomPictures::tell_failure()
{
    if (told_failure_ || xray_->back_end_error().empty()) return;
    told_failure_ = true;
    say(stderr, "cournand: %s; the rasteriser draws from here on\n", xray_->back_end_error().c_str());
}

// All X-ray pulses from pressing a pedal to releasing it form one run.
void RoomPictures::export_pulse(const RoomEvent &pulse)
{
    const bool shows_display = settings_.dicom.values == "display";
    if (exported_presses_.empty() || exported_presses_.back() != pulse.press) {
        XrayRun run = RoomScreen::describe(pulse, pulse_);
        run.window_width = 0.0; // set for the whole run at its end
        if (shows_display) {
            run.relation = PixelRelation::display;
            run.bits = shown_bits;
            run.window_centre = XrayDisplay{}.level;
            run.window_width = XrayDisplay{}.window;
        }
        export_->begin(run);
        exported_presses_.push_back(pulse.press);
    }
    RunFrame frame = RoomScreen::frame_of(pulse, pulse_);
    if (shows_display) frame.raw = pulse_.shown;
    export_->add(std::move(frame));
}

// If the user presses Ctrl-C during the session, the runs made so far are written nevertheless. A second
// Ctrl-C stops the export between two pieces of a file.
bool RoomPictures::finish_export(const Patient &patient, std::vector<std::string> &files)
{
    if (!export_) return true;
    export_->end();
    if (export_->run_count() == 0) {
        say(stderr, "cournand: --dicom %s: no file, because the pedal was never down\n",
            settings_.dicom.folder.c_str());
        export_.reset();
        return true;
    }
    // The user may change the mask while reviewing a run, and the files contain the last mask of each run.
    const std::vector<Irradiation> &presses = patient.room().dose().irradiations();
    for (std::size_t i = 0; i < exported_presses_.size(); i++) {
        const int kept = presses[exported_presses_[i]].run;
        const StoredRun *stored = kept > 0 ? room_screen_.store().find(kept) : nullptr;
        if (stored && stored->run.mask) export_->set_mask(i, *stored->run.mask);
    }
    export_->set_contrast(
        [&](std::uint32_t first, std::uint32_t last) { return patient.contrast().given(first, last); });
    const bool was_interrupted = is_interrupted();
    std::size_t wanted = 0;
    ProgressLine line(settings_.shows_progress);
    const std::vector<std::string> written = export_->finish([&](const ExportProgress &now) {
        wanted = now.files;
        line.show("writing " + now.name + " (" + std::to_string(now.file) + " of " +
                      std::to_string(now.files) + ")",
                  now.bytes_done, now.bytes);
        return was_interrupted || !is_interrupted();
    });
    const bool was_stopped = written.size() < wanted;
    if (was_stopped)
        say(stderr, "cournand: stopped: %zu of %zu DICOM files were written, each of them whole\n",
            written.size(), wanted);
    files.insert(files.end(), written.begin(), written.end());
    export_.reset();
    return !was_stopped;
}

} // namespace crn
