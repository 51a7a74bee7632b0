#include "host/xray/meter.hpp"
#include "host/xray/chain.hpp"
#include "host/xray/paths/raster_paths.hpp"
#include <algorithm>
#include <numbers>

namespace crn
{

double reference_area_cm2(const CArm &carm, const XrayBeam &beam)
{
    const double width = beam.open_width_share, height = beam.open_height_share;
    const double narrow = std::min(width, height);
    const double open = beam.circular_field ? 0.25 * std::numbers::pi * narrow * narrow : width * height;
    const double nearer = (carm.source_isocentre_m - reference_point_m) / carm.source_detector_m;
    return open * carm.field_m * carm.field_m * nearer * nearer * 1e4;
}

XrayMeter::XrayMeter(const XrayScene &scene, int threads) : scene_(scene), threads_(threads) {}
XrayMeter::~XrayMeter() = default;

XrayExposure XrayMeter::expose(const XraySettings &settings, std::span<const MovedBody> bodies,
                               MeterPace pace)
{
    XraySettings held = held_settings(settings);
    held.size = chamber_pixels;
    if (!chain_) {
        const BodyMeshes &bodies_at_rest = scene_.meshes().bodies;
        chain_ = std::make_unique<XrayChain>(
            bodies_at_rest, std::make_unique<RasterPaths>(bodies_at_rest, threads_), threads_);
    }
    XrayChain &chain = *chain_;
    const WireFrame nothing;
    XrayFrame frame{{}, nothing};
    frame.bodies = bodies;
    see_paths(chain, held, frame);
    const ExposureChoice choice = expose_bodies(chain, held, pace == MeterPace::follows ? &state_ : nullptr);
    XrayExposure exposure{choice.technique, choice.is_limited, 0.0, 0.0};
    exposure.air_kerma_uGy = reference_kerma_uGy(chain.beam, choice.technique, held.carm.source_isocentre_m);
    exposure.kap_Gy_cm2 = exposure.air_kerma_uGy * 1e-6 * reference_area_cm2(held.carm, held.beam);
    return exposure;
}

void XrayMeter::archive(StateArchive &state)
{
    state.real(state_.water_cm, 0.0, 100.0);
    state.real(state_.copper_mm, 0.0, 10.0);
}

} // namespace crn
