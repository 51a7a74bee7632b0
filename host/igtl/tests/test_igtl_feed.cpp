// Tests the data that a session publishes: the tips of the tools in use, the C-arm, only new pictures, and a
// status after every change and once per second.
#include "host/igtl/feed.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstring>
extern "C" {
#include <cmocka.h>
}

using namespace crn;

namespace
{

// Keeps what a session publishes.
class Kept final : public IgtlServer
{
  public:
    IgtlAddress address() const override { return {}; }
    std::size_t clients() const override { return 0; }
    void publish(IgtlFrame frame) override { frames.push_back(std::move(frame)); }
    std::vector<IgtlFrame> frames;
};

Instrument tool(const char *name)
{
    Instrument made;
    made.name = name;
    made.table.knots_count = 1;
    made.table.knots[0].radius_outer_um = 800;
    return made;
}

// Three nested tools point to the head; each tip is 10 mm behind the tip of the next inner tool.
SessionFrame frame_at(std::uint32_t tick)
{
    SessionFrame frame;
    frame.wire.tick = tick;
    frame.wire.tip_arc_m = {0.0, 0.01, 0.02};
    for (int i = 0; i <= 20; ++i) {
        WireNode node;
        node.position_m = {0.0, 0.1 - 0.01 * i, 0.0};
        node.arc_m = 0.01 * i;
        frame.wire.nodes.push_back(node);
    }
    return frame;
}

struct Bench {
    explicit Bench(const LineNumbers &line) : patient(SceneAnatomy{}, table, {"", {}, 1, line}) {}
    const IgtlFrame &send(std::uint32_t tick, const IgtlPicture *picture = nullptr)
    {
        feed.send(frame_at(tick), patient, picture);
        return kept.frames.back();
    }
    std::string status(const IgtlFrame &frame)
    {
        const auto found = frame.find(igtl_status_name);
        return found == frame.end() ? "none" : std::get<IgtlStatus>(found->second.content).text;
    }

    const std::vector<Instrument> table = {tool("wire"), tool("catheter"), tool("guide")};
    Patient patient;
    Kept kept;
    IgtlFeed feed{kept};
};

void a_position_without_a_tool_has_no_tip(void **)
{
    Bench bench({1, 0, 3});
    const IgtlFrame &frame = bench.send(20);
    assert_int_equal(frame.count("Tool1Tip"), 1);
    assert_int_equal(frame.count("Tool2Tip"), 0);
    const IgtlItem &guide = frame.at("Tool3Tip");
    assert_int_equal(guide.tick, 20);
    const Eigen::Vector3d tip_mm = std::get<IgtlPose>(guide.content).translation();
    assert_true((tip_mm - Eigen::Vector3d(0.0, 0.0, 80.0)).norm() < 1e-9);
    assert_string_equal(bench.status(frame).c_str(), "X-ray: off; Tool1Tip: wire; Tool3Tip: guide");
}

void a_picture_is_published_only_when_there_is_a_new_one(void **)
{
    Bench bench({1, 2, 3});
    IgtlPicture picture;
    picture.size = 4;
    picture.grey = std::make_shared<const std::vector<std::uint8_t>>(16, std::uint8_t{9});
    assert_int_equal(bench.send(0).count(igtl_picture_name), 0);
    assert_int_equal(std::get<IgtlPicture>(bench.send(10, &picture).at(igtl_picture_name).content).size, 4);
    assert_int_equal(bench.send(20).count(igtl_picture_name), 0);
    assert_int_equal(bench.send(20).count(igtl_carm_name), 1);
}

void the_status_comes_when_it_changes_and_once_per_second(void **)
{
    Bench bench({1, 2, 3});
    assert_true(bench.status(bench.send(0)) != "none");
    assert_string_equal(bench.status(bench.send(500)).c_str(), "none");
    assert_true(bench.status(bench.send(1000)) != "none");
    assert_string_equal(bench.status(bench.send(1900)).c_str(), "none");
    bench.patient.command(1901, {RoomAction::fluoro_pedal, {1, 0, 0}});
    bench.patient.look(frame_at(1902).wire);
    const std::string with_beam = bench.status(bench.send(1902));
    assert_non_null(std::strstr(with_beam.c_str(), "X-ray: fluoroscopy"));
    assert_true(bench.status(bench.send(5)) != "none"); // another session has begun
}

void the_end_of_a_session_is_published(void **)
{
    Bench bench({1, 2, 3});
    bench.send(1234);
    bench.feed.end();
    const IgtlItem &item = bench.kept.frames.back().at(igtl_status_name);
    assert_int_equal(item.tick, 1234);
    assert_false(std::get<IgtlStatus>(item.content).is_running);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_position_without_a_tool_has_no_tip),
        cmocka_unit_test(a_picture_is_published_only_when_there_is_a_new_one),
        cmocka_unit_test(the_status_comes_when_it_changes_and_once_per_second),
        cmocka_unit_test(the_end_of_a_session_is_published),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
