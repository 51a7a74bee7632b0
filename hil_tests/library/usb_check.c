/* This program tests the library libusb, as Debian ships it, with a loop-back device
 * (hil_tests/usb/usb_peer.h). The tests cover descriptors, refusals, the stream in both directions,
 * time-outs, cancelling, halts, and a device that disconnects itself. Prints TAP. */
#define _POSIX_C_SOURCE 200809L
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include <libusb-1.0/libusb.h>

#include "hil_tests/library/check.h"

enum {
    STREAM_OUT = 0x02,
    STREAM_IN = 0x82,
    STREAM_INTERFACE = 1,
    TIMEOUT_ms = 2000,
    REQUEST_MS_OS = 0x20,
    REQUEST_UNPLUG = 0x21,
    FLIGHT = 16,
    RATE_SECONDS = 1,
};

static libusb_context *usb;
static libusb_device_handle *device;
static unsigned char frame[1 << 14], back[1 << 14];

/* --- finding and opening --- */
static bool has_serial(libusb_device_handle *handle, uint8_t index, const char *serial)
{
    unsigned char text[64];
    if (serial == NULL) return true;
    const int length = libusb_get_string_descriptor_ascii(handle, index, text, sizeof text);
    return length == (int)strlen(serial) && memcmp(text, serial, (size_t)length) == 0;
}

static bool open_device(const char *serial)
{
    libusb_device **list;
    if (libusb_init(&usb) != 0) return false;
    const ssize_t count = libusb_get_device_list(usb, &list);
    device = NULL;
    for (ssize_t i = 0; i < count && device == NULL; i++) {
        struct libusb_device_descriptor descriptor;
        if (libusb_get_device_descriptor(list[i], &descriptor) != 0) continue;
        if (descriptor.idVendor != CHECK_VENDOR_ID || descriptor.idProduct != CHECK_PRODUCT_ID) continue;
        if (libusb_open(list[i], &device) != 0) continue;
        if (has_serial(device, descriptor.iSerialNumber, serial)) break;
        libusb_close(device);
        device = NULL;
    }
    if (count >= 0) libusb_free_device_list(list, 1);
    if (device != NULL) return true;
    libusb_exit(usb);
    return false;
}

static void close_device(void)
{
    libusb_close(device);
    libusb_exit(usb);
}

/* --- the stream --- */
static void make_frame(int length)
{
    for (int i = 0; i + 1 < length; i++) frame[i] = (unsigned char)(1 + (i * 7 + length) % 255);
    frame[length - 1] = 0;
}

/* Reads bytes until `length` bytes have arrived, and joins the results of short reads. */
static bool read_bytes(int length)
{
    int got = 0;
    while (got < length) {
        int count = 0;
        if (libusb_bulk_transfer(device, STREAM_IN, back + got, (int)sizeof back - got, &count, TIMEOUT_ms) !=
            0)
            return false;
        got += count;
    }
    return got == length;
}

static bool echo(int length)
{
    int count = 0;
    make_frame(length);
    if (libusb_bulk_transfer(device, STREAM_OUT, frame, length, &count, TIMEOUT_ms) != 0 || count != length)
        return false;
    return read_bytes(length) && memcmp(frame, back, (size_t)length) == 0;
}

static bool begin_stream(void)
{
    int count = 0;
    if (libusb_clear_halt(device, STREAM_OUT) != 0 || libusb_clear_halt(device, STREAM_IN) != 0) return false;
    return libusb_bulk_transfer(device, STREAM_IN, back, sizeof back, &count, TIMEOUT_ms) == 0 &&
           count == 1 && back[0] == 0;
}

static bool echo_many(void)
{
    static const int lengths[] = {2, 3, 63, 64, 65, 511, 512, 513, 1024, 4095, 4096, 5000};
    for (size_t i = 0; i < sizeof lengths / sizeof lengths[0]; i++) {
        if (echo(lengths[i])) continue;
        check_note("a frame of %d bytes did not come back", lengths[i]);
        return false;
    }
    return true;
}

static void round_trips(void)
{
    const int64_t begin = check_now_us(), end = begin + RATE_SECONDS * 1000000;
    int count = 0;
    while (check_now_us() < end && echo(64)) count++;
    const int64_t us = check_now_us() - begin;
    check(us >= RATE_SECONDS * 1000000 && count > 0, "round trips of 64 bytes go on for a second");
    check_note("link.roundtrips_per_s %lld", (long long)count * 1000000 / us);
}

/* --- several transfers in flight --- */
typedef struct flight {
    struct libusb_transfer *transfer;
    unsigned char bytes[512];
    bool is_done;
} flight;

static void LIBUSB_CALL on_done(struct libusb_transfer *transfer)
{
    flight *one = transfer->user_data;
    one->is_done = true;
}

static bool submit(flight *one, unsigned char endpoint, int length, unsigned timeout_ms)
{
    one->transfer = libusb_alloc_transfer(0);
    one->is_done = false;
    libusb_fill_bulk_transfer(one->transfer, device, endpoint, one->bytes, length, on_done, one, timeout_ms);
    return libusb_submit_transfer(one->transfer) == 0;
}

static bool await(const flight *one)
{
    const int64_t end = check_now_us() + 2 * TIMEOUT_ms * 1000;
    while (!one->is_done && check_now_us() < end) {
        struct timeval wait = {0, 100000};
        libusb_handle_events_timeout(usb, &wait);
    }
    return one->is_done;
}

static enum libusb_transfer_status finish(flight *one)
{
    await(one);
    const enum libusb_transfer_status status = one->is_done ? one->transfer->status : LIBUSB_TRANSFER_ERROR;
    if (one->is_done) libusb_free_transfer(one->transfer);
    return status;
}

/* The test keeps sixteen writes and sixteen reads pending at the same time; the bytes must come back in
 * order. */
static bool fly(void)
{
    static flight out[FLIGHT], in[FLIGHT];
    bool good = true;
    int got = 0;
    for (int i = 0; i < FLIGHT; i++) {
        memset(out[i].bytes, 'a' + i, 100);
        out[i].bytes[99] = 0;
        good = good && submit(&in[i], STREAM_IN, 512, TIMEOUT_ms) &&
               submit(&out[i], STREAM_OUT, 100, TIMEOUT_ms);
    }
    for (int i = 0; i < FLIGHT; i++) good = finish(&out[i]) == LIBUSB_TRANSFER_COMPLETED && good;
    for (int i = 0; i < FLIGHT && got < 100 * FLIGHT; i++) {
        if (!await(&in[i])) return false;
        memcpy(back + got, in[i].bytes, (size_t)in[i].transfer->actual_length);
        got += in[i].transfer->actual_length;
    }
    for (int i = 0; i < FLIGHT; i++) libusb_cancel_transfer(in[i].transfer);
    for (int i = 0; i < FLIGHT; i++) finish(&in[i]);
    for (int i = 0; i < FLIGHT; i++) good = good && memcmp(back + 100 * i, out[i].bytes, 100) == 0;
    return good && got == 100 * FLIGHT;
}

/* --- one check each --- */
static bool is_described_rightly(void)
{
    struct libusb_config_descriptor *configuration;
    bool good = libusb_get_active_config_descriptor(libusb_get_device(device), &configuration) == 0;
    if (!good) return false;
    good = configuration->bNumInterfaces == 2 &&
           configuration->interface[0].altsetting[0].bInterfaceClass == 3 &&
           configuration->interface[1].altsetting[0].bInterfaceClass == 0xff &&
           configuration->interface[1].altsetting[0].bNumEndpoints == 2;
    libusb_free_config_descriptor(configuration);
    return good;
}

static bool refuses_and_goes_on(void)
{
    unsigned char bytes[8];
    const int refused = libusb_control_transfer(device, 0xc0, 0x77, 0, 0, bytes, sizeof bytes, TIMEOUT_ms);
    const int status = libusb_control_transfer(device, 0x80, 0, 0, 0, bytes, 2, TIMEOUT_ms);
    return refused == LIBUSB_ERROR_PIPE && status == 2;
}

static bool has_microsoft_descriptors(void)
{
    unsigned char bytes[512];
    return libusb_control_transfer(device, 0xc0, REQUEST_MS_OS, 0, 7, bytes, sizeof bytes, TIMEOUT_ms) == 178;
}

static bool times_out(void)
{
    int count = 0;
    const int64_t begin = check_now_us();
    const int result = libusb_bulk_transfer(device, STREAM_IN, back, 512, &count, 200);
    const int64_t ms = (check_now_us() - begin) / 1000;
    check_note("a time-out of 200 ms took %lld ms", (long long)ms);
    return result == LIBUSB_ERROR_TIMEOUT && ms >= 199;
}

static bool cancels(void)
{
    flight one;
    if (!submit(&one, STREAM_IN, 512, 0)) return false;
    return libusb_cancel_transfer(one.transfer) == 0 && finish(&one) == LIBUSB_TRANSFER_CANCELLED;
}

static bool recovers_from_a_halt(void)
{
    int count = 0;
    if (libusb_control_transfer(device, 0x02, 3, 0, STREAM_IN, NULL, 0, TIMEOUT_ms) != 0) return false;
    if (libusb_bulk_transfer(device, STREAM_IN, back, 512, &count, TIMEOUT_ms) != LIBUSB_ERROR_PIPE)
        return false;
    return begin_stream() && echo(700);
}

/* After a device has returned to the bus, programs can list it before they can open it. A device that returns
 * to the bus appears in the bus's table first. The access rights of the device's node, and at test level L2
 * also the program that answers for the device, are ready only later. A program that finds the device but
 * gets no answer therefore searches for the device again.
 * */
static bool answers(void)
{
    return libusb_claim_interface(device, STREAM_INTERFACE) == 0 && begin_stream() && echo(64);
}

/* The device disconnects itself from the bus for 300 ms; a new search must find it within 10 s. */
static bool comes_back(const char *serial)
{
    int count = 0;
    if (libusb_control_transfer(device, 0x40, REQUEST_UNPLUG, 300, 0, NULL, 0, TIMEOUT_ms) != 0) return false;
    const int64_t begin = check_now_us(), end = begin + 10000000;
    int result = 0;
    while (result != LIBUSB_ERROR_NO_DEVICE && check_now_us() < end) {
        result = libusb_bulk_transfer(device, STREAM_IN, back, 512, &count, 50);
        if (result == LIBUSB_ERROR_IO || result == LIBUSB_ERROR_PIPE) break; /* it is leaving the bus */
    }
    check_note("gone after %lld ms: %s", (long long)(check_now_us() - begin) / 1000,
               libusb_error_name(result));
    const bool is_gone = result != 0 && result != LIBUSB_ERROR_TIMEOUT;
    close_device();
    if (!is_gone) return false;
    int tries = 0;
    bool is_back = false;
    while (!is_back && check_now_us() < end) {
        const struct timespec pause = {0, 20000000};
        nanosleep(&pause, NULL);
        if (check_now_us() < begin + 300000 || !open_device(serial)) continue;
        tries++;
        is_back = answers();
        if (!is_back) close_device();
    }
    check_note("%s after %lld ms, in try %d", is_back ? "back" : "not back",
               (long long)(check_now_us() - begin) / 1000, tries);
    return is_back;
}

int main(int argc, char **argv)
{
    const char *serial = check_serial(argc, argv);
    if (!check(open_device(serial), "the device is found and opened")) return check_end();
    check(is_described_rightly(), "two interfaces: HID and vendor");
    check(refuses_and_goes_on(), "a refused request gives PIPE and the next one is answered");
    check(has_microsoft_descriptors(), "the Microsoft descriptor set has 178 bytes");
    check(libusb_claim_interface(device, STREAM_INTERFACE) == 0, "the stream's interface is claimed");
    check(begin_stream(), "a stream begins with a zero");
    check(echo_many(), "frames of every length around a packet come back");
    check(fly(), "sixteen transfers each way are in flight at once");
    check(begin_stream(), "and a new stream begins");
    check(times_out(), "a read without data times out");
    check(cancels(), "a read without data is cancelled");
    check(recovers_from_a_halt(), "a halted endpoint gives PIPE and is cleared");
    round_trips();
    const bool is_back = comes_back(serial);
    check(is_back, "the device unplugs itself and comes back");
    if (is_back) close_device();
    return check_end();
}
