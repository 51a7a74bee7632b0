/* Clocks: the CCM (muxes, dividers, gates), its analog part (PLLs) and the core's voltage (DCDC).
 *
 * The state at the start is the one that the boot ROM leaves, as we assume it: PLL2 (528 MHz, PFD2 at 396
 * MHz) and PLL3 run, the core runs at 396 MHz, and only the gates of what the ROM itself needs are open. Lock
 * times (in periods of the crystal) and the voltage at which 600 MHz are allowed are those of the data sheet
 * IMXRT1060CEC, from memory. Registers and fields: `make registers`; the meaning of mux values: the reference
 * manual's clock tree, from memory. */
#include "hil_tests/rt1062/chip.h"
#include <math.h>

enum {
    ARM_LOCK_periods = 2250,
    SYSTEM_LOCK_periods = 11250,
    USB_LOCK_periods = 383,
    HANDSHAKE_ns = 1000, /* some periods of the slower clock */
    DCDC_SETTLE_us = 50,
    VOLTAGE_FOR_600_MHz = 18, /* 1.25 V */
    VOLTAGE_RESET = 12,       /* 1.1 V */
};
static const double crystal_Hz = 24e6, rom_core_Hz = 396e6, core_max_Hz = 600e6, core_low_max_Hz = 528e6,
                    ipg_max_Hz = 150e6, perclk_max_Hz = 75e6, flexspi_max_Hz = 332e6;

static uint32_t ccm(const rt_chip *chip, uint32_t offset)
{
    return chip->clocks.ccm[offset / 4];
}

static uint32_t analog(const rt_chip *chip, uint32_t offset)
{
    return chip->clocks.analog[offset / 4];
}

static bool is_locked(const rt_chip *chip, const rt_pll *pll, uint32_t periods)
{
    rt_duration which = periods == ARM_LOCK_periods      ? RT_TIME_ARM_LOCK
                        : periods == SYSTEM_LOCK_periods ? RT_TIME_SYSTEM_LOCK
                                                         : RT_TIME_USB_LOCK;
    uint64_t time = (uint64_t)(periods / crystal_Hz * RT_INSTANTS_PER_s);
    return pll->runs && chip->now - pll->since >= rt_mutant_time(chip, which, time);
}

/* --- frequencies --- */
static double arm_pll_Hz(const rt_chip *chip)
{
    uint32_t word = analog(chip, CCM_ANALOG_PLL_ARM);
    if (RT_FIELD(word, CCM_ANALOG_PLL_ARM_ENABLE) == 0) return 0;
    if (RT_FIELD(word, CCM_ANALOG_PLL_ARM_BYPASS) != 0) return crystal_Hz;
    if (!is_locked(chip, &chip->clocks.arm, ARM_LOCK_periods)) return 0;
    return crystal_Hz * RT_FIELD(word, CCM_ANALOG_PLL_ARM_DIV_SELECT) / 2;
}

static double system_pfd2_Hz(const rt_chip *chip)
{
    uint32_t pll = analog(chip, CCM_ANALOG_PLL_SYS), pfd = analog(chip, CCM_ANALOG_PFD_528);
    uint32_t share = RT_FIELD(pfd, CCM_ANALOG_PFD_528_PFD2_FRAC);
    bool runs = RT_FIELD(pll, CCM_ANALOG_PLL_SYS_ENABLE) != 0 &&
                RT_FIELD(pll, CCM_ANALOG_PLL_SYS_BYPASS) == 0 &&
                is_locked(chip, &chip->clocks.system, SYSTEM_LOCK_periods) &&
                RT_FIELD(pfd, CCM_ANALOG_PFD_528_PFD2_CLKGATE) == 0 && share >= 12 && share <= 35;
    return runs ? 528e6 * 18 / share : 0;
}

/* The processor's clock with the muxes and dividers in force; 0: their source does not run. */
static double core_of(const rt_chip *chip)
{
    const rt_clocks *clocks = &chip->clocks;
    double source;
    if (clocks->periph_from_clk2) {
        uint32_t select = RT_FIELD(ccm(chip, CCM_CBCMR), CCM_CBCMR_PERIPH_CLK2_SEL);
        source = select == 1 ? crystal_Hz : 0;
        source /= RT_FIELD(ccm(chip, CCM_CBCDR), CCM_CBCDR_PERIPH_CLK2_PODF) + 1;
    } else {
        uint32_t select = RT_FIELD(ccm(chip, CCM_CBCMR), CCM_CBCMR_PRE_PERIPH_CLK_SEL);
        source = select == 3   ? arm_pll_Hz(chip) / clocks->arm_divider
                 : select == 1 ? system_pfd2_Hz(chip)
                               : 0;
    }
    return source / clocks->ahb_divider;
}

double rt_clock_ipg_Hz(rt_chip *chip)
{
    rt_clocks_update(chip);
    return chip->clocks.core_Hz / (RT_FIELD(ccm(chip, CCM_CBCDR), CCM_CBCDR_IPG_PODF) + 1);
}

double rt_clock_perclk_Hz(rt_chip *chip)
{
    uint32_t word = ccm(chip, CCM_CSCMR1);
    double source = RT_FIELD(word, CCM_CSCMR1_PERCLK_CLK_SEL) == 1 ? crystal_Hz : rt_clock_ipg_Hz(chip);
    double clock = source / (RT_FIELD(word, CCM_CSCMR1_PERCLK_PODF) + 1);
    if (clock > perclk_max_Hz) rt_find(chip, "PERCLK runs at %.1f MHz; at most 75", clock * 1e-6);
    return clock;
}

double rt_clock_uart_Hz(rt_chip *chip)
{
    uint32_t word = ccm(chip, CCM_CSCDR1);
    bool is_crystal = RT_FIELD(word, CCM_CSCDR1_UART_CLK_SEL) == 1;
    double source = is_crystal ? crystal_Hz : is_locked(chip, &chip->clocks.usb, USB_LOCK_periods) ? 80e6 : 0;
    return source / (RT_FIELD(word, CCM_CSCDR1_UART_CLK_PODF) + 1);
}

double rt_clock_flexspi2_Hz(rt_chip *chip)
{
    uint32_t word = ccm(chip, CCM_CBCMR);
    double source = RT_FIELD(word, CCM_CBCMR_FLEXSPI2_CLK_SEL) == 0 ? system_pfd2_Hz(chip) : 0;
    double clock = source / (RT_FIELD(word, CCM_CBCMR_FLEXSPI2_PODF) + 1);
    if (clock > flexspi_max_Hz) rt_find(chip, "FlexSPI2 runs at %.1f MHz; at most 332", clock * 1e-6);
    return clock;
}

bool rt_clock_usb_runs(rt_chip *chip)
{
    uint32_t word = analog(chip, CCM_ANALOG_PLL_USB1);
    return is_locked(chip, &chip->clocks.usb, USB_LOCK_periods) &&
           RT_FIELD(word, CCM_ANALOG_PLL_USB1_BYPASS) == 0 &&
           RT_FIELD(word, CCM_ANALOG_PLL_USB1_ENABLE) != 0 &&
           RT_FIELD(word, CCM_ANALOG_PLL_USB1_EN_USB_CLKS) != 0 &&
           RT_FIELD(word, CCM_ANALOG_PLL_USB1_DIV_SELECT) == 0 &&
           RT_FIELD(analog(chip, PMU_REG_3P0), PMU_REG_3P0_ENABLE_LINREG) != 0;
}

bool rt_gate_is_open(rt_chip *chip, uint32_t number, uint32_t gate)
{
    return (ccm(chip, CCM_CCGR0 + 4 * number) >> (2 * gate) & 1u) != 0; /* 01: in run mode; 11: always */
}

/* --- handshakes --- */
static bool is_voltage_good(const rt_chip *chip)
{
    uint64_t time = rt_mutant_time(chip, RT_TIME_VOLTAGE, DCDC_SETTLE_us * RT_INSTANTS_PER_us);
    return chip->now - chip->clocks.dcdc_since >= time;
}

/* The processor's clock takes a new value only if its source runs and the voltage allows it; otherwise the
 * handshake does not end. */
static const char *refusal(const rt_chip *chip, double wanted)
{
    if (wanted == 0) return "the source of the processor's clock does not run";
    if (wanted > core_max_Hz) return "the processor's clock would be over 600 MHz";
    uint32_t voltage = RT_FIELD(chip->clocks.dcdc[3], DCDC_REG3_TRG);
    if (wanted > core_low_max_Hz && (voltage < VOLTAGE_FOR_600_MHz || !is_voltage_good(chip)))
        return "the core's voltage is too low for more than 528 MHz";
    return NULL;
}

static const char *set_core(rt_chip *chip)
{
    double wanted = core_of(chip);
    const char *reason = refusal(chip, wanted);
    if (reason != NULL) return reason;
    chip->clocks.core_Hz = wanted;
    chip->clocks.instants_per_cycle = (uint64_t)llround((double)RT_INSTANTS_PER_s / wanted);
    double ipg = wanted / (RT_FIELD(ccm(chip, CCM_CBCDR), CCM_CBCDR_IPG_PODF) + 1);
    if (ipg > ipg_max_Hz) rt_find(chip, "peripherals run at %.1f MHz; at most 150", ipg * 1e-6);
    return NULL;
}

static bool is_over(const rt_chip *chip, uint64_t *until)
{
    if (*until == 0 || chip->now < *until) return false;
    *until = 0;
    return true;
}

void rt_clocks_update(rt_chip *chip)
{
    rt_clocks *clocks = &chip->clocks, before = *clocks;
    bool changes = false;
    if (is_over(chip, &clocks->arm_busy_until)) {
        clocks->arm_divider = RT_FIELD(ccm(chip, CCM_CACRR), CCM_CACRR_ARM_PODF) + 1;
        changes = true;
    }
    if (is_over(chip, &clocks->ahb_busy_until)) {
        clocks->ahb_divider = RT_FIELD(ccm(chip, CCM_CBCDR), CCM_CBCDR_AHB_PODF) + 1;
        changes = true;
    }
    if (is_over(chip, &clocks->periph_busy_until)) {
        clocks->periph_from_clk2 = RT_FIELD(ccm(chip, CCM_CBCDR), CCM_CBCDR_PERIPH_CLK_SEL) != 0;
        changes = true;
    }
    if (changes && set_core(chip) != NULL) *clocks = before; /* the handshake goes on */
}

/* A clock above the processor's limit is treated as one that stands: what a processor then does is unknown.
 */
void rt_clocks_upset(rt_chip *chip)
{
    rt_clocks *clocks = &chip->clocks;
    uint32_t arm = analog(chip, CCM_ANALOG_PLL_ARM), divider = RT_FIELD(arm, CCM_ANALOG_PLL_ARM_DIV_SELECT);
    clocks->arm_divider = RT_FIELD(ccm(chip, CCM_CACRR), CCM_CACRR_ARM_PODF) + 1;
    clocks->ahb_divider = RT_FIELD(ccm(chip, CCM_CBCDR), CCM_CBCDR_AHB_PODF) + 1;
    clocks->periph_from_clk2 = RT_FIELD(ccm(chip, CCM_CBCDR), CCM_CBCDR_PERIPH_CLK_SEL) != 0;
    clocks->arm.runs = RT_FIELD(arm, CCM_ANALOG_PLL_ARM_POWERDOWN) == 0 && divider >= 54 && divider <= 108;
    clocks->usb.runs = RT_FIELD(analog(chip, CCM_ANALOG_PLL_USB1), CCM_ANALOG_PLL_USB1_POWER) != 0;
    clocks->system.runs = RT_FIELD(analog(chip, CCM_ANALOG_PLL_SYS), CCM_ANALOG_PLL_SYS_POWERDOWN) == 0;
    double wanted = core_of(chip);
    clocks->is_dead = wanted <= 0 || wanted > core_max_Hz;
    if (clocks->is_dead) return;
    clocks->core_Hz = wanted;
    clocks->instants_per_cycle = (uint64_t)llround((double)RT_INSTANTS_PER_s / wanted);
}

static uint32_t read_handshakes(rt_chip *chip)
{
    rt_clocks_update(chip);
    rt_clocks *clocks = &chip->clocks;
    uint32_t value = (clocks->arm_busy_until ? MASK(CCM_CDHIPR_ARM_PODF_BUSY) : 0) |
                     (clocks->ahb_busy_until ? MASK(CCM_CDHIPR_AHB_PODF_BUSY) : 0) |
                     (clocks->periph_busy_until ? MASK(CCM_CDHIPR_PERIPH_CLK_SEL_BUSY) : 0);
    if (value == 0) {
        rt_answered(chip, BASE_CCM + CCM_CDHIPR);
        return 0;
    }
    rt_clocks trial = *clocks;
    clocks->periph_from_clk2 = RT_FIELD(ccm(chip, CCM_CBCDR), CCM_CBCDR_PERIPH_CLK_SEL) != 0;
    clocks->arm_divider = RT_FIELD(ccm(chip, CCM_CACRR), CCM_CACRR_ARM_PODF) + 1;
    clocks->ahb_divider = RT_FIELD(ccm(chip, CCM_CBCDR), CCM_CBCDR_AHB_PODF) + 1;
    const char *reason = refusal(chip, core_of(chip));
    *clocks = trial;
    rt_pending(chip, BASE_CCM + CCM_CDHIPR, "CCM_CDHIPR: %s",
               reason ? reason : "the handshake takes its time");
    return value;
}

/* --- registers --- */
uint32_t rt_ccm_read(rt_chip *chip, uint32_t offset)
{
    if (offset == CCM_CDHIPR) return read_handshakes(chip);
    if (offset / 4 >= RT_CCM_WORDS) rt_unmodelled(chip, "CCM", offset, false);
    return offset / 4 < RT_CCM_WORDS ? ccm(chip, offset) : 0;
}

void rt_ccm_write(rt_chip *chip, uint32_t offset, uint32_t value)
{
    bool is_gate = offset >= CCM_CCGR0 && offset <= CCM_CCGR7;
    if (!is_gate && offset != CCM_CACRR && offset != CCM_CBCDR && offset != CCM_CBCMR &&
        offset != CCM_CSCMR1 && offset != CCM_CSCDR1) {
        rt_unmodelled(chip, "CCM", offset, true);
        return;
    }
    rt_clocks *clocks = &chip->clocks;
    uint32_t change = clocks->ccm[offset / 4] ^ value;
    uint64_t end =
        chip->now + rt_mutant_time(chip, RT_TIME_HANDSHAKE, HANDSHAKE_ns * RT_INSTANTS_PER_us / 1000);
    clocks->ccm[offset / 4] = value;
    if (offset == CCM_CACRR && (change & MASK(CCM_CACRR_ARM_PODF)) != 0) clocks->arm_busy_until = end;
    if (offset == CCM_CBCDR && (change & MASK(CCM_CBCDR_AHB_PODF)) != 0) clocks->ahb_busy_until = end;
    if (offset == CCM_CBCDR && (change & MASK(CCM_CBCDR_PERIPH_CLK_SEL)) != 0)
        clocks->periph_busy_until = end;
    bool changes_source =
        (change & (MASK(CCM_CBCMR_PRE_PERIPH_CLK_SEL) | MASK(CCM_CBCMR_PERIPH_CLK2_SEL))) != 0;
    if (offset == CCM_CBCMR && changes_source && set_core(chip) != NULL)
        rt_find(chip, "CCM_CBCMR: the processor's own clock is switched to a source that does not run");
}

static uint32_t lock(rt_chip *chip, uint32_t offset, const rt_pll *pll, uint32_t periods, const char *name)
{
    uint32_t value = analog(chip, offset) & ~MASK(CCM_ANALOG_PLL_ARM_LOCK);
    if (is_locked(chip, pll, periods)) {
        rt_answered(chip, BASE_CCM_ANALOG + offset);
        return value | MASK(CCM_ANALOG_PLL_ARM_LOCK);
    }
    rt_pending(chip, BASE_CCM_ANALOG + offset, "CCM_ANALOG_%s LOCK: %s", name,
               pll->runs ? "the PLL takes its time"
                         : "the PLL is powered down, or its divider is out of range");
    return value;
}

uint32_t rt_analog_read(rt_chip *chip, uint32_t offset)
{
    rt_clocks *clocks = &chip->clocks;
    if (offset == CCM_ANALOG_PLL_ARM) return lock(chip, offset, &clocks->arm, ARM_LOCK_periods, "PLL_ARM");
    if (offset == CCM_ANALOG_PLL_USB1) return lock(chip, offset, &clocks->usb, USB_LOCK_periods, "PLL_USB1");
    if (offset == CCM_ANALOG_PLL_SYS)
        return lock(chip, offset, &clocks->system, SYSTEM_LOCK_periods, "PLL_SYS");
    if (offset == PMU_REG_3P0 || offset == CCM_ANALOG_PFD_528) return analog(chip, offset);
    rt_unmodelled(chip, "CCM_ANALOG", offset, false);
    return 0;
}

static void set_pll(rt_chip *chip, rt_pll *pll, bool runs, bool changes)
{
    if (runs != pll->runs || changes) pll->since = chip->now;
    pll->runs = runs;
}

static void check_core(rt_chip *chip)
{
    rt_clocks_update(chip);
    if (core_of(chip) != chip->clocks.core_Hz)
        rt_find(chip, "CCM_ANALOG: the PLL of the processor's own clock is changed while it is used");
}

void rt_analog_write(rt_chip *chip, uint32_t offset, uint32_t value)
{
    rt_clocks *clocks = &chip->clocks;
    if (offset / 4 >= RT_ANALOG_WORDS) {
        rt_unmodelled(chip, "CCM_ANALOG", offset, true);
        return;
    }
    uint32_t change = clocks->analog[offset / 4] ^ value;
    clocks->analog[offset / 4] = value;
    switch (offset) {
    case CCM_ANALOG_PLL_ARM: {
        uint32_t divider = RT_FIELD(value, CCM_ANALOG_PLL_ARM_DIV_SELECT);
        bool runs = RT_FIELD(value, CCM_ANALOG_PLL_ARM_POWERDOWN) == 0 && divider >= 54 && divider <= 108;
        set_pll(chip, &clocks->arm, runs, (change & MASK(CCM_ANALOG_PLL_ARM_DIV_SELECT)) != 0);
        break;
    }
    case CCM_ANALOG_PLL_USB1:
        set_pll(chip, &clocks->usb, RT_FIELD(value, CCM_ANALOG_PLL_USB1_POWER) != 0,
                (change & MASK(CCM_ANALOG_PLL_USB1_DIV_SELECT)) != 0);
        break;
    case CCM_ANALOG_PLL_SYS:
        set_pll(chip, &clocks->system, RT_FIELD(value, CCM_ANALOG_PLL_SYS_POWERDOWN) == 0, false);
        break;
    case CCM_ANALOG_PFD_528:
    case PMU_REG_3P0:
        break;
    default:
        rt_unmodelled(chip, "CCM_ANALOG", offset, true);
    }
    check_core(chip);
}

uint32_t rt_dcdc_read(rt_chip *chip, uint32_t offset)
{
    if (offset == DCDC_REG3) return chip->clocks.dcdc[3];
    if (offset != DCDC_REG0) {
        rt_unmodelled(chip, "DCDC", offset, false);
        return 0;
    }
    if (is_voltage_good(chip)) {
        rt_answered(chip, BASE_DCDC + DCDC_REG0);
        return chip->clocks.dcdc[0] | MASK(DCDC_REG0_STS_DC_OK);
    }
    rt_pending(chip, BASE_DCDC + DCDC_REG0, "DCDC_REG0 STS_DC_OK: the voltage settles");
    return chip->clocks.dcdc[0];
}

void rt_dcdc_write(rt_chip *chip, uint32_t offset, uint32_t value)
{
    if (offset != DCDC_REG3) {
        rt_unmodelled(chip, "DCDC", offset, true);
        return;
    }
    if (RT_FIELD(chip->clocks.dcdc[3] ^ value, DCDC_REG3_TRG) != 0) chip->clocks.dcdc_since = chip->now;
    chip->clocks.dcdc[3] = value;
}

static void open_gate(rt_clocks *clocks, uint32_t number, uint32_t gate)
{
    clocks->ccm[(CCM_CCGR0 + 4 * number) / 4] |= 3u << (2 * gate);
}

/* Gates that are open when the ROM has started the image: IOMUXC and its GPR, FlexSPI, DCDC, the analog part,
 * WDOG3, and the on-chip memories. */
static void open_rom_gates(rt_clocks *clocks)
{
    open_gate(clocks, 3, 9);
    open_gate(clocks, 4, 1);
    open_gate(clocks, 4, 2);
    open_gate(clocks, 5, 2);
    open_gate(clocks, 6, 3);
    open_gate(clocks, 6, 5);
    open_gate(clocks, 6, 11);
}

void rt_clocks_reset(rt_chip *chip)
{
    rt_clocks *clocks = &chip->clocks;
    *clocks = (rt_clocks){.arm_divider = 2, .ahb_divider = 1, .dcdc = {0, 0, 0, VOLTAGE_RESET}};
    uint64_t long_ago = chip->now > RT_INSTANTS_PER_s ? chip->now - RT_INSTANTS_PER_s : 0;
    clocks->dcdc_since = long_ago;
    clocks->system = (rt_pll){long_ago, true};
    clocks->usb = (rt_pll){long_ago, true};
    clocks->analog[CCM_ANALOG_PLL_ARM / 4] = MASK(CCM_ANALOG_PLL_ARM_BYPASS) |
                                             MASK(CCM_ANALOG_PLL_ARM_POWERDOWN) |
                                             MASK(CCM_ANALOG_PLL_ARM_ENABLE) | 0x63;
    clocks->analog[CCM_ANALOG_PLL_SYS / 4] = MASK(CCM_ANALOG_PLL_SYS_ENABLE) | 1;
    clocks->analog[CCM_ANALOG_PLL_USB1 / 4] =
        MASK(CCM_ANALOG_PLL_USB1_POWER) | MASK(CCM_ANALOG_PLL_USB1_ENABLE);
    clocks->analog[CCM_ANALOG_PFD_528 / 4] = 0x1018101b;
    clocks->ccm[CCM_CACRR / 4] = 1;
    clocks->ccm[CCM_CBCDR / 4] = BITS(CCM_CBCDR_IPG_PODF, 3);
    clocks->ccm[CCM_CBCMR / 4] = BITS(CCM_CBCMR_PRE_PERIPH_CLK_SEL, 1);
    clocks->core_Hz = rom_core_Hz;
    clocks->instants_per_cycle = 50;
    open_rom_gates(clocks);
}
