/* What a fault does to the chip at its begin, meanwhile, and at its end. What needs the processor (memory as
 * code, exceptions, power) is done by engine_fault.c. */
#include "hil_tests/rt1062/chip.h"
#include <string.h>

enum { MODULE_BYTES = 0x4000, GLITCH_us = 2 };

void rt_fault_set(rt_chip *chip, const rt_fault *fault)
{
    chip->fault = *fault;
}

static bool is_of_engine(rt_fault_kind kind)
{
    return kind == RT_FAULT_MEMORY || kind == RT_FAULT_EXCEPTION || kind == RT_FAULT_POWER;
}

/* --- begin and end --- */
void rt_word_flip(const rt_word *word, uint32_t bits)
{
    uint32_t value = 0;
    memcpy(&value, word->at, word->bytes);
    value ^= bits;
    memcpy(word->at, &value, word->bytes);
}

static void upset(rt_chip *chip, const rt_fault *fault)
{
    static rt_word words[RT_WORDS_MAX];
    uint32_t count = rt_fault_words(chip, words);
    const rt_word *word = &words[fault->address % count];
    rt_word_flip(word, fault->flip);
    if (word->is_clock) rt_clocks_upset(chip);
    if (word->is_map) chip->is_map_changed = true;
    rt_pwm_fault(chip);
}

/* Pulses that are long enough for the input filters. Two phases that change at once are an illegal step. */
static void glitch(rt_chip *chip, const rt_fault *fault)
{
    rt_pin first = (rt_pin)fault->address, second = (rt_pin)(fault->address + 7);
    const uint64_t half = GLITCH_us * RT_INSTANTS_PER_us;
    uint64_t instant = chip->now > 2 * half * fault->set ? chip->now - 2 * half * fault->set : 0;
    const uint8_t levels[2] = {chip->pins.rig[first], chip->pins.rig[second]};
    for (uint32_t i = 0; i < 2 * fault->set; i++, instant += half) {
        bool turned = i % 2 == 0;
        rt_pin_drive(chip, first, (levels[0] == RT_HIGH) != turned ? RT_HIGH : RT_LOW, instant);
        if (fault->clear != 0)
            rt_pin_drive(chip, second, (levels[1] == RT_HIGH) != turned ? RT_HIGH : RT_LOW, instant);
    }
}

static void begin(rt_chip *chip)
{
    rt_fault *fault = &chip->fault;
    fault->has_begun = true;
    fault->struck_at = chip->now;
    fault->waits_for_engine = is_of_engine(fault->kind);
    switch (fault->kind) {
    case RT_FAULT_UPSET:
        upset(chip, fault);
        break;
    case RT_FAULT_GLITCHES:
        glitch(chip, fault);
        break;
    case RT_FAULT_PIN:
        rt_pin_drive(chip, (rt_pin)fault->address, (rt_level)chip->pins.rig[fault->address], chip->now);
        break;
    case RT_FAULT_CORE_SLOW:
        chip->clocks.core_Hz /= fault->set;
        chip->clocks.instants_per_cycle *= fault->set;
        break;
    case RT_FAULT_NO_PSRAM:
        chip->psram.is_fitted = false;
        chip->is_map_changed = true;
        break;
    case RT_FAULT_BUS_RESET:
        rt_usb_bus_reset(chip, fault->set != 0);
        break;
    case RT_FAULT_SUSPEND:
        rt_usb_suspend(chip, true);
        break;
    case RT_FAULT_UNPLUG:
        rt_usb_plug(chip, false);
        break;
    default:
        break;
    }
}

static void end(rt_chip *chip)
{
    rt_fault *fault = &chip->fault;
    fault->has_ended = true;
    fault->waits_for_engine = fault->kind == RT_FAULT_POWER;
    switch (fault->kind) {
    case RT_FAULT_PIN:
        rt_pin_drive(chip, (rt_pin)fault->address, (rt_level)chip->pins.rig[fault->address], chip->now);
        break;
    case RT_FAULT_CORE_SLOW:
        chip->clocks.core_Hz *= fault->set;
        chip->clocks.instants_per_cycle /= fault->set;
        break;
    case RT_FAULT_NO_PSRAM:
        chip->psram.is_fitted = true;
        chip->is_map_changed = true;
        break;
    case RT_FAULT_SUSPEND:
        rt_usb_suspend(chip, false);
        break;
    case RT_FAULT_UNPLUG:
        rt_usb_plug(chip, true);
        break;
    default:
        break;
    }
}

uint64_t rt_fault_run_due(rt_chip *chip)
{
    rt_fault *fault = &chip->fault;
    if (fault->kind == RT_FAULT_NONE || fault->has_ended)
        return fault->waits_for_engine ? chip->now : RT_NEVER;
    if (!fault->has_begun && fault->token == 0 && chip->now >= fault->begin) begin(chip);
    if (fault->has_begun && !fault->waits_for_engine && chip->now >= fault->end) end(chip);
    if (fault->waits_for_engine) return chip->now;
    if (fault->has_begun) return fault->has_ended ? RT_NEVER : fault->end;
    return fault->token == 0 ? fault->begin : RT_NEVER;
}

void rt_fault_token(rt_chip *chip)
{
    rt_fault *fault = &chip->fault;
    if (fault->kind == RT_FAULT_NONE || fault->has_begun || fault->token == 0) return;
    if (chip->usb.tokens < fault->token) return;
    uint64_t lasts = fault->end - fault->begin;
    fault->end = fault->end == RT_NEVER ? RT_NEVER : chip->now + lasts;
    begin(chip);
}

/* --- meanwhile --- */
static uint32_t changed(const rt_fault *fault, uint32_t value)
{
    return ((value & ~fault->clear) | fault->set) ^ fault->flip;
}

uint32_t rt_fault_read(rt_chip *chip, uint32_t address, uint32_t value)
{
    rt_fault *fault = &chip->fault;
    if (fault->address != address) return value;
    if (rt_fault_is(fault, RT_FAULT_READ)) return changed(fault, value);
    if (!rt_fault_is(fault, RT_FAULT_FROZEN)) return value;
    if (!fault->has_frozen) fault->frozen = value;
    fault->has_frozen = true;
    return fault->frozen;
}

bool rt_fault_write(rt_chip *chip, uint32_t address, uint32_t *value)
{
    const rt_fault *fault = &chip->fault;
    if (fault->address != address) return true;
    if (rt_fault_is(fault, RT_FAULT_WRITE)) *value = changed(fault, *value);
    return !rt_fault_is(fault, RT_FAULT_WRITE_LOST);
}

bool rt_fault_is_bus_error(const rt_chip *chip, uint32_t address)
{
    const rt_fault *fault = &chip->fault;
    return rt_fault_is(fault, RT_FAULT_BUS) && address - fault->address < MODULE_BYTES;
}

bool rt_fault_core_stands(const rt_chip *chip)
{
    return rt_fault_is(&chip->fault, RT_FAULT_CORE_STANDS) || rt_fault_is(&chip->fault, RT_FAULT_POWER) ||
           chip->clocks.is_dead;
}
