// Compares ray casting through voxels with computed chords, and with the X-ray picture of the same body as a
// mesh. Also tests that every version of the innermost loop gives the same sums, that kept views stay equal,
// and that damaged files are refused.
#include "host/xray/attenuation.hpp"
#include "host/xray/detector.hpp"
#include "host/xray/tests/voxel_shapes.hpp"
#include "host/xray/tests/xray_room.hpp"
#include "host/xray/volume/volume_paths.hpp"
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <span>
#include <unistd.h>

using namespace crn;
using Eigen::Vector3d;

namespace
{

constexpr std::array<double, knot_count> knots = {800, 900, 1000, 1130};

struct Look {
    double primary_deg, secondary_deg;
};
constexpr Look looks[] = {{0, 0}, {90, 0}, {-90, 0}, {30, -30}, {-47, 20}, {5, 50}, {110, -40}};

View view_of(const Look &look, int size, double field_m = 0.25)
{
    CArm carm;
    carm.primary_deg = look.primary_deg;
    carm.secondary_deg = look.secondary_deg;
    carm.isocentre_m = {0.004, -0.003, 0.002};
    carm.field_m = field_m;
    return make_view(carm, size);
}

RaySums cast(const RayCaster &caster, const View &view, int threads = 2)
{
    RayGrid grid;
    grid.columns = grid.rows = view.size;
    RaySums sums;
    caster.cast(view, grid, threads, sums);
    return sums;
}

struct Error {
    double mean_mm = 0.0, most_mm = 0.0;
};

// Compares the sums with chord(source, direction) over all views.
template <class Chord>
Error error_of(const RayCaster &caster, const Chord &chord, std::span<const Look> seen = looks,
               double field_m = 0.25)
{
    Error error;
    double count = 0.0;
    for (const Look &look : seen) {
        const View view = view_of(look, 128, field_m);
        const RaySums sums = cast(caster, view);
        for (int y = 0; y < view.size; ++y)
            for (int x = 0; x < view.size; ++x) {
                const double expected_mm = chord(view.source_m * 1e3, pixel_ray(view, x, y));
                const double off_mm =
                    std::fabs(static_cast<double>(sums.all_mm[y * view.size + x]) - expected_mm);
                if (expected_mm <= 0.0 && off_mm == 0.0) continue;
                error.mean_mm += off_mm;
                error.most_mm = std::max(error.most_mm, off_mm);
                count += 1.0;
            }
    }
    error.mean_mm /= count;
    std::printf("# error of %.0f chords: mean %.4f mm, most %.3f mm\n", count, error.mean_mm, error.most_mm);
    return error;
}

// Returns the length of a ray in a box.
double box_chord(const Vector3d &low, const Vector3d &high, const Vector3d &source_mm, const Vector3d &along)
{
    double enter = -1e9, leave = 1e9;
    for (int axis = 0; axis < 3; ++axis) {
        const double a = (low[axis] - source_mm[axis]) / along[axis],
                     b = (high[axis] - source_mm[axis]) / along[axis];
        enter = std::max(enter, std::min(a, b));
        leave = std::min(leave, std::max(a, b));
    }
    return std::max(leave - enter, 0.0);
}

double relative(Material material)
{
    const float *row = attenuation_per_cm[static_cast<int>(material)];
    return (static_cast<double>(row[54]) + static_cast<double>(row[55])) / 2.0 / 0.19288; // 70 keV, water
}

// A ball of fat with soft tissue, a lung and a bone inside, once as meshes and once as voxels.
Bodies layered_meshes()
{
    return {{sphere_body("fat", "fat", -1, {0, 0, 0}, 0.090, 60),
             sphere_body("organs", "tissue", 0, {0, 0, 0}, 0.075, 60),
             sphere_body("lung", "lung", 1, {0.03, 0.01, 0}, 0.030, 40),
             sphere_body("bone", "bone", 1, {-0.03, 0, -0.02}, 0.020, 40)}};
}

// The volume is made once.
const Bodies &layered_voxels()
{
    static const Bodies bodies = [] {
        CtVolume volume = air_volume({200, 200, 200}, {0.98, 0.98, 0.98});
        fill_sphere(volume, 1e3 * relative(Material::adipose), {0, 0, 0}, 90);
        fill_sphere(volume, 1e3 * relative(Material::soft_tissue), {0, 0, 0}, 75);
        fill_sphere(volume, 1e3 * relative(Material::lung), {30, 10, 0}, 30);
        fill_sphere(volume, 1e3 * relative(Material::bone_cortical), {-30, 0, -20}, 20);
        return Bodies{{}, {}, {}, std::make_shared<CtVolume>(std::move(volume))};
    }();
    return bodies;
}

std::vector<float> transmissions(const Room &room, const BeamTable &beam, int size)
{
    std::array<std::vector<std::int32_t>, material_count> paths;
    for (int m = 0; m < material_count; ++m) paths[m] = room.xray->body_path_q10mm(static_cast<Material>(m));
    std::vector<float> share(static_cast<std::size_t>(size) * size);
    for (int row = 0; row < size; ++row) {
        std::array<const std::int32_t *, material_count> lines{};
        for (int m = 0; m < material_count; ++m)
            if (!paths[m].empty()) lines[m] = paths[m].data() + row * size;
        transmission_row(beam, lines, size, share.data() + row * size);
    }
    return share;
}

} // namespace

static void a_sphere_of_voxels_has_the_chords_of_a_sphere(void **)
{
    // A voxel on the surface holds the share of the sphere in it. The rest of the error is the voxels' own:
    // trilinear interpolation spreads the surface over two voxels of 1 mm.
    CtVolume volume = air_volume({140, 130, 120}, {1.0, 1.0, 1.0});
    const Vector3d centre_mm(3.3, -2.1, 1.7);
    fill_sphere(volume, 1000, centre_mm, 50);
    const RayCaster caster(std::make_shared<CtVolume>(std::move(volume)), knots);
    const Error error = error_of(caster, [&](const Vector3d &source_mm, const Vector3d &along) {
        const Vector3d to = centre_mm - source_mm;
        const double square = 2500.0 - (to - along * to.dot(along)).squaredNorm();
        return square > 0.0 ? 2.0 * std::sqrt(square) : 0.0;
    });
    assert_true(error.mean_mm < 0.5); // measured: 0.19
}

static void a_box_of_long_voxels_has_the_chords_of_a_box(void **)
{
    // The voxels are longer from foot to head, as those of a scanner.
    CtVolume volume = air_volume({150, 50, 150}, {0.7, 2.5, 0.7});
    const Vector3d low(-40.2, -45.0, -30.4), high(35.3, 48.0, 42.7);
    fill_box(volume, 1000, low, high);
    const RayCaster caster(std::make_shared<CtVolume>(std::move(volume)), knots);
    const Error error = error_of(caster, [&](const Vector3d &source_mm, const Vector3d &along) {
        return box_chord(low, high, source_mm, along);
    });
    assert_true(error.mean_mm < 0.6); // measured: 0.20
}

static void a_coronal_scan_seen_a_little_obliquely_has_the_chords_of_a_box(void **)
{
    // The slices lie 10 mm apart from back to front. At LAO 8 the central ray makes more steps along x than
    // along z, but the rays at the picture's right edge run along planes of constant x.
    CtVolume volume = air_volume({200, 60, 16}, {1.0, 4.0, 10.0});
    const Vector3d low(-90.0, -100.0, -60.0), high(90.0, 100.0, 60.0);
    fill_box(volume, 1000, low, high);
    const RayCaster caster(std::make_shared<CtVolume>(std::move(volume)), knots);
    const Look seen[] = {{8, 0}, {-8, 0}};
    const Error error = error_of(
        caster,
        [&](const Vector3d &source_mm, const Vector3d &along) {
            return box_chord(low, high, source_mm, along);
        },
        seen, 0.42);
    assert_true(error.mean_mm < 1.0); // measured: 0.34
}

static void every_loop_and_number_of_threads_gives_equal_sums(void **)
{
    // Noise in all voxels, and views that reach beyond the volume and see it from 0.3 m to the side. 169
    // planes fill a memory page of 2 MB nearly to its end, so the sanitizers see a load behind the last
    // plane.
    CtVolume volume = air_volume({64, 169, 64}, {2.9, 1.9, 2.5});
    std::uint32_t state = 1;
    for (std::uint16_t &value : volume.permille) {
        state = state * 1664525u + 1013904223u;
        value = static_cast<std::uint16_t>(state >> 19);
    }
    RayCaster plain(std::make_shared<CtVolume>(volume), knots);
    const RayCaster fast(std::make_shared<CtVolume>(std::move(volume)), knots);
    plain.use_plain_loop();
    for (const Look &look : looks)
        for (double field_m : {0.10, 0.48}) {
            const View view = view_of(look, 64, field_m);
            const RaySums a = cast(plain, view, 1), b = cast(fast, view, 3);
            assert_true(a.all_mm == b.all_mm);
            for (int knot = 0; knot < knot_count; ++knot) assert_true(a.over_mm[knot] == b.over_mm[knot]);
        }
}

static void a_layered_body_has_the_transmission_of_its_meshes(void **)
{
    Room meshes(layered_meshes()), voxels(layered_voxels());
    XraySettings settings = fixed(80, 100, 5);
    settings.size = 256;
    const BeamTable beam = make_beam_table(80, 0.2);
    double sum = 0.0, count = 0.0;
    for (const Look &look : {looks[0], looks[1], looks[3]}) {
        settings.carm.primary_deg = look.primary_deg;
        settings.carm.secondary_deg = look.secondary_deg;
        meshes.picture(settings);
        voxels.picture(settings);
        const std::vector<float> expected = transmissions(meshes, beam, 256),
                                 seen = transmissions(voxels, beam, 256);
        for (std::size_t i = 0; i < seen.size(); ++i) {
            if (expected[i] > 0.97f) continue;
            sum += std::fabs(static_cast<double>(seen[i] / expected[i]) - 1.0);
            count += 1.0;
        }
    }
    std::printf("# transmission, voxels against meshes: mean difference %.3f %%\n", 100.0 * sum / count);
    assert_true(count > 10000);
    assert_true(sum / count < 0.015); // measured: 0.0053
    assert_string_equal(std::string(voxels.xray->back_end()).c_str(), "ct");
}

static void a_kept_view_is_not_cast_again_and_a_guidewire_lies_over_it(void **)
{
    Room room(layered_voxels());
    XraySettings settings = fixed(80, 100, 5);
    settings.size = 128;
    const XrayPicture first = room.picture(settings), second = room.picture(settings);
    assert_true(room.xray->last_render_used_cache());
    assert_true(first.raw == second.raw);
    const SweptCurve wire{Material::steel, {{{-0.05, 0.0, 0.05}, 0.0005}, {{0.05, 0.0, 0.05}, 0.0005}}};
    const WireFrame no_tools;
    const XrayFrame frame{{}, no_tools, {&wire, 1}};
    XrayPicture with_wire;
    room.xray->render(settings, frame, 7, nullptr, with_wire);
    assert_true(room.xray->last_render_used_cache());
    const std::vector<std::int32_t> steel = room.xray->instrument_path_q10mm(Material::steel);
    double bare = 0.0, covered = 0.0;
    for (std::size_t i = 0; i < steel.size(); ++i) {
        if (steel[i] < 128) continue; // an eighth of a millimetre
        bare += first.raw[i];
        covered += with_wire.raw[i];
    }
    assert_true(bare > 0.0);
    std::printf("# behind the guidewire: %.3f of the signal\n", covered / bare);
    assert_true(covered < 0.97 * bare);
}

static void fewer_rays_than_pixels_give_nearly_the_same_lengths(void **)
{
    // At 512 pixels in a field of 0.2 m, the pixels are three times as fine as the voxels.
    const Bodies &bodies = layered_voxels();
    const auto caster = std::make_shared<RayCaster>(bodies.ct, CtMixture().knots_permille());
    const View view = view_of(looks[3], 512, 0.20);
    assert_true(grid_for(view, *bodies.ct).step_px > 3.0);
    BodyMeshes meshes;
    append_ct(meshes);
    VolumePaths paths(caster, CtMixture(), meshes, 2);
    PathPictures pictures;
    for (const MeshChannel &channel : meshes.channels) pictures[channel.own].assign(512 * 512, 0);
    const std::uint8_t is_drawn[] = {1};
    std::string error;
    assert_true(paths.draw(view, is_drawn, {0, 0, 512, 512}, PathForm::ray_lengths, pictures, error));
    const RaySums all = cast(*caster, view);
    const auto &bone = pictures[static_cast<int>(Material::bone_cortical)];
    double sum = 0.0, count = 0.0;
    for (std::size_t i = 0; i < bone.size(); ++i) {
        const double expected_mm =
            static_cast<double>(all.over_mm[3][i]) / (CtMixture().bone - CtMixture().bone_begins);
        if (expected_mm < 1.0) continue;
        sum += std::fabs(bone[i] / 1024.0 - expected_mm);
        count += 1.0;
    }
    std::printf("# bone, interpolated between rays: mean error %.4f mm over %.0f pixels\n", sum / count,
                count);
    assert_true(sum / count < 0.2); // measured: 0.08
}

static void a_volume_reads_back_as_written_and_a_damaged_one_is_refused(void **)
{
    namespace fs = std::filesystem;
    const std::string path =
        (fs::temp_directory_path() / ("crn-" + std::to_string(getpid()) + ".ct")).string();
    CtVolume volume = air_volume({8, 9, 10}, {0.7, 2.5, 0.7});
    fill_sphere(volume, 1040, {0, 0, 0}, 3);
    write_ct_volume(path, volume);
    CtVolume read;
    std::string error;
    assert_true(read_ct_volume(path, read, error));
    assert_true(read.size == volume.size && read.spacing_mm == volume.spacing_mm &&
                read.first_mm == volume.first_mm);
    assert_true(read.permille == volume.permille);
    for (const std::streamoff at : {3, 12, 70, 500}) {
        write_ct_volume(path, volume);
        std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
        file.seekp(at);
        file.put('\x55');
        file.close();
        assert_false(read_ct_volume(path, read, error));
        assert_non_null(std::strstr(error.c_str(), path.c_str()));
    }
    write_ct_volume(path, volume);
    fs::resize_file(path, fs::file_size(path) - 1);
    assert_false(read_ct_volume(path, read, error));
    fs::remove(path);
}

// The checksums of these files are right.
static void a_volume_beyond_the_limits_is_refused(void **)
{
    namespace fs = std::filesystem;
    const std::string path =
        (fs::temp_directory_path() / ("crn-limits-" + std::to_string(getpid()) + ".ct")).string();
    const CtVolume good = air_volume({8, 9, 10}, {0.7, 2.5, 0.7});
    const auto is_refused = [&](const CtVolume &volume, const char *cause) {
        write_ct_volume(path, volume);
        CtVolume read;
        std::string error;
        assert_false(read_ct_volume(path, read, error));
        if (!std::strstr(error.c_str(), cause)) fail_msg("no '%s' in: %s", cause, error.c_str());
        assert_true(read.permille.empty());
    };
    CtVolume volume = good;
    volume.size[1] = ct_size_max + 1;
    is_refused(volume, "voxels along y; 2 to 1024");
    volume = good;
    volume.size = {1024, 1024, 1024};
    volume.spacing_mm.setConstant(0.5);
    is_refused(volume, "more than 536870912");
    volume = good;
    volume.size[2] = 9;
    is_refused(volume, "not as long as its head states");
    volume = good;
    volume.spacing_mm.z() = std::nan("");
    is_refused(volume, "mm along z; 0.01 to 10");
    volume = good;
    volume.first_mm.x() = 2000.0;
    is_refused(volume, "farther than 2 m from the origin along x");
    volume = good;
    volume.permille.back() = ct_permille_max + 1;
    is_refused(volume, "brighter than 7191 HU");
    fs::remove(path);
}

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_sphere_of_voxels_has_the_chords_of_a_sphere),
        cmocka_unit_test(a_box_of_long_voxels_has_the_chords_of_a_box),
        cmocka_unit_test(a_coronal_scan_seen_a_little_obliquely_has_the_chords_of_a_box),
        cmocka_unit_test(every_loop_and_number_of_threads_gives_equal_sums),
        cmocka_unit_test(a_layered_body_has_the_transmission_of_its_meshes),
        cmocka_unit_test(a_kept_view_is_not_cast_again_and_a_guidewire_lies_over_it),
        cmocka_unit_test(fewer_rays_than_pixels_give_nearly_the_same_lengths),
        cmocka_unit_test(a_volume_reads_back_as_written_and_a_damaged_one_is_refused),
        cmocka_unit_test(a_volume_beyond_the_limits_is_refused),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
