// These tests check the following. A project of the editor keeps its points when it is saved, undone and
// redone. A click selects the middle of the vessel under the mouse pointer.
#include "host/base/pending_file.hpp"
#include "tools/centreline/fit/editor.hpp"
#include "tools/centreline/fit/tree_picture.hpp"
#include "tools/centreline/tests/shapes.hpp"

#include <array>
#include <random>

using namespace crn;
using namespace crn::centreline;
using namespace crn::centreline::tests;

namespace
{

Point point(PointKind kind, double y, const char *name = "")
{
    Point made;
    made.kind = kind;
    made.name = name;
    made.position_mm = {0.25, y, -1};
    return made;
}

void a_project_is_saved_and_resumed(void **)
{
    const Folder folder;
    const std::filesystem::path file = folder.path / "p.toml";
    {
        Project project(file, "a \"b\".obj", "cm");
        assert_true(!project.was_resumed() && !project.is_saved());
        project.add(point(PointKind::start, 1, "in"));
        project.add(point(PointKind::bifurcation, 2));
        project.save();
        assert_true(project.is_saved());
        project.remove(0);
        assert_true(!project.is_saved());
    }
    const Project again(file, "a \"b\".obj", "cm");
    assert_true(again.was_resumed() && again.is_saved());
    assert_int_equal(again.points().size(), 2);
    assert_string_equal(again.points()[0].name.c_str(), "in");
    assert_true(again.points()[1].kind == PointKind::bifurcation);
    assert_true(again.points()[1].position_mm == Eigen::Vector3d(0.25, 2, -1));
    says([&] { Project other(file, "c.obj", "mm"); }, {"belongs to the mesh a \"b\".obj", "c.obj"});
    // If the project cannot be saved, the old project file remains.
    Project lost(folder.path / "no" / "p.toml", "a.obj", "mm");
    bool is_refused = false;
    try {
        lost.save();
    } catch (const OutputError &) {
        is_refused = true;
    }
    assert_true(is_refused);
}

void every_change_can_be_undone_and_done_again(void **)
{
    const Folder folder;
    Project project(folder.path / "p.toml", "a.obj", "mm");
    std::vector<std::string> states;
    const auto state = [&] { return points_text({"", "mm", project.points()}); };
    const auto step = [&](const std::function<void()> &change) {
        states.push_back(state());
        change();
    };
    step([&] { project.add(point(PointKind::start, 1)); });
    step([&] { project.add(point(PointKind::end, 5)); });
    step([&] { project.move(1, {0, 7, 0}); });
    step([&] { project.remove(0); });
    step([&] { project.replace({point(PointKind::end, 9), point(PointKind::start, 2)}); });
    states.push_back(state());
    assert_true(!project.redo());
    for (std::size_t n = states.size() - 1; n-- > 0;) {
        assert_true(project.undo());
        assert_string_equal(state().c_str(), states[n].c_str());
    }
    assert_true(!project.undo());
    for (std::size_t n = 1; n < states.size(); ++n) {
        assert_true(project.redo());
        assert_string_equal(state().c_str(), states[n].c_str());
    }
    // After a new change to the points, changes that were undone before can no longer be redone.
    assert_true(project.undo());
    project.add(point(PointKind::end, 3));
    assert_true(!project.redo());
}

// No project file may cause a crash, and each error message must begin with the file's name.
void damaged_texts_of_points_are_points_or_faults(void **)
{
    const Folder folder;
    const std::filesystem::path file = folder.path / "p.toml";
    const std::string good =
        points_text({"a.obj", "mm", {point(PointKind::start, 1, "in"), point(PointKind::end, 9, "out")}});
    std::mt19937 random(3);
    std::size_t faults = 0;
    for (int n = 0; n < 400; ++n) {
        std::string text = good;
        const std::size_t at = random() % text.size();
        switch (n % 4) {
        case 0:
            text[at] = static_cast<char>(random());
            break;
        case 1:
            text.resize(at);
            break;
        case 2:
            text.erase(at, 1 + random() % 9);
            break;
        default:
            text.insert(at, std::array{"[", "\"", "nan", "[[point]]\n"}[random() % 4]);
        }
        std::ofstream(file, std::ios::binary) << text;
        try {
            read_points(file);
        } catch (const Fault &fault) {
            assert_true(std::string(fault.what()).rfind(file.string(), 0) == 0);
            ++faults;
        }
    }
    assert_true(faults > 200);
}

void a_mistyped_key_or_word_gets_a_suggestion(void **)
{
    const Folder folder;
    const std::filesystem::path file = folder.path / "p.toml";
    const auto refusal = [&](const std::string &text) -> std::string {
        std::ofstream(file) << text;
        try {
            read_points(file);
        } catch (const Fault &fault) {
            return fault.what();
        }
        return "";
    };
    const std::string point = "format = 1\n[[point]]\nkind = \"start\"\nposition_mm = [0, 0, 0]\n";
    assert_string_equal(refusal(point).c_str(), "");
    assert_string_equal(refusal(point + "nam = \"a\"\n").c_str(),
                        (file.string() + ":5:7: point 1: unknown key 'nam', did you mean 'name'?").c_str());
    assert_string_equal(refusal("format = 1\nmess = \"a.obj\"\n").c_str(),
                        (file.string() + ":2:8: unknown key 'mess', did you mean 'mesh'?").c_str());
    assert_string_equal(refusal("format = 1\n[[point]]\nkind = \"strat\"\n").c_str(),
                        (file.string() + ":3:8: point 1: 'kind' is 'strat', did you mean 'start'?").c_str());
}

void a_click_means_the_middle_of_the_first_vessel_behind_it(void **)
{
    // The test looks from the front at two tubes, one of which is behind the other.
    bake::Mesh mesh = tube_mesh(2, 30, 0, 60, 32);
    const bake::Mesh back = mesh;
    for (const Eigen::Vector3d &v : back.vertices_mm)
        mesh.vertices_mm.push_back(v - Eigen::Vector3d(0, 0, 20));
    const auto count = static_cast<std::uint32_t>(back.vertices_mm.size());
    for (const bake::Triangle &t : back.triangles)
        mesh.triangles.push_back({t[0] + count, t[1] + count, t[2] + count});
    bake::Progress silent;
    const Lumen lumen(mesh, {}, silent);
    for (double turned : {0.0, 180.0}) {
        const View view = view_of(lumen.wall(), turned, 0, 600, 600);
        const SheetPoint at = view.place({1.2, 10, 0});
        const auto place = picked(lumen, view, at.x, at.y);
        assert_true(place.has_value());
        const Eigen::Vector3d wanted(0, 10, turned == 0 ? 0 : -20);
        if ((*place - wanted).norm() > 0.5) fail_msg("%.2f %.2f %.2f", place->x(), place->y(), place->z());
        assert_true(!picked(lumen, view, 5, 5));
    }
}

// In a view from the front, +x points to the right and +y up. A view from the patient's left (+x) looks along
// -x, and +z points to the left.
void views_look_from_where_they_say(void **)
{
    View view;
    view.width = view.height = 100;
    const SheetPoint front = view.place({10, 20, 0});
    assert_true(std::abs(front.x - 60) < 1e-9 && std::abs(front.y - 30) < 1e-9);
    view.turn_deg = 90;
    const SheetPoint side = view.place({0, 0, 10});
    assert_true(std::abs(side.x - 40) < 1e-9 && std::abs(side.y - 50) < 1e-9);
    assert_true((view.axes().row(2).transpose() - Eigen::Vector3d::UnitX()).norm() < 1e-9);
    view.turn_deg = 0;
    view.tilt_deg = 90;
    assert_true((view.axes().row(2).transpose() - Eigen::Vector3d::UnitY()).norm() < 1e-9);
    assert_true((view.ray_start_mm(60, 50) - Eigen::Vector3d(10, 0, 0)).norm() < 1e-9);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {cmocka_unit_test(a_project_is_saved_and_resumed),
                                cmocka_unit_test(every_change_can_be_undone_and_done_again),
                                cmocka_unit_test(damaged_texts_of_points_are_points_or_faults),
                                cmocka_unit_test(a_mistyped_key_or_word_gets_a_suggestion),
                                cmocka_unit_test(a_click_means_the_middle_of_the_first_vessel_behind_it),
                                cmocka_unit_test(views_look_from_where_they_say)};
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
