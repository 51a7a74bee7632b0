// Claim: the board's port reports broken wiring that the simulated rig of the other levels cannot have,
// because that rig ends at the port's functions and not at pins.
#include "hil_tests/cases/conversation.hpp"
#include "hil_tests/cases/tube_scene.h"
#include "hil_tests/rt1062/bench/board_bench.hpp"
#include "host/link/link.hpp"
#include <csetjmp>
#include <cstdarg>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

extern "C" {
#include <cmocka.h>
}

namespace
{

std::string image()
{
    const char *build = std::getenv("BUILD");
    return std::string(build != nullptr ? build : "build") + "/firmware/cournand-imxrt1062.elf";
}

// The fault line's cable was broken before the power came. The PWM unit then keeps its outputs off, and there
// is no edge that could set its flag. The device must not arm its motors as if all were well.
void fault_line_that_was_cut_before_power_up_is_over_current(void **)
{
    std::string said;
    try {
        hil::BoardLevel level(image());
        const std::unique_ptr<hil::Bench> bench = level.make({});
        auto &board = dynamic_cast<hil::BoardBench &>(*bench);
        board.pins().cut_fault_line();
        bench->brown_out(10);
        try {
            crn::Link(bench->pipe()).hello();
        } catch (const crn::LinkError &) { // once: it has started again
        }
        bench->advance(100);
        crn::Link link(bench->pipe());
        hil::set_up(link);
        hil::start_free_run(*bench, link);
        hil::keep_running(link, 40);
        const crn_wire_status status = link.read_status();
        said = std::string("the device is ") + crn_wire_state_name(status.state) + ", fault " +
               crn_wire_fault_name(status.fault_code);
    } catch (const std::exception &error) {
        said = error.what();
    }
    const std::string refusal =
        "a check fails (detail: fault code) [" + std::to_string(CRN_FAULT_CODE_OVER_CURRENT);
    const bool is_told =
        said.find("OVER_CURRENT") != std::string::npos || said.find(refusal) != std::string::npos;
    if (!is_told) fail_msg("%s", said.c_str());
}

// A peripheral answers with bus errors while a motor pushes. The image ends its program, and must take the
// forces away although each of its ways to do so may be the one that is broken.
void bus_error_of_any_output_takes_the_forces_at_once(void **)
{
    for (const std::uint32_t broken : {BASE_GPIO1, BASE_GPIO2, BASE_PWM3}) {
        hil::BoardLevel level(image());
        const std::unique_ptr<hil::Bench> bench = level.make({});
        auto &board = dynamic_cast<hil::BoardBench &>(*bench);
        crn::Link link(bench->pipe());
        hil::set_up(link);
        crn_wire_rig rig = hil::plant_rig();
        rig.tracks[0].seal_mN = 2000; // a push is felt at once
        link.set_rig(rig);
        hil::start_free_run(*bench, link);
        hil::push_by_spring_hand(bench->plant());
        hil::keep_running(link, 64);
        assert_int_not_equal(bench->outputs().motors[0].axial_mN, 0);
        rt_fault fault{};
        fault.kind = RT_FAULT_BUS;
        fault.begin = rt_engine_chip(&board.engine())->now;
        fault.end = RT_NEVER;
        fault.address = broken;
        rt_fault_set(rt_engine_chip(&board.engine()), &fault);
        bench->advance(2); // one tick at most until the image meets the broken peripheral
        if (bench->outputs().motors[0].axial_mN != 0 || rt_engine_trouble(&board.engine())[0] != '\0')
            fail_msg("0x%08x: the motor is ordered to give %d mN; %s", broken,
                     bench->outputs().motors[0].axial_mN, rt_engine_trouble(&board.engine()));
        assert_false(bench->outputs().enable && broken != BASE_GPIO1);
    }
}

// In a vessel of 1.5 m, the whole J wire can lie: a tick of its 378 nodes takes the board more than a
// millisecond. In LOCKSTEP the host waits for it; in the short tube, most of the wire stays outside.
// Requirement: SR-27
void a_line_too_long_for_the_boards_millisecond_gets_no_free_run(void **)
{
    const hil_piece straight = {1.5, 0.0};
    std::vector<std::uint8_t> vessel(4u << 20);
    vessel.resize(hil_scene_of(&straight, 1, 0.002, 0, vessel.data(), vessel.size()));
    std::string said;
    crn_wire_reject reject{};
    try {
        hil::BoardLevel level(image());
        const std::unique_ptr<hil::Bench> bench = level.make({});
        crn::Link link(bench->pipe());
        hil::set_up(link);
        link.load_scene(vessel);
        link.arm();
        try {
            link.use_free_run();
        } catch (const crn::LinkError &error) {
            said = error.what();
            reject = error.reject;
        }
        link.start();
        const crn_wire_tick_input input = hil::sample_input(0);
        assert_int_equal(link.step({&input, 1}, false).size(), 1);
        link.reset();
        link.load_scene(hil::tube_scene());
        link.arm();
        assert_int_equal(link.use_free_run().mode, CRN_WIRE_MODE_FREE_RUN);
    } catch (const std::exception &error) {
        fail_msg("%s (after '%s')", error.what(), said.c_str());
    }
    if (reject.code != CRN_REJECT_TOO_SLOW || reject.detail1 <= 600000 || reject.detail2 != 600000 ||
        said.find("the emulated board refused command: TOO_SLOW") == std::string::npos)
        fail_msg("FREE_RUN: '%s'", said.c_str());
}

// The power stage is held by edges of the drive line. If the device's millisecond straddles the rig's, two
// edges may fall between two samples, which then have the same level.
void two_edges_of_the_drive_line_within_a_millisecond_hold_the_power_stage(void **)
{
    enum { GPIO2 = 1, DRIVE = 1 << 12 };
    const std::unique_ptr<rt_chip, decltype(&rt_chip_destroy)> chip(rt_chip_create(), rt_chip_destroy);
    rt_gpio_write(chip.get(), GPIO2, GPIO_GDIR, DRIVE);
    hil::RigPins pins(*chip);
    bool before = pins.outputs().drive;
    assert_int_equal(pins.outputs().drive, before); // no edge
    rt_gpio_write(chip.get(), GPIO2, GPIO_DR_SET, DRIVE);
    assert_int_equal(pins.outputs().drive, !before);
    before = pins.outputs().drive;
    rt_gpio_write(chip.get(), GPIO2, GPIO_DR_CLEAR, DRIVE);
    rt_gpio_write(chip.get(), GPIO2, GPIO_DR_SET, DRIVE);
    assert_int_equal(pins.outputs().drive, !before);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(two_edges_of_the_drive_line_within_a_millisecond_hold_the_power_stage),
        cmocka_unit_test(bus_error_of_any_output_takes_the_forces_at_once),
        cmocka_unit_test(fault_line_that_was_cut_before_power_up_is_over_current),
        cmocka_unit_test(a_line_too_long_for_the_boards_millisecond_gets_no_free_run),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
