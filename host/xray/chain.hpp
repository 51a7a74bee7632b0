// Holds the state of the signal chain, which is kept from frame to frame. The signal chain converts path
// lengths (paths.hpp) to the signal at the detector.
//
//    paths ─> transmission ─┬─> focal spot, pixel ─┬─> signal ─> photons ─> scintillator ─> lag ─> raw
//                           └─> scatter ───────────┘   (here)    (detector)                    ─> shown ─> grey
//                                                                                                (readout)
#pragma once
#include "host/xray/blur.hpp"
#include "host/xray/detector.hpp"
#include "host/xray/paths/path_keeper.hpp"
#include "host/xray/sparse_blur.hpp"
#include "host/xray/volume/volume_paths.hpp"
#include "host/xray/xray.hpp"

namespace crn
{

struct XrayScene::Meshes {
    BodyMeshes bodies;
    std::shared_ptr<const RayCaster> ct; // null: the patient consists of meshes alone
};

// Holds the inputs, except the path lengths, with which the signal behind the bodies was last computed.
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

    // `is_settled` is true if `settled` holds the exposure at which automatic exposure settles for a single
    // picture with the present path lengths.
    bool is_settled = false;
    ExposureDemand settled_demand;
    SignalKey settled_key;
    ExposureChoice settled;

    // The next members, which are kept between frames, hold the signal behind the bodies as a fraction of the
    // open beam's signal behind the grid.
    std::vector<OpenColumns> open;
    std::vector<float> transmission;    // of each pixel's middle
    std::vector<float> primary;         // the same after blur by focal spot and pixel
    std::vector<float> scatter_cells;   // coarse grid
    std::vector<float> signal;          // primary and scattered
    std::vector<float> log_slow;        // slow part of log2(signal), coarse grid
    double log_mean = 0.0;              // log2(signal) over the measuring field
    std::optional<BlurKernels> kernels; // of the view and the focal spot

    // The next members describe the tools of this frame. tool_gain holds the factor by which the tools change
    // the signal behind the bodies, minus one; tool_blur holds this gain after the focal spot's blur.
    std::vector<float> tool_gain;
    SparseBlur tool_blur;
    std::vector<float> tool_signal; // at the pixels of tool_blur
    // How much the primary beam weakens per mm of faint medium (ToolPaths::haze_mm), and the share of the
    // primary beam in the signal; of squares of haze_pixels pixels.
    std::vector<float> haze_slope, haze_primary;
    static constexpr int haze_pixels = 4;
    int haze_size() const { return (size + haze_pixels - 1) / haze_pixels; }
};

// Gives the diameter of the round field in which automatic exposure measures the signal, as a fraction of the
// picture's width.
inline constexpr double measuring_field_share = 0.65;

// held_settings() limits the X-ray settings to the ranges that the signal chain supports. demand_of() returns
// the dose, mode and distances that these settings pass to automatic exposure.
XraySettings held_settings(const XraySettings &settings);
ExposureDemand demand_of(const XraySettings &settings);

// Draws the paths. If the path lengths or the collimated field have changed, all results kept from earlier
// frames are dropped.
void see_paths(XrayChain &chain, const XraySettings &settings, const XrayFrame &frame);

// Returns the technique (voltage, current, pulse width, filter) that automatic exposure reaches in this view,
// whatever pulses came before.
ExposureChoice settle_exposure(XrayChain &chain, const XraySettings &settings, const ExposureDemand &demand);

// Computes the signal behind the bodies for this technique, unless this signal has already been computed.
void see_signal(XrayChain &chain, const XraySettings &settings, const XrayTechnique &technique);

// Does both as one pulse. If the settings contain a fixed technique (voltage, current, pulse width and
// filter), that technique is used. Without a fixed technique, automatic exposure takes the technique from
// `state`, and then updates `state` from the measured signal. If `state` is null, the function uses the
// technique at which automatic exposure settles for this view.
ExposureChoice expose_bodies(XrayChain &chain, const XraySettings &settings, ExposureState *state);

// Computes chain.tool_signal, the signal behind the tools, for each pixel that the shadow of the tools
// touches.
void attenuate_tools(XrayChain &chain);

// Multiplies the signal of a row by what the faint medium of this frame leaves of it. Call it after
// attenuate_tools().
void attenuate_faint(const XrayChain &chain, int row, float *signal);

} // namespace crn
