// The signal chain's state between frames: from path lengths (paths.hpp) to the signal at the detector.
#pragma once
#include "host/xray/detector.hpp"
#include "host/xray/path_keeper.hpp"
#include "host/xray/xray.hpp"

namespace seld
{

struct XrayScene::Meshes {
    BodyMeshes bodies;
};

struct XrayChain {
    XrayChain(const BodyMeshes &meshes, std::unique_ptr<BodyPaths> back_end, int thread_count)
        : paths(meshes, std::move(back_end), thread_count), threads(thread_count)
    {
    }

    PathKeeper paths;
    int threads;

    // What the kept signal was made for, besides the paths.
    bool was_kept = false;
    int size = 0;
    bool circular_field = false;
    double collimator_share = 0.0;

    // The kept signal of the bodies.
    std::vector<OpenColumns> open;
    std::vector<float> scatter_slow; // scattered photons, share of the open beam, coarse grid
    std::vector<float> signal;       // primary and scattered photons, share of the open beam
    std::vector<float> log_slow;     // slow part of log2(signal), coarse grid
    double log_mean = 0.0;           // log2(signal) over the measuring field

    // Buffers.
    std::vector<float> primary, log_signal;
    std::vector<float> tool_signal; // at the pixels of paths.tools()
};

// Makes paths and signal those of these settings; the signal is without the tools.
void see(XrayChain &chain, const XraySettings &settings, std::span<const RadiopaqueInstrument> tools,
         const WireFrame &wire);

// Signal behind the tools, for each pixel that they touch: chain.tool_signal.
void attenuate_tools(XrayChain &chain);

} // namespace seld
