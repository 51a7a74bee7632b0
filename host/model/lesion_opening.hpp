// Opens the lesions in the host's tree of vessels as far as they have yielded in the core (docs/lesions.md).
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

// Describes the stations of one lesion that yields by their number and the distance between two of them along
// the healthy vessel. The lesion lies in the middle of its stations.
struct LesionStations {
    std::size_t count = 0;
    double spacing_m = 0.0;
};

// Returns the stations of each lesion that yields, from a validated scene. The result is in the order of the
// tree's lesions, of which the lesions that yield come first.
std::vector<LesionStations> lesion_stations(const crn_scene &scene);
// Reads these stations from the PLAQUES section of a scene file. Returns nothing when there is no such
// section. When it cannot be read, `error` has a message too.
std::vector<LesionStations> read_lesion_stations(const std::string &scene_path, std::string &error);

class LesionOpening
{
  public:
    LesionOpening() = default;
    // Stations for lesions that the tree does not have are ignored.
    LesionOpening(const VesselTree &tree, std::span<const LesionStations> stations);

    bool is_empty() const { return lesions_.empty(); }
    std::size_t lesion_count() const
    {
        return lesions_.size();
    } // number of lesions that yield: the tree's first ones

    // Describes a place between two stations, as an index into WireFrame::lesions_open.
    struct Place {
        std::size_t station = 0;
        double share = 0.0; // share of the next one
    };
    // Returns the place at this distance from the lesion's first point, measured along the healthy vessel.
    Place place(std::size_t lesion, double arc_m) const;
    // Returns how far the lesion is open at a place: 0 means as it was baked, 1 means healthy. Returns 0 if
    // the list `lesions_open` is too short.
    static double at(const Place &place, std::span<const double> lesions_open);
    bool is_open(std::size_t lesion, std::span<const double> lesions_open) const;
    bool is_any_open(std::span<const double> lesions_open) const;
    // Returns how far a lesion is open at one of its points.
    double at_point(std::size_t lesion, std::size_t point, std::span<const double> lesions_open) const
    {
        return at(lesions_[lesion].points[point], lesions_open);
    }

    // Moves the points and radii of `now` inside lesions, from their values in `tree` towards the healthy
    // values. `tree` must be the one for which this object was made.
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
