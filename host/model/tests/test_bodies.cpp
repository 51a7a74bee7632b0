// These tests check the following. Reading a body file gives the bodies that were written. A file that is not
// a body file is refused with a message that names the file, the byte and the remedy. A body that breathes
// lies as in the file at the end of expiration, and is displaced by the stated displacement at the end of
// inspiration.
#include "host/model/bodies.hpp"
#include "host/model/breathing_bodies.hpp"
#include "host/xray/tests/xray_shapes.hpp"
#include "shared/scene/scene_write.h"
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <unistd.h>
extern "C" {
#include <cmocka.h>
}

using namespace crn;

namespace
{

const std::string path = "/tmp/cournand-bodies-" + std::to_string(getpid()) + ".bodies";

// Makes the BODY section that docs/scene.md describes, independently of tools/bake.
std::vector<std::uint8_t> body_section(const Body &body)
{
    std::vector<std::uint8_t> bytes(64);
    std::memcpy(bytes.data(), body.name.data(), body.name.size());
    std::memcpy(bytes.data() + 32, body.material.data(), body.material.size());
    crn_scene_put_u32(bytes.data() + 48, static_cast<std::uint32_t>(body.parent));
    crn_scene_put_u32(bytes.data() + 52, static_cast<std::uint32_t>(body.vertices_um.size()));
    crn_scene_put_u32(bytes.data() + 56, static_cast<std::uint32_t>(body.triangles.size()));
    auto put = [&](std::uint32_t word) {
        bytes.resize(bytes.size() + 4);
        crn_scene_put_u32(bytes.data() + bytes.size() - 4, word);
    };
    for (const auto &vertex : body.vertices_um)
        for (int axis = 0; axis < 3; ++axis) put(static_cast<std::uint32_t>(vertex[axis]));
    for (const auto &triangle : body.triangles)
        for (std::uint32_t corner : triangle) put(corner);
    if (body.breath_um.empty()) return bytes;
    crn_scene_put_u32(bytes.data() + 60, CRN_SCENE_BODY_BREATHES);
    for (const auto &way : body.breath_um)
        for (int axis = 0; axis < 3; ++axis) {
            bytes.resize(bytes.size() + 2);
            crn_scene_put_u16(bytes.data() + bytes.size() - 2, static_cast<std::uint16_t>(way[axis]));
        }
    return bytes;
}

std::vector<std::uint8_t> body_file(const Bodies &bodies, std::optional<SceneName> baked_with = {})
{
    std::vector<std::uint8_t> meta(CRN_SCENE_META_BYTES, 0);
    std::memcpy(meta.data(), "test", 4);
    std::vector<std::vector<std::uint8_t>> sections;
    for (const Body &body : bodies.bodies) sections.push_back(body_section(body));
    std::vector<crn_scene_part> parts = {{CRN_SCENE_META, meta.data(), meta.size()}};
    for (const auto &section : sections) parts.push_back({CRN_SCENE_BODY, section.data(), section.size()});
    std::uint8_t partner[CRN_SCENE_PARTNER_BYTES];
    if (baked_with) {
        crn_scene_put_u32(partner, static_cast<std::uint32_t>(baked_with->size_bytes));
        crn_scene_put_u32(partner + 4, baked_with->crc32);
        parts.push_back({CRN_SCENE_PARTNER, partner, sizeof partner});
    }
    const auto count = static_cast<std::uint32_t>(parts.size());
    std::vector<std::uint8_t> file(crn_scene_write_bytes(parts.data(), count));
    crn_scene_write(CRN_SCENE_KIND_BODIES, parts.data(), count, file.data(), file.size());
    return file;
}

void write(const std::vector<std::uint8_t> &bytes)
{
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char *>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

Bodies two_bodies()
{
    return {{sphere_body("skin", "soft", -1, {0, 0, 0}, 0.1, 3),
             box_body("spine", "cortical_bone", 0, {-0.01, -0.02, -0.03}, {0.01, 0.02, 0.03})}};
}

} // namespace

static void body_file_reads_back_as_written(void **)
{
    write(body_file(two_bodies()));
    Bodies read;
    std::string error;
    if (!read_bodies(path, read, error)) std::printf("# %s\n", error.c_str());
    assert_int_equal(read.bodies.size(), 2);
    for (std::size_t i = 0; i < 2; ++i) {
        const Body got = read.bodies[i], wanted = two_bodies().bodies[i];
        assert_string_equal(got.name.c_str(), wanted.name.c_str());
        assert_string_equal(got.material.c_str(), wanted.material.c_str());
        assert_int_equal(got.parent, wanted.parent);
        assert_true(got.vertices_um == wanted.vertices_um);
        assert_true(got.triangles == wanted.triangles);
    }
    unlink(path.c_str());
}

static void missing_file_is_named(void **)
{
    Bodies read;
    std::string error;
    assert_false(read_bodies("/nowhere/a.bodies", read, error));
    assert_true(error.find("/nowhere/a.bodies") != error.npos);
}

// The test cuts a file after every 37th byte, and flips a bit in every 37th byte. All cut or changed files
// must be refused, and the bodies that were read before must not change.
static void damaged_file_is_refused_and_leaves_the_old_bodies(void **)
{
    const std::vector<std::uint8_t> whole = body_file(two_bodies());
    Bodies old = two_bodies();
    std::string error;
    for (std::size_t at = 0; at < whole.size(); at += 37) {
        write({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(at)});
        assert_false(read_bodies(path, old, error));
        std::vector<std::uint8_t> flipped = whole;
        flipped[at] ^= 0x10;
        write(flipped);
        error.clear();
        assert_false(read_bodies(path, old, error));
        assert_true(error.find(path) == 0 && error.find("byte") != error.npos);
        assert_int_equal(old.bodies.size(), 2);
    }
    unlink(path.c_str());
}

// The CRC-32 of "123456789" is cbf43926, which is the check value in catalogues of CRC algorithms.
static void bodies_are_read_with_the_scene_they_were_baked_with_alone(void **)
{
    const std::string scene = path + ".scene", other = path + ".other";
    std::ofstream(scene) << "123456789";
    std::ofstream(other) << "123456780";
    write(body_file(two_bodies(), SceneName{9, 0xcbf43926}));
    Bodies read;
    std::string error;
    assert_true(read_bodies_of(scene, path, read, error));
    assert_int_equal(read.bodies.size(), 2);
    Bodies kept;
    assert_false(read_bodies_of(other, path, kept, error));
    assert_true(kept.bodies.empty());
    for (const char *part : {"were not baked with", "9 bytes, CRC-32 cbf43926", "bake ", "--bodies"})
        assert_true(error.find(part) != error.npos);
    assert_true(error.find(path + ":") == 0 && error.find(other) != error.npos);
    write(body_file(two_bodies())); // from an older bake
    assert_false(read_bodies_of(scene, path, kept, error));
    assert_true(error.find("does not say which scene") != error.npos && error.find("bake ") != error.npos);
    assert_true(read_bodies_of("", path, kept, error)); // free space has none
    for (const std::string &file : {scene, other, path}) unlink(file.c_str());
}

static void a_body_breathes_in_steps_of_its_displacement(void **)
{
    constexpr std::uint32_t inhaled = 1u << 31;
    Bodies bodies = two_bodies(), read;
    for (const Eigen::Vector3i &vertex_um : bodies.bodies[1].vertices_um)
        bodies.bodies[1].breath_um.emplace_back(0, -12000, vertex_um.x() > 0 ? 1500 : -7);
    write(body_file(bodies));
    std::string error;
    assert_true(read_bodies(path, read, error));
    unlink(path.c_str());
    assert_true(read.bodies[0].breath_um.empty() && read.bodies[1].breath_um == bodies.bodies[1].breath_um);
    const std::vector<Eigen::Vector3i> &rest = read.bodies[1].vertices_um, &way = read.bodies[1].breath_um;
    BreathingBodies breathing(read);
    for (const std::uint32_t phase : {0u, inhaled / 10, inhaled / 2, inhaled, inhaled + inhaled / 2, 0u}) {
        const auto &moved = breathing.at(phase);
        assert_int_equal(moved.size(), 1);
        assert_int_equal(moved[0].body, 1);
        // The depth is sin^4(pi phase), by docs/heart.md.
        const double sine = std::sin(3.14159265358979 * phase / 4294967296.0);
        const long step = std::lround(32 * std::pow(sine, 4));
        assert_int_equal(breath_step(phase), step);
        for (std::size_t i = 0; i < rest.size(); ++i)
            for (int k = 0; k < 3; ++k)
                assert_int_equal(moved[0].vertices_um[i][k],
                                 rest[i][k] + std::lround(static_cast<double>(way[i][k] * step) / 32));
    }
    assert_int_equal(breath_step(0), 0);
    assert_int_equal(breath_step(inhaled), breath_steps);
}

int main()
{
    cmocka_set_message_output(CM_OUTPUT_TAP);
    const CMUnitTest tests[] = {
        cmocka_unit_test(body_file_reads_back_as_written),
        cmocka_unit_test(missing_file_is_named),
        cmocka_unit_test(damaged_file_is_refused_and_leaves_the_old_bodies),
        cmocka_unit_test(bodies_are_read_with_the_scene_they_were_baked_with_alone),
        cmocka_unit_test(a_body_breathes_in_steps_of_its_displacement),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
