/* This header has functions that the programs of this folder share: TAP lines, a clock, and the option that
 * names the device. */
#ifndef CRN_LIBRARY_CHECK_H
#define CRN_LIBRARY_CHECK_H

#include <stdbool.h>
#include <stdint.h>

#ifndef CRN_USB_VENDOR_ID /* make USB_ID=... */
#define CRN_USB_VENDOR_ID 0x1209
#define CRN_USB_PRODUCT_ID 0x0001
#endif
enum { CHECK_VENDOR_ID = CRN_USB_VENDOR_ID, CHECK_PRODUCT_ID = CRN_USB_PRODUCT_ID };

/* Prints "ok N - name" if `good` is true and "not ok N - name" otherwise; returns `good`. */
bool check(bool good, const char *name);

/* Prints a line that begins with "# "; the arguments are those of printf. */
void check_note(const char *format, ...) __attribute__((format(printf, 1, 2)));

/* Prints the TAP plan (the number of tests), and returns the program's exit code. */
int check_end(void);

int64_t check_now_us(void);

/* Returns the serial number that follows `--serial` on the command line, or NULL without this option. Any
 * other argument ends the program with exit code 2. */
const char *check_serial(int argc, char **argv);

#endif
