/* This file contains the four memory functions that a freestanding compiler may call, under their C names
 * (gcc) and under their names in ARM's run-time ABI (clang). In ARM's run-time ABI, function names with the
 * suffix 4 or 8 guarantee that the addresses are aligned to 4 or 8 bytes. The compiler can replace loops by
 * calls of memory functions. This file switches off the replacement of loops by calls, because the memory
 * functions would then call themselves. */
#include <stddef.h>
#include <stdint.h>

void *memcpy(void *restrict to, const void *restrict from, size_t size);
void *memmove(void *to, const void *from, size_t size);
void *memset(void *to, int value, size_t size);
int memcmp(const void *a, const void *b, size_t size);

/* Copies words while source and destination are aligned, then bytes. The function copies overlapping blocks
 * correctly when `to` lies below `from`. */
static void *copy_upwards(unsigned char *to, const unsigned char *from, size_t size)
{
    unsigned char *t = to;
    if ((((uintptr_t)t | (uintptr_t)from) & 3u) == 0) {
        for (; size >= 4; size -= 4, t += 4, from += 4) *(uint32_t *)t = *(const uint32_t *)from;
    }
    while (size-- > 0) *t++ = *from++;
    return to;
}

void *memcpy(void *restrict to, const void *restrict from, size_t size)
{
    return copy_upwards(to, from, size);
}

void *memmove(void *to, const void *from, size_t size)
{
    unsigned char *t = to;
    const unsigned char *f = from;
    if ((uintptr_t)t <= (uintptr_t)f) return copy_upwards(t, f, size);
    while (size-- > 0) t[size] = f[size];
    return to;
}

void *memset(void *to, int value, size_t size)
{
    unsigned char *t = to;
    while (size-- > 0) *t++ = (unsigned char)value;
    return to;
}

int memcmp(const void *a, const void *b, size_t size)
{
    const unsigned char *left = a, *right = b;
    for (size_t i = 0; i < size; i++) {
        if (left[i] != right[i]) return left[i] < right[i] ? -1 : 1;
    }
    return 0;
}

/* --- ARM's run-time ABI --------------------------------------------------------------------------------- */

#define COPY(name)                                                                                           \
    void name(void *to, const void *from, size_t size);                                                      \
    void name(void *to, const void *from, size_t size)                                                       \
    {                                                                                                        \
        (void)memmove(to, from, size);                                                                       \
    }
#define CLEAR(name)                                                                                          \
    void name(void *to, size_t size);                                                                        \
    void name(void *to, size_t size)                                                                         \
    {                                                                                                        \
        (void)memset(to, 0, size);                                                                           \
    }
#define SET(name)                                                                                            \
    void name(void *to, size_t size, int value);                                                             \
    void name(void *to, size_t size, int value)                                                              \
    {                                                                                                        \
        (void)memset(to, value, size);                                                                       \
    }
COPY(__aeabi_memcpy)
COPY(__aeabi_memcpy4)
COPY(__aeabi_memcpy8)
COPY(__aeabi_memmove)
COPY(__aeabi_memmove4)
COPY(__aeabi_memmove8)
CLEAR(__aeabi_memclr)
CLEAR(__aeabi_memclr4)
CLEAR(__aeabi_memclr8)
SET(__aeabi_memset)
SET(__aeabi_memset4)
SET(__aeabi_memset8)
