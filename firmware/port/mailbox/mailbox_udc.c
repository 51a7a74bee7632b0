/* The controller in memory. Called through seld_udc. */
#include "firmware/port/mailbox/mailbox_udc.h"

/* --- what the stack asks for --- */
static seld_mailbox_endpoint *endpoint_of(seld_mailbox_udc *controller, uint8_t endpoint)
{
    uint8_t number = endpoint % SELD_MAILBOX_ENDPOINT_COUNT;
    return endpoint & SELD_UDC_IN ? &controller->in[number] : &controller->out[number];
}

static void udc_connect(void *context, bool connected)
{
    seld_mailbox_udc *controller = context;
    seld_mailbox_write(&controller->mailbox->device.attached, connected);
    if (!connected) controller->is_powered = false;
}

static void udc_set_address(void *context, uint8_t address)
{
    seld_mailbox_udc *controller = context;
    controller->address = address;
}

static bool udc_open(void *context, uint8_t endpoint, seld_udc_type type, uint16_t packet_bytes)
{
    (void)type;
    if (packet_bytes > SELD_MAILBOX_DATA_MAX) return false;
    *endpoint_of(context, endpoint) = (seld_mailbox_endpoint){.is_open = true, .packet_bytes = packet_bytes};
    return true;
}

static void udc_close(void *context, uint8_t endpoint)
{
    *endpoint_of(context, endpoint) = (seld_mailbox_endpoint){0};
}

static void udc_arm(void *context, uint8_t endpoint, uint8_t *bytes, uint32_t count)
{
    seld_mailbox_endpoint *pipe = endpoint_of(context, endpoint);
    pipe->bytes = bytes;
    pipe->count = count;
    pipe->done = 0;
    pipe->is_armed = pipe->is_open;
}

static void udc_stall(void *context, uint8_t endpoint)
{
    seld_mailbox_udc *controller = context;
    seld_mailbox_endpoint *pipe = endpoint_of(controller, endpoint);
    pipe->is_stalled = true;
    pipe->is_armed = false;
    if (endpoint % SELD_MAILBOX_ENDPOINT_COUNT != 0) return;
    controller->in[0].is_stalled = controller->out[0].is_stalled = true;
    controller->in[0].is_armed = controller->out[0].is_armed = false;
}

static void udc_test(void *context, uint8_t selector)
{
    seld_mailbox_udc *controller = context;
    seld_mailbox_write(&controller->mailbox->device.test_selector, selector);
}

/* --- the bus --- */
static void reset(seld_mailbox_udc *controller)
{
    controller->address = 0;
    for (uint8_t number = 0; number < SELD_MAILBOX_ENDPOINT_COUNT; number++) {
        udc_close(controller, number);
        udc_close(controller, number | SELD_UDC_IN);
    }
    const seld_mailbox_endpoint control = {.is_open = true, .packet_bytes = SELD_UDC_CONTROL_PACKET_BYTES};
    controller->in[0] = controller->out[0] = control;
}

static bool take_bus(seld_mailbox_udc *controller, seld_udc_event *event)
{
    seld_mailbox *mailbox = controller->mailbox;
    uint32_t bus = seld_mailbox_read(&mailbox->host.bus);
    if (bus == seld_mailbox_read(&mailbox->device.bus_done)) return false;
    uint32_t state = seld_mailbox_read(&mailbox->host.bus_state);
    bool attached = seld_mailbox_read(&mailbox->device.attached) != 0;
    if (attached && (state == SELD_MAILBOX_RESET_FULL || state == SELD_MAILBOX_RESET_HIGH)) {
        reset(controller);
        controller->is_powered = true;
        event->kind = SELD_UDC_RESET;
        bool high = state == SELD_MAILBOX_RESET_HIGH && controller->udc.can_high_speed;
        event->speed = high ? SELD_UDC_HIGH_SPEED : SELD_UDC_FULL_SPEED;
    } else if (state == SELD_MAILBOX_UNPLUGGED) {
        reset(controller);
        controller->is_powered = false;
        event->kind = SELD_UDC_UNPLUG;
    } else if (controller->is_powered && state == SELD_MAILBOX_SUSPENDED) {
        event->kind = SELD_UDC_SUSPEND;
    } else if (controller->is_powered && state == SELD_MAILBOX_RESUMED) {
        event->kind = SELD_UDC_RESUME;
    }
    seld_mailbox_write(&mailbox->device.bus_done, bus);
    return event->kind != SELD_UDC_NOTHING;
}

/* --- tokens: each returns the reply --- */
static void copy(uint8_t *to, const uint8_t *from, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) to[i] = from[i];
}

static seld_mailbox_reply setup(seld_mailbox_udc *controller, const seld_mailbox_host_half *token,
                                seld_udc_event *event)
{
    if (token->token_endpoint != 0 || token->token_bytes != SELD_UDC_SETUP_BYTES) return SELD_MAILBOX_SILENCE;
    if (token->token_flags & SELD_MAILBOX_DATA1) return SELD_MAILBOX_SILENCE;
    for (int way = 0; way < 2; way++) {
        seld_mailbox_endpoint *pipe = way ? &controller->in[0] : &controller->out[0];
        pipe->is_stalled = pipe->is_armed = false;
        pipe->toggle = true; /* data and status stages begin with DATA1 */
    }
    event->kind = SELD_UDC_SETUP;
    copy(event->setup, controller->mailbox->host_data, SELD_UDC_SETUP_BYTES);
    return SELD_MAILBOX_ACK;
}

static void finish(seld_mailbox_endpoint *pipe, uint8_t endpoint, seld_udc_event *event)
{
    pipe->is_armed = false;
    event->kind = SELD_UDC_DONE;
    event->endpoint = endpoint;
    event->bytes = pipe->done;
}

static seld_mailbox_reply out(seld_mailbox_udc *controller, const seld_mailbox_host_half *token,
                              seld_udc_event *event)
{
    seld_mailbox_endpoint *pipe = &controller->out[token->token_endpoint];
    uint32_t bytes = token->token_bytes;
    if (!pipe->is_open || bytes > pipe->packet_bytes) return SELD_MAILBOX_SILENCE;
    if (pipe->is_stalled) return SELD_MAILBOX_STALL;
    bool toggle = (token->token_flags & SELD_MAILBOX_DATA1) != 0;
    if (toggle != pipe->toggle) return SELD_MAILBOX_ACK; /* the host missed our last ACK: it sends again */
    if (!pipe->is_armed) return SELD_MAILBOX_NAK;
    uint32_t room = pipe->count - pipe->done;
    if (bytes > room) { /* more than was asked for: a protocol error of the host */
        udc_stall(controller, (uint8_t)token->token_endpoint);
        return SELD_MAILBOX_STALL;
    }
    copy(pipe->bytes + pipe->done, controller->mailbox->host_data, bytes);
    pipe->toggle = !pipe->toggle;
    pipe->done += bytes;
    if (bytes < pipe->packet_bytes || pipe->done == pipe->count)
        finish(pipe, (uint8_t)token->token_endpoint, event);
    return SELD_MAILBOX_ACK;
}

static seld_mailbox_reply in(seld_mailbox_udc *controller, const seld_mailbox_host_half *token,
                             uint32_t *reply_bytes, seld_udc_event *event)
{
    seld_mailbox_endpoint *pipe = &controller->in[token->token_endpoint];
    if (!pipe->is_open) return SELD_MAILBOX_SILENCE;
    if (pipe->is_stalled) return SELD_MAILBOX_STALL;
    if (!pipe->is_armed) return SELD_MAILBOX_NAK;
    uint32_t bytes = pipe->count - pipe->done;
    if (bytes > pipe->packet_bytes) bytes = pipe->packet_bytes;
    copy(controller->mailbox->device_data, pipe->bytes + pipe->done, bytes);
    *reply_bytes = bytes;
    bool toggle = pipe->toggle;
    if (!(token->token_flags & SELD_MAILBOX_LOST_ACK)) {
        pipe->toggle = !toggle;
        pipe->done += bytes;
        if (pipe->done == pipe->count) finish(pipe, (uint8_t)(token->token_endpoint | SELD_UDC_IN), event);
    }
    return toggle ? SELD_MAILBOX_REPLY_DATA1 : SELD_MAILBOX_REPLY_DATA0;
}

static void take_token(seld_mailbox_udc *controller, seld_udc_event *event)
{
    seld_mailbox *mailbox = controller->mailbox;
    uint32_t number = seld_mailbox_read(&mailbox->host.token);
    if (number == seld_mailbox_read(&mailbox->device.token_done)) return;
    const seld_mailbox_host_half token = {
        .token_kind = seld_mailbox_read(&mailbox->host.token_kind),
        .token_flags = seld_mailbox_read(&mailbox->host.token_flags),
        .token_address = seld_mailbox_read(&mailbox->host.token_address),
        .token_endpoint = seld_mailbox_read(&mailbox->host.token_endpoint),
        .token_bytes = seld_mailbox_read(&mailbox->host.token_bytes),
    };
    uint32_t reply_bytes = 0;
    seld_mailbox_reply reply = SELD_MAILBOX_SILENCE;
    if (controller->is_powered && token.token_address == controller->address &&
        token.token_endpoint < SELD_MAILBOX_ENDPOINT_COUNT && token.token_bytes <= SELD_MAILBOX_DATA_MAX) {
        if (token.token_kind == SELD_MAILBOX_SETUP) reply = setup(controller, &token, event);
        if (token.token_kind == SELD_MAILBOX_OUT) reply = out(controller, &token, event);
        if (token.token_kind == SELD_MAILBOX_IN) reply = in(controller, &token, &reply_bytes, event);
    }
    seld_mailbox_write(&mailbox->device.reply, reply);
    seld_mailbox_write(&mailbox->device.reply_bytes, reply_bytes);
    seld_mailbox_write(&mailbox->device.token_done, number);
}

static bool udc_poll(void *context, seld_udc_event *event)
{
    seld_mailbox_udc *controller = context;
    *event = (seld_udc_event){0};
    if (!take_bus(controller, event)) take_token(controller, event);
    return event->kind != SELD_UDC_NOTHING;
}

void seld_mailbox_udc_init(seld_mailbox_udc *controller, seld_mailbox *mailbox, bool can_high_speed)
{
    *controller = (seld_mailbox_udc){
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
    seld_mailbox_device_half *half = &mailbox->device;
    seld_mailbox_write(&half->attached, 0);
    seld_mailbox_write(&half->can_high_speed, can_high_speed);
    seld_mailbox_write(&half->test_selector, 0);
    seld_mailbox_write(&half->reply, SELD_MAILBOX_SILENCE);
    seld_mailbox_write(&half->reply_bytes, 0);
    seld_mailbox_write(&half->bus_done, seld_mailbox_read(&mailbox->host.bus));
    seld_mailbox_write(&half->token_done, seld_mailbox_read(&mailbox->host.token));
    seld_mailbox_write(&half->version, SELD_MAILBOX_VERSION);
    seld_mailbox_write(&half->boot_count, seld_mailbox_read(&half->boot_count) + 1);
    seld_mailbox_write(&half->magic, SELD_MAILBOX_MAGIC);
}

seld_mailbox_demand seld_mailbox_udc_demand(const seld_mailbox_udc *controller)
{
    const seld_mailbox *mailbox = controller->mailbox;
    if (seld_mailbox_read(&mailbox->host.bus) != mailbox->device.bus_done) return SELD_MAILBOX_BRINGS_WORK;
    if (seld_mailbox_read(&mailbox->host.token) == mailbox->device.token_done) return SELD_MAILBOX_IDLE;
    return mailbox->host.token_kind == SELD_MAILBOX_IN ? SELD_MAILBOX_ASKS_DATA : SELD_MAILBOX_BRINGS_WORK;
}
