/* This file makes the semihosting calls of ARM's specification (version 2.0) by BKPT 0xAB, with the operation
 * in r0 and the address of its arguments in r1. */
#include "firmware/port/mps2_an500/semihost.h"

enum {
    SYS_OPEN = 0x01,
    SYS_CLOSE = 0x02,
    SYS_WRITE0 = 0x04,
    SYS_READ = 0x06,
    SYS_FLEN = 0x0c,
    SYS_GET_CMDLINE = 0x15,
    SYS_EXIT_EXTENDED = 0x20,
    STOPPED_BY_APPLICATION = 0x20026,
    READ_BINARY = 1,
};

static intptr_t call(uintptr_t operation, const void *arguments)
{
    register uintptr_t r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = arguments;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return (intptr_t)r0;
}

void semihost_write(const char *text)
{
    (void)call(SYS_WRITE0, text);
}

static uintptr_t length(const char *text)
{
    uintptr_t count = 0;
    while (text[count] != '\0') count++;
    return count;
}

size_t semihost_read_file(const char *path, void *bytes, size_t capacity)
{
    const uintptr_t open[3] = {(uintptr_t)path, READ_BINARY, length(path)};
    intptr_t handle = call(SYS_OPEN, open);
    if (handle < 0) return 0;
    const uintptr_t of_file[1] = {(uintptr_t)handle};
    intptr_t size = call(SYS_FLEN, of_file);
    if (size > 0 && (size_t)size <= capacity) {
        const uintptr_t read[3] = {(uintptr_t)handle, (uintptr_t)bytes, (uintptr_t)size};
        size =
            call(SYS_READ, read) == 0 ? size : 0; /* the result is the number of bytes that were not read */
    } else {
        size = 0;
    }
    (void)call(SYS_CLOSE, of_file);
    return (size_t)size;
}

int semihost_arguments(char *line, size_t capacity, char **argv, int most)
{
    uintptr_t block[2] = {(uintptr_t)line, capacity};
    int count = 0;
    if (call(SYS_GET_CMDLINE, block) == 0) {
        for (char *c = line; *c != '\0' && count < most;) {
            while (*c == ' ') *c++ = '\0';
            if (*c != '\0') argv[count++] = c;
            while (*c != ' ' && *c != '\0') c++;
        }
    }
    argv[count] = NULL;
    return count;
}

_Noreturn void semihost_exit(int code)
{
    const uintptr_t reason[2] = {STOPPED_BY_APPLICATION, (uintptr_t)code};
    for (;;) (void)call(SYS_EXIT_EXTENDED, reason);
}
