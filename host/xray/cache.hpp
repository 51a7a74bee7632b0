// What an Xray keeps between frames: the sums of the bodies for one view, and the buffers of the frame.
#pragma once
#include "host/xray/detector.hpp"
#include "host/xray/raster.hpp"
#include "host/xray/tube.hpp"
#include "host/xray/xray.hpp"

namespace seld
{

struct XrayScene::Meshes {
    RasterMeshes raster;
};

using PathPictures = std::array<std::vector<std::int32_t>, material_count>; // 1/1024 mm; empty where absent

struct XrayCache {
    XrayCache(const RasterMeshes &of, int thread_count) : meshes(of), threads(thread_count) {}

    const RasterMeshes &meshes;
    int threads;

    // What the kept view was made for.
    bool is_filled = false;
    bool was_used = false;
    CArm carm;
    int size = 0;
    bool circular_field = false;
    double collimator_share = 0.0;

    // The kept view.
    View view;
    PathPictures paths;
    std::vector<OpenColumns> open;
    std::vector<float> scatter_slow; // scattered photons, share of the open beam, coarse grid
    std::vector<float> signal;       // primary and scattered photons, share of the open beam
    std::vector<float> log_slow;     // slow part of log2(signal), coarse grid
    double log_mean = 0.0;           // log2(signal) over the measuring field

    // Buffers.
    std::vector<std::vector<std::int32_t>> sums; // [thread], channel after channel
    std::vector<float> primary, log_signal;
    TubePicture tube;
    std::vector<float> tube_signal;
};

// Makes the kept view fit the settings; does nothing when it does already.
void fill_cache(XrayCache &cache, const XraySettings &settings);

} // namespace seld
