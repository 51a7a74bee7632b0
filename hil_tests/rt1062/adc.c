/* ADC1 and ADC2: calibration, single conversions with averaging. A converter works only with a clock of at
 * most 40 MHz, and is exact only after its calibration. Channels belong to pins as in the reference manual's
 * table of ADC inputs (from memory; the port's list was made without this one). */
#include "hil_tests/rt1062/chip.h"
#include <math.h>

enum {
    NO_CHANNEL = 31,
    CALIBRATION_CLOCKS = 14000,
    SAMPLE_CLOCKS = 25,
    FROM_IPG = 0,
    FROM_IPG_HALF = 1,
    BITS_12 = 2,
    RESULT_MAX = 4095,
};
static const double clock_max_Hz = 40e6, reference_V = 3.3;

/* Pins by channel; -1: not on this board. */
static int pin_of(uint32_t adc, uint32_t channel)
{
    if (adc == 0 && channel == 12) return RT_PIN_FORCE0;       /* AD_B1_07 */
    if (adc == 0 && channel == 11) return RT_PIN_FORCE0 + 1;   /* AD_B1_06 */
    if (adc == 0 && channel == 15) return RT_PIN_FORCE0 + 2;   /* AD_B1_10 */
    if (adc == 0 && channel == 13) return RT_PIN_CURRENT0;     /* AD_B1_08 */
    if (adc == 0 && channel == 14) return RT_PIN_CURRENT0 + 1; /* AD_B1_09 */
    if (adc == 0 && channel == 9) return RT_PIN_CURRENT0 + 2;  /* AD_B1_04 */
    if (channel == 0) return RT_PIN_PRESSURE;                  /* AD_B1_11, of both converters */
    if (adc == 1 && channel == 3) return RT_PIN_SUPPLY;        /* AD_B1_14 */
    return -1;
}

static double clock_of(rt_chip *chip, const rt_adc *adc)
{
    uint32_t source = RT_FIELD(adc->cfg, ADC_CFG_ADICLK);
    double clock = rt_clock_ipg_Hz(chip) / (source == FROM_IPG_HALF ? 2 : 1);
    if (source != FROM_IPG && source != FROM_IPG_HALF) return 0;
    return clock / (1u << RT_FIELD(adc->cfg, ADC_CFG_ADIV));
}

static bool has_clock(rt_chip *chip, const rt_adc *adc)
{
    double clock = clock_of(chip, adc);
    return clock > 0 && clock <= clock_max_Hz;
}

static uint64_t instants(rt_chip *chip, const rt_adc *adc, double clocks)
{
    return has_clock(chip, adc) ? (uint64_t)(clocks / clock_of(chip, adc) * RT_INSTANTS_PER_s) : RT_NEVER;
}

static uint32_t sample(rt_chip *chip, uint32_t number, uint32_t channel)
{
    int pin = pin_of(number, channel);
    if (pin < 0 || !rt_pin_is_routed(chip, (rt_pin)pin)) {
        rt_find(chip, "ADC%u converts channel %u, at which no analog pin of the board is", number + 1,
                channel);
        return 0;
    }
    const rt_fault *fault = &chip->fault;
    bool is_wrong = rt_fault_is(fault, RT_FAULT_VOLTS) && fault->address == (uint32_t)pin;
    double volts = is_wrong && fault->set == 0 ? 0 : chip->pins.volts[pin];
    double counts = (volts + (is_wrong ? fault->volts : 0)) / reference_V * RESULT_MAX;
    if (!chip->adc[number].is_calibrated) counts += 40; /* the data sheet allows such an offset before */
    return counts < 0 ? 0 : counts > RESULT_MAX ? RESULT_MAX : (uint32_t)lround(counts);
}

static void update(rt_chip *chip, uint32_t number)
{
    rt_adc *adc = &chip->adc[number];
    if ((adc->gc & MASK(ADC_GC_CAL)) != 0 && chip->now >= adc->calibrates_until) {
        adc->gc &= ~MASK(ADC_GC_CAL);
        adc->is_calibrated = (adc->gs & MASK(ADC_GS_CALF)) == 0;
    }
    if (adc->is_converting && chip->now >= adc->converts_until) {
        adc->result = sample(chip, number, RT_FIELD(adc->hc, ADC_HC0_ADCH));
        adc->is_converting = false;
        adc->is_complete = true;
    }
}

static const char *why(rt_chip *chip, const rt_adc *adc)
{
    return has_clock(chip, adc) ? "it takes its time" : "the converter's clock stands or is over 40 MHz";
}

uint32_t rt_adc_read(rt_chip *chip, uint32_t number, uint32_t offset)
{
    rt_adc *adc = &chip->adc[number];
    uint32_t at = (number == 0 ? BASE_ADC1 : BASE_ADC2) + offset;
    update(chip, number);
    switch (offset) {
    case ADC_HC0:
        return adc->hc;
    case ADC_CFG:
        return adc->cfg;
    case ADC_GC:
        if ((adc->gc & MASK(ADC_GC_CAL)) != 0)
            rt_pending(chip, at, "ADC%u_GC CAL: %s", number + 1, why(chip, adc));
        else
            rt_answered(chip, at);
        return adc->gc;
    case ADC_GS:
        return adc->gs;
    case ADC_HS:
        if (adc->is_complete) {
            rt_answered(chip, at);
            return MASK(ADC_HS_COCO0);
        }
        rt_pending(chip, at, "ADC%u_HS COCO0: %s", number + 1,
                   adc->is_converting ? why(chip, adc) : "no conversion was begun");
        return 0;
    case ADC_R0:
        adc->is_complete = false;
        return adc->result;
    default:
        rt_unmodelled(chip, "ADC", offset, false);
        return 0;
    }
}

static void begin(rt_chip *chip, rt_adc *adc, uint32_t value)
{
    adc->hc = value;
    adc->is_complete = adc->is_converting = false;
    if (RT_FIELD(value, ADC_HC0_ADCH) == NO_CHANNEL) return;
    if ((adc->gc & MASK(ADC_GC_CAL)) != 0) { /* spoils the calibration */
        adc->gc &= ~MASK(ADC_GC_CAL);
        adc->gs |= MASK(ADC_GS_CALF);
        return;
    }
    uint32_t samples = (adc->gc & MASK(ADC_GC_AVGE)) != 0 ? 4u << RT_FIELD(adc->cfg, ADC_CFG_AVGS) : 1;
    uint64_t time =
        rt_mutant_time(chip, RT_TIME_ADC_CONVERSION, instants(chip, adc, samples * (double)SAMPLE_CLOCKS));
    adc->is_converting = true;
    adc->converts_until = time == RT_NEVER ? RT_NEVER : chip->now + time;
}

void rt_adc_write(rt_chip *chip, uint32_t number, uint32_t offset, uint32_t value)
{
    rt_adc *adc = &chip->adc[number];
    update(chip, number);
    switch (offset) {
    case ADC_HC0:
        begin(chip, adc, value);
        break;
    case ADC_CFG:
        adc->cfg = value;
        if (RT_FIELD(value, ADC_CFG_MODE) != BITS_12)
            rt_find(chip, "ADC%u does not convert 12 bits", number + 1);
        break;
    case ADC_GC:
        if ((value & MASK(ADC_GC_CAL)) != 0) {
            uint64_t time =
                rt_mutant_time(chip, RT_TIME_ADC_CALIBRATION, instants(chip, adc, CALIBRATION_CLOCKS));
            adc->is_calibrated = false;
            adc->calibrates_until = time == RT_NEVER ? RT_NEVER : chip->now + time;
        }
        adc->gc = value;
        break;
    case ADC_GS:
        adc->gs &= ~(value & MASK(ADC_GS_CALF));
        break;
    default:
        rt_unmodelled(chip, "ADC", offset, true);
    }
}

void rt_adc_reset(rt_chip *chip)
{
    for (uint32_t number = 0; number < RT_ADCS; number++) chip->adc[number] = (rt_adc){.hc = NO_CHANNEL};
}
