/* The loop-back rig. */
#include "hil_tests/usb/usb_rig.h"

#include <string.h>

/* --- the app --- */
static void app_receive(void *context, const uint8_t *bytes, size_t count)
{
    usb_rig *rig = context;
    rig->bytes_in += (uint32_t)count;
    for (size_t i = 0; i < count; i++) {
        if (rig->frame_bytes == sizeof rig->frame) rig->frame_bytes = 0;
        rig->frame[rig->frame_bytes++] = bytes[i];
        if (bytes[i] != 0) continue;
        if (rig->frame_bytes > 1 && !rig->is_deaf) {
            if (crn_usb_transmit(&rig->usb, rig->frame, rig->frame_bytes))
                rig->frames_back++;
            else
                rig->frames_lost++;
        }
        rig->frame_bytes = 0;
    }
}

static void app_link(void *context, crn_usb_link link)
{
    usb_rig *rig = context;
    rig->link = link;
    rig->link_changes++;
}

static void app_command(void *context, const crn_hid_command *command)
{
    usb_rig *rig = context;
    rig->command = *command;
    rig->commands++;
}

static void app_identity(void *context, crn_hid_identity *identity)
{
    (void)context;
    identity->protocol_major = CRN_WIRE_PROTOCOL_MAJOR;
    identity->protocol_minor = CRN_WIRE_PROTOCOL_MINOR;
    identity->schema_hash = crn_wire_schema_hash();
    identity->report_hash = crn_hid_report_hash();
    identity->core_version = 7;
}

static void app_capabilities(void *context, crn_hid_capabilities *capabilities)
{
    (void)context;
    *capabilities = (crn_hid_capabilities){CRN_WIRE_CAPABILITY_LOCKSTEP, 1000, 1 << 20, 3};
}

static void app_calibration(void *context, crn_hid_calibration *calibration)
{
    const usb_rig *rig = context;
    *calibration = rig->calibration;
}

static void app_limits(void *context, crn_hid_limits *limits)
{
    const usb_rig *rig = context;
    *limits = rig->limits;
}

static bool app_set_calibration(void *context, const crn_hid_calibration *calibration)
{
    usb_rig *rig = context;
    if (calibration->tracks[0].translation_pm_per_count == 0) return false;
    rig->calibration = *calibration;
    return true;
}

static bool app_set_limits(void *context, const crn_hid_limits *limits)
{
    usb_rig *rig = context;
    for (int k = 0; k < 3; k++)
        if (limits->tracks[k].force_limit_mN > rig->limits.tracks[k].force_limit_mN) return false;
    rig->limits = *limits;
    return true;
}

/* --- the host's patience: a number of looks at the mailbox --- */
static bool host_wait(void *context)
{
    usb_rig *rig = context;
    if (rig->waits == 0) return false;
    rig->waits--;
    crn_usb_poll(&rig->usb);
    return true;
}

static void host_begin_wait(void *context)
{
    usb_rig *rig = context;
    rig->waits = USB_RIG_WAITS_MAX;
}

void usb_rig_reboot(usb_rig *rig, bool can_high_speed)
{
    const crn_usb_config config = {
        .udc = &rig->controller.udc,
        .app = &rig->app,
        .serial = "RIG-0001",
        .queue = rig->queue,
        .queue_bytes = sizeof rig->queue,
        .reply_bytes = CRN_WIRE_FRAME_MAX,
    };
    crn_mailbox_udc_init(&rig->controller, &rig->mailbox, can_high_speed);
    crn_usb_init(&rig->usb, &config);
    crn_usb_connect(&rig->usb, true);
}

void usb_rig_open(usb_rig *rig, bool can_high_speed)
{
    memset(rig, 0, sizeof *rig);
    rig->app = (crn_usb_app){
        .context = rig,
        .receive = app_receive,
        .link = app_link,
        .command = app_command,
        .identity = app_identity,
        .capabilities = app_capabilities,
        .calibration = app_calibration,
        .limits = app_limits,
        .set_calibration = app_set_calibration,
        .set_limits = app_set_limits,
    };
    for (int k = 0; k < 3; k++) {
        rig->calibration.tracks[k] = (crn_hid_track_calibration){10000000, 4096, 1000};
        rig->limits.tracks[k] = (crn_hid_track_limits){8000, 20000};
    }
    rig->host = (usb_host){
        .mailbox = &rig->mailbox,
        .wait = host_wait,
        .begin_wait = host_begin_wait,
        .context = rig,
        .packet_bytes = 64,
        .naks_max = USB_RIG_NAKS_MAX,
    };
    usb_rig_reboot(rig, can_high_speed);
}

void usb_rig_tick(usb_rig *rig)
{
    crn_hid_state state = rig->usb.state;
    state.tick++;
    state.state = CRN_WIRE_STATE_READY;
    state.command_number = rig->command.number;
    crn_usb_timer(&rig->usb, &state);
}

void usb_rig_settle(usb_rig *rig)
{
    for (int i = 0; i < USB_RIG_WAITS_MAX && crn_usb_poll(&rig->usb); i++) {
    }
}

usb_result usb_rig_control(usb_rig *rig, uint8_t type, uint8_t request, uint16_t value, uint16_t index,
                           uint16_t length, uint8_t *bytes, uint32_t *count)
{
    const usb_request setup = {type, request, value, index, length};
    uint32_t none;
    return usb_host_control(&rig->host, &setup, bytes, count != NULL ? count : &none);
}

usb_result usb_rig_configure(usb_rig *rig, bool high_speed)
{
    usb_result result =
        usb_host_bus(&rig->host, high_speed ? CRN_MAILBOX_RESET_HIGH : CRN_MAILBOX_RESET_FULL);
    if (result == USB_OK) result = usb_rig_control(rig, 0x00, 5, 5, 0, 0, NULL, NULL);
    rig->host.address = 5;
    if (result == USB_OK) result = usb_rig_control(rig, 0x00, 9, 1, 0, 0, NULL, NULL);
    return result;
}
