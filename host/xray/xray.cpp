// One picture: kept view of the patient, instrument on top, photons, grey values.
#include "host/xray/xray.hpp"
#include "host/xray/chain.hpp"
#include "host/xray/parallel.hpp"
#include "host/xray/raster_paths.hpp"
#include <algorithm>
#include <cmath>

namespace seld
{
namespace
{

constexpr double measuring_floor_log2 = -13.0; // the tube cannot give more than this asks for

std::string describe(const Body &body, std::size_t index)
{
    return "body " + std::to_string(index) + " \"" + body.name + "\"";
}

XraySettings held_settings(const XraySettings &settings)
{
    XraySettings held = settings;
    held.carm = clamp_carm(settings.carm);
    held.size = held_size(settings.size);
    held.beam.collimator_share = std::clamp(settings.beam.collimator_share, 0.2, 1.0);
    held.beam.dose_per_frame_nGy = std::clamp(settings.beam.dose_per_frame_nGy, 0.1, 1e5);
    return held;
}

// Puts the tools' values into the signal, and takes them out again when called a second time.
void swap_tools(XrayChain &chain)
{
    const std::vector<std::int32_t> &pixels = chain.paths.tools().pixels;
    for (std::size_t i = 0; i < pixels.size(); ++i) std::swap(chain.signal[pixels[i]], chain.tool_signal[i]);
}

void count_all(const XrayChain &chain, const XraySettings &settings, std::uint64_t seed, XrayPicture &picture)
{
    const int size = chain.size;
    const std::uint32_t key = noise_key(seed, picture.tick);
    const auto photons_open = static_cast<float>(picture.photons_open);
    run_on_threads(chain.threads, [&](int thread) {
        std::vector<float> expected(size);
        const RowRange rows = rows_of_thread(thread, chain.threads, size);
        for (int row = rows.begin; row < rows.end; ++row) {
            const std::size_t begin = static_cast<std::size_t>(row) * size;
            std::uint16_t *photons = picture.photons.data() + begin;
            for (int x = 0; x < size; ++x) expected[x] = chain.signal[begin + x] * photons_open;
            if (settings.beam.noise)
                count_row(expected.data(), size, key, static_cast<std::uint32_t>(begin), photons);
            else
                for (int x = 0; x < size; ++x)
                    photons[x] = static_cast<std::uint16_t>(std::min(expected[x] + 0.5f, 65535.0f));
            std::fill(photons, photons + chain.open[row].begin, std::uint16_t{0});
            std::fill(photons + chain.open[row].end, photons + size, std::uint16_t{0});
        }
    });
}

// Light spread of the scintillator: [1 4 1]/6 along both axes. Sum of nine weighted counts, 36 per photon.
void blur_row(const XrayPicture &picture, int row, float *column, float *blurred)
{
    const int size = picture.size;
    const int above = std::max(row - 1, 0), below = std::min(row + 1, size - 1);
    const std::uint16_t *a = picture.photons.data() + static_cast<std::size_t>(above) * size;
    const std::uint16_t *b = picture.photons.data() + static_cast<std::size_t>(row) * size;
    const std::uint16_t *c = picture.photons.data() + static_cast<std::size_t>(below) * size;
    for (int x = 0; x < size; ++x) column[x + 1] = static_cast<float>(a[x] + 4 * b[x] + c[x]);
    column[0] = column[1];
    column[size + 1] = column[size];
    for (int x = 0; x < size; ++x) blurred[x] = column[x] + 4.0f * column[x + 1] + column[x + 2];
}

struct Curve {
    float slope, level, keep_slow, log_mean, log_open;
};

Curve make_curve(const XrayChain &chain, const XrayDisplay &display, double photons_open)
{
    Curve curve;
    curve.slope = static_cast<float>(0.70 * std::clamp(display.contrast, 0.1, 10.0));
    curve.level = static_cast<float>(0.12 + std::clamp(display.brightness, -1.0, 1.0));
    curve.keep_slow = static_cast<float>(1.0 - std::clamp(display.harmonise, 0.0, 1.0));
    curve.log_mean = static_cast<float>(chain.log_mean);
    curve.log_open = log2_positive(static_cast<float>(photons_open) * 36.0f);
    return curve;
}

// Log image, slow changes held down, then an S-curve: few photons (bone, metal) are dark.
void display_row(const Curve &curve, const float *blurred, const float *slow, int size, std::uint8_t *grey)
{
    for (int x = 0; x < size; ++x) {
        const float share_log2 = log2_positive(blurred[x] + 18.0f) - curve.log_open;
        const float value = (share_log2 - slow[x]) + curve.keep_slow * (slow[x] - curve.log_mean);
        const float t = value * curve.slope + curve.level;
        const float s = t / std::sqrt(1.0f + t * t); // -1 .. 1
        grey[x] = static_cast<std::uint8_t>(static_cast<std::int32_t>(128.0f + 127.0f * s));
    }
}

void display_all(const XrayChain &chain, const XraySettings &settings, XrayPicture &picture)
{
    const int size = chain.size;
    const Curve curve = make_curve(chain, settings.display, picture.photons_open);
    run_on_threads(chain.threads, [&](int thread) {
        std::vector<float> scratch(2 * size + 2), slow(size);
        const RowRange rows = rows_of_thread(thread, chain.threads, size);
        for (int row = rows.begin; row < rows.end; ++row) {
            std::uint8_t *grey = picture.grey.data() + static_cast<std::size_t>(row) * size;
            slow_row(chain.log_slow, size, row, slow.data());
            blur_row(picture, row, scratch.data() + size, scratch.data());
            display_row(curve, scratch.data(), slow.data(), size, grey);
            std::fill(grey, grey + chain.open[row].begin, std::uint8_t{0});
            std::fill(grey + chain.open[row].end, grey + size, std::uint8_t{0});
        }
    });
}

// Automatic exposure: the dose behind the patient is held, however thick he is.
void set_exposure(const XrayChain &chain, const XraySettings &settings, XrayPicture &picture)
{
    const double pixel_mm2 = chain.paths.view().pixel_m * chain.paths.view().pixel_m * 1e6;
    const double wanted = settings.beam.dose_per_frame_nGy / kerma_behind_patient_nGy_mm2 * pixel_mm2;
    const double log_mean = std::max(chain.log_mean, measuring_floor_log2);
    // A power of two of a double would need libm: the polynomial's result is taken as it is.
    picture.photons_open =
        wanted / static_cast<double>(exp2_negative(static_cast<float>(std::max(-log_mean, 0.0))));
    const double nearer =
        chain.paths.view().source_detector_m / (chain.paths.view().source_isocentre_m - 0.15);
    picture.air_kerma_uGy = picture.photons_open / pixel_mm2 * kerma_open_nGy_mm2 * nearer * nearer * 1e-3;
}

} // namespace

int held_size(int size)
{
    return (std::clamp(size, 64, 2048) + 15) / 16 * 16;
}

XrayScene::XrayScene() : meshes_(std::make_unique<Meshes>()) {}
XrayScene::~XrayScene() = default;

bool XrayScene::set_bodies(const Bodies &bodies, std::string &error)
{
    *meshes_ = Meshes();
    if (!check_bodies(bodies, error)) return false;
    std::vector<int> materials;
    for (std::size_t i = 0; i < bodies.bodies.size(); ++i) {
        const Body &body = bodies.bodies[i];
        std::optional<Material> material = material_from_name(body.material);
        if (!material) {
            error = describe(body, i) + ": unknown material \"" + body.material + "\"; use one of " +
                    material_names();
            return false;
        }
        materials.push_back(static_cast<int>(*material));
    }
    Meshes meshes;
    for (std::size_t i = 0; i < bodies.bodies.size(); ++i) {
        const Body &body = bodies.bodies[i];
        const int parent = body.parent >= 0 ? materials[body.parent] : -1;
        append_body(meshes.bodies, body, materials[i], parent);
    }
    *meshes_ = std::move(meshes);
    return true;
}

std::size_t XrayScene::triangle_count() const
{
    return meshes_->bodies.triangles.size();
}

Xray::Xray(const XrayScene &scene, int threads)
{
    const int processors = static_cast<int>(std::thread::hardware_concurrency());
    const int count = threads > 0 ? threads : std::clamp(processors, 1, 4);
    const BodyMeshes &meshes = scene.meshes().bodies;
    const int held = std::min(count, 16);
    chain_ = std::make_unique<XrayChain>(meshes, std::make_unique<RasterPaths>(meshes, held), held);
}
Xray::~Xray() = default;

void Xray::render(const XraySettings &settings, std::span<const RadiopaqueInstrument> tools,
                  const WireFrame &wire, std::uint64_t seed, XrayPicture &picture)
{
    const XraySettings held = held_settings(settings);
    XrayChain &chain = *chain_;
    see(chain, held, tools, wire);
    picture.size = held.size;
    picture.tick = wire.tick;
    picture.grey.resize(static_cast<std::size_t>(held.size) * held.size);
    picture.photons.resize(picture.grey.size());
    set_exposure(chain, held, picture);
    attenuate_tools(chain);
    swap_tools(chain);
    count_all(chain, held, seed, picture);
    swap_tools(chain);
    display_all(chain, held, picture);
}

std::vector<std::int32_t> Xray::body_path_q10mm(Material material) const
{
    return chain_->paths.bodies()[static_cast<int>(material)];
}

std::vector<std::int32_t> Xray::instrument_path_q10mm(Material material) const
{
    const ToolPaths &tools = chain_->paths.tools();
    const auto place = std::find(tools.materials.begin(), tools.materials.end(), material);
    if (place == tools.materials.end()) return {};
    const std::size_t slot = place - tools.materials.begin();
    std::vector<std::int32_t> path(static_cast<std::size_t>(tools.size) * tools.size, 0);
    for (std::size_t i = 0; i < tools.pixels.size(); ++i)
        path[tools.pixels[i]] = (tools.sum(i, slot) + tool_rays / 2) / tool_rays;
    return path;
}

bool Xray::last_render_used_cache() const
{
    return chain_->was_kept;
}

} // namespace seld
