#include "host/app/session_pictures.hpp"
#include "host/model/bodies.hpp"
#include <algorithm>
#include <cstdio>
#include <stdexcept>

namespace seld
{

namespace
{

constexpr double carm_deg_per_s = 40.0;
constexpr double table_m_per_s = 0.10;
constexpr double follow_share_per_s = 2.0; // of the remaining distance

double toward(double present, double wanted, double step)
{
    return present + std::clamp(wanted - present, -step, step);
}

} // namespace

CArm ViewMotion::advance(const ViewState &wanted, const WireFrame &wire, double seconds)
{
    const double primary_deg = wanted.primary_mdeg * 1e-3;
    const double secondary_deg = wanted.secondary_mdeg * 1e-3;
    const bool follows = wanted.follows_tip && !wire.nodes.empty();
    const Eigen::Vector3d table_m =
        Eigen::Vector3d(wanted.table_um[0], wanted.table_um[1], wanted.table_um[2]) * 1e-6;
    const Eigen::Vector3d target_m = follows ? wire.nodes.front().position_m : table_m;
    carm_.field_m = wanted.field_um * 1e-6;
    if (is_first_) {
        carm_.primary_deg = primary_deg;
        carm_.secondary_deg = secondary_deg;
        carm_.isocentre_m = target_m;
        is_first_ = false;
        return carm_;
    }
    carm_.primary_deg = toward(carm_.primary_deg, primary_deg, carm_deg_per_s * seconds);
    carm_.secondary_deg = toward(carm_.secondary_deg, secondary_deg, carm_deg_per_s * seconds);
    for (int i = 0; i < 3; i++) {
        const double gap_m = (target_m[i] - carm_.isocentre_m[i]) *
                             (follows ? std::min(1.0, follow_share_per_s * seconds) : 1.0);
        carm_.isocentre_m[i] += std::clamp(gap_m, -table_m_per_s * seconds, table_m_per_s * seconds);
    }
    return carm_;
}

RadiopaqueInstrument instrument_look(const Instrument &instrument)
{
    RadiopaqueInstrument look;
    for (const InstrumentLayer &layer : instrument.layers) {
        const std::optional<Material> material = material_from_name(layer.material);
        if (!material) {
            throw std::runtime_error("instrument '" + instrument.name + "': unknown X-ray material '" +
                                     layer.material + "'; known: " + material_names());
        }
        look.sections.push_back(
            {layer.arc_begin_m, layer.arc_end_m, *material, layer.fill, layer.radius_share});
    }
    for (std::uint16_t i = 0; i < instrument.table.knots_count; i++) {
        const seld_wire_knot &knot = instrument.table.knots[i];
        look.radii.push_back({knot.arc_um * 1e-6, knot.radius_outer_um * 1e-6, knot.radius_inner_um * 1e-6});
    }
    return look;
}

SessionPictures::SessionPictures(const PictureSettings &settings, const std::vector<Instrument> &tools)
    : settings_(settings)
{
    for (const Instrument &tool : tools) {
        looks_.push_back(instrument_look(tool));
        names_.push_back(tool.name);
    }
    settings_.size = held_size(settings.size);
    std::string error;
    Bodies bodies;
    if (!settings_.bodies_path.empty() && !read_bodies(settings_.bodies_path, bodies, error)) {
        throw std::runtime_error(error);
    }
    if (!scene_.set_bodies(bodies, error)) throw std::runtime_error(settings_.bodies_path + ": " + error);
    xray_ = std::make_unique<Xray>(scene_, settings_.threads,
                                   paths_maker(settings_.xray, settings_.window_context));
    const bool needs_movie = !settings_.mp4_path.empty();
    if (needs_movie && !movie_.open(settings_.mp4_path, settings_.size, settings_.size,
                                    static_cast<int>(settings_.pictures_per_second), error)) {
        throw std::runtime_error(error);
    }
}

SessionPictures::~SessionPictures() = default;

OverlayInfo SessionPictures::display(const SessionFrame &frame, bool is_beam_on) const
{
    OverlayInfo info;
    info.primary_deg = carm_.primary_deg;
    info.secondary_deg = carm_.secondary_deg;
    info.field_m = carm_.field_m;
    info.time_s = frame.wire.tick * 1e-3;
    for (std::size_t k = 0; k < frame.tools.size(); k++) {
        const ToolReading &tool = frame.tools[k];
        info.tools.push_back({k < names_.size() ? names_[k] : "", tool.inserted_m * 1e3, tool.turned_deg,
                              tool.axial_N, tool.torque_N_m * 1e3,
                              frame.tools.size() > 1 && (chosen_tool_ == k || chooses_all_)});
    }
    info.fluoro_s = fluoro_s_;
    info.kerma_mGy = kerma_mGy_;
    info.is_beam_on = is_beam_on;
    info.notice = notice_;
    info.panel = panel_;
    return info;
}

// With the pedal down a new X-ray is made; otherwise the last one is held and only the display goes on.
void SessionPictures::frame(const SessionFrame &frame)
{
    const double period_s = 1.0 / settings_.pictures_per_second;
    carm_ = motion_.advance(frame.view, frame.wire, period_s);
    is_beam_on_ = frame.view.is_fluoro_on || !has_picture_;
    if (is_beam_on_) {
        XraySettings xray;
        xray.carm = carm_;
        xray.size = settings_.size;
        xray_->render(xray, looks_, frame.wire, settings_.seed, picture_);
        tell_failure();
        has_picture_ = true;
        kerma_mGy_ += picture_.air_kerma_uGy * 1e-3;
        fluoro_s_ += period_s;
    }
    redraw(frame);
    count_++;
    std::string error;
    if (movie_.is_open() && !movie_.add(image_, error)) throw std::runtime_error(error);
}

// A graphics driver that gives up does not end a session: the rasteriser goes on.
void SessionPictures::tell_failure()
{
    if (told_failure_ || xray_->back_end_error().empty()) return;
    told_failure_ = true;
    std::fprintf(stderr, "seldinger: %s; the rasteriser draws from here on\n",
                 xray_->back_end_error().c_str());
}

void SessionPictures::annotate(const std::string &notice, const std::vector<std::string> &panel)
{
    notice_ = notice;
    panel_ = panel;
}

void SessionPictures::redraw(const SessionFrame &frame)
{
    image_ = compose_display(picture_, display(frame, is_beam_on_));
}

void SessionPictures::finish()
{
    std::string error;
    if (movie_.is_open() && !movie_.finish(error)) throw std::runtime_error(error);
    if (!settings_.png_path.empty() && count_ > 0 && !write_png(settings_.png_path, image_, error)) {
        throw std::runtime_error(error);
    }
}

} // namespace seld
