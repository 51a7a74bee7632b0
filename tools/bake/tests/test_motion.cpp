// These tests check the following. A lattice fitted to 24 frames moves the lumen, as the core computes the
// motion, to within 0.3 mm of each frame. Frames at other times of the heartbeat are converted to the
// standard times. Meshes that form no sequence are refused with a message of one sentence. The tests use a
// tube of 1.5 mm radius that lies on a beating and rotating sphere.
#include "host/model/bodies.hpp"
#include "host/model/motion.hpp"
#include "shared/scene/scene.h"
#include "tools/bake/tests/shapes.hpp"

#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <sstream>
extern "C" {
#include <cmocka.h>
}

using namespace crn::bake;
using namespace crn::bake::tests;
using crn::Bodies;

namespace
{

const std::string motion_text = "[motion]\nframes = \"frames\"\nend_systole = 10\n";
constexpr double motion_ring_mm = 40, motion_tube_mm = 1.5;
constexpr int around = 220, across = 14;

// Returns the contraction of the heart, which is 0 at the end of filling and 1 at the end of systole (10 / 24
// of the cycle).
double contraction(double phase)
{
    const double end = 10.0 / 24.0;
    const double share = phase < end ? phase / end / 2 : 0.5 + (phase - end) / (1 - end) / 2;
    return (1 - std::cos(turn * share)) / 2;
}

// Shrinks the space by 30 % towards a fixed point, moves it 6 mm down and rotates it by 12 degrees. The
// motion fades to zero at 90 mm from the fixed point.
Eigen::Vector3d beating(const Eigen::Vector3d &X, double phase)
{
    const Eigen::Vector3d middle(8, -5, 6), r = X - middle;
    const double s = r.norm() / 90, fade = s < 1 ? (1 - s * s) * (1 - s * s) : 0,
                 c = contraction(phase) * fade;
    const Eigen::AngleAxisd twist(12 * turn / 360 * c, Eigen::Vector3d(0.3, 1, 0.2).normalized());
    return middle + (1 - 0.3 * c) * (twist * r) - Eigen::Vector3d(0, 6 * c, 0);
}

// Returns the position to which a full breath moves a point. The displacement by a full breath is 3.2 mm
// down, as in the shipped heart, and fades to zero at a distance of 90 mm.
Eigen::Vector3d inhaled(const Eigen::Vector3d &x)
{
    const double s = x.norm() / 90, fade = s < 1 ? (1 - s * s) * (1 - s * s) : 0;
    return x - Eigen::Vector3d(0, 0, 3.2 * fade);
}

std::string obj_of(const Mesh &mesh)
{
    std::ostringstream text;
    text.precision(9);
    for (const Eigen::Vector3d &v : mesh.vertices_mm)
        text << "v " << v.x() << ' ' << v.y() << ' ' << v.z() << '\n';
    for (const Triangle &t : mesh.triangles)
        text << "f " << t[0] + 1 << ' ' << t[1] + 1 << ' ' << t[2] + 1 << '\n';
    return text.str();
}

std::string frame_name(int k)
{
    return (k < 10 ? "frames/f0" : "frames/f") + std::to_string(k) + ".obj";
}

// Writes 24 mesh files, one per frame, and a scene whose lumen is the first frame.
void write_frames(const Folder &folder, const std::function<double(int)> &phase_of)
{
    std::filesystem::create_directory(folder.path / "frames");
    const Mesh reference = torus(motion_ring_mm, motion_tube_mm, around, across);
    for (int k = 0; k < 24; ++k) {
        Mesh frame = reference;
        for (Eigen::Vector3d &v : frame.vertices_mm) v = beating(v, phase_of(k));
        folder.write(frame_name(k), obj_of(frame));
    }
}

std::string text_of(const std::string &motion)
{
    return scene_text_of("frames/f00.obj", "", "[0, 40, 0]") + motion;
}

Options options_for(const Folder &folder, const std::string &text)
{
    Options options;
    options.scene = folder.write("scene.toml", text);
    options.output = folder.path / "out.scene";
    options.poses = 200;
    options.points = 5000;
    return options;
}

double number_behind(const std::string &text, const std::string &words)
{
    const std::size_t at = text.find(words);
    if (at == std::string::npos) fail_msg("\"%s\" does not say \"%s\"", text.c_str(), words.c_str());
    return std::stod(text.substr(at + words.size()));
}

void the_moved_lumen_is_the_moved_mesh_in_every_frame(void **)
{
    Folder folder;
    Progress progress;
    write_frames(folder, [](int k) { return k / 24.0; });
    const std::string report = crn::bake::bake(options_for(folder, text_of(motion_text)), progress);
    const double worst = number_behind(report, "  worst     ");
    print_message("# worst %.3f mm, allowed 0.3\n", worst);
    assert_true(worst > 0.005 && worst < 0.3);
    assert_true(report.find("frame 23") != std::string::npos &&
                report.find("warning: the moved lumen") == std::string::npos);
    const auto bytes = [&] {
        std::ifstream in(folder.path / "out.scene", std::ios::binary);
        return std::string(std::istreambuf_iterator<char>(in), {});
    }();
    std::vector<std::uint32_t> aligned((bytes.size() + 3) / 4);
    std::memcpy(aligned.data(), bytes.data(), bytes.size());
    crn_scene scene;
    assert_int_equal(
        crn_scene_open(reinterpret_cast<const std::uint8_t *>(aligned.data()), bytes.size(), &scene, nullptr),
        CRN_SCENE_OK);
    assert_true(scene.has_motion && !scene.has_breath);
    assert_int_equal(scene.motion.spacing_log2_q30, 23);
}

// The lattice of breath is fitted to the first frame alone. The fit must also be correct for every other
// frame, because the moving chest moves the beating heart.
void a_full_breath_carries_every_frame(void **)
{
    Folder folder;
    Progress progress;
    write_frames(folder, [](int k) { return k / 24.0; });
    const Mesh reference = torus(motion_ring_mm, motion_tube_mm, around, across);
    Mesh first = reference;
    for (Eigen::Vector3d &v : first.vertices_mm) v = inhaled(beating(v, 0));
    folder.write("inhaled.obj", obj_of(first));
    const std::string report =
        crn::bake::bake(options_for(folder, text_of(motion_text + "inhaled = \"inhaled.obj\"\n")), progress);
    assert_true(report.find("  inhaled   moved lumen") != std::string::npos);
    assert_true(number_behind(report, "  worst     ") < 0.3);
    std::string error;
    const std::optional<crn::Motion> motion = crn::read_motion((folder.path / "out.scene").string(), error);
    assert_true(motion && motion->breathes());
    const double pose = number_behind(report, "pose of keyframe ") / 24;
    double worst_mm = 0;
    for (std::uint32_t k = 0; k < 24; k += 3)
        for (const Eigen::Vector3d &v : reference.vertices_mm) {
            const crn::MotionMoment moment{static_cast<std::uint32_t>((std::uint64_t{k} << 32) / 24),
                                           1u << 31};
            const Eigen::Vector3d pulled = 1e3 * motion->pull(1e-3 * inhaled(beating(v, k / 24.0)), moment);
            worst_mm = std::max(worst_mm, (pulled - beating(v, pose)).norm());
        }
    print_message("# inhaled, worst of eight frames %.3f mm, allowed 0.3\n", worst_mm);
    assert_true(worst_mm > 0.005 && worst_mm < 0.3);
}

// The reference pose is the middle keyframe: every frame is within half the length of the motion from it.
void the_reference_pose_is_in_the_middle(void **)
{
    Sequence sequence;
    for (int k = 0; k < 24; ++k) sequence.moved_mm.push_back({{10 * contraction(k / 24.0), 0, 0}});
    const std::size_t pose = middle_pose(sequence);
    assert_true(std::abs(sequence.moved_mm[pose][0].x() - 5) < 1.1);
}

// Bodies described at keyframe 0 are moved to the reference pose, so that each of their vertices lies where
// the frames show it.
void bodies_go_to_the_reference_pose_with_the_lumen(void **)
{
    Folder folder;
    Progress progress;
    write_frames(folder, [](int k) { return k / 24.0; });
    const std::string body =
        "[[body]]\nname = \"blood\"\nmesh = \"lumen\"\nmaterial = \"blood\"\nmoves = true\n";
    crn::bake::bake(options_for(folder, text_of(motion_text + body)), progress);
    std::string error;
    Bodies bodies;
    assert_true(read_bodies((folder.path / "out.bodies").string(), bodies, error));
    MeshText text;
    text.placement.unit = "mm";
    text.file = folder.path / frame_name(5);
    const Mesh frame = load_mesh(text);
    double nearest_mm = 1e9;
    assert_true(bodies.bodies.at(0).moves);
    for (const Eigen::Vector3d &v : frame.vertices_mm)
        nearest_mm =
            std::min(nearest_mm, (v - bodies.bodies[0].vertices_um[100].cast<double>() * 1e-3).norm());
    assert_true(nearest_mm < 0.3);
}

// A lesion of 60 % stenosis is made in the reference pose, at the angle of 220 degrees on the ring-shaped
// vessel. In every frame, the narrowest point of the lumen lies where the motion has moved the lesion's
// centre.
void a_lesion_moves_with_its_vessel(void **)
{
    Folder folder;
    Progress progress;
    write_frames(folder, [](int k) { return k / 24.0; });
    std::string ring = "branch,name,x_mm,y_mm,z_mm,radius_mm\n";
    const auto place_mm = [](double degrees) {
        return Eigen::Vector3d(motion_ring_mm * std::cos(turn * degrees / 360),
                               motion_ring_mm * std::sin(turn * degrees / 360), 0);
    };
    for (int degrees = 120; degrees <= 400; degrees += 4)
        ring += "0,ring," + std::to_string(place_mm(degrees).x()) + "," +
                std::to_string(place_mm(degrees).y()) + ",0," + std::to_string(motion_tube_mm) + "\n";
    folder.write("ring.csv", ring);
    const std::string at_mm = std::to_string(motion_ring_mm * turn * 100 / 360);
    const std::string report = crn::bake::bake(
        options_for(folder, text_of("[tree]\ncentrelines = [\"ring.csv\"]\n" + motion_text +
                                    "[[lesion]]\nname = \"plaque\"\nbranch = \"ring\"\nat_mm = " + at_mm +
                                    "\nlength_mm = 14\nstenosis_percent = 60\n")),
        progress);
    assert_true(report.find("60 % by diameter") != std::string::npos);
    std::string error;
    Bodies bodies;
    assert_true(read_bodies((folder.path / "out.bodies").string(), bodies, error));
    const auto motion = crn::read_motion((folder.path / "out.scene").string(), error);
    assert_true(motion.has_value());
    const crn::VesselTree &tree = bodies.vessels;
    const Eigen::Vector3d throat_m = tree.branches.at(0).points_m[tree.throat(tree.lesions.at(0))];
    for (int k : {0, 5, 10, 17}) {
        const auto phase32 = static_cast<std::uint32_t>(k * (4294967296.0 / 24));
        const double off_mm =
            (motion->push(throat_m, {phase32, 0}) * 1e3 - beating(place_mm(220), k / 24.0)).norm();
        print_message("# frame %d: throat off by %.3f mm\n", k, off_mm);
        assert_true(off_mm < 0.1);
    }
}

// A second recording of the same motion ends systole in frame 8. After conversion to the standard times, its
// frame 8 is keyframe 10, and its frame 4 is keyframe 5.
void frames_of_another_timing_are_retimed(void **)
{
    Sequence timed;
    for (int k = 0; k < 24; ++k)
        timed.moved_mm.push_back({{static_cast<double>(k), std::cos(turn * k / 24), 0}});
    timed.retime(8);
    assert_true(std::abs(timed.moved_mm[10][0].x() - 8) < 1e-9 &&
                std::abs(timed.moved_mm[5][0].x() - 4) < 1e-9);
    assert_true(std::abs(timed.moved_mm[17][0].x() - 16) < 1e-9);
    assert_true(std::abs(timed.moved_mm[0][0].x()) < 1e-9);
    for (int k = 0; k < 10; ++k) // between frames, within 0.1 % of a smooth course
        assert_true(std::abs(timed.moved_mm[static_cast<std::size_t>(k)][0].y() -
                             std::cos(turn * 0.8 * k / 24)) < 1e-3);
}

void what_is_no_sequence_is_refused(void **)
{
    Folder folder;
    Progress progress;
    write_frames(folder, [](int k) { return k / 24.0; });
    const auto why = [&](const std::string &motion) {
        return complaint([&] { crn::bake::bake(options_for(folder, text_of(motion)), progress); });
    };
    const auto says = [](const std::string &text, const char *part) {
        if (text.find(part) == std::string::npos) fail_msg("\"%s\" does not say \"%s\"", text.c_str(), part);
    };
    says(why("[motion]\nframes = \"nowhere\"\n"), "which is no folder");
    says(why("[motion]\nframes = \"frames\"\nspacin_mm = 8\n"),
         "[motion]: unknown key 'spacin_mm', did you mean 'spacing_mm'?");
    Mesh other = torus(motion_ring_mm, motion_tube_mm, around - 1, across);
    folder.write(frame_name(7), obj_of(other));
    says(why("[motion]\nframes = \"frames\"\n"), "has other triangles than");
    other = torus(motion_ring_mm, motion_tube_mm, around, across);
    for (Eigen::Vector3d &v : other.vertices_mm) v = beating(v, 0.29) + Eigen::Vector3d(0, 0, 9);
    folder.write(frame_name(7), obj_of(other));
    says(why("[motion]\nframes = \"frames\"\n"), "jumps by");
    std::filesystem::remove(folder.path / frame_name(7));
    says(why("[motion]\nframes = \"frames\"\n"), "holds 23 meshes");
    assert_false(std::filesystem::exists(folder.path / "out.scene"));
}

// A ball of 8 mm in a box of 20 mm goes down by 3 mm with a full breath. The core's scene must not differ
// from that of a ball that does not breathe.
void a_body_that_breathes_changes_no_byte_of_the_scene(void **)
{
    Folder folder;
    Progress progress;
    folder.write("lumen.obj", obj_of(torus(motion_ring_mm, motion_tube_mm, around, across)));
    Mesh ball = cube(8), box = cube(20);
    for (Eigen::Vector3d &v : ball.vertices_mm) v += Eigen::Vector3d(6, 4, 6);
    folder.write("box.obj", obj_of(box));
    folder.write("ball.obj", obj_of(ball));
    for (Eigen::Vector3d &v : ball.vertices_mm) v.y() -= 3;
    folder.write("inhaled.obj", obj_of(ball));
    for (Eigen::Vector3d &v : ball.vertices_mm) v.y() -= 3;
    folder.write("deep.obj", obj_of(ball));
    const auto body = [](const char *name, const char *mesh, const std::string &more) {
        return "[[body]]\nname = \"" + std::string(name) + "\"\nmesh = \"" + mesh +
               "\"\nunit = \"mm\"\nmaterial = \"soft\"\n" + more;
    };
    const std::string still = scene_text_of("lumen.obj", "", "[0, 40, 0]") + body("box", "box.obj", "") +
                              body("ball", "ball.obj", "inside = \"box\"\n");
    const auto bytes_of = [&](const std::string &text, std::string &report) {
        report = crn::bake::bake(options_for(folder, text), progress);
        std::ifstream file(folder.path / "out.scene", std::ios::binary);
        return std::string(std::istreambuf_iterator<char>(file), {});
    };
    std::string report;
    const std::string expected = bytes_of(still, report);
    assert_true(report.find("breath") == std::string::npos);
    assert_true(bytes_of(still + "inhaled = \"inhaled.obj\"\n", report) == expected);
    assert_true(report.find("breath            moves 1 bodies by at most 3.0 mm") != std::string::npos);
    assert_true(report.find("warning") == std::string::npos);
    std::string error;
    Bodies bodies;
    assert_true(read_bodies((folder.path / "out.bodies").string(), bodies, error));
    assert_true(bodies.bodies.at(0).breath_um.empty());
    assert_int_equal(bodies.bodies.at(1).breath_um.at(5).y(), -3000);
    bytes_of(still + "inhaled = \"deep.obj\"\n", report);
    const auto says = [](const std::string &text, const char *part) {
        if (text.find(part) == std::string::npos) fail_msg("\"%s\" does not say \"%s\"", text.c_str(), part);
    };
    says(report, "warning: after a full breath, body 'ball' reaches 2.0 mm out of 'box'");
    const auto why = [&](const std::string &more) {
        return complaint([&] { crn::bake::bake(options_for(folder, still + more), progress); });
    };
    says(why("inhaled = \"lumen.obj\"\n"), "has other triangles than");
    says(why("inhaled = \"inhaled.obj\"\nsolid_mm = 1\n"), "so its mesh must stay as it is");
    says(why("inhaled = \"nowhere.obj\"\n"), "nowhere.obj");
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(the_moved_lumen_is_the_moved_mesh_in_every_frame),
        cmocka_unit_test(a_full_breath_carries_every_frame),
        cmocka_unit_test(the_reference_pose_is_in_the_middle),
        cmocka_unit_test(bodies_go_to_the_reference_pose_with_the_lumen),
        cmocka_unit_test(a_lesion_moves_with_its_vessel),
        cmocka_unit_test(frames_of_another_timing_are_retimed),
        cmocka_unit_test(what_is_no_sequence_is_refused),
        cmocka_unit_test(a_body_that_breathes_changes_no_byte_of_the_scene),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
