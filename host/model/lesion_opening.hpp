// Widens the lesions in the host's tree of vessels by as much as the balloon has opened them in the core
// (docs/lesions.md).
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

// Describes the stations (evenly spaced points) of a lesion that a balloon can open: their number, and the
// distance between them along the healthy vessel. The middle of the lesion is the middle of its row of
// stations (evenly spaced points).
struct LesionStations {
    std::size_t count = 0;
    double spacing_m = 0.0;
};

// Returns the stations (evenly spaced points) of each lesion that a balloon can open; the scene must be
// validated. The returned stations are in the order of the tree's lesions, in which the lesions that a
// balloon can open come first.
std::vector<LesionStations> lesion_stations(const crn_scene &scene);
// Reads the stations (evenly spaced points) of all lesions that a balloon can open from the PLAQUES section
// of a scene file. Returns an empty list when the file has no PLAQUES section. When the section cannot be
// read, the list is empty too, and `error` has a message.
std::vector<LesionStations> read_lesion_stations(const std::string &scene_path, std::string &error);

class LesionOpening
{
  public:
    LesionOpening() = default;
    // The constructor ignores stations for lesions that the tree does not have.
    LesionOpening(const VesselTree &tree, std::span<const LesionStations> stations);

    bool is_empty() const { return lesions_.empty(); }
    std::size_t lesion_count() const
    {
        return lesions_.size();
    } // number of lesions that yield: the tree's first ones

    // Describes a position between two stations (points) of a lesion by the index of the first station in
    // WireFrame::lesions_open and the fraction of the distance to the next station.
    struct Place {
        std::size_t station = 0;
        double share = 0.0; // share of the next one
    };
    // Returns the position at this distance from the lesion's first point, measured along the healthy vessel.
    Place place(std::size_t lesion, double arc_m) const;
    // Returns the opening of a lesion at a position: 0 is as narrow as in the scene file, 1 as wide as the
    // healthy vessel. Returns 0 if the list `lesions_open` has no value for this position.
    static double at(const Place &place, std::span<const double> lesions_open);
    bool is_open(std::size_t lesion, std::span<const double> lesions_open) const;
    bool is_any_open(std::span<const double> lesions_open) const;
    // Returns the opening of a lesion at one of its points, from 0 (as narrow as in the scene file) to 1 (as
    // wide as the healthy vessel).
    double at_point(std::size_t lesion, std::size_t point, std::span<const double> lesions_open) const
    {
        return at(lesions_[lesion].points[point], lesions_open);
    }

    // Sets the points and radii of `now` inside lesions to values between those in `tree` and those of the
    // healthy vessel. `tree` must be the tree with which this object was constructed.
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
