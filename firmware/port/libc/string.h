/* This header is the part of <string.h> that shared/ and firmware/app use, for images that are linked without
 * a C library; the port provides the functions (memory.c). */
#ifndef CRN_PORT_STRING_H
#define CRN_PORT_STRING_H

#include <stddef.h>

void *memcpy(void *restrict to, const void *restrict from, size_t size);
void *memmove(void *to, const void *from, size_t size);
void *memset(void *to, int value, size_t size);
int memcmp(const void *a, const void *b, size_t size);

#endif
