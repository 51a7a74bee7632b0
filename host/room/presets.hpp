// Lists the standard views of the C-arm by name. The file docs/room.md names the sources of the angles.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace crn
{

struct ViewPreset {
    std::string_view name; // as written in a script
    std::string_view shows;
    std::int32_t primary_mdeg;   // + LAO
    std::int32_t secondary_mdeg; // + CRA
    std::int32_t field_um;
    std::int32_t sid_um; // as large as the view needs to clear table and chest
};

std::span<const ViewPreset> view_presets();
const ViewPreset *view_preset(std::string_view name); // nullptr: no such view

} // namespace crn
