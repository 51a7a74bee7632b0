// What the person at the C-arm has asked for: part of a session, recorded with it, never seen by the core.
// Plain numbers, integers where they are recorded, so that a replay shows the same pictures.
#pragma once
#include <cstdint>

namespace seld
{

struct ViewState {
    bool is_fluoro_on = false;
    bool follows_tip = false;             // the table is moved to keep the tip in the field
    std::int32_t primary_mdeg = 0;        // + LAO
    std::int32_t secondary_mdeg = 0;      // + CRA
    std::int32_t table_um[3] = {0, 0, 0}; // patient point at the isocentre, when not following
    std::int32_t field_um = 320000;       // width of the square field at the detector

    bool operator==(const ViewState &) const = default;
};

} // namespace seld
