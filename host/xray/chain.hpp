// Holds the state of the signal chain between frames. The chain converts path lengths (paths.hpp) to the
// signal at the detector.
//
//    paths ─> transmission ─┬─> focal spot, pixel ─┬─> signal ─> photons ─> scintillator ─> lag ─> raw
//                           └─> scatter ───────────┘   (here)    (detector)                    ─> shown ─> grey
//                                                                                                (readout)
#pragma once
#include "host/xray/blur.hpp"
#include "host/xray/detector.hpp"
#include "host/xray/paths/path_keeper.hpp"
#include "host/xray/sparse_blur.hpp"
#include "host/xray/xray.hpp"

namespace crn
{

struct XrayScene::Meshes {
    BodyMeshes bodies;
};

// Holds the inputs for which a signal of the bodies was computed, except the paths.
struct SignalKey {
    XrayTechnique technique; // only voltage, copper and focal spot
    bool scatter = true;
    bool circular_field = false;
    double open_width_share = 0.0, open_height_share = 0.0;

    bool operator==(const SignalKey &) const = default;
};

struct XrayChain {
    XrayChain(const BodyMeshes &meshes, std::unique_ptr<BodyPaths> back_end, int thread_count)
        : paths(meshes, std::move(back_end), thread_count), threads(thread_count)
    {
    }

    PathKeeper paths;
    Exposure exposure;
    int threads;

    bool was_kept = false; // whether the last render reused the bodies' signal
    bool is_filled = false;
    SignalKey key;
    BeamTable beam;
    int size = 0;

    // This is true if `settled` is the exposure at which automatic exposure settles for a single picture of
    // these paths.
    bool is_settled = false;
    ExposureDemand settled_demand;
    SignalKey settled_key;
    ExposureChoice settled;

    // These values describe the signal of the bodies, kept between frames, as shares of the open beam behind
    // the grid.
    std::vector<OpenColumns> open;
    std::vector<float> transmission;  // of each pixel's middle
    std::vector<float> primary;       // the same after blur by focal spot and pixel
    std::vector<float> scatter_cells; // coarse grid
    std::vector<float> signal;        // primary and scattered
    std::vector<float> log_slow;      // slow part of log2(signal), coarse grid
    double log_mean = 0.0;            // log2(signal) over the measuring field
    BlurKernel focal_kernel;          // of the focal spot alone

    // These values describe the tools of this frame: their gain on the signal behind the bodies, minus one;
    // and then this gain after the focal spot's blur.
    std::vector<float> tool_gain;
    SparseBlur tool_blur;
    std::vector<float> tool_signal; // at the pixels of tool_blur
};

// Automatic exposure measures a round field with this diameter, as a share of the picture's width.
inline constexpr double measuring_field_share = 0.65;

// held_settings() limits settings to what the chain can do. demand_of() returns the demand that settings make
// on a pulse.
XraySettings held_settings(const XraySettings &settings);
ExposureDemand demand_of(const XraySettings &settings);

// Draws the paths. If the paths or the field have changed, all results kept from earlier frames are dropped.
void see_paths(XrayChain &chain, const XraySettings &settings, const XrayFrame &frame);

// Returns the technique at which automatic exposure settles in this view, whatever pulses came before.
ExposureChoice settle_exposure(XrayChain &chain, const XraySettings &settings, const ExposureDemand &demand);

// Computes the signal of the bodies for this technique, unless it has already been computed.
void see_signal(XrayChain &chain, const XraySettings &settings, const XrayTechnique &technique);

// Does both as one pulse. If the settings fix a technique, that technique is used. Otherwise the control
// takes the technique from `state`, and then updates `state` from the measured signal. If `state` is null, it
// is the technique at which the control settles.
ExposureChoice expose_bodies(XrayChain &chain, const XraySettings &settings, ExposureState *state);

// Computes chain.tool_signal, the signal behind the tools, for each pixel that their shadow touches.
void attenuate_tools(XrayChain &chain);

} // namespace crn
