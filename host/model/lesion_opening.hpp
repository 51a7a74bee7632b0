// How far the core's lesions have given way, on the host's tree of vessels (docs/lesions.md).
//
//   const auto stations = read_lesion_stations("lad.scene", error);
//   const LesionOpening opening(tree, stations);
//   opening.open(tree, wire.lesions_open, now);          // points and radii within lesions; all else as it is in `now`
#pragma once
#include "host/model/vessel_tree.hpp"
#include <span>
#include <string>
#include <vector>

struct crn_scene;

namespace crn
{

// Of one lesion that gives way: so many stations, so far apart along the healthy vessel, the lesion in their
// middle.
struct LesionStations {
    std::size_t count = 0;
    double spacing_m = 0.0;
};

// Of a checked scene: lesion by lesion, the first of its tree's.
std::vector<LesionStations> lesion_stations(const crn_scene &scene);
// The PLAQUES section of a scene file. Nothing when it has none, or, with a message in `error`, when it
// cannot be read.
std::vector<LesionStations> read_lesion_stations(const std::string &scene_path, std::string &error);

class LesionOpening
{
  public:
    LesionOpening() = default;
    // Stations for lesions that the tree has not are left out.
    LesionOpening(const VesselTree &tree, std::span<const LesionStations> stations);

    bool is_empty() const { return lesions_.empty(); }
    std::size_t lesion_count() const { return lesions_.size(); } // that give way: the tree's first ones

    // A place between two stations of WireFrame::lesions_open.
    struct Place {
        std::size_t station = 0;
        double share = 0.0; // of the next one
    };
    // So far along the healthy lesion, from its first point.
    Place place(std::size_t lesion, double arc_m) const;
    // 0 as it was baked .. 1 healthy. 0 for a list that is shorter.
    static double at(const Place &place, std::span<const double> lesions_open);
    bool is_open(std::size_t lesion, std::span<const double> lesions_open) const;
    bool is_any_open(std::span<const double> lesions_open) const;
    // How far every point of a lesion is open.
    double at_point(std::size_t lesion, std::size_t point, std::span<const double> lesions_open) const
    {
        return at(lesions_[lesion].points[point], lesions_open);
    }

    // Points and radii of `now` within the lesions: on the way from those of `tree`, which this was made for,
    // to the healthy ones.
    void open(const VesselTree &tree, std::span<const double> lesions_open, VesselTree &now) const;

  private:
    struct Lesion {
        std::size_t first = 0, count = 0; // stations
        double begin_m = 0.0, spacing_m = 1.0;
        std::vector<Place> points;
    };
    std::vector<Lesion> lesions_;
};

} // namespace crn
