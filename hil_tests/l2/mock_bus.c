/* At test level L2, this file makes simulated devices visible as USB devices to a program, on a machine
 * without USB. The library umockdev, loaded into the program, redirects the program's calls for /dev/bus/usb
 * and /dev/hidraw* to this file, which converts them to USB tokens for the device. The tested program and its
 * libraries are the unchanged ones that users run.
 *
 *   umockdev-wrapper mock_bus --here -- PROGRAM ARGUMENT...     the loop-back rig
 *   umockdev-wrapper mock_bus --app -- PROGRAM ARGUMENT...      the whole app
 *   umockdev-wrapper mock_bus --mailbox FILE:OFFSET -- PROGRAM ARGUMENT...
 *
 * The command line may name several devices, but --here and --app may each occur only once.
 *
 * The exit code is that of the tested program. If the device does not start, the exit code is 1; if the
 * arguments are wrong, the exit code is 2. */
#define _GNU_SOURCE
#include "hil_tests/l2/mock.h"

#include <errno.h>
#include <fcntl.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdio.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { SLACK_ns = 1, STEP_ns = 100000, PROGRAM_SECONDS = 200, AWAY_ms = 500, DEVICES_MAX = 4 };

static mock mocks[DEVICES_MAX];
static unsigned mock_count;
static atomic_bool is_over;

/* --- the tree of devices, as udev and sysfs report it --- */
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
    GString *text = g_string_new(NULL);
    char *serial = read_serial(m);
    g_string_append_printf(text,
                           "P: %s\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_device\n"
                           "E: BUSNUM=001\nE: DEVNUM=%03u\nE: DEVNAME=%s\nE: MAJOR=189\nE: MINOR=%u\n"
                           "A: busnum=1\\n\nA: devnum=%u\\n\nA: bConfigurationValue=1\\n\nA: speed=480\\n\n",
                           m->usb_path, m->number + 2, m->usb_node, m->number + 1, m->number + 2);
    g_string_append_printf(
        text,
        "A: idVendor=%02x%02x\\n\nA: idProduct=%02x%02x\\n\nA: serial=%s\\n\nH: descriptors=", descriptors[9],
        descriptors[8], descriptors[11], descriptors[10], serial);
    append_hex(text, descriptors, count);
    g_string_append_printf(text,
                           "\n\nP: %s/1-%u:1.0\nE: SUBSYSTEM=usb\nE: DEVTYPE=usb_interface\nA: "
                           "bInterfaceNumber=00\\n\n",
                           m->usb_path, m->number + 1);
    g_string_append_printf(text,
                           "\nP: %s\nE: SUBSYSTEM=hid\nE: HID_ID=0003:0000%02X%02X:0000%02X%02X\n"
                           "E: HID_NAME=Cournand rig\nE: HID_UNIQ=%s\n",
                           m->hid_path, descriptors[9], descriptors[8], descriptors[11], descriptors[10],
                           serial);
    g_string_append_printf(text,
                           "\nP: %s/hidraw/hidraw%u\nE: SUBSYSTEM=hidraw\nE: DEVNAME=%s"
                           "\nE: MAJOR=244\nE: MINOR=%u\nL: device=../../../0003:1209:0001.%04u\n\n",
                           m->hid_path, m->number, m->hid_node, m->number, m->number + 1);
    g_free(serial);
    return g_string_free(text, FALSE);
}

/* Makes a device node as a FIFO, which programs can poll. This file makes the device node in /dev itself,
 * because umockdev makes a node only once. This process keeps the FIFO open for reading and writing, so no
 * program ever finds the other end closed. */
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
    if (usb_host_bus(host, CRN_MAILBOX_RESET_HIGH) != USB_OK) return false;
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

static void tell(mock *m, const char *what)
{
    char *path = g_strdup_printf("/sys%s", m->usb_path);
    umockdev_testbed_uevent(m->testbed, path, what);
    g_free(path);
}

/* If the node of an unplugged device were removed, umockdev would end every program that is in the middle of
 * a call on this node. Therefore the nodes of an unplugged device stay, and answer ENODEV until the device
 * returns. The device returns only after programs have had time to close its nodes. */
static void detach(mock *m)
{
    if (!m->is_attached) return;
    umockdev_testbed_detach_ioctl(m->testbed, m->usb_node, NULL);
    umockdev_testbed_detach_ioctl(m->testbed, m->hid_node, NULL);
    m->is_attached = false;
}

static bool plug(mock *m)
{
    uint8_t descriptors[1024];
    uint32_t count = 0;
    detach(m);
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
    m->usbfs_fifo = make_fifo(m, m->usb_node);
    m->hidraw_fifo = make_fifo(m, m->hid_node);
    m->usbfs_is_full = false;
    m->report_count = 0;
    m->is_plugged = m->usbfs_fifo >= 0 && m->hidraw_fifo >= 0 &&
                    umockdev_testbed_attach_ioctl(m->testbed, m->usb_node, m->usbfs, NULL) &&
                    umockdev_testbed_attach_ioctl(m->testbed, m->hid_node, m->hidraw, NULL);
    m->is_attached = m->is_plugged;
    mock_usbfs_unplugged(m); /* nothing is under way: the node is filled */
    tell(m, "add");
    return m->is_plugged;
}

static void unplug(mock *m)
{
    m->is_plugged = false;
    m->unplugged_ns = usb_peer_now_ns();
    m->hidraw_is_reading = false;
    mock_usbfs_unplugged(m);
    tell(m, "remove");
    char *const paths[] = {g_strdup_printf("/sys%s/hidraw/hidraw%u", m->hid_path, m->number),
                           g_strdup_printf("/sys%s", m->hid_path),
                           g_strdup_printf("/sys%s/1-%u:1.0", m->usb_path, m->number + 1),
                           g_strdup_printf("/sys%s", m->usb_path)};
    for (unsigned i = 0; i < G_N_ELEMENTS(paths); i++) {
        umockdev_testbed_remove_device(m->testbed, paths[i]);
        g_free(paths[i]);
    }
    remove_node(m, m->usb_node);
    remove_node(m, m->hid_node);
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

/* If the device is in this process, the function waits until the next millisecond or until a transfer is
 * submitted; a device in another process is polled. */
static void wait_for_work(mock *m)
{
    const int64_t until = m->peer.kind == USB_PEER_FILE ? usb_peer_now_ns() + STEP_ns : m->peer.next_tick_ns;
    const struct timespec time = {until / 1000000000, until % 1000000000};
    if (!m->is_handed_in) pthread_cond_timedwait(&m->handed_in, &m->lock, &time);
    m->is_handed_in = false;
}

static void *run_bus(void *context)
{
    mock *m = context;
    pthread_mutex_lock(&m->lock);
    while (!is_over) {
        const usb_host *host = m->peer.host;
        usb_peer_run(&m->peer);
        const bool is_there =
            usb_host_sees_device(host) &&
            (!m->is_plugged || crn_mailbox_read(&host->mailbox->device.boot_count) == host->boot_count);
        if (m->is_plugged && !is_there)
            unplug(m);
        else if (!m->is_plugged && is_there &&
                 usb_peer_now_ns() - m->unplugged_ns > AWAY_ms * (int64_t)1000000)
            plug(m);
        for (mock_hidraw_step(m); usb_urbs_step(&m->urbs); mock_hidraw_step(m)) usb_peer_run(&m->peer);
        wait_for_work(m);
    }
    pthread_mutex_unlock(&m->lock);
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

/* --- devices --- */
static void name_nodes(mock *m, unsigned number)
{
    m->number = number;
    snprintf(m->usb_path, sizeof m->usb_path, "/devices/usb1/1-%u", number + 1);
    snprintf(m->hid_path, sizeof m->hid_path, "/devices/usb1/1-%u/1-%u:1.0/0003:1209:0001.%04u", number + 1,
             number + 1, number + 1);
    snprintf(m->usb_node, sizeof m->usb_node, "/dev/bus/usb/001/%03u", number + 2);
    snprintf(m->hid_node, sizeof m->hid_node, "/dev/hidraw%u", number);
}

/* Returns NULL on success, otherwise an error message. Sets `*used` to the number of words on the command
 * line that select the devices; these words come first. */
static const char *open_devices(int count, char **words, int *used)
{
    const char *wrong = NULL;
    *used = 0;
    while (wrong == NULL && mock_count < DEVICES_MAX && *used < count && strcmp(words[*used], "--") != 0) {
        int more = 0;
        wrong = usb_peer_open(&mocks[mock_count].peer, count - *used, words + *used, &more);
        name_nodes(&mocks[mock_count], mock_count);
        mock_count++;
        *used += more;
    }
    if (wrong == NULL && mock_count == 0) wrong = "no device is named";
    if (wrong == NULL && (*used + 1 >= count || strcmp(words[*used], "--") != 0))
        wrong = "a program comes behind --";
    return wrong;
}

static void make_nodes(mock *m, UMockdevTestbed *testbed)
{
    pthread_condattr_t clock;
    pthread_condattr_init(&clock);
    pthread_condattr_setclock(&clock, CLOCK_MONOTONIC);
    pthread_mutex_init(&m->lock, NULL);
    pthread_cond_init(&m->handed_in, &clock);
    pthread_condattr_destroy(&clock);
    m->testbed = testbed;
    m->root = umockdev_testbed_get_root_dir(testbed);
    m->usbfs = umockdev_ioctl_base_new();
    m->hidraw = umockdev_ioctl_base_new();
    g_signal_connect(m->usbfs, "handle-ioctl", G_CALLBACK(mock_usbfs_ioctl), m);
    g_signal_connect(m->usbfs, "client-vanished", G_CALLBACK(mock_usbfs_vanished), m);
    g_signal_connect(m->hidraw, "handle-ioctl", G_CALLBACK(mock_hidraw_ioctl), m);
    g_signal_connect(m->hidraw, "handle-read", G_CALLBACK(mock_hidraw_read), m);
    g_signal_connect(m->hidraw, "handle-write", G_CALLBACK(mock_hidraw_write), m);
    g_signal_connect(m->hidraw, "client-connected", G_CALLBACK(mock_hidraw_connected), m);
    g_signal_connect(m->hidraw, "client-vanished", G_CALLBACK(mock_hidraw_vanished), m);
    m->urbs = (usb_urbs){.host = m->peer.host, .complete = on_complete, .context = m};
}

/* When umockdev is used, every ioctl call exchanges half a dozen messages between two threads. Waking a
 * thread on another processor costs more than the message itself. If both threads run on one processor, the
 * loop-back rig's round trips are fast enough to finish each millisecond of work in time. */
static void stay_on_one_processor(void)
{
    cpu_set_t here;
    CPU_ZERO(&here);
    CPU_SET((size_t)sched_getcpu(), &here);
    sched_setaffinity(0, sizeof here, &here);
}

int main(int argc, char **argv)
{
    pthread_t buses[DEVICES_MAX];
    int used = 0;
    const char *wrong = open_devices(argc - 1, argv + 1, &used);
    if (wrong != NULL) {
        fprintf(stderr,
                "mock_bus: %s\nusage: mock_bus (--here | --app[=SERIAL] | --mailbox FILE[:OFFSET])... -- "
                "PROGRAM\n",
                wrong);
        return 2;
    }
    /* The threads of this program, and the tested program that it starts, inherit the timer slack that is set
     * here. After every ioctl call, umockdev calls a sleep of zero length, which takes 50 us with Linux's
     * usual timer slack. With 50 us for each of these sleeps, the six ioctl calls for one interrupt transfer
     * in each direction would last longer than a USB frame of 1 ms. */
    prctl(PR_SET_TIMERSLACK, SLACK_ns);
    if (mocks[0].peer.kind == USB_PEER_RIG) stay_on_one_processor();
    UMockdevTestbed *testbed = umockdev_testbed_new();
    if (!umockdev_in_mock_environment()) {
        fprintf(stderr, "mock_bus: run it by umockdev-wrapper\n");
        return 2;
    }
    for (unsigned i = 0; i < mock_count; i++) {
        make_nodes(&mocks[i], testbed);
        if (plug(&mocks[i])) continue;
        fprintf(stderr, "mock_bus: no device answers\n");
        return 1;
    }
    for (unsigned i = 0; i < mock_count; i++) pthread_create(&buses[i], NULL, run_bus, &mocks[i]);
    const int result = run_program(argv + used + 2);
    is_over = true;
    for (unsigned i = 0; i < mock_count; i++) pthread_join(buses[i], NULL);
    g_object_unref(testbed);
    return result;
}
