/* The chip's bus: which peripheral answers at an address, with which width, and behind which clock gate; the
 * list of waits and of findings. */
#include "hil_tests/rt1062/chip.h"
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>

enum { NO_GATE = 0xff, SPACE_BYTES = 0x4000, PRIVATE_BYTES = 0x100000 };
#define PRIVATE_BEGIN 0xe0000000u

typedef uint32_t reader(rt_chip *chip, uint32_t offset);
typedef void writer(rt_chip *chip, uint32_t offset, uint32_t value);

/* Modules that exist several times. */
#define INSTANCE(NAME, FUNCTION, NUMBER)                                                                     \
    static uint32_t read_##NAME(rt_chip *chip, uint32_t offset)                                              \
    {                                                                                                        \
        return rt_##FUNCTION##_read(chip, NUMBER, offset);                                                   \
    }                                                                                                        \
    static void write_##NAME(rt_chip *chip, uint32_t offset, uint32_t value)                                 \
    {                                                                                                        \
        rt_##FUNCTION##_write(chip, NUMBER, offset, value);                                                  \
    }
INSTANCE(gpio1, gpio, 0)
INSTANCE(gpio2, gpio, 1)
INSTANCE(gpio3, gpio, 2)
INSTANCE(enc1, decoder, 0)
INSTANCE(enc2, decoder, 1)
INSTANCE(enc3, decoder, 2)
INSTANCE(enc4, decoder, 3)
INSTANCE(tmr1, timer, 1)
INSTANCE(tmr3, timer, 3)
INSTANCE(pwm2, pwm, 0)
INSTANCE(pwm3, pwm, 1)
INSTANCE(adc1, adc, 0)
INSTANCE(adc2, adc, 1)

static void write_nothing(rt_chip *chip, uint32_t offset, uint32_t value)
{
    (void)value;
    rt_unmodelled(chip, "OCOTP", offset, true);
}

/* Gates: register CCGRn and its field, as the chip's public description names them. */
static const struct place {
    const char *name;
    uint32_t base;
    uint8_t bits, register_number, gate;
    reader *read;
    writer *write;
} places[] = {
    {"CCM", BASE_CCM, 32, NO_GATE, 0, rt_ccm_read, rt_ccm_write},
    {"CCM_ANALOG", BASE_CCM_ANALOG, 32, 6, 11, rt_analog_read, rt_analog_write},
    {"USBPHY1", BASE_USBPHY1, 32, 6, 0, rt_usb_phy_read, rt_usb_phy_write},
    {"DCDC", BASE_DCDC, 32, 6, 3, rt_dcdc_read, rt_dcdc_write},
    {"IOMUXC_GPR", BASE_IOMUXC_GPR, 32, 4, 2, rt_gpr_read, rt_gpr_write},
    {"IOMUXC", BASE_IOMUXC, 32, 4, 1, rt_iomuxc_read, rt_iomuxc_write},
    {"GPIO1", BASE_GPIO1, 32, 1, 13, read_gpio1, write_gpio1},
    {"GPIO2", BASE_GPIO2, 32, 0, 15, read_gpio2, write_gpio2},
    {"GPIO3", BASE_GPIO3, 32, 2, 13, read_gpio3, write_gpio3},
    {"PIT", BASE_PIT, 32, 1, 6, rt_pit_read, rt_pit_write},
    {"GPT1", BASE_GPT1, 32, 1, 10, rt_gpt_read, rt_gpt_write},
    {"WDOG1", BASE_WDOG1, 16, 3, 8, rt_wdog_read, rt_wdog_write},
    {"RTWDOG", BASE_RTWDOG, 32, 5, 2, rt_rtwdog_read, rt_rtwdog_write},
    {"SRC", BASE_SRC, 32, NO_GATE, 0, rt_src_read, rt_src_write},
    {"OCOTP", BASE_OCOTP, 32, 2, 6, rt_ocotp_read, write_nothing},
    {"LPUART6", BASE_LPUART6, 32, 3, 3, rt_uart_read, rt_uart_write},
    {"XBARA1", BASE_XBARA1, 16, 2, 11, rt_crossbar_read, rt_crossbar_write},
    {"ENC1", BASE_ENC1, 16, 4, 12, read_enc1, write_enc1},
    {"ENC2", BASE_ENC2, 16, 4, 13, read_enc2, write_enc2},
    {"ENC3", BASE_ENC3, 16, 4, 14, read_enc3, write_enc3},
    {"ENC4", BASE_ENC4, 16, 4, 15, read_enc4, write_enc4},
    {"TMR1", BASE_TMR1, 16, 6, 13, read_tmr1, write_tmr1},
    {"TMR3", BASE_TMR3, 16, 6, 15, read_tmr3, write_tmr3},
    {"PWM2", BASE_PWM2, 16, 4, 9, read_pwm2, write_pwm2},
    {"PWM3", BASE_PWM3, 16, 4, 10, read_pwm3, write_pwm3},
    {"ADC1", BASE_ADC1, 32, 1, 8, read_adc1, write_adc1},
    {"ADC2", BASE_ADC2, 32, 1, 4, read_adc2, write_adc2},
    {"FLEXSPI2", BASE_FLEXSPI2, 32, 7, 1, rt_flexspi_read, rt_flexspi_write},
    {"USB1", BASE_USB1, 32, 6, 0, rt_usb_read, rt_usb_write},
};

/* CCM_ANALOG and USBPHY1 share a space of 16 kB: the later base wins. */
static const struct place *place_of(uint32_t address)
{
    const struct place *found = NULL;
    for (size_t i = 0; i < sizeof places / sizeof places[0]; i++) {
        const struct place *place = &places[i];
        if (address < place->base || address - place->base >= SPACE_BYTES) continue;
        if (found == NULL || place->base > found->base) found = place;
    }
    return found;
}

static bool can_access(rt_chip *chip, const struct place *place, uint32_t address, unsigned bytes)
{
    if (place == NULL) {
        rt_find(chip, "0x%08x belongs to no peripheral that is modelled", address);
        return false;
    }
    if (place->register_number != NO_GATE && !rt_gate_is_open(chip, place->register_number, place->gate)) {
        rt_find(chip, "%s+0x%x is accessed while its clock gate CCGR%u CG%u is closed", place->name,
                address - place->base, place->register_number, place->gate);
        return false;
    }
    if (bytes * 8 != place->bits || address % bytes != 0) {
        rt_find(chip, "%s+0x%x is accessed with %u bits; its registers have %u", place->name,
                address - place->base, bytes * 8, place->bits);
        return false;
    }
    return true;
}

static void count_access(rt_census *census, uint32_t address, unsigned bytes, bool is_write, uint32_t value)
{
    uint32_t i = 0;
    while (i < census->count && census->registers[i].address != address) i++;
    if (i == RT_CENSUS_MAX) return;
    if (i == census->count) census->count++;
    census->registers[i].address = address;
    census->registers[i].bytes = bytes;
    if (is_write) {
        census->registers[i].writes++;
        census->registers[i].written_ones |= value;
        census->registers[i].written_zeros |= ~value;
        return;
    }
    census->registers[i].reads++;
    census->registers[i].ones |= value;
    census->registers[i].zeros |= ~value;
}

static uint32_t read_true(rt_chip *chip, uint32_t address, unsigned bytes)
{
    if (address - PRIVATE_BEGIN < PRIVATE_BYTES) return rt_core_read(chip, address);
    const struct place *place = place_of(address);
    return can_access(chip, place, address, bytes) ? place->read(chip, address - place->base) : 0;
}

uint32_t rt_chip_read(rt_chip *chip, uint32_t address, unsigned bytes)
{
    uint32_t value = read_true(chip, address, bytes);
    if (chip->census != NULL) count_access(chip->census, address, bytes, false, value);
    return rt_fault_read(chip, address, rt_mutant_read(chip, address, value));
}

void rt_chip_tamper(rt_chip *chip, uint32_t address, uint32_t clear, uint32_t set)
{
    chip->tamper.address = address;
    chip->tamper.clear = clear;
    chip->tamper.set = set;
}

void rt_chip_write(rt_chip *chip, uint32_t address, unsigned bytes, uint32_t value)
{
    if (address == chip->tamper.address && address != 0)
        value = (value & ~chip->tamper.clear) | chip->tamper.set;
    if (chip->census != NULL) count_access(chip->census, address, bytes, true, value);
    if (!rt_fault_write(chip, address, &value) || !rt_mutant_write(chip, address, &value)) return;
    if (address - PRIVATE_BEGIN < PRIVATE_BYTES) {
        rt_core_write(chip, address, value);
        return;
    }
    const struct place *place = place_of(address);
    if (can_access(chip, place, address, bytes)) place->write(chip, address - place->base, value);
}

/* --- time --- */
uint64_t rt_chip_run_due(rt_chip *chip)
{
    rt_clocks_update(chip);
    uint64_t fault = rt_fault_run_due(chip), next = rt_pit_run_due(chip), dogs = rt_watchdogs_run_due(chip),
             usb = rt_usb_run_due(chip);
    next = next < dogs ? next : dogs;
    next = next < fault ? next : fault;
    return next < usb ? next : usb;
}

int rt_chip_interrupt(rt_chip *chip)
{
    if (rt_fault_is(&chip->fault, RT_FAULT_INTERRUPT)) return (int)chip->fault.address;
    if (rt_fault_is(&chip->fault, RT_FAULT_NO_INTERRUPT)) return -1;
    bool is_enabled = (chip->core.enabled[RT_INTERRUPT_PIT / 32] >> RT_INTERRUPT_PIT % 32 & 1u) != 0;
    return is_enabled && rt_pit_interrupts(chip) ? RT_INTERRUPT_PIT : -1;
}

void rt_chip_pass_us(rt_chip *chip, double us)
{
    uint64_t end = chip->now + (uint64_t)(us * RT_INSTANTS_PER_us);
    while (chip->now < end) {
        uint64_t next = rt_chip_run_due(chip);
        chip->now = next < end && next > chip->now ? next : end;
    }
    rt_chip_run_due(chip);
}

/* --- waits and findings --- */
static rt_wait *wait_of(rt_chip *chip, uint32_t address)
{
    for (uint32_t i = 0; i < chip->waits_count; i++)
        if (chip->waits[i].address == address && chip->waits[i].pc == chip->pc) return &chip->waits[i];
    if (chip->waits_count == RT_WAITS_MAX) return NULL;
    rt_wait *wait = &chip->waits[chip->waits_count++];
    *wait = (rt_wait){.address = address, .pc = chip->pc, .first = chip->now, .is_answered = true};
    return wait;
}

void rt_pending(rt_chip *chip, uint32_t address, const char *format, ...)
{
    rt_wait *wait = wait_of(chip, address);
    if (wait == NULL) return;
    if (wait->is_answered) wait->first = chip->now, wait->polls = 0;
    wait->is_answered = false;
    wait->polls++;
    wait->last = chip->now;
    va_list list;
    va_start(list, format);
    vsnprintf(wait->reason, sizeof wait->reason, format, list);
    va_end(list);
}

void rt_answered(rt_chip *chip, uint32_t address)
{
    for (uint32_t i = 0; i < chip->waits_count; i++)
        if (chip->waits[i].address == address) chip->waits[i].is_answered = true;
}

void rt_find(rt_chip *chip, const char *format, ...)
{
    char text[RT_TEXT_BYTES];
    va_list list;
    va_start(list, format);
    vsnprintf(text, sizeof text, format, list);
    va_end(list);
    for (uint32_t i = 0; i < chip->findings_count; i++) {
        if (strcmp(chip->findings[i].text, text) != 0) continue;
        chip->findings[i].count++;
        return;
    }
    if (chip->findings_count == RT_FINDINGS_MAX) return;
    rt_finding *finding = &chip->findings[chip->findings_count++];
    *finding = (rt_finding){.pc = chip->pc, .count = 1};
    memcpy(finding->text, text, sizeof text);
}

void rt_unmodelled(rt_chip *chip, const char *module, uint32_t offset, bool is_write)
{
    rt_find(chip, "%s+0x%x is %s, and the model has no such register", module, offset,
            is_write ? "written" : "read");
}

const rt_wait *rt_unanswered(const rt_chip *chip, uint32_t index)
{
    for (uint32_t i = 0; i < chip->waits_count; i++)
        if (!chip->waits[i].is_answered && index-- == 0) return &chip->waits[i];
    return NULL;
}

uint32_t rt_report(const rt_chip *chip, FILE *to, rt_name_place *name, void *context)
{
    uint32_t count = 0;
    const rt_wait *wait;
    for (; (wait = rt_unanswered(chip, count)) != NULL; count++)
        fprintf(to, "never answered: 0x%08x at 0x%08x %s, %llu reads in %.3f ms: %s\n", wait->address,
                wait->pc, name ? name(context, wait->pc) : "", (unsigned long long)wait->polls,
                (double)(wait->last - wait->first) / (RT_INSTANTS_PER_us * 1000.0), wait->reason);
    for (uint32_t i = 0; i < chip->findings_count; i++) {
        const rt_finding *finding = &chip->findings[i];
        fprintf(to, "finding: %s (at 0x%08x %s, %llu times)\n", finding->text, finding->pc,
                name ? name(context, finding->pc) : "", (unsigned long long)finding->count);
    }
    return count + chip->findings_count;
}

/* --- memory and life --- */
uint8_t *rt_chip_memory(rt_chip *chip, uint32_t address, uint32_t bytes)
{
    if (address >= RT_OCRAM_BEGIN && bytes <= RT_OCRAM_BYTES &&
        address - RT_OCRAM_BEGIN <= RT_OCRAM_BYTES - bytes)
        return chip->ocram + (address - RT_OCRAM_BEGIN);
    uint32_t data = rt_dtcm_bytes(chip);
    if (address >= RT_DTCM_BEGIN && bytes <= data && address - RT_DTCM_BEGIN <= data - bytes)
        return chip->flexram + (RT_FLEXRAM_BYTES - data) + (address - RT_DTCM_BEGIN);
    rt_find(chip, "a controller accesses 0x%08x, where no memory is", address);
    return NULL;
}

void rt_chip_reset(rt_chip *chip, rt_reset_cause cause)
{
    chip->reset = cause;
    rt_watchdogs_reset(chip, cause == RT_RESET_POWER);
    chip->reset = RT_RESET_NONE;
    rt_clocks_reset(chip);
    rt_flexram_reset(chip);
    rt_flexspi_reset(chip);
    rt_timers_reset(chip);
    rt_pins_reset(chip);
    rt_encoders_reset(chip);
    rt_pwm_reset(chip);
    rt_adc_reset(chip);
    rt_uart_reset(chip);
    rt_usb_reset(chip);
    rt_core_reset(chip);
    rt_mutant_reset(chip);
    if (cause == RT_RESET_POWER) chip->psram.has_four_lines = chip->psram.is_reset_enabled = false;
}

static uint8_t *memory_of(size_t bytes)
{
    uint8_t *memory = aligned_alloc(4096, bytes);
    if (memory != NULL) memset(memory, 0xa5, bytes); /* what a memory holds at power-up is unknown */
    return memory;
}

rt_chip *rt_chip_create(void)
{
    rt_chip *chip = calloc(1, sizeof *chip);
    if (chip == NULL) return NULL;
    rt_mutant_take(chip);
    chip->flexram = memory_of(RT_FLEXRAM_BYTES);
    chip->ocram = memory_of(RT_OCRAM_BYTES);
    chip->flash = memory_of(RT_FLASH_BYTES);
    chip->psram = (rt_psram){.memory = memory_of(RT_PSRAM_BYTES), .is_fitted = true};
    if (!chip->flexram || !chip->ocram || !chip->flash || !chip->psram.memory) {
        rt_chip_destroy(chip);
        return NULL;
    }
    for (rt_pin pin = 0; pin < RT_PINS; pin++) chip->pins.rig[pin] = RT_OPEN;
    rt_chip_reset(chip, RT_RESET_POWER);
    return chip;
}

void rt_chip_destroy(rt_chip *chip)
{
    if (chip == NULL) return;
    rt_mutant_write_census(chip);
    free(chip->flexram);
    free(chip->ocram);
    free(chip->flash);
    free(chip->psram.memory);
    free(chip);
}
