// The materials an X-ray beam meets, by the names used in body files and instrument files. Their attenuation
// is in attenuation.cpp, written by tools/check/make_attenuation.py.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace crn
{

enum class Material : std::uint8_t {
    soft_tissue,
    muscle,
    blood,
    lung,
    adipose,
    bone_cortical,
    bone_spongy,
    iohexol_350,
    steel,
    nitinol,
    platinum,
    tungsten,
    gold,
    polymer_barium,
    polymer,
    air,
};
inline constexpr int material_count = 16;

// Name as written in files, e.g. "bone_cortical".
std::string_view material_name(Material material);

// Accepts the names above and these short forms: tissue, skin, organ, water (soft_tissue), heart (muscle),
// fat (adipose), bone, cortical (bone_cortical), spongy, marrow (bone_spongy), contrast (iohexol_350),
// steel_304 (steel).
std::optional<Material> material_from_name(std::string_view name);

// All accepted names, comma separated, for error messages.
std::string material_names();

} // namespace crn
