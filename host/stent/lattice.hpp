// Holds the points of a stent and the springs between them, which are made from the stent's design
// (docs/stent.md, "Springs").
//
// The k-th point of ring j (k = 0 .. 2N-1 around the axis) lies at the angle k pi / N from the ring's first
// point. In an even ring, the points with even k are the crowns towards the tip. The springs are
//   struts    k to k+1 of a ring                              keep their length
//   hinges    k to k+2, k+4, k+N of a ring, of one side       bending of a crown; yield
//   links     a crown to a crown of the next ring             keep their length
//   braces    both ends of a link to the other's neighbours   bending of a link; yield
#pragma once
#include "host/stent/design.hpp"
#include <array>
#include <cstdint>
#include <vector>

namespace crn
{

enum class StentSpringKind : std::uint8_t { strut, hinge, link, brace };

struct StentSpring {
    std::array<std::uint32_t, 2> ends;
    double stiffness_N_per_mm = 0.0;
    StentSpringKind kind = StentSpringKind::strut;
    bool yields() const { return kind == StentSpringKind::hinge || kind == StentSpringKind::brace; }
};

struct StentLattice {
    explicit StentLattice(const StentDesign &design);

    std::size_t point_count() const { return static_cast<std::size_t>(2 * crowns * rings); }
    std::uint32_t point(int ring, int place) const
    {
        const int around = 2 * crowns;
        return static_cast<std::uint32_t>(ring * around + (place % around + around) % around);
    }
    int ring_of(std::size_t point) const { return static_cast<int>(point) / (2 * crowns); }
    int place_of(std::size_t point) const { return static_cast<int>(point) % (2 * crowns); }
    double angle(std::size_t point) const; // rad
    // Returns -1 for a point on the side of its ring towards the tip, and +1 for one towards the hub.
    int side_of(std::size_t point) const;

    int rings = 0, crowns = 0;
    double bulge_share =
        0.0; // 1 / cos(pi / 2N) - 1: distance by which a round strut's middle lies outside its chord
    bool mirrors = false; // every second ring: crowns that face each other
    std::vector<StentSpring> springs;
    std::vector<std::array<std::uint32_t, 2>> struts, links;
    // Lists, for each point, the springs that end there, as pairs of (spring, point at its other end).
    struct Bar {
        std::uint32_t spring, other;
        double stiffness_N_per_mm;
    };
    std::vector<std::uint32_t> bar_begin;
    std::vector<Bar> bars;
};

// Returns the stiffness with which a ring's hinges resist a change of the radius R: the second derivative of
// the hinges' energy, which is the sum of k (d length / d R)^2 over all hinges.
double hinge_ring_stiffness(const StentLattice &lattice);

} // namespace crn
