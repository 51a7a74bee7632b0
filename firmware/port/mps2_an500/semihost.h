/* This header gives access to services of the debugger or emulator that runs the program ("semihosting"):
 * text, files, arguments, exit. */
#ifndef CRN_PORT_SEMIHOST_H
#define CRN_PORT_SEMIHOST_H

#include <stddef.h>
#include <stdint.h>

void semihost_write(const char *text);

/* Reads a whole file. Returns the size of the file in bytes, or 0 if the file cannot be read or is larger
 * than `capacity`. */
size_t semihost_read_file(const char *path, void *bytes, size_t capacity);

/* Splits the command line at blanks into argv, sets argv[count] to NULL, and returns the number of arguments,
 * which is at most `most`. */
int semihost_arguments(char *line, size_t capacity, char **argv, int most);

_Noreturn void semihost_exit(int code);

#endif
