/* The controller in memory. The USB stack calls the functions of this file through the function pointers in
 * crn_udc. */
#include "firmware/port/mailbox/mailbox_udc.h"

/* --- requests of the stack --- */
static crn_mailbox_endpoint *endpoint_of(crn_mailbox_udc *controller, uint8_t endpoint)
{
    uint8_t number = endpoint % CRN_MAILBOX_ENDPOINT_COUNT;
    return endpoint & CRN_UDC_IN ? &controller->in[number] : &controller->out[number];
}

static void udc_connect(void *context, bool connected)
{
    crn_mailbox_udc *controller = context;
    crn_mailbox_write(&controller->mailbox->device.attached, connected);
    if (!connected) controller->is_powered = false;
}

static void udc_set_address(void *context, uint8_t address)
{
    crn_mailbox_udc *controller = context;
    controller->address = address;
}

static bool udc_open(void *context, uint8_t endpoint, crn_udc_type type, uint16_t packet_bytes)
{
    (void)type;
    if (packet_bytes > CRN_MAILBOX_DATA_MAX) return false;
    *endpoint_of(context, endpoint) = (crn_mailbox_endpoint){.is_open = true, .packet_bytes = packet_bytes};
    return true;
}

static void udc_close(void *context, uint8_t endpoint)
{
    *endpoint_of(context, endpoint) = (crn_mailbox_endpoint){0};
}

static void udc_arm(void *context, uint8_t endpoint, uint8_t *bytes, uint32_t count)
{
    crn_mailbox_endpoint *pipe = endpoint_of(context, endpoint);
    pipe->bytes = bytes;
    pipe->count = count;
    pipe->done = 0;
    pipe->is_armed = pipe->is_open;
}

static void udc_stall(void *context, uint8_t endpoint)
{
    crn_mailbox_udc *controller = context;
    crn_mailbox_endpoint *pipe = endpoint_of(controller, endpoint);
    pipe->is_stalled = true;
    pipe->is_armed = false;
    if (endpoint % CRN_MAILBOX_ENDPOINT_COUNT != 0) return;
    controller->in[0].is_stalled = controller->out[0].is_stalled = true;
    controller->in[0].is_armed = controller->out[0].is_armed = false;
}

static void udc_test(void *context, uint8_t selector)
{
    crn_mailbox_udc *controller = context;
    crn_mailbox_write(&controller->mailbox->device.test_selector, selector);
}

/* --- the bus --- */
static void reset(crn_mailbox_udc *controller)
{
    controller->address = 0;
    for (uint8_t number = 0; number < CRN_MAILBOX_ENDPOINT_COUNT; number++) {
        udc_close(controller, number);
        udc_close(controller, number | CRN_UDC_IN);
    }
    const crn_mailbox_endpoint control = {.is_open = true, .packet_bytes = CRN_UDC_CONTROL_PACKET_BYTES};
    controller->in[0] = controller->out[0] = control;
}

static bool take_bus(crn_mailbox_udc *controller, crn_udc_event *event)
{
    crn_mailbox *mailbox = controller->mailbox;
    uint32_t bus = crn_mailbox_read(&mailbox->host.bus);
    if (bus == crn_mailbox_read(&mailbox->device.bus_done)) return false;
    uint32_t state = crn_mailbox_read(&mailbox->host.bus_state);
    bool attached = crn_mailbox_read(&mailbox->device.attached) != 0;
    if (attached && (state == CRN_MAILBOX_RESET_FULL || state == CRN_MAILBOX_RESET_HIGH)) {
        reset(controller);
        controller->is_powered = true;
        event->kind = CRN_UDC_RESET;
        bool high = state == CRN_MAILBOX_RESET_HIGH && controller->udc.can_high_speed;
        event->speed = high ? CRN_UDC_HIGH_SPEED : CRN_UDC_FULL_SPEED;
    } else if (state == CRN_MAILBOX_UNPLUGGED) {
        reset(controller);
        controller->is_powered = false;
        event->kind = CRN_UDC_UNPLUG;
    } else if (controller->is_powered && state == CRN_MAILBOX_SUSPENDED) {
        event->kind = CRN_UDC_SUSPEND;
    } else if (controller->is_powered && state == CRN_MAILBOX_RESUMED) {
        event->kind = CRN_UDC_RESUME;
    }
    crn_mailbox_write(&mailbox->device.bus_done, bus);
    return event->kind != CRN_UDC_NOTHING;
}

/* --- tokens: each returns the reply --- */
static void copy(uint8_t *to, const uint8_t *from, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) to[i] = from[i];
}

static crn_mailbox_reply setup(crn_mailbox_udc *controller, const crn_mailbox_host_half *token,
                               crn_udc_event *event)
{
    if (token->token_endpoint != 0 || token->token_bytes != CRN_UDC_SETUP_BYTES) return CRN_MAILBOX_SILENCE;
    if (token->token_flags & CRN_MAILBOX_DATA1) return CRN_MAILBOX_SILENCE;
    for (int way = 0; way < 2; way++) {
        crn_mailbox_endpoint *pipe = way ? &controller->in[0] : &controller->out[0];
        pipe->is_stalled = pipe->is_armed = false;
        pipe->toggle = true; /* data and status stages begin with DATA1 */
    }
    event->kind = CRN_UDC_SETUP;
    copy(event->setup, controller->mailbox->host_data, CRN_UDC_SETUP_BYTES);
    return CRN_MAILBOX_ACK;
}

static void finish(crn_mailbox_endpoint *pipe, uint8_t endpoint, crn_udc_event *event)
{
    pipe->is_armed = false;
    event->kind = CRN_UDC_DONE;
    event->endpoint = endpoint;
    event->bytes = pipe->done;
}

static crn_mailbox_reply out(crn_mailbox_udc *controller, const crn_mailbox_host_half *token,
                             crn_udc_event *event)
{
    crn_mailbox_endpoint *pipe = &controller->out[token->token_endpoint];
    uint32_t bytes = token->token_bytes;
    if (!pipe->is_open || bytes > pipe->packet_bytes) return CRN_MAILBOX_SILENCE;
    if (pipe->is_stalled) return CRN_MAILBOX_STALL;
    bool toggle = (token->token_flags & CRN_MAILBOX_DATA1) != 0;
    if (toggle != pipe->toggle)
        return CRN_MAILBOX_ACK; /* the host missed the last ACK of this device and sends again */
    if (!pipe->is_armed) return CRN_MAILBOX_NAK;
    uint32_t room = pipe->count - pipe->done;
    if (bytes > room) { /* more than was requested: a protocol error of the host */
        udc_stall(controller, (uint8_t)token->token_endpoint);
        return CRN_MAILBOX_STALL;
    }
    copy(pipe->bytes + pipe->done, controller->mailbox->host_data, bytes);
    pipe->toggle = !pipe->toggle;
    pipe->done += bytes;
    if (bytes < pipe->packet_bytes || pipe->done == pipe->count)
        finish(pipe, (uint8_t)token->token_endpoint, event);
    return CRN_MAILBOX_ACK;
}

static crn_mailbox_reply in(crn_mailbox_udc *controller, const crn_mailbox_host_half *token,
                            uint32_t *reply_bytes, crn_udc_event *event)
{
    crn_mailbox_endpoint *pipe = &controller->in[token->token_endpoint];
    if (!pipe->is_open) return CRN_MAILBOX_SILENCE;
    if (pipe->is_stalled) return CRN_MAILBOX_STALL;
    if (!pipe->is_armed) return CRN_MAILBOX_NAK;
    uint32_t bytes = pipe->count - pipe->done;
    if (bytes > pipe->packet_bytes) bytes = pipe->packet_bytes;
    copy(controller->mailbox->device_data, pipe->bytes + pipe->done, bytes);
    *reply_bytes = bytes;
    bool toggle = pipe->toggle;
    if (!(token->token_flags & CRN_MAILBOX_LOST_ACK)) {
        pipe->toggle = !toggle;
        pipe->done += bytes;
        if (pipe->done == pipe->count) finish(pipe, (uint8_t)(token->token_endpoint | CRN_UDC_IN), event);
    }
    return toggle ? CRN_MAILBOX_REPLY_DATA1 : CRN_MAILBOX_REPLY_DATA0;
}

static void take_token(crn_mailbox_udc *controller, crn_udc_event *event)
{
    crn_mailbox *mailbox = controller->mailbox;
    uint32_t number = crn_mailbox_read(&mailbox->host.token);
    if (number == crn_mailbox_read(&mailbox->device.token_done)) return;
    const crn_mailbox_host_half token = {
        .token_kind = crn_mailbox_read(&mailbox->host.token_kind),
        .token_flags = crn_mailbox_read(&mailbox->host.token_flags),
        .token_address = crn_mailbox_read(&mailbox->host.token_address),
        .token_endpoint = crn_mailbox_read(&mailbox->host.token_endpoint),
        .token_bytes = crn_mailbox_read(&mailbox->host.token_bytes),
    };
    uint32_t reply_bytes = 0;
    crn_mailbox_reply reply = CRN_MAILBOX_SILENCE;
    if (controller->is_powered && token.token_address == controller->address &&
        token.token_endpoint < CRN_MAILBOX_ENDPOINT_COUNT && token.token_bytes <= CRN_MAILBOX_DATA_MAX) {
        if (token.token_kind == CRN_MAILBOX_SETUP) reply = setup(controller, &token, event);
        if (token.token_kind == CRN_MAILBOX_OUT) reply = out(controller, &token, event);
        if (token.token_kind == CRN_MAILBOX_IN) reply = in(controller, &token, &reply_bytes, event);
    }
    crn_mailbox_write(&mailbox->device.reply, reply);
    crn_mailbox_write(&mailbox->device.reply_bytes, reply_bytes);
    crn_mailbox_write(&mailbox->device.token_done, number);
}

static bool udc_poll(void *context, crn_udc_event *event)
{
    crn_mailbox_udc *controller = context;
    *event = (crn_udc_event){0};
    if (!take_bus(controller, event)) take_token(controller, event);
    return event->kind != CRN_UDC_NOTHING;
}

void crn_mailbox_udc_init(crn_mailbox_udc *controller, crn_mailbox *mailbox, bool can_high_speed)
{
    *controller = (crn_mailbox_udc){
        .udc =
            {
                .context = controller,
                .can_high_speed = can_high_speed,
                .connect = udc_connect,
                .set_address = udc_set_address,
                .open = udc_open,
                .close = udc_close,
                .arm = udc_arm,
                .stall = udc_stall,
                .test = udc_test,
                .poll = udc_poll,
            },
        .mailbox = mailbox,
    };
    reset(controller);
    crn_mailbox_start_device(mailbox, can_high_speed);
}

crn_mailbox_demand crn_mailbox_udc_demand(const crn_mailbox_udc *controller)
{
    const crn_mailbox *mailbox = controller->mailbox;
    if (crn_mailbox_read(&mailbox->host.bus) != mailbox->device.bus_done) return CRN_MAILBOX_BRINGS_WORK;
    if (crn_mailbox_read(&mailbox->host.token) == mailbox->device.token_done) return CRN_MAILBOX_IDLE;
    return mailbox->host.token_kind == CRN_MAILBOX_IN ? CRN_MAILBOX_ASKS_DATA : CRN_MAILBOX_BRINGS_WORK;
}
