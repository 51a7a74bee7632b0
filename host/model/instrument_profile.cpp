// Converts an instrument's sections and arcs to the knots of the protocol's `instrument` message (values at
// arc lengths), to the nodes of the mesh, and to the unloaded shape.
#include "host/model/instrument_parts.hpp"
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace crn
{

namespace instrument_file
{

namespace
{

constexpr double same_mm = 1e-3; // boundaries closer than this count as one

// Returns a stiffness at the fraction u of a section's length. A stiffness changes geometrically, because it
// may change by several powers of ten along a ground taper; all other values change linearly.
double by_ratio(const TomlRange &range, double u)
{
    return range.is_constant() ? range.from : range.from * std::pow(range.to / range.from, u);
}

double linearly(const TomlRange &range, double u)
{
    return range.from + (range.to - range.from) * u;
}

std::uint32_t rounded(double value)
{
    return static_cast<std::uint32_t>(std::lround(value));
}

bool has_same_properties(const crn_wire_knot &a, const crn_wire_knot &b)
{
    return a.bend_stiffness_nN_m2 == b.bend_stiffness_nN_m2 &&
           a.twist_stiffness_nN_m2 == b.twist_stiffness_nN_m2 && a.mass_mg_per_m == b.mass_mg_per_m &&
           a.radius_outer_um == b.radius_outer_um && a.radius_inner_um == b.radius_inner_um &&
           a.friction_kinetic_milli == b.friction_kinetic_milli &&
           a.friction_static_milli == b.friction_static_milli &&
           a.rest_curvature1_per_m_milli == b.rest_curvature1_per_m_milli &&
           a.rest_curvature2_per_m_milli == b.rest_curvature2_per_m_milli;
}

crn_wire_knot knot_at(const Section &section, const InstrumentArc *arc, double arc_mm)
{
    const double u = (arc_mm - section.from_mm) / (section.to_mm - section.from_mm);
    crn_wire_knot knot{};
    knot.arc_um = rounded(arc_mm * 1e3);
    knot.bend_stiffness_nN_m2 = rounded(by_ratio(section.bend_N_m2, u) * 1e9);
    knot.twist_stiffness_nN_m2 = rounded(by_ratio(section.twist_N_m2, u) * 1e9);
    knot.mass_mg_per_m = rounded(linearly(section.mass_kg_per_m, u) * 1e6);
    knot.radius_outer_um = rounded(linearly(section.radius_outer_mm, u) * 1e3);
    knot.radius_inner_um = rounded(linearly(section.radius_inner_mm, u) * 1e3);
    knot.friction_kinetic_milli = rounded(linearly(section.kinetic, u) * 1e3);
    knot.friction_static_milli = rounded(linearly(section.statical, u) * 1e3);
    if (arc) {
        knot.rest_curvature1_per_m_milli =
            static_cast<std::int32_t>(std::lround(arc->curvature1_per_m * 1e3));
        knot.rest_curvature2_per_m_milli =
            static_cast<std::int32_t>(std::lround(arc->curvature2_per_m * 1e3));
    }
    return knot;
}

// Returns arc lengths in ascending order: the ends of the section, of the equal steps into which it is
// divided, and of the arcs inside it.
std::vector<double> boundaries_mm(const Section &section, const std::vector<InstrumentArc> &shape)
{
    std::vector<double> all;
    for (int i = 0; i <= section.steps; i++) {
        all.push_back(section.from_mm + (section.to_mm - section.from_mm) * i / section.steps);
    }
    for (const InstrumentArc &arc : shape) {
        const double end_mm = arc.arc_end_m * 1e3;
        if (end_mm > section.from_mm && end_mm < section.to_mm) all.push_back(end_mm);
    }
    std::sort(all.begin(), all.end());
    std::vector<double> distinct = {section.from_mm};
    for (double at_mm : all) {
        if (at_mm > distinct.back() + same_mm && at_mm < section.to_mm - same_mm) distinct.push_back(at_mm);
    }
    distinct.push_back(section.to_mm);
    return distinct;
}

const InstrumentArc *arc_at(const std::vector<InstrumentArc> &shape, double arc_mm)
{
    for (const InstrumentArc &arc : shape) {
        if (arc_mm < arc.arc_end_m * 1e3) return &arc;
    }
    return nullptr;
}

// Adds a knot (values at an arc length) and removes redundant knots: the second of two equal knots, or the
// middle one of three knots with equal values.
void append(std::vector<crn_wire_knot> &knots, const crn_wire_knot &knot)
{
    const std::size_t count = knots.size();
    if (count > 0 && has_same_properties(knots.back(), knot)) {
        if (knots.back().arc_um == knot.arc_um) return;
        if (count > 1 && has_same_properties(knots[count - 2], knot)) knots.pop_back();
    }
    knots.push_back(knot);
}

} // namespace

void add_profile(const TomlTable &preset, const std::vector<Section> &sections, Instrument &instrument)
{
    std::vector<crn_wire_knot> knots;
    for (const Section &section : sections) {
        const std::vector<double> at_mm = boundaries_mm(section, instrument.shape);
        for (std::size_t i = 0; i + 1 < at_mm.size(); i++) {
            const InstrumentArc *arc = arc_at(instrument.shape, 0.5 * (at_mm[i] + at_mm[i + 1]));
            append(knots, knot_at(section, arc, at_mm[i]));
            append(knots, knot_at(section, arc, at_mm[i + 1]));
        }
        instrument.layers.insert(instrument.layers.end(), section.layers.begin(), section.layers.end());
    }
    if (knots.size() > CRN_WIRE_MAX_instrument_knots) {
        sections.front().table.in_place_of(preset).fail(
            "the profile needs " + std::to_string(knots.size()) + " knots, at most " +
            std::to_string(CRN_WIRE_MAX_instrument_knots) + "; use fewer steps, sections or shapes");
    }
    for (const crn_wire_knot &knot : knots) instrument.table.knots[instrument.table.knots_count++] = knot;
    instrument.length_m = sections.back().to_mm * 1e-3;
    if (!instrument.shape.empty() && instrument.shape.back().arc_end_m > instrument.length_m) {
        sections.back().table.in_place_of(preset).fail("the shape is longer than the instrument");
    }
    const int nodes = line_node_count(instrument.table);
    if (nodes > line_nodes_max) {
        sections.front().table.in_place_of(preset).fail("the elements make " + std::to_string(nodes) +
                                                        " nodes, at most " + std::to_string(line_nodes_max) +
                                                        "; use longer elements or fewer fine ones");
    }
}

} // namespace instrument_file

int line_node_count(std::span<const crn_wire_instrument *const> tools)
{
    // The number of elements is computed with the core's Q30 metres and rounding, because the instrument's
    // length may be an exact multiple of the element length.
    const auto q30 = [](std::uint64_t um) {
        return static_cast<std::int64_t>(((um << 30) + 500000) / 1000000);
    };
    constexpr std::int64_t rounding = 64;
    std::int64_t total = 0, tip = INT32_MAX, shaft = INT32_MAX, fine = 0;
    for (const crn_wire_instrument *tool : tools) {
        total = std::max(total, q30(tool->knots[tool->knots_count - 1].arc_um));
        tip = std::min(tip, q30(tool->element_tip_um));
        shaft = std::min(shaft, q30(tool->element_shaft_um));
        fine = std::max(fine, q30(tool->element_fine_um));
    }
    int nodes = 1;
    std::int64_t arc = 0, length = tip;
    while (arc + length <= total + rounding) {
        arc += length;
        nodes++;
        if (arc >= fine && length < shaft) length = std::min(length + length / 2, shaft);
    }
    return nodes;
}

int line_node_count(const crn_wire_instrument &tool)
{
    const crn_wire_instrument *const one[] = {&tool};
    return line_node_count(one);
}

std::vector<ShapePoint> unloaded_shape(const Instrument &instrument, double step_m, double straight_m)
{
    using Eigen::Vector3d;
    std::vector<ShapePoint> points;
    const double begin_m = instrument.shape.empty() ? 0.0 : instrument.shape.back().arc_end_m;
    ShapePoint at;
    at.arc_m = std::min(begin_m + straight_m, instrument.length_m);
    Vector3d d1 = Vector3d::UnitY(), d2 = -Vector3d::UnitZ();
    auto walk = [&](double until_m,
                    const Vector3d &rotation_per_m) { // constant curvature gives parts of a circle
        const double length_m = at.arc_m - until_m;
        const int steps = std::max(1, static_cast<int>(std::ceil(length_m / step_m - 1e-9)));
        for (int i = 0; i < steps && length_m > 0.0; i++) {
            points.push_back(at);
            const double part_m = length_m / steps, angle = rotation_per_m.norm() * part_m;
            const Vector3d axis = angle > 0.0 ? Vector3d(rotation_per_m.normalized()) : Vector3d::UnitX();
            const Vector3d chord = Eigen::AngleAxisd(0.5 * angle, axis) * at.forward;
            at.position_m += chord * (angle > 0.0 ? part_m * std::sin(0.5 * angle) / (0.5 * angle) : part_m);
            const Eigen::AngleAxisd turn(angle, axis);
            at.forward = turn * at.forward;
            d1 = turn * d1;
            d2 = turn * d2;
            at.arc_m -= part_m;
        }
    };
    walk(begin_m, Vector3d::Zero());
    for (auto arc = instrument.shape.rbegin(); arc != instrument.shape.rend(); ++arc) {
        const Vector3d towards = arc->curvature1_per_m * d1 + arc->curvature2_per_m * d2;
        walk(arc->arc_begin_m, at.forward.cross(towards));
    }
    points.push_back(at);
    std::reverse(points.begin(), points.end());
    return points;
}

} // namespace crn
