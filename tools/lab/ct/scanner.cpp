#include "tools/lab/ct/scanner.hpp"
#include "host/xray/paths/parallel.hpp"
#include "tools/lab/ct/scanner_parts.hpp"
#include "tools/lab/ct/volume/volume_io.hpp"
#include <algorithm>
#include <atomic>
#include <cmath>
#include <exception>
#include <mutex>

namespace crn::ct
{

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace
{

constexpr int slice_planes = 7;           // planes of a slice's profile, 0.7 sigma apart
constexpr double around_mm = 3;           // margin of air in the picture
constexpr double photons_least = 2;       // least number of photons that a starved ray counts
constexpr double electronic_photons = 15; // standard deviation of the read-out

// Returns an independent random number for every ray, made by the last step of the generator splitmix64; the
// order of the calls does not matter.
std::uint64_t mixed(std::uint64_t value)
{
    value += 0x9e3779b97f4a7c15u;
    value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9u;
    value = (value ^ (value >> 27)) * 0x94d049bb133111ebu;
    return value ^ (value >> 31);
}

double normal_number(std::uint64_t seed, std::uint64_t number)
{
    const std::uint64_t bits = mixed(mixed(seed) ^ number);
    const double u = (static_cast<double>(bits >> 32) + 0.5) / 4294967296.0,
                 v = static_cast<double>(bits & 0xffffffffu) / 4294967296.0;
    return std::sqrt(-2 * std::log(u)) * std::cos(6.283185307179586 * v);
}

class Scan
{
  public:
    Scan(const bake::Mesh &lumen, const PhantomMaterials &phantom,
         const std::vector<ScanInstrument> &instruments, const ScannerSettings &settings, Volume &volume,
         const Eigen::AlignedBox3d &box_lps, const Vector3d &centre)
        : settings_(settings), volume_(volume), centre_(centre), fluid_(1 + phantom.fluid_HU * 1e-3),
          planes_(lumen, phantom, box_lps, centre), tubes_(instruments, centre),
          beam_(settings.tube_kV, tubes_.materials()),
          rays_(settings.views, bins_for(volume, settings.detector_mm), settings.detector_mm),
          back_(rays_, settings.blur_mm)
    {
        double sum = 0;
        for (int i = 0; i < slice_planes; ++i) {
            const double sigmas = 0.7 * (i - slice_planes / 2);
            heights_[i] = sigmas * settings.blur_slice_mm;
            sum += weights_[i] = std::exp(-0.5 * sigmas * sigmas);
        }
        for (double &weight : weights_) weight /= sum;
        photons_ = settings.noise_HU > 0 ? photons_for_noise() : 0;
    }

    void slice(int index)
    {
        const double height = volume_.lps({0, 0, double(index)}).z() - centre_.z();
        std::vector<float> water(rays_.count(), 0.0f);
        std::vector<Edge> edges;
        for (int plane = 0; plane < slice_planes; ++plane) {
            planes_.edges_at(height + heights_[plane], edges);
            add_chords(edges, rays_, weights_[plane], water);
        }
        const std::vector<float> metal = through_instruments(height, water);
        for (std::size_t ray = 0; ray < water.size(); ++ray) {
            double seen = metal.empty() ? -1 : static_cast<double>(metal[ray]);
            if (seen < 0) {
                if (photons_ <= 0) continue;
                seen = beam_.water_transmission(static_cast<double>(water[ray]));
            }
            water[ray] = static_cast<float>(beam_.water_for(photons_ > 0 ? counted(seen, index, ray) : seen));
        }
        back_.filter(water);
        const Vector3d first = volume_.lps({0, 0, double(index)}) - centre_;
        float *out = &volume_.hu[volume_.at(0, 0, index)];
        back_.project_back(water, first.head<2>(), settings_.spacing_mm.head<2>(), volume_.size[0],
                           volume_.size[1], out);
        const auto pixels =
            static_cast<std::size_t>(volume_.size[0]) * static_cast<std::size_t>(volume_.size[1]);
        for (std::size_t i = 0; i < pixels; ++i)
            out[i] = std::round(std::clamp(out[i], -1024.0f, static_cast<float>(settings_.highest_HU)));
    }

  private:
    // Returns the number of detector bins that cover the volume's diagonal, with some extra bins at each end
    // for the interpolation.
    static int bins_for(const Volume &volume, double pitch_mm)
    {
        const double x = volume.size[0] * volume.spacing_mm.x(), y = volume.size[1] * volume.spacing_mm.y();
        return static_cast<int>(std::ceil(std::hypot(x, y) / pitch_mm)) + 6;
    }

    // Returns the fraction of the signal that remains on each ray through an instrument, and -1 for all other
    // rays. The returned list of fractions is empty if no ray passes through an instrument. Over the
    // detector's aperture and the slice's thickness, we average the signal and not the lengths of material.
    // Because the signal is averaged, thin metal blooms and causes streaks, as in a real scanner.
    std::vector<float> through_instruments(double height, const std::vector<float> &water) const
    {
        const std::size_t materials = beam_.material_count(), block = slice_planes * rays_per_bin * materials;
        std::vector<TubeChord> chords;
        std::vector<int> slot;
        std::vector<std::uint32_t> touched;
        std::vector<float> lengths;
        for (int plane = 0; plane < slice_planes; ++plane) {
            chords.clear();
            tubes_.chords_at(height + heights_[plane], rays_, chords);
            if (!chords.empty() && slot.empty()) slot.assign(rays_.count(), -1);
            for (const TubeChord &chord : chords) {
                const std::uint32_t ray = chord.ray / rays_per_bin;
                if (slot[ray] < 0) {
                    slot[ray] = static_cast<int>(touched.size());
                    touched.push_back(ray);
                    lengths.resize(lengths.size() + block, 0.0f);
                }
                lengths[static_cast<std::size_t>(slot[ray]) * block +
                        (static_cast<std::size_t>(plane) * rays_per_bin + chord.ray % rays_per_bin) *
                            materials +
                        chord.material] += chord.length_mm;
            }
        }
        if (touched.empty()) return {};
        std::vector<float> seen(rays_.count(), -1.0f);
        for (std::size_t i = 0; i < touched.size(); ++i) {
            double sum = 0;
            for (int plane = 0; plane < slice_planes; ++plane)
                for (int sub = 0; sub < rays_per_bin; ++sub) {
                    const float *of_ray =
                        &lengths[i * block + (static_cast<std::size_t>(plane) * rays_per_bin +
                                              static_cast<std::size_t>(sub)) *
                                                 materials];
                    double displaced = 0;
                    for (std::size_t m = 0; m < materials; ++m) displaced += static_cast<double>(of_ray[m]);
                    sum += weights_[plane] / rays_per_bin *
                           beam_.transmission(static_cast<double>(water[touched[i]]) - fluid_ * displaced,
                                              of_ray);
                }
            seen[touched[i]] = static_cast<float>(sum);
        }
        return seen;
    }

    double counted(double share, int slice, std::size_t ray) const
    {
        const double mean = photons_ * share;
        const double sigma = std::sqrt(mean + electronic_photons * electronic_photons);
        const auto number = static_cast<std::uint64_t>(slice) << 32 | ray;
        return std::max(photons_least, mean + sigma * normal_number(settings_.seed, number)) / photons_;
    }

    // Returns the number of photons per ray in air that gives the wanted noise at the lumen's centre in the
    // middle slice.
    double photons_for_noise() const
    {
        std::vector<Edge> edges;
        std::vector<float> water(rays_.count(), 0.0f);
        planes_.edges_at(0, edges);
        add_chords(edges, rays_, 1, water);
        for (float &length : water) {
            // The variance of -log(signal) is 1 / (number of photons). The variance of the water length is
            // the variance of -log(signal) times the square of the slope d(water length) / d(-log(signal)).
            const double share = beam_.water_transmission(static_cast<double>(length));
            const double slope = beam_.water_for(share * 0.99) - beam_.water_for(share * 1.01);
            length = static_cast<float>(slope * slope / (0.02 * 0.02) / share);
        }
        const double one_photon_HU = back_.noise_HU(water, planes_.middle_at(0));
        return one_photon_HU * one_photon_HU / (settings_.noise_HU * settings_.noise_HU);
    }

    const ScannerSettings &settings_;
    Volume &volume_;
    Vector3d centre_;
    double fluid_;
    PhantomPlanes planes_;
    InstrumentTubes tubes_;
    Beam beam_;
    Rays rays_;
    Reconstruction back_;
    std::array<double, slice_planes> heights_{}, weights_{};
    double photons_ = 0;
};

Eigen::AlignedBox3d box_in_lps(const bake::Mesh &lumen, const PhantomMaterials &phantom,
                               const Eigen::AlignedBox3d &wanted)
{
    Eigen::AlignedBox3d scene = wanted, lps;
    if (scene.isEmpty()) {
        for (const Vector3d &vertex : lumen.vertices_mm) scene.extend(vertex);
        const Vector3d margin = Vector3d::Constant(8 + phantom.wall_mm);
        scene = {scene.min() - margin, scene.max() + margin};
    }
    lps.extend(lps_from_scene(scene.min()));
    lps.extend(lps_from_scene(scene.max()));
    return lps;
}

Volume empty_volume(const Eigen::AlignedBox3d &box, const ScannerSettings &settings)
{
    Volume volume;
    const Vector3d around(around_mm, around_mm, 0), sides = box.sizes() + 2 * around;
    std::array<long, 3> size{};
    for (int axis = 0; axis < 3; ++axis) {
        size[static_cast<std::size_t>(axis)] =
            std::lround(std::floor(sides[axis] / settings.spacing_mm[axis]));
        volume.origin_mm[axis] =
            box.center()[axis] -
            0.5 * settings.spacing_mm[axis] * static_cast<double>(size[static_cast<std::size_t>(axis)] - 1);
    }
    check_grid(size, settings.spacing_mm, volume.origin_mm, volume.direction, "the scan");
    for (std::size_t axis = 0; axis < 3; ++axis) volume.size[axis] = static_cast<int>(size[axis]);
    volume.spacing_mm = settings.spacing_mm;
    volume.name = "virtual scan";
    volume.hu.assign(volume.count(), 0.0f);
    return volume;
}

} // namespace

Volume simulate_scan(const bake::Mesh &lumen, const PhantomMaterials &phantom,
                     const std::vector<ScanInstrument> &instruments, const ScannerSettings &settings,
                     const Report &report)
{
    const Eigen::AlignedBox3d box = box_in_lps(lumen, phantom, settings.box_mm);
    Volume volume = empty_volume(box, settings);
    const Vector3d centre = box.center();
    Scan scan(lumen, phantom, instruments, settings, volume, box, centre);
    std::atomic<int> done = 0;
    std::mutex one_at_a_time;
    std::atomic<bool> is_stopped = false;
    std::exception_ptr stopped;
    run_on_rows(settings.threads, volume.size[2], 1, [&](RowRange range) {
        if (is_stopped) return;
        scan.slice(range.begin);
        const std::lock_guard lock(one_at_a_time);
        try {
            report("scanning", static_cast<double>(++done) / volume.size[2]);
        } catch (...) {
            stopped = std::current_exception();
            is_stopped = true;
        }
    });
    if (stopped) std::rethrow_exception(stopped);
    return volume;
}

} // namespace crn::ct
