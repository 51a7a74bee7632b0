/* This program makes a device visible to a guest machine in QEMU: it translates between the device's USB
 * tokens and the protocol usbredir on a unix socket.
 *
 *   bridge SOCKET [--full-speed] DEVICE
 *
 *   --here                     the loop-back rig, in this process
 *   --app                      the whole app, in this process
 *   --mailbox FILE[:OFFSET]    whatever serves the mailbox in FILE
 *
 * The program waits for QEMU to connect (`-chardev socket,path=SOCKET -device usb-redir`), and ends when QEMU
 * disconnects. The device may disconnect itself, restart, and connect again at any time. The exit code is
 * normally 0. The exit code is 1 if the device hangs, and 2 if the arguments are wrong. */
#define _GNU_SOURCE /* ppoll */
#include <errno.h>
#include <poll.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include <usbredirparser.h>

#include "hil_tests/usb/usb_peer.h"
#include "hil_tests/usb/usb_urbs.h"

enum { CONNECT_SECONDS = 30, IDLE_us = 50, TALK_us = 400, STREAM = 2 };

typedef struct bridge {
    struct usbredirparser *parser;
    int socket;
    usb_peer peer;
    usb_urbs urbs;
    bool is_shown; /* device_connect was sent */
    bool is_dead;
    bool is_full_speed; /* a cable that carries 12 Mbit/s only */
    uint8_t configuration;
    uint8_t interfaces[USB_URBS_PIPES]; /* to which each endpoint belongs */
    int64_t stream_ns; /* end of the stream's last transfer: the next one follows soon, and waking up takes
                          time */
} bridge;

static uint8_t status_of(usb_result result)
{
    switch (result) {
    case USB_OK:
        return usb_redir_success;
    case USB_STALLED:
        return usb_redir_stall;
    case USB_BROKEN:
        return usb_redir_babble;
    default:
        return usb_redir_ioerror;
    }
}

static usb_result control(bridge *b, uint8_t type, uint8_t request, uint16_t value, uint16_t index,
                          uint16_t length, uint8_t *bytes, uint32_t *count)
{
    const usb_request setup = {type, request, value, index, length};
    uint32_t none;
    const usb_result result = usb_host_control(b->peer.host, &setup, bytes, count != NULL ? count : &none);
    if (result == USB_DEAD) b->is_dead = true;
    return result;
}

/* --- the device's descriptors, which usbredir reports to QEMU before the guest's requests --- */
static void cancel_all(bridge *b)
{
    usb_urb urb;
    while (usb_urbs_cancel_any(&b->urbs, &urb)) free(urb.bytes);
}

static bool address_device(bridge *b)
{
    cancel_all(b);
    b->configuration = 0;
    if (usb_host_bus(b->peer.host, b->is_full_speed ? CRN_MAILBOX_RESET_FULL : CRN_MAILBOX_RESET_HIGH) !=
        USB_OK)
        return false;
    if (control(b, 0x00, 5, 1, 0, 0, NULL, NULL) != USB_OK) return false;
    b->peer.host->address = 1;
    return true;
}

/* Fills usbredir's two tables with the interfaces and endpoints of the device's configuration. The bridge
 * reports interrupt endpoints to QEMU as bulk endpoints. If the bridge reported interrupt endpoints, usbredir
 * would read them as fast as this bridge can, and would collect data that the guest does not fetch. With bulk
 * endpoints, every read by the guest causes one read from the device. The guest's own USB controller (xHCI)
 * therefore sets the pace, as on a real cable. The guest reads the true type of the endpoints from the
 * device's descriptors. */
static void describe(bridge *b, const uint8_t *bytes, uint32_t count)
{
    struct usb_redir_interface_info_header interfaces;
    struct usb_redir_ep_info_header endpoints;
    memset(&interfaces, 0, sizeof interfaces);
    memset(&endpoints, 0, sizeof endpoints);
    memset(endpoints.type, usb_redir_type_invalid, sizeof endpoints.type);
    memset(b->urbs.packet_bytes, 0, sizeof b->urbs.packet_bytes);
    endpoints.type[0] = endpoints.type[16] = usb_redir_type_control;
    endpoints.max_packet_size[0] = endpoints.max_packet_size[16] = 64;
    uint8_t interface = 0;
    for (uint32_t place = 0; place + 2 <= count && bytes[place] >= 2 && place + bytes[place] <= count;
         place += bytes[place]) {
        const uint8_t *part = bytes + place;
        if (part[1] == 4 && part[0] >= 9 && interfaces.interface_count < 32) {
            const uint32_t i = interfaces.interface_count++;
            interface = interfaces.interface[i] = part[2];
            interfaces.interface_class[i] = part[5];
            interfaces.interface_subclass[i] = part[6];
            interfaces.interface_protocol[i] = part[7];
        } else if (part[1] == 5 && part[0] >= 7) {
            const unsigned pipe = usb_urbs_pipe(part[2]);
            const uint16_t packet_bytes = (uint16_t)(part[4] | part[5] << 8);
            endpoints.type[pipe] = usb_redir_type_bulk;
            endpoints.interval[pipe] = part[6];
            endpoints.interface[pipe] = b->interfaces[pipe] = interface;
            endpoints.max_packet_size[pipe] = packet_bytes;
            b->urbs.packet_bytes[pipe] = packet_bytes <= CRN_MAILBOX_DATA_MAX ? packet_bytes : 0;
        }
    }
    usbredirparser_send_interface_info(b->parser, &interfaces);
    usbredirparser_send_ep_info(b->parser, &endpoints);
}

static bool show(bridge *b)
{
    uint8_t device[18], configuration[1024];
    uint32_t device_count, count;
    if (!address_device(b)) return false;
    if (control(b, 0x80, 6, 0x0100, 0, sizeof device, device, &device_count) != USB_OK || device_count != 18)
        return false;
    if (control(b, 0x80, 6, 0x0200, 0, sizeof configuration, configuration, &count) != USB_OK) return false;
    describe(b, configuration, count);
    struct usb_redir_device_connect_header connect = {
        .speed = b->is_full_speed ? usb_redir_speed_full : usb_redir_speed_high,
        .device_class = device[4],
        .device_subclass = device[5],
        .device_protocol = device[6],
        .vendor_id = (uint16_t)(device[8] | device[9] << 8),
        .product_id = (uint16_t)(device[10] | device[11] << 8),
        .device_version_bcd = (uint16_t)(device[12] | device[13] << 8),
    };
    usbredirparser_send_device_connect(b->parser, &connect);
    b->is_shown = true;
    return true;
}

/* Informs the guest if the device was connected, disconnected or restarted since the last call. */
static void watch_plug(bridge *b)
{
    const usb_host *host = b->peer.host;
    const bool is_there = usb_host_sees_device(host);
    const bool is_same = crn_mailbox_read(&host->mailbox->device.boot_count) == host->boot_count;
    if (b->is_shown && (!is_there || !is_same)) {
        cancel_all(b);
        b->is_shown = false;
        usbredirparser_send_device_disconnect(b->parser);
        fprintf(stderr, "bridge: the device is gone\n");
    } else if (!b->is_shown && is_there) {
        fprintf(stderr, "bridge: a device %s\n", show(b) ? "is there" : "does not answer");
    }
}

/* --- requests of the guest --- */
static void on_reset(void *context)
{
    bridge *b = context;
    if (b->is_shown && !address_device(b)) fprintf(stderr, "bridge: no answer after a reset\n");
}

static void on_set_configuration(void *context, uint64_t id,
                                 struct usb_redir_set_configuration_header *header)
{
    bridge *b = context;
    uint8_t bytes[1024];
    uint32_t count = 0;
    cancel_all(b);
    const usb_result result = control(b, 0x00, 9, header->configuration, 0, 0, NULL, NULL);
    if (result == USB_OK) {
        b->configuration = header->configuration;
        memset(b->peer.host->toggle_in, 0, sizeof b->peer.host->toggle_in);
        memset(b->peer.host->toggle_out, 0, sizeof b->peer.host->toggle_out);
        if (control(b, 0x80, 6, 0x0200, 0, sizeof bytes, bytes, &count) == USB_OK) describe(b, bytes, count);
    }
    struct usb_redir_configuration_status_header answer = {status_of(result), b->configuration};
    usbredirparser_send_configuration_status(b->parser, id, &answer);
}

static void on_get_configuration(void *context, uint64_t id)
{
    bridge *b = context;
    uint8_t configuration = 0;
    uint32_t count = 0;
    const usb_result result = control(b, 0x80, 8, 0, 0, 1, &configuration, &count);
    struct usb_redir_configuration_status_header answer = {status_of(result), configuration};
    usbredirparser_send_configuration_status(b->parser, id, &answer);
}

/* The device begins again with DATA0 on every endpoint of the interface, so the host does. */
static void restart_endpoints(bridge *b, uint8_t interface)
{
    for (unsigned number = 1; number < 16; number++) {
        if (b->interfaces[number] == interface) b->peer.host->toggle_out[number] = false;
        if (b->interfaces[number | 0x10] == interface) b->peer.host->toggle_in[number] = false;
    }
}

static void on_set_alt_setting(void *context, uint64_t id, struct usb_redir_set_alt_setting_header *header)
{
    bridge *b = context;
    const usb_result result = control(b, 0x01, 11, header->alt, header->interface, 0, NULL, NULL);
    struct usb_redir_alt_setting_status_header answer = {status_of(result), header->interface, header->alt};
    if (result == USB_OK) restart_endpoints(b, header->interface);
    usbredirparser_send_alt_setting_status(b->parser, id, &answer);
}

static void on_get_alt_setting(void *context, uint64_t id, struct usb_redir_get_alt_setting_header *header)
{
    bridge *b = context;
    uint8_t setting = 0;
    uint32_t count = 0;
    const usb_result result = control(b, 0x81, 10, 0, header->interface, 1, &setting, &count);
    struct usb_redir_alt_setting_status_header answer = {status_of(result), header->interface, setting};
    usbredirparser_send_alt_setting_status(b->parser, id, &answer);
}

static void on_cancel(void *context, uint64_t id)
{
    bridge *b = context;
    usb_urb urb;
    if (!usb_urbs_cancel(&b->urbs, id, &urb)) return; /* it is done, and the answer is under way */
    struct usb_redir_bulk_packet_header answer = {.endpoint = urb.endpoint, .status = usb_redir_cancelled};
    usbredirparser_send_bulk_packet(b->parser, id, &answer, NULL, 0);
    free(urb.bytes);
}

static void on_control(void *context, uint64_t id, struct usb_redir_control_packet_header *header,
                       uint8_t *data, int data_bytes)
{
    bridge *b = context;
    static uint8_t bytes[1 << 16];
    uint32_t count = 0;
    usb_result result;
    const bool to_host = (header->requesttype & 0x80) != 0;
    if (data_bytes > 0) memcpy(bytes, data, (size_t)data_bytes);
    usbredirparser_free_packet_data(b->parser, data);
    if (!b->is_shown)
        result = USB_SILENT;
    else if (!to_host && data_bytes != header->length)
        result = USB_BROKEN;
    else if (header->requesttype == 0x02 && header->request == 1 && header->value == 0)
        result = usb_host_clear_halt(b->peer.host, (uint8_t)header->index);
    else
        result = control(b, header->requesttype, header->request, header->value, header->index,
                         header->length, bytes, &count);
    if (result == USB_DEAD) b->is_dead = true;
    header->status = status_of(result);
    header->length = (uint16_t)(to_host ? count : header->length);
    usbredirparser_send_control_packet(b->parser, id, header, count > 0 ? bytes : NULL, (int)count);
}

/* Begins one transfer of the guest; this program owns the transfer's buffer until the answer is sent. */
static bool submit(bridge *b, uint64_t id, uint8_t endpoint, uint32_t length, const uint8_t *data,
                   int data_bytes)
{
    uint8_t *bytes = length <= USB_URB_BYTES_MAX ? malloc(length + 1) : NULL;
    const bool is_whole = (endpoint & 0x80) != 0 || (uint32_t)data_bytes == length;
    if (bytes == NULL || !is_whole || !b->is_shown) {
        free(bytes);
        return false;
    }
    if ((endpoint & 0x80) == 0 && length > 0) memcpy(bytes, data, length);
    const usb_urb urb = {.id = id, .endpoint = endpoint, .bytes = bytes, .length = length};
    if (usb_urbs_submit(&b->urbs, &urb)) return true;
    free(bytes);
    return false;
}

static void on_bulk(void *context, uint64_t id, struct usb_redir_bulk_packet_header *header, uint8_t *data,
                    int data_bytes)
{
    bridge *b = context;
    const uint32_t length = header->length | (uint32_t)header->length_high << 16;
    const bool taken = submit(b, id, header->endpoint, length, data, data_bytes);
    usbredirparser_free_packet_data(b->parser, data);
    if (taken) return;
    header->status = usb_redir_inval;
    header->length = header->length_high = 0;
    usbredirparser_send_bulk_packet(b->parser, id, header, NULL, 0);
}

/* --- answers of the device --- */
static void on_complete(void *context, const usb_urb *urb)
{
    bridge *b = context;
    const int data_bytes = urb->endpoint & 0x80 ? (int)urb->done : 0;
    struct usb_redir_bulk_packet_header answer = {
        .endpoint = urb->endpoint,
        .status = status_of(urb->result),
        .length = (uint16_t)urb->done,
        .length_high = (uint16_t)(urb->done >> 16),
    };
    if (urb->result == USB_DEAD) b->is_dead = true;
    if ((urb->endpoint & 0x0f) == STREAM) b->stream_ns = usb_peer_now_ns();
    usbredirparser_send_bulk_packet(b->parser, urb->id, &answer, data_bytes > 0 ? urb->bytes : NULL,
                                    data_bytes);
    free(urb->bytes);
}

/* --- the socket --- */
static void on_log(void *context, int level, const char *text)
{
    (void)context;
    if (level <= usbredirparser_warning) fprintf(stderr, "bridge: %s\n", text);
}

static int on_read(void *context, uint8_t *bytes, int count)
{
    bridge *b = context;
    const ssize_t got = recv(b->socket, bytes, (size_t)count, MSG_DONTWAIT);
    if (got > 0) return (int)got;
    if (got < 0 && (errno == EAGAIN || errno == EINTR)) return 0;
    return -1;
}

static int on_write(void *context, uint8_t *bytes, int count)
{
    bridge *b = context;
    const ssize_t sent = send(b->socket, bytes, (size_t)count, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (sent >= 0) return (int)sent;
    return errno == EAGAIN || errno == EINTR ? 0 : -1;
}

static void make_parser(bridge *b)
{
    uint32_t caps[USB_REDIR_CAPS_SIZE] = {0};
    b->parser = usbredirparser_create();
    b->parser->priv = b;
    b->parser->log_func = on_log;
    b->parser->read_func = on_read;
    b->parser->write_func = on_write;
    b->parser->reset_func = on_reset;
    b->parser->set_configuration_func = on_set_configuration;
    b->parser->get_configuration_func = on_get_configuration;
    b->parser->set_alt_setting_func = on_set_alt_setting;
    b->parser->get_alt_setting_func = on_get_alt_setting;
    b->parser->cancel_data_packet_func = on_cancel;
    b->parser->control_packet_func = on_control;
    b->parser->bulk_packet_func = on_bulk;
    usbredirparser_caps_set_cap(caps, usb_redir_cap_connect_device_version);
    usbredirparser_caps_set_cap(caps, usb_redir_cap_ep_info_max_packet_size);
    usbredirparser_caps_set_cap(caps, usb_redir_cap_64bits_ids);
    usbredirparser_caps_set_cap(caps, usb_redir_cap_32bits_bulk_length);
    usbredirparser_init(b->parser, "cournand bridge", caps, USB_REDIR_CAPS_SIZE, usbredirparser_fl_usb_host);
}

/* Runs until QEMU disconnects or the device hangs. */
static int serve(bridge *b)
{
    for (;;) {
        usb_peer_run(&b->peer);
        if (usbredirparser_have_peer_caps(b->parser)) watch_plug(b);
        const bool moved = usb_urbs_step(&b->urbs);
        while (usbredirparser_has_data_to_write(b->parser))
            if (usbredirparser_do_write(b->parser) != 0) return 0;
        struct pollfd wait = {b->socket, POLLIN, 0};
        const bool is_talking = usb_peer_now_ns() - b->stream_ns < TALK_us * 1000;
        const struct timespec idle = {0, moved || is_talking ? 0 : IDLE_us * 1000};
        if (ppoll(&wait, 1, &idle, NULL) > 0 &&
            usbredirparser_do_read(b->parser) == usbredirparser_read_io_error)
            return 0;
        if (b->is_dead) {
            fprintf(stderr, "bridge: the device did not serve a token for %d s\n", USB_PEER_DEADLINE_s);
            return 1;
        }
    }
}

static int wait_for_qemu(const char *path)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    if (strlen(path) >= sizeof address.sun_path) return -1;
    strcpy(address.sun_path, path);
    unlink(path);
    const int listener = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (listener < 0 || bind(listener, (struct sockaddr *)&address, sizeof address) != 0 ||
        listen(listener, 1) != 0)
        return -1;
    struct pollfd wait = {listener, POLLIN, 0};
    const int connection = poll(&wait, 1, CONNECT_SECONDS * 1000) > 0 ? accept(listener, NULL, NULL) : -1;
    close(listener);
    return connection;
}

int main(int argc, char **argv)
{
    static bridge b;
    int used = 0;
    b.is_full_speed = argc > 2 && strcmp(argv[2], "--full-speed") == 0;
    const int first = b.is_full_speed ? 3 : 2;
    const char *wrong = usb_peer_open(&b.peer, argc - first, argv + first, &used);
    if (wrong == NULL && argc != first + used) wrong = "there are words that mean nothing";
    if (wrong != NULL) {
        fprintf(
            stderr,
            "bridge: %s\nusage: bridge SOCKET [--full-speed] (--here | --app | --mailbox FILE[:OFFSET])\n",
            wrong);
        return 2;
    }
    b.urbs = (usb_urbs){.host = b.peer.host, .complete = on_complete, .context = &b};
    b.socket = wait_for_qemu(argv[1]);
    if (b.socket < 0) {
        fprintf(stderr, "bridge: nobody connected to %s within %d s\n", argv[1], CONNECT_SECONDS);
        return 1;
    }
    make_parser(&b);
    const int result = serve(&b);
    cancel_all(&b);
    usbredirparser_destroy(b.parser);
    close(b.socket);
    unlink(argv[1]);
    return result;
}
