// Standard views by name. Angles and their sources: docs/room.md.
#pragma once
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace crn
{

struct ViewPreset {
    std::string_view name; // as a script says it
    std::string_view shows;
    std::int32_t primary_mdeg;   // + LAO
    std::int32_t secondary_mdeg; // + CRA
    std::int32_t field_um;
    std::int32_t sid_um; // as far back as the view needs to pass table and chest
};

std::span<const ViewPreset> view_presets();
const ViewPreset *view_preset(std::string_view name); // nullptr: no such view

} // namespace crn
