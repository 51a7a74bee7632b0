// How far the core's lesions have yielded, applied to the host's tree of vessels (docs/lesions.md).
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

// The stations of one lesion that yields: their number and their distance along the healthy vessel; the
// lesion lies in their middle.
struct LesionStations {
    std::size_t count = 0;
    double spacing_m = 0.0;
};

// Returns the stations of each yielding lesion of a validated scene, in the order of the tree's lesions, of
// which they are the first.
std::vector<LesionStations> lesion_stations(const crn_scene &scene);
// Reads the PLAQUES section of a scene file. Returns nothing when there is none, or, with a message in
// `error`, when it cannot be read.
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

    // A place between two stations of WireFrame::lesions_open.
    struct Place {
        std::size_t station = 0;
        double share = 0.0; // share of the next one
    };
    // Returns the place at this distance along the healthy lesion, from its first point.
    Place place(std::size_t lesion, double arc_m) const;
    // Returns 0 as it was baked .. 1 healthy. It returns 0 if the list is too short.
    static double at(const Place &place, std::span<const double> lesions_open);
    bool is_open(std::size_t lesion, std::span<const double> lesions_open) const;
    bool is_any_open(std::span<const double> lesions_open) const;
    // Returns how far a point of a lesion is open.
    double at_point(std::size_t lesion, std::size_t point, std::span<const double> lesions_open) const
    {
        return at(lesions_[lesion].points[point], lesions_open);
    }

    // Moves points and radii of `now` within the lesions from those of `tree`, for which this object was
    // made, towards the healthy ones.
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
