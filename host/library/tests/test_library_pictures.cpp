// Tests the pictures of the library. Pictures must be reproducible. Label images must mark tools where the
// view's matrix projects the tools, and must mark contrast medium, stents and balloons.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

#include "host/library/tests/worlds.hpp"

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

namespace
{

using namespace crn::tests;

cournand_renderer *renderer(cournand_scene *scene, std::uint32_t threads = 1)
{
    cournand_renderer *made = nullptr;
    done(cournand_renderer_create(scene, threads, &made));
    return made;
}

// A view of the tip.
cournand_view view_of(cournand_world *world, std::uint32_t size = 256)
{
    auto view = sized<cournand_view>();
    const cournand_pose shape = pose(world);
    for (int axis = 0; axis < 3; axis++) view.isocentre_m[axis] = shape.positions_m[axis];
    view.flags = COURNAND_VIEW_LABELS;
    view.size = size;
    view.seed = 7;
    return view;
}

cournand_picture picture_of(cournand_renderer *by, cournand_world *world, const cournand_view &view)
{
    auto picture = sized<cournand_picture>();
    done(cournand_render(by, world, &view, &picture));
    return picture;
}

std::size_t pixels_with(const cournand_picture &picture, std::uint8_t bit)
{
    const std::size_t count = std::size_t{picture.size} * picture.size;
    return static_cast<std::size_t>(std::count_if(picture.labels, picture.labels + count,
                                                  [&](std::uint8_t one) { return (one & bit) != 0; }));
}

void equal_worlds_give_equal_pictures_with_any_number_of_threads(void **)
{
    cournand_world *seen = world(aorta());
    push(seen, 1000);
    const cournand_view view = view_of(seen);
    std::vector<std::vector<std::uint16_t>> raws;
    for (const std::uint32_t threads : {1u, 2u, 4u}) {
        cournand_renderer *by = renderer(aorta(), threads);
        const cournand_picture picture = picture_of(by, seen, view);
        raws.emplace_back(picture.raw, picture.raw + 256 * 256);
        assert_int_equal(picture.tick, 1000);
        assert_true(picture.tube_voltage_kV >= 60.0 && picture.air_kerma_uGy > 0.0);
        done(cournand_renderer_free(by));
    }
    assert_true(raws[0] == raws[1] && raws[0] == raws[2]);
    const auto [least, most] = std::minmax_element(raws[0].begin(), raws[0].end());
    print_message("raw values %u to %u\n", unsigned{*least}, unsigned{*most});
    assert_true(*most > *least + 500);
    done(cournand_world_free(seen));
}

void the_tool_is_marked_where_the_matrix_projects_its_nodes(void **)
{
    cournand_world *seen = world(aorta());
    push(seen, 1500);
    cournand_renderer *by = renderer(aorta());
    cournand_view view = view_of(seen);
    view.primary_deg = 30.0;
    view.secondary_deg = -20.0;
    const cournand_picture picture = picture_of(by, seen, view);
    double matrix[12];
    done(cournand_view_matrix(&view, matrix));
    const cournand_pose shape = pose(seen);
    std::size_t inside = 0, marked = 0;
    for (std::uint32_t i = 1; i < shape.node_count; i++) {
        double image[3] = {matrix[3], matrix[7], matrix[11]};
        for (int row = 0; row < 3; row++)
            for (int axis = 0; axis < 3; axis++)
                image[row] += matrix[4 * row + axis] * shape.positions_m[3 * i + axis];
        const int column = static_cast<int>(std::floor(image[0] / image[2])),
                  row = static_cast<int>(std::floor(image[1] / image[2]));
        if (column < 1 || row < 1 || column > 254 || row > 254) continue;
        inside++;
        for (int d = 0; d < 9; d++)
            if (picture.labels[(row + d / 3 - 1) * 256 + column + d % 3 - 1] & COURNAND_LABEL_TOOL_0) {
                marked++;
                break;
            }
    }
    print_message("%zu of %zu nodes in the picture are marked\n", marked, inside);
    assert_true(inside >= 10);
    assert_true(marked == inside);
    assert_true(pixels_with(picture, COURNAND_LABEL_TOOL_0) < 256 * 256 / 20); // a thin line
    assert_int_equal(pixels_with(picture, COURNAND_LABEL_TOOL_1), 0);
    done(cournand_renderer_free(by));
    done(cournand_world_free(seen));
}

void nested_tools_have_masks_of_their_own(void **)
{
    auto options = sized<cournand_world_options>();
    options.inserted_count = 2;
    options.inserted_m[0] = 0.012f;
    options.inserted_m[1] = 0.005f;
    cournand_world *seen = world(aorta(), {"j_wire", "terumo_5f"}, &options);
    const float together[COURNAND_ACTION_FLOATS] = {0.06f, 0.03f};
    done(cournand_world_move(seen, together, 1500));
    cournand_renderer *by = renderer(aorta());
    const cournand_picture picture = picture_of(by, seen, view_of(seen));
    const std::size_t wire = pixels_with(picture, COURNAND_LABEL_TOOL_0),
                      catheter = pixels_with(picture, COURNAND_LABEL_TOOL_1);
    print_message("wire %zu, catheter %zu pixels\n", wire, catheter);
    assert_true(wire > 30 && catheter > 30 && wire != catheter);
    done(cournand_renderer_free(by));
    done(cournand_world_free(seen));
}

void medium_is_marked_after_an_injection(void **)
{
    auto options = sized<cournand_world_options>();
    options.flags = COURNAND_WITH_PATIENT;
    cournand_world *seen = world(aorta(), {"terumo_5f"}, &options);
    push(seen, 500, 0.04f);
    cournand_renderer *by = renderer(aorta());
    const cournand_view view = view_of(seen);
    assert_int_equal(pixels_with(picture_of(by, seen, view), COURNAND_LABEL_MEDIUM), 0);
    done(cournand_world_inject(seen, 8.0, 8.0, -1, 350.0));
    push(seen, 700, 0.0f);
    const std::size_t medium = pixels_with(picture_of(by, seen, view), COURNAND_LABEL_MEDIUM);
    print_message("medium in %zu pixels\n", medium);
    assert_true(medium > 300);
    done(cournand_renderer_free(by));
    done(cournand_world_free(seen));
}

void stent_and_balloon_are_marked_when_they_open(void **)
{
    auto options = sized<cournand_world_options>();
    options.flags = COURNAND_WITH_PATIENT;
    const std::string path = stents + "renal_6_0x18.toml";
    const char *const paths[] = {path.c_str()};
    options.stent_count = 1;
    options.stents = paths;
    options.inserted_count = 2;
    options.inserted_m[0] = options.inserted_m[1] = 0.05f;
    cournand_world *seen = world(free_space(), {"coronary_014", "balloon_6x20"}, &options);
    done(cournand_world_load_stent(seen));
    float inflated[COURNAND_ACTION_FLOATS] = {};
    done(cournand_world_move(seen, inflated, 100));
    cournand_renderer *by = renderer(free_space());
    const cournand_view view = view_of(seen);
    const std::size_t folded = pixels_with(picture_of(by, seen, view), COURNAND_LABEL_BALLOON);
    inflated[6] = 800.0f;
    done(cournand_world_move(seen, inflated, 1500));
    const cournand_picture picture = picture_of(by, seen, view);
    auto read = sized<cournand_patient_reading>();
    done(cournand_world_read_patient(seen, &read));
    print_message("balloon %zu pixels, before %zu; struts %zu; %.1f mm; stent '%s'\n",
                  pixels_with(picture, COURNAND_LABEL_BALLOON), folded,
                  pixels_with(picture, COURNAND_LABEL_STENT), reading(seen).balloon_diameter_max_m * 1e3,
                  read.stent_stage);
    assert_int_equal(folded, 0);
    assert_int_equal(read.stents_loaded, 1);
    assert_true(pixels_with(picture, COURNAND_LABEL_BALLOON) > 50);
    assert_true(pixels_with(picture, COURNAND_LABEL_STENT) > 50);
    done(cournand_renderer_free(by));
    done(cournand_world_free(seen));
}

void labels_alone_equal_those_beside_a_picture(void **)
{
    cournand_world *seen = world(aorta());
    push(seen, 1000);
    cournand_renderer *by = renderer(aorta());
    cournand_view view = view_of(seen);
    const cournand_picture both = picture_of(by, seen, view);
    const std::vector<std::uint8_t> labels(both.labels, both.labels + 256 * 256);
    view.flags = COURNAND_VIEW_LABELS_ONLY;
    const cournand_picture alone = picture_of(by, seen, view);
    assert_null(alone.grey);
    assert_true(std::equal(labels.begin(), labels.end(), alone.labels));
    view.flags = 0;
    assert_null(picture_of(by, seen, view).labels);
    done(cournand_renderer_free(by));
    done(cournand_world_free(seen));
}

void wrong_views_are_refused(void **)
{
    cournand_world *seen = world(aorta()), *elsewhere = world(free_space());
    cournand_renderer *by = renderer(aorta());
    auto picture = sized<cournand_picture>();
    const cournand_view usual = view_of(seen);
    const auto refuses = [&](const cournand_view &view) {
        const bool is_refused = cournand_render(by, seen, &view, &picture) == COURNAND_BAD_ARGUMENT;
        return is_refused && std::string(cournand_error_text()).find("view") == 0;
    };
    cournand_view view = usual;
    view.size = 100;
    assert_true(refuses(view));
    view.size = UINT32_MAX;
    assert_true(refuses(view));
    view = usual;
    view.primary_deg = std::nan("");
    assert_true(refuses(view));
    view = usual;
    view.flags = 1u << 30;
    assert_true(refuses(view));
    view = usual;
    view.isocentre_m[2] = 1e30;
    assert_true(refuses(view));
    view = usual;
    view.field_m = -1.0;
    assert_true(refuses(view));
    assert_int_equal(cournand_render(by, elsewhere, &usual, &picture), COURNAND_BAD_ARGUMENT);
    assert_int_equal(cournand_render(nullptr, seen, &usual, &picture), COURNAND_BAD_HANDLE);
    assert_int_equal(cournand_render(by, seen, nullptr, &picture), COURNAND_BAD_ARGUMENT);
    assert_int_equal(cournand_render(by, seen, &usual, nullptr), COURNAND_BAD_ARGUMENT);
    done(cournand_renderer_free(by));
    done(cournand_world_free(seen));
    done(cournand_world_free(elsewhere));
}

// The limits for the rendering times are the goals of the figure env.picture_ms on a quiet machine: 2 ms for
// a picture of 128 pixels, and 12 ms for one of 512 pixels.
void a_picture_with_labels_takes_milliseconds(void **)
{
    cournand_world *seen = world(aorta());
    push(seen, 1000);
    cournand_renderer *by = renderer(aorta());
    for (const std::uint32_t size : {128u, 512u}) {
        const cournand_view view = view_of(seen, size);
        picture_of(by, seen, view);
        double least_ms = 1e9;
        for (int i = 0; i < 10; i++) {
            const auto begin = std::chrono::steady_clock::now();
            picture_of(by, seen, view);
            const std::chrono::duration<double, std::milli> took = std::chrono::steady_clock::now() - begin;
            least_ms = std::min(least_ms, took.count());
        }
        print_message("%u pixels: %.2f ms\n", size, least_ms);
        assert_true(least_ms < 200.0);
    }
    done(cournand_renderer_free(by));
    done(cournand_world_free(seen));
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(equal_worlds_give_equal_pictures_with_any_number_of_threads),
        cmocka_unit_test(the_tool_is_marked_where_the_matrix_projects_its_nodes),
        cmocka_unit_test(nested_tools_have_masks_of_their_own),
        cmocka_unit_test(medium_is_marked_after_an_injection),
        cmocka_unit_test(stent_and_balloon_are_marked_when_they_open),
        cmocka_unit_test(labels_alone_equal_those_beside_a_picture),
        cmocka_unit_test(wrong_views_are_refused),
        cmocka_unit_test(a_picture_with_labels_takes_milliseconds),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
