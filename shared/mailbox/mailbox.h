/* USB tokens in shared memory: how an emulated device controller and an emulated host controller talk, in one process or
 * in two that map the same 64 KiB.
 *
 *   host writes its half, then counts up `token` (or `bus`)  --->  device sees a new number, acts, writes its half
 *   host reads the answer when `token_done` has its number   <---  and then repeats the number in `token_done`
 *
 * One token is under way at a time, as on a real bus; the host never waits for a device that is busy for longer than
 * its deadline. Each half has one writer. Every field is a little-endian 32-bit word; numbers that order the exchange are
 * written with release and read with acquire. Neither side trusts the other: lengths are bounded after they are read
 * once. Lost handshakes are told by a flag, since memory loses nothing.
 *
 * May include: nothing. Called by: firmware/port/mailbox, hil_tests/usb. C11 (gcc, clang).
 */
#ifndef SELD_MAILBOX_H
#define SELD_MAILBOX_H

#include <stdbool.h>
#include <stdint.h>

enum {
    SELD_MAILBOX_BYTES = 0x10000,
    SELD_MAILBOX_HOST_OFFSET = 0x1000, /* the halves stand on pages of their own */
    SELD_MAILBOX_DATA_OFFSET = 0x100,  /* in each half */
    SELD_MAILBOX_DATA_MAX = 1024,      /* largest packet of USB 2.0 */
    SELD_MAILBOX_MAGIC = 0x42535553,   /* "SUSB" */
    SELD_MAILBOX_VERSION = 1,
};

/* What the host does to the bus. */
typedef enum seld_mailbox_bus {
    SELD_MAILBOX_UNPLUGGED = 0, /* no power on the cable */
    SELD_MAILBOX_RESET_FULL,    /* reset that ends at full speed */
    SELD_MAILBOX_RESET_HIGH,    /* reset that ends at high speed, if the device can */
    SELD_MAILBOX_SUSPENDED,
    SELD_MAILBOX_RESUMED,
} seld_mailbox_bus;

typedef enum seld_mailbox_token {
    SELD_MAILBOX_SETUP = 1,
    SELD_MAILBOX_OUT,
    SELD_MAILBOX_IN,
} seld_mailbox_token;

/* Bits of `token_flags`. */
enum {
    SELD_MAILBOX_DATA1 = 1,    /* SETUP, OUT: the packet's toggle */
    SELD_MAILBOX_LOST_ACK = 2, /* IN: the host's acknowledgement gets lost: the device has to send again */
};

typedef enum seld_mailbox_reply {
    SELD_MAILBOX_SILENCE = 0, /* nobody answers: wrong address, no such endpoint, detached, malformed */
    SELD_MAILBOX_ACK,
    SELD_MAILBOX_NAK,
    SELD_MAILBOX_STALL,
    SELD_MAILBOX_REPLY_DATA0,
    SELD_MAILBOX_REPLY_DATA1,
} seld_mailbox_reply;

typedef struct seld_mailbox_device_half {
    uint32_t magic; /* written last at power-up */
    uint32_t version;
    uint32_t boot_count; /* a new number: the device started again and knows nothing of before */
    uint32_t attached;   /* 1: pull-up on */
    uint32_t can_high_speed;
    uint32_t bus_done;   /* = bus: that change was seen */
    uint32_t token_done; /* = token: reply, reply_bytes and data are its answer */
    uint32_t reply;
    uint32_t reply_bytes;
    uint32_t test_selector; /* test mode the device was put into, 0: none */
} seld_mailbox_device_half;

typedef struct seld_mailbox_host_half {
    uint32_t bus; /* counts changes of the bus */
    uint32_t bus_state;
    uint32_t token; /* counts tokens */
    uint32_t token_kind;
    uint32_t token_flags;
    uint32_t token_address;
    uint32_t token_endpoint; /* 0 .. 15 */
    uint32_t token_bytes;    /* SETUP, OUT: of data */
} seld_mailbox_host_half;

typedef struct seld_mailbox {
    seld_mailbox_device_half device;
    uint8_t gap1[SELD_MAILBOX_DATA_OFFSET - sizeof(seld_mailbox_device_half)];
    uint8_t device_data[SELD_MAILBOX_DATA_MAX];
    uint8_t gap2[SELD_MAILBOX_HOST_OFFSET - SELD_MAILBOX_DATA_OFFSET - SELD_MAILBOX_DATA_MAX];
    seld_mailbox_host_half host;
    uint8_t gap3[SELD_MAILBOX_DATA_OFFSET - sizeof(seld_mailbox_host_half)];
    uint8_t host_data[SELD_MAILBOX_DATA_MAX];
    uint8_t gap4[SELD_MAILBOX_BYTES - SELD_MAILBOX_HOST_OFFSET - SELD_MAILBOX_DATA_OFFSET -
                 SELD_MAILBOX_DATA_MAX];
} seld_mailbox;

_Static_assert(sizeof(seld_mailbox) == SELD_MAILBOX_BYTES, "the mailbox fills its 64 KiB");

static inline uint32_t seld_mailbox_little(uint32_t value)
{
#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
    return __builtin_bswap32(value);
#else
    return value;
#endif
}

/* Read a word of the other half: once, and before anything that is read after it. */
static inline uint32_t seld_mailbox_read(const uint32_t *word)
{
    return seld_mailbox_little(__atomic_load_n(word, __ATOMIC_ACQUIRE));
}

/* Write a word of the own half, after everything that was written before it. */
static inline void seld_mailbox_write(uint32_t *word, uint32_t value)
{
    __atomic_store_n(word, seld_mailbox_little(value), __ATOMIC_RELEASE);
}

#endif
