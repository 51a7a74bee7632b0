// Reads body files. The format of body files is the container of shared/scene with KIND_BODIES
// (docs/scene.md).
#include "host/base/format.hpp"
#include "host/base/text.hpp"
#include "host/model/bodies.hpp"
#include "host/model/ct_volume.hpp"
#include "shared/scene/scene.h"
#include "shared/wire/wire_frame.h"

namespace crn
{
namespace
{

Body read_body(const crn_scene_body_view &view)
{
    Body body;
    body.name = view.name;
    body.material = view.material;
    body.parent = view.parent;
    body.moves = view.moves;
    body.is_trabecular = view.is_trabecular;
    body.vertices_um.resize(view.vertex_count);
    for (std::size_t i = 0; i < view.vertex_count; ++i) {
        const std::uint8_t *at = view.vertices_um + 12 * i;
        body.vertices_um[i] = {crn_scene_i32(at), crn_scene_i32(at + 4), crn_scene_i32(at + 8)};
    }
    body.triangles.resize(view.triangle_count);
    for (std::size_t i = 0; i < view.triangle_count; ++i) {
        const std::uint8_t *at = view.triangles + 12 * i;
        body.triangles[i] = {crn_scene_u32(at), crn_scene_u32(at + 4), crn_scene_u32(at + 8)};
    }
    if (view.breath_um) {
        body.breath_um.resize(view.vertex_count);
        for (std::size_t i = 0; i < 3 * std::size_t{view.vertex_count}; ++i)
            body.breath_um.data()->data()[i] =
                static_cast<std::int16_t>(crn_scene_u16(view.breath_um + 2 * i));
    }
    return body;
}

void read_points(const std::uint8_t *points, std::size_t count, std::vector<Eigen::Vector3d> &places_m,
                 std::vector<double> &radii_m)
{
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint8_t *at = points + CRN_SCENE_TREE_POINT_BYTES * i;
        places_m.push_back(Eigen::Vector3d(crn_scene_i32(at), crn_scene_i32(at + 4), crn_scene_i32(at + 8)) *
                           1e-6);
        radii_m.push_back(crn_scene_u32(at + 12) * 1e-6);
    }
}

VesselBranch read_branch(const crn_scene_branch_view &view, double flow_unit_ml_s)
{
    VesselBranch branch;
    branch.name = view.name;
    branch.parent = view.parent;
    branch.parent_point = view.parent_point;
    branch.bed = static_cast<VesselBed>(view.bed);
    branch.flow_ml_s = view.flow_mm3_per_s * flow_unit_ml_s;
    branch.is_vein = (view.flags & CRN_SCENE_BRANCH_IS_VEIN) != 0;
    if ((view.flags & CRN_SCENE_BRANCH_JOINS) != 0) branch.joins = static_cast<int>(view.joins);
    read_points(view.points, view.point_count, branch.points_m, branch.radii_m);
    return branch;
}

VesselLesion read_lesion(const crn_scene_lesion_view &view)
{
    VesselLesion lesion;
    lesion.name = view.name;
    lesion.branch = view.branch;
    lesion.first_point = view.first_point;
    read_points(view.healthy_points, view.point_count, lesion.healthy_points_m, lesion.healthy_radii_m);
    return lesion;
}

std::string describe(const SceneName &scene)
{
    return formatted("%zu bytes, CRC-32 %08x", scene.size_bytes, unsigned{scene.crc32});
}

std::string strangers(const std::string &scene_path, const SceneName &scene, const std::string &path,
                      const std::optional<SceneName> &baked_with)
{
    const std::string remedy = "; bake " + scene_path +
                               " again, which writes its bodies beside it, or name its own body file with "
                               "--bodies";
    if (!baked_with)
        return path + ": does not say which scene it was baked with, as files of an older bake" + remedy;
    return path + ": these bodies were not baked with " + scene_path + ": that scene has " + describe(scene) +
           ", theirs had " + describe(*baked_with) + remedy;
}

} // namespace

bool read_bodies(const std::string &path, Bodies &bodies, std::string &error)
{
    std::vector<unsigned char> bytes;
    try {
        bytes = read_binary_file(path);
    } catch (const FileError &fault) {
        error = fault.what();
        return false;
    }
    crn_scene scene;
    std::uint32_t where_byte = 0;
    const crn_scene_status status = crn_scene_open(bytes.data(), bytes.size(), &scene, &where_byte);
    if (status != CRN_SCENE_OK) {
        error = path + ": byte " + std::to_string(where_byte) + ": " + crn_scene_status_text(status);
        return false;
    }
    if (scene.kind != CRN_SCENE_KIND_BODIES) {
        error = path + ": a scene for the device, not a body file; name the file that ends in .bodies";
        return false;
    }
    Bodies read;
    for (std::uint32_t i = 0; i < scene.body_count; ++i)
        read.bodies.push_back(read_body(crn_scene_body(&scene, i)));
    for (std::uint32_t i = 0; i < scene.branch_count; ++i)
        read.vessels.branches.push_back(read_branch(crn_scene_branch(&scene, i), 1e-3));
    for (std::uint32_t i = 0; i < scene.small_count; ++i)
        read.vessels.small.push_back(read_branch(crn_scene_small(&scene, i), 1e-6));
    for (std::uint32_t i = 0; i < scene.lesion_count; ++i)
        read.vessels.lesions.push_back(read_lesion(crn_scene_lesion(&scene, i)));
    const std::string ct = ct_beside(path);
    if (!ct.empty()) {
        auto volume = std::make_shared<CtVolume>();
        if (!read_ct_volume(ct, *volume, error)) return false;
        read.ct = std::move(volume);
    }
    if (scene.has_partner) read.baked_with = SceneName{scene.partner_bytes, scene.partner_crc32};
    bodies = std::move(read);
    return true;
}

bool read_bodies_of(const std::string &scene_path, const std::string &path, Bodies &bodies,
                    std::string &error)
{
    Bodies read;
    if (!read_bodies(path, read, error)) return false;
    if (!scene_path.empty()) {
        SceneName scene;
        try {
            const std::vector<unsigned char> bytes = read_binary_file(scene_path);
            scene = {bytes.size(), crn_wire_crc32(0, bytes.data(), bytes.size())};
        } catch (const FileError &fault) {
            error = fault.what();
            return false;
        }
        if (read.baked_with != scene) {
            error = strangers(scene_path, scene, path, read.baked_with);
            return false;
        }
    }
    bodies = std::move(read);
    return true;
}

} // namespace crn
