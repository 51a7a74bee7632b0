/* Declares the text output for those check programs that also run without an operating system. Each check
 * program is linked with either console_stdio.c or console_semihost.c. */
#ifndef CRN_CHECK_CONSOLE_H
#define CRN_CHECK_CONSOLE_H

void console_write(const char *text);

#endif
