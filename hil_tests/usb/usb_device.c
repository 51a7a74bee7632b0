/* Implements a complete device that exchanges USB tokens through the mailbox. */
#include "hil_tests/usb/usb_device.h"

#include <string.h>

enum { WAITS_MAX = 200, NAKS_MAX = 50, SETTLE_MAX = 10000, STREAM = 2, PACKET = 512 };

static bool no_rig(void *context, crn_port_inputs *inputs)
{
    (void)context;
    (void)inputs;
    return false;
}

static void take_outputs(void *context, const crn_port_outputs *outputs)
{
    usb_device *device = context;
    device->outputs = *outputs;
}

static bool transmit(void *context, const uint8_t *frame, size_t frame_bytes)
{
    usb_device *device = context;
    return crn_rig_usb_transmit(&device->rig_usb, frame, frame_bytes);
}

static size_t room(void *context)
{
    usb_device *device = context;
    return crn_rig_usb_room(&device->rig_usb);
}

static uint32_t now_us(void *context)
{
    const usb_device *device = context;
    return device->us;
}

static bool host_wait(void *context)
{
    usb_device *device = context;
    if (device->waits == 0) return false;
    device->waits--;
    crn_rig_usb_poll(&device->rig_usb);
    return true;
}

static void host_begin_wait(void *context)
{
    usb_device *device = context;
    device->waits = WAITS_MAX;
}

static usb_result control(usb_device *device, uint8_t request, uint16_t value)
{
    const usb_request setup = {0x00, request, value, 0, 0};
    uint32_t none;
    return usb_host_control(&device->host, &setup, NULL, &none);
}

bool usb_device_start(usb_device *device, const char *serial)
{
    static _Alignas(8) uint8_t slots[2][USB_DEVICE_SLOT_BYTES];
    memset(device, 0, sizeof *device);
    device->port = (crn_port){
        .context = device,
        .transmit = transmit,
        .transmit_room = room,
        .inputs = no_rig,
        .outputs = take_outputs,
        .now_us = now_us,
        .serial = serial,
        .tool_table = device->tool_table,
        .scene_slots = {slots[0], slots[1]},
        .scene_slot_bytes = USB_DEVICE_SLOT_BYTES,
    };
    device->host = (usb_host){
        .mailbox = &device->mailbox,
        .wait = host_wait,
        .begin_wait = host_begin_wait,
        .context = device,
        .packet_bytes = 64,
        .naks_max = NAKS_MAX,
    };
    crn_mailbox_udc_init(&device->controller, &device->mailbox, true);
    crn_app_init(&device->app, &device->port);
    if (!crn_rig_usb_init(&device->rig_usb, &device->app, &device->controller.udc)) return false;
    crn_rig_usb_connect(&device->rig_usb, true);
    return true;
}

bool usb_device_open(usb_device *device)
{
    if (!usb_device_start(device, "USB-0001")) return false;
    if (usb_host_bus(&device->host, CRN_MAILBOX_RESET_HIGH) != USB_OK || control(device, 5, 1) != USB_OK)
        return false;
    device->host.address = 1;
    if (control(device, 9, 1) != USB_OK) return false;
    uint8_t zero = 1;
    return usb_device_read(device, &zero, 1) == 1 && zero == 0;
}

void usb_device_tick(usb_device *device)
{
    device->us += 1000;
    crn_app_timer(&device->app);
    crn_rig_usb_timer(&device->rig_usb);
}

void usb_device_settle(usb_device *device)
{
    for (int i = 0; i < SETTLE_MAX && crn_rig_usb_poll(&device->rig_usb); i++) {
    }
}

void usb_device_write(void *context, const uint8_t *bytes, size_t count)
{
    usb_device *device = context;
    device->last = usb_host_out(&device->host, STREAM, PACKET, bytes, (uint32_t)count);
    usb_device_settle(device);
}

size_t usb_device_read(void *context, uint8_t *bytes, size_t capacity)
{
    usb_device *device = context;
    if (device->read_begin == device->read_end) {
        device->read_begin = device->read_end = 0;
        device->last =
            usb_host_packet_in(&device->host, STREAM, device->read_bytes, PACKET, &device->read_end);
        if (device->last != USB_OK) device->read_end = 0;
        /* An empty packet has no meaning except that it ends a longer read. */
        if (device->last == USB_OK && device->read_end == 0)
            device->last =
                usb_host_packet_in(&device->host, STREAM, device->read_bytes, PACKET, &device->read_end);
        if (device->last != USB_OK) device->read_end = 0;
    }
    size_t count = device->read_end - device->read_begin;
    if (count > capacity) count = capacity;
    memcpy(bytes, device->read_bytes + device->read_begin, count);
    device->read_begin += (uint32_t)count;
    return count;
}
