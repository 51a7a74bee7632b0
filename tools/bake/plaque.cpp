#include "tools/bake/plaque.hpp"
#include "shared/scene/scene_write.h"
#include "tools/bake/fault.hpp"

#include <algorithm>
#include <cmath>

namespace crn::bake
{
namespace
{

using Eigen::Vector3d;

constexpr double pace_m = 4e-6;     // speed of a wall per tick: less than the growth of a balloon's sphere
constexpr double reach_radii = 2.5; // the core looks up to two radii far
constexpr unsigned spacing_log2_min = 17, spacing_log2_max = 22;

std::int32_t q30(double value)
{
    return static_cast<std::int32_t>(std::lround(std::ldexp(value, 30)));
}

struct Station {
    Vector3d healthy_m, channel_m;
    double healthy_radius_m = 0, channel_radius_m = 0;
};

// Describes a lesion as a function of arc length along the lesion's healthy centreline.
class Stretch
{
  public:
    Stretch(const VesselTree &tree, const VesselLesion &lesion)
        : lesion_(lesion), branch_(tree.branches[lesion.branch])
    {
        arcs_m_.push_back(0);
        for (std::size_t i = 1; i < lesion.size(); ++i)
            arcs_m_.push_back(arcs_m_.back() +
                              (lesion.healthy_points_m[i] - lesion.healthy_points_m[i - 1]).norm());
    }
    double length_m() const { return arcs_m_.back(); }

    // Beyond the ends of the lesion, the vessel is taken as straight and healthy.
    Station at(double arc_m) const
    {
        const auto after = std::upper_bound(arcs_m_.begin() + 1, arcs_m_.end() - 1, arc_m);
        const auto i = static_cast<std::size_t>(after - arcs_m_.begin()) - 1, k = lesion_.first_point + i;
        const double beyond = (arc_m - arcs_m_[i]) / (arcs_m_[i + 1] - arcs_m_[i]);
        const double share = std::clamp(beyond, 0.0, 1.0);
        const auto mix = [](const auto &a, const auto &b, double s) { return a + s * (b - a); };
        const std::vector<Vector3d> &h = lesion_.healthy_points_m, &c = branch_.points_m;
        Station station;
        station.healthy_m = mix(h[i], Vector3d(h[i + 1]), beyond);
        station.channel_m = mix(c[k], Vector3d(c[k + 1]), share) + (beyond - share) * (h[i + 1] - h[i]);
        station.healthy_radius_m = mix(lesion_.healthy_radii_m[i], lesion_.healthy_radii_m[i + 1], share);
        station.channel_radius_m =
            std::min(mix(branch_.radii_m[k], branch_.radii_m[k + 1], share), station.healthy_radius_m);
        return station;
    }

  private:
    const VesselLesion &lesion_;
    const VesselBranch &branch_;
    std::vector<double> arcs_m_;
};

// Returns at most CRN_SCENE_PLAQUE_STATION_MAX points along the vessel, with the lesion in their middle. The
// distance between neighbouring points is a power of two, in metres.
std::vector<Station> stations_of(const Stretch &stretch, const std::string &name, unsigned &log2)
{
    for (log2 = spacing_log2_min; log2 <= spacing_log2_max; ++log2) {
        const double spacing_m = std::ldexp(1.0, static_cast<int>(log2) - 30);
        const double gaps = std::max(std::ceil(stretch.length_m() / spacing_m), 2.0);
        if (gaps > CRN_SCENE_PLAQUE_STATION_MAX - 1) continue;
        const double begin_m = 0.5 * (stretch.length_m() - gaps * spacing_m);
        std::vector<Station> stations;
        double aside_m = 0;
        for (int i = 0; i <= static_cast<int>(gaps); ++i) {
            stations.push_back(stretch.at(begin_m + i * spacing_m));
            aside_m = std::max(
                aside_m, (stations.back().channel_m - stations.back().healthy_m).lpNorm<Eigen::Infinity>());
        }
        if (aside_m <= 4 * spacing_m) return stations;
    }
    throw Fault("[[lesion]] '" + name + "' is longer than 89 mm: divide it into two");
}

class Words
{
  public:
    explicit Words(std::vector<std::uint8_t> &bytes) : bytes_(bytes) {}
    void put(std::int32_t value)
    {
        bytes_.resize(bytes_.size() + 4);
        crn_scene_put_u32(&bytes_[bytes_.size() - 4], static_cast<std::uint32_t>(value));
    }
    void put_q30(const Vector3d &v)
    {
        for (int k = 0; k < 3; ++k) put(q30(v[k]));
    }

  private:
    std::vector<std::uint8_t> &bytes_;
};

void put_record(Words &words, const std::vector<Station> &stations, unsigned log2, std::size_t first,
                const LesionText &text)
{
    Eigen::AlignedBox3d box;
    double lost_m = 0, arc_m = 0;
    for (std::size_t i = 0; i < stations.size(); ++i) {
        const Station &s = stations[i];
        const Vector3d reach = Vector3d::Constant(reach_radii * s.healthy_radius_m);
        box.extend(s.healthy_m - reach).extend(s.healthy_m + reach).extend(s.channel_m);
        lost_m = std::max(lost_m, s.healthy_radius_m - s.channel_radius_m);
        if (i > 0) arc_m += (s.healthy_m - stations[i - 1].healthy_m).norm();
    }
    const Vector3d chord = stations.back().healthy_m - stations.front().healthy_m;
    words.put_q30(box.min());
    words.put_q30(box.max());
    words.put_q30(chord.normalized());
    words.put(static_cast<std::int32_t>(std::lround(std::ldexp(std::min(arc_m / chord.norm(), 2.0), 28))));
    words.put(static_cast<std::int32_t>(log2));
    words.put(static_cast<std::int32_t>(stations.size()));
    words.put(static_cast<std::int32_t>(std::lround(text.yield_kPa * 1000)));
    words.put(static_cast<std::int32_t>(std::lround(text.full_kPa * 1000)));
    words.put(q30(text.recoil));
    words.put(std::clamp(q30(pace_m / std::max(lost_m, 16 * pace_m)), 1, 1 << 28));
    words.put(static_cast<std::int32_t>(first));
    for (int i = 0; i < 3; ++i) words.put(0);
}

void put_stations(Words &words, const std::vector<Station> &stations)
{
    for (std::size_t i = 0; i < stations.size(); ++i) {
        const std::size_t from = std::min(i, stations.size() - 2);
        words.put_q30(stations[i].healthy_m);
        words.put(q30(stations[i].healthy_radius_m));
        words.put_q30(stations[i].channel_m);
        words.put(q30(stations[i].channel_radius_m));
        words.put_q30((stations[from + 1].healthy_m - stations[from].healthy_m).normalized());
        words.put(0);
    }
}

} // namespace

std::vector<std::uint8_t> plaques_section(const VesselTree &tree, const std::vector<LesionText> &texts)
{
    std::vector<std::uint8_t> bytes;
    if (tree.lesions.empty()) return bytes;
    const std::size_t count = std::min<std::size_t>(tree.lesions.size(), CRN_SCENE_PLAQUE_MAX);
    std::vector<std::vector<Station>> stations;
    std::vector<unsigned> log2(count);
    std::size_t total = 0;
    for (std::size_t i = 0; i < count; ++i) {
        stations.push_back(stations_of(Stretch(tree, tree.lesions[i]), texts[i].name, log2[i]));
        total += stations.back().size();
    }
    Words words(bytes);
    words.put(static_cast<std::int32_t>(count));
    words.put(static_cast<std::int32_t>(total));
    words.put(0);
    words.put(0);
    std::size_t first = 0;
    for (std::size_t i = 0; i < count; ++i) {
        put_record(words, stations[i], log2[i], first, texts[i]);
        first += stations[i].size();
    }
    for (const std::vector<Station> &s : stations) put_stations(words, s);
    return bytes;
}

} // namespace crn::bake
