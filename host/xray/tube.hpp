// Tools as swept round tubes on one centreline: chord lengths along the rays, exact for cylinders cut at their joints'
// bisecting planes, so that neighbouring pieces neither overlap nor leave a gap. Averaged over 3x3 rays per pixel.
#pragma once
#include "host/model/wire_frame.hpp"
#include "host/xray/carm.hpp"
#include "host/xray/xray.hpp"
#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace seld
{

inline constexpr int tube_rays = 9; // per pixel

// Filled chord of each material, in 1/1024 mm times tube_rays, summed over the rays of a pixel.
struct TubePicture {
    int size = 0;
    std::array<std::vector<std::int32_t>, material_count> sums; // empty where the material is absent
    std::vector<std::int32_t> touched; // pixels with any chord, each once, in drawing order
    std::vector<std::uint8_t> is_touched;

    void clear(int new_size);
};

void draw_tools(std::span<const RadiopaqueInstrument> tools, const WireFrame &wire, const View &view,
                TubePicture &picture);

} // namespace seld
