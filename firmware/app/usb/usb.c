/* Power-up, events and pipes. */
#include "firmware/app/usb/usb.h"
#include "firmware/app/usb/usb_internal.h"

static bool serial_is_good(const char *serial)
{
    uint32_t length = 0;
    while (length <= CRN_USB_SERIAL_MAX && serial[length] > ' ' && serial[length] < 127) length++;
    return length > 0 && length <= CRN_USB_SERIAL_MAX && serial[length] == '\0';
}

bool crn_usb_init(crn_usb *usb, const crn_usb_config *config)
{
    unsigned char *bytes = (unsigned char *)usb;
    for (size_t i = 0; i < sizeof *usb; i++) bytes[i] = 0;
    if (config->reply_bytes < CRN_WIRE_FRAME_MAX || config->reply_bytes > config->queue_bytes / 2)
        return false;
    if (!serial_is_good(config->serial)) return false;
    usb->config = *config;
    return true;
}

/* --- pipes --- */
void crn_usb_pipe_open(crn_usb *usb, crn_usb_pipe pipe)
{
    const crn_usb_endpoint *row = &crn_usb_endpoints[pipe];
    const crn_udc *udc = usb->config.udc;
    usb->is_armed[pipe] = false;
    /* An endpoint that the USB controller cannot provide stays halted, so the host's transfers to this
     * endpoint fail. */
    usb->is_halted[pipe] =
        !udc->open(udc->context, row->address, (crn_udc_type)row->type, row->packet_bytes[usb->speed]);
    if (pipe == CRN_USB_STATUS_IN) crn_usb_hid_begin(usb);
    if (pipe == CRN_USB_STREAM_IN) crn_usb_stream_begin(usb, true);
    if (pipe == CRN_USB_STREAM_OUT) crn_usb_stream_begin(usb, false);
    if (pipe == CRN_USB_STATUS_OUT) crn_usb_pipe_arm(usb, pipe, usb->report_out, sizeof usb->report_out);
}

void crn_usb_pipe_halt(crn_usb *usb, crn_usb_pipe pipe)
{
    usb->config.udc->stall(usb->config.udc->context, crn_usb_endpoints[pipe].address);
    usb->is_halted[pipe] = true;
    usb->is_armed[pipe] = false;
}

void crn_usb_pipe_arm(crn_usb *usb, crn_usb_pipe pipe, uint8_t *bytes, uint32_t count)
{
    if (!crn_usb_pipe_is_free(usb, pipe)) return;
    usb->is_armed[pipe] = true;
    usb->config.udc->arm(usb->config.udc->context, crn_usb_endpoints[pipe].address, bytes, count);
}

bool crn_usb_pipe_is_free(const crn_usb *usb, crn_usb_pipe pipe)
{
    return usb->configuration != 0 && !usb->is_halted[pipe] && !usb->is_armed[pipe];
}

static void pipe_done(crn_usb *usb, uint8_t endpoint, uint32_t bytes)
{
    for (int pipe = 0; pipe < CRN_USB_PIPE_COUNT; pipe++) {
        if (crn_usb_endpoints[pipe].address != endpoint || !usb->is_armed[pipe]) continue;
        usb->is_armed[pipe] = false;
        if (pipe == CRN_USB_STATUS_OUT) crn_usb_hid_received(usb, bytes);
        if (pipe == CRN_USB_STREAM_IN) crn_usb_stream_sent(usb, bytes);
        if (pipe == CRN_USB_STREAM_OUT) {
            if (usb->off_packets > 0 && --usb->off_packets == 0) {
                crn_usb_leave(usb);
                return;
            }
            crn_usb_stream_received(usb, bytes);
        }
    }
}

/* --- states of the device --- */
void crn_usb_tell_link(crn_usb *usb)
{
    uint8_t link = CRN_USB_DETACHED;
    if (usb->configuration != 0) link = usb->is_suspended ? CRN_USB_SUSPENDED : CRN_USB_CONFIGURED;
    if (link == usb->link) return;
    usb->link = link;
    usb->config.app->link(usb->config.app->context, (crn_usb_link)link);
}

void crn_usb_configure(crn_usb *usb, uint8_t configuration)
{
    const crn_udc *udc = usb->config.udc;
    usb->configuration = configuration;
    for (int pipe = 0; pipe < CRN_USB_PIPE_COUNT; pipe++) {
        if (configuration != 0)
            crn_usb_pipe_open(usb, (crn_usb_pipe)pipe);
        else
            udc->close(udc->context, crn_usb_endpoints[pipe].address);
        usb->is_armed[pipe] = usb->is_armed[pipe] && configuration != 0;
    }
    crn_usb_tell_link(usb);
}

/* After a bus reset, after the cable is unplugged, and before the device connects, the USB address is 0,
 * nothing is configured, and no transfer runs. */
static void to_default(crn_usb *usb)
{
    usb->address = 0;
    usb->configuration = 0;
    usb->is_suspended = false;
    usb->off_packets = 0;
    usb->hid_idle = 0;
    for (int pipe = 0; pipe < CRN_USB_PIPE_COUNT; pipe++) usb->is_armed[pipe] = usb->is_halted[pipe] = false;
    crn_usb_control_reset(usb);
    crn_usb_tell_link(usb);
}

void crn_usb_connect(crn_usb *usb, bool connected)
{
    const crn_udc *udc = usb->config.udc;
    usb->is_connected = connected;
    usb->off_ms = 0;
    udc->connect(udc->context, connected);
    to_default(usb);
}

void crn_usb_leave(crn_usb *usb)
{
    crn_usb_connect(usb, false);
    usb->off_ms = usb->off_value_ms;
}

/* --- events --- */
static void take_event(crn_usb *usb, const crn_udc_event *event)
{
    switch (event->kind) {
    case CRN_UDC_RESET:
        usb->speed = event->speed == CRN_UDC_HIGH_SPEED ? CRN_UDC_HIGH_SPEED : CRN_UDC_FULL_SPEED;
        to_default(usb);
        break;
    case CRN_UDC_UNPLUG:
        to_default(usb);
        break;
    case CRN_UDC_SUSPEND:
    case CRN_UDC_RESUME:
        usb->is_suspended = event->kind == CRN_UDC_SUSPEND;
        crn_usb_tell_link(usb);
        break;
    case CRN_UDC_SETUP:
        crn_usb_control_setup(usb, event->setup);
        break;
    case CRN_UDC_DONE:
        if ((event->endpoint & ~CRN_UDC_IN) == 0)
            crn_usb_control_done(usb, event->endpoint, event->bytes);
        else
            pipe_done(usb, event->endpoint, event->bytes);
        break;
    default:
        break;
    }
}

bool crn_usb_poll(crn_usb *usb)
{
    const crn_udc *udc = usb->config.udc;
    crn_udc_event event;
    int events = 0;
    while (events < CRN_USB_EVENTS_PER_POLL && udc->poll(udc->context, &event)) {
        take_event(usb, &event);
        events++;
    }
    bool more = crn_usb_stream_deliver(usb);
    crn_usb_hid_send(usb);
    crn_usb_stream_send(usb);
    return more || events == CRN_USB_EVENTS_PER_POLL;
}

void crn_usb_timer(crn_usb *usb, const crn_hid_state *state)
{
    crn_usb_hid_queue(usb, state);
    if (usb->off_ms == 0) return;
    usb->off_ms--;
    if (usb->off_ms == 0) crn_usb_connect(usb, true);
}
