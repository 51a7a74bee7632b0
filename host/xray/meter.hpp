// Simulates the measuring chamber of automatic exposure, which lies behind the patient. Even when no picture
// is wanted, the chamber determines the technique that automatic exposure takes for a pulse, and the dose of
// that pulse. The chamber measures a small picture of fixed size, so that the dose of a session does not
// depend on which pictures the program makes.
//
//   XrayMeter meter(scene);
//   const XrayExposure exposure = meter.expose(settings, bodies, MeterPace::follows);
//    settings.beam.fixed_technique = exposure.technique;       // and render, if a picture is wanted
//
// See docs/xray.md.
#pragma once
#include "host/base/state_archive.hpp"
#include "host/xray/xray.hpp"
#include <memory>
#include <span>

namespace crn
{

// States how automatic exposure uses the signal of the previous pulse.
enum class MeterPace {
    follows, // from pulse to pulse, as a generator does
    settles  // as after test exposures, until the control has settled: the first frame of DSA
};

// Holds the technique (voltage, current, pulse width, filter) and the dose of one pulse.
struct XrayExposure {
    XrayTechnique technique;
    bool is_underexposed = false; // the control is at a limit
    double air_kerma_uGy = 0.0;   // at the reference point, 15 cm from the isocentre toward the tube
    double kap_Gy_cm2 = 0.0;      // kerma times the area of the open field there
};

// Returns the area of the open field at the reference point, in cm2. The kerma-area product is the kerma at
// the reference point times the area of the open field there; it is the same at every distance from the
// source.
double reference_area_cm2(const CArm &carm, const XrayBeam &beam);

class XrayMeter
{
  public:
    static constexpr int chamber_pixels = 128; // along each edge

    // `scene` must live longer than the meter.
    explicit XrayMeter(const XrayScene &scene, int threads = 1);
    ~XrayMeter();
    XrayMeter(const XrayMeter &) = delete;
    XrayMeter &operator=(const XrayMeter &) = delete;

    // Simulates one X-ray pulse through the bodies at their present positions. Tools and contrast medium are
    // ignored, because they are too small to change the exposure. The display window and the picture size in
    // the settings are ignored.
    XrayExposure expose(const XraySettings &settings, std::span<const MovedBody> bodies, MeterPace pace);

    void archive(StateArchive &state); // the memory of the exposure control

  private:
    const XrayScene &scene_;
    int threads_;
    std::unique_ptr<XrayChain> chain_; // made at the first pulse, because many sessions have none
    ExposureState state_;
};

} // namespace crn
