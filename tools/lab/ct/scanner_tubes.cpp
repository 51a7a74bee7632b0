// Computes the chords of rays through pieces of round tubes, which form the instrument, and computes the
// X-ray beam itself.
#include "host/xray/attenuation.hpp"
#include "host/xray/spectrum.hpp"
#include "tools/lab/ct/scanner_parts.hpp"
#include "tools/mesh/fault.hpp"
#include <algorithm>
#include <cmath>

namespace crn::ct
{

using Eigen::Vector3d;

namespace
{

constexpr double piece_mm =
    0.5; // length of a piece of a curve; its chord is off by 0.01 mm in a bend of 3 mm radius
constexpr double water_step_mm = 1.0;
constexpr int water_steps = 3000;

// Divides a polyline into pieces of at most piece_mm.
std::vector<Vector3d> fine_line(const std::vector<Vector3d> &line)
{
    std::vector<Vector3d> fine{line.front()};
    for (std::size_t i = 1; i < line.size(); ++i) {
        const double length = (line[i] - line[i - 1]).norm();
        if (length < 1e-6) continue;
        const int parts = std::max(1, static_cast<int>(std::ceil(length / piece_mm)));
        for (int part = 1; part <= parts; ++part)
            fine.push_back(line[i - 1] + (line[i] - line[i - 1]) * (static_cast<double>(part) / parts));
    }
    return fine;
}

struct Span {
    double low, high;
    double length() const { return std::max(0.0, high - low); }
};

// Keeps the part of the ray p + t d that lies in front of a plane through q, or the part behind this plane.
void clip(Span &span, double slope, double beyond, bool wants_positive)
{
    if (!wants_positive) {
        slope = -slope;
        beyond = -beyond;
    }
    if (std::abs(slope) < 1e-12) {
        if (beyond < 0) span = {0, 0};
        return;
    }
    const double t = -beyond / slope;
    if (slope > 0)
        span.low = std::max(span.low, t);
    else
        span.high = std::min(span.high, t);
}

} // namespace

InstrumentTubes::InstrumentTubes(const std::vector<ScanInstrument> &instruments, const Vector3d &centre)
{
    for (const ScanInstrument &instrument : instruments) add(instrument, centre);
}

std::uint8_t InstrumentTubes::index_of(Material material)
{
    const auto found = std::find(materials_.begin(), materials_.end(), material);
    if (found != materials_.end()) return static_cast<std::uint8_t>(found - materials_.begin());
    materials_.push_back(material);
    return static_cast<std::uint8_t>(materials_.size() - 1);
}

void InstrumentTubes::add(const ScanInstrument &instrument, const Vector3d &centre)
{
    if (instrument.line_mm.size() < 2)
        throw Fault("the instrument's line has fewer than two points: give its centreline");
    if (instrument.stretches.empty())
        throw Fault("the instrument has no section: give its radius and material");
    std::vector<Vector3d> line = fine_line(instrument.line_mm);
    for (Vector3d &point : line) point = lps_from_scene(point) - centre;
    std::reverse(line.begin(), line.end()); // the line now begins at the tip
    double arc = 0;
    const std::size_t first = pieces_.size();
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
        Piece piece;
        piece.a = line[i];
        piece.b = line[i + 1];
        const double length = (piece.b - piece.a).norm();
        piece.axis = (piece.b - piece.a) / length;
        piece.normal_a = piece.normal_b = piece.axis;
        const ScanStretch *stretch = &instrument.stretches.back();
        for (const ScanStretch &other : instrument.stretches)
            if (arc + length / 2 < other.arc_end_mm) {
                stretch = &other;
                break;
            }
        piece.reach_mm = 0;
        for (const ScanLayer &layer : stretch->layers) {
            const double outer = stretch->radius_mm * layer.radius_share;
            if (outer <= stretch->bore_mm) continue;
            piece.layers.push_back({outer, stretch->bore_mm, layer.fill, index_of(layer.material)});
            piece.reach_mm = std::max(piece.reach_mm, outer);
        }
        arc += length;
        pieces_.push_back(piece);
    }
    for (std::size_t i = first; i + 1 < pieces_.size(); ++i)
        pieces_[i].normal_b = pieces_[i + 1].normal_a = (pieces_[i].axis + pieces_[i + 1].axis).normalized();
}

void InstrumentTubes::chords_at(double height_mm, const Rays &rays, std::vector<TubeChord> &chords) const
{
    const int sub_rays = rays.bins * rays_per_bin;
    const double pitch = rays.pitch_mm / rays_per_bin;
    for (const Piece &piece : pieces_) {
        const double reach = 1.1 * piece.reach_mm;
        if (std::min(piece.a.z(), piece.b.z()) - reach > height_mm ||
            std::max(piece.a.z(), piece.b.z()) + reach < height_mm)
            continue;
        for (int view = 0; view < rays.views; ++view) {
            const double c = rays.cosine[static_cast<std::size_t>(view)],
                         s = rays.sine[static_cast<std::size_t>(view)];
            const Vector3d d(-s, c, 0);
            const double at_a = c * piece.a.x() + s * piece.a.y(), at_b = c * piece.b.x() + s * piece.b.y();
            const int low = std::max(0, static_cast<int>(std::ceil((std::min(at_a, at_b) - reach) / pitch +
                                                                   0.5 * sub_rays - 0.5))),
                      high = std::min(sub_rays - 1, static_cast<int>((std::max(at_a, at_b) + reach) / pitch +
                                                                     0.5 * sub_rays - 0.5));
            const Vector3d across = d - d.dot(piece.axis) * piece.axis;
            const double square = std::max(across.squaredNorm(), 1e-12);
            for (int ray = low; ray <= high; ++ray) {
                const double place = (ray + 0.5 - 0.5 * sub_rays) * pitch;
                const Vector3d from = Vector3d(place * c, place * s, height_mm) - piece.a;
                const Vector3d beside = from - from.dot(piece.axis) * piece.axis;
                const double middle = -beside.dot(across) / square;
                const double nearest = (beside + middle * across).squaredNorm();
                for (const Layer &layer : piece.layers) {
                    const auto part = [&](double radius) {
                        const double under = (radius * radius - nearest) / square;
                        if (under <= 0) return 0.0;
                        Span span{middle - std::sqrt(under), middle + std::sqrt(under)};
                        clip(span, d.dot(piece.normal_a), from.dot(piece.normal_a), true);
                        clip(span, d.dot(piece.normal_b), (from + piece.a - piece.b).dot(piece.normal_b),
                             false);
                        return span.length();
                    };
                    const double length = layer.fill * (part(layer.outer_mm) - part(layer.inner_mm));
                    if (length > 1e-5)
                        chords.push_back({static_cast<std::uint32_t>(view * sub_rays + ray),
                                          static_cast<float>(length), layer.material});
                }
            }
        }
    }
}

Beam::Beam(double tube_kV, const std::vector<Material> &materials)
{
    const Spectrum photons = tube_spectrum(tube_kV, 0.2);
    std::array<double, energy_count> signal;
    double all = 0;
    for (int i = 0; i < energy_count; ++i)
        all += signal[static_cast<std::size_t>(i)] = photons[static_cast<std::size_t>(i)] * energy_keV(i);
    per_mm_.resize(materials.size());
    double below = 0;
    for (int i = 0; i < energy_count; ++i) {
        const double share = signal[static_cast<std::size_t>(i)] / all;
        // We divide the beam's spectrum into bins of equal signal; the attenuation of a bin is the mean over
        // its photons.
        const auto bin = std::min<std::size_t>(beam_energies - 1,
                                               static_cast<std::size_t>((below + share / 2) * beam_energies));
        below += share;
        weight_[bin] += share;
        const auto per_mm = [&](Material material) {
            return 0.1 * static_cast<double>(attenuation_per_cm[static_cast<int>(material)][i]);
        };
        water_per_mm_[bin] += share * per_mm(Material::soft_tissue);
        for (std::size_t m = 0; m < materials.size(); ++m) per_mm_[m][bin] += share * per_mm(materials[m]);
    }
    for (std::size_t bin = 0; bin < beam_energies; ++bin) {
        water_per_mm_[bin] /= weight_[bin];
        for (auto &of_material : per_mm_) of_material[bin] /= weight_[bin];
    }
    for (int i = 0; i < water_steps; ++i) table_.push_back(-std::log(water_transmission(i * water_step_mm)));
}

double Beam::transmission(double water_mm, const float *lengths_mm) const
{
    double sum = 0;
    for (std::size_t bin = 0; bin < beam_energies; ++bin) {
        double depth = water_per_mm_[bin] * water_mm;
        for (std::size_t m = 0; m < per_mm_.size(); ++m)
            depth += per_mm_[m][bin] * static_cast<double>(lengths_mm[m]);
        sum += weight_[bin] * std::exp(-depth);
    }
    return sum;
}

double Beam::water_transmission(double water_mm) const
{
    double sum = 0;
    for (std::size_t bin = 0; bin < beam_energies; ++bin)
        sum += weight_[bin] * std::exp(-water_per_mm_[bin] * water_mm);
    return sum;
}

double Beam::water_for(double transmission) const
{
    const double depth = -std::log(transmission);
    if (depth <= 0) return depth / table_[1] * water_step_mm;
    const auto above = std::upper_bound(table_.begin(), table_.end(), depth);
    if (above == table_.end()) return (water_steps - 1) * water_step_mm;
    const auto index = static_cast<std::size_t>(above - table_.begin());
    const double share = (depth - table_[index - 1]) / (table_[index] - table_[index - 1]);
    return (static_cast<double>(index - 1) + share) * water_step_mm;
}

} // namespace crn::ct
