// The sections of the scene container are specified in docs/scene.md.
#include "tools/bake/container.hpp"
#include "host/base/pending_file.hpp"
#include "shared/scene/scene_write.h"
#include "shared/wire/wire_frame.h"
#include "tools/bake/fault.hpp"
#include "tools/bake/plaque.hpp"

#include <cmath>
#include <cstring>

namespace crn::bake
{
namespace
{

void put_u32(Bytes &bytes, std::uint32_t value)
{
    bytes.resize(bytes.size() + 4);
    crn_scene_put_u32(&bytes[bytes.size() - 4], value);
}

void put_u16(Bytes &bytes, std::uint16_t value)
{
    bytes.resize(bytes.size() + 2);
    crn_scene_put_u16(&bytes[bytes.size() - 2], value);
}

void put_text(Bytes &bytes, const std::string &text, std::size_t capacity)
{
    bytes.insert(bytes.end(), text.begin(), text.end());
    bytes.resize(bytes.size() + capacity - text.size());
}

Bytes meta_section(const SceneText &text)
{
    Bytes bytes;
    put_text(bytes, text.name, CRN_SCENE_NAME_BYTES);
    put_text(bytes, text.source, CRN_SCENE_SOURCE_BYTES);
    return bytes;
}

Bytes entry_section(const Eigen::Vector3d &position_mm, const Eigen::Vector3d &direction,
                    std::uint32_t start_um)
{
    Bytes bytes;
    const crn_vec3 position = to_q30(position_mm);
    for (int k = 0; k < 3; ++k) put_u32(bytes, static_cast<std::uint32_t>(position.v[k]));
    for (int k = 0; k < 3; ++k)
        put_u32(bytes, static_cast<std::uint32_t>(
                           static_cast<std::int32_t>(std::lround(std::ldexp(direction[k], 30)))));
    if (start_um > 0) put_u32(bytes, start_um);
    return bytes;
}

Bytes lumen_section(const Field &field)
{
    Bytes bytes;
    for (std::int32_t origin : field.lumen.origin_m_q30) put_u32(bytes, static_cast<std::uint32_t>(origin));
    for (std::uint16_t count : field.lumen.brick_count_xyz) put_u16(bytes, count);
    put_u16(bytes, field.lumen.child_row_count);
    put_u32(bytes, field.lumen.brick_count);
    put_u16(bytes, static_cast<std::uint16_t>(field.row_first_rank));
    put_u16(bytes, 0);
    put_u32(bytes, 0);
    for (std::uint16_t entry : field.index) put_u16(bytes, entry);
    for (std::uint16_t entry : field.children) put_u16(bytes, entry);
    for (std::int8_t sample : field.samples) bytes.push_back(static_cast<std::uint8_t>(sample));
    return bytes;
}

// Writes the MOTION section of the scene file, or the BREATH section when the motion has no keyframes.
Bytes motion_section(const crn_lattice &lattice, std::uint16_t keyframes,
                     const std::vector<std::int16_t> &values)
{
    Bytes bytes;
    for (std::int32_t origin : lattice.origin_m_q30) put_u32(bytes, static_cast<std::uint32_t>(origin));
    for (std::uint32_t count : lattice.count_xyz) put_u16(bytes, static_cast<std::uint16_t>(count));
    put_u16(bytes, static_cast<std::uint16_t>(lattice.spacing_log2_q30));
    put_u16(bytes, keyframes);
    put_u16(bytes, 0);
    put_u32(bytes, 0);
    put_u32(bytes, 0);
    for (std::int16_t value : values) put_u16(bytes, static_cast<std::uint16_t>(value));
    return bytes;
}

// Writes the displacement of every vertex by a full breath. The positions are rounded first, so that the
// inhaled body has exactly the rounded positions.
void put_breath(Bytes &bytes, const BakedBody &body)
{
    for (std::size_t i = 0; i < body.inhaled_mm.size(); ++i)
        for (int k = 0; k < 3; ++k) {
            const long way_um =
                std::lround(body.inhaled_mm[i][k] * 1000) - std::lround(body.mesh.vertices_mm[i][k] * 1000);
            put_u16(bytes, static_cast<std::uint16_t>(static_cast<std::int16_t>(way_um)));
        }
}

Bytes body_section(const BakedBody &body)
{
    Bytes bytes;
    put_text(bytes, body.name, CRN_SCENE_BODY_NAME_BYTES);
    put_text(bytes, body.material, CRN_SCENE_MATERIAL_BYTES);
    put_u32(bytes, static_cast<std::uint32_t>(body.parent));
    put_u32(bytes, static_cast<std::uint32_t>(body.mesh.vertices_mm.size()));
    put_u32(bytes, static_cast<std::uint32_t>(body.mesh.triangles.size()));
    const std::uint32_t motion = body.moves                 ? CRN_SCENE_BODY_MOVES
                                 : !body.inhaled_mm.empty() ? CRN_SCENE_BODY_BREATHES
                                                            : 0;
    put_u32(bytes, body.is_trabecular ? motion | CRN_SCENE_BODY_TRABECULAE : motion);
    for (const Eigen::Vector3d &v : body.mesh.vertices_mm)
        for (int k = 0; k < 3; ++k)
            put_u32(bytes, static_cast<std::uint32_t>(static_cast<std::int32_t>(std::lround(v[k] * 1000))));
    for (const Triangle &t : body.mesh.triangles)
        for (std::uint32_t corner : t) put_u32(bytes, corner);
    put_breath(bytes, body);
    return bytes;
}

void put_tree_point(Bytes &bytes, const Eigen::Vector3d &point_m, double radius_m)
{
    for (int k = 0; k < 3; ++k)
        put_u32(bytes, static_cast<std::uint32_t>(static_cast<std::int32_t>(std::lround(point_m[k] * 1e6))));
    put_u32(bytes, static_cast<std::uint32_t>(std::lround(radius_m * 1e6)));
}

Bytes lesions_section(const VesselTree &tree)
{
    Bytes bytes;
    std::uint32_t points = 0;
    for (const VesselLesion &lesion : tree.lesions) points += static_cast<std::uint32_t>(lesion.size());
    put_u32(bytes, static_cast<std::uint32_t>(tree.lesions.size()));
    put_u32(bytes, points);
    bytes.resize(CRN_SCENE_LESIONS_HEADER_BYTES);
    std::uint32_t first = 0;
    for (const VesselLesion &lesion : tree.lesions) {
        const auto count = static_cast<std::uint32_t>(lesion.size());
        put_text(bytes, lesion.name, CRN_SCENE_BRANCH_NAME_BYTES);
        put_u32(bytes, static_cast<std::uint32_t>(lesion.branch));
        put_u32(bytes, static_cast<std::uint32_t>(lesion.first_point));
        put_u32(bytes, count);
        put_u32(bytes, first);
        first += count;
    }
    for (const VesselLesion &lesion : tree.lesions)
        for (std::size_t i = 0; i < lesion.size(); ++i)
            put_tree_point(bytes, lesion.healthy_points_m[i], lesion.healthy_radii_m[i]);
    return bytes;
}

Bytes branches_section(const std::vector<VesselBranch> &branches, double flow_unit_ml_s)
{
    Bytes bytes;
    std::uint32_t points = 0;
    for (const VesselBranch &branch : branches) points += static_cast<std::uint32_t>(branch.points_m.size());
    put_u32(bytes, static_cast<std::uint32_t>(branches.size()));
    put_u32(bytes, points);
    bytes.resize(CRN_SCENE_TREE_HEADER_BYTES);
    std::uint32_t first = 0;
    for (const VesselBranch &branch : branches) {
        const auto count = static_cast<std::uint32_t>(branch.points_m.size());
        put_text(bytes, branch.name, CRN_SCENE_BRANCH_NAME_BYTES);
        put_u32(bytes, static_cast<std::uint32_t>(branch.parent));
        put_u32(bytes, static_cast<std::uint32_t>(branch.parent_point));
        put_u32(bytes, first);
        put_u32(bytes, count);
        put_u32(bytes, static_cast<std::uint32_t>(branch.bed));
        put_u32(bytes, static_cast<std::uint32_t>(std::lround(branch.flow_ml_s / flow_unit_ml_s)));
        const bool joins = branch.joins >= 0;
        put_u32(bytes, joins ? CRN_SCENE_BRANCH_JOINS : branch.is_vein ? CRN_SCENE_BRANCH_IS_VEIN : 0);
        put_u32(bytes, joins ? static_cast<std::uint32_t>(branch.joins) : 0);
        first += count;
    }
    for (const VesselBranch &branch : branches)
        for (std::size_t i = 0; i < branch.points_m.size(); ++i)
            put_tree_point(bytes, branch.points_m[i], branch.radii_m[i]);
    return bytes;
}

Bytes partner_section(const Bytes &scene)
{
    Bytes bytes;
    put_u32(bytes, static_cast<std::uint32_t>(scene.size()));
    put_u32(bytes, crn_wire_crc32(0, scene.data(), scene.size()));
    return bytes;
}

std::string_view text_of(const Bytes &bytes)
{
    return {reinterpret_cast<const char *>(bytes.data()), bytes.size()};
}

// Lays out the bytes of the file, and then checks these bytes by opening them with the device's own reader.
Bytes sealed(crn_scene_kind kind, const std::vector<std::pair<crn_scene_section, Bytes>> &sections,
             const std::string &what)
{
    std::vector<crn_scene_part> parts;
    for (const auto &[type, bytes] : sections) parts.push_back({type, bytes.data(), bytes.size()});
    const auto count = static_cast<std::uint32_t>(parts.size());
    Bytes file(crn_scene_write_bytes(parts.data(), count));
    if (file.empty() || crn_scene_write(kind, parts.data(), count, file.data(), file.size()) != file.size())
        throw Fault(what + ": larger than 2 GiB: simplify the meshes");
    crn_scene scene;
    std::uint32_t where = 0;
    const crn_scene_status status = crn_scene_open(file.data(), file.size(), &scene, &where);
    if (status != CRN_SCENE_OK)
        throw Fault(what + ": " + crn_scene_status_text(status) + " (byte " + std::to_string(where) + ")");
    return file;
}

} // namespace

Bytes scene_bytes(const SceneText &text, const Eigen::Vector3d &entry_mm, const Eigen::Vector3d &direction,
                  const Field &field, const Motion *motion, const VesselTree *tree, std::uint32_t start_um)
{
    std::vector<std::pair<crn_scene_section, Bytes>> sections = {
        {CRN_SCENE_META, meta_section(text)},
        {CRN_SCENE_ENTRY, entry_section(entry_mm, direction, start_um)},
        {CRN_SCENE_LUMEN, lumen_section(field)}};
    if (motion)
        sections.emplace_back(CRN_SCENE_MOTION, motion_section(motion->lattices.beat,
                                                               CRN_SCENE_MOTION_KEYFRAMES, motion->rows));
    if (motion && !motion->inhaled.empty())
        sections.emplace_back(CRN_SCENE_BREATH, motion_section(motion->lattices.breath, 0, motion->inhaled));
    if (tree && !tree->lesions.empty())
        sections.emplace_back(CRN_SCENE_PLAQUES, plaques_section(*tree, text.lesions));
    if (text.walls.is_given) sections.emplace_back(CRN_SCENE_WALLS, walls_section(text.walls, field, tree));
    return sealed(CRN_SCENE_KIND_SCENE, sections, text.file.string());
}

Bytes bodies_bytes(const SceneText &text, const std::vector<BakedBody> &bodies, const VesselTree &tree,
                   const Bytes &scene)
{
    std::vector<std::pair<crn_scene_section, Bytes>> sections{{CRN_SCENE_META, meta_section(text)}};
    for (const BakedBody &body : bodies) sections.emplace_back(CRN_SCENE_BODY, body_section(body));
    if (!tree.branches.empty()) sections.emplace_back(CRN_SCENE_TREE, branches_section(tree.branches, 1e-3));
    if (!tree.small.empty()) sections.emplace_back(CRN_SCENE_SMALL, branches_section(tree.small, 1e-6));
    if (!tree.lesions.empty()) sections.emplace_back(CRN_SCENE_LESIONS, lesions_section(tree));
    if (!scene.empty()) sections.emplace_back(CRN_SCENE_PARTNER, partner_section(scene));
    return sealed(CRN_SCENE_KIND_BODIES, sections, text.file.string());
}

void write_whole(const std::filesystem::path &file, const Bytes &bytes)
{
    write_whole_file(file.string(), text_of(bytes));
}

void write_both(const std::filesystem::path &scene_file, const Bytes &scene,
                const std::filesystem::path &bodies_file, const Bytes &bodies)
{
    FileSet files;
    files.add(bodies_file.string(), text_of(bodies));
    files.add(scene_file.string(), text_of(scene));
    files.commit();
}

} // namespace crn::bake
