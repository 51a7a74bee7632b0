/* This port has never run on hardware. Seven quadrature encoders, of which hardware counts every edge:
 *
 *   decoders ENC1 to ENC4 (32 bits, detect an illegal step) by the crossbar: translation 1, 2, 3, rotation 1
 *   timers TMR3 and TMR1 (16 bits, widened here, detect none): rotation 2 and 3, syringe
 *
 * Between two ticks a timer must not count more than 32,767 steps. The limit of 32,767 steps per tick
 * corresponds to 32 million steps a second, more than any encoder gives. */
#include "firmware/port/imxrt1062/board.h"
#include "firmware/port/imxrt1062/imxrt1062_registers.h"

enum {
    DECODERS = 4,
    TIMERS = 3,
    /* the crossbar's outputs: phases A and B of ENC1; each further decoder is 5 higher */
    CROSSBAR_ENC1_A = 66,
    CROSSBAR_PER_DECODER = 5,
    FILTER_SAMPLES = 2, /* + 3 equal samples */
    FILTER_CLOCKS = 6,  /* clocks between the samples: pulses under 200 ns are noise */
    COUNT_QUADRATURE = 4,
};

static const uint32_t decoder_base[DECODERS] = {BASE_ENC1, BASE_ENC2, BASE_ENC3, BASE_ENC4};
/* Lists the crossbar's two inputs for the phases A and B of each encoder, as pins.c has connected them. */
static const uint8_t decoder_inputs[DECODERS][2] = {{6, 7}, {8, 9}, {22, 23}, {14, 15}};

static const struct timer_channel {
    uint32_t base, channel; /* it counts on the inputs `channel` and `channel` + 1 */
} timer_channels[TIMERS] = {{BASE_TMR3, 0}, {BASE_TMR3, 2}, {BASE_TMR1, 0}};

static struct {
    uint16_t last;
    uint32_t counts;
} wide[TIMERS];

/* Lists the decoder (0 .. 3) or timer (4 .. 6) of each encoder. */
static const uint8_t source[ENCODERS_COUNT] = {0, 3, 1, 4, 2, 5, 6};

static void connect(uint32_t output, uint8_t input)
{
    volatile uint16_t *select = &R16(BASE_XBARA1, XBARA_SEL0 + (output & ~1u));
    uint32_t shift = output % 2 * 8;
    *select = (uint16_t)((*select & ~(0x7fu << shift)) | (uint32_t)input << shift);
}

static void start_decoder(uint32_t number)
{
    uint32_t base = decoder_base[number];
    uint32_t output = CROSSBAR_ENC1_A + number * CROSSBAR_PER_DECODER;
    connect(output, decoder_inputs[number][0]);
    connect(output + 1, decoder_inputs[number][1]);
    R16(base, ENC_FILT) =
        (uint16_t)(BITS(ENC_FILT_FILT_CNT, FILTER_SAMPLES) | BITS(ENC_FILT_FILT_PER, FILTER_CLOCKS));
    R16(base, ENC_UINIT) = 0;
    R16(base, ENC_LINIT) = 0;
    R16(base, ENC_CTRL2) = (uint16_t)MASK(ENC_CTRL2_SABIRQ);
    R16(base, ENC_CTRL) = (uint16_t)MASK(ENC_CTRL_SWIP);
}

static void start_timer(const struct timer_channel *timer)
{
    for (uint32_t i = 0; i < 2; i++) {
        R16(timer->base, TMR_FILT0 + (timer->channel + i) * TMR_STRIDE_CTRL) =
            (uint16_t)(BITS(TMR_FILT0_FILT_CNT, FILTER_SAMPLES) | BITS(TMR_FILT0_FILT_PER, FILTER_CLOCKS));
    }
    R16(timer->base, TMR_CNTR0 + timer->channel * TMR_STRIDE_CTRL) = 0;
    R16(timer->base, TMR_CTRL0 + timer->channel * TMR_STRIDE_CTRL) =
        (uint16_t)(BITS(TMR_CTRL0_CM, COUNT_QUADRATURE) | BITS(TMR_CTRL0_PCS, timer->channel) |
                   BITS(TMR_CTRL0_SCS, timer->channel + 1));
    R16(timer->base, TMR_ENBL) |= (uint16_t)(1u << timer->channel);
}

void encoders_start(void)
{
    R32(BASE_IOMUXC_GPR, IOMUXC_GPR_GPR6) &=
        ~(MASK(IOMUXC_GPR_GPR6_QTIMER1_TRM0_INPUT_SEL) | MASK(IOMUXC_GPR_GPR6_QTIMER1_TRM1_INPUT_SEL) |
          MASK(IOMUXC_GPR_GPR6_QTIMER3_TRM0_INPUT_SEL) | MASK(IOMUXC_GPR_GPR6_QTIMER3_TRM1_INPUT_SEL) |
          MASK(IOMUXC_GPR_GPR6_QTIMER3_TRM2_INPUT_SEL) | MASK(IOMUXC_GPR_GPR6_QTIMER3_TRM3_INPUT_SEL));
    for (uint32_t i = 0; i < DECODERS; i++) start_decoder(i);
    for (uint32_t i = 0; i < TIMERS; i++) start_timer(&timer_channels[i]);
}

static int32_t signed_of(uint32_t word)
{
    return word <= INT32_MAX ? (int32_t)word : -1 - (int32_t)(UINT32_MAX - word);
}

/* When the code reads the low half of the counter, the hardware stores (latches) the high half of the same
 * moment. */
static encoders_reading read_decoder(uint32_t base)
{
    uint32_t low = R16(base, ENC_LPOS), high = R16(base, ENC_UPOSH);
    bool is_illegal = (R16(base, ENC_CTRL2) & MASK(ENC_CTRL2_SABIRQ)) != 0;
    if (is_illegal) R16(base, ENC_CTRL2) = (uint16_t)MASK(ENC_CTRL2_SABIRQ);
    return (encoders_reading){signed_of(high << 16 | low),
                              (uint8_t)(is_illegal ? CRN_PORT_SENSOR_ERROR : CRN_PORT_SENSOR_OK)};
}

encoders_reading encoders_read(uint32_t which)
{
    uint32_t number = source[which];
    if (number < DECODERS) return read_decoder(decoder_base[number]);
    number -= DECODERS;
    const struct timer_channel *timer = &timer_channels[number];
    uint16_t now = R16(timer->base, TMR_CNTR0 + timer->channel * TMR_STRIDE_CTRL);
    uint16_t step = (uint16_t)(now - wide[number].last);
    wide[number].last = now;
    wide[number].counts += step < 0x8000u ? step : step - 0x10000u;
    return (encoders_reading){signed_of(wide[number].counts), CRN_PORT_SENSOR_OK};
}
