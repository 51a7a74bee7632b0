/* This program runs the cases of Linux' module usbtest against the device on this machine's USB. It loads the
 * module, and prints one row of TAP per case.
 *
 *   usbtest MODULE            the images with source and sink (firmware/app/usb/source_sink)
 *   usbtest MODULE --case N   of these cases one alone
 *   usbtest MODULE --times N  all cases with N times as many transfers
 *   usbtest MODULE --rig      a rig as it ships: usbtest then knows only endpoint 0, so that the cases 0, 9
 *                             and 10 apply
 *   usbtest MODULE --beside PROGRAM    the cases 9 and 10 over and over by a rig's HID interface, as long as
 *                             PROGRAM uses its stream
 *
 * The module is loaded with realworld=0, with which it also requests what many devices on the market do not
 * implement (GET_CONFIGURATION, GET_INTERFACE, control transfers of length 0). The program needs root. */
#define _GNU_SOURCE
#include "hil_tests/library/check.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <linux/usbdevice_fs.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#define DEVICES "/sys/bus/usb/devices"
#define PATTERN "/sys/module/usbtest/parameters/pattern"

enum {
    WAIT_MAX_ms = 20000, /* for the device and its driver */
    ROUNDS_MIN = 20,     /* beside a program, for a verdict */
    REQUEST_PATTERN = 0x5d,
    REQUEST_RECEIVED = 0x5e,
    OPEN_PACKETS_MAX = 3, /* of a transfer of the sink that is not over, and not counted yet */
    COUNT_TRIES = 5,
    RESETS = 10,
    TIMES_MAX = 100,
    GADGET_ZERO_VENDOR = 0x0525, /* the kernel's own test device */
    GADGET_ZERO_PRODUCT = 0xa4a0,
    ZEROES = 1, /* sets of patterns */
    MOD_63 = 2,
};

/* As the module's ioctl expects it. */
typedef struct usbtest_param {
    uint32_t number, iterations, length, vary, list_length;
    int32_t duration_s, duration_us;
} usbtest_param;
#define USBTEST_REQUEST _IOWR('U', 100, usbtest_param)

typedef struct usb_case {
    uint32_t number;
    const char *name;
    uint32_t iterations, length, vary, list_length;
    int patterns; /* the case runs with each of them */
} usb_case;

/* Reads are whole packets of 512 bytes, because the source sends nothing else. Writes end within a packet, or
 * at its end (then usbtest appends an empty packet). */
static const usb_case cases[] = {
    {0, "nothing", 1, 0, 0, 0, ZEROES},
    {1, "bulk write", 64, 1000, 0, 0, ZEROES | MOD_63},
    {1, "bulk write of whole packets", 64, 2048, 0, 0, ZEROES | MOD_63},
    {2, "bulk read", 64, 2048, 0, 0, ZEROES | MOD_63},
    {3, "bulk writes of varied length", 128, 5000, 421, 0, ZEROES | MOD_63},
    {3, "bulk writes of every length", 1100, 1100, 1, 0, ZEROES | MOD_63},
    {4, "bulk reads of varied length", 64, 8192, 512, 0, ZEROES | MOD_63},
    {5, "queued bulk writes", 8, 2048, 0, 16, ZEROES | MOD_63},
    {6, "queued bulk reads", 8, 2048, 0, 16, ZEROES | MOD_63},
    {7, "queued bulk writes of varied length", 8, 4096, 512, 16, ZEROES | MOD_63},
    {7, "queued bulk writes of odd length", 8, 3000, 421, 16, ZEROES | MOD_63},
    {8, "queued bulk reads of varied length", 8, 4096, 512, 16, ZEROES | MOD_63},
    {9, "chapter 9 requests", 32, 0, 0, 0, ZEROES},
    {10, "queued control requests", 32, 0, 0, 32, ZEROES},
    {11, "cancelled reads", 32, 4096, 0, 0, ZEROES | MOD_63},
    {12, "cancelled writes", 32, 4096, 0, 0, ZEROES | MOD_63},
    {13, "halt, and clear the halt", 16, 0, 0, 0, ZEROES | MOD_63},
    {14, "control write and read back of every length", 514, 256, 1, 0, ZEROES},
    {15, "isochronous write", 4, 512, 0, 4, ZEROES},
    {16, "isochronous read", 4, 512, 0, 4, ZEROES},
    {17, "bulk write from an odd address", 32, 1000, 0, 0, ZEROES | MOD_63},
    {18, "bulk read to an odd address", 32, 1024, 0, 0, ZEROES | MOD_63},
    {19, "bulk write from an odd mapped address", 32, 1000, 0, 0, ZEROES | MOD_63},
    {20, "bulk read to an odd mapped address", 32, 1024, 0, 0, ZEROES | MOD_63},
    {21, "control write and read back at odd addresses", 128, 256, 13, 0, ZEROES},
    {22, "isochronous write from an odd address", 4, 512, 0, 4, ZEROES},
    {23, "isochronous read to an odd address", 4, 512, 0, 4, ZEROES},
    {24, "cancelled writes in a queue", 16, 4096, 0, 16, ZEROES | MOD_63},
    {25, "interrupt write", 32, 150, 0, 0, ZEROES | MOD_63},
    {26, "interrupt read", 32, 192, 0, 0, ZEROES | MOD_63},
    {27, "bulk write, queue always full", 16, 8192, 0, 16, ZEROES},
    {28, "bulk read, queue always full", 16, 8192, 0, 16, ZEROES},
    {29, "toggle after a cleared halt", 32, 0, 0, 0, ZEROES | MOD_63},
};
enum { CASE_COUNT = sizeof cases / sizeof cases[0] };

static struct {
    int file; /* of usbfs */
    int interface;
    bool is_rig;
    uint32_t packet_bytes; /* of the bulk endpoints */
    char name[64];         /* of the interface in sysfs */
    char driver[32];       /* of the host controller */
} device;
static long only_case = -1, times = 1;

static void give_up(const char *what, const char *why)
{
    fprintf(stderr, "usbtest: %s: %s\n", what, why);
    exit(1);
}

/* --- module and device --- */
static void load_module(const char *path)
{
    char options[80] = "realworld=0";
    if (device.is_rig)
        snprintf(options, sizeof options, "realworld=0 vendor=%d product=%d", CHECK_VENDOR_ID,
                 CHECK_PRODUCT_ID);
    const int file = open(path, O_RDONLY | O_CLOEXEC);
    if (file < 0) give_up(path, strerror(errno));
    if (syscall(SYS_finit_module, file, options, 0) != 0) give_up(path, strerror(errno));
    close(file);
}

static bool read_text(const char *folder, const char *name, char *text, size_t capacity)
{
    char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "re");
    if (file == NULL) return false;
    const bool has_text = fgets(text, (int)capacity, file) != NULL;
    fclose(file);
    return has_text;
}

static long read_number(const char *folder, const char *name, int base)
{
    char text[32];
    return read_text(folder, name, text, sizeof text) ? strtol(text, NULL, base) : -1;
}

/* Writes the name of the driver of a device or an interface; it is empty without a driver. */
static void read_driver(const char *folder, char *name, size_t capacity)
{
    char path[512], target[512] = "";
    snprintf(path, sizeof path, "%s/driver", folder);
    if (readlink(path, target, sizeof target - 1) < 0) target[0] = '\0';
    const char *slash = strrchr(target, '/');
    snprintf(name, capacity, "%s", slash == NULL ? "" : slash + 1);
}

/* The folder names of interfaces contain a colon: bus-port:configuration.interface. */
static bool find_interface(const char *name)
{
    char folder[300], parent[300], driver[32];
    const char *colon = strchr(name, ':');
    snprintf(folder, sizeof folder, DEVICES "/%s", name);
    read_driver(folder, driver, sizeof driver);
    if (colon == NULL || strcmp(driver, "usbtest") != 0) return false;
    snprintf(parent, sizeof parent, DEVICES "/%.*s", (int)(colon - name), name);
    const int vendor = device.is_rig ? CHECK_VENDOR_ID : GADGET_ZERO_VENDOR;
    const int product = device.is_rig ? CHECK_PRODUCT_ID : GADGET_ZERO_PRODUCT;
    if (read_number(parent, "idVendor", 16) != vendor || read_number(parent, "idProduct", 16) != product)
        return false;
    char path[64];
    snprintf(path, sizeof path, "/dev/bus/usb/%03ld/%03ld", read_number(parent, "busnum", 10),
             read_number(parent, "devnum", 10));
    device.file = open(path, O_RDWR | O_CLOEXEC);
    if (device.file < 0) give_up(path, strerror(errno));
    device.interface = (int)read_number(folder, "bInterfaceNumber", 16);
    snprintf(device.name, sizeof device.name, "%s", name);
    snprintf(folder, sizeof folder, DEVICES "/usb%ld/..", read_number(parent, "busnum", 10));
    read_driver(folder, device.driver, sizeof device.driver);
    device.packet_bytes = read_number(parent, "speed", 10) == 480 ? 512 : 64;
    check_note("%s, interface %d, %ld Mbit/s, host controller of %s", path, device.interface,
               read_number(parent, "speed", 10), device.driver);
    return true;
}

static bool find_device(void)
{
    DIR *folder = opendir(DEVICES);
    if (folder == NULL) give_up(DEVICES, strerror(errno));
    bool is_found = false;
    for (struct dirent *entry; !is_found && (entry = readdir(folder)) != NULL;)
        is_found = find_interface(entry->d_name);
    closedir(folder);
    return is_found;
}

/* --- one run of a case --- */
static void write_text(const char *path, const char *text)
{
    FILE *file = fopen(path, "we");
    if (file == NULL || fputs(text, file) < 0 || fclose(file) != 0) give_up(path, strerror(errno));
}

static void choose_kernels_pattern(int pattern)
{
    write_text(PATTERN, pattern == 0 ? "0" : "1");
}

static void choose_devices_pattern(int pattern)
{
    struct usbdevfs_ctrltransfer request = {
        .bRequestType = 0x40, .bRequest = REQUEST_PATTERN, .wValue = (uint16_t)pattern, .timeout = 5000};
    if (ioctl(device.file, USBDEVFS_CONTROL, &request) < 0) give_up("choice of the pattern", strerror(errno));
}

/* Returns 0, or the kernel's error number. */
static int run(const usb_case *one, double *seconds)
{
    usbtest_param param = {.number = one->number,
                           .iterations = one->iterations,
                           .length = one->length,
                           .vary = one->vary,
                           .list_length = one->list_length};
    struct usbdevfs_ioctl request = {
        .ifno = device.interface, .ioctl_code = (int)USBTEST_REQUEST, .data = &param};
    const int64_t begin = check_now_us();
    const int result = ioctl(device.file, USBDEVFS_IOCTL, &request) < 0 ? errno : 0;
    *seconds += (double)(check_now_us() - begin) * 1e-6;
    return result;
}

/* --- what the sink must have received: usbtest checks what it reads, but not what becomes of its writes ---
 */

/* The lengths of usbtest's writes: each is `vary` longer than the one before, modulo the longest. */
static uint32_t varied_sum(const usb_case *one, uint32_t count)
{
    uint32_t sum = 0, length = one->length;
    for (uint32_t i = 0; i < count; i++) {
        sum += length;
        if (one->vary == 0) continue;
        length = (length + one->vary) % one->length;
        if (length == 0) length = one->vary < one->length ? one->vary : one->length;
    }
    return sum;
}

/* Returns how many bytes a case writes, or 0 if that is open: a case that only reads, or cancels writes. */
static uint32_t written_bytes(const usb_case *one)
{
    switch (one->number) {
    case 1:
    case 3:
    case 17:
    case 19:
    case 25:
        return varied_sum(one, one->iterations);
    case 5:
    case 7:
        return one->iterations * varied_sum(one, one->list_length);
    case 13: /* a write before the halt and one after it, of 512 bytes each */
        return one->iterations * 2 * 512;
    case 27:
        return one->iterations * one->list_length * one->length;
    case 29: /* two writes of two packets each */
        return one->iterations * 2 * 2 * device.packet_bytes;
    default:
        return 0;
    }
}

static uint32_t received_bytes(void)
{
    uint8_t bytes[4] = {0};
    struct usbdevfs_ctrltransfer request = {
        .bRequestType = 0xc0, .bRequest = REQUEST_RECEIVED, .wLength = 4, .timeout = 5000, .data = bytes};
    if (ioctl(device.file, USBDEVFS_CONTROL, &request) != 4) give_up("count of bytes", strerror(errno));
    return bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

/* Every byte must have arrived once. Writes in queues end with a full packet, after which the sink's transfer
 * may still be open. The device may answer the request before it has looked at the last packet. */
static bool has_arrived(const usb_case *one)
{
    const uint32_t written = written_bytes(one);
    const uint32_t open = one->list_length > 0 ? OPEN_PACKETS_MAX * device.packet_bytes : 0;
    uint32_t received = 0;
    for (int i = 0; i < COUNT_TRIES; i++) {
        received = received_bytes();
        if (written == 0 || (received <= written && received + open >= written)) return true;
        usleep(1000);
    }
    check_note("case %u wrote %u bytes, and the sink received %u", one->number, written, received);
    return false;
}

static int run_with_patterns(const usb_case *one, double *seconds)
{
    for (int pattern = 0; pattern < 2; pattern++) {
        if ((one->patterns & 1 << pattern) == 0) continue;
        if (!device.is_rig) {
            choose_devices_pattern(pattern);
            choose_kernels_pattern(pattern);
        }
        const int error = run(one, seconds);
        if (error != 0) return error;
        if (!device.is_rig && !has_arrived(one)) return EBADMSG;
    }
    return 0;
}

/* --- rows --- */
static void describe(const usb_case *one, char *text, size_t capacity)
{
    int used = snprintf(text, capacity, "case %u, %s: %u times", one->number, one->name, one->iterations);
    if (one->list_length > 0)
        used += snprintf(text + used, capacity - (size_t)used, ", %u in a queue", one->list_length);
    if (one->length > 0) used += snprintf(text + used, capacity - (size_t)used, ", %u bytes", one->length);
    if (one->vary > 0) used += snprintf(text + used, capacity - (size_t)used, " in steps of %u", one->vary);
    if (one->patterns == (ZEROES | MOD_63)) snprintf(text + used, capacity - (size_t)used, ", both patterns");
}

/* Returns why the case does not apply to the device, or NULL. */
static const char *why_unfit(const usb_case *one)
{
    const bool is_control = one->number == 0 || one->number == 9 || one->number == 10;
    if (device.is_rig && !is_control) return "usbtest knows no endpoint of a rig";
    const bool is_isochronous =
        one->number == 15 || one->number == 16 || one->number == 22 || one->number == 23;
    return is_isochronous ? "the device has no isochronous endpoint" : NULL;
}

/* Returns why the case cannot run with this machine's host controller, whatever the device is, or NULL. */
static const char *why_left_out(const usb_case *one)
{
    if (device.is_rig) return NULL;
    if (strcmp(device.driver, "xhci_hcd") == 0 && one->number == 24)
        return "when the driver cancels a transfer, QEMU's xHCI loses the others of the queue, and the "
               "kernel waits for them without end";
    if (strcmp(device.driver, "ehci-pci") == 0 && one->number == 7 && one->vary % 512 != 0)
        return "with EHCI the kernel refuses a queue whose pieces are not whole packets";
    return NULL;
}

/* A case that does not apply must be one that usbtest refuses for this device. Returns true if the case
 * applies. */
static bool run_row(const usb_case *one, bool *has_passed)
{
    char text[400];
    double seconds = 0;
    describe(one, text, sizeof text);
    const size_t used = strlen(text);
    const char *unfit = why_unfit(one);
    const int error = unfit != NULL ? run(one, &seconds) : run_with_patterns(one, &seconds);
    if (unfit != NULL)
        snprintf(text + used, sizeof text - used, " (does not apply: %s; the kernel says: %s)", unfit,
                 strerror(error));
    else
        snprintf(text + used, sizeof text - used, " (%s, %.3f s)", error == 0 ? "passed" : strerror(error),
                 seconds);
    *has_passed = check(error == (unfit != NULL ? EOPNOTSUPP : 0), text);
    return unfit == NULL;
}

static const usb_case short_write = {1, "bulk write", 4, 1000, 0, 0, ZEROES | MOD_63};

/* Without these rows, a kernel that compares nothing and a sink that takes everything would pass. After each
 * of them the device must work as before. */
static void check_judges(void)
{
    static const usb_case read = {2, "bulk read", 4, 1024, 0, 0, ZEROES | MOD_63};
    static const usb_case cut = {2, "bulk read", 4, 1000, 0, 0, ZEROES | MOD_63};
    double seconds = 0;
    choose_devices_pattern(0);
    choose_kernels_pattern(1);
    check(run(&read, &seconds) == EINVAL, "usbtest refuses what it reads in the other pattern");
    check(run(&short_write, &seconds) == EPIPE, "the sink halts at what it receives in the other pattern");
    check(run(&cut, &seconds) == EOVERFLOW, "usbtest refuses a packet that is longer than its buffer");
    check(run_with_patterns(&read, &seconds) == 0 && run_with_patterns(&short_write, &seconds) == 0,
          "source and sink then work as before");
}

/* A reset of the bus unbinds usbtest; the kernel then configures the device and binds usbtest anew. */
static bool is_bound_again(void)
{
    char folder[300], driver[32] = "";
    snprintf(folder, sizeof folder, DEVICES "/%s", device.name);
    for (int waited_ms = 0; waited_ms < WAIT_MAX_ms; waited_ms += 10) {
        read_driver(folder, driver, sizeof driver);
        if (strcmp(driver, "usbtest") == 0) return true;
        usleep(10000);
    }
    return false;
}

static void check_resets(void)
{
    static const usb_case read = {2, "bulk read", 4, 2048, 0, 0, ZEROES | MOD_63};
    double seconds = 0;
    int good = 0;
    while (good < RESETS && ioctl(device.file, USBDEVFS_RESET) == 0 && is_bound_again() &&
           run_with_patterns(&short_write, &seconds) == 0 && run_with_patterns(&read, &seconds) == 0)
        good++;
    if (good < RESETS) check_note("reset %d: %s", good + 1, strerror(errno));
    check(good == RESETS, "after each of 10 resets of the bus, source and sink work");
}

/* --- beside a program that uses the stream --- */

/* The kernel gives usbtest the stream's interface, because usbhid has the other one. They change places. */
static void move_to_hid_interface(void)
{
    write_text("/sys/bus/usb/drivers/usbtest/unbind", device.name);
    device.name[strlen(device.name) - 1] = '0';
    device.interface = 0;
    write_text("/sys/bus/usb/drivers/usbhid/unbind", device.name);
    write_text("/sys/bus/usb/drivers/usbtest/bind", device.name);
}

/* A run of a case is short, because usbfs lets the other program submit nothing while it lasts. What that
 * program has submitted before goes on during the run. */
static void run_beside(char *program)
{
    static const usb_case pair[] = {{9, "chapter 9 requests", 1, 0, 0, 0, ZEROES},
                                    {10, "queued control requests", 1, 0, 0, 16, ZEROES}};
    move_to_hid_interface();
    const pid_t child = fork();
    if (child == 0) {
        char *const words[] = {program, NULL};
        execv(program, words);
        give_up(program, strerror(errno));
    }
    int status = -1, rounds = 0, error = 0;
    double seconds = 0;
    while (child > 0 && waitpid(child, &status, WNOHANG) == 0) {
        for (int i = 0; i < 2 && error == 0; i++) error = run(&pair[i], &seconds);
        rounds++;
        usleep(200);
    }
    char text[200];
    snprintf(text, sizeof text, "cases 9 and 10, %d times by the HID interface while %s used the stream (%s)",
             rounds, strrchr(program, '/') + 1, error == 0 ? "passed" : strerror(error));
    check(error == 0 && rounds >= ROUNDS_MIN, text);
    check(status == 0, "and that program passed, too");
}

static void run_rows(void)
{
    int applied = 0, passed = 0;
    for (int i = 0; i < CASE_COUNT; i++) {
        bool has_passed = false;
        if (only_case >= 0 && cases[i].number != (uint32_t)only_case) continue;
        usb_case one = cases[i];
        one.iterations *= (uint32_t)times;
        const char *left_out = why_left_out(&one);
        if (left_out != NULL) {
            check_note("left out: case %u, %s: %s", one.number, one.name, left_out);
            continue;
        }
        if (!run_row(&one, &has_passed)) continue;
        applied++;
        passed += has_passed;
    }
    if (!device.is_rig && only_case < 0) {
        check_judges();
        check_resets();
    }
    check_note("usbtest: of %d rows %d apply, and %d of them pass", CASE_COUNT, applied, passed);
}

int main(int argc, char **argv)
{
    const char *option = argc > 2 ? argv[2] : "";
    char *program = argc == 4 && strcmp(option, "--beside") == 0 ? argv[3] : NULL;
    device.is_rig = program != NULL || (argc == 3 && strcmp(option, "--rig") == 0);
    const bool has_case = argc == 4 && strcmp(option, "--case") == 0;
    const bool has_times = argc == 4 && strcmp(option, "--times") == 0;
    if (has_case) only_case = strtol(argv[3], NULL, 10);
    if (has_times) times = strtol(argv[3], NULL, 10);
    const bool is_usable = argc == 2 || device.is_rig || (has_case && only_case >= 0) || has_times;
    if (!is_usable || times < 1 || times > TIMES_MAX) {
        fprintf(stderr, "usage: %s MODULE [--case N | --times N | --rig | --beside PROGRAM]\n", argv[0]);
        return 2;
    }
    load_module(argv[1]);
    int waited_ms = 0;
    for (; !find_device() && waited_ms < WAIT_MAX_ms; waited_ms += 50) usleep(50000);
    if (waited_ms >= WAIT_MAX_ms) give_up("no device of usbtest", "none came within 20 s");
    if (program != NULL)
        run_beside(program);
    else
        run_rows();
    return check_end();
}
