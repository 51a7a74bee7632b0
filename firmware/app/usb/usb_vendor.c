/* Vendor requests to the device: the descriptors for Windows, and leaving the bus. */
#include "firmware/app/usb/usb_internal.h"

bool crn_usb_vendor(crn_usb *usb, const crn_usb_setup *setup, crn_wire_writer *reply)
{
    const uint8_t to_device = CRN_USB_TYPE_VENDOR | CRN_USB_TO_DEVICE;
    if (setup->type == (to_device | CRN_USB_TYPE_IN) && setup->request == CRN_USB_REQUEST_MS_OS)
        return setup->value == 0 && setup->index == 7 && crn_usb_ms_os_set(reply);
    if (setup->type != to_device || setup->request != CRN_USB_REQUEST_UNPLUG) return false;
    if (setup->value == 0 || setup->value > CRN_USB_OFF_MAX_ms || setup->length != 0) return false;
    usb->after_status = CRN_USB_AFTER_UNPLUG;
    usb->after_value = setup->value;
    usb->after_index = setup->index;
    return true;
}
