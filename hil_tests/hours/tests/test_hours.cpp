// These tests run a device for seconds of simulated time as `make hours` does for a day: the clocks begin a
// few seconds before the device's microseconds wrap, and every kind of disturbance comes. Every count of the
// device must equal that of the simulated hardware, and the judge must notice what it is there for.
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <unistd.h>

#include "hil_tests/cases/cases.hpp"
#include "hil_tests/hours/board.hpp"
#include "hil_tests/hours/campaign.hpp"
#include "hil_tests/hours/emulated_board.hpp"

extern "C" {
#include <cmocka.h>
}

namespace
{

namespace fs = std::filesystem;

constexpr std::uint64_t wrap_ms = (UINT64_C(1) << 32) / 1000; // of the device's clock
constexpr std::uint32_t element_um = 8000;

const soak::Catalogue &free_space()
{
    static const soak::Catalogue catalogue = [] {
        soak::Catalogue made =
            soak::read_catalogue({""}, "shared/examples/instruments", "shared/examples/stents");
        hours::coarsen(made, element_um);
        return made;
    }();
    return catalogue;
}

hours::Plan plan_of(hours::Disturbance disturbance)
{
    hours::Plan plan = hours::draw_plan(free_space(), 1, 0, 5);
    plan.disturbance = disturbance;
    plan.run_ms = 1500;
    plan.disturb_ms = 700;
    plan.disturbed_ms = disturbance == hours::Disturbance::stall ? 20 : 200;
    plan.wraps_encoders = true;
    plan.is_repeated = true;
    return plan;
}

void assert_no_trouble(const hours::Ledger &ledger)
{
    if (!ledger.trouble.empty()) fail_msg("%s", ledger.trouble.c_str());
}

void every_disturbance_keeps_every_count(void **)
{
    hours::Board board({.seed = 5, .late_every = 300, .begin_ms = wrap_ms - 4000});
    std::uint64_t ticks = 0, late = 0;
    for (int k = 0; k < static_cast<int>(hours::Disturbance::count); k++) {
        const hours::Played played =
            hours::play(board, free_space(), plan_of(static_cast<hours::Disturbance>(k)));
        assert_no_trouble(board.look());
        assert_int_equal(played.faults_unplanned, 0);
        assert_true(played.repeated_ticks > 500);
        ticks += played.ticks;
        late += played.late_ticks;
    }
    const hours::Ledger &ledger = board.look();
    assert_int_equal(ledger.edges, ledger.edges_done);
    assert_int_equal(ledger.us_wraps, 1);
    assert_true(ledger.frame_wraps > 5);
    assert_int_equal(ledger.frames_missed, 0);
    assert_int_equal(ledger.reports_lost, 0);
    assert_true(ledger.drift_ms < 1.0);
    assert_int_equal(ledger.restarts, 1);
    // What the processor made late, the device noticed, and told the host, except for ticks lost with the
    // cable.
    assert_true(ledger.overruns_given > 20);
    assert_int_equal(ledger.overruns, ledger.overruns_given);
    assert_true(late <= ledger.overruns && late + 5 >= ledger.overruns);
    assert_true(ticks <= ledger.ticks && ticks + 5 >= ledger.ticks);
}

// The board's check of its timer against the frames of USB allows 6 %; both crystals together differ by 0.01
// %.
void ticks_and_frames_differ_by_what_the_crystals_make(void **)
{
    hours::Board board({.seed = 2});
    board.pass_ms(100000);
    const hours::Ledger ledger = board.look();
    assert_no_trouble(ledger);
    const double ppm = (static_cast<double>(ledger.edges) - static_cast<double>(ledger.frames)) / 1e5 * 1e6;
    if (ppm < 1.0 || ppm > 1.0 * hours::crystals_ppm) fail_msg("%.1f ppm", ppm);
    assert_int_equal(ledger.reports + 2 > ledger.edges, 1);
}

void a_device_without_late_ticks_has_no_overrun(void **)
{
    hours::Board board({.seed = 5, .late_every = 0});
    hours::play(board, free_space(), plan_of(hours::Disturbance::none));
    assert_no_trouble(board.look());
    assert_int_equal(board.look().overruns, 0);
}

// The rig's clock may have run for longer than half a turn of the microseconds, 35.8 minutes, when the device
// gets its power.
void an_emulated_board_finds_a_halt_whatever_time_the_rig_has(void **)
{
    constexpr std::uint64_t half_a_turn_ms = wrap_ms / 2;
    hours::EmulatedBoard board(3, half_a_turn_ms + 300000);
    const hours::Played played = hours::play(board, free_space(), plan_of(hours::Disturbance::stall));
    assert_no_trouble(board.look());
    assert_int_equal(played.faults, 1);
    assert_int_equal(played.faults_unplanned, 0);
}

// Somebody presses the stop button of this rig for one of its milliseconds.
class PressedBoard : public hours::Board
{
  public:
    explicit PressedBoard(std::uint32_t press_ms) : Board({.seed = 5}), press_ms_(press_ms) {}
    void pass_ms(std::uint32_t milliseconds) override
    {
        passed_ms_ += milliseconds;
        plant().emergency_stop = passed_ms_ == press_ms_;
        Board::pass_ms(milliseconds);
    }

  private:
    std::uint32_t press_ms_, passed_ms_ = 0;
};

// The host hears of a fault every 8 ms. A run that ends, or is disturbed, in between has still met that
// fault.
void a_fault_between_two_looks_of_the_host_is_found(void **)
{
    constexpr std::uint32_t set_up_ms = 3, run_ms = 1500;
    hours::Plan plan = plan_of(hours::Disturbance::none);
    plan.wraps_encoders = false;
    PressedBoard at_end(set_up_ms + run_ms - 1);
    assert_int_equal(hours::play(at_end, free_space(), plan).faults_unplanned, 1);
    assert_no_trouble(at_end.look());

    plan.disturbance = hours::Disturbance::cable;
    PressedBoard before_disturbance(set_up_ms + plan.disturb_ms);
    const hours::Played played = hours::play(before_disturbance, free_space(), plan);
    assert_int_equal(played.faults_unplanned, 1);
}

hours::CampaignSettings short_campaign(const std::string &path, double seconds)
{
    hours::CampaignSettings settings;
    settings.hours = seconds / 3600.0;
    settings.seconds_max = 5;
    settings.long_every = 0;
    settings.warm_sessions = 1;
    settings.path = path;
    settings.key = "test";
    settings.shows_progress = false;
    return settings;
}

std::unique_ptr<hours::Station> make_board(std::uint64_t begin_ms)
{
    return std::make_unique<hours::Board>(hours::BoardSettings{.begin_ms = begin_ms});
}

// A later call, and a half-written row, cost nothing that was done.
void a_campaign_goes_on_where_it_stopped(void **)
{
    const fs::path folder = fs::temp_directory_path() / ("hours_" + std::to_string(getpid()));
    fs::create_directories(folder);
    const std::string path = (folder / "sessions.tsv").string();
    const hours::Sums first = hours::run_campaign(free_space(), short_campaign(path, 6), make_board);
    std::ofstream(path, std::ios::app) << "77\t12";
    hours::Sums second = hours::run_campaign(free_space(), short_campaign(path, 16), make_board);
    fs::remove_all(folder);
    assert_true(first.sessions >= 1 && second.sessions > first.sessions);
    assert_true(first.simulated_ms >= 6000 && second.simulated_ms >= 16000);
    assert_true(second.edges > first.edges);
    assert_int_equal(second.calls, 2);
    std::string why;
    second.leak_bytes = 0; // only the program itself runs without the library's kept blocks
    if (!hours::is_kept(second, why)) fail_msg("%s", why.c_str());
}

void every_broken_promise_is_told(void **)
{
    hours::Sums good;
    good.edges = good.edges_done = good.ticks = 1000000;
    std::string why;
    assert_true(hours::is_kept(good, why));
    good.stack_growth = 36; // an interrupt at the deepest place
    assert_true(hours::is_kept(good, why));
    const auto is_told = [&](auto change) {
        hours::Sums sums = good;
        change(sums);
        return !hours::is_kept(sums, why) && !why.empty();
    };
    assert_true(is_told([](hours::Sums &sums) { sums.broken = 1; }));
    assert_true(is_told([](hours::Sums &sums) { sums.edges_done--; }));
    assert_true(is_told([](hours::Sums &sums) { sums.overruns = 1; }));
    assert_true(is_told([](hours::Sums &sums) { sums.overruns = sums.overruns_given = 300; }));
    assert_true(is_told([](hours::Sums &sums) { sums.frames_missed = 1; }));
    assert_true(is_told([](hours::Sums &sums) { sums.drift_us = 1000; }));
    assert_true(is_told([](hours::Sums &sums) { sums.reports_lost = 1; }));
    assert_true(is_told([](hours::Sums &sums) { sums.leak_bytes = 16; }));
    assert_true(is_told([](hours::Sums &sums) { sums.leak_files = 1; }));
    assert_true(is_told([](hours::Sums &sums) { sums.stack_growth = 68; }));
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(every_disturbance_keeps_every_count),
        cmocka_unit_test(ticks_and_frames_differ_by_what_the_crystals_make),
        cmocka_unit_test(a_device_without_late_ticks_has_no_overrun),
        cmocka_unit_test(an_emulated_board_finds_a_halt_whatever_time_the_rig_has),
        cmocka_unit_test(a_fault_between_two_looks_of_the_host_is_found),
        cmocka_unit_test(a_campaign_goes_on_where_it_stopped),
        cmocka_unit_test(every_broken_promise_is_told),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
