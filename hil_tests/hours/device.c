/* The device on the host, with simulated hardware. */
#include "hil_tests/hours/device.h"
#include "firmware/port/imxrt1062/board.h"
#include "firmware/port/mailbox/mailbox_udc.h"
#include "firmware/port/usb/rig_usb.h"

#include <stdlib.h>
#include <string.h>

enum {
    CANARY_BYTES = 4096,
    CANARY = 0xa5,
    FRAMES = 2048,
    /* Times of the work besides ticks, of the order that the emulated board needs (docs/hil.md). */
    REQUEST_us = 30,   /* a packet with a request */
    ARM_us = 20000,    /* the model is built */
    SCENE_us = 150000, /* a scene is checked */
};

struct hours_device {
    uint8_t canary_low[CANARY_BYTES];
    crn_instrument tool_table[CRN_TABLE_MAX];
    crn_app app;
    uint8_t canary_middle[CANARY_BYTES];
    crn_rig_usb usb;
    uint8_t canary_high[CANARY_BYTES];
    crn_mailbox_udc controller;
    crn_port port;
    hours_hardware hardware;
    crn_mailbox *mailbox;
    volatile uint32_t edges;
    uint32_t edges_done, frames, frame_last;
    bool has_frame;
    int32_t clock_error;
    uint8_t *slots;
};

/* --- the port --- */
static bool inputs(void *context, crn_port_inputs *inputs)
{
    hours_device *device = context;
    const hours_hardware *hardware = &device->hardware;
    const crn_app *app = &device->app;
    const bool is_ticking = app->mode == CRN_WIRE_MODE_FREE_RUN && app->state == CRN_WIRE_STATE_RUNNING;
    hardware->sample(hardware->context, inputs);
    hardware->pass(hardware->context, hardware->work_us(hardware->context, is_ticking));
    return true;
}

static void outputs(void *context, const crn_port_outputs *outputs)
{
    const hours_hardware *hardware = &((hours_device *)context)->hardware;
    hardware->drive(hardware->context, outputs);
}

static uint32_t now_us(void *context)
{
    const hours_hardware *hardware = &((hours_device *)context)->hardware;
    return hardware->now_us(hardware->context);
}

static bool transmit(void *context, const uint8_t *frame, size_t frame_bytes)
{
    return crn_rig_usb_transmit(&((hours_device *)context)->usb, frame, frame_bytes);
}

static size_t room(void *context)
{
    return crn_rig_usb_room(&((hours_device *)context)->usb);
}

/* --- life --- */
hours_device *hours_device_create(const hours_hardware *hardware, void *mailbox)
{
    hours_device *device = aligned_alloc(64, (sizeof *device + 63) / 64 * 64);
    uint8_t *slots = malloc(2 * (size_t)HOURS_SLOT_BYTES + CANARY_BYTES);
    if (device == NULL || slots == NULL) {
        free(device);
        free(slots);
        return NULL;
    }
    memset(device, 0, sizeof *device);
    memset(device->canary_low, CANARY, CANARY_BYTES);
    memset(device->canary_middle, CANARY, CANARY_BYTES);
    memset(device->canary_high, CANARY, CANARY_BYTES);
    memset(slots + 2 * (size_t)HOURS_SLOT_BYTES, CANARY, CANARY_BYTES);
    device->hardware = *hardware;
    device->mailbox = mailbox;
    device->slots = slots;
    device->port = (crn_port){
        .context = device,
        .transmit = transmit,
        .transmit_room = room,
        .inputs = inputs,
        .outputs = outputs,
        .now_us = now_us,
        .serial = "HOURS-0001",
        .tool_table = device->tool_table,
        .scene_slots = {slots, slots + HOURS_SLOT_BYTES},
        .scene_slot_bytes = HOURS_SLOT_BYTES,
        .capabilities = CRN_WIRE_CAPABILITY_ENCODERS | CRN_WIRE_CAPABILITY_MOTORS,
        .built = {.damping_mN_s_per_m = 1000, .damping_nN_m_s_per_rad = 2000}, /* of hil_tests/plant */
    };
    hours_device_power_up(device);
    return device;
}

void hours_device_destroy(hours_device *device)
{
    if (device == NULL) return;
    free(device->slots);
    free(device);
}

void hours_device_power_up(hours_device *device)
{
    device->edges = device->edges_done = device->frames = 0;
    device->has_frame = false;
    device->clock_error = 0;
    crn_app_init(&device->app, &device->port);
    crn_mailbox_udc_init(&device->controller, device->mailbox, true);
    (void)crn_rig_usb_init(&device->usb, &device->app, &device->controller.udc);
    crn_rig_usb_connect(&device->usb, true);
}

/* --- the loop --- */
void hours_device_edge(hours_device *device)
{
    device->edges++;
}

uint32_t hours_device_edges_due(const hours_device *device)
{
    return device->edges - device->edges_done;
}

static void count_frames(hours_device *device, uint32_t frame)
{
    if (device->has_frame) device->frames += (frame - device->frame_last) % FRAMES;
    device->has_frame = true;
    device->frame_last = frame;
}

static void tick(hours_device *device)
{
    const hours_hardware *hardware = &device->hardware;
    crn_app_timer(&device->app);
    const uint32_t frame = hardware->frame(hardware->context);
    const int32_t difference = clock_check(device->edges, frame); /* as in the loop of the board */
    if (difference != 0) {
        device->clock_error = difference;
        crn_app_port_error(&device->app, difference);
    }
    count_frames(device, frame);
    crn_rig_usb_timer(&device->usb);
    device->edges_done++;
}

bool hours_device_poll(hours_device *device)
{
    const hours_hardware *hardware = &device->hardware;
    const uint32_t works = device->usb.works;
    const uint8_t state = device->app.state;
    const bool was_open = device->app.setup.scene_upload.open;
    const bool has_more = crn_rig_usb_poll(&device->usb);
    if (device->usb.works == works) return has_more;
    uint32_t us = REQUEST_us;
    if (was_open && !device->app.setup.scene_upload.open) us = SCENE_us;
    if (state == CRN_WIRE_STATE_READY && device->app.state == CRN_WIRE_STATE_ARMED) us = ARM_us;
    hardware->pass(hardware->context, us);
    return has_more;
}

bool hours_device_round(hours_device *device)
{
    const bool has_more = hours_device_poll(device);
    if (hours_device_edges_due(device) == 0) return has_more;
    tick(device);
    return true;
}

/* --- for the judge --- */
hours_counts hours_device_read(const hours_device *device)
{
    return (hours_counts){
        .edges = device->edges,
        .edges_done = device->app.edges_done,
        .frames = device->frames,
        .overruns = device->app.clock.tick_overruns,
        .clock_error = device->clock_error,
        .reports_dropped = device->usb.usb.reports_dropped,
        .frames_refused = device->usb.usb.frames_refused,
        .reports_waiting =
            device->usb.usb.report_count + (device->usb.usb.is_armed[CRN_USB_STATUS_IN] ? 1u : 0u),
        .state = device->app.state,
        .mode = device->app.mode,
    };
}

static bool is_canary(const uint8_t *bytes)
{
    for (int i = 0; i < CANARY_BYTES; i++)
        if (bytes[i] != CANARY) return false;
    return true;
}

bool hours_device_is_sound(const hours_device *device)
{
    return is_canary(device->canary_low) && is_canary(device->canary_middle) &&
           is_canary(device->canary_high) && is_canary(device->slots + 2 * (size_t)HOURS_SLOT_BYTES);
}
