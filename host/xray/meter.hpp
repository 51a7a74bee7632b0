// The measuring chamber behind the patient: which technique automatic exposure takes for a pulse, and the
// dose of it, without a picture. What it sees has a size of its own, so that the dose of a session does not
// depend on which pictures are made of it.
//
//   XrayMeter meter(scene);
//   const XrayExposure exposure = meter.expose(settings, bodies, MeterPace::follows);
//   settings.beam.fixed_technique = exposure.technique;       // and render, if somebody wants a picture
//
// See docs/xray.md.
#pragma once
#include "host/xray/xray.hpp"
#include <memory>
#include <span>

namespace crn
{

// How the control takes the pulse before into account.
enum class MeterPace {
    follows, // from pulse to pulse, as a generator does
    settles  // where test exposures come to rest: the first frame of DSA
};

// What one pulse is taken with, and what it costs.
struct XrayExposure {
    XrayTechnique technique;
    bool is_underexposed = false; // the control is at a limit
    double air_kerma_uGy = 0.0;   // at the reference point, 15 cm from the isocentre toward the tube
    double kap_Gy_cm2 = 0.0;      // kerma times the area of the open field there
};

// Area of the open field at the reference point, in cm2. Kerma there times this is the kerma-area product,
// which is the same at every distance.
double reference_area_cm2(const CArm &carm, const XrayBeam &beam);

class XrayMeter
{
  public:
    static constexpr int chamber_pixels = 128; // along each edge

    explicit XrayMeter(const XrayScene &scene, int threads = 1);
    ~XrayMeter();
    XrayMeter(const XrayMeter &) = delete;
    XrayMeter &operator=(const XrayMeter &) = delete;

    // One pulse through the bodies as they are now; tools and medium are too small to count. Display and size
    // of the settings are ignored.
    XrayExposure expose(const XraySettings &settings, std::span<const MovedBody> bodies, MeterPace pace);

  private:
    std::unique_ptr<XrayChain> chain_;
    ExposureState state_;
};

} // namespace crn
