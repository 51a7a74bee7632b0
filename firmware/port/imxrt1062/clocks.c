/* This port has never run on hardware. This file controls the processor's clock, the timer edge of every
 * millisecond, the time and the watchdog, and reads the chip's serial number.
 *
 *   crystal 24 MHz -> ARM PLL 1,200 MHz / 2 -> processor 600 MHz / 4 -> peripherals 150 MHz
 *   crystal 24 MHz -> PIT (the 1 ms edge), GPT1 (microseconds), console */
#include "firmware/port/imxrt1062/board.h"
#include "firmware/port/imxrt1062/cortex_m7.h"
#include "firmware/port/imxrt1062/imxrt1062_registers.h"

enum {
    INTERRUPT_PIT = 122,
    CORE_VOLTAGE_TARGET = 18, /* 0.8 V + 18 x 25 mV = 1.25 V: required for 600 MHz */
    PLL_MULTIPLIER = 100,     /* x 24 MHz / 2 */
    PRE_PERIPHERAL_ARM_PLL = 3,
    GPT_CLOCK_CRYSTAL = 2, /* the peripheral clock, which take_clocks has connected to the crystal */
    /* + 1: 2 s. The longest request is a scene's validation, which takes under 0.5 s */
    WATCHDOG_HALF_SECONDS = 3,
    ALL_GATES_OPEN = -1,
};

static volatile uint32_t edges; /* the interrupt increments it */
static uint32_t edges_done;

static void open_gates(void)
{
    for (uint32_t gate = CCM_CCGR0; gate <= CCM_CCGR7; gate += 4)
        R32(BASE_CCM, gate) = (uint32_t)ALL_GATES_OPEN;
}

/* The processor runs on the crystal's clock while the code sets the processor's PLL. */
static bool take_clocks(void)
{
    volatile uint32_t *pll = &R32(BASE_CCM_ANALOG, CCM_ANALOG_PLL_ARM), *bus = &R32(BASE_CCM, CCM_CBCDR);
    volatile uint32_t *busy = &R32(BASE_CCM, CCM_CDHIPR);
    SET_FIELD(R32(BASE_DCDC, DCDC_REG3), DCDC_REG3_TRG, CORE_VOLTAGE_TARGET);
    bool is_good =
        board_wait(&R32(BASE_DCDC, DCDC_REG0), MASK(DCDC_REG0_STS_DC_OK), MASK(DCDC_REG0_STS_DC_OK));
    SET_FIELD(R32(BASE_CCM, CCM_CBCMR), CCM_CBCMR_PERIPH_CLK2_SEL, 1);
    SET_FIELD(*bus, CCM_CBCDR_PERIPH_CLK2_PODF, 0);
    SET_FIELD(*bus, CCM_CBCDR_PERIPH_CLK_SEL, 1);
    is_good = board_wait(busy, MASK(CCM_CDHIPR_PERIPH_CLK_SEL_BUSY), 0) && is_good;

    *pll = BITS(CCM_ANALOG_PLL_ARM_BYPASS, 1) | BITS(CCM_ANALOG_PLL_ARM_ENABLE, 1) |
           BITS(CCM_ANALOG_PLL_ARM_DIV_SELECT, PLL_MULTIPLIER);
    is_good = board_wait(pll, MASK(CCM_ANALOG_PLL_ARM_LOCK), MASK(CCM_ANALOG_PLL_ARM_LOCK)) && is_good;
    if (!is_good) return false;
    SET_FIELD(*pll, CCM_ANALOG_PLL_ARM_BYPASS, 0);

    SET_FIELD(R32(BASE_CCM, CCM_CACRR), CCM_CACRR_ARM_PODF, 1); /* / 2 */
    is_good = board_wait(busy, MASK(CCM_CDHIPR_ARM_PODF_BUSY), 0);
    SET_FIELD(*bus, CCM_CBCDR_AHB_PODF, 0); /* / 1 */
    is_good = board_wait(busy, MASK(CCM_CDHIPR_AHB_PODF_BUSY), 0) && is_good;
    SET_FIELD(*bus, CCM_CBCDR_IPG_PODF, 3); /* / 4 */
    SET_FIELD(R32(BASE_CCM, CCM_CBCMR), CCM_CBCMR_PRE_PERIPH_CLK_SEL, PRE_PERIPHERAL_ARM_PLL);
    SET_FIELD(*bus, CCM_CBCDR_PERIPH_CLK_SEL, 0);
    return board_wait(busy, MASK(CCM_CDHIPR_PERIPH_CLK_SEL_BUSY), 0) && is_good;
}

static void start_watchdog(void)
{
    /* The code in the ROM may have left the chip's second watchdog (RTWDOG) on. The start-up code unlocks the
     * chip's second watchdog and turns it off within 255 clocks, before the watchdog locks again. */
    if (R32(BASE_RTWDOG, RTWDOG_CS) & MASK(RTWDOG_CS_EN)) {
        R32(BASE_RTWDOG, RTWDOG_CNT) = 0xd928c520u;
        R32(BASE_RTWDOG, RTWDOG_TOVAL) = 0xffffu;
        R32(BASE_RTWDOG, RTWDOG_CS) =
            (R32(BASE_RTWDOG, RTWDOG_CS) & ~MASK(RTWDOG_CS_EN)) | MASK(RTWDOG_CS_UPDATE);
    }
    R16(BASE_WDOG1, WDOG_WMCR) = 0; /* no power-down after 16 s */
    R16(BASE_WDOG1, WDOG_WCR) =
        (uint16_t)(BITS(WDOG_WCR_WT, WATCHDOG_HALF_SECONDS) | BITS(WDOG_WCR_WDA, 1) | BITS(WDOG_WCR_SRS, 1) |
                   BITS(WDOG_WCR_WDE, 1) | BITS(WDOG_WCR_WDBG, 1));
}

static void start_time(void)
{
    R32(BASE_GPT1, GPT_CR) = MASK(GPT_CR_SWR);
    (void)board_wait(&R32(BASE_GPT1, GPT_CR), MASK(GPT_CR_SWR), 0);
    R32(BASE_GPT1, GPT_PR) = BITS(GPT_PR_PRESCALER, BOARD_CRYSTAL_HZ / 1000000 - 1);
    R32(BASE_GPT1, GPT_CR) = BITS(GPT_CR_CLKSRC, GPT_CLOCK_CRYSTAL) | BITS(GPT_CR_FRR, 1) |
                             BITS(GPT_CR_ENMOD, 1) | BITS(GPT_CR_WAITEN, 1);
    R32(BASE_GPT1, GPT_CR) |= MASK(GPT_CR_EN);
    CORE_DEMCR |= CORE_DEMCR_TRACE;
    CORE_DWT_LAR = core_dwt_key;
    CORE_DWT_CYCCNT = 0;
    CORE_DWT_CTRL |= CORE_DWT_CYCLES;
}

bool clocks_start(void)
{
    open_gates();
    SET_FIELD(R32(BASE_CCM, CCM_CSCMR1), CCM_CSCMR1_PERCLK_CLK_SEL, 1);
    SET_FIELD(R32(BASE_CCM, CCM_CSCMR1), CCM_CSCMR1_PERCLK_PODF, 0);
    SET_FIELD(R32(BASE_CCM, CCM_CSCDR1), CCM_CSCDR1_UART_CLK_SEL, 1);
    SET_FIELD(R32(BASE_CCM, CCM_CSCDR1), CCM_CSCDR1_UART_CLK_PODF, 0);
    bool is_good = take_clocks();
    start_time();
    start_watchdog();
    return is_good;
}

void clocks_start_tick(void)
{
    R32(BASE_PIT, PIT_MCR) = 0; /* on, also in debug: a halted processor is late, and detects that */
    R32(BASE_PIT, PIT_LDVAL_0) = BOARD_CRYSTAL_HZ / 1000 - 1;
    R32(BASE_PIT, PIT_TFLG_0) = MASK(PIT_TFLG_0_TIF);
    R32(BASE_PIT, PIT_TCTRL_0) = MASK(PIT_TCTRL_0_TIE) | MASK(PIT_TCTRL_0_TEN);
    CORE_NVIC_ENABLE(INTERRUPT_PIT) = 1u << INTERRUPT_PIT % 32;
    __asm__ volatile("cpsie i" ::: "memory");
}

void clocks_tick(void)
{
    R32(BASE_PIT, PIT_TFLG_0) = MASK(PIT_TFLG_0_TIF);
    edges++;
    __asm__ volatile("dsb" ::: "memory"); /* the flag is cleared before the interrupt ends */
}

uint32_t clocks_edges(void)
{
    return edges;
}

uint32_t clocks_edges_due(void)
{
    return edges - edges_done;
}

void clocks_edge_done(void)
{
    edges_done++;
}

uint32_t clocks_now_us(void *context)
{
    (void)context;
    return R32(BASE_GPT1, GPT_CNT);
}

uint32_t clocks_cycles(void)
{
    return CORE_DWT_CYCCNT;
}

void clocks_feed_watchdog(void)
{
    R16(BASE_WDOG1, WDOG_WSR) = 0x5555;
    R16(BASE_WDOG1, WDOG_WSR) = 0xaaaa;
}

bool clocks_was_watchdog(void)
{
    return (R32(BASE_SRC, SRC_SRSR) & (MASK(SRC_SRSR_WDOG_RST_B) | MASK(SRC_SRSR_WDOG3_RST_B))) != 0;
}

/* Converts the chip's own 64-bit number to text. */
void clocks_serial(char serial[BOARD_SERIAL_BYTES + 1])
{
    static const char head[] = "RT1062-";
    const uint32_t words[2] = {R32(BASE_OCOTP, OCOTP_CFG1), R32(BASE_OCOTP, OCOTP_CFG0)};
    uint32_t at = 0;
    for (; head[at] != '\0'; at++) serial[at] = head[at];
    for (uint32_t i = 0; i < 16; i++)
        serial[at++] = "0123456789ABCDEF"[words[i / 8] >> (28 - 4 * (i % 8)) & 15u];
    serial[at] = '\0';
}
