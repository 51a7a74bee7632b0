// For coronary views, each angle of the C-arm is the middle of its range in docs/room.md. The field is 20 cm
// for coronary arteries, 25 cm for renal arteries, and 32 cm for arch and pelvis. The distance from the X-ray
// source to the detector (SID) is 105 cm, or more in views where the detector would otherwise come too near
// the chest.
#include "host/room/presets.hpp"
#include <algorithm>
#include <iterator>

namespace crn
{
namespace
{

constexpr ViewPreset presets[] = {
    {"ap", "from the front", 0, 0, 320'000, 1'050'000},
    {"spider", "left main and its division (LAO caudal)", 45'000, -30'000, 200'000, 1'100'000},
    {"rao-caudal", "left main, circumflex", -10'000, -30'000, 200'000, 1'100'000},
    {"rao-caudal-steep", "circumflex and its marginals", -30'000, -35'000, 200'000, 1'100'000},
    {"rao-cranial", "left anterior descending", -5'000, 40'000, 200'000, 1'150'000},
    {"lao-cranial", "left anterior descending and diagonals", 40'000, 30'000, 200'000, 1'100'000},
    {"lateral", "left anterior descending from the side", 90'000, 0, 200'000, 1'150'000},
    {"rca-lao", "right coronary artery", 50'000, 0, 200'000, 1'050'000},
    {"rca-rao", "right coronary artery, middle part", -35'000, 0, 200'000, 1'050'000},
    {"arch", "aortic arch unfolded", 45'000, 0, 320'000, 1'100'000},
    {"renal-left", "origin of the left renal artery", 15'000, 0, 250'000, 1'050'000},
    {"renal-right", "origin of the right renal artery", -15'000, 0, 250'000, 1'050'000},
    {"iliac-left", "division of the left common iliac artery", -25'000, 0, 320'000, 1'050'000},
    {"iliac-right", "division of the right common iliac artery", 25'000, 0, 320'000, 1'050'000},
};

} // namespace

std::span<const ViewPreset> view_presets()
{
    return presets;
}

const ViewPreset *view_preset(std::string_view name)
{
    const auto *found = std::find_if(std::begin(presets), std::end(presets),
                                     [&](const ViewPreset &preset) { return preset.name == name; });
    return found == std::end(presets) ? nullptr : found;
}

} // namespace crn
