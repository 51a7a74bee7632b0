/* For the library hidapi, this file does the work of the Linux drivers usbhid and hidraw. The code reads the
 * device's reports while a program has the device node open, and keeps the last 64 reports. The code also
 * sends the reports that programs write, and turns feature reports into control transfers. */
#include "hil_tests/l2/mock.h"

#include <errno.h>
#include <linux/hidraw.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

enum { STATUS_IN = 0x81, STATUS_OUT = 1, GET_REPORT = 1, SET_REPORT = 9, FEATURE = 3 };

static int request(mock *m, uint8_t type, uint8_t number, uint16_t value, uint16_t length, uint8_t *bytes,
                   uint32_t *count)
{
    const usb_request setup = {type, number, value, 0, length};
    return m->is_plugged ? mock_errno(usb_host_control(m->peer.host, &setup, bytes, count)) : ENODEV;
}

/* --- reports come in --- */
void mock_hidraw_step(mock *m)
{
    const usb_urb urb = {
        .id = 0, .endpoint = STATUS_IN, .bytes = m->hidraw_packet, .length = CRN_HID_REPORT_BYTES_MAX};
    if (m->hidraw_clients == 0 || m->hidraw_is_reading || m->hid_is_claimed || !m->is_plugged) return;
    m->hidraw_is_reading = usb_urbs_submit(&m->urbs, &urb);
}

static void stop_reading(mock *m)
{
    usb_urb urb;
    if (m->hidraw_is_reading) usb_urbs_cancel(&m->urbs, 0, &urb);
    m->hidraw_is_reading = false;
}

void mock_hidraw_unbind(mock *m)
{
    stop_reading(m);
    m->hid_is_claimed = true;
}

void mock_hidraw_complete(mock *m, const usb_urb *urb)
{
    static const uint8_t token = 1;
    m->hidraw_is_reading = false;
    if (urb->result != USB_OK || urb->done == 0) return;
    if (m->report_count == MOCK_REPORTS) {
        m->reports_lost++;
        return;
    }
    const uint32_t place = (m->report_first + m->report_count++) % MOCK_REPORTS;
    memcpy(m->reports[place], m->hidraw_packet, urb->done);
    m->report_bytes[place] = (uint8_t)urb->done;
    if (write(m->hidraw_fifo, &token, 1) != 1) m->reports_lost++;
}

gboolean mock_hidraw_read(UMockdevIoctlBase *base, UMockdevIoctlClient *client, mock *m)
{
    (void)base;
    UMockdevIoctlData *data = umockdev_ioctl_client_get_arg(client);
    uint8_t token;
    pthread_mutex_lock(&m->lock);
    if (!m->is_plugged || m->report_count == 0) {
        const int wrong = m->is_plugged ? EAGAIN : EIO;
        pthread_mutex_unlock(&m->lock);
        umockdev_ioctl_client_complete(client, -1, wrong);
        return TRUE;
    }
    int count = m->report_bytes[m->report_first];
    if (count > data->data_len) count = data->data_len;
    umockdev_ioctl_data_update(data, 0, m->reports[m->report_first], count);
    m->report_first = (m->report_first + 1) % MOCK_REPORTS;
    m->report_count--;
    const bool was_told = read(m->hidraw_fifo, &token, 1) == 1;
    pthread_mutex_unlock(&m->lock);
    umockdev_ioctl_client_complete(client, was_told ? count : -1, was_told ? 0 : EIO);
    return TRUE;
}

/* --- reports go out --- */
gboolean mock_hidraw_write(UMockdevIoctlBase *base, UMockdevIoctlClient *client, mock *m)
{
    (void)base;
    const UMockdevIoctlData *data = umockdev_ioctl_client_get_arg(client);
    pthread_mutex_lock(&m->lock);
    int wrong = m->is_plugged ? 0 : ENODEV;
    if (wrong == 0)
        wrong = mock_errno(usb_host_out(m->peer.host, STATUS_OUT, CRN_HID_REPORT_BYTES_MAX, data->data,
                                        (uint32_t)data->data_len));
    pthread_mutex_unlock(&m->lock);
    umockdev_ioctl_client_complete(client, wrong == 0 ? data->data_len : -1, wrong);
    return TRUE;
}

/* --- ioctls --- */
static int descriptor(mock *m, UMockdevIoctlData *argument)
{
    struct hidraw_report_descriptor *wanted;
    uint8_t bytes[HID_MAX_DESCRIPTOR_SIZE];
    uint32_t count = 0;
    const usb_request get = {0x81, 6, 0x2200, 0, sizeof bytes};
    if (!m->is_plugged || argument->data_len < (int)sizeof *wanted) return ENODEV;
    const int wrong = mock_errno(usb_host_control(m->peer.host, &get, bytes, &count));
    wanted = (struct hidraw_report_descriptor *)(void *)argument->data;
    if (wrong == 0) memcpy(wanted->value, bytes, count < wanted->size ? count : wanted->size);
    return wrong;
}

static int descriptor_size(mock *m, UMockdevIoctlData *argument)
{
    uint8_t hid[9];
    uint32_t count = 0;
    const usb_request get = {0x81, 6, 0x2100, 0, sizeof hid};
    const int wrong = m->is_plugged ? mock_errno(usb_host_control(m->peer.host, &get, hid, &count)) : ENODEV;
    int size = hid[7] | hid[8] << 8;
    if (wrong == 0) umockdev_ioctl_data_update(argument, 0, (guint8 *)(void *)&size, sizeof size);
    return wrong;
}

static int answer(mock *m, UMockdevIoctlClient *client, UMockdevIoctlData *argument, long *result)
{
    const unsigned long number = umockdev_ioctl_client_get_request(client);
    uint8_t *bytes = argument->data;
    uint32_t count = 0;
    int wrong;
    if (number == HIDIOCGRDESCSIZE) return descriptor_size(m, argument);
    if (number == HIDIOCGRDESC) return descriptor(m, argument);
    switch (_IOC_NR(number)) {
    case _IOC_NR(HIDIOCGFEATURE(0)):
        wrong = request(m, 0xa1, GET_REPORT, (uint16_t)(FEATURE << 8 | bytes[0]),
                        (uint16_t)argument->data_len, bytes, &count);
        *result = count;
        return wrong;
    case _IOC_NR(HIDIOCSFEATURE(0)):
        *result = argument->data_len;
        return request(m, 0x21, SET_REPORT, (uint16_t)(FEATURE << 8 | bytes[0]), (uint16_t)argument->data_len,
                       bytes, &count);
    default:
        return ENOTTY;
    }
}

gboolean mock_hidraw_ioctl(UMockdevIoctlBase *base, UMockdevIoctlClient *client, mock *m)
{
    (void)base;
    long result = 0;
    const gsize size = _IOC_SIZE(umockdev_ioctl_client_get_request(client));
    UMockdevIoctlData *argument = umockdev_ioctl_client_get_arg(client);
    UMockdevIoctlData *data = umockdev_ioctl_data_resolve(argument, 0, size, NULL);
    pthread_mutex_lock(&m->lock);
    const int wrong = data != NULL ? answer(m, client, data, &result) : EFAULT;
    pthread_mutex_unlock(&m->lock);
    umockdev_ioctl_client_complete(client, wrong == 0 ? result : -1, wrong);
    if (data != NULL) umockdev_ioctl_data_unref(data);
    return TRUE;
}

/* --- programs that have the node open --- */
void mock_hidraw_connected(UMockdevIoctlBase *base, UMockdevIoctlClient *client, mock *m)
{
    (void)base;
    (void)client;
    pthread_mutex_lock(&m->lock);
    m->hidraw_clients++;
    pthread_mutex_unlock(&m->lock);
}

void mock_hidraw_vanished(UMockdevIoctlBase *base, UMockdevIoctlClient *client, mock *m)
{
    (void)base;
    (void)client;
    uint8_t token;
    pthread_mutex_lock(&m->lock);
    if (--m->hidraw_clients == 0) {
        stop_reading(m);
        for (; m->report_count > 0; m->report_count--)
            if (read(m->hidraw_fifo, &token, 1) != 1) break;
        m->report_count = 0;
    }
    pthread_mutex_unlock(&m->lock);
}
