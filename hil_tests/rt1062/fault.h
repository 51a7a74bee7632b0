/* One fault of the chip or of the lines at its pins, for a while that begins and ends at a stated instant. It
 * acts where the processor meets a register, where memory holds its bits, and where a clock, an interrupt, a
 * pin or the bus fails. fault_words.c lists the stored words in which a bit can flip. The campaign that draws
 * faults and judges them: chip_fault.hpp. */
#ifndef CRN_RT1062_FAULT_H
#define CRN_RT1062_FAULT_H

#include <stdbool.h>
#include <stdint.h>

struct rt_chip;

typedef enum rt_fault_kind {
    RT_FAULT_NONE,
    RT_FAULT_READ,       /* bits of a register are read wrongly: clear, then set, then flip */
    RT_FAULT_FROZEN,     /* a register reads as it did at the first read */
    RT_FAULT_WRITE,      /* bits of a register are written wrongly */
    RT_FAULT_WRITE_LOST, /* a register takes no writes */
    RT_FAULT_BUS,        /* the processor's accesses to a peripheral end in a bus error */
    RT_FAULT_UPSET,      /* bits of a stored word (`address`: its number) flip */
    RT_FAULT_MEMORY,     /* bits of a memory word flip; with `set`, so far above the stack pointer */
    RT_FAULT_EXCEPTION,  /* a memory behind the bus reports an error */
    RT_FAULT_INTERRUPT,  /* interrupt number `address` comes without a cause */
    RT_FAULT_NO_INTERRUPT,
    RT_FAULT_CORE_STANDS, /* the processor's clock and those made from it stand */
    RT_FAULT_CORE_SLOW,   /* they are `set` times as slow */
    RT_FAULT_TICK_RATE,   /* the millisecond timer's period is `set` thousandths of its own */
    RT_FAULT_NO_PSRAM,
    RT_FAULT_PIN,       /* pin `address` has the level `set`, whatever drives it */
    RT_FAULT_GLITCHES,  /* pin `address` (and the next phase, with `clear`) has `set` short pulses */
    RT_FAULT_VOLTS,     /* pin `address` has `volts`, or with `set` so much more */
    RT_FAULT_DUTY,      /* motor `address` gets the duty `set` */
    RT_FAULT_BUS_RESET, /* of USB, at high speed if `set` */
    RT_FAULT_SUSPEND,
    RT_FAULT_UNPLUG,
    RT_FAULT_SILENCE,  /* no token of the bus arrives */
    RT_FAULT_LOST_ACK, /* the host loses every answer of the device */
    RT_FAULT_NOISE,    /* bits of every packet to the device flip; the receiver drops it by its CRC */
    RT_FAULT_POWER,    /* the supply breaks down until the end, then the chip starts anew */
} rt_fault_kind;

typedef struct rt_fault {
    rt_fault_kind kind;
    uint64_t begin, end; /* instants; RT_NEVER: it stays */
    uint64_t token;      /* begins with this token of the bus; 0: at the instant `begin` */
    uint32_t address, clear, set, flip;
    double volts;
    /* what becomes of it */
    bool has_begun, has_ended, has_frozen;
    bool waits_for_engine; /* the processor's part of its begin or end is due */
    uint32_t frozen;
    uint64_t struck_at; /* the instant at which it began */
} rt_fault;

/* A stored word in which bits can flip. */
typedef struct rt_word {
    const char *part;
    void *at;
    uint8_t bytes;
    bool is_clock, is_map, is_motor; /* clocks, the processor's view, or the motors' PWM depend on it */
} rt_word;
enum { RT_WORDS_MAX = 512 };
uint32_t rt_fault_words(struct rt_chip *chip, rt_word words[RT_WORDS_MAX]);
void rt_word_flip(const rt_word *word, uint32_t bits);

void rt_fault_set(struct rt_chip *chip, const rt_fault *fault);
static inline bool rt_fault_is(const rt_fault *fault, rt_fault_kind kind)
{
    return fault->kind == kind && fault->has_begun && !fault->has_ended;
}

/* --- where it acts --- */
uint64_t rt_fault_run_due(struct rt_chip *chip);
uint32_t rt_fault_read(struct rt_chip *chip, uint32_t address, uint32_t value);
bool rt_fault_write(struct rt_chip *chip, uint32_t address, uint32_t *value); /* false: it is lost */
bool rt_fault_is_bus_error(const struct rt_chip *chip, uint32_t address);
bool rt_fault_core_stands(const struct rt_chip *chip);
void rt_fault_token(struct rt_chip *chip);

#endif
