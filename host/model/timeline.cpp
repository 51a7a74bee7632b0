#include "host/model/timeline.hpp"
#include "host/model/units.hpp"
#include <algorithm>

namespace seld
{

WireFrame wire_frame(const seld_wire_nodes &nodes, const seld_wire_node_table &table)
{
    WireFrame frame;
    frame.tick = nodes.tick;
    const std::size_t count = std::min(nodes.positions_count, table.nodes_count);
    frame.nodes.reserve(count);
    for (std::size_t i = 0; i < count; i++) {
        const seld_wire_node_position &p = nodes.positions[i];
        const seld_wire_node_rest &rest = table.nodes[i];
        frame.nodes.push_back({units::metres(p.x_m_q30, p.y_m_q30, p.z_m_q30), units::metres(rest.arc_m_q30),
                               units::metres(rest.radius_m_q30), 0.0});
    }
    return frame;
}

} // namespace seld
