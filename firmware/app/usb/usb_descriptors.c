/* The code writes every USB descriptor from the table (usb_table.def) when a host requests it. */
#include "firmware/app/usb/usb_internal.h"

const crn_usb_endpoint crn_usb_endpoints[CRN_USB_PIPE_COUNT] = {
#define USB_ENDPOINT(INTERFACE, NAME, address, type, full_bytes, full_interval, high_bytes, high_interval,   \
                     text)                                                                                   \
    {CRN_USB_INTERFACE_##INTERFACE, address, type, {full_bytes, high_bytes}, {full_interval, high_interval}},
#include CRN_USB_TABLE
};

const uint8_t crn_usb_interface_classes[CRN_USB_INTERFACE_COUNT] = {
#define USB_INTERFACE(NAME, class, text) class,
#include CRN_USB_TABLE
};

enum { /* indices of strings; 0 is the list of languages */
       STRING_LANGUAGES = 0,
#define USB_STRING(NAME, text) STRING_##NAME,
#include CRN_USB_TABLE
       STRING_COUNT,
};

static const char *const strings[STRING_COUNT] = {
    "",
#define USB_STRING(NAME, text) text,
#include CRN_USB_TABLE
};

static const uint8_t interface_strings[CRN_USB_INTERFACE_COUNT] = {
#define USB_INTERFACE(NAME, class, text) STRING_##NAME,
#include CRN_USB_TABLE
};

enum {
    USB_BCD = 0x0210, /* 2.1: the first version with a BOS descriptor */
    DEVICE_BCD = 0x0100,
    CLASS_HID = 3,
    SELF_POWERED = 0xc0,
    POWER_2mA = 50,
    LANGUAGE = 0x0409,          /* English, United States, which every host requests */
    MS_OS_WINDOWS = 0x06030000, /* 8.1, the first that reads the set */
    MS_OS_BYTES = 178,
};

void crn_usb_put_bytes(crn_wire_writer *reply, const uint8_t *bytes, size_t count)
{
    for (size_t i = 0; i < count; i++) crn_wire_write(reply, bytes[i], 1);
}

/* Writes an ASCII text as UTF-16, without a terminator. */
static void put_text(crn_wire_writer *reply, const char *text)
{
    while (*text != '\0') crn_wire_write(reply, (uint8_t)*text++, 2);
}

/* --- device and qualifier --- */
static void put_device(crn_wire_writer *reply)
{
    crn_wire_write(reply, 18, 1);
    crn_wire_write(reply, CRN_USB_DESCRIPTOR_DEVICE, 1);
    crn_wire_write(reply, USB_BCD, 2);
    crn_wire_write(reply, 0, 3); /* class, subclass and protocol belong to the interfaces */
    crn_wire_write(reply, CRN_UDC_CONTROL_PACKET_BYTES, 1);
    crn_wire_write(reply, CRN_USB_VENDOR_ID, 2);
    crn_wire_write(reply, CRN_USB_PRODUCT_ID, 2);
    crn_wire_write(reply, DEVICE_BCD, 2);
    crn_wire_write(reply, STRING_MANUFACTURER, 1);
    crn_wire_write(reply, STRING_PRODUCT, 1);
    crn_wire_write(reply, STRING_SERIAL, 1);
    crn_wire_write(reply, 1, 1); /* configurations */
}

static void put_qualifier(crn_wire_writer *reply)
{
    crn_wire_write(reply, 10, 1);
    crn_wire_write(reply, CRN_USB_DESCRIPTOR_QUALIFIER, 1);
    crn_wire_write(reply, USB_BCD, 2);
    crn_wire_write(reply, 0, 3);
    crn_wire_write(reply, CRN_UDC_CONTROL_PACKET_BYTES, 1);
    crn_wire_write(reply, 1, 1);
    crn_wire_write(reply, 0, 1);
}

/* --- configuration --- */
static void put_endpoint(crn_wire_writer *reply, const crn_usb_endpoint *row, uint8_t speed)
{
    crn_wire_write(reply, 7, 1);
    crn_wire_write(reply, CRN_USB_DESCRIPTOR_ENDPOINT, 1);
    crn_wire_write(reply, row->address, 1);
    crn_wire_write(reply, row->type, 1);
    crn_wire_write(reply, row->packet_bytes[speed], 2);
    crn_wire_write(reply, row->interval[speed], 1);
}

static void put_interface(crn_wire_writer *reply, int interface, uint8_t speed)
{
    unsigned endpoints = 0;
    for (int pipe = 0; pipe < CRN_USB_PIPE_COUNT; pipe++)
        endpoints += crn_usb_endpoints[pipe].interface == interface;
    crn_wire_write(reply, 9, 1);
    crn_wire_write(reply, CRN_USB_DESCRIPTOR_INTERFACE, 1);
    crn_wire_write(reply, (unsigned)interface, 1);
    crn_wire_write(reply, 0, 1); /* the only setting */
    crn_wire_write(reply, endpoints, 1);
    crn_wire_write(reply, crn_usb_interface_classes[interface], 1);
    crn_wire_write(reply, 0, 2); /* no subclass, no protocol */
    crn_wire_write(reply, interface_strings[interface], 1);
    if (crn_usb_interface_classes[interface] == CLASS_HID) crn_usb_hid_put_descriptor(reply);
    for (int pipe = 0; pipe < CRN_USB_PIPE_COUNT; pipe++)
        if (crn_usb_endpoints[pipe].interface == interface)
            put_endpoint(reply, &crn_usb_endpoints[pipe], speed);
}

static void put_configuration(crn_wire_writer *reply, uint8_t type, uint8_t speed)
{
    const size_t begin = reply->length;
    crn_wire_write(reply, 9, 1);
    crn_wire_write(reply, type, 1);
    crn_wire_write(reply, 0, 2); /* total length: written below */
    crn_wire_write(reply, CRN_USB_INTERFACE_COUNT, 1);
    crn_wire_write(reply, 1, 1); /* its value */
    crn_wire_write(reply, 0, 1); /* no string */
    crn_wire_write(reply, SELF_POWERED, 1);
    crn_wire_write(reply, POWER_2mA, 1);
    for (int interface = 0; interface < CRN_USB_INTERFACE_COUNT; interface++)
        put_interface(reply, interface, speed);
    crn_wire_writer total = crn_wire_writer_make(reply->bytes + begin + 2, 2);
    crn_wire_write(&total, reply->length - begin, 2);
}

static bool put_string(const crn_usb *usb, const crn_usb_setup *setup, crn_wire_writer *reply)
{
    const uint8_t index = (uint8_t)setup->value;
    if (index >= STRING_COUNT || (index != STRING_LANGUAGES && setup->index != LANGUAGE)) return false;
    crn_wire_write(reply, 0, 1); /* length: written below */
    crn_wire_write(reply, CRN_USB_DESCRIPTOR_STRING, 1);
    if (index == STRING_LANGUAGES) crn_wire_write(reply, LANGUAGE, 2);
    put_text(reply, index == STRING_SERIAL ? usb->config.serial : strings[index]);
    reply->bytes[0] = (uint8_t)reply->length;
    return true;
}

/* --- Microsoft OS 2.0: Windows takes its own WinUSB driver for the stream, without a file from us
 * ---------------- */
static void put_bos(crn_wire_writer *reply)
{
    /* The bytes are the identifier D8DD60DF-4589-4CC7-9CD2-659D9E648A9F, in their order on the bus. It
     * announces the set below. */
    static const uint8_t platform[16] = {0xdf, 0x60, 0xdd, 0xd8, 0x89, 0x45, 0xc7, 0x4c,
                                         0x9c, 0xd2, 0x65, 0x9d, 0x9e, 0x64, 0x8a, 0x9f};
    crn_wire_write(reply, 5, 1);
    crn_wire_write(reply, CRN_USB_DESCRIPTOR_BOS, 1);
    crn_wire_write(reply, 5 + 28, 2);
    crn_wire_write(reply, 1, 1);    /* capabilities */
    crn_wire_write(reply, 28, 1);   /* the platform capability */
    crn_wire_write(reply, 0x10, 1); /* device capability */
    crn_wire_write(reply, 0x05, 1); /* platform */
    crn_wire_write(reply, 0, 1);
    crn_usb_put_bytes(reply, platform, sizeof platform);
    crn_wire_write(reply, MS_OS_WINDOWS, 4);
    crn_wire_write(reply, MS_OS_BYTES, 2);
    crn_wire_write(reply, CRN_USB_REQUEST_MS_OS, 1);
    crn_wire_write(reply, 0, 1); /* no alternate enumeration */
}

/* Writes the Microsoft OS 2.0 descriptor set: a header (10 bytes), a configuration subset (8), a function
 * subset (8), a compatible id (20), and a registry property (132). */
bool crn_usb_ms_os_set(crn_wire_writer *reply)
{
    static const uint8_t compatible[16] = {'W', 'I', 'N', 'U', 'S', 'B'};
    crn_wire_write(reply, 10, 2);
    crn_wire_write(reply, 0, 2); /* set header */
    crn_wire_write(reply, MS_OS_WINDOWS, 4);
    crn_wire_write(reply, MS_OS_BYTES, 2);

    crn_wire_write(reply, 8, 2);
    crn_wire_write(reply, 1, 2); /* subset of configuration 0, the first */
    crn_wire_write(reply, 0, 2);
    crn_wire_write(reply, MS_OS_BYTES - 10, 2);

    crn_wire_write(reply, 8, 2);
    crn_wire_write(reply, 2, 2); /* subset of the function that begins with this interface */
    crn_wire_write(reply, CRN_USB_INTERFACE_STREAM, 2);
    crn_wire_write(reply, MS_OS_BYTES - 10 - 8, 2);

    crn_wire_write(reply, 20, 2);
    crn_wire_write(reply, 3, 2); /* compatible id, and no sub-compatible one */
    crn_usb_put_bytes(reply, compatible, sizeof compatible);

    crn_wire_write(reply, 132, 2);
    crn_wire_write(reply, 4, 2); /* registry property: a program finds the interface by it */
    crn_wire_write(reply, 7, 2); /* of type REG_MULTI_SZ */
    crn_wire_write(reply, 42, 2);
    put_text(reply, "DeviceInterfaceGUIDs");
    crn_wire_write(reply, 0, 2);
    crn_wire_write(reply, 80, 2);
    put_text(reply, "{41FDA16E-C12B-46E6-84D1-752D1013C5E4}");
    crn_wire_write(reply, 0, 4);
    return reply->length == MS_OS_BYTES;
}

/* --- which one --- */
bool crn_usb_descriptor(const crn_usb *usb, const crn_usb_setup *setup, crn_wire_writer *reply)
{
    const uint8_t type = (uint8_t)(setup->value >> 8);
    const bool can_high_speed = usb->config.udc->can_high_speed;
    if ((setup->type & CRN_USB_TYPE_RECIPIENT) == CRN_USB_TO_INTERFACE)
        return crn_usb_hid_class_descriptor(setup, reply);
    if (type == CRN_USB_DESCRIPTOR_STRING) return put_string(usb, setup, reply);
    if ((setup->value & 0xff) != 0 || setup->index != 0) return false; /* there is one of each */
    if (type == CRN_USB_DESCRIPTOR_DEVICE) put_device(reply);
    if (type == CRN_USB_DESCRIPTOR_CONFIGURATION) put_configuration(reply, type, usb->speed);
    if (type == CRN_USB_DESCRIPTOR_QUALIFIER && can_high_speed) put_qualifier(reply);
    if (type == CRN_USB_DESCRIPTOR_OTHER_SPEED && can_high_speed)
        put_configuration(reply, type,
                          usb->speed == CRN_UDC_HIGH_SPEED ? CRN_UDC_FULL_SPEED : CRN_UDC_HIGH_SPEED);
    if (type == CRN_USB_DESCRIPTOR_BOS) put_bos(reply);
    return reply->length > 0;
}
