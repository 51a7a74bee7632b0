// Makes one picture. Keeps the signal behind the patient from earlier pictures, and adds tools, photons and
// grey values for each new picture.
#include "host/xray/xray.hpp"
#include "host/xray/attenuation.hpp"
#include "host/xray/chain.hpp"
#include "host/xray/paths/parallel.hpp"
#include "host/xray/paths/raster_paths.hpp"
#include "host/xray/readout.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{
namespace
{

std::string describe(const Body &body, std::size_t index)
{
    return "body " + std::to_string(index) + " \"" + body.name + "\"";
}

// Swaps the signal at the tools' pixels with the signal behind the tools; a second call swaps them back.
void swap_tools(XrayChain &chain)
{
    const std::vector<std::int32_t> &pixels = chain.tool_blur.pixels();
    for (std::size_t i = 0; i < pixels.size(); ++i) std::swap(chain.signal[pixels[i]], chain.tool_signal[i]);
}

void count_all(const XrayChain &chain, const XraySettings &settings, std::uint64_t seed, XrayPicture &picture)
{
    const int size = chain.size;
    const std::uint32_t key = noise_key(seed, picture.tick);
    const auto photons_open = static_cast<float>(picture.photons_open);
    run_on_rows(chain.threads, size, 32, [&](const RowRange &rows) {
        std::vector<float> expected(size);
        for (int row = rows.begin; row < rows.end; ++row) {
            const std::size_t begin = static_cast<std::size_t>(row) * size;
            std::uint32_t *photons = picture.photons.data() + begin;
            for (int x = 0; x < size; ++x) expected[x] = chain.signal[begin + x] * photons_open;
            attenuate_faint(chain, row, expected.data());
            if (settings.beam.noise)
                count_row(expected.data(), size, key, static_cast<std::uint32_t>(begin), photons);
            else
                for (int x = 0; x < size; ++x)
                    photons[x] = static_cast<std::uint32_t>(static_cast<std::int32_t>(
                        std::min(expected[x] + 0.5f, static_cast<float>(photons_max))));
            std::fill(photons, photons + chain.open[row].begin, 0u);
            std::fill(photons + chain.open[row].end, photons + size, 0u);
        }
    });
}

// Returns the attenuation at the effective energy of a CT of 120 kV, relative to that of water.
double of_water(Material material)
{
    constexpr double water_per_cm = 0.19288; // at 70 keV, xraylib
    constexpr int below = 54;                // the table's steps of 69.5 and 70.5 keV
    static_assert(energy_keV(below) < 70.0 && energy_keV(below + 1) > 70.0);
    const float *per_cm = attenuation_per_cm[static_cast<int>(material)];
    return 0.5 * (static_cast<double>(per_cm[below]) + static_cast<double>(per_cm[below + 1])) / water_per_cm;
}

CtMixture ct_mixture()
{
    CtMixture mixture;
    mixture.soft_tissue = of_water(Material::soft_tissue);
    mixture.fat = of_water(Material::adipose);
    mixture.bone = of_water(Material::bone_cortical);
    return mixture;
}

double square(double value)
{
    return value * value;
}

double open_pixels(const XrayChain &chain)
{
    std::int64_t count = 0;
    for (const OpenColumns &row : chain.open) count += row.end - row.begin;
    return static_cast<double>(count);
}

// Computes the photons, the gain and the dose of a technique.
void expose(XrayChain &chain, const XraySettings &settings, const ExposureChoice &choice,
            XrayPicture &picture)
{
    const View &view = chain.paths.view();
    const double pixel_mm2 = square(view.pixel_m * 1e3);
    picture.technique = choice.technique;
    picture.is_underexposed = choice.is_limited;
    picture.photons_open = open_quanta_mm2(chain.beam, choice.technique, view.source_detector_m) * pixel_mm2;
    picture.raw_per_photon =
        raw_of_wanted_dose /
        (chain.exposure.wanted_quanta_mm2(settings.beam.dose_per_frame_nGy, chain.beam) * pixel_mm2);
    picture.air_kerma_uGy = reference_kerma_uGy(chain.beam, choice.technique, view.source_isocentre_m);
    const double nearer = (view.source_isocentre_m - reference_point_m) / view.source_detector_m;
    picture.kap_Gy_cm2 =
        picture.air_kerma_uGy * 1e-6 * open_pixels(chain) * pixel_mm2 * 1e-2 * square(nearer);
}

// If the size or the field of the picture changes, each pixel covers another area of the detector, so the
// stored lag is cleared.
void prepare_lag(const XraySettings &settings, std::uint32_t tick, XrayMemory &memory)
{
    const std::size_t pixels = static_cast<std::size_t>(settings.size) * settings.size;
    const bool goes_on = memory.is_used && memory.size == settings.size &&
                         memory.field_m == settings.carm.field_m && memory.trapped.size() == pixels;
    if (!goes_on) memory.trapped.assign(pixels, 0.0f);
    if (!goes_on) memory.tick = tick;
    memory.size = settings.size;
    memory.field_m = settings.carm.field_m;
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
    if (bodies.ct) {
        std::string fault;
        if (!check_ct_volume(*bodies.ct, fault)) {
            error = "the CT: " + fault;
            return false;
        }
        append_ct(meshes.bodies);
        meshes.ct = std::make_shared<RayCaster>(bodies.ct, ct_mixture().knots_permille());
    }
    *meshes_ = std::move(meshes);
    return true;
}

std::size_t XrayScene::triangle_count() const
{
    return meshes_->bodies.triangles.size();
}

Xray::Xray(const XrayScene &scene, int threads, const BodyPathsMaker &make_paths)
{
    const int processors = static_cast<int>(std::thread::hardware_concurrency());
    const int count = threads > 0 ? threads : std::clamp(processors, 1, 4);
    const BodyMeshes &meshes = scene.meshes().bodies;
    const int held = std::min(count, 16);
    std::unique_ptr<BodyPaths> paths;
    if (scene.meshes().ct)
        paths = std::make_unique<VolumePaths>(scene.meshes().ct, ct_mixture(), meshes, held);
    else if (make_paths)
        paths = make_paths(meshes, held);
    else
        paths = std::make_unique<RasterPaths>(meshes, held);
    chain_ = std::make_unique<XrayChain>(meshes, std::move(paths), held);
}
Xray::~Xray() = default;

void Xray::render(const XraySettings &settings, std::span<const RadiopaqueInstrument> tools,
                  const WireFrame &wire, std::uint64_t seed, XrayPicture &picture)
{
    render(settings, XrayFrame{tools, wire}, seed, nullptr, picture);
}

void Xray::render(const XraySettings &settings, std::span<const RadiopaqueInstrument> tools,
                  const WireFrame &wire, std::uint64_t seed, XrayMemory &memory, XrayPicture &picture)
{
    render(settings, XrayFrame{tools, wire}, seed, &memory, picture);
}

void Xray::render(const XraySettings &settings, const XrayFrame &frame, std::uint64_t seed,
                  XrayMemory *memory, XrayPicture &picture)
{
    const XraySettings held = held_settings(settings);
    XrayChain &chain = *chain_;
    see_paths(chain, held, frame);
    const ExposureChoice choice = expose_bodies(chain, held, memory ? &memory->exposure : nullptr);
    picture.size = held.size;
    picture.tick = frame.wire.tick;
    expose(chain, held, choice, picture);
    attenuate_tools(chain);
    swap_tools(chain);
    picture.photons.resize(static_cast<std::size_t>(held.size) * held.size);
    count_all(chain, held, seed, picture);
    swap_tools(chain);
    if (memory) prepare_lag(held, frame.wire.tick, *memory);
    read_out(chain, held.display, memory, picture);
    if (!memory) return;
    memory->tick = frame.wire.tick;
    memory->is_used = true;
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
    for (const std::int32_t pixel : tools.pixels)
        path[pixel] = (tools.sum(pixel, slot) + tool_rays / 2) / tool_rays;
    return path;
}

std::string_view Xray::back_end() const
{
    return chain_->paths.back_end();
}

const std::string &Xray::back_end_error() const
{
    return chain_->paths.back_end_error();
}

bool Xray::last_render_used_cache() const
{
    return chain_->was_kept;
}

} // namespace crn
