/* This file implements the HID interface: class requests (HID 1.11, 7.2), state reports, command reports, and
 * settings as feature reports. */
#include "firmware/app/usb/usb_internal.h"

enum { HID_BCD = 0x0111 };
enum { REPORT_INPUT = 1, REPORT_OUTPUT = 2, REPORT_FEATURE = 3 }; /* high byte of wValue */

static bool is_for_hid(const crn_usb *usb, const crn_usb_setup *setup)
{
    return usb->configuration != 0 && setup->index == CRN_USB_INTERFACE_STATUS &&
           (setup->type & CRN_USB_TYPE_RECIPIENT) == CRN_USB_TO_INTERFACE;
}

/* --- descriptors --- */
void crn_usb_hid_put_descriptor(crn_wire_writer *reply)
{
    crn_wire_write(reply, 9, 1);
    crn_wire_write(reply, CRN_USB_DESCRIPTOR_HID, 1);
    crn_wire_write(reply, HID_BCD, 2);
    crn_wire_write(reply, 0, 1); /* no country */
    crn_wire_write(reply, 1, 1);
    crn_wire_write(reply, CRN_USB_DESCRIPTOR_REPORT, 1);
    crn_wire_write(reply, CRN_HID_DESCRIPTOR_BYTES, 2);
}

bool crn_usb_hid_class_descriptor(const crn_usb_setup *setup, crn_wire_writer *reply)
{
    if (setup->index != CRN_USB_INTERFACE_STATUS || (setup->value & 0xff) != 0) return false;
    if (setup->value >> 8 == CRN_USB_DESCRIPTOR_HID)
        crn_usb_hid_put_descriptor(reply);
    else if (setup->value >> 8 == CRN_USB_DESCRIPTOR_REPORT)
        crn_usb_put_bytes(reply, crn_hid_descriptor, sizeof crn_hid_descriptor);
    return reply->length > 0;
}

/* --- reports to the host --- */
static bool put_state(const crn_usb *usb, crn_wire_writer *writer)
{
    crn_wire_write(writer, CRN_HID_ID_state, 1);
    return crn_hid_put_state(writer, &usb->state);
}

static bool put_feature(const crn_usb *usb, uint8_t id, crn_wire_writer *reply)
{
    const crn_usb_app *app = usb->config.app;
    crn_hid_identity identity = {0};
    crn_hid_capabilities capabilities = {0};
    crn_hid_calibration calibration = {0};
    crn_hid_limits limits = {0};
    crn_wire_write(reply, id, 1);
    switch (id) {
    case CRN_HID_ID_identity:
        app->identity(app->context, &identity);
        return crn_hid_put_identity(reply, &identity);
    case CRN_HID_ID_capabilities:
        app->capabilities(app->context, &capabilities);
        return crn_hid_put_capabilities(reply, &capabilities);
    case CRN_HID_ID_calibration:
        app->calibration(app->context, &calibration);
        return crn_hid_put_calibration(reply, &calibration);
    case CRN_HID_ID_limits:
        app->limits(app->context, &limits);
        return crn_hid_put_limits(reply, &limits);
    default:
        return false;
    }
}

static bool get_report(const crn_usb *usb, const crn_usb_setup *setup, crn_wire_writer *reply)
{
    const uint8_t id = (uint8_t)setup->value;
    switch (setup->value >> 8) {
    case REPORT_INPUT:
        return id == CRN_HID_ID_state && put_state(usb, reply);
    case REPORT_FEATURE:
        return put_feature(usb, id, reply);
    default:
        return false;
    }
}

/* The device stores the idle rates that a host sets, and the host can read them back. The idle rates of a
 * host have no effect, because every state report differs from the last one by its tick. */
bool crn_usb_hid_request(crn_usb *usb, const crn_usb_setup *setup, crn_wire_writer *reply)
{
    const bool to_host = (setup->type & CRN_USB_TYPE_IN) != 0;
    if (!is_for_hid(usb, setup)) return false;
    if (to_host && setup->request == CRN_USB_HID_GET_REPORT) return get_report(usb, setup, reply);
    if (to_host && setup->request == CRN_USB_HID_GET_IDLE) {
        crn_wire_write(reply, usb->hid_idle, 1);
        return setup->length == 1;
    }
    if (to_host || setup->request != CRN_USB_HID_SET_IDLE || setup->length != 0) return false;
    usb->hid_idle = (uint8_t)(setup->value >> 8);
    return true;
}

/* Drops state reports that waited for another host, or that were made before a halt, because they are out of
 * date. */
void crn_usb_hid_begin(crn_usb *usb)
{
    usb->report_first = usb->report_count = 0;
}

void crn_usb_hid_queue(crn_usb *usb, const crn_hid_state *state)
{
    usb->state = *state;
    if (usb->link != CRN_USB_CONFIGURED) return;
    if (usb->report_count == CRN_USB_REPORT_QUEUE) {
        usb->report_first = (usb->report_first + 1) % CRN_USB_REPORT_QUEUE;
        usb->report_count--;
        usb->reports_dropped++;
    }
    const uint32_t place = (usb->report_first + usb->report_count++) % CRN_USB_REPORT_QUEUE;
    crn_wire_writer writer = crn_wire_writer_make(usb->reports[place], CRN_HID_REPORT_BYTES_MAX);
    put_state(usb, &writer);
}

void crn_usb_hid_send(crn_usb *usb)
{
    if (usb->report_count == 0 || !crn_usb_pipe_is_free(usb, CRN_USB_STATUS_IN)) return;
    for (uint32_t i = 0; i < CRN_HID_REPORT_BYTES_MAX; i++)
        usb->report_in[i] = usb->reports[usb->report_first][i];
    usb->report_first = (usb->report_first + 1) % CRN_USB_REPORT_QUEUE;
    usb->report_count--;
    crn_usb_pipe_arm(usb, CRN_USB_STATUS_IN, usb->report_in, 1 + CRN_HID_BYTES_state);
}

/* --- reports from the host: `bytes` begin with the id --- */
static bool take_command(crn_usb *usb, const uint8_t *bytes, size_t count)
{
    crn_hid_command command;
    if (count == 0 || bytes[0] != CRN_HID_ID_command) return false;
    if (!crn_hid_decode_command(bytes + 1, count - 1, &command)) return false;
    usb->config.app->command(usb->config.app->context, &command);
    return true;
}

static bool take_feature(crn_usb *usb, const uint8_t *bytes, size_t count)
{
    const crn_usb_app *app = usb->config.app;
    crn_hid_calibration calibration;
    crn_hid_limits limits;
    if (count == 0) return false;
    switch (bytes[0]) {
    case CRN_HID_ID_calibration:
        return crn_hid_decode_calibration(bytes + 1, count - 1, &calibration) &&
               app->set_calibration(app->context, &calibration);
    case CRN_HID_ID_limits:
        return crn_hid_decode_limits(bytes + 1, count - 1, &limits) && app->set_limits(app->context, &limits);
    default:
        return false;
    }
}

bool crn_usb_hid_takes(const crn_usb *usb, const crn_usb_setup *setup)
{
    const bool is_class = (setup->type & CRN_USB_TYPE_KIND) == CRN_USB_TYPE_CLASS;
    return is_class && is_for_hid(usb, setup) && setup->request == CRN_USB_HID_SET_REPORT;
}

bool crn_usb_hid_data(crn_usb *usb, const crn_usb_setup *setup, const uint8_t *bytes, size_t count)
{
    if (count == 0 || bytes[0] != (uint8_t)setup->value) return false;
    switch (setup->value >> 8) {
    case REPORT_OUTPUT:
        return take_command(usb, bytes, count);
    case REPORT_FEATURE:
        return take_feature(usb, bytes, count);
    default:
        return false;
    }
}

/* An invalid HID report from the host is counted and changes nothing. After an invalid report the command
 * number in the state report does not change, so the host's program notices the refusal. The interrupt pipe
 * is not halted after an invalid report, because a halt would lose the next command. */
void crn_usb_hid_received(crn_usb *usb, uint32_t bytes)
{
    if (!take_command(usb, usb->report_out, bytes)) usb->reports_refused++;
    crn_usb_pipe_arm(usb, CRN_USB_STATUS_OUT, usb->report_out, sizeof usb->report_out);
}
