// Compares path lengths with computed chords in random views, and tests the cases in which rasterisers often
// fail. The difficult cases for rasterisers are very thin triangles, corners at the centres of pixels, a
// source inside a body, and faces behind the source.
#include "host/xray/paths/path_keeper.hpp"
#include "host/xray/paths/raster_paths.hpp"
#include "host/xray/tests/xray_shapes.hpp"
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdio>
extern "C" {
#include <cmocka.h>
}

using namespace crn;
using Eigen::Vector3d;

namespace
{

// Generates random numbers that are the same on every machine.
class Lot
{
  public:
    explicit Lot(std::uint64_t seed) : state_(seed) {}
    double between(double low, double high)
    {
        state_ = state_ * 6364136223846793005ull + 1442695040888963407ull;
        return low + (high - low) * static_cast<double>(state_ >> 11) * 0x1p-53;
    }
    Vector3d point(double reach)
    {
        return {between(-reach, reach), between(-reach, reach), between(-reach, reach)};
    }

  private:
    std::uint64_t state_;
};

CArm any_view(Lot &lot)
{
    CArm carm;
    carm.primary_deg = lot.between(-110.0, 110.0);
    carm.secondary_deg = lot.between(-45.0, 45.0);
    carm.isocentre_m = lot.point(0.03);
    carm.source_detector_m = lot.between(0.9, 1.3);
    carm.field_m = lot.between(0.15, 0.42);
    return clamp_carm(carm);
}

BodyMeshes meshes_of(const std::vector<Body> &bodies, const std::vector<Material> &materials)
{
    BodyMeshes meshes;
    for (std::size_t i = 0; i < bodies.size(); ++i)
        append_body(meshes, bodies[i], static_cast<int>(materials[i]),
                    bodies[i].parent >= 0 ? static_cast<int>(materials[bodies[i].parent]) : -1);
    return meshes;
}

PathPictures draw(const BodyMeshes &meshes, const View &view, PathForm form, int threads = 2)
{
    PathPictures pictures;
    for (const MeshChannel &channel : meshes.channels)
        for (int material : {channel.own, channel.parent})
            if (material >= 0) pictures[material].assign(static_cast<std::size_t>(view.size) * view.size, -7);
    RasterPaths raster(meshes, threads);
    const std::vector<std::uint8_t> all(meshes.vertex_counts.size(), 1);
    std::string error;
    assert_true(raster.draw(view, all, {0, 0, view.size, view.size}, form, pictures, error));
    return pictures;
}

const std::vector<std::int32_t> &of(const PathPictures &pictures, Material material)
{
    return pictures[static_cast<int>(material)];
}

// Returns a random rotation; its columns are the axes of a body.
Eigen::Matrix3d turned(Lot &lot)
{
    Eigen::Quaterniond q(lot.between(-1, 1), lot.between(-1, 1), lot.between(-1, 1), lot.between(0.1, 1));
    q.normalize();
    return q.toRotationMatrix();
}

// Moves a body from its own axes to the position `at`.
Body placed(const std::string &name, const std::vector<Vector3d> &points_m,
            const std::vector<std::array<std::uint32_t, 3>> &triangles, const Eigen::Matrix3d &axes,
            const Vector3d &at)
{
    Body body{name, "bone", -1, {}, triangles};
    for (const Vector3d &point : points_m) body.vertices_um.push_back(to_um(axes * point + at));
    return body;
}

std::vector<std::array<std::uint32_t, 3>> box_triangles()
{
    return box_body("", "bone", -1, {0, 0, 0}, {1, 1, 1}).triangles;
}

std::vector<Vector3d> box_points(const Vector3d &half)
{
    std::vector<Vector3d> points;
    for (int corner = 0; corner < 8; ++corner)
        points.push_back({corner & 1 ? half.x() : -half.x(), corner & 2 ? half.y() : -half.y(),
                          corner & 4 ? half.z() : -half.z()});
    return points;
}

// Makes a cylinder along z, from -half to half, with `sides` flat sides.
Body cylinder_body(double radius, double half, int sides, const Eigen::Matrix3d &axes, const Vector3d &at)
{
    std::vector<Vector3d> points = {{0, 0, -half}, {0, 0, half}};
    std::vector<std::array<std::uint32_t, 3>> triangles;
    for (int i = 0; i < sides; ++i) {
        const double angle = 6.283185307179586 * i / sides;
        points.push_back({radius * std::cos(angle), radius * std::sin(angle), -half});
        points.push_back({radius * std::cos(angle), radius * std::sin(angle), half});
        const std::uint32_t low = 2 + 2 * i, next = 2 + 2 * ((i + 1) % sides);
        triangles.push_back({0, next, low});
        triangles.push_back({1, low + 1, next + 1});
        triangles.push_back({low, next, low + 1});
        triangles.push_back({next, next + 1, low + 1});
    }
    return placed("cylinder", points, triangles, axes, at);
}

double slab_chord(double from, double along, double half, double &enter, double &leave)
{
    const double a = (-half - from) / along, b = (half - from) / along;
    enter = std::max(enter, std::min(a, b));
    leave = std::min(leave, std::max(a, b));
    return std::max(leave - enter, 0.0);
}

double box_chord(const Vector3d &source, const Vector3d &ray, const Vector3d &half)
{
    double enter = 0.0, leave = 1e9;
    for (int axis = 0; axis < 3; ++axis) slab_chord(source[axis], ray[axis], half[axis], enter, leave);
    return std::max(leave - enter, 0.0);
}

double cylinder_chord(const Vector3d &source, const Vector3d &ray, double radius, double half)
{
    const double a = ray.x() * ray.x() + ray.y() * ray.y(), b = source.x() * ray.x() + source.y() * ray.y();
    const double c = source.x() * source.x() + source.y() * source.y() - radius * radius,
                 root = b * b - a * c;
    if (root <= 0.0) return 0.0;
    double enter = (-b - std::sqrt(root)) / a, leave = (-b + std::sqrt(root)) / a;
    return slab_chord(source.z(), ray.z(), half, enter, leave);
}

double sphere_chord(const Vector3d &source, const Vector3d &ray, double radius)
{
    const double along = source.dot(ray), square = along * along - source.squaredNorm() + radius * radius;
    return square > 0.0 ? 2.0 * std::sqrt(square) : 0.0;
}

// Returns the mean error in mm over the pixels whose chord is not 0; the chord is computed in the body's own
// axes.
template <class Chord>
double mean_error_mm(const Body &body, const Eigen::Matrix3d &axes, const Vector3d &at, const View &view,
                     Chord chord)
{
    const PathPictures pictures =
        draw(meshes_of({body}, {Material::bone_cortical}), view, PathForm::ray_lengths);
    const auto &path = of(pictures, Material::bone_cortical);
    const Vector3d source = axes.transpose() * (view.source_m - at);
    double sum = 0.0;
    int count = 0;
    for (int y = 0; y < view.size; ++y)
        for (int x = 0; x < view.size; ++x) {
            const double expected_mm =
                1e3 * chord(source, Vector3d(axes.transpose() * pixel_ray(view, x, y)));
            if (expected_mm <= 0.0) continue;
            sum += std::fabs(path[static_cast<std::size_t>(y) * view.size + x] / 1024.0 - expected_mm);
            ++count;
        }
    return sum / std::max(count, 1);
}

// Makes closed tetrahedra with edges from 2 um to 40 mm; some of them are long thin needles.
Body slivers(Lot &lot, int count)
{
    Body body{"slivers", "bone", -1, {}, {}};
    for (int i = 0; i < count; ++i) {
        const auto first = static_cast<std::uint32_t>(body.vertices_um.size());
        const Vector3d at = lot.point(0.05), along = lot.point(0.02), across = lot.point(1e-5),
                       up = lot.point(2e-6);
        for (const Vector3d &point : {at, Vector3d(at + along), Vector3d(at + across), Vector3d(at + up)})
            body.vertices_um.push_back(to_um(point));
        const Eigen::Vector3i *v = body.vertices_um.data() + first;
        const auto volume = [&] {
            const Eigen::Matrix<std::int64_t, 3, 1> a = (v[1] - v[0]).cast<std::int64_t>(),
                                                    b = (v[2] - v[0]).cast<std::int64_t>(),
                                                    c = (v[3] - v[0]).cast<std::int64_t>();
            return a.cross(b).dot(c);
        }();
        const bool is_left = volume > 0;
        auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
            if (is_left) std::swap(b, c);
            body.triangles.push_back({first + a, first + b, first + c});
        };
        add(0, 1, 2), add(0, 2, 3), add(0, 3, 1), add(1, 3, 2);
    }
    return body;
}

// If a face were drawn without the opposite face, its distance from the source would remain in the sum. A
// face is 500 mm or more from the source, and no closed body in this test has such a long path.
void no_pixel_is_unpaired(const BodyMeshes &meshes, const View &view, double largest_mm)
{
    const PathPictures pictures = draw(meshes, view, PathForm::axis_sums);
    for (const auto &picture : pictures)
        for (std::size_t i = 0; i < picture.size(); ++i)
            if (picture[i] < -2048 || picture[i] > largest_mm * 1024.0) {
                std::printf("# pixel %zu, %zu: %.3f mm, at most %.3f\n", i % view.size, i / view.size,
                            picture[i] / 1024.0, largest_mm);
                fail_msg("a path is out of range");
            }
}

} // namespace

// On the sphere the flat facets cause an error of 0.010 mm in the path length. The cylinder has 720 sides,
// whose flatness causes an error of 0.3 um. The corners of the bodies are rounded to 1 um.
static void paths_of_sphere_cylinder_and_tilted_box_are_their_chords(void **)
{
    Lot lot(1);
    double worst_mm[3] = {};
    for (int i = 0; i < 6; ++i) {
        const View view = make_view(any_view(lot), 256);
        const Vector3d at = lot.point(0.02);
        const Eigen::Matrix3d axes = turned(lot);
        const Vector3d half(lot.between(0.01, 0.05), lot.between(0.01, 0.05), lot.between(0.01, 0.05));
        const double errors_mm[3] = {
            mean_error_mm(sphere_body("ball", "bone", -1, at, 0.05, 90), axes, at, view,
                          [](const Vector3d &s, const Vector3d &r) { return sphere_chord(s, r, 0.05); }),
            mean_error_mm(
                cylinder_body(0.03, 0.04, 720, axes, at), axes, at, view,
                [](const Vector3d &s, const Vector3d &r) { return cylinder_chord(s, r, 0.03, 0.04); }),
            mean_error_mm(placed("box", box_points(half), box_triangles(), axes, at), axes, at, view,
                          [&](const Vector3d &s, const Vector3d &r) { return box_chord(s, r, half); })};
        for (int k = 0; k < 3; ++k) worst_mm[k] = std::max(worst_mm[k], errors_mm[k]);
    }
    std::printf("# mean error, worst of 6 views: sphere %.4f, cylinder %.4f, tilted box %.4f mm\n",
                worst_mm[0], worst_mm[1], worst_mm[2]);
    for (double worst : worst_mm) assert_true(worst <= 0.02);
}

static void no_pixel_is_unpaired_over_many_views(void **)
{
    Lot lot(2);
    const BodyMeshes ball =
        meshes_of({sphere_body("ball", "bone", -1, {0, 0, 0}, 0.06, 40)}, {Material::steel});
    const BodyMeshes needles = meshes_of({slivers(lot, 300)}, {Material::steel});
    for (int i = 0; i < 60; ++i) {
        const View view = make_view(any_view(lot), i % 2 ? 512 : 208);
        no_pixel_is_unpaired(ball, view, 121.0);
        no_pixel_is_unpaired(needles, view, 5.0);
    }
}

// In the AP view, the pixel centres in the plane through the isocentre are at (k + 1/2) times 0.25 mm.
static void corners_and_edges_on_the_centres_of_pixels_are_covered_once(void **)
{
    CArm carm;
    carm.source_detector_m = 1.0;
    carm.source_isocentre_m = 0.75;
    carm.field_m = 512 * 0.25e-3 / 0.75;
    carm = clamp_carm(carm);
    const View view = make_view(carm, 512);
    Body grid{"grid", "bone", -1, {}, {}};
    // The body consists of two sheets of squares whose corners are at pixel centres, joined at the rim by the
    // sides of a box.
    const int n = 40;
    for (int sheet = 0; sheet < 2; ++sheet)
        for (int j = 0; j <= n; ++j)
            for (int i = 0; i <= n; ++i)
                grid.vertices_um.push_back(
                    {125 + 250 * (i * 3 - 60), 125 + 250 * (j * 3 - 60), sheet ? 0 : -20000});
    auto at = [&](int sheet, int i, int j) {
        return static_cast<std::uint32_t>((sheet * (n + 1) + j) * (n + 1) + i);
    };
    auto quad = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
        grid.triangles.push_back({a, b, c});
        grid.triangles.push_back({a, c, d});
    };
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            quad(at(1, i, j), at(1, i + 1, j), at(1, i + 1, j + 1), at(1, i, j + 1));
            quad(at(0, i, j), at(0, i, j + 1), at(0, i + 1, j + 1), at(0, i + 1, j));
        }
    for (int i = 0; i < n; ++i) {
        quad(at(0, i, 0), at(0, i + 1, 0), at(1, i + 1, 0), at(1, i, 0));
        quad(at(0, i + 1, n), at(0, i, n), at(1, i, n), at(1, i + 1, n));
        quad(at(0, 0, i + 1), at(0, 0, i), at(1, 0, i), at(1, 0, i + 1));
        quad(at(0, n, i), at(0, n, i + 1), at(1, n, i + 1), at(1, n, i));
    }
    const BodyMeshes meshes = meshes_of({grid}, {Material::bone_cortical});
    no_pixel_is_unpaired(meshes, view, 21.0);
    const PathPictures pictures = draw(meshes, view, PathForm::axis_sums);
    Eigen::Vector2d pixel;
    assert_true(project(view, {0.0, 0.0, 0.0}, pixel));
    for (int y = -50; y < 50; ++y)
        for (int x = -50; x < 50; ++x) {
            const auto where = static_cast<std::size_t>(static_cast<int>(pixel.y()) + y) * 512 +
                               static_cast<std::size_t>(static_cast<int>(pixel.x()) + x);
            assert_in_range(of(pictures, Material::bone_cortical)[where], 20 * 1024 - 4, 20 * 1024 + 4);
        }
}

// The expected length is that of the ray from the source to the face where the ray leaves the body. Those
// parts of the body that are nearer to the source than 1 mm, measured along the axis, are cut off.
static void a_source_inside_a_body_sees_the_way_out_in_every_direction(void **)
{
    Lot lot(3);
    for (int i = 0; i < 6; ++i) {
        const View view = make_view(any_view(lot), 128);
        const Vector3d half(0.3, 0.2, 0.25), at = view.source_m + lot.point(0.1);
        const Eigen::Matrix3d axes = turned(lot);
        const double error_mm =
            mean_error_mm(placed("box", box_points(half), box_triangles(), axes, at), axes, at, view,
                          [&](const Vector3d &s, const Vector3d &r) { return box_chord(s, r, half); });
        std::printf("# mean error %.4f mm\n", error_mm);
        assert_true(error_mm <= 0.02);
    }
}

static void nested_bodies_are_taken_out_of_their_parents_to_any_depth(void **)
{
    const Material materials[] = {Material::adipose,     Material::muscle,  Material::bone_cortical,
                                  Material::bone_spongy, Material::blood,   Material::iohexol_350,
                                  Material::nitinol,     Material::polymer, Material::gold,
                                  Material::soft_tissue};
    std::vector<Body> bodies;
    for (int i = 0; i < 10; ++i) {
        const double half = 0.05 - 0.004 * i;
        bodies.push_back(box_body("shell", "bone", i - 1, {-half, -half, -half}, {half, half, half}));
    }
    const View view = make_view(CArm(), 256);
    const PathPictures pictures =
        draw(meshes_of(bodies, {std::begin(materials), std::end(materials)}), view, PathForm::ray_lengths);
    const std::size_t centre = 128 * 256 + 128;
    for (int i = 0; i < 10; ++i) {
        const double expected_mm = i < 9 ? 8.0 : 2.0 * (50.0 - 36.0);
        const double path_mm = of(pictures, materials[i])[centre] / 1024.0;
        if (std::fabs(path_mm - expected_mm) > 0.005) {
            std::printf("# level %d: %.4f mm, expected %.4f\n", i, path_mm, expected_mm);
            fail_msg("a path differs");
        }
    }
}

static void part_of_a_picture_is_drawn_like_the_whole_and_by_any_number_of_threads(void **)
{
    Lot lot(4);
    const BodyMeshes meshes =
        meshes_of({sphere_body("skin", "bone", -1, {0, 0, 0}, 0.1, 60),
                   box_body("bone", "bone", 0, {-0.03, -0.02, -0.04}, {0.03, 0.05, 0.02})},
                  {Material::soft_tissue, Material::bone_cortical});
    for (int i = 0; i < 4; ++i) {
        const View view = make_view(any_view(lot), 320);
        const PathPictures whole = draw(meshes, view, PathForm::ray_lengths, 1);
        for (int threads : {2, 4, 7})
            assert_true(draw(meshes, view, PathForm::ray_lengths, threads) == whole);
        PathPictures part = whole;
        for (auto &picture : part) std::fill(picture.begin(), picture.end(), -7);
        const PixelRect rect = {37, 101, 290, 205};
        RasterPaths raster(meshes, 2);
        const std::vector<std::uint8_t> all(2, 1);
        std::string error;
        raster.draw(view, all, rect, PathForm::ray_lengths, part, error);
        for (int m = 0; m < material_count; ++m)
            for (std::size_t at = 0; at < whole[m].size(); ++at) {
                const int x = static_cast<int>(at % 320), y = static_cast<int>(at / 320);
                const bool is_inside = x >= rect.x0 && x < rect.x1 && y >= rect.y0 && y < rect.y1;
                assert_int_equal(part[m][at], is_inside ? whole[m][at] : -7);
            }
    }
}

// The program accepts a mesh with a hole, and the error must stay in the pixels behind the hole.
static void an_open_mesh_harms_only_the_pixels_behind_its_hole(void **)
{
    Body ball = sphere_body("ball", "bone", -1, {0, 0, 0}, 0.05, 30);
    const View view = make_view(CArm(), 256);
    const PathPictures closed = draw(meshes_of({ball}, {Material::steel}), view, PathForm::axis_sums);
    ball.triangles.erase(ball.triangles.begin() + 1234);
    const PathPictures open = draw(meshes_of({ball}, {Material::steel}), view, PathForm::axis_sums);
    int harmed = 0;
    for (std::size_t i = 0; i < 256 * 256; ++i)
        harmed += of(open, Material::steel)[i] != of(closed, Material::steel)[i];
    std::printf("# %d pixels\n", harmed);
    assert_in_range(harmed, 1, 12);
    assert_true(draw(meshes_of({Body{"nothing", "bone", -1, {}, {}}}, {Material::steel}), view,
                     PathForm::ray_lengths)[static_cast<int>(Material::steel)] ==
                std::vector<std::int32_t>(256 * 256, 0));
}

// When the heart beats, the picture must be that of a scene made with the moved body, and only the pixels
// around the body may be redrawn.
static void a_moved_body_is_drawn_as_if_the_scene_had_it_there(void **)
{
    Body heart = sphere_body("heart", "muscle", 0, {0.02, 0.0, 0.01}, 0.03, 30);
    const Body skin = box_body("skin", "soft_tissue", -1, {-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1});
    const std::vector<Material> materials = {Material::soft_tissue, Material::muscle};
    const BodyMeshes meshes = meshes_of({skin, heart}, materials);
    PathKeeper keeper(meshes, std::make_unique<RasterPaths>(meshes, 2), 2);
    const WireFrame wire;
    CArm carm;
    carm.primary_deg = 30.0;
    assert_true(keeper.see(carm, 256, {{}, wire}));
    const PathPictures at_rest = keeper.bodies();
    for (int beat = 1; beat <= 3; ++beat) {
        Body moved = heart;
        for (Eigen::Vector3i &v : moved.vertices_um)
            v = Eigen::Vector3i(v.x() * (20 - beat) / 20, v.y() + 1500 * beat, v.z());
        const MovedBody bodies[] = {{1, moved.vertices_um}};
        assert_true(keeper.see(carm, 256, {{}, wire, {}, bodies}));
        const PathPictures expected =
            draw(meshes_of({skin, moved}, materials), keeper.view(), PathForm::ray_lengths);
        assert_true(keeper.bodies() == expected);
        if (beat > 1) assert_in_range(keeper.changed().x1 - keeper.changed().x0, 60, 110);
        assert_false(keeper.see(carm, 256, {{}, wire, {}, bodies}));
    }
    assert_true(keeper.see(carm, 256, {{}, wire}));
    assert_true(keeper.bodies() == at_rest);
    // The function must ignore entries for bodies that do not exist, entries with a wrong number of vertices,
    // and entries with vertices too far away.
    std::vector<Eigen::Vector3i> far(heart.vertices_um.size(), Eigen::Vector3i(3'000'000, 0, 0));
    const std::vector<Eigen::Vector3i> few(3, Eigen::Vector3i(0, 0, 0));
    const MovedBody wrong[] = {{7, heart.vertices_um}, {-1, heart.vertices_um}, {1, few}, {1, far}};
    assert_false(keeper.see(carm, 256, {{}, wire, {}, wrong}));
    assert_true(keeper.bodies() == at_rest);
}

// Bodies that breathe: a lung with a vessel in it, and a liver beside it, both in the trunk, with a spine
// that stays. The bodies move by `shift_um` along the patient, and the lung and its vessel grow, too.
std::vector<Body> breathing_trunk(int shift_um)
{
    std::vector<Body> bodies = {box_body("trunk", "", -1, {-0.12, -0.3, -0.09}, {0.12, 0.3, 0.09}),
                                box_body("spine", "", 0, {-0.015, -0.28, -0.085}, {0.015, 0.28, -0.06}),
                                sphere_body("lung", "", 0, {0.05, 0.06, 0.01}, 0.045, 20),
                                sphere_body("vessel", "", 2, {0.05, 0.06, 0.015}, 0.012, 8),
                                sphere_body("liver", "", 0, {-0.04, 0.0, 0.0}, 0.05, 20)};
    for (int body : {2, 3, 4})
        for (Eigen::Vector3i &at : bodies[body].vertices_um) {
            if (body != 4) at.z() += (at.z() - 10'000) * (shift_um / 1000) / 400;
            at.y() += shift_um;
        }
    return bodies;
}

// The steps are small, as in a breath, and as large as several tiles of the rasteriser; bodies leave the
// picture and come back, and start and end to move. Between them the C-arm turns, the table moves, and the
// size changes to one that is not a multiple of a tile. Every pixel is compared with a drawing of the whole
// scene.
static void bodies_that_breathe_are_drawn_as_a_new_scene_in_every_view(void **)
{
    const std::vector<Material> materials = {Material::soft_tissue, Material::bone_cortical, Material::lung,
                                             Material::blood, Material::muscle};
    const std::vector<Body> at_rest = breathing_trunk(0);
    const BodyMeshes meshes = meshes_of(at_rest, materials);
    PathKeeper keeper(meshes, std::make_unique<RasterPaths>(meshes, 2), 2);
    const WireFrame wire;
    Lot lot(5);
    const int shifts_um[] = {400, 800, 1200, -90'000, 90'000, 0, 400'000, -300'000, 5'000, 5'400};
    for (int look = 0; look < 6; ++look) {
        CArm carm = any_view(lot);
        if (look == 3) carm.isocentre_m.y() += 0.35; // only the lung's upper part, or nothing that moves
        const int size = look % 2 == 0 ? 256 : 336;
        for (int step = 0; step < 10; ++step) {
            std::vector<Body> moved = breathing_trunk(shifts_um[step]);
            std::vector<MovedBody> list;
            for (int body : {2, 3, 4})
                if (step != 6 || body != 4) list.push_back({body, moved[body].vertices_um});
            if (step == 6) moved[4] = at_rest[4]; // the liver stays in this frame
            if (look == 4 && step == 5) carm.isocentre_m.x() += 0.02;
            keeper.see(carm, size, {{}, wire, {}, list});
            const PathPictures expected =
                draw(meshes_of(moved, materials), keeper.view(), PathForm::ray_lengths);
            for (int m = 0; m < material_count; ++m)
                if (keeper.bodies()[m] != expected[m])
                    fail_msg("view %d, step %d, material %d", look, step, m);
        }
    }
}

int main()
{
    cmocka_set_message_output(CM_OUTPUT_TAP);
    const CMUnitTest tests[] = {
        cmocka_unit_test(paths_of_sphere_cylinder_and_tilted_box_are_their_chords),
        cmocka_unit_test(no_pixel_is_unpaired_over_many_views),
        cmocka_unit_test(corners_and_edges_on_the_centres_of_pixels_are_covered_once),
        cmocka_unit_test(a_source_inside_a_body_sees_the_way_out_in_every_direction),
        cmocka_unit_test(nested_bodies_are_taken_out_of_their_parents_to_any_depth),
        cmocka_unit_test(part_of_a_picture_is_drawn_like_the_whole_and_by_any_number_of_threads),
        cmocka_unit_test(an_open_mesh_harms_only_the_pixels_behind_its_hole),
        cmocka_unit_test(a_moved_body_is_drawn_as_if_the_scene_had_it_there),
        cmocka_unit_test(bodies_that_breathe_are_drawn_as_a_new_scene_in_every_view),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
