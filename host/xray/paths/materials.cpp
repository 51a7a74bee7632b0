// Lists the names of the materials, in the order of the enum.
#include "host/xray/paths/materials.hpp"
#include <cmath>
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

// Returns the percentage N of a name "spongy_N", which has no leading zero.
std::optional<int> spongy_percent(std::string_view name)
{
    constexpr std::string_view prefix = "spongy_";
    constexpr int most = 60;
    if (!name.starts_with(prefix)) return std::nullopt;
    name.remove_prefix(prefix.size());
    if (name.empty() || name.size() > 2 || name[0] == '0') return std::nullopt;
    int percent = 0;
    for (const char c : name) {
        if (c < '0' || c > '9') return std::nullopt;
        percent = 10 * percent + (c - '0');
    }
    return percent <= most ? std::optional(percent) : std::nullopt;
}

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
    if (spongy_percent(name)) return Material::bone_spongy;
    return std::nullopt;
}

// Both mixtures are marrow and bone, a share x of it bone. With m and b for their attenuation, that of N % is
// (1 - x) m + x b = a ((1 - x0) m + x0 b) + (1 - a) b, where a = (1 - x) / (1 - x0).
int spongy_scale_q10(std::string_view name)
{
    constexpr double nominal = 0.195; // 32 % of the mass: tools/check/make_attenuation.py
    const std::optional<int> percent = spongy_percent(name);
    return percent ? static_cast<int>(std::lround(1024.0 * (1.0 - 0.01 * *percent) / (1.0 - nominal))) : 1024;
}

std::string material_names()
{
    std::string list;
    for (std::string_view name : names) list += (list.empty() ? "" : ", ") + std::string(name);
    return list + ", spongy_1 to spongy_60";
}

} // namespace crn
