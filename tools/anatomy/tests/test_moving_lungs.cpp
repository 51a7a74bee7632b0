// These tests check the following. When the shipped lungs move with the heart, no face of their meshes turns
// over. Rounding the vertices to a micrometre, as in files, must not turn any face of the lungs' meshes over.
#include "tools/anatomy/heart_sequence.hpp"
#include "tools/anatomy/vessel_file.hpp"
#include "tools/mesh/sequence.hpp"

#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
extern "C" {
#include <cmocka.h>
}

using namespace anatomy;

namespace
{

void no_face_of_a_lung_turns_over(void **)
{
    const VesselTree tree = shipped_vessels("heart");
    const HeartBeat beat(tree.vessels.front());
    crn::mesh::Sequence sequence;
    for (const Body &body : patient_bodies(tree, {})) {
        if (body.name != "lung_left" && body.name != "lung_right") continue;
        const Mesh mesh = mesh_of(body.request);
        assert_string_equal(closed_mesh_fault(mesh).c_str(), "");
        MovingBody moving = moving_body(body.name, mesh, beat);
        for (std::vector<Vec3> &frame : moving.frames_mm)
            for (Vec3 &vertex : frame) vertex = (vertex * 1e3).array().round() * 1e-3;
        sequence.bodies.push_back({body.name, moving.triangles, moving.frames_mm});
    }
    assert_int_equal(sequence.bodies.size(), 2);
    for (const crn::mesh::SequenceReport &report : crn::mesh::check_sequence(sequence))
        if (!report.fault.empty()) fail_msg("%s: %s", report.body.c_str(), report.fault.c_str());
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {cmocka_unit_test(no_face_of_a_lung_turns_over)};
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
