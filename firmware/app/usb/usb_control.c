/* This file handles USB control transfers, that is, the setup, data and status stages of endpoint 0.
 *
 *   request with data to the host     SETUP -> DATA_IN ---------------> (host's empty packet) -> idle
 *   request with data to the device   SETUP -> DATA_OUT -> STATUS_IN -> idle
 *   request without data              SETUP -------------> STATUS_IN -> idle
 *   refused                           SETUP -> STALL, until the next setup packet
 *
 * A new setup packet ends any control transfer that is in progress. The host may end a data stage early by
 * beginning the status stage. */
#include "firmware/app/usb/usb_internal.h"

enum { IDLE = 0, DATA_IN, DATA_OUT, STATUS_IN };

static void arm(crn_usb *usb, uint8_t endpoint, uint8_t *bytes, uint32_t count)
{
    usb->config.udc->arm(usb->config.udc->context, endpoint, bytes, count);
}

static void refuse(crn_usb *usb)
{
    usb->stage = IDLE;
    usb->after_status = CRN_USB_AFTER_NOTHING;
    usb->requests_refused++;
    usb->config.udc->stall(usb->config.udc->context, 0);
}

static void begin_status_in(crn_usb *usb)
{
    usb->stage = STATUS_IN;
    arm(usb, CRN_UDC_IN, usb->control, 0);
}

/* Sends at most as many bytes as the host requested. If the data are shorter than the host requested and fill
 * their last packet completely, the device sends an empty packet to show their end. */
static void begin_data_in(crn_usb *usb, const crn_usb_setup *setup, uint32_t count)
{
    if (count > setup->length) count = setup->length;
    usb->stage = DATA_IN;
    usb->ends_empty = count != 0 && count < setup->length && count % CRN_UDC_CONTROL_PACKET_BYTES == 0;
    arm(usb, 0, usb->control, 0); /* the status stage, whenever the host starts it */
    arm(usb, CRN_UDC_IN, usb->control, count);
}

void crn_usb_control_reset(crn_usb *usb)
{
    usb->stage = IDLE;
    usb->after_status = CRN_USB_AFTER_NOTHING;
    usb->ends_empty = false;
}

/* --- who answers what --- */
static bool answer(crn_usb *usb, const crn_usb_setup *setup, crn_wire_writer *reply)
{
    switch (setup->type & CRN_USB_TYPE_KIND) {
    case CRN_USB_TYPE_STANDARD:
        return crn_usb_standard(usb, setup, reply);
    case CRN_USB_TYPE_CLASS:
        return crn_usb_hid_request(usb, setup, reply);
    case CRN_USB_TYPE_VENDOR:
        return crn_usb_vendor(usb, setup, reply);
    default:
        return false;
    }
}

static crn_usb_setup parse(const uint8_t bytes[CRN_UDC_SETUP_BYTES])
{
    crn_wire_reader reader = crn_wire_reader_make(bytes, CRN_UDC_SETUP_BYTES);
    crn_usb_setup setup;
    setup.type = (uint8_t)crn_wire_read(&reader, 1);
    setup.request = (uint8_t)crn_wire_read(&reader, 1);
    setup.value = (uint16_t)crn_wire_read(&reader, 2);
    setup.index = (uint16_t)crn_wire_read(&reader, 2);
    setup.length = (uint16_t)crn_wire_read(&reader, 2);
    return setup;
}

void crn_usb_control_setup(crn_usb *usb, const uint8_t bytes[CRN_UDC_SETUP_BYTES])
{
    crn_usb_control_reset(usb);
    const crn_usb_setup setup = usb->setup = parse(bytes);
    const bool to_host = (setup.type & CRN_USB_TYPE_IN) != 0;
    if (!to_host && setup.length != 0) { /* the data comes first and is judged when it is complete */
        if (setup.length > sizeof usb->control || !crn_usb_hid_takes(usb, &setup)) {
            refuse(usb);
            return;
        }
        usb->stage = DATA_OUT;
        arm(usb, 0, usb->control, setup.length);
        return;
    }
    crn_wire_writer reply = crn_wire_writer_make(usb->control, sizeof usb->control);
    if (!answer(usb, &setup, &reply) || reply.overflowed)
        refuse(usb);
    else if (to_host && setup.length != 0)
        begin_data_in(usb, &setup, (uint32_t)reply.length);
    else
        begin_status_in(usb); /* also for a request to the host of length 0 */
}

/* --- the end of a stage --- */
static void status_over(crn_usb *usb)
{
    const crn_udc *udc = usb->config.udc;
    const uint8_t after = usb->after_status;
    const uint16_t value = usb->after_value, index = usb->after_index;
    crn_usb_control_reset(usb);
    switch (after) {
    case CRN_USB_AFTER_ADDRESS:
        usb->address = (uint8_t)value;
        udc->set_address(udc->context, usb->address);
        break;
    case CRN_USB_AFTER_UNPLUG:
        usb->off_packets = index;
        usb->off_value_ms = value;
        if (index == 0) crn_usb_leave(usb);
        break;
    case CRN_USB_AFTER_TEST:
        udc->test(udc->context, (uint8_t)value);
        break;
    default:
        break;
    }
}

void crn_usb_control_done(crn_usb *usb, uint8_t endpoint, uint32_t bytes)
{
    const bool is_in = (endpoint & CRN_UDC_IN) != 0;
    if (usb->stage == DATA_IN && is_in && usb->ends_empty) {
        usb->ends_empty = false;
        arm(usb, CRN_UDC_IN, usb->control, 0);
    } else if (usb->stage == DATA_IN && !is_in) {
        crn_usb_control_reset(usb);
    } else if (usb->stage == DATA_OUT && !is_in) {
        bool is_whole = bytes == usb->setup.length;
        if (is_whole && crn_usb_hid_data(usb, &usb->setup, usb->control, bytes))
            begin_status_in(usb);
        else
            refuse(usb);
    } else if (usb->stage == STATUS_IN && is_in) {
        status_over(usb);
    }
}
