#include "host/library/renderer.hpp"
#include "host/patient/balloon.hpp"
#include "host/xray/paths/tube.hpp"
#include <cmath>

namespace crn::library
{

namespace
{

constexpr std::uint32_t known_flags = COURNAND_VIEW_LABELS | COURNAND_VIEW_NO_NOISE |
                                      COURNAND_VIEW_NO_SCATTER | COURNAND_VIEW_SEQUENCE |
                                      COURNAND_VIEW_LABELS_ONLY;
constexpr int medium_min_q10mm = 32; // mean path of undiluted medium: 1/32 mm

double within(double value, double least, double most, const char *name)
{
    if (value >= least && value <= most) return value; // refuses NaN, too
    throw Refused(COURNAND_BAD_ARGUMENT, std::string("view: ") + name + " is " + std::to_string(value) +
                                             ", not within " + std::to_string(least) + " and " +
                                             std::to_string(most));
}

double or_default(double value, double usual, double least, double most, const char *name)
{
    return value == 0.0 ? usual : within(value, least, most, name);
}

} // namespace

XraySettings xray_settings(const cournand_view &view)
{
    require((view.flags & ~known_flags) == 0, "view: flags has an unknown bit");
    XraySettings settings;
    CArm &carm = settings.carm;
    carm.primary_deg = within(view.primary_deg, -120.0, 120.0, "primary_deg");
    carm.secondary_deg = within(view.secondary_deg, -50.0, 50.0, "secondary_deg");
    for (int axis = 0; axis < 3; axis++)
        carm.isocentre_m[axis] = within(view.isocentre_m[axis], -1.9, 1.9, "isocentre_m");
    carm.source_detector_m = or_default(view.source_detector_m, 1.05, 0.9, 1.3, "source_detector_m");
    carm.source_isocentre_m = or_default(view.source_isocentre_m, 0.75, 0.6, 0.85, "source_isocentre_m");
    carm.field_m = or_default(view.field_m, 0.32, 0.1, 0.45, "field_m");
    settings.beam.dose_per_frame_nGy = or_default(view.dose_nGy, 40.0, 1.0, 10000.0, "dose_nGy");
    settings.beam.noise = (view.flags & COURNAND_VIEW_NO_NOISE) == 0;
    settings.beam.scatter = (view.flags & COURNAND_VIEW_NO_SCATTER) == 0;
    settings.size = view.size == 0 ? 512 : static_cast<int>(std::min<std::uint32_t>(view.size, 1u << 20));
    require(held_size(settings.size) == settings.size,
            "view: size is not a multiple of 16 within 64 and 2048");
    return settings;
}

void write_matrix(const cournand_view &given, double matrix[12])
{
    const XraySettings settings = xray_settings(given);
    const View view = make_view(settings.carm, settings.size);
    const double focal = view.source_detector_m / view.pixel_m, middle = view.size * 0.5;
    const Eigen::Vector3d rows[3] = {focal * view.right + middle * view.forward,
                                     -focal * view.up + middle * view.forward, view.forward};
    for (int row = 0; row < 3; row++) {
        for (int axis = 0; axis < 3; axis++) matrix[4 * row + axis] = rows[row][axis];
        matrix[4 * row + 3] = -rows[row].dot(view.source_m);
    }
}

Renderer::Renderer(std::shared_ptr<const Scene> scene, std::uint32_t threads)
    : scene_(std::move(scene)), xray_(scene_->xray(), static_cast<int>(threads)), poses_(scene_->anatomy())
{
}

PulseShot Renderer::shot_at(World &world)
{
    const WireFrame &frame = world.frame();
    if (Patient *patient = world.patient())
        return shot_of(*patient, frame, world.tick(), balloon_iodine_mg_per_ml);
    PulseShot shot;
    shot.shape = frame;
    shot.curves = balloon_filling(frame, world.tools_on_line(), balloon_iodine_mg_per_ml);
    const std::span<const MovedBody> bodies = poses_.at(frame);
    shot.bodies.assign(bodies.begin(), bodies.end());
    return shot;
}

void Renderer::render(World &world, const cournand_view &view, cournand_picture &picture)
{
    if (&world.scene() != scene_.get())
        throw Refused(COURNAND_BAD_ARGUMENT,
                      "the world is not of the renderer's scene: make a renderer for it");
    const XraySettings settings = xray_settings(view);
    const PulseShot shot = shot_at(world);
    const bool has_picture = (view.flags & COURNAND_VIEW_LABELS_ONLY) == 0;
    const bool has_labels = !has_picture || (view.flags & COURNAND_VIEW_LABELS) != 0;
    picture.size = static_cast<std::uint32_t>(settings.size);
    picture.tick = world.tick();
    if (has_labels) choose_labels(world, shot);
    const XrayFrame frame{world.looks_on_line(), shot.shape, shot.curves, shot.bodies,
                          has_labels ? &labels_ : nullptr};
    if (has_picture) {
        XrayMemory *memory = (view.flags & COURNAND_VIEW_SEQUENCE) != 0 ? &memory_ : nullptr;
        xray_.render(settings, frame, view.seed, memory, picture_);
        picture.is_underexposed = picture_.is_underexposed;
        picture.grey = picture_.grey.data();
        picture.raw = picture_.raw.data();
        picture.tube_voltage_kV = picture_.technique.tube_voltage_kV;
        picture.tube_current_mA = picture_.technique.tube_current_mA;
        picture.pulse_ms = picture_.technique.pulse_ms;
        picture.air_kerma_uGy = picture_.air_kerma_uGy;
        picture.kap_Gy_cm2 = picture_.kap_Gy_cm2;
    } else {
        draw_tubes(frame, make_view(settings.carm, settings.size), Material::blood, paths_);
    }
    if (has_labels) picture.labels = labels_.pixels.data();
}

// The curves of the X-ray shot come in this order: the balloon, the struts, and the contrast medium
// (shot_of).
void Renderer::choose_labels(World &world, const PulseShot &shot)
{
    const std::size_t balloon =
        balloon_filling(shot.shape, world.tools_on_line(), balloon_iodine_mg_per_ml).size();
    const std::size_t medium = world.patient() ? world.patient()->contrast().curves().size() : 0;
    labels_.tool_bits = {COURNAND_LABEL_TOOL_0, COURNAND_LABEL_TOOL_1, COURNAND_LABEL_TOOL_2};
    labels_.curves = {{balloon, COURNAND_LABEL_BALLOON, 0},
                      {shot.curves.size() - balloon - medium, COURNAND_LABEL_STENT, 0},
                      {medium, COURNAND_LABEL_MEDIUM, medium_min_q10mm * tool_rays}};
}

} // namespace crn::library
