/* The output of a check's program that also runs without an operating system. One of console_stdio.c and
 * console_semihost.c is linked. */
#ifndef CRN_CHECK_CONSOLE_H
#define CRN_CHECK_CONSOLE_H

void console_write(const char *text);

#endif
