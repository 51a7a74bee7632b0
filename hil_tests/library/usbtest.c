/* This program runs the cases of Linux' module usbtest against the device on this machine's USB. It loads the
 * module, and prints one row of TAP per case.
 *
 *   usbtest MODULE            the images with source and sink (firmware/app/usb/source_sink)
 *   usbtest MODULE --case N   of these cases one alone
 *   usbtest MODULE --rig      a rig as it ships: usbtest then knows only endpoint 0, so that the cases 0, 9
 *                             and 10 apply
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
#include <unistd.h>

#define DEVICES "/sys/bus/usb/devices"
#define PATTERN "/sys/module/usbtest/parameters/pattern"

enum {
    WAIT_MAX_ms = 20000, /* for the device and its driver */
    REQUEST_PATTERN = 0x5d,
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
    {14, "control write and read back", 128, 256, 17, 0, ZEROES},
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
    char driver[32]; /* of the host controller */
} device;
static long only_case = -1;

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
    snprintf(folder, sizeof folder, DEVICES "/usb%ld/..", read_number(parent, "busnum", 10));
    read_driver(folder, device.driver, sizeof device.driver);
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
static void choose_kernels_pattern(int pattern)
{
    FILE *file = fopen(PATTERN, "we");
    if (file == NULL || fprintf(file, "%d\n", pattern) < 0 || fclose(file) != 0)
        give_up(PATTERN, strerror(errno));
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
               "kernel waits "
               "for them without end";
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

/* Without these rows, a kernel that compares nothing and a sink that takes everything would pass. After each
 * of them the device must work as before. */
static void check_judges(void)
{
    static const usb_case write = {1, "bulk write", 4, 1000, 0, 0, ZEROES | MOD_63};
    static const usb_case read = {2, "bulk read", 4, 1024, 0, 0, ZEROES | MOD_63};
    static const usb_case cut = {2, "bulk read", 4, 1000, 0, 0, ZEROES | MOD_63};
    double seconds = 0;
    choose_devices_pattern(0);
    choose_kernels_pattern(1);
    check(run(&read, &seconds) == EINVAL, "usbtest refuses what it reads in the other pattern");
    check(run(&write, &seconds) == EPIPE, "the sink halts at what it receives in the other pattern");
    check(run(&cut, &seconds) == EOVERFLOW, "usbtest refuses a packet that is longer than its buffer");
    check(run_with_patterns(&read, &seconds) == 0 && run_with_patterns(&write, &seconds) == 0,
          "source and sink then work as before");
}

int main(int argc, char **argv)
{
    device.is_rig = argc == 3 && strcmp(argv[2], "--rig") == 0;
    if (argc == 4 && strcmp(argv[2], "--case") == 0) only_case = strtol(argv[3], NULL, 10);
    if (argc != 2 && !device.is_rig && only_case < 0) {
        fprintf(stderr, "usage: %s MODULE [--rig | --case N]\n", argv[0]);
        return 2;
    }
    load_module(argv[1]);
    int waited_ms = 0;
    for (; !find_device() && waited_ms < WAIT_MAX_ms; waited_ms += 50) usleep(50000);
    if (waited_ms >= WAIT_MAX_ms) give_up("no device of usbtest", "none came within 20 s");
    int applied = 0, passed = 0;
    for (int i = 0; i < CASE_COUNT; i++) {
        bool has_passed = false;
        if (only_case >= 0 && cases[i].number != (uint32_t)only_case) continue;
        const char *left_out = why_left_out(&cases[i]);
        if (left_out != NULL) {
            check_note("left out: case %u, %s: %s", cases[i].number, cases[i].name, left_out);
            continue;
        }
        if (!run_row(&cases[i], &has_passed)) continue;
        applied++;
        passed += has_passed;
    }
    if (!device.is_rig && only_case < 0) check_judges();
    check_note("usbtest: of %d rows %d apply, and %d of them pass", CASE_COUNT, applied, passed);
    return check_end();
}
