// This test exercises the USB interface of the firmware image with single USB tokens. The device must
// enumerate, accept its configuration, and answer HELLO through the pair of bulk endpoints. The device must
// also keep its messages while the bus is suspended, and its clock must count the time that USB requests take
// as working time.
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <span>
#include <string>
#include <unistd.h>
#include <vector>

#include "host/link/emulator.hpp"
#include "shared/wire/wire_frame.h"

#define _Static_assert static_assert // for the C headers below
extern "C" {
#include "hil_tests/usb/usb_host.h"
#include <cmocka.h>
}
#undef _Static_assert

namespace
{

constexpr std::uint8_t stream = 2; // number of the bulk pair's endpoints
constexpr int looks_max = 200000;  // some 10 s

struct Patience {
    int looks = 0;
};

bool wait_a_little(void *context)
{
    auto *patience = static_cast<Patience *>(context);
    usleep(50);
    return ++patience->looks < looks_max;
}

void begin_wait(void *context)
{
    static_cast<Patience *>(context)->looks = 0;
}

void expect(usb_result result, const char *what)
{
    if (result != USB_OK) fail_msg("%s: %s", what, usb_result_name(result));
}

// Runs a device in the emulator, with a configured host on its USB side.
class Session
{
  public:
    Session() : emulator(options())
    {
        crn_wire_decoder_init(&decoder);
        host.mailbox = reinterpret_cast<crn_mailbox *>(emulator.memory());
        host.wait = wait_a_little;
        host.begin_wait = begin_wait;
        host.context = &patience_;
        host.packet_bytes = 64;
        host.naks_max = 20000;
    }

    static crn::EmulatorOptions options()
    {
        crn::EmulatorOptions options;
        options.icount_shift = 0;
        options.serial = "AN500-0042";
        return options;
    }

    void configure()
    {
        const usb_request address = {0, 5, 5, 0, 0}, configure = {0, 9, 1, 0, 0};
        std::uint32_t count = 0;
        assert_true(usb_host_sees_device(&host));
        expect(usb_host_bus(&host, CRN_MAILBOX_RESET_HIGH), "reset of the bus");
        expect(usb_host_control(&host, &address, nullptr, &count), "SET_ADDRESS");
        host.address = 5;
        expect(usb_host_control(&host, &configure, nullptr, &count), "SET_CONFIGURATION");
    }

    std::vector<std::uint8_t> framed(std::uint16_t type, std::span<const std::uint8_t> payload)
    {
        std::vector<std::uint8_t> frame(256);
        const crn_wire_header header = {++sequence_, 0, type};
        frame.resize(
            crn_wire_frame_encode(&header, payload.data(), payload.size(), frame.data(), frame.size()));
        return frame;
    }

    std::vector<std::uint8_t> framed_hello()
    {
        const crn_wire_hello hello = {CRN_WIRE_PROTOCOL_MAJOR, CRN_WIRE_PROTOCOL_MINOR,
                                      crn_wire_schema_hash()};
        std::uint8_t payload[64];
        crn_wire_writer writer = crn_wire_writer_make(payload, sizeof payload);
        assert_true(crn_wire_put_hello(&writer, &hello));
        return framed(CRN_WIRE_TYPE_hello, {payload, writer.length});
    }

    void write_usb(const std::vector<std::uint8_t> &frame)
    {
        expect(usb_host_out(&host, stream, 512, frame.data(), static_cast<std::uint32_t>(frame.size())),
               "a frame to the device");
    }

    // Sends the frame through the ring buffers in the memory page of the emulated rig, and waits until the
    // device has read it.
    void write_page(const std::vector<std::uint8_t> &frame)
    {
        rig_page &page = emulator.page();
        std::uint32_t head = page.host.to_device_head;
        for (const std::uint8_t byte : frame) page.to_device[head++ % RIG_RING_BYTES] = byte;
        rig_write(&page.host.to_device_head, head);
        emulator.wait([&] { return rig_read(&page.device.to_device_tail) == head; }, "a request");
    }

    // Checks that the next frame that arrives over USB has the message type `type`, and leaves this frame in
    // the decoder.
    void expect_frame(std::uint16_t type)
    {
        for (int packets = 0; packets < 8; packets++) {
            std::uint8_t packet[512];
            std::uint32_t count = 0;
            expect(usb_host_packet_in(&host, stream, packet, sizeof packet, &count), "an answer");
            for (std::uint32_t i = 0; i < count; i++) {
                if (crn_wire_decoder_push(&decoder, packet[i]) != CRN_WIRE_FRAME) continue;
                assert_int_equal(decoder.header.type, type);
                return;
            }
        }
        fail_msg("no frame in 8 packets");
    }

    crn::Emulator emulator;
    usb_host host{};
    crn_wire_decoder decoder{};

  private:
    Patience patience_;
    std::uint16_t sequence_ = 0;
};

void the_image_answers_hello_over_usb(void **)
{
    Session session;
    session.configure();
    const std::string serial = Session::options().serial;
    std::uint8_t descriptor[64];
    std::uint32_t count = 0;
    const usb_request get_device = {0x80, 6, 0x0100, 0, 18}, get_serial = {0x80, 6, 0x0303, 0x0409, 64};
    expect(usb_host_control(&session.host, &get_device, descriptor, &count), "device descriptor");
    assert_int_equal(count, 18);
    expect(usb_host_control(&session.host, &get_serial, descriptor, &count), "serial number");
    assert_int_equal(count, 2 + 2 * serial.size());
    for (std::size_t i = 0; i < serial.size(); i++) assert_int_equal(descriptor[2 + 2 * i], serial[i]);
    session.write_usb(session.framed_hello());
    session.expect_frame(CRN_WIRE_TYPE_hello_reply);
    crn_wire_hello_reply reply;
    assert_true(crn_wire_decode_hello_reply(session.decoder.payload, session.decoder.payload_bytes, &reply));
    assert_int_equal(reply.accepted, 1);
}

// The device's messages must wait while the bus is suspended, until the host resumes the bus.
void a_sleeping_bus_keeps_what_the_app_says(void **)
{
    Session session;
    session.configure();
    session.write_usb(session.framed_hello());
    session.expect_frame(CRN_WIRE_TYPE_hello_reply);
    const std::uint32_t said = rig_read(&session.emulator.page().device.to_host_head);
    expect(usb_host_bus(&session.host, CRN_MAILBOX_SUSPENDED), "suspend");
    const std::uint8_t get[] = {CRN_WIRE_GET_STATUS};
    session.write_page(session.framed(CRN_WIRE_TYPE_get, get));
    assert_int_equal(rig_read(&session.emulator.page().device.to_host_head), said);
    expect(usb_host_bus(&session.host, CRN_MAILBOX_RESUMED), "resume");
    session.expect_frame(CRN_WIRE_TYPE_status);
    assert_int_equal(session.decoder.header.answers, 2);
}

// If the simulated rig (plant) controls time, the device's clock does not advance while the device waits. A
// request takes the same time on the device's clock whether it arrived over USB or through the ring buffers.
void work_that_comes_by_usb_takes_the_plants_time(void **)
{
    Session session;
    session.configure();
    session.write_usb(session.framed_hello());
    session.expect_frame(CRN_WIRE_TYPE_hello_reply);
    const rig_device_half &device = session.emulator.page().device;
    const std::uint32_t idle_us = rig_read(&device.clock_us), idle_counts = rig_read(&device.receive_counts);
    usleep(20000);
    assert_int_equal(rig_read(&device.clock_us), idle_us);
    session.write_usb(session.framed_hello());
    session.expect_frame(CRN_WIRE_TYPE_hello_reply);
    const std::uint32_t counts = rig_read(&device.receive_counts) - idle_counts,
                        us = rig_read(&device.clock_us) - idle_us;
    std::printf("# HELLO over USB: %u us, %.0f instructions\n", us, session.emulator.instructions(counts));
    assert_in_range(us, 2, 200);
    assert_in_range(counts * (1000000 / 1000) / (RIG_CLOCK_HZ / 1000), us - 1, us + 1);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(the_image_answers_hello_over_usb),
        cmocka_unit_test(a_sleeping_bus_keeps_what_the_app_says),
        cmocka_unit_test(work_that_comes_by_usb_takes_the_plants_time),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
