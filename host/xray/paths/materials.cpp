// Lists the names of the materials, in the order of the enum.
#include "host/xray/paths/materials.hpp"
#include <utility>

namespace crn
{
namespace
{

constexpr std::string_view names[material_count] = {
    "soft_tissue", "muscle",         "blood",   "lung",    "adipose",  "bone_cortical",
    "bone_spongy", "iohexol_350",    "steel",   "nitinol", "platinum", "tungsten",
    "gold",        "polymer_barium", "polymer", "air",
};

constexpr std::pair<std::string_view, Material> short_forms[] = {
    {"soft", Material::soft_tissue},
    {"gas", Material::air},
    {"tissue", Material::soft_tissue},
    {"skin", Material::soft_tissue},
    {"organ", Material::soft_tissue},
    {"water", Material::soft_tissue},
    {"heart", Material::muscle},
    {"fat", Material::adipose},
    {"bone", Material::bone_cortical},
    {"cortical_bone", Material::bone_cortical},
    {"trabecular_bone", Material::bone_spongy},
    {"marrow", Material::bone_spongy},
    {"contrast", Material::iohexol_350},
    {"steel_304", Material::steel},
    {"silicone", Material::polymer}, // of the phantoms; silicon would make it a little darker
};

} // namespace

std::string_view material_name(Material material)
{
    return names[static_cast<int>(material)];
}

std::optional<Material> material_from_name(std::string_view name)
{
    for (int i = 0; i < material_count; ++i)
        if (names[i] == name) return static_cast<Material>(i);
    for (const auto &[word, material] : short_forms)
        if (word == name) return material;
    return std::nullopt;
}

std::string material_names()
{
    std::string list;
    for (std::string_view name : names) list += (list.empty() ? "" : ", ") + std::string(name);
    return list;
}

} // namespace crn
