// Tests runs that must wait: cine or DSA begins only when C-arm and table have reached the ordered pose, and
// until then the screen shows a notice. If the user releases the pedal while the run still waits, there must
// be no run, and a notice must give the reason. After every five minutes of fluoroscopy, a reminder must
// appear and stay until the user acknowledges the reminder.
#include "host/room/room_screen.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstring>
extern "C" {
#include <cmocka.h>
}

using namespace crn;

namespace
{

struct WaitBench {
    void ask(RoomAction action, std::int32_t a = 0, std::int32_t b = 0, std::int32_t c = 0)
    {
        assert_string_equal(room.give(now, {action, {a, b, c}}).c_str(), "");
    }
    // Runs the room through all ticks before tick `end`.
    void run_to(std::uint32_t end, const Eigen::Vector3d *tip = nullptr)
    {
        for (; now < end; ++now) {
            room.advance(now, tip);
            if (room.is_pulse_due()) room.expose({});
            const XrayPicture picture;
            for (const RoomEvent &event : room.events())
                screen.take(event, event.kind == RoomEvent::Kind::pulse ? &picture : nullptr);
            room.forget_events();
            if (room.is_beam_on() && screen.status().kind != RunKind::fluoro && begin_tick == 0)
                begin_tick = now;
        }
    }
    bool notice_has(const char *text) const
    {
        return std::strstr(screen.status().notice.c_str(), text) != nullptr;
    }

    Room room;
    RoomScreen screen{room};
    std::uint32_t now = 0, begin_tick = 0; // of the first run
};

// The session, if it ended now, has refused one request, for this reason.
void check_refused(const WaitBench &bench, const char *why)
{
    assert_int_equal(bench.room.refusals().size(), 1);
    assert_non_null(std::strstr(bench.room.refusals()[0].why.c_str(), why));
}

// The C-arm turns by 30 degrees in 1.2 s + 0.625 s, because its speed is 25 degrees/s and its acceleration is
// 40 degrees/s^2. The test commands this turn of the C-arm at tick 1, so the run must begin at tick 1826 or
// 1827.
void check_waits(std::int32_t program)
{
    WaitBench bench;
    bench.run_to(1);
    bench.ask(RoomAction::angles, 30'000);
    bench.run_to(500);
    bench.ask(RoomAction::program, program);
    bench.ask(RoomAction::acquire_pedal, 1);
    bench.run_to(502);
    assert_true(bench.notice_has("WAITS - the C-arm or the table is moving"));
    bench.run_to(3000);
    assert_in_range(bench.begin_tick, 1820, 1830);
    assert_true(bench.screen.status().carm.primary_deg == 30.0); // not stopped on its path
    bench.ask(RoomAction::acquire_pedal, 0);
    bench.run_to(3100);
    assert_int_equal(bench.screen.store().runs().size(), 1);
    assert_true(bench.room.refusals().empty());
}

} // namespace

static void dsa_waits_for_the_motors_and_they_reach_their_target(void **)
{
    check_waits(1);
}

static void cine_waits_for_the_motors_and_they_reach_their_target(void **)
{
    check_waits(0);
}

static void a_pedal_that_goes_up_too_early_makes_no_run_and_the_room_says_why(void **)
{
    WaitBench bench;
    bench.run_to(1);
    bench.ask(RoomAction::table, 100'000, 0, 0);
    bench.run_to(100);
    bench.ask(RoomAction::program, 1);
    bench.ask(RoomAction::acquire_pedal, 1);
    bench.run_to(300);
    bench.ask(RoomAction::acquire_pedal, 0);
    bench.run_to(301);
    assert_true(bench.notice_has("NO DSA RUN - the pedal went up"));
    bench.run_to(5000);
    assert_int_equal(bench.screen.store().runs().size(), 0);
    assert_true(bench.room.dose().irradiations().empty());
    assert_int_equal(bench.room.refusals().size(), 1);
    assert_int_equal(bench.room.refusals()[0].tick, 300);
    assert_non_null(std::strstr(bench.room.refusals()[0].why.c_str(), "hold the pedal longer"));
}

// Nobody is left without a word: a session that ends while a run waits, a pedal that goes up in the
// millisecond in which it went down, and a run that is ordered while the pedal of another program's run is
// still down.
static void a_run_that_still_waits_when_the_session_ends_is_refused(void **)
{
    WaitBench bench;
    bench.run_to(1);
    bench.ask(RoomAction::table, 100'000, 0, 0);
    bench.run_to(100);
    bench.ask(RoomAction::program, 1);
    bench.ask(RoomAction::acquire_pedal, 1);
    check_refused(bench, "NO RUN - the session ended at the moment");
    bench.run_to(300);
    check_refused(bench, "NO DSA RUN - the session ended while the C-arm or the table was still moving");
    bench.run_to(3000);
    assert_true(bench.room.refusals().empty()); // the run has begun
    assert_int_equal(bench.screen.store().runs().size(), 1);
}

static void a_pedal_that_goes_up_at_once_makes_no_run_and_the_room_says_why(void **)
{
    WaitBench bench;
    bench.run_to(10);
    bench.ask(RoomAction::program, 1);
    bench.ask(RoomAction::acquire_pedal, 1);
    bench.ask(RoomAction::acquire_pedal, 0);
    bench.run_to(12);
    assert_true(bench.notice_has("NO DSA RUN - the pedal went up at the moment"));
    bench.run_to(500);
    assert_int_equal(bench.screen.store().runs().size(), 0);
    check_refused(bench, "hold the pedal while the run lasts");
}

static void a_run_ordered_during_the_run_of_another_program_is_refused(void **)
{
    WaitBench bench;
    bench.run_to(10);
    bench.ask(RoomAction::acquire_pedal, 1); // cine
    bench.run_to(500);
    bench.ask(RoomAction::acquire_pedal, 1); // again the same: the run simply goes on
    bench.run_to(600);
    assert_true(bench.room.refusals().empty());
    bench.ask(RoomAction::program, 1);
    bench.ask(RoomAction::acquire_pedal, 1);
    bench.run_to(700);
    assert_true(bench.notice_has("NO DSA RUN - the pedal is still down for another run"));
    check_refused(bench, "release it first, then press it again");
    assert_true(bench.screen.status().kind == RunKind::cine && bench.room.is_beam_on());
}

// A run that was made must not count as refused; nor must a run that was requested while the motors were at
// rest.
static void a_pedal_on_a_room_that_stands_is_never_refused(void **)
{
    WaitBench bench;
    bench.run_to(10);
    for (int run = 0; run < 2; ++run) {
        bench.ask(RoomAction::acquire_pedal, 1);
        bench.run_to(bench.now + 300);
        bench.ask(RoomAction::acquire_pedal, 0);
        bench.run_to(bench.now + 300);
    }
    assert_int_equal(bench.screen.store().runs().size(), 2);
    assert_true(bench.room.refusals().empty());
}

static void fluoroscopy_goes_on_while_a_run_waits(void **)
{
    WaitBench bench;
    bench.run_to(1);
    bench.ask(RoomAction::fluoro_pedal, 1);
    bench.ask(RoomAction::angles, 30'000);
    bench.run_to(400);
    bench.ask(RoomAction::acquire_pedal, 1);
    bench.run_to(1700);
    assert_true(bench.room.is_beam_on() && bench.screen.status().kind == RunKind::fluoro);
    bench.run_to(2000);
    assert_true(bench.room.is_beam_on() && bench.screen.status().kind == RunKind::cine);
}

// In this test the tip of the tools keeps moving, and the table follows it for ever. The table must stop so
// that a cine run can start, and must follow the tip again during the run.
static void a_table_that_follows_a_tip_comes_to_rest_for_a_run(void **)
{
    WaitBench bench;
    bench.ask(RoomAction::follow, 1);
    Eigen::Vector3d tip(0.0, 0.0, 0.0);
    bench.run_to(1, &tip);
    for (; bench.now < 4000 && bench.begin_tick == 0;) {
        tip.y() += 0.1e-3; // 100 mm/s
        bench.run_to(bench.now + 1, &tip);
        if (bench.now == 1500) bench.ask(RoomAction::acquire_pedal, 1);
    }
    assert_in_range(bench.begin_tick, 1500, 3500);
}

static void five_minutes_of_fluoroscopy_are_reminded_of_until_acknowledged(void **)
{
    WaitBench bench;
    bench.run_to(1);
    bench.ask(RoomAction::fluoro_rate, 375);
    bench.ask(RoomAction::fluoro_pedal, 1);
    bench.run_to(300'000);
    assert_false(bench.room.dose().has_unseen_reminder());
    bench.run_to(300'002);
    assert_true(bench.room.dose().has_unseen_reminder() && bench.notice_has("FLUOROSCOPY 5 MIN"));
    bench.run_to(310'000);
    assert_true(bench.room.dose().has_unseen_reminder());
    bench.ask(RoomAction::acknowledge);
    bench.run_to(310'001);
    assert_false(bench.room.dose().has_unseen_reminder());
    bench.run_to(600'002);
    assert_true(bench.room.dose().has_unseen_reminder() && bench.notice_has("FLUOROSCOPY 10 MIN"));
}

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(dsa_waits_for_the_motors_and_they_reach_their_target),
        cmocka_unit_test(cine_waits_for_the_motors_and_they_reach_their_target),
        cmocka_unit_test(a_pedal_that_goes_up_too_early_makes_no_run_and_the_room_says_why),
        cmocka_unit_test(a_run_that_still_waits_when_the_session_ends_is_refused),
        cmocka_unit_test(a_pedal_that_goes_up_at_once_makes_no_run_and_the_room_says_why),
        cmocka_unit_test(a_run_ordered_during_the_run_of_another_program_is_refused),
        cmocka_unit_test(a_pedal_on_a_room_that_stands_is_never_refused),
        cmocka_unit_test(fluoroscopy_goes_on_while_a_run_waits),
        cmocka_unit_test(a_table_that_follows_a_tip_comes_to_rest_for_a_run),
        cmocka_unit_test(five_minutes_of_fluoroscopy_are_reminded_of_until_acknowledged),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
