/* Are these descriptors right? Checks USB descriptors against the standards (USB 2.0 chapter 9, HID 1.11
 * section 6, Microsoft OS 2.0). The checks do not use the table from which the firmware makes the
 * descriptors. */
#ifndef CRN_USB_JUDGE_H
#define CRN_USB_JUDGE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { USB_JUDGE_ENDPOINT_MAX = 16, USB_JUDGE_REPORT_MAX = 32 };

typedef struct usb_judged_endpoint {
    uint8_t interface, address, type, interval;
    uint16_t packet_bytes;
} usb_judged_endpoint;

typedef struct usb_judged {
    uint8_t interface_count, endpoint_count;
    uint8_t interface_classes[8];
    usb_judged_endpoint endpoints[USB_JUDGE_ENDPOINT_MAX];
    uint16_t report_descriptor_bytes; /* as stated in the HID descriptor; 0 without one */
} usb_judged;

typedef struct usb_judged_report {
    uint8_t kind; /* 1 input, 2 output, 3 feature, as in GET_REPORT */
    uint8_t id;
    uint32_t bits;
} usb_judged_report;

/* Every function returns NULL if the descriptors are correct, otherwise an error message. */
const char *usb_judge_device(const uint8_t *bytes, size_t count);
const char *usb_judge_qualifier(const uint8_t *bytes, size_t count, const uint8_t *device);
const char *usb_judge_configuration(const uint8_t *bytes, size_t count, uint8_t type, bool high_speed,
                                    usb_judged *judged);
const char *usb_judge_reports(const uint8_t *bytes, size_t count, usb_judged_report *reports,
                              size_t *report_count);
/* Besides checking the BOS descriptor, the function returns the vendor code and the length of the Microsoft
 * descriptor set that this descriptor announces. */
const char *usb_judge_bos(const uint8_t *bytes, size_t count, uint8_t *vendor_code, uint16_t *set_bytes);
const char *usb_judge_ms_os(const uint8_t *bytes, size_t count, uint8_t *first_interface);

#endif
