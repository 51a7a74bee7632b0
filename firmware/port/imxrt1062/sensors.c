/* This port has never run on hardware. This file reads force, current, pressure and supply voltage through
 * the two 12-bit converters; each value is the mean of four samples. Both converters work in parallel, and
 * one sample of all values takes about 20 us. */
#include "firmware/port/imxrt1062/board.h"
#include "firmware/port/imxrt1062/imxrt1062_registers.h"

enum {
    WAIT_MAX = 2000, /* iterations, about 50 us: a converter that takes longer is broken */
    BITS_12 = 2,
    CLOCK_HALF = 1, /* 150 MHz / 2 / 2 = 37.5 MHz; the maximum is 40 MHz */
    DIVIDE_BY_2 = 1,
    NO_CHANNEL = 31,
    /* channels of ADC1, by pin: docs/porting.md */
    FORCE_1 = 12,
    FORCE_2 = 11,
    FORCE_3 = 15,
    PRESSURE = 0,
    CURRENT_1 = 13,
    CURRENT_2 = 14,
    CURRENT_3 = 9,
    SUPPLY = 3, /* of ADC2 */
};

static bool is_calibrated;

static bool start(uint32_t base)
{
    R32(base, ADC_CFG) = BITS(ADC_CFG_MODE, BITS_12) | BITS(ADC_CFG_ADICLK, CLOCK_HALF) |
                         BITS(ADC_CFG_ADIV, DIVIDE_BY_2) | BITS(ADC_CFG_ADLSMP, 1) | BITS(ADC_CFG_ADHSC, 1) |
                         BITS(ADC_CFG_AVGS, 0);
    R32(base, ADC_GS) = MASK(ADC_GS_CALF);
    R32(base, ADC_GC) = MASK(ADC_GC_AVGE) | MASK(ADC_GC_CAL);
    return board_wait(&R32(base, ADC_GC), MASK(ADC_GC_CAL), 0) &&
           (R32(base, ADC_GS) & MASK(ADC_GS_CALF)) == 0;
}

void sensors_start(void)
{
    bool first = start(BASE_ADC1), second = start(BASE_ADC2);
    is_calibrated = first && second;
}

static void begin(uint32_t base, uint32_t channel)
{
    R32(base, ADC_HC0) = BITS(ADC_HC0_ADCH, channel);
}

static uint16_t end(uint32_t base, bool *is_good)
{
    int turns = 0;
    while ((R32(base, ADC_HS) & MASK(ADC_HS_COCO0)) == 0) {
        if (++turns == WAIT_MAX) {
            *is_good = false;
            return 0;
        }
    }
    return (uint16_t)(R32(base, ADC_R0) & MASK(ADC_R0_CDATA));
}

sensors_sample sensors_read(void)
{
    static const uint8_t force[CRN_PORT_TOOL_MAX] = {FORCE_1, FORCE_2, FORCE_3};
    static const uint8_t current[CRN_PORT_TOOL_MAX] = {CURRENT_1, CURRENT_2, CURRENT_3};
    sensors_sample sample = {.is_good = is_calibrated};
    if (!sample.is_good) return sample;
    begin(BASE_ADC2, SUPPLY);
    for (uint32_t k = 0; k < CRN_PORT_TOOL_MAX && sample.is_good; k++) {
        begin(BASE_ADC1, force[k]);
        sample.force_raw[k] = end(BASE_ADC1, &sample.is_good);
        begin(BASE_ADC1, current[k]);
        sample.current_raw[k] = end(BASE_ADC1, &sample.is_good);
    }
    if (sample.is_good) {
        begin(BASE_ADC1, PRESSURE);
        sample.inflator_raw = end(BASE_ADC1, &sample.is_good);
        sample.supply_raw = end(BASE_ADC2, &sample.is_good);
    }
    begin(BASE_ADC1, NO_CHANNEL);
    begin(BASE_ADC2, NO_CHANNEL);
    return sample;
}
