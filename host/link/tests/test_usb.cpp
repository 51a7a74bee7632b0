// These tests check the following. A rig on USB gives the same results as a device in this process, bit for
// bit. Every unplugging, refusal, silence or false answer ends within a limited time with a message that
// gives the remedy, and no resource of libusb is leaked.
#include <algorithm>
#include <atomic>
#include <chrono>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <random>
#include <string>
#include <thread>

#include "host/base/output_files.hpp"
#include "host/link/tests/fake_usb.hpp"
#include "host/link/usb_transport.hpp"
#include "host/session/device.hpp"
#include <libusb-1.0/libusb.h>

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

namespace
{

constexpr crn::UsbLimits short_limits = {.read_ms = 100, .write_ms = 100};

int begin(void **)
{
    fake_usb::reset();
    return 0;
}

int end(void **)
{
    const bool is_clean = fake_usb::transfers() == 0 && fake_usb::contexts() == 0;
    fake_usb::reset();
    return is_clean ? 0 : -1; // transfers, handles or contexts were left behind
}

template <class Error = crn::LinkError>
void expect_error(const std::function<void()> &action, const std::vector<std::string> &parts)
{
    try {
        action();
    } catch (const Error &error) {
        for (const std::string &part : parts) {
            if (std::string(error.what()).find(part) == std::string::npos)
                fail_msg("'%s' does not hold '%s'", error.what(), part.c_str());
        }
        return;
    }
    fail_msg("no error, expected one with '%s'", parts.front().c_str());
}

void hello(const std::string &serial, const crn::UsbLimits &limits = short_limits)
{
    crn::UsbTransport pipe(serial, limits);
    crn::Link link(pipe);
    link.hello();
    link.read_status();
}

// --- sessions ---

crn::Instrument wire()
{
    crn::Instrument tool;
    tool.name = "wire";
    tool.length_m = 0.3;
    tool.table.axial_stiffness_max_N = 5000;
    tool.table.element_tip_um = 2000;
    tool.table.element_shaft_um = 4000;
    tool.table.element_fine_um = 20000;
    tool.table.knots_count = 2;
    crn_wire_knot knot{};
    knot.bend_stiffness_nN_m2 = 1000000;
    knot.twist_stiffness_nN_m2 = 800000;
    knot.mass_mg_per_m = 4000;
    knot.radius_outer_um = 445;
    knot.friction_kinetic_milli = 100;
    knot.friction_static_milli = 120;
    knot.rest_curvature1_per_m_milli = 20000;
    tool.table.knots[0] = tool.table.knots[1] = knot;
    tool.table.knots[1].arc_um = 300000;
    return tool;
}

crn::DeviceChoice usb_choice(const std::string &serial = "", std::uint32_t return_limit_ms = 5000)
{
    crn::DeviceChoice choice;
    choice.is_usb = true;
    choice.serial = serial;
    choice.return_limit_ms = return_limit_ms;
    return choice;
}

constexpr unsigned session_ticks = 2400, batch_ticks = 40;

// Runs a session and returns its last hash; `before_batch` may act on the simulated bus.
std::uint64_t play(const crn::DeviceChoice &choice, std::uint32_t &resumes,
                   const std::function<void(unsigned)> &before_batch = {})
{
    const crn::SceneFile scene = crn::read_scene("");
    crn::Device device(scene, {wire()}, crn::entry_of(scene, 1, {}), crn::host_rig(), choice);
    for (unsigned tick = 0; tick < session_ticks; tick += batch_ticks) {
        if (before_batch) before_batch(tick);
        std::vector<crn_wire_tick_input> inputs;
        for (unsigned i = tick; i < tick + batch_ticks; i++) {
            crn_wire_tick_input input{};
            input.hands_count = 1;
            input.hands[0] = {static_cast<std::int32_t>(i * 20), static_cast<std::int32_t>(i * 10)};
            inputs.push_back(input);
        }
        const auto states = device.step(inputs, tick % 400 == 0);
        assert_int_equal(states.size(), batch_ticks);
        assert_int_equal(states.back().tick, tick + batch_ticks);
    }
    std::uint64_t hash = 0;
    device.ask([&](crn::Link &link) { hash = link.read_hash64().hash; });
    resumes = device.resumes();
    return hash;
}

std::uint64_t sim_hash()
{
    std::uint32_t resumes;
    static const std::uint64_t hash = play({}, resumes);
    return hash;
}

void a_session_on_usb_has_the_hash_of_one_in_this_process(void **)
{
    std::uint32_t resumes = 1;
    fake_usb::add("RIG-0001");
    assert_true(play(usb_choice(), resumes) == sim_hash());
    assert_int_equal(resumes, 0);
}

// The test cuts the cable while the host sends its n-th byte, for many n. In some cases the device keeps its
// power while the cable is cut; in others the device loses its power.
void a_session_goes_on_bit_for_bit_after_every_cut(void **)
{
    unsigned total = 0;
    for (std::uint64_t cut = 700; cut < 47000; cut += 4201) {
        const bool loses_power = cut % 2 == 0;
        fake_usb::reset();
        fake_usb::Rig &rig = fake_usb::add("RIG-0001");
        bool is_armed = false;
        std::atomic<bool> is_over = false;
        std::thread hand([&] {
            while (!is_over) {
                bool is_out = false;
                fake_usb::change([&] {
                    is_out = !rig.is_plugged;
                    if (is_out && loses_power) crn_sim_reset(rig.sim);
                });
                std::this_thread::sleep_for(std::chrono::milliseconds(5));
                if (is_out) fake_usb::plug("RIG-0001");
            }
        });
        std::uint32_t resumes = 0;
        const std::uint64_t hash = play(usb_choice("RIG-0001"), resumes, [&](unsigned) {
            if (!is_armed) fake_usb::change([&] { rig.unplug_after_bytes = rig.out_bytes + cut; });
            is_armed = true;
        });
        is_over = true;
        hand.join();
        assert_true(hash == sim_hash());
        total += resumes;
    }
    assert_int_equal(total, 12);
}

void a_rig_that_stays_away_ends_the_session_with_its_tick(void **)
{
    std::uint32_t resumes;
    fake_usb::add("RIG-0001");
    expect_error(
        [&] {
            play(usb_choice("", 300), resumes, [](unsigned tick) {
                if (tick == 800) fake_usb::unplug("RIG-0001");
            });
        },
        {"went away at tick 800", "did not come back", "recording is complete", "Remedy"});
}

void another_rig_in_its_place_is_not_taken(void **)
{
    std::uint32_t resumes;
    fake_usb::add("RIG-0001");
    fake_usb::add("RIG-0002");
    fake_usb::unplug("RIG-0002");
    expect_error(
        [&] {
            play(usb_choice("RIG-0001", 300), resumes, [](unsigned tick) {
                if (tick != 800) return;
                fake_usb::unplug("RIG-0001");
                fake_usb::plug("RIG-0002");
            });
        },
        {"did not come back"});
}

// --- finding and opening ---

void rigs_are_told_apart_by_their_serial_numbers(void **)
{
    fake_usb::Rig &first = fake_usb::add("RIG-0001"), &second = fake_usb::add("RIG-0002");
    hello("RIG-0002");
    assert_true(first.out_bytes == 0 && second.out_bytes > 0);
    expect_error([] { hello(""); }, {"several rigs", "RIG-0001", "RIG-0002", "--device usb:SERIAL"});
    expect_error<crn::DeviceLost>([] { hello("RIG-0003"); }, {"'RIG-0003'", "RIG-0001", "RIG-0002"});
    const crn::UsbContext context = crn::usb_context();
    assert_int_equal(crn::usb_rigs(context.get()).size(), 2);
}

void both_rigs_work_at_the_same_time(void **)
{
    fake_usb::add("RIG-0001");
    fake_usb::add("RIG-0002");
    crn::UsbTransport one("RIG-0001", short_limits), two("RIG-0002", short_limits);
    crn::Link first(one), second(two);
    first.hello();
    second.hello();
    for (int i = 0; i < 20; i++) {
        first.read_status();
        second.read_status();
    }
}

void no_rig_is_told(void **)
{
    expect_error<crn::DeviceLost>([] { hello(""); },
                                  {"no rig is on USB", "1209:0001", "cable", "cournand rig list"});
}

void a_refusal_to_open_tells_the_fix(void **)
{
    fake_usb::Rig &rig = fake_usb::add("RIG-0001");
    rig.open_error = LIBUSB_ERROR_ACCESS;
    expect_error([] { hello(""); }, {"may not be opened by this user", "ACCESS", "sudo make install-udev"});
    const crn::UsbContext context = crn::usb_context();
    const auto rigs = crn::usb_rigs(context.get());
    assert_int_equal(rigs.size(), 1);
    assert_true(rigs[0].trouble.find("install-udev") != std::string::npos);
    rig.open_error = 0;
    rig.claim_error = LIBUSB_ERROR_BUSY;
    expect_error([] { hello(""); }, {"used by another program", "end that program"});
    rig.claim_error = 0;
    rig.has_stream = false;
    expect_error([] { hello(""); }, {"no vendor interface", "install this release's firmware"});
}

void two_hosts_do_not_share_a_rig(void **)
{
    fake_usb::add("RIG-0001");
    const crn::UsbTransport first("", short_limits);
    expect_error([] { hello(""); }, {"used by another program"});
}

void device_names_are_parsed(void **)
{
    assert_false(crn::parse_device("sim").is_usb);
    assert_true(crn::parse_device("usb").is_usb);
    assert_string_equal(crn::parse_device("usb:RIG-0001").serial.c_str(), "RIG-0001");
    for (const char *text : {"", "usb:", "hid", "USB", "usb RIG"})
        expect_error<crn::UsageError>([&] { crn::parse_device(text); }, {"usb:SERIAL"});
}

void a_rig_is_seen_coming(void **)
{
    for (const bool is_told : {true, false}) {
        fake_usb::set_hotplug(is_told);
        if (is_told) fake_usb::add("RIG-0001");
        fake_usb::unplug("RIG-0001");
        crn::UsbWatch watch;
        assert_true(watch.is_told() == is_told);
        assert_false(watch.wait_for("", 50, [] { return false; }));
        std::thread hand([] {
            std::this_thread::sleep_for(std::chrono::milliseconds(30));
            fake_usb::plug("RIG-0001");
        });
        const bool came = watch.wait_for("RIG-0001", 5000, [] { return false; });
        hand.join();
        assert_true(came);
        assert_false(watch.wait_for("RIG-0002", 5000, [] { return true; })); // Ctrl-C
    }
}

// --- silence, unplug, lies ---

void a_silent_rig_is_told_in_time(void **)
{
    fake_usb::Rig &rig = fake_usb::add("RIG-0001");
    rig.gives_bytes = false;
    expect_error([] { hello(""); }, {"does not answer", "hello_reply", "cable"});
    rig.gives_bytes = true;
    rig.takes_bytes = false;
    expect_error(
        [] {
            crn::UsbTransport pipe("", short_limits);
            const std::vector<std::uint8_t> bytes(1 << 20, 1);
            pipe.write(bytes);
        },
        {"took no bytes for 100 ms", "plug it out and in"});
}

// A device that does not answer the request for its name receives no further requests.
void a_rig_that_does_not_say_its_name_is_told(void **)
{
    fake_usb::add("RIG-0001").answers_control = false;
    const auto begin = std::chrono::steady_clock::now();
    const crn::UsbContext context = crn::usb_context();
    const auto rigs = crn::usb_rigs(context.get());
    assert_int_equal(rigs.size(), 1);
    assert_true(rigs[0].trouble.find("does not answer") != std::string::npos);
    assert_true(rigs[0].trouble.find("bus 1, address 4") != std::string::npos);
    expect_error([] { hello(""); }, {"does not answer", "Remedy"});
    assert_true(std::chrono::steady_clock::now() - begin < std::chrono::seconds(5)); // 0.7 s each
}

void an_unplugged_rig_ends_every_wait(void **)
{
    fake_usb::add("RIG-0001");
    crn::UsbTransport pipe("", {.read_ms = 10000, .write_ms = 10000});
    std::thread hand([] {
        std::this_thread::sleep_for(std::chrono::milliseconds(30));
        fake_usb::unplug("RIG-0001");
    });
    std::uint8_t bytes[16];
    const auto begin = std::chrono::steady_clock::now();
    expect_error<crn::DeviceLost>(
        [&] {
            while (pipe.read(bytes) < 100) {
            }
        },
        {"RIG-0001", "gone or started anew", "cable and power"});
    hand.join();
    assert_true(std::chrono::steady_clock::now() - begin < std::chrono::seconds(5));
    expect_error<crn::DeviceLost>([&] { pipe.write({bytes, 4}); }, {"gone"});
}

void a_longer_packet_than_fits_is_told(void **)
{
    fake_usb::add("RIG-0001").read_status = LIBUSB_TRANSFER_OVERFLOW;
    expect_error([] { hello(""); }, {"longer packet", "firmware"});
}

// The test damages the firmware's replies at random: each call must end with a LinkError or without an error.
void a_lying_rig_leaves_the_host_alive(void **)
{
    std::mt19937 random(1);
    unsigned errors = 0;
    for (int round = 0; round < 60; round++) {
        fake_usb::reset();
        fake_usb::Rig &rig = fake_usb::add("RIG-0001");
        rig.in_bytes_max = 1 + random() % 512;
        rig.spoil = [&random, round](std::vector<std::uint8_t> &bytes) {
            if (round % 3 == 0) bytes.assign(random() % 512, static_cast<std::uint8_t>(random()));
            if (round % 3 == 1 && !bytes.empty()) bytes[random() % bytes.size()] ^= 1 << random() % 8;
            if (round % 3 == 2) bytes.resize(random() % (bytes.size() + 1));
        };
        try {
            hello("", {.read_ms = 5, .write_ms = 100});
        } catch (const crn::LinkError &error) {
            errors++;
            assert_true(std::string(error.what()).size() > 20);
        }
    }
    assert_true(errors > 40);
}

// While the host does not read, the device must wait, and no byte that it sends may be lost.
void bytes_come_in_order_and_a_slow_host_holds_the_rig(void **)
{
    constexpr std::size_t total = 3 << 20;
    for (const std::uint32_t packet : {500u, 512u, 16384u}) {
        fake_usb::reset();
        fake_usb::Rig &rig = fake_usb::add("RIG-0001");
        rig.in_bytes_max = packet;
        rig.flood_bytes = total;
        crn::UsbTransport pipe("", {.read_ms = 2000, .write_ms = 300});
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
        std::size_t left = 0;
        fake_usb::change([&] { left = rig.flood_bytes; });
        assert_true(left >= total - (1 << 20)); // the transport keeps at most 1 MiB
        std::vector<std::uint8_t> bytes(5000);
        std::size_t got = 0;
        for (std::size_t count = 1; got < total && count > 0; got += count) {
            count = pipe.read(bytes);
            for (std::size_t i = 0; i < count; i++)
                if (bytes[i] != static_cast<std::uint8_t>((got + i) * 7))
                    fail_msg("byte %zu is wrong", got + i);
        }
        assert_int_equal(got, total);
        pipe.pass_time_ms(1); // from here on a read does not wait
        assert_int_equal(pipe.read(bytes), 0);
    }
}

} // namespace

#define USB_TEST(name) cmocka_unit_test_setup_teardown(name, begin, end)

int main()
{
    const CMUnitTest tests[] = {
        USB_TEST(a_session_on_usb_has_the_hash_of_one_in_this_process),
        USB_TEST(a_session_goes_on_bit_for_bit_after_every_cut),
        USB_TEST(a_rig_that_stays_away_ends_the_session_with_its_tick),
        USB_TEST(another_rig_in_its_place_is_not_taken),
        USB_TEST(rigs_are_told_apart_by_their_serial_numbers),
        USB_TEST(both_rigs_work_at_the_same_time),
        USB_TEST(no_rig_is_told),
        USB_TEST(a_refusal_to_open_tells_the_fix),
        USB_TEST(two_hosts_do_not_share_a_rig),
        USB_TEST(device_names_are_parsed),
        USB_TEST(a_rig_is_seen_coming),
        USB_TEST(a_silent_rig_is_told_in_time),
        USB_TEST(a_rig_that_does_not_say_its_name_is_told),
        USB_TEST(an_unplugged_rig_ends_every_wait),
        USB_TEST(a_longer_packet_than_fits_is_told),
        USB_TEST(a_lying_rig_leaves_the_host_alive),
        USB_TEST(bytes_come_in_order_and_a_slow_host_holds_the_rig),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
