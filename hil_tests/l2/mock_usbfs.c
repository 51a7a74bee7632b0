/* For the library libusb, this file does the work of the Linux driver usbfs: programs submit, fetch and
 * cancel transfers by ioctl calls. The argument of an ioctl call is a pointer in the memory of the program;
 * umockdev_ioctl_data_resolve() copies the data to which it points. */
#include "hil_tests/l2/mock.h"

#include <errno.h>
#include <linux/usbdevice_fs.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

int mock_errno(usb_result result)
{
    switch (result) {
    case USB_OK:
        return 0;
    case USB_STALLED:
        return EPIPE;
    case USB_BROKEN:
        return EOVERFLOW;
    case USB_SILENT:
        return EPROTO;
    default:
        return ETIMEDOUT;
    }
}

static struct usbdevfs_urb *header_of(mock_urb *one)
{
    return (struct usbdevfs_urb *)(void *)one->urb->data;
}

/* --- the node is ready while something can be reaped --- */
static void tell_ready(mock *m)
{
    uint8_t bytes[MOCK_PIPE_BYTES] = {0};
    bool any = !m->is_plugged;
    for (const mock_urb *one = m->first; one != NULL; one = one->next) any = any || one->is_done;
    if (any && m->usbfs_is_full) {
        while (read(m->usbfs_fifo, bytes, sizeof bytes) > 0) {
        }
        m->usbfs_is_full = false;
    } else if (!any && !m->usbfs_is_full) {
        while (write(m->usbfs_fifo, bytes, sizeof bytes) > 0) {
        }
        while (write(m->usbfs_fifo, bytes, 1) > 0) {
        }
        m->usbfs_is_full = true;
    }
}

static void finish(mock *m, mock_urb *one, int status, uint32_t done)
{
    struct usbdevfs_urb *header = header_of(one);
    header->status = -status;
    header->actual_length = (int)done;
    one->is_done = true;
    tell_ready(m);
}

void mock_usbfs_complete(mock *m, const usb_urb *urb)
{
    for (mock_urb *one = m->first; one != NULL; one = one->next)
        if ((uint64_t)(uintptr_t)one == urb->id) finish(m, one, mock_errno(urb->result), urb->done);
}

/* Ends the transfers in progress with an error as the kernel would. Makes the device node ready, so that
 * programs that poll the node notice that the device is gone.
 * */
void mock_usbfs_unplugged(mock *m)
{
    usb_urb urb;
    while (usb_urbs_cancel_any(&m->urbs, &urb)) {
    }
    for (mock_urb *one = m->first; one != NULL; one = one->next)
        if (!one->is_done) finish(m, one, ESHUTDOWN, 0);
    tell_ready(m);
}

/* --- submit --- */
static void control(mock *m, mock_urb *one)
{
    uint8_t *bytes = one->buffer->data;
    const usb_request setup = {bytes[0], bytes[1], (uint16_t)(bytes[2] | bytes[3] << 8),
                               (uint16_t)(bytes[4] | bytes[5] << 8), (uint16_t)(bytes[6] | bytes[7] << 8)};
    uint32_t count = 0;
    if (8 + setup.length > header_of(one)->buffer_length) {
        finish(m, one, EINVAL, 0);
        return;
    }
    const usb_result result = usb_host_control(m->peer.host, &setup, bytes + 8, &count);
    finish(m, one, mock_errno(result), setup.type & 0x80 ? count : setup.length);
}

static int submit(mock *m, UMockdevIoctlClient *client, UMockdevIoctlData *argument)
{
    if (!m->is_plugged) return ENODEV;
    mock_urb *one = g_new0(mock_urb, 1);
    one->client = client;
    one->urb = umockdev_ioctl_data_resolve(argument, 0, sizeof(struct usbdevfs_urb), NULL);
    const struct usbdevfs_urb *header = one->urb != NULL ? header_of(one) : NULL;
    if (header != NULL && header->buffer_length > 0)
        one->buffer = umockdev_ioctl_data_resolve(one->urb, offsetof(struct usbdevfs_urb, buffer),
                                                  (gsize)header->buffer_length, NULL);
    const bool is_control = header != NULL && header->type == USBDEVFS_URB_TYPE_CONTROL;
    if (header == NULL || (is_control && (one->buffer == NULL || header->buffer_length < 8))) {
        g_free(one);
        return EFAULT;
    }
    mock_urb **place = &m->first;
    while (*place != NULL) place = &(*place)->next;
    *place = one;
    if (is_control) {
        control(m, one);
        return 0;
    }
    const usb_urb urb = {
        .id = (uint64_t)(uintptr_t)one,
        .endpoint = header->endpoint,
        .bytes = one->buffer != NULL ? one->buffer->data : NULL,
        .length = (uint32_t)header->buffer_length,
        .ends_empty = (header->flags & USBDEVFS_URB_ZERO_PACKET) != 0,
    };
    if (!usb_urbs_submit(&m->urbs, &urb)) finish(m, one, ENOENT, 0);
    usb_urbs_step(&m->urbs);
    m->is_handed_in = true;
    pthread_cond_signal(&m->handed_in);
    return 0;
}

/* --- reap and discard --- */
static void release(mock *m, mock_urb *one)
{
    mock_urb **place = &m->first;
    while (*place != one) place = &(*place)->next;
    *place = one->next;
    if (one->buffer != NULL) umockdev_ioctl_data_unref(one->buffer);
    umockdev_ioctl_data_unref(one->urb);
    g_free(one);
}

static int reap(mock *m, UMockdevIoctlClient *client, UMockdevIoctlData *argument)
{
    mock_urb *one = m->first;
    while (one != NULL && !(one->is_done && one->client == client)) one = one->next;
    if (one == NULL) {
        tell_ready(m);
        return m->is_plugged ? EAGAIN : ENODEV;
    }
    UMockdevIoctlData *place = umockdev_ioctl_data_resolve(argument, 0, sizeof(void *), NULL);
    if (place == NULL) return EFAULT;
    umockdev_ioctl_data_set_ptr(place, 0, one->urb);
    umockdev_ioctl_data_unref(place);
    release(m, one);
    tell_ready(m);
    return 0;
}

static int discard(mock *m, UMockdevIoctlClient *client, const UMockdevIoctlData *argument)
{
    usb_urb urb;
    gulong address;
    memcpy(&address, argument->data, sizeof address);
    for (mock_urb *one = m->first; one != NULL; one = one->next) {
        if (one->client != client || one->is_done || one->urb->client_addr != address) continue;
        const bool was_waiting = usb_urbs_cancel(&m->urbs, (uint64_t)(uintptr_t)one, &urb);
        finish(m, one, ENOENT, was_waiting ? urb.done : 0);
        return 0;
    }
    return EINVAL;
}

/* --- the other calls --- */
static int clear_halt(mock *m, UMockdevIoctlData *argument)
{
    UMockdevIoctlData *number = umockdev_ioctl_data_resolve(argument, 0, sizeof(unsigned), NULL);
    if (number == NULL) return EFAULT;
    unsigned endpoint;
    memcpy(&endpoint, number->data, sizeof endpoint);
    umockdev_ioctl_data_unref(number);
    return m->is_plugged ? mock_errno(usb_host_clear_halt(m->peer.host, (uint8_t)endpoint)) : ENODEV;
}

/* Interface 0 is the HID interface. When a program claims the HID interface, libusb takes it from the driver
 * usbhid. In the data of both ioctl calls (claim and release), the number of the interface comes first. */
static int claim(mock *m, UMockdevIoctlData *argument, bool is_taken)
{
    unsigned interface;
    if (!m->is_plugged) return ENODEV;
    UMockdevIoctlData *number = umockdev_ioctl_data_resolve(argument, 0, sizeof interface, NULL);
    if (number == NULL) return EFAULT;
    memcpy(&interface, number->data, sizeof interface);
    umockdev_ioctl_data_unref(number);
    if (interface != 0) return 0;
    if (is_taken)
        mock_hidraw_unbind(m);
    else
        m->hid_is_claimed = false;
    return 0;
}

static int capabilities(UMockdevIoctlData *argument)
{
    const uint32_t offered =
        USBDEVFS_CAP_ZERO_PACKET | USBDEVFS_CAP_NO_PACKET_SIZE_LIM | USBDEVFS_CAP_REAP_AFTER_DISCONNECT;
    UMockdevIoctlData *place = umockdev_ioctl_data_resolve(argument, 0, sizeof offered, NULL);
    if (place == NULL) return EFAULT;
    umockdev_ioctl_data_update(place, 0, (guint8 *)(void *)&offered, sizeof offered);
    umockdev_ioctl_data_unref(place);
    return 0;
}

static int answer(mock *m, UMockdevIoctlClient *client, UMockdevIoctlData *argument, long *result)
{
    switch (umockdev_ioctl_client_get_request(client)) {
    case USBDEVFS_GET_CAPABILITIES:
        return capabilities(argument);
    case USBDEVFS_GET_SPEED:
        *result = 3; /* high speed, in the kernel's own numbering */
        return 0;
    case USBDEVFS_CLAIMINTERFACE:
    case USBDEVFS_DISCONNECT_CLAIM:
        return claim(m, argument, true);
    case USBDEVFS_RELEASEINTERFACE:
        return claim(m, argument, false);
    case USBDEVFS_GETDRIVER:
    case USBDEVFS_IOCTL:
        return ENODATA; /* no driver of the kernel is bound */
    case USBDEVFS_CLEAR_HALT:
        return clear_halt(m, argument);
    case USBDEVFS_SUBMITURB:
        return submit(m, client, argument);
    case USBDEVFS_REAPURB:
    case USBDEVFS_REAPURBNDELAY:
        return reap(m, client, argument);
    case USBDEVFS_DISCARDURB:
        return discard(m, client, argument);
    default:
        return ENOTTY;
    }
}

gboolean mock_usbfs_ioctl(UMockdevIoctlBase *base, UMockdevIoctlClient *client, mock *m)
{
    (void)base;
    long result = 0;
    pthread_mutex_lock(&m->lock);
    const int wrong = answer(m, client, umockdev_ioctl_client_get_arg(client), &result);
    pthread_mutex_unlock(&m->lock);
    umockdev_ioctl_client_complete(client, wrong == 0 ? result : -1, wrong);
    return TRUE;
}

/* When a program has closed the node, or has crashed, the kernel takes back the program's transfers. */
void mock_usbfs_vanished(UMockdevIoctlBase *base, UMockdevIoctlClient *client, mock *m)
{
    (void)base;
    usb_urb urb;
    pthread_mutex_lock(&m->lock);
    for (mock_urb *one = m->first, *next; one != NULL; one = next) {
        next = one->next;
        if (one->client != client) continue;
        usb_urbs_cancel(&m->urbs, (uint64_t)(uintptr_t)one, &urb);
        release(m, one);
    }
    tell_ready(m);
    pthread_mutex_unlock(&m->lock);
}
