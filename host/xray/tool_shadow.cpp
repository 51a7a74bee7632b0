// Computes the signal behind tools, struts and contrast medium.
#include "host/xray/chain.hpp"
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
        layers.push_back({m, bodies.empty() ? nullptr : bodies.data(),
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

// Writes the path lengths of the rays of a block in one material. A tool cannot displace more of a material
// than lies on the ray, so no path length is below 0.
void fill(const ToolPaths &tools, const Layer &layer, const Block &block, std::int32_t *length_q10mm)
{
    std::array<std::int32_t, rays_at_once> common{};
    std::int32_t *next = common.data();
    if (layer.bodies)
        for (int i = 0; i < block.runs; ++i)
            next = std::copy_n(layer.bodies + block.run[i].first_pixel, block.run[i].count, next);
    if (layer.slot >= 0)
        for (int i = 0; i < block.count; ++i) common[i] += tools.wide(block.entry[i])[layer.slot];
    if (!block.has_narrow()) {
        for (int i = 0; i < block.count; ++i) length_q10mm[i] = std::max(common[i], 0);
        return;
    }
    for (int i = 0; i < block.count; ++i) {
        const std::int32_t *narrow = tools.narrow(block.entry[i]);
        const int rays = narrow ? tool_rays : 1;
        const bool has_own = narrow && layer.slot >= 0;
        for (int ray = 0; ray < rays; ++ray)
            *length_q10mm++ = std::max(common[i] + (has_own ? narrow[layer.slot * tool_rays + ray] : 0), 0);
    }
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
        fill(tools, layer, block, line);
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

// Computes the slopes of a row of squares from the transmissions at their middles, without and with a little
// medium.
void find_haze_row(XrayChain &chain, const std::vector<Layer> &layers, int row)
{
    constexpr std::int32_t probe_q10mm = 1024; // 1 mm
    const int count = chain.haze_size(), padded = (count + 15) / 16 * 16;
    const auto pixel_of = [&](int square) {
        return std::min(square * XrayChain::haze_pixels + XrayChain::haze_pixels / 2, chain.size - 1);
    };
    const std::size_t line = static_cast<std::size_t>(pixel_of(row)) * chain.size;
    std::array<std::vector<std::int32_t>, material_count> lengths_q10mm;
    std::array<const std::int32_t *, material_count> paths{};
    for (const Layer &layer : layers) {
        std::vector<std::int32_t> &lengths = lengths_q10mm[layer.material];
        lengths.assign(static_cast<std::size_t>(padded), 0);
        for (int i = 0; i < count && layer.bodies; ++i) lengths[i] = layer.bodies[line + pixel_of(i)];
        if (layer.material == static_cast<int>(Material::iohexol_350))
            for (std::int32_t &length : lengths) length += probe_q10mm;
        paths[layer.material] = lengths.data();
    }
    std::vector<float> transmitted(static_cast<std::size_t>(padded));
    transmission_row(chain.beam, paths, padded, transmitted.data());
    for (int i = 0; i < count; ++i) {
        const std::size_t pixel = line + pixel_of(i), square = static_cast<std::size_t>(row) * count + i;
        chain.haze_slope[square] =
            std::clamp(chain.transmission[pixel] / std::max(transmitted[i], 1e-12f) - 1.0f, 0.0f, 10.0f);
        chain.haze_primary[square] =
            std::min(chain.primary[pixel] / std::max(chain.signal[pixel], 1e-12f), 1.0f);
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
    for (int x = 0; x < chain.size; ++x) {
        const std::size_t square = squares + static_cast<std::size_t>(x / XrayChain::haze_pixels);
        const float weaker = chain.haze_slope[square] * length_mm[x];
        signal[x] *= 1.0f - chain.haze_primary[square] * weaker / (1.0f + weaker);
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
