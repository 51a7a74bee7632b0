/* The app on USB. */
#include "firmware/port/usb/rig_usb.h"

_Static_assert((int)CRN_TOOL_MAX == (int)(sizeof((crn_hid_state *)0)->tracks / sizeof(crn_hid_track)),
               "app and reports agree about the number of tracks");

enum { LINE_DRIVEN = 16 };

/* --- stream --- */
bool crn_rig_usb_transmit(void *context, const uint8_t *frame, size_t frame_bytes)
{
    crn_rig_usb *rig = context;
    return crn_usb_transmit(&rig->usb, frame, frame_bytes);
}

size_t crn_rig_usb_room(void *context)
{
    const crn_rig_usb *rig = context;
    return crn_usb_queue_room(&rig->usb);
}

static void receive(void *context, const uint8_t *bytes, size_t count)
{
    crn_rig_usb *rig = context;
    rig->works++;
    crn_app_receive(rig->app, bytes, count);
}

/* --- reports --- */
static int16_t clamp16(int32_t value)
{
    return (int16_t)(value > INT16_MAX ? INT16_MAX : value < INT16_MIN ? INT16_MIN : value);
}

static uint8_t lines(const crn_app *app)
{
    unsigned bits = 0;
    if (app->edge.rig.emergency_stop) bits |= CRN_WIRE_LINE_STOP;
    if (app->edge.rig.supply_good) bits |= CRN_WIRE_LINE_SUPPLY;
    if (app->edge.rig.stage_on) bits |= CRN_WIRE_LINE_STAGE;
    if (app->edge.rig.local_unlock) bits |= CRN_WIRE_LINE_UNLOCK;
    if (app->safety.is_driving) bits |= LINE_DRIVEN;
    return (uint8_t)bits;
}

void crn_rig_usb_timer(crn_rig_usb *rig)
{
    const crn_app *app = rig->app;
    crn_hid_state state = {
        .tick = app->state >= CRN_WIRE_STATE_ARMED ? app->core.words.tick : 0,
        .state = app->state,
        .mode = app->mode,
        .fault_code = app->faults.stopped_by,
        .command_number = rig->command_number,
        .command_result = rig->command_result,
        .buttons = (uint8_t)(app->edge.has_rig ? app->edge.rig.buttons : app->session.mailbox.buttons),
        .lines = lines(app),
        .fault_count = (uint8_t)(app->faults.count > UINT8_MAX ? UINT8_MAX : app->faults.count),
        .syringe_counts =
            app->edge.has_rig ? app->edge.rig.syringe_counts : app->session.mailbox.syringe_counts,
        .inflator_raw = app->edge.has_rig ? app->edge.rig.inflator_raw : app->session.mailbox.inflator_raw,
    };
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) {
        const crn_port_hand *hand =
            app->edge.has_rig ? &app->edge.rig.hands[k] : &app->session.mailbox.hands[k];
        state.tracks[k] = (crn_hid_track){
            .translation_counts = hand->translation_counts,
            .rotation_counts = hand->rotation_counts,
            .motor_axial_mN = clamp16(app->haptics.motors[k].axial_mN),
            .motor_torque_uN_m = clamp16(app->haptics.motors[k].torque_uN_m),
            .sensor_axial_mN = clamp16(crn_app_force_measured(app, k)),
        };
    }
    crn_usb_timer(&rig->usb, &state);
}

static void identity(void *context, crn_hid_identity *report)
{
    (void)context;
    report->protocol_major = CRN_WIRE_PROTOCOL_MAJOR;
    report->protocol_minor = CRN_WIRE_PROTOCOL_MINOR;
    report->schema_hash = crn_wire_schema_hash();
    report->report_hash = crn_hid_report_hash();
    report->core_version = CRN_CORE_VERSION;
}

static void capabilities(void *context, crn_hid_capabilities *report)
{
    const crn_port *port = ((const crn_rig_usb *)context)->app->port;
    report->capabilities = CRN_WIRE_CAPABILITY_LOCKSTEP | CRN_WIRE_CAPABILITY_FREE_RUN |
                           CRN_WIRE_CAPABILITY_SNAPSHOTS | port->capabilities;
    report->tick_us = CRN_TICK_us;
    report->scene_bytes_max = crn_app_scene_bytes_max(port);
    report->track_count = port->capabilities & CRN_WIRE_CAPABILITY_ENCODERS ? CRN_PORT_TOOL_MAX : 0;
}

/* --- commands: only those that take power away --- */
static void command(void *context, const crn_hid_command *report)
{
    crn_rig_usb *rig = context;
    const bool is_stop = report->action == CRN_WIRE_ACTION_STOP;
    const bool is_reset = report->action == CRN_WIRE_ACTION_RESET;
    rig->command_number = report->number;
    rig->command_result = CRN_REJECT_ACTION_UNKNOWN;
    if (!is_stop && !is_reset) return;
    rig->works++;
    rig->command_result = crn_app_order(rig->app, report->action) ? 0 : CRN_REJECT_WRONG_STATE;
}

/* --- settings: the wire's `rig` with some fields changed, read back to see whether the app took it --- */
static void calibration(void *context, crn_hid_calibration *report)
{
    const crn_app *app = ((const crn_rig_usb *)context)->app;
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) {
        const crn_wire_track *wire = &app->setup.tracks[k].wire;
        report->tracks[k] = (crn_hid_track_calibration){
            wire->translation_pm_per_count, wire->rotation_counts_per_turn, wire->force_gain_milli};
    }
}

static void limits(void *context, crn_hid_limits *report)
{
    const crn_app *app = ((const crn_rig_usb *)context)->app;
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) {
        const crn_wire_track *wire = &app->setup.tracks[k].wire;
        report->tracks[k] = (crn_hid_track_limits){wire->force_limit_mN, wire->torque_limit_uN_m};
    }
}

static crn_wire_rig present(const crn_app *app)
{
    crn_wire_rig wire = {.tracks_count = CRN_TOOL_MAX};
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) wire.tracks[k] = app->setup.tracks[k].wire;
    return wire;
}

static void set(crn_rig_usb *rig, const crn_wire_rig *wire)
{
    rig->works++;
    crn_app_configure(rig->app, wire);
}

static bool set_calibration(void *context, const crn_hid_calibration *report)
{
    crn_rig_usb *rig = context;
    crn_wire_rig wire = present(rig->app);
    bool is_taken = true;
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) {
        wire.tracks[k].translation_pm_per_count = report->tracks[k].translation_pm_per_count;
        wire.tracks[k].rotation_counts_per_turn = report->tracks[k].rotation_counts_per_turn;
        wire.tracks[k].force_gain_milli = report->tracks[k].force_gain_milli;
    }
    set(rig, &wire);
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) {
        const crn_wire_track *now = &rig->app->setup.tracks[k].wire;
        is_taken = is_taken && now->translation_pm_per_count == wire.tracks[k].translation_pm_per_count &&
                   now->rotation_counts_per_turn == wire.tracks[k].rotation_counts_per_turn &&
                   now->force_gain_milli == wire.tracks[k].force_gain_milli;
    }
    return is_taken;
}

static bool set_limits(void *context, const crn_hid_limits *report)
{
    crn_rig_usb *rig = context;
    crn_wire_rig wire = present(rig->app);
    bool is_taken = true;
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) {
        wire.tracks[k].force_limit_mN = report->tracks[k].force_limit_mN;
        wire.tracks[k].torque_limit_uN_m = report->tracks[k].torque_limit_uN_m;
    }
    set(rig, &wire);
    for (uint32_t k = 0; k < CRN_TOOL_MAX; k++) {
        const crn_wire_track *now = &rig->app->setup.tracks[k].wire;
        is_taken = is_taken && now->force_limit_mN == wire.tracks[k].force_limit_mN &&
                   now->torque_limit_uN_m == wire.tracks[k].torque_limit_uN_m;
    }
    return is_taken;
}

/* --- the loop --- */

/* The app notices an absent host because no messages arrive, whatever the cause. The callback for changes of
 * the USB link does nothing. */
static void link(void *context, crn_usb_link link)
{
    (void)context;
    (void)link;
}

bool crn_rig_usb_init(crn_rig_usb *rig, crn_app *app, const crn_udc *udc)
{
    rig->app = app;
    rig->works = 0;
    rig->command_number = rig->command_result = 0;
    rig->callbacks = (crn_usb_app){
        .context = rig,
        .receive = receive,
        .link = link,
        .command = command,
        .identity = identity,
        .capabilities = capabilities,
        .calibration = calibration,
        .limits = limits,
        .set_calibration = set_calibration,
        .set_limits = set_limits,
    };
    const crn_usb_config config = {
        .udc = udc,
        .app = &rig->callbacks,
        .serial = app->port->serial,
        .queue = rig->queue,
        .queue_bytes = sizeof rig->queue,
        .reply_bytes = CRN_RIG_USB_REPLY_BYTES,
    };
    return crn_usb_init(&rig->usb, &config);
}

void crn_rig_usb_connect(crn_rig_usb *rig, bool connected)
{
    crn_usb_connect(&rig->usb, connected);
}

bool crn_rig_usb_is_configured(const crn_rig_usb *rig)
{
    return rig->usb.configuration != 0;
}

bool crn_rig_usb_poll(crn_rig_usb *rig)
{
    return crn_usb_poll(&rig->usb);
}
