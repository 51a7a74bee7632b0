// Lists the materials that an X-ray beam may cross, with the names that body files and instrument files use.
// The attenuation of the materials is in attenuation.cpp, which tools/check/make_attenuation.py writes.
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

// Returns the name that files use for a material, such as "bone_cortical".
std::string_view material_name(Material material);

// Accepts the full names of the materials, and these short forms: tissue, skin, organ, water (soft_tissue),
// heart (muscle), fat (adipose), bone, cortical (bone_cortical), spongy, marrow (bone_spongy), contrast
// (iohexol_350), steel_304 (steel).
std::optional<Material> material_from_name(std::string_view name);

// Bodies of spongy bone may state how much of their volume is bone: "spongy_14" has 14 %, the rest is yellow
// marrow. The material is bone_spongy, which has 19.5 %; the difference is a share of the bone around it, in
// place of marrow. So the lengths in such a body are multiplied by this factor, in 1/1024: those added to
// bone_spongy, and those taken from the bone around it. Returns 1024 for every other name.
int spongy_scale_q10(std::string_view name);

// Returns all accepted names of materials, separated by commas, for error messages.
std::string material_names();

} // namespace crn
