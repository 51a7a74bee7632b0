// Compares path lengths from OpenGL with those of the rasteriser, in both kinds of OpenGL context that need
// no window. The test also covers a library, a function or an OpenGL context that is missing or has been
// lost.
//
// Tolerances. The tolerances of the comparison between OpenGL and the rasteriser have the following reasons.
// Both OpenGL and the rasteriser move the corners of a triangle to a grid, and then cover each pixel whose
// centre lies in the triangle. In the rasteriser the grid of corners has a spacing of 1/256 pixel; in OpenGL
// the driver chooses the spacing (llvmpipe uses 1/256 too, with its own rounding). OpenGL may cover a pixel
// at an edge that the rasteriser does not cover, or the reverse. Away from edges, the path length changes by
// less than 2 mm between neighbouring pixels, so a shift by 1/128 pixel changes it by 0.016 mm. The sums of
// OpenGL are floating-point numbers around 100 mm, each exact to 0.00001 mm, and the rasteriser rounds each
// face to 1/1024 mm. The tolerance for path lengths inside bodies is therefore 0.05 mm, and 0.002 mm on
// average; some of the pixels at edges may differ by more.
#include "firmware/tests/reference/long_run.h"
#include "host/xray/gl/gl_paths.hpp"
#include "host/xray/paths/raster_paths.hpp"
#include "host/xray/tests/xray_shapes.hpp"
#include "host/xray/xray.hpp"
#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <dlfcn.h>
#include <fstream>
#include <link.h>
#include <thread>
#include <unistd.h>
extern "C" {
#include <cmocka.h>
}

// Mesa and LLVM never free the memory that they allocate at start-up. The test suppresses leak reports only
// for memory that Mesa and LLVM allocated.
extern "C" const char *__lsan_default_suppressions();
extern "C" const char *__lsan_default_suppressions()
{
    return "leak:libLLVM\nleak:swrast_dri\nleak:libgallium\nleak:libOSMesa\nleak:libEGL_mesa\nleak:libglapi\n"
           "leak:libGLdispatch\n";
}

using namespace crn;

namespace
{

constexpr double q10_mm = 1.0 / 1024.0;

void turn(Body &body, const Eigen::Vector3d &centre_m)
{
    const View turned = make_view({33.0, 21.0, {0, 0, 0}, 1.05, 0.75, 0.32}, 64);
    for (Eigen::Vector3i &vertex : body.vertices_um) {
        const Eigen::Vector3d at = vertex.cast<double>() * 1e-6;
        vertex = to_um(turned.right * at.x() + turned.up * at.y() + turned.forward * at.z() + centre_m);
    }
}

// Makes bodies of eight materials, nested three levels deep; one is tilted, and one is hidden behind another.
Bodies nested_bodies()
{
    Bodies bodies;
    auto &list = bodies.bodies;
    list.push_back(sphere_body("trunk", "soft_tissue", -1, {0, 0, 0}, 0.09, 32));
    list.push_back(box_body("block", "bone_cortical", 0, {-.03, -.02, -.025}, {.03, .02, .025}));
    turn(list.back(), {0.004, 0.002, 0.0});
    list.push_back(sphere_body("marrow", "bone_spongy", 1, {0.004, 0.002, 0.0}, 0.015, 24));
    list.push_back(sphere_body("left lung", "lung", 0, {0.055, 0.0, 0.01}, 0.02, 20));
    list.push_back(sphere_body("right lung", "lung", 0, {-0.055, 0.0, 0.01}, 0.02, 20));
    list.push_back(sphere_body("heart", "muscle", 0, {0.0, 0.06, 0.02}, 0.022, 24));
    list.push_back(sphere_body("ventricle", "blood", 5, {0.002, 0.06, 0.02}, 0.014, 20));
    list.push_back(box_body("pad", "adipose", -1, {-.05, -.12, -.04}, {.05, -.1, .04}));
    list.push_back(box_body("gas", "air", 0, {-.01, -.06, -.02}, {.01, -.04, .0}));
    return bodies;
}

BodyMeshes meshes_of(const Bodies &bodies)
{
    BodyMeshes meshes;
    auto material = [&](int body) {
        return static_cast<int>(*material_from_name(bodies.bodies[body].material));
    };
    for (std::size_t i = 0; i < bodies.bodies.size(); ++i) {
        const int parent = bodies.bodies[i].parent;
        append_body(meshes, bodies.bodies[i], material(static_cast<int>(i)),
                    parent < 0 ? -1 : material(parent));
    }
    return meshes;
}

PathPictures pictures_for(const BodyMeshes &meshes, int size, std::int32_t value = 0)
{
    PathPictures pictures;
    for (const MeshChannel &channel : meshes.channels)
        for (int material : {channel.own, channel.parent})
            if (material >= 0) pictures[material].assign(static_cast<std::size_t>(size) * size, value);
    return pictures;
}

GlOpener opener(GlLibrary library)
{
    return [library] { return open_headless(library); };
}

void draw(BodyPaths &paths, const View &view, PathPictures &pictures, std::size_t bodies)
{
    const std::vector<std::uint8_t> all(bodies, 1);
    std::string error;
    if (!paths.draw(view, all, {0, 0, view.size, view.size}, PathForm::ray_lengths, pictures, error))
        fail_msg("%s", error.c_str());
}

struct Difference {
    int inner = 0, inner_off = 0, edge = 0, edge_off = 0;
    double inner_sum_mm = 0.0;
};

// A pixel counts as inside a body if its path length differs from those of all eight neighbours by less than
// 2 mm, and none of the nine path lengths is 0.
void compare_material(const std::vector<std::int32_t> &expected, const std::vector<std::int32_t> &got,
                      int size, Difference &difference)
{
    for (int y = 1; y + 1 < size; ++y)
        for (int x = 1; x + 1 < size; ++x) {
            std::int32_t low = INT32_MAX, high = 0;
            for (int j = -1; j <= 1; ++j)
                for (int i = -1; i <= 1; ++i) {
                    low = std::min(low, expected[(y + j) * size + x + i]);
                    high = std::max(high, expected[(y + j) * size + x + i]);
                }
            const int at = y * size + x;
            const double off_mm = std::abs(got[at] - expected[at]) * q10_mm;
            if (low > 0 && high - low <= 2048) {
                ++difference.inner;
                difference.inner_sum_mm += off_mm;
                difference.inner_off += off_mm > 0.05;
            } else if (high > 0 || got[at] > 0) {
                ++difference.edge;
                difference.edge_off += off_mm > 0.5;
            }
        }
}

void assert_same(const PathPictures &expected, const PathPictures &got, int size, const char *what)
{
    Difference difference;
    for (int m = 0; m < material_count; ++m) {
        assert_int_equal(expected[m].size(), got[m].size());
        if (!expected[m].empty()) compare_material(expected[m], got[m], size, difference);
    }
    const double mean_mm = difference.inner_sum_mm / std::max(difference.inner, 1);
    std::printf(
        "# %s: inside %d pixels, mean %.5f mm, %d off by more than .05 mm; edges %d pixels, %d off by more "
        "than .5 mm\n",
        what, difference.inner, mean_mm, difference.inner_off, difference.edge, difference.edge_off);
    assert_true(difference.inner > size * size / 100);
    assert_true(mean_mm < 0.002);
    assert_true(difference.inner_off * 20000 <= difference.inner);
    assert_true(difference.edge_off * 1000 <= difference.edge);
}

struct NamedView {
    const char *name;
    CArm carm;
    int size;
};

const NamedView views[] = {
    {"AP", {0, 0, {0, 0, 0}, 1.05, 0.75, 0.32}, 256},
    {"LAO 45 CAU 30", {45, -30, {0.01, 0.02, -0.03}, 1.05, 0.75, 0.32}, 256},
    {"lateral, smallest field", {90, 0, {0, 0, 0}, 1.2, 0.75, 0.15}, 512},
    {"RAO 30 CRA 35, largest field", {-30, 35, {0, 0, 0}, 1.05, 0.75, 0.42}, 256},
    {"block out of the middle", {10, 5, {0.08, 0.06, 0.0}, 0.95, 0.72, 0.2}, 320},
    {"source 10 mm from the trunk", {20, 10, {0.3, 0.2, 0.27}, 1.05, 0.75, 0.2}, 256},
};

// In the last view of the list, the source is 10 mm in front of the trunk.
CArm placed(const NamedView &of)
{
    CArm carm = of.carm;
    if (std::strncmp(of.name, "source", 6) != 0) return carm;
    carm.isocentre_m.setZero();
    const View view = make_view(carm, of.size);
    carm.isocentre_m = view.forward * (carm.source_isocentre_m - 0.1);
    return carm;
}

void views_agree(GlLibrary library)
{
    const Bodies bodies = nested_bodies();
    const BodyMeshes meshes = meshes_of(bodies);
    GlPaths opengl(meshes, opener(library), 2);
    RasterPaths raster(meshes, 2);
    std::printf("# %s, %s, %s\n", opengl.description().origin.c_str(), opengl.description().renderer.c_str(),
                opengl.description().version.c_str());
    for (const NamedView &of : views) {
        const View view = make_view(placed(of), of.size);
        PathPictures expected = pictures_for(meshes, of.size), got = pictures_for(meshes, of.size);
        draw(raster, view, expected, bodies.bodies.size());
        draw(opengl, view, got, bodies.bodies.size());
        assert_same(expected, got, of.size, of.name);
    }
}

void osmesa_gives_the_path_lengths_of_the_rasteriser_in_every_view(void **)
{
    views_agree(GlLibrary::osmesa);
}

void egl_gives_the_path_lengths_of_the_rasteriser_in_every_view(void **)
{
    views_agree(GlLibrary::egl);
}

void two_contexts_of_two_libraries_take_turns(void **)
{
    const Bodies bodies = nested_bodies();
    const BodyMeshes meshes = meshes_of(bodies);
    GlPaths osmesa(meshes, opener(GlLibrary::osmesa), 1), egl(meshes, opener(GlLibrary::egl), 1);
    for (double angle_deg : {0.0, 30.0, 60.0}) {
        const View view = make_view({angle_deg, 0, {0, 0, 0}, 1.05, 0.75, 0.32}, 128);
        PathPictures a = pictures_for(meshes, 128), b = pictures_for(meshes, 128);
        draw(osmesa, view, a, bodies.bodies.size());
        draw(egl, view, b, bodies.bodies.size());
        assert_true(a == b); // one driver, one picture
    }
}

void a_source_inside_a_body_sees_the_way_out_only(void **)
{
    Bodies bodies;
    bodies.bodies.push_back(sphere_body("room", "air", -1, {0, 0, 0}, 0.9, 40));
    bodies.bodies.push_back(sphere_body("trunk", "soft_tissue", 0, {0, 0, 0}, 0.09, 24));
    const BodyMeshes meshes = meshes_of(bodies);
    GlPaths opengl(meshes, opener(GlLibrary::any), 1);
    RasterPaths raster(meshes, 1);
    const View view = make_view({25, 10, {0, 0, 0}, 1.05, 0.75, 0.32}, 256);
    PathPictures expected = pictures_for(meshes, 256), got = pictures_for(meshes, 256);
    draw(raster, view, expected, 2);
    draw(opengl, view, got, 2);
    assert_same(expected, got, 256, "source inside");
    // On the axis, the path in air is the distance from the source, at 750 mm, to the far wall, at 900 mm,
    // minus the path in the trunk.
    const double axis_mm = got[static_cast<int>(Material::air)][128 * 256 + 128] * q10_mm;
    std::printf("# axis %.2f mm, expected 1470 mm\n", axis_mm);
    assert_true(std::fabs(axis_mm - 1470.0) < 1.5); // facets of the large sphere
}

void part_of_a_picture_and_some_bodies_leave_the_rest(void **)
{
    const Bodies bodies = nested_bodies();
    const BodyMeshes meshes = meshes_of(bodies);
    GlPaths opengl(meshes, opener(GlLibrary::any), 2);
    RasterPaths raster(meshes, 2);
    const View view = make_view({15, 0, {0, 0, 0}, 1.05, 0.75, 0.25}, 192);
    std::vector<std::uint8_t> some(bodies.bodies.size(), 0);
    some[1] = some[5] = some[6] = 1; // block, heart and ventricle without the trunk: its sum is below 0
    const PixelRect rect{70, 31, 150, 100};
    PathPictures expected = pictures_for(meshes, 192, 7), got = pictures_for(meshes, 192, 7);
    std::string error;
    assert_true(raster.draw(view, some, rect, PathForm::axis_sums, expected, error));
    assert_true(opengl.draw(view, some, rect, PathForm::axis_sums, got, error));
    const int tissue = static_cast<int>(Material::soft_tissue);
    int below = 0, off = 0, outside_off = 0;
    for (int y = 0; y < 192; ++y)
        for (int x = 0; x < 192; ++x) {
            const bool is_inside = x >= rect.x0 && x < rect.x1 && y >= rect.y0 && y < rect.y1;
            const std::int32_t value = got[tissue][y * 192 + x];
            outside_off += !is_inside && value != 7;
            below += is_inside && value < 0;
            off += is_inside && std::abs(value - expected[tissue][y * 192 + x]) > 512;
        }
    std::printf("# %d sums below 0, %d off by more than .5 mm, %d touched outside\n", below, off,
                outside_off);
    assert_true(below > 1000);
    assert_int_equal(outside_off, 0);
    assert_true(off <= 2);
}

void a_moved_body_is_drawn_where_it_went(void **)
{
    const Bodies bodies = nested_bodies();
    const BodyMeshes meshes = meshes_of(bodies);
    GlPaths opengl(meshes, opener(GlLibrary::any), 2);
    RasterPaths raster(meshes, 2);
    const View view = make_view({0, 0, {0, 0, 0}, 1.05, 0.75, 0.32}, 256);
    PathPictures before = pictures_for(meshes, 256), expected = before, got = before;
    draw(opengl, view, before, bodies.bodies.size());
    std::vector<Eigen::Vector3i> heart = bodies.bodies[5].vertices_um;
    std::vector<Eigen::Vector3i> ventricle = bodies.bodies[6].vertices_um;
    for (auto *vertices : {&heart, &ventricle})
        for (Eigen::Vector3i &vertex : *vertices) vertex += Eigen::Vector3i(4000, -3000, 1000);
    for (BodyPaths *paths : {static_cast<BodyPaths *>(&opengl), static_cast<BodyPaths *>(&raster)}) {
        paths->move(5, heart);
        paths->move(6, ventricle);
    }
    draw(raster, view, expected, bodies.bodies.size());
    draw(opengl, view, got, bodies.bodies.size());
    assert_same(expected, got, 256, "moved");
    assert_false(before == got);
}

void every_size_from_64_to_2048_and_back_is_right(void **)
{
    Bodies bodies;
    bodies.bodies.push_back(sphere_body("trunk", "soft_tissue", -1, {0, 0, 0}, 0.06, 24));
    bodies.bodies.push_back(box_body("block", "bone_cortical", 0, {-.02, -.02, -.02}, {.02, .02, .02}));
    const BodyMeshes meshes = meshes_of(bodies);
    GlPaths opengl(meshes, opener(GlLibrary::any), 2);
    RasterPaths raster(meshes, 2);
    for (int size : {64, 80, 2048, 512, 64, 1024, 496}) {
        const View view = make_view({20, 10, {0, 0, 0}, 1.05, 0.75, 0.15}, size);
        PathPictures expected = pictures_for(meshes, size), got = pictures_for(meshes, size);
        draw(raster, view, expected, 2);
        draw(opengl, view, got, 2);
        assert_same(expected, got, size, std::to_string(size).c_str());
    }
}

// In this test a guidewire passes through the trunk, and the whole signal chain computes the picture. The
// compared pictures differ only in the back end that computes the path lengths of the bodies.
void pictures_with_a_wire_look_the_same_to_the_eye(void **)
{
    XrayScene scene;
    std::string error;
    assert_true(scene.set_bodies(nested_bodies(), error));
    WireFrame wire;
    for (int i = 0; i < 60; ++i) {
        const double s = i / 59.0;
        wire.nodes.push_back({{0.05 - 0.1 * s, 0.03 * s * s, 0.02 * s}, 0.11 * s, 0.00045});
    }
    wire.tick = 5;
    const std::vector<RadiopaqueInstrument> tools = {guidewire_look()};
    XraySettings settings;
    settings.beam.noise = false;
    settings.carm.primary_deg = 20.0;
    XrayPicture expected, got;
    Xray raster(scene, 2);
    Xray opengl(scene, 2, [](const BodyMeshes &meshes, int threads) {
        return std::make_unique<GlPaths>(meshes, opener(GlLibrary::any), threads);
    });
    raster.render(settings, tools, wire, 3, expected);
    opengl.render(settings, tools, wire, 3, got);
    assert_string_equal(std::string(opengl.back_end()).c_str(), "opengl");
    assert_true(raster.instrument_path_q10mm(Material::steel) ==
                opengl.instrument_path_q10mm(Material::steel));
    int off = 0;
    for (std::size_t i = 0; i < got.grey.size(); ++i) off += std::abs(got.grey[i] - expected.grey[i]) > 1;
    std::printf("# %d of %zu grey values differ by more than 1 of 255\n", off, got.grey.size());
    assert_true(off * 1000 <= static_cast<int>(got.grey.size()));
}

void a_missing_library_names_its_package(void **)
{
    const GlFileNames none = {{"libOSMesa-missing.so.1"}, {"libEGL-missing.so.1"}};
    try {
        open_headless(GlLibrary::any, none);
        fail_msg("opened libraries that are not there");
    } catch (const GlError &error) {
        std::printf("# %s\n", error.what());
        for (const char *part : {"libosmesa6", "libegl1", "libOSMesa-missing.so.1", "--xray raster"})
            assert_non_null(std::strstr(error.what(), part));
    }
}

void without_osmesa_egl_is_taken_and_named(void **)
{
    const GlFileNames names = {{"libOSMesa-missing.so.1"}, GlFileNames{}.egl};
    const std::unique_ptr<GlContext> context = open_headless(GlLibrary::any, names);
    std::printf("# %s\n", context->origin().c_str());
    assert_non_null(std::strstr(context->origin().c_str(), "EGL"));
}

void a_library_that_is_no_opengl_is_refused(void **)
{
    for (const GlLibrary library : {GlLibrary::osmesa, GlLibrary::egl}) {
        try {
            open_headless(library, {{"libc.so.6"}, {"libc.so.6"}});
            fail_msg("the C library passed for OpenGL");
        } catch (const GlError &error) {
            std::printf("# %s\n", error.what());
            assert_non_null(std::strstr(error.what(), "libc.so.6"));
        }
    }
}

// --- a context that is lost, and drivers that refuse
// ----------------------------------------------------------------------
unsigned no_memory()
{
    return gl::out_of_memory;
}
unsigned incomplete(unsigned)
{
    return 0;
}
void nothing_compiled(unsigned, unsigned, int *value)
{
    *value = 0;
}

// Wraps a real OpenGL context to simulate a fault: either the context is lost when a thread makes it current
// for the n-th time, or one of its functions is replaced.
class Tampered final : public GlContext
{
  public:
    explicit Tampered(int entries_left) : entries_left_(entries_left) {}
    template <class Function> Tampered(const char *name, Function *other) : name_(name)
    {
        std::memcpy(&other_, &other, sizeof other);
    }
    void enter() override
    {
        if (entries_left_-- == 0) throw GlLost("the graphics card was taken out");
        inner_->enter();
    }
    void leave() override { inner_->leave(); }
    GlFunction function(const char *name) const override
    {
        return name_ == name ? other_ : inner_->function(name);
    }
    std::string origin() const override { return "tampered " + inner_->origin(); }

  private:
    std::unique_ptr<GlContext> inner_ = open_headless();
    int entries_left_ = 1 << 20;
    std::string name_;
    GlFunction other_ = nullptr;
};

constexpr int entries_of_a_start = 2; // description, sending the bodies

void a_lost_context_is_made_again_with_everything_in_it(void **)
{
    const Bodies bodies = nested_bodies();
    const BodyMeshes meshes = meshes_of(bodies);
    int opened = 0;
    GlPaths opengl(
        meshes,
        [&]() -> std::unique_ptr<GlContext> {
            if (++opened == 1) return std::make_unique<Tampered>(entries_of_a_start + 1);
            return open_headless();
        },
        2);
    const View view = make_view({0, 0, {0, 0, 0}, 1.05, 0.75, 0.32}, 128);
    PathPictures first = pictures_for(meshes, 128), second = first;
    draw(opengl, view, first, bodies.bodies.size());
    draw(opengl, view, second, bodies.bodies.size());
    assert_int_equal(opened, 2);
    assert_true(first == second);
}

void a_context_that_keeps_going_leaves_the_picture_to_the_rasteriser(void **)
{
    XrayScene scene;
    std::string error;
    assert_true(scene.set_bodies(nested_bodies(), error));
    Xray raster(scene, 1);
    Xray opengl(scene, 1, [](const BodyMeshes &meshes, int threads) {
        return std::make_unique<GlPaths>(
            meshes, [] { return std::make_unique<Tampered>(entries_of_a_start); }, threads);
    });
    XrayPicture expected, got;
    raster.render({}, {}, {}, 1, expected);
    opengl.render({}, {}, {}, 1, got);
    std::printf("# %s\n", opengl.back_end_error().c_str());
    assert_string_equal(opengl.back_end_error().c_str(), "the graphics card was taken out");
    assert_string_equal(std::string(opengl.back_end()).c_str(), "raster");
    assert_true(expected.grey == got.grey);
}

template <class Function> std::string start_failure(const char *name, Function *other)
{
    const Bodies bodies = nested_bodies();
    const BodyMeshes meshes = meshes_of(bodies);
    try {
        GlPaths opengl(
            meshes, [&] { return std::make_unique<Tampered>(name, other); }, 1);
        std::string error;
        PathPictures pictures = pictures_for(meshes, 64);
        const std::vector<std::uint8_t> all(bodies.bodies.size(), 1);
        const View view = make_view({}, 64);
        if (opengl.draw(view, all, {0, 0, 64, 64}, PathForm::ray_lengths, pictures, error)) return "";
        return error;
    } catch (const GlError &error) {
        return error.what();
    }
}

void a_driver_that_refuses_is_told_from_one_that_draws(void **)
{
    const std::pair<std::string, const char *> cases[] = {
        {start_failure<void()>("glMultiDrawElements", nullptr), "has no glMultiDrawElements"},
        {start_failure("glGetError", no_memory), "out of memory"},
        {start_failure("glCheckFramebufferStatus", incomplete), "pictures of floats"},
        {start_failure("glGetShaderiv", nothing_compiled), "refuses a shader"},
        {start_failure("glGetProgramiv", nothing_compiled), "refuses a program"},
    };
    for (const auto &[message, part] : cases) {
        std::printf("# %s\n", message.c_str());
        assert_non_null(std::strstr(message.c_str(), part));
    }
}

long resident_kB()
{
    long pages = 0, resident = 0;
    std::ifstream("/proc/self/statm") >> pages >> resident;
    return resident * (sysconf(_SC_PAGESIZE) / 1024);
}

void fifty_contexts_come_and_go_without_growing(void **)
{
    const Bodies bodies = nested_bodies();
    const BodyMeshes meshes = meshes_of(bodies);
    const View view = make_view({}, 64);
    long after_ten_kB = 0;
    for (int i = 0; i < 50; ++i) {
        GlPaths opengl(meshes, opener(i % 2 ? GlLibrary::egl : GlLibrary::osmesa), 1);
        PathPictures pictures = pictures_for(meshes, 64);
        draw(opengl, view, pictures, bodies.bodies.size());
        if (i == 9) after_ten_kB = resident_kB();
    }
    const long growth_kB = resident_kB() - after_ten_kB;
    std::printf("# %ld kB more after 50 contexts than after 10\n", growth_kB);
#ifndef REFERENCE_SANITIZED // which delays the reuse of freed blocks
    assert_true(growth_kB < 16384);
#endif
}

void another_thread_may_go_on_with_it(void **)
{
    const Bodies bodies = nested_bodies();
    const BodyMeshes meshes = meshes_of(bodies);
    const View view = make_view({}, 64);
    for (const GlLibrary library : {GlLibrary::osmesa, GlLibrary::egl}) {
        GlPaths opengl(meshes, opener(library), 1);
        PathPictures here = pictures_for(meshes, 64), there = here;
        draw(opengl, view, here, bodies.bodies.size());
        std::thread([&] { draw(opengl, view, there, bodies.bodies.size()); }).join();
        assert_true(here == there);
    }
}

// EGL unloads its driver together with its last context; leaks in the driver could then not be distinguished
// from leaks in our code. The test therefore keeps the EGL driver loaded.
int keep_driver(void **)
{
    std::unique_ptr<GlContext> context;
    try {
        context = open_headless(GlLibrary::egl);
    } catch (const GlError &error) {
        std::printf("# %s\n", error.what());
        return -1;
    }
    std::vector<std::string> names;
    auto take_name = [](dl_phdr_info *module, std::size_t, void *list) {
        static_cast<std::vector<std::string> *>(list)->push_back(module->dlpi_name);
        return 0;
    };
    dl_iterate_phdr(take_name, &names);
    for (const std::string &name : names)
        if (name.find("_dri.so") != std::string::npos || name.find("libgallium") != std::string::npos)
            dlopen(name.c_str(), RTLD_LAZY | RTLD_NOLOAD | RTLD_NODELETE);
    return 0;
}

} // namespace

// LeakSanitizer calls the function below when the program ends. LeakSanitizer's own tracer would crash on the
// threads of Mesa's llvmpipe (clang 14, Mesa 22.3.6), so the test does not search for leaks. The growth of
// memory is limited by another test in this file.
extern "C" int __lsan_is_turned_off()
{
    return 1;
}

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(osmesa_gives_the_path_lengths_of_the_rasteriser_in_every_view),
        cmocka_unit_test(egl_gives_the_path_lengths_of_the_rasteriser_in_every_view),
        cmocka_unit_test(two_contexts_of_two_libraries_take_turns),
        cmocka_unit_test(a_source_inside_a_body_sees_the_way_out_only),
        cmocka_unit_test(part_of_a_picture_and_some_bodies_leave_the_rest),
        cmocka_unit_test(a_moved_body_is_drawn_where_it_went),
        cmocka_unit_test(every_size_from_64_to_2048_and_back_is_right),
        cmocka_unit_test(pictures_with_a_wire_look_the_same_to_the_eye),
        cmocka_unit_test(a_missing_library_names_its_package),
        cmocka_unit_test(without_osmesa_egl_is_taken_and_named),
        cmocka_unit_test(a_library_that_is_no_opengl_is_refused),
        cmocka_unit_test(a_lost_context_is_made_again_with_everything_in_it),
        cmocka_unit_test(a_context_that_keeps_going_leaves_the_picture_to_the_rasteriser),
        cmocka_unit_test(a_driver_that_refuses_is_told_from_one_that_draws),
        cmocka_unit_test(fifty_contexts_come_and_go_without_growing),
        cmocka_unit_test(another_thread_may_go_on_with_it),
    };
    return cmocka_run_group_tests(tests, keep_driver, nullptr);
}
