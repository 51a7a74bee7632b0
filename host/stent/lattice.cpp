#include "host/stent/lattice.hpp"
#include <cmath>
#include <numbers>
#include <set>

namespace crn
{

namespace
{

// Forces between points of the stent are hundredths of a newton, so the struts change their length by a few
// micrometres. Real struts are fifty times stiffer than these springs, but the difference would be invisible,
// and the equilibrium would take more iterations. Links are bent wires, which yield easily along the axis of
// the stent.
constexpr double strut_stiffness_N_per_mm = 20.0, link_stiffness_N_per_mm = 2.0;
// A brace is a spring that resists the bending of a link. Gives the stiffness of a brace as a fraction of a
// hinge's stiffness; the fraction is low because a stent bends easily.
constexpr double brace_share = 0.5;
// Gives the stiffness of hinges to farther neighbours, which keep a ring round, as a fraction of the
// stiffness of hinges to the nearest neighbours.
constexpr double wide_share = 0.5;

struct Builder {
    const StentDesign &design;
    StentLattice &lattice;

    void add(std::uint32_t a, std::uint32_t b, double stiffness, StentSpringKind kind) const
    {
        lattice.springs.push_back({{a, b}, stiffness, kind});
    }

    // The points of the stent are made ring by ring, so that neighbours in space are near each other in
    // memory.
    void ring(int ring) const
    {
        const int n = lattice.crowns;
        for (int k = 0; k < 2 * n; ++k) {
            lattice.struts.push_back({lattice.point(ring, k), lattice.point(ring, k + 1)});
            add(lattice.point(ring, k), lattice.point(ring, k + 1), strut_stiffness_N_per_mm,
                StentSpringKind::strut);
        }
        for (int offset : std::set<int>{2, 4, n / 2 * 2})
            for (int k = 0; k < (offset == n ? n : 2 * n); ++k)
                add(lattice.point(ring, k), lattice.point(ring, k + offset), offset == 2 ? 1.0 : wide_share,
                    StentSpringKind::hinge);
    }

    void links_behind(int ring) const
    {
        for (int link = 0; link < design.links; ++link) {
            // Links are evenly spaced around the ring, and from one gap between rings to the next the links
            // are shifted by one crown.
            const int crown = (link * lattice.crowns / design.links + ring) % lattice.crowns;
            int place = 2 * crown;
            if (lattice.side_of(lattice.point(ring, place)) < 0) ++place;
            const std::uint32_t a = lattice.point(ring, place), b = lattice.point(ring + 1, place);
            lattice.links.push_back({a, b});
            add(a, b, link_stiffness_N_per_mm, StentSpringKind::link);
            for (int side : {-1, 1}) {
                add(a, lattice.point(ring + 1, place + side), brace_share, StentSpringKind::brace);
                add(b, lattice.point(ring, place + side), brace_share, StentSpringKind::brace);
            }
        }
    }

    void list_bars() const
    {
        lattice.bar_begin.assign(lattice.point_count() + 1, 0);
        for (const StentSpring &spring : lattice.springs)
            for (std::uint32_t end : spring.ends) ++lattice.bar_begin[end + 1];
        for (std::size_t i = 0; i < lattice.point_count(); ++i)
            lattice.bar_begin[i + 1] += lattice.bar_begin[i];
        lattice.bars.resize(2 * lattice.springs.size());
        std::vector<std::uint32_t> next(lattice.bar_begin.begin(), lattice.bar_begin.end() - 1);
        for (std::uint32_t i = 0; i < lattice.springs.size(); ++i) {
            const auto [a, b] = lattice.springs[i].ends;
            const double stiffness = lattice.springs[i].stiffness_N_per_mm;
            lattice.bars[next[a]++] = {i, b, stiffness};
            lattice.bars[next[b]++] = {i, a, stiffness};
        }
    }
};

// Returns (d length / d R)^2, the squared change of a chord's length with the ring's radius R; the chord
// joins two points on one side of the ring, and the value is 4 sin^2(half the angle between them).
double chord_share(const StentLattice &lattice, const StentSpring &spring)
{
    const double half = (lattice.angle(spring.ends[1]) - lattice.angle(spring.ends[0])) / 2;
    return 4 * std::sin(half) * std::sin(half);
}

} // namespace

StentLattice::StentLattice(const StentDesign &design)
    : rings(design.rings), crowns(design.crowns), mirrors(design.connection == StentConnection::facing)
{
    bulge_share = 1 / std::cos(std::numbers::pi / (2 * crowns)) - 1;
    const Builder builder{design, *this};
    for (int ring = 0; ring < rings; ++ring) {
        builder.ring(ring);
        if (ring + 1 < rings) builder.links_behind(ring);
    }
    // The code above has set only the ratios between the stiffnesses of the hinges. The stiffnesses of the
    // hinges are now scaled so that a ring is as stiff as the stent's design states.
    const double scale = design.ring_stiffness_N_per_mm / hinge_ring_stiffness(*this);
    for (StentSpring &spring : springs)
        if (spring.yields()) spring.stiffness_N_per_mm *= scale;
    builder.list_bars();
}

double StentLattice::angle(std::size_t point) const
{
    return place_of(point) * std::numbers::pi / crowns;
}

int StentLattice::side_of(std::size_t point) const
{
    const bool is_odd = (place_of(point) + (mirrors ? ring_of(point) : 0)) % 2 != 0;
    return is_odd ? 1 : -1;
}

double hinge_ring_stiffness(const StentLattice &lattice)
{
    double sum = 0.0;
    for (const StentSpring &spring : lattice.springs)
        if (spring.kind == StentSpringKind::hinge)
            sum += spring.stiffness_N_per_mm * chord_share(lattice, spring);
    return sum / lattice.rings;
}

} // namespace crn
