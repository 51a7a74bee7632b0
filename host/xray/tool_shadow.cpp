// Computes the signal behind tools, struts and contrast medium.
#include "host/xray/chain.hpp"
#include "host/xray/paths/lanes.hpp"
#include "host/xray/paths/parallel.hpp"
#include <algorithm>

namespace crn
{
namespace
{

constexpr int rays_at_once = 64; // a multiple of 16, see transmission_row
constexpr int pixels_per_turn = 1024;

// A material that occurs in the bodies or in the tools.
struct Layer {
    int material;
    const std::int32_t *bodies; // of each pixel; nullptr if no body has this material
    std::int32_t pixels;        // of the picture
    int slot;                   // in the tools' path lengths; -1 if no tool has this material
};

std::vector<Layer> layers_of(const XrayChain &chain)
{
    const std::vector<Material> &drawn = chain.paths.tools().materials;
    std::vector<Layer> layers;
    for (int m = 0; m < material_count; ++m) {
        const std::vector<std::int32_t> &bodies = chain.paths.bodies()[m];
        const auto place = std::find(drawn.begin(), drawn.end(), static_cast<Material>(m));
        if (bodies.empty() && place == drawn.end()) continue;
        layers.push_back({m, bodies.empty() ? nullptr : bodies.data(), chain.size * chain.size,
                          place == drawn.end() ? -1 : static_cast<int>(place - drawn.begin())});
    }
    return layers;
}

// Some touched pixels, and the places of their path lengths. Runs are groups of pixels that lie side by side.
struct Block {
    struct Run {
        std::int32_t first_pixel, count;
    };
    int count = 0, rays = 0, runs = 0;
    std::array<std::int32_t, rays_at_once> entry;
    std::array<Run, rays_at_once> run;
    bool has_narrow() const { return rays > count; }
};

// Returns the number of rays that differ in one pixel.
int rays_of(const ToolPaths &tools, std::int32_t entry)
{
    return tools.narrow_entry[entry] < 0 ? 1 : tool_rays;
}

// Collects touched pixels from `begin` on until they have rays_at_once different rays, or until `end`.
void collect(const ToolPaths &tools, int begin, int end, Block &block)
{
    block.count = block.rays = block.runs = 0;
    for (int i = begin; i < end; ++i) {
        const std::int32_t pixel = tools.pixels[i], entry = tools.entry[pixel];
        const int rays = rays_of(tools, entry);
        if (block.rays + rays > rays_at_once) return;
        if (block.count == 0 || pixel != tools.pixels[i - 1] + 1) block.run[block.runs++] = {pixel, 0};
        block.run[block.runs - 1].count++;
        block.entry[block.count++] = entry;
        block.rays += rays;
    }
}

// Path lengths of the pixels of a block; whole lanes are written past their end.
using OfPixels = std::array<std::int32_t, rays_at_once + lane_count>;

// Copies the path lengths of the bodies. The runs are short, so a call of memcpy for each would cost more
// than the copy.
void copy_bodies(const Layer &layer, const Block &block, OfPixels &lengths)
{
    std::int32_t *to = lengths.data();
    for (int i = 0; i < block.runs; ++i) {
        const auto [first, count] = block.run[i];
        if (first + count + lane_count > layer.pixels) {
            std::copy_n(layer.bodies + first, count, to);
        } else {
            for (int k = 0; k < count; k += lane_count) {
                *reinterpret_cast<Lanes_i_anywhere *>(to + k) =
                    *reinterpret_cast<const Lanes_i_anywhere *>(layer.bodies + first + k);
                asm volatile("" ::: "memory"); // keeps the compiler from calling memcpy after all
            }
        }
        to += count;
    }
}

// Writes the path lengths of the rays of one pixel: their own and the common one. A tool cannot displace more
// of a material than lies on the ray, so no path length is below 0.
void spread(std::int32_t common, const std::int32_t *own, std::int32_t *length_q10mm)
{
    static_assert(tool_rays == lane_count + 1);
    Lanes_i first = common - Lanes_i{};
    if (own) first += *reinterpret_cast<const Lanes_i_anywhere *>(own);
    *reinterpret_cast<Lanes_i_anywhere *>(length_q10mm) = first > 0 ? first : Lanes_i{};
    length_q10mm[lane_count] = std::max(common + (own ? own[lane_count] : 0), 0);
}

// Writes the path lengths of the rays of a block in one material. Returns false, and writes nothing, if no
// ray meets the material.
bool fill(const ToolPaths &tools, const Layer &layer, const Block &block, std::int32_t *length_q10mm)
{
    OfPixels common;
    if (layer.bodies)
        copy_bodies(layer, block, common);
    else
        std::fill_n(common.begin(), block.count, 0);
    if (layer.slot >= 0)
        for (int i = 0; i < block.count; ++i) common[i] += tools.wide(block.entry[i])[layer.slot];
    else if (std::all_of(common.begin(), common.begin() + block.count,
                         [](int length) { return length == 0; }))
        return false;
    if (!block.has_narrow()) {
        for (int i = 0; i < block.count; ++i) length_q10mm[i] = std::max(common[i], 0);
        return true;
    }
    for (int i = 0; i < block.count; ++i) {
        const std::int32_t *narrow = tools.narrow(block.entry[i]);
        if (narrow) {
            spread(common[i], layer.slot >= 0 ? narrow + layer.slot * tool_rays : nullptr, length_q10mm);
            length_q10mm += tool_rays;
        } else {
            *length_q10mm++ = std::max(common[i], 0);
        }
    }
    return true;
}

// Computes the transmission of the pixels of a block. The transmissions of the rays of a pixel are averaged,
// because averaged path lengths would make thin metal too dark.
void transmit(const XrayChain &chain, const std::vector<Layer> &layers, const Block &block, float *share)
{
    const ToolPaths &tools = chain.paths.tools();
    std::array<std::array<std::int32_t, rays_at_once>, material_count> lengths_q10mm;
    std::array<const std::int32_t *, material_count> paths{};
    const int padded = (block.rays + 15) / 16 * 16;
    for (const Layer &layer : layers) {
        std::int32_t *line = lengths_q10mm[layer.material].data();
        if (!fill(tools, layer, block, line)) continue;
        std::fill(line + block.rays, line + padded, 0);
        paths[layer.material] = line;
    }
    std::array<float, rays_at_once> transmitted;
    transmission_row(chain.beam, paths, padded, transmitted.data());
    const float *of_ray = transmitted.data();
    for (int i = 0; i < block.count; ++i) {
        const int count = rays_of(tools, block.entry[i]);
        float sum = 0.0f;
        for (int ray = 0; ray < count; ++ray) sum += of_ray[ray];
        share[i] = count == 1 ? sum : sum * (1.0f / tool_rays);
        of_ray += count;
    }
}

// Computes the transmission of the touched pixels [begin, end), and from it their gain: the factor by which
// the tools change the signal behind the bodies, minus one.
void find_gain(XrayChain &chain, const std::vector<Layer> &layers, const RowRange &range)
{
    const ToolPaths &tools = chain.paths.tools();
    Block block;
    for (int begin = range.begin; begin < range.end; begin += block.count) {
        collect(tools, begin, range.end, block);
        transmit(chain, layers, block, chain.tool_gain.data() + begin);
    }
    for (int i = range.begin; i < range.end; ++i) {
        // The lower limit of 1e-12 avoids a division by zero, and a pixel that the bodies make black still
        // stays black.
        const float body = std::max(chain.transmission[tools.pixels[i]], 1e-12f);
        chain.tool_gain[i] = std::min(chain.tool_gain[i] / body, 1e3f) - 1.0f;
    }
}

// Squares whose faint medium is looked for together.
constexpr int squares_at_once = 16, pixels_at_once = squares_at_once * XrayChain::haze_pixels;

// Returns whether a row of pixels has faint medium in `count` columns.
bool has_faint(const float *length_mm, int count)
{
    float sum = 0.0f;
    for (int x = 0; x < count; ++x) sum = std::max(sum, length_mm[x]);
    return sum > 0.0f;
}

// Computes the slopes of some squares in a row from the transmissions at their middles, without and with a
// little medium.
void find_haze_squares(XrayChain &chain, const std::vector<Layer> &layers, int row, int first)
{
    constexpr std::int32_t probe_q10mm = 1024; // 1 mm
    const int count = std::min(squares_at_once, chain.haze_size() - first);
    const auto pixel_of = [&](int square) {
        return std::min(square * XrayChain::haze_pixels + XrayChain::haze_pixels / 2, chain.size - 1);
    };
    const std::size_t line = static_cast<std::size_t>(pixel_of(row)) * chain.size;
    std::array<std::array<std::int32_t, squares_at_once>, material_count> lengths_q10mm;
    std::array<const std::int32_t *, material_count> paths{};
    for (const Layer &layer : layers) {
        auto &lengths = lengths_q10mm[layer.material];
        lengths.fill(layer.material == static_cast<int>(Material::iohexol_350) ? probe_q10mm : 0);
        for (int i = 0; i < count && layer.bodies; ++i)
            lengths[i] += layer.bodies[line + pixel_of(first + i)];
        paths[layer.material] = lengths.data();
    }
    std::array<float, squares_at_once> transmitted;
    transmission_row(chain.beam, paths, squares_at_once, transmitted.data());
    for (int i = 0; i < count; ++i) {
        const std::size_t pixel = line + pixel_of(first + i),
                          square = static_cast<std::size_t>(row) * chain.haze_size() + first + i;
        chain.haze_slope[square] =
            std::clamp(chain.transmission[pixel] / std::max(transmitted[i], 1e-12f) - 1.0f, 0.0f, 10.0f);
        chain.haze_primary[square] =
            std::min(chain.primary[pixel] / std::max(chain.signal[pixel], 1e-12f), 1.0f);
    }
}

// Squares without faint medium keep old slopes, which no pixel uses.
void find_haze_row(XrayChain &chain, const std::vector<Layer> &layers, int row)
{
    const int y0 = row * XrayChain::haze_pixels, y1 = std::min(y0 + XrayChain::haze_pixels, chain.size);
    for (int x = 0; x < chain.size; x += pixels_at_once) {
        const int columns = std::min(pixels_at_once, chain.size - x);
        bool is_seen = false;
        for (int y = y0; y < y1 && !is_seen; ++y)
            is_seen = has_faint(
                chain.paths.tools().haze_mm.data() + static_cast<std::size_t>(y) * chain.size + x, columns);
        if (is_seen) find_haze_squares(chain, layers, row, x / XrayChain::haze_pixels);
    }
}

void find_haze(XrayChain &chain, const std::vector<Layer> &layers)
{
    if (chain.paths.tools().haze_mm.empty()) return;
    const int rows = chain.haze_size();
    chain.haze_slope.resize(static_cast<std::size_t>(rows) * rows);
    chain.haze_primary.resize(chain.haze_slope.size());
    run_on_rows(chain.threads, rows, 16, [&](const RowRange &range) {
        for (int row = range.begin; row < range.end; ++row) find_haze_row(chain, layers, row);
    });
}

} // namespace

void attenuate_faint(const XrayChain &chain, int row, float *signal)
{
    const std::vector<float> &haze_mm = chain.paths.tools().haze_mm;
    if (haze_mm.empty()) return;
    const float *length_mm = haze_mm.data() + static_cast<std::size_t>(row) * chain.size;
    const std::size_t squares = static_cast<std::size_t>(row / XrayChain::haze_pixels) * chain.haze_size();
    for (int begin = 0; begin < chain.size; begin += pixels_at_once) {
        const int end = std::min(begin + pixels_at_once, chain.size);
        if (!has_faint(length_mm + begin, end - begin)) continue;
        for (int x = begin; x < end; ++x) {
            const std::size_t square = squares + static_cast<std::size_t>(x / XrayChain::haze_pixels);
            const float weaker = chain.haze_slope[square] * length_mm[x];
            signal[x] *= 1.0f - chain.haze_primary[square] * weaker / (1.0f + weaker);
        }
    }
}

void attenuate_tools(XrayChain &chain)
{
    const ToolPaths &tools = chain.paths.tools();
    const int count = static_cast<int>(tools.pixels.size());
    const std::vector<Layer> layers = layers_of(chain);
    find_haze(chain, layers);
    chain.tool_gain.resize(count);
    run_on_rows(count > pixels_per_turn ? chain.threads : 1, count, pixels_per_turn,
                [&](const RowRange &range) { find_gain(chain, layers, range); });
    // The average over several rays per pixel already includes the blur by the pixel, and the signal of the
    // bodies is already blurred. The shadow of the tools must still be blurred by the focal spot, but not by
    // the pixel.
    chain.tool_blur.run(chain.size, tools.pixels, chain.tool_gain, chain.kernels->focal_spot);
    const std::vector<std::int32_t> &pixels = chain.tool_blur.pixels();
    chain.tool_signal.resize(pixels.size());
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        const float left = std::max(1.0f + chain.tool_blur.values()[i], 0.0f);
        const float primary = chain.primary[pixels[i]];
        chain.tool_signal[i] = primary * left + (chain.signal[pixels[i]] - primary);
    }
}

} // namespace crn
