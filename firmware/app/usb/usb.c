/* Power-up, events and pipes. Called by: firmware/port. */
#include "firmware/app/usb/usb.h"
#include "firmware/app/usb/usb_internal.h"

static bool serial_is_good(const char *serial)
{
    uint32_t length = 0;
    while (length <= SELD_USB_SERIAL_MAX && serial[length] > ' ' && serial[length] < 127) length++;
    return length > 0 && length <= SELD_USB_SERIAL_MAX && serial[length] == '\0';
}

bool seld_usb_init(seld_usb *usb, const seld_usb_config *config)
{
    unsigned char *bytes = (unsigned char *)usb;
    for (size_t i = 0; i < sizeof *usb; i++) bytes[i] = 0;
    if (config->reply_bytes < SELD_WIRE_FRAME_MAX || config->reply_bytes > config->queue_bytes / 2)
        return false;
    if (!serial_is_good(config->serial)) return false;
    usb->config = *config;
    return true;
}

/* --- pipes --- */
void seld_usb_pipe_open(seld_usb *usb, seld_usb_pipe pipe)
{
    const seld_usb_endpoint *row = &seld_usb_endpoints[pipe];
    const seld_udc *udc = usb->config.udc;
    usb->is_armed[pipe] = false;
    /* A controller that cannot have the endpoint leaves it halted: the host is told. */
    usb->is_halted[pipe] =
        !udc->open(udc->context, row->address, (seld_udc_type)row->type, row->packet_bytes[usb->speed]);
    if (pipe == SELD_USB_STATUS_IN) seld_usb_hid_begin(usb);
    if (pipe == SELD_USB_STREAM_IN) seld_usb_stream_begin(usb, true);
    if (pipe == SELD_USB_STREAM_OUT) seld_usb_stream_begin(usb, false);
    if (pipe == SELD_USB_STATUS_OUT) seld_usb_pipe_arm(usb, pipe, usb->report_out, sizeof usb->report_out);
}

void seld_usb_pipe_halt(seld_usb *usb, seld_usb_pipe pipe)
{
    usb->config.udc->stall(usb->config.udc->context, seld_usb_endpoints[pipe].address);
    usb->is_halted[pipe] = true;
    usb->is_armed[pipe] = false;
}

void seld_usb_pipe_arm(seld_usb *usb, seld_usb_pipe pipe, uint8_t *bytes, uint32_t count)
{
    if (!seld_usb_pipe_is_free(usb, pipe)) return;
    usb->is_armed[pipe] = true;
    usb->config.udc->arm(usb->config.udc->context, seld_usb_endpoints[pipe].address, bytes, count);
}

bool seld_usb_pipe_is_free(const seld_usb *usb, seld_usb_pipe pipe)
{
    return usb->configuration != 0 && !usb->is_halted[pipe] && !usb->is_armed[pipe];
}

static void pipe_done(seld_usb *usb, uint8_t endpoint, uint32_t bytes)
{
    for (int pipe = 0; pipe < SELD_USB_PIPE_COUNT; pipe++) {
        if (seld_usb_endpoints[pipe].address != endpoint || !usb->is_armed[pipe]) continue;
        usb->is_armed[pipe] = false;
        if (pipe == SELD_USB_STATUS_OUT) seld_usb_hid_received(usb, bytes);
        if (pipe == SELD_USB_STREAM_IN) seld_usb_stream_sent(usb, bytes);
        if (pipe == SELD_USB_STREAM_OUT) {
            if (usb->off_packets > 0 && --usb->off_packets == 0) {
                seld_usb_leave(usb);
                return;
            }
            seld_usb_stream_received(usb, bytes);
        }
    }
}

/* --- states of the device --- */
void seld_usb_tell_link(seld_usb *usb)
{
    uint8_t link = SELD_USB_DETACHED;
    if (usb->configuration != 0) link = usb->is_suspended ? SELD_USB_SUSPENDED : SELD_USB_CONFIGURED;
    if (link == usb->link) return;
    usb->link = link;
    usb->config.app->link(usb->config.app->context, (seld_usb_link)link);
}

void seld_usb_configure(seld_usb *usb, uint8_t configuration)
{
    const seld_udc *udc = usb->config.udc;
    usb->configuration = configuration;
    for (int pipe = 0; pipe < SELD_USB_PIPE_COUNT; pipe++) {
        if (configuration != 0)
            seld_usb_pipe_open(usb, (seld_usb_pipe)pipe);
        else
            udc->close(udc->context, seld_usb_endpoints[pipe].address);
        usb->is_armed[pipe] = usb->is_armed[pipe] && configuration != 0;
    }
    seld_usb_tell_link(usb);
}

/* Address 0, nothing configured, nothing under way: after a reset, an unplug and before a connect. */
static void to_default(seld_usb *usb)
{
    usb->address = 0;
    usb->configuration = 0;
    usb->is_suspended = false;
    usb->off_packets = 0;
    usb->hid_idle = 0;
    for (int pipe = 0; pipe < SELD_USB_PIPE_COUNT; pipe++) usb->is_armed[pipe] = usb->is_halted[pipe] = false;
    seld_usb_control_reset(usb);
    seld_usb_tell_link(usb);
}

void seld_usb_connect(seld_usb *usb, bool connected)
{
    const seld_udc *udc = usb->config.udc;
    usb->is_connected = connected;
    usb->off_ms = 0;
    udc->connect(udc->context, connected);
    to_default(usb);
}

void seld_usb_leave(seld_usb *usb)
{
    seld_usb_connect(usb, false);
    usb->off_ms = usb->off_value_ms;
}

/* --- events --- */
static void take_event(seld_usb *usb, const seld_udc_event *event)
{
    switch (event->kind) {
    case SELD_UDC_RESET:
        usb->speed = event->speed == SELD_UDC_HIGH_SPEED ? SELD_UDC_HIGH_SPEED : SELD_UDC_FULL_SPEED;
        to_default(usb);
        break;
    case SELD_UDC_UNPLUG:
        to_default(usb);
        break;
    case SELD_UDC_SUSPEND:
    case SELD_UDC_RESUME:
        usb->is_suspended = event->kind == SELD_UDC_SUSPEND;
        seld_usb_tell_link(usb);
        break;
    case SELD_UDC_SETUP:
        seld_usb_control_setup(usb, event->setup);
        break;
    case SELD_UDC_DONE:
        if ((event->endpoint & ~SELD_UDC_IN) == 0)
            seld_usb_control_done(usb, event->endpoint, event->bytes);
        else
            pipe_done(usb, event->endpoint, event->bytes);
        break;
    default:
        break;
    }
}

bool seld_usb_poll(seld_usb *usb)
{
    const seld_udc *udc = usb->config.udc;
    seld_udc_event event;
    int events = 0;
    while (events < SELD_USB_EVENTS_PER_POLL && udc->poll(udc->context, &event)) {
        take_event(usb, &event);
        events++;
    }
    bool more = seld_usb_stream_deliver(usb);
    seld_usb_hid_send(usb);
    seld_usb_stream_send(usb);
    return more || events == SELD_USB_EVENTS_PER_POLL;
}

void seld_usb_timer(seld_usb *usb, const seld_hid_state *state)
{
    seld_usb_hid_queue(usb, state);
    if (usb->off_ms == 0) return;
    usb->off_ms--;
    if (usb->off_ms == 0) seld_usb_connect(usb, true);
}
