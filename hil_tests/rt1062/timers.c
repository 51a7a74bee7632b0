/* PIT channel 0 (the millisecond edge, interrupt 122) and GPT1 (microseconds). Both count PERCLK. A timer
 * whose gate is closed cannot be written (chip.c), and one whose clock stands does not count. Behaviour:
 * reference manual, chapters PIT and GPT, from memory. */
#include "hil_tests/rt1062/chip.h"

enum { GPT_FROM_PERCLK = 2, GPT_RESET_ns = 500 };

static uint64_t pit_period(rt_chip *chip)
{
    double share = rt_fault_is(&chip->fault, RT_FAULT_TICK_RATE) ? chip->fault.set * 1e-3 : 1;
    double clock = rt_clock_perclk_Hz(chip);
    if (clock <= 0) return RT_NEVER / 2;
    return rt_mutant_time(chip, RT_TIME_PIT,
                          (uint64_t)((chip->pit.load + 1.0) / clock * share * RT_INSTANTS_PER_s + 0.5));
}

static bool pit_runs(const rt_pit *pit)
{
    return (pit->mcr & MASK(PIT_MCR_MDIS)) == 0 && (pit->control & MASK(PIT_TCTRL_0_TEN)) != 0;
}

uint32_t rt_pit_read(rt_chip *chip, uint32_t offset)
{
    const rt_pit *pit = &chip->pit;
    switch (offset) {
    case PIT_MCR:
        return pit->mcr;
    case PIT_LDVAL_0:
        return pit->load;
    case PIT_TCTRL_0:
        return pit->control;
    case PIT_TFLG_0:
        return pit->flag;
    default:
        rt_unmodelled(chip, "PIT", offset, false);
        return 0;
    }
}

void rt_pit_write(rt_chip *chip, uint32_t offset, uint32_t value)
{
    rt_pit *pit = &chip->pit;
    bool ran = pit_runs(pit);
    switch (offset) {
    case PIT_MCR:
        pit->mcr = value;
        break;
    case PIT_LDVAL_0:
        pit->load = value; /* counts from the next time-out on */
        break;
    case PIT_TCTRL_0:
        pit->control = value & (MASK(PIT_TCTRL_0_TEN) | MASK(PIT_TCTRL_0_TIE));
        break;
    case PIT_TFLG_0:
        pit->flag &= ~value;
        break;
    default:
        rt_unmodelled(chip, "PIT", offset, true);
    }
    if (!pit_runs(pit)) pit->next = RT_NEVER;
    if (!ran && pit_runs(pit)) pit->next = chip->now + pit_period(chip);
}

uint64_t rt_pit_run_due(rt_chip *chip)
{
    rt_pit *pit = &chip->pit;
    while (pit->next <= chip->now) {
        pit->flag |= MASK(PIT_TFLG_0_TIF);
        pit->next += pit_period(chip);
    }
    return pit->next;
}

bool rt_pit_interrupts(const rt_chip *chip)
{
    return (chip->pit.control & MASK(PIT_TCTRL_0_TIE)) != 0 && (chip->pit.flag & MASK(PIT_TFLG_0_TIF)) != 0;
}

static uint32_t gpt_count(rt_chip *chip)
{
    const rt_gpt *gpt = &chip->gpt;
    if ((gpt->control & MASK(GPT_CR_EN)) == 0 || RT_FIELD(gpt->control, GPT_CR_CLKSRC) != GPT_FROM_PERCLK)
        return gpt->count;
    double clock = rt_clock_perclk_Hz(chip) / (RT_FIELD(gpt->prescaler, GPT_PR_PRESCALER) + 1);
    uint64_t passed = rt_mutant_time(chip, RT_TIME_GPT, chip->now - gpt->begin);
    return (uint32_t)(uint64_t)((double)passed * clock / RT_INSTANTS_PER_s);
}

uint32_t rt_gpt_read(rt_chip *chip, uint32_t offset)
{
    rt_gpt *gpt = &chip->gpt;
    switch (offset) {
    case GPT_CR:
        if (chip->now < gpt->reset_until) {
            rt_pending(chip, BASE_GPT1 + GPT_CR, "GPT_CR SWR: the reset takes its time");
            return gpt->control | MASK(GPT_CR_SWR);
        }
        rt_answered(chip, BASE_GPT1 + GPT_CR);
        return gpt->control;
    case GPT_PR:
        return gpt->prescaler;
    case GPT_CNT:
        return gpt_count(chip);
    default:
        rt_unmodelled(chip, "GPT", offset, false);
        return 0;
    }
}

void rt_gpt_write(rt_chip *chip, uint32_t offset, uint32_t value)
{
    rt_gpt *gpt = &chip->gpt;
    if (offset == GPT_CR) {
        bool starts = (value & ~gpt->control & MASK(GPT_CR_EN)) != 0;
        if (value & MASK(GPT_CR_SWR)) {
            uint64_t time = rt_mutant_time(chip, RT_TIME_GPT_RESET, GPT_RESET_ns * RT_INSTANTS_PER_us / 1000);
            *gpt = (rt_gpt){.reset_until = chip->now + time};
            return;
        }
        if (starts && RT_FIELD(value, GPT_CR_CLKSRC) != GPT_FROM_PERCLK)
            rt_find(chip, "GPT1 starts on clock source %u, which does not run",
                    RT_FIELD(value, GPT_CR_CLKSRC));
        if (starts && (value & MASK(GPT_CR_ENMOD)) != 0) gpt->begin = chip->now; /* from 0 */
        gpt->control = value;
    } else if (offset == GPT_PR) {
        gpt->prescaler = value;
    } else {
        rt_unmodelled(chip, "GPT", offset, true);
    }
}

void rt_timers_reset(rt_chip *chip)
{
    chip->pit = (rt_pit){.mcr = MASK(PIT_MCR_MDIS), .next = RT_NEVER};
    chip->gpt = (rt_gpt){0};
}
