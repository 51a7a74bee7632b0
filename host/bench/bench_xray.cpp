// Measures how long the computation of an X-ray picture takes (docs/bench.md and docs/xray.md). The simulated
// patient is out/aorta.bodies, which `make run` makes; if that file is missing, the program makes a model
// itself. The two models of a patient have at least 300,000 triangles and four materials.
#include "firmware/bench/bench.h"
#include "host/model/breathing_bodies.hpp"
#include "host/xray/chain.hpp"
#include "host/xray/gl/gl_paths.hpp"
#include "host/xray/paths/raster_paths.hpp"
#include "host/xray/tests/xray_shapes.hpp"
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <optional>
#include <string>

using namespace crn;

namespace
{

constexpr std::size_t triangles_min = 300'000;
constexpr int rounds = 12; // the fastest counts, since the machine does other work too
const char *const bodies_file = "out/aorta.bodies";
const char *const heart_name = "heart that beats";

// Lists common views of chest and belly, with the C-arm's angles and the table's position.
struct Look {
    double primary_deg, secondary_deg, y_m;
};
constexpr Look looks[] = {{0, 0, 0.0},  {45, -30, 0.05}, {-30, 0, 0.1},
                          {90, 0, 0.0}, {45, 0, 0.15},   {10, -30, -0.15}};

std::size_t count_triangles(const Bodies &bodies)
{
    std::size_t count = 0;
    for (const Body &body : bodies.bodies) count += body.triangles.size();
    return count;
}

// Makes a model of a trunk with lungs, spine and ribs, which consist of spheres.
Bodies made_here()
{
    Bodies bodies;
    bodies.bodies.push_back(sphere_body("trunk", "soft_tissue", -1, {0, 0, 0}, 0.16, 110));
    bodies.bodies.push_back(sphere_body("left lung", "lung", 0, {0.08, 0, 0}, 0.06, 80));
    bodies.bodies.push_back(sphere_body("right lung", "lung", 0, {-0.08, 0, 0}, 0.06, 80));
    for (int i = 0; i < 12; ++i)
        bodies.bodies.push_back(
            sphere_body("vertebra", "bone_cortical", 0, {0, -0.11 + 0.02 * i, -0.1}, 0.009, 30));
    return bodies;
}

// Replaces the eight materials of the shipped anatomy by four, because docs/xray.md limits the computing time
// for four materials.
const char *one_of_four(const std::string &name)
{
    const Material material = material_from_name(name).value_or(Material::soft_tissue);
    switch (material) {
    case Material::bone_cortical:
    case Material::bone_spongy:
        return "bone_cortical";
    case Material::lung:
    case Material::air:
        return "lung";
    case Material::blood:
        return "blood";
    default:
        return "soft_tissue";
    }
}

struct Scene {
    bool beats = false;    // adds a ball of 28,800 triangles that can move
    bool is_four = false;  // only four materials
    bool breathes = false; // the bodies that breathe move from frame to frame
};

Bodies patient(const Scene &scene)
{
    Bodies bodies;
    std::string error;
    if (!read_bodies(bodies_file, bodies, error)) bodies = made_here();
    for (Body &body : bodies.bodies)
        if (scene.is_four) body.material = one_of_four(body.material);
    if (scene.beats) bodies.bodies.push_back(sphere_body(heart_name, "blood", 0, {0.0, 0.0, 0.02}, 0.03, 60));
    for (int i = 0; count_triangles(bodies) < triangles_min; ++i)
        bodies.bodies.push_back(sphere_body("node", "blood", 0, {0.004 * i - 0.06, -0.05, 0.0}, 0.0018, 20));
    return bodies;
}

// The guidewire goes 700 mm from the groin up the aorta, with a bend and with a node every 2.5 mm; all nodes
// are displaced by `shift_m`.
WireFrame wire_at(double shift_m)
{
    WireFrame wire;
    for (int i = 0; i < 280; ++i) {
        WireNode node;
        const double s = i * 0.0025;
        node.position_m = {0.02 + 0.03 * (s - 0.2) * (s - 0.2) * 10 + shift_m, 0.2 - s, 0.01 * s};
        node.arc_m = s;
        node.radius_m = 0.00045;
        wire.nodes.push_back(node);
    }
    return wire;
}

class Bench
{
  public:
    Bench(int threads, const Scene &scene) : patient_(patient(scene))
    {
        std::string error;
        if (!scene_.set_bodies(patient_, error)) bench_fail(error.c_str());
        while (scene.beats && patient_.bodies[heart_].name != heart_name) ++heart_;
        xray_ = std::make_unique<Xray>(scene_, threads);
        if (scene.breathes) breathing_.emplace(patient_);
        if (scene.breathes && breathing_->is_empty())
            bench_fail("out/aorta.bodies does not breathe: make it anew by `make out/aorta.scene`");
    }
    // After this call the heart beats, and a stent of 400 struts moves with the heart.
    void start_heart()
    {
        moves_ = true;
        for (int k = 0; k < 400; ++k) {
            SweptCurve strut{Material::nitinol, {}};
            for (int i = 0; i <= 12; ++i) {
                const double angle = 0.09 * i + 0.3 * k;
                strut.points.push_back(
                    {{0.0015 * std::cos(angle), 0.00006 * k + 0.0001 * i, 0.03 + 0.0015 * std::sin(angle)},
                     4e-5});
            }
            curves_.push_back(strut);
        }
    }
    // Finds the exposure technique (voltage, current and others) that automatic exposure control chooses in
    // each view, and fixes it, so that all frames have the same exposure.
    void settle(int size)
    {
        for (std::size_t i = 0; i < std::size(looks); ++i) {
            look(i, size);
            settings_.beam.fixed_technique.reset();
            xray_->render(settings_, {wires_, wire_at(0.0)}, 7, nullptr, picture_);
            techniques_[i] = picture_.technique;
        }
    }
    void look(std::size_t index, int size)
    {
        const Look &at = looks[index];
        settings_.beam.fixed_technique = techniques_[index];
        settings_.carm.primary_deg = at.primary_deg;
        settings_.carm.secondary_deg = at.secondary_deg;
        settings_.carm.isocentre_m = {0.0, at.y_m, 0.0};
        settings_.size = size;
    }
    // Computes the next picture of a sequence, including the remains of earlier pictures (the detector's
    // lag).
    void render(int frame)
    {
        const std::vector<Eigen::Vector3i> heart = moves_ ? heart_at(frame) : std::vector<Eigen::Vector3i>();
        std::vector<MovedBody> bodies;
        if (moves_) bodies.push_back({heart_, heart});
        if (breathing_)
            for (const MovingBodies::Moved &body : breathing_->at(inhaling(frame)))
                bodies.push_back({body.body, body.vertices_um});
        WireFrame wire = wire_at(0.0005 * (frame % 16));
        wire.tick = static_cast<std::uint32_t>(67 * ++frames_);
        xray_->render(settings_, {wires_, wire, curves_, bodies}, 7, &memory_, picture_);
    }
    bool was_kept() const { return xray_->last_render_used_cache(); }
    std::size_t triangle_count() const { return scene_.triangle_count(); }

  private:
    // Returns the phase of breath where the chest moves fastest; the domes move by 0.8 mm from frame to
    // frame, as they do at 15 pictures per second and 14 breaths per minute.
    static std::uint32_t inhaling(int frame)
    {
        return (1u << 30) + (1u << 26) * static_cast<std::uint32_t>(frame % 16);
    }
    std::vector<Eigen::Vector3i> heart_at(int frame) const
    {
        std::vector<Eigen::Vector3i> vertices = patient_.bodies[heart_].vertices_um;
        for (Eigen::Vector3i &v : vertices) v.y() += 100 * (frame % 16);
        return vertices;
    }

    Bodies patient_;
    int heart_ = 0;
    bool moves_ = false;
    std::optional<BreathingBodies> breathing_;
    std::vector<SweptCurve> curves_;
    XrayScene scene_;
    std::unique_ptr<Xray> xray_;
    XraySettings settings_;
    std::vector<RadiopaqueInstrument> wires_ = {guidewire_look()};
    XrayPicture picture_;
    XrayMemory memory_;
    XrayTechnique techniques_[std::size(looks)];
    int frames_ = 0;
};

constexpr int is_kept = 1 << 16, is_beating = 1 << 17, has_four = 1 << 18, is_breathing = 1 << 19;

// Returns the mean, over all views, of the shortest computing time of a frame in each view.
double frame_ms(const bench_case *self)
{
    const int size = self->argument & 0xffff;
    const bool keeps = (self->argument & is_kept) != 0, beats = (self->argument & is_beating) != 0;
    const bool breathes = (self->argument & is_breathing) != 0;
    Bench bench(2, {beats, (self->argument & has_four) != 0, breathes});
    if (beats) bench.start_heart();
    bench.settle(size);
    std::vector<double> best(std::size(looks), 1e9), processor(best);
    for (int round = 0; round < rounds; ++round)
        for (std::size_t i = 0; i < std::size(looks); ++i) {
            bench.look(i, size);
            if (keeps) bench.render(breathes ? round : 0);
            const double begin_us = bench_now_us(), begin_ms = bench_processor_ms();
            bench.render(round + 1);
            best[i] = std::min(best[i], (bench_now_us() - begin_us) * 1e-3);
            processor[i] = std::min(processor[i], bench_processor_ms() - begin_ms);
            if (bench.was_kept() != (keeps && !beats && !breathes))
                bench_fail("the view was kept when it should not be, or the reverse");
        }
    double sum = 0.0;
    for (double ms : best) sum += ms;
    std::fprintf(stderr, "%zu triangles; by view:", bench.triangle_count());
    for (double ms : best) std::fprintf(stderr, " %.2f", ms);
    std::fprintf(stderr, " ms; processor time, both threads:");
    for (double ms : processor) std::fprintf(stderr, " %.2f", ms);
    std::fprintf(stderr, " ms\n");
    return sum / static_cast<double>(best.size());
}

} // namespace

extern "C" BENCH_MEASURED void measured_frame(void *bench, int frame)
{
    static_cast<Bench *>(bench)->render(frame);
}

namespace
{

double frame_instructions(const bench_case *self)
{
    Bench bench(1, {.breathes = (self->argument & is_breathing) != 0});
    const int size = self->argument & 0xffff;
    const bool keeps = (self->argument & is_kept) != 0;
    bench.settle(size);
    for (std::size_t i = 0; i < 2; ++i) {
        bench.look(i, size);
        if (keeps) bench.render(0);
        measured_frame(&bench, static_cast<int>(i) + 1);
    }
    return 0.0;
}

// Compares two ways to compute path lengths: the rasteriser, and OpenGL on OSMesa. The rasteriser and OpenGL
// run in turn, with two threads each, and the fastest time of each view counts.
struct PathTimes {
    double raster_ms = 0.0, osmesa_ms = 0.0; // means over the views
    double difference_mm = 0.0;              // mean over all pixels that have any material, all materials
};

double mean_difference_mm(const PathPictures &expected, const PathPictures &got)
{
    double sum_q10 = 0.0;
    std::size_t count = 0;
    for (std::size_t m = 0; m < expected.size(); ++m)
        for (std::size_t i = 0; i < expected[m].size(); ++i) {
            if (expected[m][i] == 0 && got[m][i] == 0) continue;
            sum_q10 += std::abs(expected[m][i] - got[m][i]);
            ++count;
        }
    return sum_q10 / 1024.0 / static_cast<double>(std::max<std::size_t>(count, 1));
}

double draw_ms(BodyPaths &paths, const View &view, std::span<const std::uint8_t> all, PathPictures &pictures)
{
    std::string error;
    const double begin_us = bench_now_us();
    if (!paths.draw(view, all, {0, 0, view.size, view.size}, PathForm::ray_lengths, pictures, error))
        bench_fail(error.c_str());
    return (bench_now_us() - begin_us) * 1e-3;
}

PathTimes path_times(int size)
{
    setenv("LP_NUM_THREADS", "2", 1); // for llvmpipe, Mesa's driver without a graphics card
    XrayScene scene;
    std::string error;
    if (!scene.set_bodies(patient({}), error)) bench_fail(error.c_str());
    const BodyMeshes &meshes = scene.meshes().bodies;
    RasterPaths raster(meshes, 2);
    std::unique_ptr<GlPaths> osmesa;
    try {
        osmesa = std::make_unique<GlPaths>(
            meshes, [] { return open_headless(GlLibrary::osmesa); }, 2);
    } catch (const GlError &failure) {
        bench_fail(failure.what());
    }
    const std::vector<std::uint8_t> all(meshes.channel_of_body.size(), 1);
    PathPictures pictures;
    for (const MeshChannel &channel : meshes.channels)
        for (int material : {channel.own, channel.parent})
            if (material >= 0) pictures[material].resize(static_cast<std::size_t>(size) * size);
    PathPictures pictures_osmesa = pictures;
    PathTimes sum;
    for (const Look &look : looks) {
        CArm carm;
        carm.primary_deg = look.primary_deg;
        carm.secondary_deg = look.secondary_deg;
        carm.isocentre_m = {0.0, look.y_m, 0.0};
        const View view = make_view(carm, size);
        double raster_ms = 1e9, osmesa_ms = 1e9;
        for (int round = 0; round < rounds; ++round) {
            raster_ms = std::min(raster_ms, draw_ms(raster, view, all, pictures));
            osmesa_ms = std::min(osmesa_ms, draw_ms(*osmesa, view, all, pictures_osmesa));
        }
        sum.raster_ms += raster_ms / static_cast<double>(std::size(looks));
        sum.osmesa_ms += osmesa_ms / static_cast<double>(std::size(looks));
        sum.difference_mm +=
            mean_difference_mm(pictures, pictures_osmesa) / static_cast<double>(std::size(looks));
    }
    std::fprintf(stderr,
                 "path lengths of %zu triangles: raster %.2f ms, %s on %s %.2f ms; they differ by %.5f mm\n",
                 scene.triangle_count(), sum.raster_ms, osmesa->description().version.c_str(),
                 osmesa->description().renderer.c_str(), sum.osmesa_ms, sum.difference_mm);
    return sum;
}

double raster_paths_ms(const bench_case *self)
{
    return path_times(self->argument).raster_ms;
}
double osmesa_paths_ms(const bench_case *self)
{
    return path_times(self->argument).osmesa_ms;
}
double osmesa_difference_mm(const bench_case *self)
{
    return path_times(self->argument).difference_mm;
}
double osmesa_ratio(const bench_case *self)
{
    const PathTimes times = path_times(self->argument);
    return times.osmesa_ms / times.raster_ms;
}

const bench_case cases[] = {
    {"xray.frame_ms", "ms", "size=512 view=moved threads=2 materials=4", nullptr, 0, frame_ms,
     512 | has_four},
    {"xray.frame_ms", "ms", "size=1024 view=moved threads=2 materials=4", nullptr, 0, frame_ms,
     1024 | has_four},
    {"xray.frame_ms", "ms", "size=512 view=kept threads=2 materials=4", nullptr, 0, frame_ms,
     512 | is_kept | has_four},
    {"xray.frame_ms", "ms", "size=1024 view=kept threads=2 materials=4", nullptr, 0, frame_ms,
     1024 | is_kept | has_four},
    {"xray.frame_ms", "ms", "size=512 view=moved threads=2 materials=8", nullptr, 0, frame_ms, 512},
    {"xray.frame_ms", "ms", "size=1024 view=moved threads=2 materials=8", nullptr, 0, frame_ms, 1024},
    {"xray.frame_ms", "ms", "size=512 view=kept threads=2 materials=8", nullptr, 0, frame_ms, 512 | is_kept},
    {"xray.frame_ms", "ms", "size=1024 view=kept threads=2 materials=8", nullptr, 0, frame_ms,
     1024 | is_kept},
    {"xray.frame_ms", "ms", "size=512 view=kept threads=2 materials=8 heart_triangles=28800 struts=400",
     nullptr, 0, frame_ms, 512 | is_kept | is_beating},
    {"xray.frame_ms", "ms", "size=512 view=breathing threads=2 materials=8", nullptr, 0, frame_ms,
     512 | is_kept | is_breathing},
    {"xray.paths_ms", "ms", "size=512 by=raster threads=2", nullptr, 0, raster_paths_ms, 512},
    {"xray.paths_ms", "ms", "size=512 by=osmesa threads=2", nullptr, 0, osmesa_paths_ms, 512},
    {"xray.paths_ms", "ms", "size=1024 by=raster threads=2", nullptr, 0, raster_paths_ms, 1024},
    {"xray.paths_ms", "ms", "size=1024 by=osmesa threads=2", nullptr, 0, osmesa_paths_ms, 1024},
    {"xray.osmesa_over_raster", "1", "size=512 paths threads=2", nullptr, 0, osmesa_ratio, 512},
    {"xray.osmesa_over_raster", "1", "size=1024 paths threads=2", nullptr, 0, osmesa_ratio, 1024},
    {"xray.osmesa_difference_mm", "mm", "size=512 paths", nullptr, 0, osmesa_difference_mm, 512},
    {"xray.frame_instructions", "instructions", "size=512 view=moved", "measured_frame", 2,
     frame_instructions, 512},
    {"xray.frame_instructions", "instructions", "size=512 view=kept", "measured_frame", 2, frame_instructions,
     512 | is_kept},
    {"xray.frame_instructions", "instructions", "size=512 view=breathing", "measured_frame", 2,
     frame_instructions, 512 | is_kept | is_breathing},
};

} // namespace

int main(int argc, char **argv)
{
    return bench_main(argc, argv, cases, sizeof(cases) / sizeof(cases[0]));
}
