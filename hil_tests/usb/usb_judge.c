/* Checks descriptors against the standards. */
#include "hil_tests/usb/usb_judge.h"

#include <string.h>

#define WRONG_IF(condition, text)                                                                            \
    do {                                                                                                     \
        if (condition) return text;                                                                          \
    } while (0)

static unsigned word(const uint8_t *bytes)
{
    return (unsigned)bytes[0] | (unsigned)bytes[1] << 8;
}

const char *usb_judge_device(const uint8_t *bytes, size_t count)
{
    WRONG_IF(count != 18 || bytes[0] != 18 || bytes[1] != 1, "a device descriptor has 18 bytes and type 1");
    WRONG_IF(word(bytes + 2) < 0x0200, "bcdUSB of a high-speed device is 2.00 or later");
    WRONG_IF(bytes[7] != 8 && bytes[7] != 16 && bytes[7] != 32 && bytes[7] != 64,
             "bMaxPacketSize0 is 8, 16, 32 or 64");
    WRONG_IF(word(bytes + 8) == 0, "idVendor is not 0");
    WRONG_IF(bytes[17] == 0, "there is a configuration");
    return NULL;
}

const char *usb_judge_qualifier(const uint8_t *bytes, size_t count, const uint8_t *device)
{
    WRONG_IF(count != 10 || bytes[0] != 10 || bytes[1] != 6, "a qualifier has 10 bytes and type 6");
    WRONG_IF(memcmp(bytes + 2, device + 2, 6) != 0,
             "version, class and packet size as in the device descriptor");
    WRONG_IF(bytes[8] != device[17], "as many configurations as at the other speed");
    WRONG_IF(bytes[9] != 0, "the reserved byte is 0");
    return NULL;
}

/* --- configuration --- */
static const char *judge_endpoint(const uint8_t *bytes, bool high_speed, usb_judged *judged)
{
    const usb_judged_endpoint row = {
        .interface = (uint8_t)(judged->interface_count - 1),
        .address = bytes[2],
        .type = bytes[3] & 3,
        .interval = bytes[6],
        .packet_bytes = (uint16_t)word(bytes + 4),
    };
    WRONG_IF(bytes[0] != 7, "an endpoint descriptor has 7 bytes");
    WRONG_IF((row.address & 0x70) != 0 || (row.address & 0x0f) == 0, "an endpoint's number is 1 .. 15");
    WRONG_IF((bytes[3] & 0xfc) != 0, "bulk and interrupt endpoints have no other attributes");
    for (int i = 0; i < judged->endpoint_count; i++)
        WRONG_IF(judged->endpoints[i].address == row.address, "an address stands once");
    if (row.type == 2) {
        const unsigned bytes_of_packet = row.packet_bytes;
        WRONG_IF(high_speed && bytes_of_packet != 512, "bulk packets have 512 bytes at high speed");
        WRONG_IF(!high_speed && bytes_of_packet != 8 && bytes_of_packet != 16 && bytes_of_packet != 32 &&
                     bytes_of_packet != 64,
                 "bulk packets have 8, 16, 32 or 64 bytes at full speed");
    } else if (row.type == 3) {
        WRONG_IF(row.packet_bytes > (high_speed ? 1024 : 64),
                 "an interrupt packet of this speed is not so long");
        WRONG_IF(row.interval == 0 || (high_speed && row.interval > 16),
                 "an interrupt interval is 1 .. 255 or 16");
    } else {
        return "only bulk and interrupt endpoints are expected";
    }
    WRONG_IF(judged->endpoint_count == USB_JUDGE_ENDPOINT_MAX, "too many endpoints");
    judged->endpoints[judged->endpoint_count++] = row;
    return NULL;
}

static const char *judge_part(const uint8_t *bytes, const uint8_t *before, bool high_speed,
                              usb_judged *judged, int *endpoints_left)
{
    switch (bytes[1]) {
    case 4:
        WRONG_IF(bytes[0] != 9, "an interface descriptor has 9 bytes");
        WRONG_IF(*endpoints_left > 0, "an interface has as many endpoints as it says");
        WRONG_IF(bytes[2] != judged->interface_count, "interfaces are numbered from 0, without gaps");
        WRONG_IF(bytes[3] != 0, "the first setting of an interface is 0");
        WRONG_IF(judged->interface_count == sizeof judged->interface_classes, "too many interfaces");
        judged->interface_classes[judged->interface_count++] = bytes[5];
        *endpoints_left = bytes[4];
        return NULL;
    case 5:
        WRONG_IF(*endpoints_left <= 0, "an endpoint stands below an interface that counts it");
        --*endpoints_left;
        return judge_endpoint(bytes, high_speed, judged);
    case 0x21:
        WRONG_IF(before[1] != 4 || before[5] != 3, "a HID descriptor follows its interface");
        WRONG_IF(bytes[0] != 9 || bytes[5] != 1 || bytes[6] != 0x22,
                 "a HID descriptor names one report descriptor");
        judged->report_descriptor_bytes = (uint16_t)word(bytes + 7);
        return NULL;
    default:
        return "a descriptor of unknown type";
    }
}

const char *usb_judge_configuration(const uint8_t *bytes, size_t count, uint8_t type, bool high_speed,
                                    usb_judged *judged)
{
    memset(judged, 0, sizeof *judged);
    WRONG_IF(count < 9 || bytes[0] != 9 || bytes[1] != type,
             "a configuration begins with 9 bytes of its type");
    WRONG_IF(word(bytes + 2) != count, "wTotalLength is the length of the whole");
    WRONG_IF(bytes[5] == 0, "value 0 means: not configured");
    WRONG_IF((bytes[7] & 0x80) == 0 || (bytes[7] & 0x1f) != 0,
             "bit 7 of the attributes is 1, bits 4 .. 0 are 0");
    int endpoints_left = 0;
    size_t place = 9, before = 0;
    while (place < count) {
        WRONG_IF(count - place < 2 || bytes[place] < 2 || bytes[place] > count - place,
                 "a part exceeds the whole");
        const char *wrong = judge_part(bytes + place, bytes + before, high_speed, judged, &endpoints_left);
        if (wrong != NULL) return wrong;
        before = place;
        place += bytes[place];
    }
    WRONG_IF(endpoints_left != 0, "the last interface has as many endpoints as it says");
    WRONG_IF(judged->interface_count != bytes[4], "bNumInterfaces counts the interfaces");
    return NULL;
}

/* --- HID report descriptor: short items, tag and type in the upper six bits of the first byte --- */
static usb_judged_report *report_of(usb_judged_report *reports, size_t *count, uint8_t kind, uint8_t id)
{
    for (size_t i = 0; i < *count; i++)
        if (reports[i].kind == kind && reports[i].id == id) return &reports[i];
    if (*count == USB_JUDGE_REPORT_MAX) return NULL;
    reports[*count] = (usb_judged_report){kind, id, 0};
    return &reports[(*count)++];
}

const char *usb_judge_reports(const uint8_t *bytes, size_t count, usb_judged_report *reports,
                              size_t *report_count)
{
    uint32_t size = 0, items = 0, id = 0;
    int depth = 0;
    *report_count = 0;
    for (size_t place = 0; place < count;) {
        const uint8_t head = bytes[place];
        const size_t data_bytes = (head & 3) == 3 ? 4 : head & 3;
        uint32_t value = 0;
        WRONG_IF(head == 0xfe, "no long items are expected");
        WRONG_IF(data_bytes > count - place - 1, "an item exceeds the descriptor");
        for (size_t i = 0; i < data_bytes; i++) value |= (uint32_t)bytes[place + 1 + i] << (8 * i);
        place += 1 + data_bytes;
        const uint8_t tag = head & 0xfc;
        if (tag == 0x74) size = value;
        if (tag == 0x94) items = value;
        if (tag == 0x84) id = value;
        if (tag == 0xa0) depth++;
        if (tag == 0xc0) depth--;
        WRONG_IF(depth < 0, "a collection ends that did not begin");
        if (tag != 0x80 && tag != 0x90 && tag != 0xb0) continue;
        WRONG_IF(depth == 0, "a report stands outside every collection");
        WRONG_IF(id == 0 || id > 255, "every report has an id of 1 .. 255");
        usb_judged_report *report = report_of(reports, report_count,
                                              tag == 0x80   ? 1
                                              : tag == 0x90 ? 2
                                                            : 3,
                                              (uint8_t)id);
        WRONG_IF(report == NULL, "too many reports");
        report->bits += size * items;
    }
    WRONG_IF(depth != 0, "a collection does not end");
    return NULL;
}

/* --- Microsoft OS 2.0 --- */
const char *usb_judge_bos(const uint8_t *bytes, size_t count, uint8_t *vendor_code, uint16_t *set_bytes)
{
    static const uint8_t ms_os[16] = {0xdf, 0x60, 0xdd, 0xd8, 0x89, 0x45, 0xc7, 0x4c,
                                      0x9c, 0xd2, 0x65, 0x9d, 0x9e, 0x64, 0x8a, 0x9f};
    WRONG_IF(count < 5 || bytes[0] != 5 || bytes[1] != 15, "a BOS descriptor begins with 5 bytes of type 15");
    WRONG_IF(word(bytes + 2) != count, "wTotalLength is the length of the whole");
    size_t place = 5;
    unsigned capabilities = 0;
    bool found = false;
    while (place < count) {
        const uint8_t *part = bytes + place;
        WRONG_IF(count - place < 3 || part[0] < 3 || part[0] > count - place,
                 "a capability exceeds the whole");
        WRONG_IF(part[1] != 16, "capabilities have type 16");
        if (part[2] == 5 && part[0] == 28 && memcmp(part + 4, ms_os, sizeof ms_os) == 0) {
            found = true;
            *set_bytes = (uint16_t)word(part + 24);
            *vendor_code = part[26];
        }
        capabilities++;
        place += part[0];
    }
    WRONG_IF(capabilities != bytes[4], "bNumDeviceCaps counts the capabilities");
    WRONG_IF(!found, "the Microsoft platform capability is missing");
    return NULL;
}

/* Checks a registry property in a Microsoft OS descriptor: UTF-16 text of type REG_MULTI_SZ, which ends with
 * two zeros. */
static const char *judge_property(const uint8_t *bytes, size_t count)
{
    WRONG_IF(count < 10 || word(bytes + 4) != 7, "the property is a REG_MULTI_SZ");
    const size_t name_bytes = word(bytes + 6);
    WRONG_IF(name_bytes % 2 != 0 || name_bytes + 10 > count, "the property's name exceeds it");
    WRONG_IF(bytes[8] != 'D' || word(bytes + 8 + name_bytes - 2) != 0, "the name is zero-terminated");
    const uint8_t *data = bytes + 10 + name_bytes;
    const size_t data_bytes = word(data - 2);
    WRONG_IF(10 + name_bytes + data_bytes != count, "name and data fill the property");
    WRONG_IF(data_bytes != 80 || data[0] != '{' || data[74] != '}', "the data is one GUID in braces");
    WRONG_IF(word(data + 76) != 0 || word(data + 78) != 0, "a multi-string ends with two zeros");
    return NULL;
}

const char *usb_judge_ms_os(const uint8_t *bytes, size_t count, uint8_t *first_interface)
{
    WRONG_IF(count < 10 || word(bytes) != 10 || word(bytes + 2) != 0, "the set begins with its header");
    WRONG_IF(word(bytes + 8) != count, "wTotalLength is the length of the whole");
    WRONG_IF(count < 26 || word(bytes + 10) != 8 || word(bytes + 12) != 1, "a configuration subset follows");
    WRONG_IF(bytes[14] != 0 || word(bytes + 16) != count - 10,
             "it is for configuration index 0 and fills the rest");
    WRONG_IF(word(bytes + 18) != 8 || word(bytes + 20) != 2, "a function subset follows");
    WRONG_IF(word(bytes + 24) != count - 18, "it fills the rest");
    *first_interface = bytes[22];
    bool has_id = false, has_property = false;
    for (size_t place = 26; place < count;) {
        const uint8_t *part = bytes + place;
        WRONG_IF(count - place < 4 || word(part) < 4 || word(part) > count - place,
                 "a feature exceeds the whole");
        if (word(part + 2) == 3) {
            WRONG_IF(word(part) != 20 || memcmp(part + 4, "WINUSB\0\0", 8) != 0,
                     "the compatible id is WINUSB");
            has_id = true;
        } else if (word(part + 2) == 4) {
            const char *wrong = judge_property(part, word(part));
            if (wrong != NULL) return wrong;
            has_property = true;
        } else {
            return "a feature of unknown type";
        }
        place += word(part);
    }
    WRONG_IF(!has_id || !has_property, "compatible id and interface GUID are both needed");
    return NULL;
}
