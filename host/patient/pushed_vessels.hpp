// Shows vessels where the tools have pushed them (docs/walls.md). Flow, medium, stents and bodies are
// computed in the vessel at rest; pictures show them displaced.
//
//   contrast.advance(at_rest(wire));            // the tools as the vessel at rest sees them
//   const PushedVessels pushed(wire);
//   place_m += pushed.way_m(place_m);           // where the place of the vessel at rest is now
#pragma once
#include "host/model/wall_way.hpp"
#include "host/xray/paths/moved.hpp"
#include <span>
#include <vector>

namespace crn
{

class PushedVessels
{
  public:
    explicit PushedVessels(const WireFrame &wire);
    bool is_empty() const { return places_.empty(); } // the vessels are at rest

    // Returns how far the place is displaced that is at `rest_m` in vessels at rest. The nearest part of the
    // tools decides. The way fades with the distance d from the tools as exp(-(d / 25 mm)^2), because tissue
    // around the vessel moves along.
    Eigen::Vector3d way_m(const Eigen::Vector3d &rest_m) const;
    // Moves curves in vessels at rest, such as medium and struts, to where they are.
    void push(std::span<SweptCurve> curves) const;

  private:
    struct Place {
        Eigen::Vector3d rest_m, way_m;
    };
    std::vector<Place> places_;      // along the tools, at least 2 mm apart
    Eigen::Vector3d low_m_, high_m_; // box of what moves
};

} // namespace crn
