/* Crossbar, decoders ENC1 to 4, and the quadrature counters of the timers TMR1 and TMR3. An edge at a pin
 * reaches a counter through IOMUXC, (for decoders) the crossbar, and the input filter: a level counts when it
 * has been constant for (FILT_CNT + 3) samples of FILT_PER clocks. Behaviour: reference manual, chapters
 * XBAR, ENC and TMR, from memory. */
#include "hil_tests/rt1062/chip.h"

enum {
    CROSSBAR_ENC1_A = 66, /* an output; B is the next, and each further decoder is 5 higher */
    CROSSBAR_PER_DECODER = 5,
    QUADRATURE = 4,
    GATE_ENC1 = 12, /* of CCGR4 */
    FILTER_MORE_SAMPLES = 3,
};

/* Inputs of the crossbar at which the pins of the decoders arrive: IOMUX_XBAR_INOUT06 is input 6, and so on.
 */
static const uint8_t pin_inputs[RT_DECODERS][2] = {{6, 7}, {8, 9}, {22, 23}, {14, 15}};

/* --- crossbar --- */
uint32_t rt_crossbar_read(rt_chip *chip, uint32_t offset)
{
    if (offset / 2 < RT_CROSSBAR_OUTPUTS / 2) return chip->crossbar.select[offset / 2];
    rt_unmodelled(chip, "XBARA1", offset, false);
    return 0;
}

void rt_crossbar_write(rt_chip *chip, uint32_t offset, uint32_t value)
{
    if (offset / 2 < RT_CROSSBAR_OUTPUTS / 2) {
        chip->crossbar.select[offset / 2] = (uint16_t)value;
        rt_pwm_fault(chip);
    } else {
        rt_unmodelled(chip, "XBARA1", offset, true);
    }
}

int rt_crossbar_input(const rt_chip *chip, uint32_t output)
{
    return chip->crossbar.select[output / 2] >> (output % 2 * 8) & 0x7f;
}

/* --- filter and quadrature --- */
static uint64_t filter_instants(rt_chip *chip, uint16_t filter)
{
    uint32_t period = RT_FIELD(filter, ENC_FILT_FILT_PER), samples = RT_FIELD(filter, ENC_FILT_FILT_CNT);
    if (period == 0) return 0;
    double clocks = (samples + FILTER_MORE_SAMPLES) * (double)period;
    return rt_mutant_time(chip, RT_TIME_FILTER,
                          (uint64_t)(clocks / rt_clock_ipg_Hz(chip) * RT_INSTANTS_PER_s));
}

/* The instant at which the filter lets the waiting level pass; RT_NEVER if none waits. */
static uint64_t passes_at(const rt_filtered *input, uint64_t delay)
{
    return input->next != input->level ? input->since + delay : RT_NEVER;
}

/* The sign of a step of the phases (A, B): A leads B when the count rises. */
static int32_t step_of(bool a, bool b, bool is_a)
{
    return (a != b) == is_a ? 1 : -1;
}

/* The times of the two phases' filters. */
typedef struct delays {
    uint64_t a, b;
} delays;

static void settle(rt_quadrature *inputs, uint64_t now, delays delay)
{
    for (;;) {
        uint64_t a = passes_at(&inputs->a, delay.a), b = passes_at(&inputs->b, delay.b);
        uint64_t first = a < b ? a : b;
        if (first > now) return;
        if (a == b) {
            inputs->a.level = inputs->a.next;
            inputs->b.level = inputs->b.next;
            inputs->illegal++;
            continue;
        }
        rt_filtered *input = a < b ? &inputs->a : &inputs->b;
        input->level = input->next;
        inputs->steps += step_of(inputs->a.level, inputs->b.level, a < b);
    }
}

static void edge(rt_quadrature *inputs, bool is_b, bool level, uint64_t instant, delays delay)
{
    rt_filtered *input = is_b ? &inputs->b : &inputs->a;
    settle(inputs, instant, delay);
    if (level == input->next) return;
    input->next = level;
    input->since = instant;
}

/* Takes the steps out of the filter. */
static int32_t take(rt_chip *chip, rt_quadrature *inputs, delays delay)
{
    settle(inputs, chip->now, delay);
    int32_t steps = inputs->steps;
    inputs->steps = 0;
    return steps;
}

static delays of_decoder(rt_chip *chip, const rt_decoder *decoder)
{
    uint64_t both = filter_instants(chip, decoder->filter);
    return (delays){both, both};
}

/* Each channel of a timer filters its own input. */
static delays of_counter(rt_chip *chip, const rt_counter *counter)
{
    return (delays){filter_instants(chip, counter->filter), filter_instants(chip, counter->filter_b)};
}

static bool is_connected(rt_chip *chip, uint32_t decoder, bool is_b)
{
    uint32_t output = CROSSBAR_ENC1_A + CROSSBAR_PER_DECODER * decoder + (is_b ? 1 : 0);
    return rt_crossbar_input(chip, output) == pin_inputs[decoder][is_b] &&
           rt_gate_is_open(chip, 4, GATE_ENC1 + decoder);
}

void rt_encoders_edge(rt_chip *chip, uint32_t encoder, bool is_b, bool level, uint64_t instant)
{
    if (encoder < RT_DECODERS) {
        rt_decoder *decoder = &chip->decoders[encoder];
        if (is_connected(chip, encoder, is_b))
            edge(&decoder->inputs, is_b, level, instant, of_decoder(chip, decoder));
        return;
    }
    rt_counter *counter = &chip->counters[encoder - RT_DECODERS];
    edge(&counter->inputs, is_b, level, instant, of_counter(chip, counter));
}

/* --- decoders --- */
static void update_decoder(rt_chip *chip, rt_decoder *decoder)
{
    decoder->position += (uint32_t)take(chip, &decoder->inputs, of_decoder(chip, decoder));
    if (decoder->inputs.illegal != 0) decoder->control2 |= (uint16_t)MASK(ENC_CTRL2_SABIRQ);
    decoder->inputs.illegal = 0;
}

uint32_t rt_decoder_read(rt_chip *chip, uint32_t number, uint32_t offset)
{
    rt_decoder *decoder = &chip->decoders[number];
    update_decoder(chip, decoder);
    switch (offset) {
    case ENC_LPOS: /* holds the high half of the same moment */
        decoder->held_high = (uint16_t)(decoder->position >> 16);
        return decoder->position & 0xffffu;
    case ENC_UPOSH:
        return decoder->held_high;
    case ENC_CTRL:
        return decoder->control;
    case ENC_CTRL2:
        return decoder->control2;
    case ENC_FILT:
        return decoder->filter;
    default:
        rt_unmodelled(chip, "ENC", offset, false);
        return 0;
    }
}

void rt_decoder_write(rt_chip *chip, uint32_t number, uint32_t offset, uint32_t value)
{
    rt_decoder *decoder = &chip->decoders[number];
    update_decoder(chip, decoder);
    switch (offset) {
    case ENC_CTRL:
        if (value & MASK(ENC_CTRL_SWIP))
            decoder->position = (uint32_t)decoder->init_high << 16 | decoder->init_low;
        decoder->control = (uint16_t)(value & ~MASK(ENC_CTRL_SWIP));
        break;
    case ENC_FILT:
        decoder->filter = (uint16_t)value;
        break;
    case ENC_UINIT:
        decoder->init_high = (uint16_t)value;
        break;
    case ENC_LINIT:
        decoder->init_low = (uint16_t)value;
        break;
    case ENC_CTRL2: /* SABIRQ is cleared by a one */
        decoder->control2 = (uint16_t)((decoder->control2 & MASK(ENC_CTRL2_SABIRQ) & ~value) |
                                       (value & ~MASK(ENC_CTRL2_SABIRQ)));
        break;
    default:
        rt_unmodelled(chip, "ENC", offset, true);
    }
}

/* --- timers --- */
/* Channel (of the module) on which each counter counts: TMR3 0 and 2, TMR1 0. */
static const struct {
    uint32_t module, channel;
} places[RT_TIMER_CHANNELS] = {{3, 0}, {3, 2}, {1, 0}};

static rt_counter *counter_of(rt_chip *chip, uint32_t module, uint32_t channel, bool *is_second)
{
    for (uint32_t i = 0; i < RT_TIMER_CHANNELS; i++) {
        *is_second = channel == places[i].channel + 1;
        if (places[i].module == module && (places[i].channel == channel || *is_second))
            return &chip->counters[i];
    }
    return NULL;
}

static bool counts(const rt_counter *counter, uint32_t channel)
{
    return counter->is_enabled && RT_FIELD(counter->control, TMR_CTRL0_CM) == QUADRATURE &&
           RT_FIELD(counter->control, TMR_CTRL0_PCS) == channel &&
           RT_FIELD(counter->control, TMR_CTRL0_SCS) == channel + 1;
}

static void update_counter(rt_chip *chip, rt_counter *counter, uint32_t channel)
{
    int32_t steps = take(chip, &counter->inputs, of_counter(chip, counter));
    if (counts(counter, channel)) counter->count = (uint16_t)(counter->count + (uint32_t)steps);
}

static uint32_t enabled_of(const rt_chip *chip, uint32_t module)
{
    uint32_t bits = 0;
    for (uint32_t i = 0; i < RT_TIMER_CHANNELS; i++)
        if (places[i].module == module && chip->counters[i].is_enabled) bits |= 1u << places[i].channel;
    return bits;
}

uint32_t rt_timer_read(rt_chip *chip, uint32_t module, uint32_t offset)
{
    if (offset == TMR_ENBL) return enabled_of(chip, module);
    uint32_t channel = offset / TMR_STRIDE_CTRL;
    bool is_second;
    rt_counter *counter = counter_of(chip, module, channel, &is_second);
    uint32_t which = offset % TMR_STRIDE_CTRL;
    if (counter != NULL && which == TMR_FILT0) return is_second ? counter->filter_b : counter->filter;
    if (counter != NULL && !is_second && which == TMR_CTRL0) return counter->control;
    if (counter == NULL || is_second || which != TMR_CNTR0) {
        rt_unmodelled(chip, "TMR", offset, false);
        return 0;
    }
    update_counter(chip, counter, channel);
    return counter->count;
}

void rt_timer_write(rt_chip *chip, uint32_t module, uint32_t offset, uint32_t value)
{
    if (offset == TMR_ENBL) {
        for (uint32_t i = 0; i < RT_TIMER_CHANNELS; i++) {
            if (places[i].module != module) continue;
            update_counter(chip, &chip->counters[i], places[i].channel);
            chip->counters[i].is_enabled = (value >> places[i].channel & 1u) != 0;
        }
        return;
    }
    uint32_t channel = offset / TMR_STRIDE_CTRL, which = offset % TMR_STRIDE_CTRL;
    bool is_second;
    rt_counter *counter = counter_of(chip, module, channel, &is_second);
    if (counter == NULL) {
        rt_unmodelled(chip, "TMR", offset, true);
        return;
    }
    update_counter(chip, counter, is_second ? channel - 1 : channel);
    if (which == TMR_FILT0 && is_second) {
        counter->filter_b = (uint16_t)value;
    } else if (which == TMR_FILT0) {
        counter->filter = (uint16_t)value;
    } else if (which == TMR_CNTR0 && !is_second) {
        counter->count = (uint16_t)value;
    } else if (which == TMR_CTRL0 && !is_second) {
        counter->control = (uint16_t)value;
    } else {
        rt_unmodelled(chip, "TMR", offset, true);
    }
}

static void keep_levels(rt_quadrature *inputs)
{
    inputs->steps = 0;
    inputs->illegal = 0;
}

void rt_encoders_reset(rt_chip *chip)
{
    chip->crossbar = (rt_crossbar){0};
    for (uint32_t i = 0; i < RT_DECODERS; i++) {
        rt_quadrature inputs = chip->decoders[i].inputs;
        keep_levels(&inputs);
        chip->decoders[i] = (rt_decoder){.inputs = inputs};
    }
    for (uint32_t i = 0; i < RT_TIMER_CHANNELS; i++) {
        rt_quadrature inputs = chip->counters[i].inputs;
        keep_levels(&inputs);
        chip->counters[i] = (rt_counter){.inputs = inputs};
    }
}
