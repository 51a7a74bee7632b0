#include "host/report/figures/reported_tools.hpp"
#include "host/script/session.hpp"

namespace crn
{

std::vector<Instrument> reported_tools(const Patient &patient)
{
    return with_free_positions(patient.tools());
}

std::vector<Instrument> with_free_positions(std::vector<Instrument> tools)
{
    for (Instrument &tool : tools)
        if (tool.name.empty() && tool.table.knots_count == 0) tool.name = free_position;
    return tools;
}

} // namespace crn
