#include "host/model/lesion_opening.hpp"
#include "host/model/scene_reading.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{

std::vector<LesionStations> lesion_stations(const crn_scene &scene)
{
    std::vector<LesionStations> stations;
    for (std::uint32_t i = 0; i < scene.plaque_count; ++i) {
        const crn_scene_plaque_view plaque = crn_scene_plaque(&scene, i);
        stations.push_back(
            {plaque.station_count, std::ldexp(1.0, static_cast<int>(plaque.spacing_log2_q30) - 30)});
    }
    return stations;
}

std::vector<LesionStations> read_lesion_stations(const std::string &scene_path, std::string &error)
{
    return from_scene<std::vector<LesionStations>>(scene_path, error, lesion_stations);
}

LesionOpening::LesionOpening(const VesselTree &tree, std::span<const LesionStations> stations)
{
    std::size_t first = 0;
    for (std::size_t k = 0; k < std::min(tree.lesions.size(), stations.size()); ++k) {
        if (stations[k].count < 2 || !(stations[k].spacing_m > 0.0)) break;
        const VesselLesion &lesion = tree.lesions[k];
        Lesion of;
        of.first = first;
        of.count = stations[k].count;
        of.spacing_m = stations[k].spacing_m;
        of.begin_m = 0.5 * (lesion.length_m() - static_cast<double>(of.count - 1) * of.spacing_m);
        lesions_.push_back(of);
        double arc_m = 0.0;
        for (std::size_t i = 0; i < lesion.size(); ++i) {
            if (i > 0) arc_m += (lesion.healthy_points_m[i] - lesion.healthy_points_m[i - 1]).norm();
            lesions_.back().points.push_back(place(k, arc_m));
        }
        first += of.count;
    }
}

LesionOpening::Place LesionOpening::place(std::size_t lesion, double arc_m) const
{
    const Lesion &of = lesions_[lesion];
    const double station =
        std::clamp((arc_m - of.begin_m) / of.spacing_m, 0.0, static_cast<double>(of.count - 1));
    const std::size_t before = std::min(static_cast<std::size_t>(station), of.count - 2);
    return {of.first + before, station - static_cast<double>(before)};
}

double LesionOpening::at(const Place &place, std::span<const double> open)
{
    if (place.station + 1 >= open.size()) return 0.0;
    const double from = open[place.station], to = open[place.station + 1];
    return from + place.share * (to - from);
}

bool LesionOpening::is_open(std::size_t lesion, std::span<const double> open) const
{
    const Lesion &of = lesions_[lesion];
    if (of.first + of.count > open.size()) return false;
    const std::span<const double> stations = open.subspan(of.first, of.count);
    return std::any_of(stations.begin(), stations.end(), [](double share) { return share > 0.0; });
}

bool LesionOpening::is_any_open(std::span<const double> open) const
{
    for (std::size_t k = 0; k < lesions_.size(); ++k)
        if (is_open(k, open)) return true;
    return false;
}

void LesionOpening::open(const VesselTree &tree, std::span<const double> open, VesselTree &now) const
{
    for (std::size_t k = 0; k < lesions_.size(); ++k) {
        const VesselLesion &lesion = tree.lesions[k];
        const VesselBranch &narrow = tree.branches[lesion.branch];
        VesselBranch &branch = now.branches[lesion.branch];
        for (std::size_t i = 0; i < lesion.size(); ++i) {
            const std::size_t point = lesion.first_point + i;
            const double share = at_point(k, i, open);
            branch.points_m[point] =
                narrow.points_m[point] + share * (lesion.healthy_points_m[i] - narrow.points_m[point]);
            branch.radii_m[point] =
                narrow.radii_m[point] + share * (lesion.healthy_radii_m[i] - narrow.radii_m[point]);
        }
    }
}

} // namespace crn
