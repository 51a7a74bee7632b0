// Tests which C-arm pose belongs to the shown picture: a held picture, or a frame of a run, keeps the pose of
// its own pulse, even if the C-arm has moved since.
#include "host/room/room_screen.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
extern "C" {
#include <cmocka.h>
}

using namespace crn;

namespace
{

constexpr int side = 16;

struct PlaceBench {
    void ask(RoomAction action, std::int32_t a = 0, std::int32_t b = 0, std::int32_t c = 0)
    {
        assert_string_equal(room.give(now, {action, {a, b, c}}).c_str(), "");
    }
    void run_for(std::uint32_t ticks)
    {
        XrayPicture picture;
        picture.size = side;
        picture.grey.assign(std::size_t{side} * side, 1);
        picture.raw.assign(std::size_t{side} * side, 1);
        for (const std::uint32_t end = now + ticks; now < end; ++now) {
            room.advance(now, nullptr);
            if (room.is_pulse_due()) room.expose({});
            for (const RoomEvent &event : room.events())
                screen.take(event, event.kind == RoomEvent::Kind::pulse ? &picture : nullptr);
            room.forget_events();
        }
    }
    void press(RoomAction pedal)
    {
        ask(pedal, 1);
        run_for(500);
        ask(pedal, 0);
        run_for(100);
    }
    double shown_deg() const { return screen.status().picture_carm.primary_deg; }

    Room room;
    RoomScreen screen{room};
    std::uint32_t now = 0;
};

void before_the_first_pulse_the_place_is_that_of_the_c_arm(void **)
{
    PlaceBench bench;
    bench.ask(RoomAction::angles, 20'000);
    bench.run_for(4000);
    assert_true(bench.shown_deg() == 20.0);
}

void a_held_picture_keeps_the_place_of_its_pulse(void **)
{
    PlaceBench bench;
    bench.press(RoomAction::fluoro_pedal);
    bench.ask(RoomAction::angles, 20'000);
    bench.run_for(4000);
    assert_true(bench.screen.status().carm.primary_deg == 20.0);
    assert_true(bench.shown_deg() == 0.0);
    bench.press(RoomAction::fluoro_pedal);
    assert_true(bench.shown_deg() == 20.0);
}

void a_frame_of_a_run_keeps_the_place_of_its_pulse(void **)
{
    PlaceBench bench;
    bench.press(RoomAction::acquire_pedal);
    bench.ask(RoomAction::angles, 20'000);
    bench.run_for(4000);
    bench.press(RoomAction::fluoro_pedal);
    assert_true(bench.shown_deg() == 20.0);
    bench.ask(RoomAction::review, 2, 1, 3);
    bench.run_for(10);
    assert_true(bench.screen.status().source == ScreenSource::still);
    assert_true(bench.shown_deg() == 0.0);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(before_the_first_pulse_the_place_is_that_of_the_c_arm),
        cmocka_unit_test(a_held_picture_keeps_the_place_of_its_pulse),
        cmocka_unit_test(a_frame_of_a_run_keeps_the_place_of_its_pulse),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
