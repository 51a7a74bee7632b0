// The signal chain's state between frames: from path lengths (paths.hpp) to the signal at the detector.
//
//     paths ─> transmission ─┬─> focal spot, pixel ─┬─> signal ─> photons ─> scintillator ─> lag ─> raw ─>
//     shown ─> grey
//                            └─> scatter ───────────┘   (here)    (detector, readout)
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

// What a signal of the bodies is made for, besides the paths.
struct SignalKey {
    XrayTechnique technique; // voltage, copper and focal spot alone
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

    bool was_kept = false; // the bodies' signal, by the last render
    bool is_filled = false;
    SignalKey key;
    BeamTable beam;
    int size = 0;

    // The exposure on which a single picture of these paths settles.
    bool is_settled = false;
    ExposureDemand settled_demand;
    SignalKey settled_key;
    ExposureChoice settled;

    // The kept signal of the bodies, as shares of the open beam behind the grid.
    std::vector<OpenColumns> open;
    std::vector<float> transmission;  // of each pixel's middle
    std::vector<float> primary;       // the same behind focal spot and pixel
    std::vector<float> scatter_cells; // coarse grid
    std::vector<float> signal;        // primary and scattered
    std::vector<float> log_slow;      // slow part of log2(signal), coarse grid
    double log_mean = 0.0;            // log2(signal) over the measuring field
    BlurKernel focal_kernel;          // of the focal spot alone

    // Of this frame's tools: share of what bodies let through, less one; then the same behind the focal spot.
    std::vector<float> tool_gain;
    SparseBlur tool_blur;
    std::vector<float> tool_signal; // at the pixels of tool_blur
};

// Diameter of the round field that automatic exposure measures, share of the picture.
inline constexpr double measuring_field_share = 0.65;

// Settings within what the chain can do, and what they ask of a pulse.
XraySettings held_settings(const XraySettings &settings);
ExposureDemand demand_of(const XraySettings &settings);

// Draws the paths. Everything kept is given up when they or the field have changed.
void see_paths(XrayChain &chain, const XraySettings &settings, const XrayFrame &frame);

// The technique on which automatic exposure comes to rest in this view, whatever was before.
ExposureChoice settle_exposure(XrayChain &chain, const XraySettings &settings, const ExposureDemand &demand);

// Makes the bodies' signal for this technique; does nothing when it is there.
void see_signal(XrayChain &chain, const XraySettings &settings, const XrayTechnique &technique);

// Both, as one pulse: the technique that is fixed, else the one that control takes from `state`, which then
// follows what was seen; without a state the one on which control comes to rest.
ExposureChoice expose_bodies(XrayChain &chain, const XraySettings &settings, ExposureState *state);

// Signal behind the tools, for each pixel that their shadow touches: chain.tool_signal.
void attenuate_tools(XrayChain &chain);

} // namespace crn
