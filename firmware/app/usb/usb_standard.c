/* Standard requests (USB 2.0, 9.4). The device refuses requests whose meaning the USB standard does not
 * define. */
#include "firmware/app/usb/usb_internal.h"

enum { SELF_POWERED = 1, HALTED = 1 };

/* Returns the pipe of an endpoint address, or CRN_USB_PIPE_COUNT. */
static crn_usb_pipe pipe_of(uint16_t address)
{
    int pipe = 0;
    while (pipe < CRN_USB_PIPE_COUNT && crn_usb_endpoints[pipe].address != address) pipe++;
    return (crn_usb_pipe)pipe;
}

static bool is_control_endpoint(uint16_t address)
{
    return address == 0 || address == CRN_UDC_IN;
}

static bool interface_exists(const crn_usb *usb, uint16_t interface)
{
    return usb->configuration != 0 && interface < CRN_USB_INTERFACE_COUNT;
}

static bool endpoint_exists(const crn_usb *usb, uint16_t address)
{
    if (is_control_endpoint(address)) return true;
    return usb->configuration != 0 && pipe_of(address) < CRN_USB_PIPE_COUNT;
}

static bool get_status(const crn_usb *usb, const crn_usb_setup *setup, crn_wire_writer *reply)
{
    uint16_t status = 0;
    bool exists = false;
    switch (setup->type & CRN_USB_TYPE_RECIPIENT) {
    case CRN_USB_TO_DEVICE:
        exists = setup->index == 0;
        status = SELF_POWERED;
        break;
    case CRN_USB_TO_INTERFACE:
        exists = interface_exists(usb, setup->index);
        break;
    case CRN_USB_TO_ENDPOINT:
        exists = endpoint_exists(usb, setup->index);
        if (exists && !is_control_endpoint(setup->index) && usb->is_halted[pipe_of(setup->index)])
            status = HALTED;
        break;
    default:
        break;
    }
    crn_wire_write(reply, status, 2);
    return exists && setup->value == 0 && setup->length == 2;
}

static bool halt(crn_usb *usb, const crn_usb_setup *setup, bool set)
{
    const bool is_control = is_control_endpoint(setup->index);
    if (setup->value != CRN_USB_FEATURE_HALT || !endpoint_exists(usb, setup->index)) return false;
    if (is_control) return !set; /* endpoint 0 is never halted, so there is nothing to clear */
    if (set)
        crn_usb_pipe_halt(usb, pipe_of(setup->index));
    else
        crn_usb_pipe_open(usb, pipe_of(setup->index));
    return true;
}

/* The selector of the test mode is in the high byte of wIndex; test modes exist at high speed only (USB 2.0,
 * 9.4.9). */
static bool test_mode(crn_usb *usb, const crn_usb_setup *setup)
{
    const uint16_t selector = setup->index >> 8;
    if (setup->value != CRN_USB_FEATURE_TEST || (setup->index & 0xff) != 0) return false;
    if (usb->config.udc->test == NULL || usb->speed != CRN_UDC_HIGH_SPEED) return false;
    if (selector == 0 || selector > CRN_USB_TEST_MAX) return false;
    usb->after_status = CRN_USB_AFTER_TEST;
    usb->after_value = selector;
    return true;
}

static bool feature(crn_usb *usb, const crn_usb_setup *setup, bool set)
{
    if (setup->length != 0) return false;
    switch (setup->type & CRN_USB_TYPE_RECIPIENT) {
    case CRN_USB_TO_DEVICE:
        return set && test_mode(usb, setup); /* remote wake-up is not offered */
    case CRN_USB_TO_ENDPOINT:
        return halt(usb, setup, set);
    default:
        return false;
    }
}

static bool set_address(crn_usb *usb, const crn_usb_setup *setup)
{
    if (setup->value > 127 || setup->index != 0 || setup->length != 0 || usb->configuration != 0)
        return false;
    usb->after_status = CRN_USB_AFTER_ADDRESS;
    usb->after_value = setup->value;
    return true;
}

static bool set_configuration(crn_usb *usb, const crn_usb_setup *setup)
{
    if (usb->address == 0 || setup->value > 1 || setup->index != 0 || setup->length != 0) return false;
    crn_usb_configure(usb, (uint8_t)setup->value);
    return true;
}

/* There is one setting, 0. When the host chooses an alternate setting, the interface's endpoints return to
 * their initial state.
 */
static bool set_interface(crn_usb *usb, const crn_usb_setup *setup)
{
    if (!interface_exists(usb, setup->index) || setup->value != 0 || setup->length != 0) return false;
    for (int pipe = 0; pipe < CRN_USB_PIPE_COUNT; pipe++)
        if (crn_usb_endpoints[pipe].interface == setup->index) crn_usb_pipe_open(usb, (crn_usb_pipe)pipe);
    return true;
}

static bool to_device(crn_usb *usb, const crn_usb_setup *setup, crn_wire_writer *reply)
{
    switch (setup->request) {
    case CRN_USB_SET_ADDRESS:
        return set_address(usb, setup);
    case CRN_USB_SET_CONFIGURATION:
        return set_configuration(usb, setup);
    case CRN_USB_GET_DESCRIPTOR:
        return crn_usb_descriptor(usb, setup, reply);
    case CRN_USB_GET_CONFIGURATION:
        crn_wire_write(reply, usb->configuration, 1);
        return setup->value == 0 && setup->index == 0 && setup->length == 1;
    default:
        return false;
    }
}

static bool to_interface(crn_usb *usb, const crn_usb_setup *setup, crn_wire_writer *reply)
{
    switch (setup->request) {
    case CRN_USB_SET_INTERFACE:
        return set_interface(usb, setup);
    case CRN_USB_GET_DESCRIPTOR: /* of the HID class (HID 1.11, 7.1.1) */
        return crn_usb_descriptor(usb, setup, reply);
    case CRN_USB_GET_INTERFACE:
        crn_wire_write(reply, 0, 1);
        return interface_exists(usb, setup->index) && setup->value == 0 && setup->length == 1;
    default:
        return false;
    }
}

static bool goes_to_host(uint8_t request)
{
    return request == CRN_USB_GET_STATUS || request == CRN_USB_GET_DESCRIPTOR ||
           request == CRN_USB_GET_CONFIGURATION || request == CRN_USB_GET_INTERFACE;
}

bool crn_usb_standard(crn_usb *usb, const crn_usb_setup *setup, crn_wire_writer *reply)
{
    if (goes_to_host(setup->request) != ((setup->type & CRN_USB_TYPE_IN) != 0)) return false;
    switch (setup->request) {
    case CRN_USB_GET_STATUS:
        return get_status(usb, setup, reply);
    case CRN_USB_CLEAR_FEATURE:
    case CRN_USB_SET_FEATURE:
        return feature(usb, setup, setup->request == CRN_USB_SET_FEATURE);
    default:
        break;
    }
    switch (setup->type & CRN_USB_TYPE_RECIPIENT) {
    case CRN_USB_TO_DEVICE:
        return to_device(usb, setup, reply);
    case CRN_USB_TO_INTERFACE:
        return to_interface(usb, setup, reply);
    default:
        return false;
    }
}
