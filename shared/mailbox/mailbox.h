/* USB tokens in shared memory: the connection between an emulated device controller and an emulated host
 * controller, in one process or in two that map the same 64 KiB.
 *
 *   host writes its half, then counts up `token` (or `bus`)  --->  device sees a new number, acts, writes its half
 *   host reads the answer when `token_done` has its number   <---  and then repeats the number in `token_done`
 *
 * Host and device exchange one token at a time, as on a real USB bus. The host never waits longer than its
 * deadline for a device that is busy. Each half has one writer. Every field of the mailbox is a little-endian
 * 32-bit word; the sequence numbers are written with release and read with acquire semantics. Host and device
 * do not trust each other: each reads a length once and then limits it. A flag of the mailbox simulates lost
 * handshakes, because the shared memory itself never loses anything.
 *
 * C11 (gcc, clang). */
#ifndef CRN_MAILBOX_H
#define CRN_MAILBOX_H

#include <stdbool.h>
#include <stdint.h>

enum {
    CRN_MAILBOX_BYTES = 0x10000,
    CRN_MAILBOX_HOST_OFFSET = 0x1000, /* the halves are on pages of their own */
    CRN_MAILBOX_DATA_OFFSET = 0x100,  /* in each half */
    CRN_MAILBOX_DATA_MAX = 1024,      /* largest packet of USB 2.0 */
    CRN_MAILBOX_MAGIC = 0x42535553,   /* "SUSB" */
    CRN_MAILBOX_VERSION = 1,
};

/* Lists the states of the bus that the host can set. */
typedef enum crn_mailbox_bus {
    CRN_MAILBOX_UNPLUGGED = 0, /* no power on the cable */
    CRN_MAILBOX_RESET_FULL,    /* reset that ends at full speed */
    CRN_MAILBOX_RESET_HIGH,    /* reset that ends at high speed, if the device can */
    CRN_MAILBOX_SUSPENDED,
    CRN_MAILBOX_RESUMED,
} crn_mailbox_bus;

typedef enum crn_mailbox_token {
    CRN_MAILBOX_SETUP = 1,
    CRN_MAILBOX_OUT,
    CRN_MAILBOX_IN,
} crn_mailbox_token;

/* Bits of `token_flags`. */
enum {
    CRN_MAILBOX_DATA1 = 1,    /* SETUP, OUT: the packet's toggle */
    CRN_MAILBOX_LOST_ACK = 2, /* IN: the host's acknowledgement is lost, so the device has to send again */
};

typedef enum crn_mailbox_reply {
    CRN_MAILBOX_SILENCE = 0, /* no answer: wrong address, no such endpoint, detached, malformed */
    CRN_MAILBOX_ACK,
    CRN_MAILBOX_NAK,
    CRN_MAILBOX_STALL,
    CRN_MAILBOX_REPLY_DATA0,
    CRN_MAILBOX_REPLY_DATA1,
} crn_mailbox_reply;

typedef struct crn_mailbox_device_half {
    uint32_t magic; /* written last at power-up */
    uint32_t version;
    uint32_t boot_count; /* a new number means that the device restarted and has lost its history */
    uint32_t attached;   /* 1: pull-up on */
    uint32_t can_high_speed;
    uint32_t bus_done;   /* = bus: that change was seen */
    uint32_t token_done; /* = token: reply, reply_bytes and data are the answer to it */
    uint32_t reply;
    uint32_t reply_bytes;
    uint32_t test_selector; /* test mode the device was put into, 0: none */
} crn_mailbox_device_half;

typedef struct crn_mailbox_host_half {
    uint32_t bus; /* counts changes of the bus */
    uint32_t bus_state;
    uint32_t token; /* counts tokens */
    uint32_t token_kind;
    uint32_t token_flags;
    uint32_t token_address;
    uint32_t token_endpoint; /* 0 .. 15 */
    uint32_t token_bytes;    /* SETUP, OUT: length of data */
} crn_mailbox_host_half;

typedef struct crn_mailbox {
    crn_mailbox_device_half device;
    uint8_t gap1[CRN_MAILBOX_DATA_OFFSET - sizeof(crn_mailbox_device_half)];
    uint8_t device_data[CRN_MAILBOX_DATA_MAX];
    uint8_t gap2[CRN_MAILBOX_HOST_OFFSET - CRN_MAILBOX_DATA_OFFSET - CRN_MAILBOX_DATA_MAX];
    crn_mailbox_host_half host;
    uint8_t gap3[CRN_MAILBOX_DATA_OFFSET - sizeof(crn_mailbox_host_half)];
    uint8_t host_data[CRN_MAILBOX_DATA_MAX];
    uint8_t
        gap4[CRN_MAILBOX_BYTES - CRN_MAILBOX_HOST_OFFSET - CRN_MAILBOX_DATA_OFFSET - CRN_MAILBOX_DATA_MAX];
} crn_mailbox;

_Static_assert(sizeof(crn_mailbox) == CRN_MAILBOX_BYTES, "the mailbox fills its 64 KiB");

static inline uint32_t crn_mailbox_little(uint32_t value)
{
#if __BYTE_ORDER__ == __ORDER_BIG_ENDIAN__
    return __builtin_bswap32(value);
#else
    return value;
#endif
}

/* Reads a word of the other side's half of the mailbox once, before any later read. */
static inline uint32_t crn_mailbox_read(const uint32_t *word)
{
    return crn_mailbox_little(__atomic_load_n(word, __ATOMIC_ACQUIRE));
}

/* Writes a word of this side's half of the mailbox after all earlier writes. */
static inline void crn_mailbox_write(uint32_t *word, uint32_t value)
{
    __atomic_store_n(word, crn_mailbox_little(value), __ATOMIC_RELEASE);
}

/* Starts the device's half at power-up: not attached, and all that the host has asked for counts as seen. */
static inline void crn_mailbox_start_device(crn_mailbox *mailbox, uint32_t can_high_speed)
{
    crn_mailbox_device_half *half = &mailbox->device;
    crn_mailbox_write(&half->attached, 0);
    crn_mailbox_write(&half->can_high_speed, can_high_speed);
    crn_mailbox_write(&half->test_selector, 0);
    crn_mailbox_write(&half->reply, CRN_MAILBOX_SILENCE);
    crn_mailbox_write(&half->reply_bytes, 0);
    crn_mailbox_write(&half->bus_done, crn_mailbox_read(&mailbox->host.bus));
    crn_mailbox_write(&half->token_done, crn_mailbox_read(&mailbox->host.token));
    crn_mailbox_write(&half->version, CRN_MAILBOX_VERSION);
    crn_mailbox_write(&half->boot_count, crn_mailbox_read(&half->boot_count) + 1);
    crn_mailbox_write(&half->magic, CRN_MAILBOX_MAGIC);
}

#endif
