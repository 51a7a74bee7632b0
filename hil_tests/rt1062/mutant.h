/* A model whose behaviour is wrong in one respect, to find out whether a test notices (mutants.py). The
 * mutant is chosen at run time: the variable RT_MUTANT in the environment holds "kind address shift bits"
 * when a chip is made. RT_CENSUS names a file to which every chip appends, at its end, the registers that
 * were accessed. Without the two variables, nothing here does anything. */
#ifndef CRN_RT1062_MUTANT_H
#define CRN_RT1062_MUTANT_H

#include <stdbool.h>
#include <stdint.h>

struct rt_chip;

typedef enum rt_mutant_kind {
    RT_MUTANT_NONE,
    RT_MUTANT_READ_CLEAR, /* a field always reads 0 */
    RT_MUTANT_READ_SET,   /* all ones */
    RT_MUTANT_READ_FLIP,  /* inverted */
    RT_MUTANT_READ_MORE,  /* one more */
    RT_MUTANT_WRITE_CLEAR,
    RT_MUTANT_WRITE_SET,
    RT_MUTANT_WRITE_MORE,
    RT_MUTANT_WRITE_LOST, /* the register ignores what is written */
    RT_MUTANT_RESET,      /* bits of stored word `address` (rt_fault_words) are inverted after a reset */
    RT_MUTANT_EARLY,      /* duration `address` is a quarter of what it should be */
    RT_MUTANT_LATE,       /* four times */
    RT_MUTANT_KINDS,
} rt_mutant_kind;

/* The durations of the model. */
typedef enum rt_duration {
    RT_TIME_ARM_LOCK,
    RT_TIME_SYSTEM_LOCK,
    RT_TIME_USB_LOCK,
    RT_TIME_HANDSHAKE,
    RT_TIME_VOLTAGE,
    RT_TIME_FLEXSPI_RESET,
    RT_TIME_FLEXSPI_COMMAND,
    RT_TIME_FLEXSPI_LINE,
    RT_TIME_NEAR_LINE,
    RT_TIME_PIT,
    RT_TIME_GPT,
    RT_TIME_GPT_RESET,
    RT_TIME_WDOG,
    RT_TIME_RTWDOG,
    RT_TIME_RTWDOG_UNLOCK,
    RT_TIME_FILTER,
    RT_TIME_ADC_CALIBRATION,
    RT_TIME_ADC_CONVERSION,
    RT_TIME_UART_BYTE,
    RT_TIME_USB_RESET,
    RT_TIME_USB_PRIME,
    RT_TIME_USB_FLUSH,
    RT_TIME_USB_BUS_RESET,
    RT_TIMES,
} rt_duration;

typedef struct rt_mutant {
    rt_mutant_kind kind;
    uint32_t address, shift, bits;
} rt_mutant;

void rt_mutant_take(struct rt_chip *chip); /* from the environment */
void rt_mutant_reset(struct rt_chip *chip);
uint32_t rt_mutant_read(const struct rt_chip *chip, uint32_t address, uint32_t value);
bool rt_mutant_write(const struct rt_chip *chip, uint32_t address, uint32_t *value); /* false: it is lost */
uint64_t rt_mutant_time(const struct rt_chip *chip, rt_duration which, uint64_t instants);
void rt_mutant_write_census(const struct rt_chip *chip);

#endif
