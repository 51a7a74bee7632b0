/* Level L2: runs a program that sees a rig on USB, on a machine without USB. umockdev, loaded into the program, sends its calls
 * to /dev/bus/usb and /dev/hidraw0 here; here they become tokens for the device on the mailbox. The program and its libraries
 * are the ones that ship.
 *
 *   umockdev-wrapper mock_bus --here -- PROGRAM ARGUMENT...     the loop-back rig
 *   umockdev-wrapper mock_bus --app -- PROGRAM ARGUMENT...      the whole app
 *   umockdev-wrapper mock_bus --mailbox FILE:OFFSET -- PROGRAM ARGUMENT...
 *
 * The exit code is the program's; 1 when the device does not come up, 2 for bad arguments.
 *
 * May include: mock.h. Called by: make hil-mock.
 */
#define _GNU_SOURCE
#include "hil_tests/l2/mock.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#define USB_PATH "/devices/usb1/1-1"
#define HID_PATH USB_PATH "/1-1:1.0/0003:1209:0001.0001"
#define USB_NODE "/dev/bus/usb/001/002"
#define HID_NODE "/dev/hidraw0"

enum { STEP_us = 100, PROGRAM_SECONDS = 60 };

/* --- the tree of devices, as udev and sysfs tell it --- */
static void append_hex(GString *text, const uint8_t *bytes, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) g_string_append_printf(text, "%02X", bytes[i]);
}

static char *read_serial(mock *m)
{
    uint8_t bytes[255];
    uint32_t count = 0;
    GString *serial = g_string_new(NULL);
    const usb_request get = {0x80, 6, 0x0303, 0x0409, sizeof bytes};
    if (usb_host_control(m->peer.host, &get, bytes, &count) == USB_OK)
        for (uint32_t i = 2; i + 1 < count; i += 2) g_string_append_c(serial, (char)bytes[i]);
    return g_string_free(serial, FALSE);
}

static char *describe(mock *m, const uint8_t *descriptors, uint32_t count)
{
    GString *text =
        g_string_new("P: " USB_PATH "\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\n"
                     "E: BUSNUM=001\nE: DEVNUM=002\nE: DEVNAME=" USB_NODE "\nE: MAJOR=189\nE: MINOR=1\n"
                     "A: busnum=1\\n\nA: devnum=2\\n\nA: bConfigurationValue=1\\n\nA: speed=480\\n\n");
    char *serial = read_serial(m);
    g_string_append_printf(
        text,
        "A: idVendor=%02x%02x\\n\nA: idProduct=%02x%02x\\n\nA: serial=%s\\n\nH: descriptors=", descriptors[9],
        descriptors[8], descriptors[11], descriptors[10], serial);
    append_hex(text, descriptors, count);
    g_string_append(text,
                    "\n\nP: " USB_PATH
                    "/1-1:1.0\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_interface\nA: bInterfaceNumber=00\\n\n");
    g_string_append_printf(text,
                           "\nP: " HID_PATH "\nE: SUBSYSTEM=hid\nE: HID_ID=0003:0000%02X%02X:0000%02X%02X\n"
                           "E: HID_NAME=Seldinger rig\nE: HID_UNIQ=%s\n",
                           descriptors[9], descriptors[8], descriptors[11], descriptors[10], serial);
    g_string_append(text, "\nP: " HID_PATH "/hidraw/hidraw0\nE: SUBSYSTEM=hidraw\nE: DEVNAME=" HID_NODE
                          "\nE: MAJOR=244\nE: MINOR=0\nL: device=../../../0003:1209:0001.0001\n\n");
    g_free(serial);
    return g_string_free(text, FALSE);
}

/* A node that can be waited for; made here, since umockdev makes one only once. The descriptor stays open, so that neither end ever sees the other gone. */
static int make_fifo(const mock *m, const char *node)
{
    char *path = g_build_filename(m->root, node, NULL);
    char *folder = g_path_get_dirname(path);
    g_mkdir_with_parents(folder, 0777);
    g_free(folder);
    unlink(path);
    int fifo = -1;
    if (mkfifo(path, 0666) == 0) fifo = open(path, O_RDWR | O_NONBLOCK | O_CLOEXEC);
    if (fifo >= 0) fcntl(fifo, F_SETPIPE_SZ, MOCK_PIPE_BYTES);
    g_free(path);
    return fifo;
}

static void remove_node(const mock *m, const char *node)
{
    char *path = g_build_filename(m->root, node, NULL);
    unlink(path);
    g_free(path);
}

/* --- plug and unplug --- */
static bool enumerate(mock *m, uint8_t *descriptors, uint32_t *count)
{
    usb_host *host = m->peer.host;
    uint32_t device = 0, configuration = 0;
    const usb_request address = {0x00, 5, 1, 0, 0}, configure = {0x00, 9, 1, 0, 0};
    const usb_request get_device = {0x80, 6, 0x0100, 0, 18}, get_configuration = {0x80, 6, 0x0200, 0, 512};
    if (usb_host_bus(host, SELD_MAILBOX_RESET_HIGH) != USB_OK) return false;
    if (usb_host_control(host, &address, NULL, &device) != USB_OK) return false;
    host->address = 1;
    if (usb_host_control(host, &get_device, descriptors, &device) != USB_OK || device != 18) return false;
    if (usb_host_control(host, &get_configuration, descriptors + 18, &configuration) != USB_OK) return false;
    *count = device + configuration;
    memset(m->urbs.packet_bytes, 0, sizeof m->urbs.packet_bytes);
    for (uint32_t place = 18; place + 7 <= *count && descriptors[place] >= 2; place += descriptors[place])
        if (descriptors[place + 1] == 5)
            m->urbs.packet_bytes[usb_urbs_pipe(descriptors[place + 2])] =
                (uint16_t)(descriptors[place + 4] | descriptors[place + 5] << 8);
    return usb_host_control(host, &configure, NULL, &device) == USB_OK;
}

static bool plug(mock *m)
{
    uint8_t descriptors[1024];
    uint32_t count = 0;
    if (!enumerate(m, descriptors, &count)) return false;
    char *text = describe(m, descriptors, count);
    GError *error = NULL;
    if (!umockdev_testbed_add_from_string(m->testbed, text, &error)) {
        fprintf(stderr, "mock_bus: %s\n", error->message);
        g_clear_error(&error);
        g_free(text);
        return false;
    }
    g_free(text);
    m->usbfs_fifo = make_fifo(m, USB_NODE);
    m->hidraw_fifo = make_fifo(m, HID_NODE);
    m->usbfs_is_full = false;
    m->report_count = 0;
    m->is_plugged = m->usbfs_fifo >= 0 && m->hidraw_fifo >= 0 &&
                    umockdev_testbed_attach_ioctl(m->testbed, USB_NODE, m->usbfs, NULL) &&
                    umockdev_testbed_attach_ioctl(m->testbed, HID_NODE, m->hidraw, NULL);
    mock_usbfs_unplugged(m); /* nothing is under way: the node is filled */
    umockdev_testbed_uevent(m->testbed, "/sys" USB_PATH, "add");
    return m->is_plugged;
}

static void unplug(mock *m)
{
    static const char *const paths[] = {"/sys" USB_PATH, "/sys" USB_PATH "/1-1:1.0", "/sys" HID_PATH,
                                        "/sys" HID_PATH "/hidraw/hidraw0"};
    m->is_plugged = false;
    m->hidraw_is_reading = false;
    mock_usbfs_unplugged(m);
    umockdev_testbed_uevent(m->testbed, "/sys" USB_PATH, "remove");
    umockdev_testbed_detach_ioctl(m->testbed, USB_NODE, NULL);
    umockdev_testbed_detach_ioctl(m->testbed, HID_NODE, NULL);
    for (int i = (int)G_N_ELEMENTS(paths) - 1; i >= 0; i--)
        umockdev_testbed_remove_device(m->testbed, paths[i]);
    remove_node(m, USB_NODE);
    remove_node(m, HID_NODE);
    close(m->usbfs_fifo);
    close(m->hidraw_fifo);
}

/* --- the bus moves --- */
static void on_complete(void *context, const usb_urb *urb)
{
    mock *m = context;
    if (urb->id == 0)
        mock_hidraw_complete(m, urb);
    else
        mock_usbfs_complete(m, urb);
}

static void *run_bus(void *context)
{
    mock *m = context;
    const struct timespec pause = {0, STEP_us * 1000};
    for (bool is_over = false; !is_over;) {
        pthread_mutex_lock(&m->lock);
        const usb_host *host = m->peer.host;
        usb_peer_run(&m->peer);
        const bool is_there =
            usb_host_sees_device(host) &&
            (!m->is_plugged || seld_mailbox_read(&host->mailbox->device.boot_count) == host->boot_count);
        if (m->is_plugged && !is_there)
            unplug(m);
        else if (!m->is_plugged && is_there)
            plug(m);
        mock_hidraw_step(m);
        while (usb_urbs_step(&m->urbs)) usb_peer_run(&m->peer);
        is_over = m->is_over;
        pthread_mutex_unlock(&m->lock);
        nanosleep(&pause, NULL);
    }
    return NULL;
}

/* --- the program --- */
static int run_program(char **arguments)
{
    const pid_t child = fork();
    if (child == 0) {
        alarm(PROGRAM_SECONDS);
        execvp(arguments[0], arguments);
        fprintf(stderr, "mock_bus: cannot run %s: %s\n", arguments[0], strerror(errno));
        _exit(127);
    }
    int status = 0;
    if (child < 0 || waitpid(child, &status, 0) != child) return 1;
    if (WIFEXITED(status)) return WEXITSTATUS(status);
    fprintf(stderr, "mock_bus: %s was ended by signal %d\n", arguments[0], WTERMSIG(status));
    return 1;
}

int main(int argc, char **argv)
{
    static mock m;
    pthread_t bus;
    int used = 0;
    const char *wrong = usb_peer_open(&m.peer, argc - 1, argv + 1, &used);
    if (wrong == NULL && (argc < used + 3 || strcmp(argv[used + 1], "--") != 0))
        wrong = "a program comes behind --";
    if (wrong != NULL) {
        fprintf(stderr,
                "mock_bus: %s\nusage: mock_bus (--here | --app | --mailbox FILE[:OFFSET]) -- PROGRAM\n",
                wrong);
        return 2;
    }
    pthread_mutex_init(&m.lock, NULL);
    m.testbed = umockdev_testbed_new();
    if (!umockdev_in_mock_environment()) {
        fprintf(stderr, "mock_bus: run it by umockdev-wrapper\n");
        return 2;
    }
    m.root = umockdev_testbed_get_root_dir(m.testbed);
    m.usbfs = umockdev_ioctl_base_new();
    m.hidraw = umockdev_ioctl_base_new();
    g_signal_connect(m.usbfs, "handle-ioctl", G_CALLBACK(mock_usbfs_ioctl), &m);
    g_signal_connect(m.usbfs, "client-vanished", G_CALLBACK(mock_usbfs_vanished), &m);
    g_signal_connect(m.hidraw, "handle-ioctl", G_CALLBACK(mock_hidraw_ioctl), &m);
    g_signal_connect(m.hidraw, "handle-read", G_CALLBACK(mock_hidraw_read), &m);
    g_signal_connect(m.hidraw, "handle-write", G_CALLBACK(mock_hidraw_write), &m);
    g_signal_connect(m.hidraw, "client-connected", G_CALLBACK(mock_hidraw_connected), &m);
    g_signal_connect(m.hidraw, "client-vanished", G_CALLBACK(mock_hidraw_vanished), &m);
    m.urbs = (usb_urbs){.host = m.peer.host, .complete = on_complete, .context = &m};
    if (!plug(&m)) {
        fprintf(stderr, "mock_bus: no device answers\n");
        return 1;
    }
    pthread_create(&bus, NULL, run_bus, &m);
    const int result = run_program(argv + used + 2);
    pthread_mutex_lock(&m.lock);
    m.is_over = true;
    pthread_mutex_unlock(&m.lock);
    pthread_join(bus, NULL);
    g_object_unref(m.testbed);
    return result;
}
