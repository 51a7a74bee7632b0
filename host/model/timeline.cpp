#include "host/model/timeline.hpp"
#include "host/model/units.hpp"
#include <algorithm>

namespace crn
{

double outer_radius_m(const crn_wire_instrument &tool, double arc_m)
{
    if (tool.knots_count == 0) return 0.0;
    const crn_wire_knot *after =
        std::upper_bound(tool.knots, tool.knots + tool.knots_count, arc_m,
                         [](double arc, const crn_wire_knot &knot) { return arc < knot.arc_um * 1e-6; });
    if (after == tool.knots) return after->radius_outer_um * 1e-6;
    const crn_wire_knot &before = after[-1];
    if (after == tool.knots + tool.knots_count) return before.radius_outer_um * 1e-6;
    const double share = (arc_m - before.arc_um * 1e-6) / ((after->arc_um - before.arc_um) * 1e-6);
    return (before.radius_outer_um + share * (double{1} * after->radius_outer_um - before.radius_outer_um)) *
           1e-6;
}

WireFrame wire_frame(const crn_wire_nodes &nodes, const crn_wire_node_table &table,
                     std::span<const Instrument> tools)
{
    WireFrame frame;
    frame.tick = nodes.tick;
    frame.heart_phase32 = nodes.heart_phase32;
    frame.breath_phase32 = nodes.breath_phase32;
    const std::span<const std::int32_t> inserted(nodes.inserted_m_q30, nodes.inserted_m_q30_count);
    for (std::int32_t m_q30 : inserted)
        frame.tip_arc_m.push_back(units::metres(*std::max_element(inserted.begin(), inserted.end())) -
                                  units::metres(m_q30));
    const std::size_t count = std::min(nodes.positions_count, table.arcs_m_q30_count);
    frame.nodes.reserve(count);
    for (std::size_t i = 0; i < count; i++) {
        const crn_wire_node_position &p = nodes.positions[i];
        WireNode node{units::metres(p.x_m_q30, p.y_m_q30, p.z_m_q30), units::metres(table.arcs_m_q30[i]), 0.0,
                      0.0};
        for (std::size_t k = 0; k < std::min(tools.size(), frame.tip_arc_m.size()); k++) {
            const double own_arc_m = node.arc_m - frame.tip_arc_m[k];
            if (own_arc_m >= 0.0)
                node.radius_m = std::max(node.radius_m, outer_radius_m(tools[k].table, own_arc_m));
        }
        frame.nodes.push_back(node);
    }
    for (std::size_t j = 0; j < nodes.balloon_radii_um_count; j++)
        frame.balloon_radii_m.push_back(nodes.balloon_radii_um[j] * 1e-6);
    frame.balloon_arc_m = units::metres(nodes.balloon_arc_m_q30);
    frame.balloon_spacing_m = units::metres(nodes.balloon_spacing_m_q30);
    for (std::size_t i = 0; i < nodes.lesions_open_q15_count; i++)
        frame.lesions_open.push_back(nodes.lesions_open_q15[i] / 32768.0);
    for (std::size_t j = 0; j < nodes.walls_count; j++) {
        const crn_wire_wall_way &at = nodes.walls[j];
        frame.walls.push_back({Eigen::Vector3d(at.x_um, at.y_um, at.z_um) * 1e-6, at.widened_um * 1e-6});
    }
    return frame;
}

} // namespace crn
