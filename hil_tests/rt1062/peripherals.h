/* The state of every peripheral of the model (chip.h), and their functions. Each peripheral has a file of its
 * own. Time is in instants: 19.8 GHz is the least frequency of which 24, 396 and 600 MHz are whole parts. */
#ifndef CRN_RT1062_PERIPHERALS_H
#define CRN_RT1062_PERIPHERALS_H

#include "firmware/port/imxrt1062/imxrt1062_registers.h"
#include "hil_tests/rt1062/registers.h"
#include <stdbool.h>
#include <stdint.h>

#define RT_INSTANTS_PER_s 19800000000ull
#define RT_INSTANTS_PER_us 19800ull
#define RT_NEVER UINT64_MAX

struct rt_chip;

static inline uint32_t rt_field_(uint32_t word, uint32_t shift, uint32_t bits)
{
    return word >> shift & ((1u << bits) - 1u);
}
#define RT_FIELD_(word, shift, bits) rt_field_(word, shift, bits)
#define RT_FIELD(word, ...) RT_FIELD_(word, __VA_ARGS__)

/* --- clocks.c: CCM, its analog part (PLLs, regulators), DCDC --- */
enum { RT_CCM_WORDS = 0x90 / 4, RT_ANALOG_WORDS = 0x180 / 4, RT_GATES = 8 };
typedef struct rt_pll {
    uint64_t since; /* instant at which its present setting began */
    bool runs;      /* powered, with a divider in range */
} rt_pll;
typedef struct rt_clocks {
    uint32_t ccm[RT_CCM_WORDS], analog[RT_ANALOG_WORDS], dcdc[4];
    rt_pll arm, system, usb;
    uint64_t dcdc_since;
    uint64_t periph_busy_until, arm_busy_until, ahb_busy_until;
    double core_Hz, arm_divider, ahb_divider; /* in force: a change takes effect when its handshake ends */
    bool periph_from_clk2;
    bool is_dead; /* a fault has taken the processor's clock away, until a reset */
    uint64_t instants_per_cycle;
} rt_clocks;
void rt_clocks_reset(struct rt_chip *chip);
uint32_t rt_ccm_read(struct rt_chip *chip, uint32_t offset);
void rt_ccm_write(struct rt_chip *chip, uint32_t offset, uint32_t value);
uint32_t rt_analog_read(struct rt_chip *chip, uint32_t offset);
void rt_analog_write(struct rt_chip *chip, uint32_t offset, uint32_t value);
uint32_t rt_dcdc_read(struct rt_chip *chip, uint32_t offset);
void rt_dcdc_write(struct rt_chip *chip, uint32_t offset, uint32_t value);
bool rt_gate_is_open(struct rt_chip *chip, uint32_t number, uint32_t gate);
void rt_clocks_update(struct rt_chip *chip); /* lets handshakes end that are due */
void rt_clocks_upset(struct rt_chip *chip);  /* a bit of a stored word has flipped: it acts at once */
double rt_clock_ipg_Hz(struct rt_chip *chip);
double rt_clock_perclk_Hz(struct rt_chip *chip);
double rt_clock_uart_Hz(struct rt_chip *chip);
double rt_clock_flexspi2_Hz(struct rt_chip *chip); /* 0: its source does not run */
bool rt_clock_usb_runs(struct rt_chip *chip);

/* --- flexram.c: IOMUXC_GPR, which splits the FlexRAM and chooses inputs --- */
typedef struct rt_flexram {
    uint32_t gpr[0x80 / 4];
} rt_flexram;
void rt_flexram_reset(struct rt_chip *chip);
uint32_t rt_gpr_read(struct rt_chip *chip, uint32_t offset);
void rt_gpr_write(struct rt_chip *chip, uint32_t offset, uint32_t value);
uint32_t rt_itcm_bytes(const struct rt_chip *chip);
uint32_t rt_dtcm_bytes(const struct rt_chip *chip);

/* --- flexspi.c: FlexSPI2; psram.c: the chip behind it --- */
enum { RT_LUT_WORDS = 64 };
typedef struct rt_psram {
    uint8_t *memory;
    bool is_fitted, has_four_lines, is_reset_enabled;
} rt_psram;
/* One transaction on the lines: what FlexSPI sends, and how many data bytes follow. */
typedef struct rt_spi {
    uint32_t command, command_lines, address, address_bits, address_lines, dummy_clocks, data_bytes,
        data_lines;
    bool has_address, reads, writes;
    double clock_Hz;
} rt_spi;
typedef struct rt_flexspi {
    uint32_t mcr0, ahbcr, intr, lutkey, size_kB, timing, sequences, ipcr0, ipcr1, lut[RT_LUT_WORDS];
    bool is_unlocked;
    uint64_t reset_until, command_until;
    uint32_t command_error;
    uint64_t access_instants; /* of the last access of the processor */
} rt_flexspi;
void rt_flexspi_reset(struct rt_chip *chip);
uint32_t rt_flexspi_read(struct rt_chip *chip, uint32_t offset);
void rt_flexspi_write(struct rt_chip *chip, uint32_t offset, uint32_t value);
/* An access of the processor to the mapped PSRAM; false: the bus reports an error. */
bool rt_flexspi_access(struct rt_chip *chip, uint32_t address, unsigned bytes, bool is_write,
                       uint32_t *value);
/* True if reads and writes of whole lines reach the PSRAM rightly with the present setting. */
bool rt_flexspi_is_sound(struct rt_chip *chip);
/* Instants that a line of 32 bytes takes. */
uint64_t rt_flexspi_line_instants(struct rt_chip *chip);
/* Returns false if the chip does not understand the transaction; data then are all ones. */
bool rt_psram_transfer(struct rt_chip *chip, const rt_spi *spi, uint8_t *data);

/* --- timers.c: PIT channel 0, GPT1 --- */
typedef struct rt_pit {
    uint32_t mcr, load, control, flag;
    uint64_t next; /* instant of the next time-out */
} rt_pit;
typedef struct rt_gpt {
    uint32_t control, prescaler;
    uint64_t begin, reset_until;
    uint32_t count; /* while it stands */
} rt_gpt;
void rt_timers_reset(struct rt_chip *chip);
uint32_t rt_pit_read(struct rt_chip *chip, uint32_t offset);
void rt_pit_write(struct rt_chip *chip, uint32_t offset, uint32_t value);
uint64_t rt_pit_run_due(struct rt_chip *chip);
bool rt_pit_interrupts(const struct rt_chip *chip);
uint32_t rt_gpt_read(struct rt_chip *chip, uint32_t offset);
void rt_gpt_write(struct rt_chip *chip, uint32_t offset, uint32_t value);

/* --- watchdogs.c: WDOG1, RTWDOG, SRC, OCOTP --- */
typedef struct rt_watchdogs {
    uint32_t wcr, wmcr, srsr;
    uint64_t wdog_bites, service_until;
    bool is_half_served, is_locked;
    uint32_t cs, toval;
    uint64_t rtwdog_bites, unlocked_until;
    uint64_t served;
} rt_watchdogs;
void rt_watchdogs_reset(struct rt_chip *chip, bool is_power_up);
uint32_t rt_wdog_read(struct rt_chip *chip, uint32_t offset);
void rt_wdog_write(struct rt_chip *chip, uint32_t offset, uint32_t value);
uint32_t rt_rtwdog_read(struct rt_chip *chip, uint32_t offset);
void rt_rtwdog_write(struct rt_chip *chip, uint32_t offset, uint32_t value);
uint64_t rt_watchdogs_run_due(struct rt_chip *chip);
/* A debugger halts the processor for a time: with WDBG the watchdog stands meanwhile. */
void rt_watchdogs_halt(struct rt_chip *chip, uint64_t instants);
uint32_t rt_src_read(struct rt_chip *chip, uint32_t offset);
void rt_src_write(struct rt_chip *chip, uint32_t offset, uint32_t value);
uint32_t rt_ocotp_read(struct rt_chip *chip, uint32_t offset);

/* --- pins.c: IOMUXC, GPIO1 to 3, and what is connected to the pins --- */
typedef enum rt_pin {
    RT_PIN_ENCODER_A0, /* translation 1, 2, 3, rotation 1 (decoders), rotation 2, 3, syringe (timers) */
    RT_PIN_ENCODER_B0 = RT_PIN_ENCODER_A0 + 7,
    RT_PIN_PWM0 = RT_PIN_ENCODER_B0 + 7, /* axial and rotation of track 1, 2, 3 */
    RT_PIN_DIRECTION0 = RT_PIN_PWM0 + 6,
    RT_PIN_FAULT = RT_PIN_DIRECTION0 + 6,
    RT_PIN_DRIVE,
    RT_PIN_ENABLE,
    RT_PIN_LAMP,
    RT_PIN_STOP,
    RT_PIN_PEDAL_XRAY,
    RT_PIN_PEDAL_CINE,
    RT_PIN_UNLOCK,
    RT_PIN_STAGE,
    RT_PIN_CONSOLE,
    RT_PIN_FORCE0,
    RT_PIN_CURRENT0 = RT_PIN_FORCE0 + 3,
    RT_PIN_PRESSURE = RT_PIN_CURRENT0 + 3,
    RT_PIN_SUPPLY,
    RT_PIN_MEMORY0, /* DQS, select, clock, four lines of data */
    RT_PINS = RT_PIN_MEMORY0 + 7,
} rt_pin;
typedef enum rt_level { RT_LOW, RT_HIGH, RT_OPEN } rt_level; /* what the rig drives */
enum { RT_IOMUXC_WORDS = 0x800 / 4, RT_PORTS = 3 };
typedef struct rt_pins {
    uint32_t iomuxc[RT_IOMUXC_WORDS];
    uint32_t data[RT_PORTS], direction[RT_PORTS];
    uint8_t rig[RT_PINS]; /* rt_level */
    double volts[RT_PINS];
    uint32_t drive_edges; /* of the drive line, since the model was made */
} rt_pins;
void rt_pins_reset(struct rt_chip *chip);
uint32_t rt_iomuxc_read(struct rt_chip *chip, uint32_t offset);
void rt_iomuxc_write(struct rt_chip *chip, uint32_t offset, uint32_t value);
uint32_t rt_gpio_read(struct rt_chip *chip, uint32_t port, uint32_t offset);
void rt_gpio_write(struct rt_chip *chip, uint32_t port, uint32_t offset, uint32_t value);
/* True if mux, input selection and electrical setting of the pin are those of its function on this board. */
bool rt_pin_is_routed(const struct rt_chip *chip, rt_pin pin);
const char *rt_pin_name(rt_pin pin);
/* The rig drives a digital input at an instant that is not later than now. */
void rt_pin_drive(struct rt_chip *chip, rt_pin pin, rt_level level, uint64_t instant);
void rt_pin_volts(struct rt_chip *chip, rt_pin pin, double volts);
/* The level that the chip sees at an input, or that the rig sees at an output; an output that nothing drives
 * is low by the resistor outside. */
bool rt_pin_level(struct rt_chip *chip, rt_pin pin);

/* --- encoders.c: crossbar, decoders ENC1 to 4, timers TMR1 and TMR3 --- */
enum { RT_DECODERS = 4, RT_TIMER_CHANNELS = 3, RT_CROSSBAR_OUTPUTS = 132 };
typedef struct rt_crossbar {
    uint16_t select[RT_CROSSBAR_OUTPUTS / 2];
} rt_crossbar;
/* A digital input behind its filter: a level counts when it has been there for the filter's time. */
typedef struct rt_filtered {
    bool level, next;
    uint64_t since;
} rt_filtered;
typedef struct rt_quadrature {
    rt_filtered a, b;
    int32_t steps;    /* not yet taken */
    uint32_t illegal; /* both phases changed at once */
} rt_quadrature;
typedef struct rt_decoder {
    uint16_t control, filter, init_low, init_high, control2, held_high;
    uint32_t position;
    rt_quadrature inputs;
} rt_decoder;
typedef struct rt_counter {
    uint16_t control, filter, filter_b, count;
    bool is_enabled;
    rt_quadrature inputs;
} rt_counter;
void rt_encoders_reset(struct rt_chip *chip);
uint32_t rt_crossbar_read(struct rt_chip *chip, uint32_t offset);
void rt_crossbar_write(struct rt_chip *chip, uint32_t offset, uint32_t value);
int rt_crossbar_input(const struct rt_chip *chip, uint32_t output);
uint32_t rt_decoder_read(struct rt_chip *chip, uint32_t number, uint32_t offset);
void rt_decoder_write(struct rt_chip *chip, uint32_t number, uint32_t offset, uint32_t value);
uint32_t rt_timer_read(struct rt_chip *chip, uint32_t module, uint32_t offset);
void rt_timer_write(struct rt_chip *chip, uint32_t module, uint32_t offset, uint32_t value);
void rt_encoders_edge(struct rt_chip *chip, uint32_t encoder, bool is_b, bool level, uint64_t instant);

/* --- pwm.c: FlexPWM2 and FlexPWM3 --- */
enum { RT_PWM_MODULES = 2, RT_PWM_SUBMODULES = 4 };
typedef struct rt_pwm_values {
    uint16_t init, val[6];
} rt_pwm_values;
typedef struct rt_pwm_submodule {
    uint16_t control, control2, disable_map;
    rt_pwm_values buffer, active;
} rt_pwm_submodule;
typedef struct rt_pwm {
    rt_pwm_submodule submodules[RT_PWM_SUBMODULES];
    uint16_t outen, mctrl, fctrl, fsts, filter;
    bool is_disabled; /* by the fault input, until the flag is cleared and the input has gone */
} rt_pwm;
void rt_pwm_reset(struct rt_chip *chip);
uint32_t rt_pwm_read(struct rt_chip *chip, uint32_t module, uint32_t offset);
void rt_pwm_write(struct rt_chip *chip, uint32_t module, uint32_t offset, uint32_t value);
void rt_pwm_fault(struct rt_chip *chip); /* the level of the fault line or its routing has changed */
/* Share of the period for which the output is high, 0 .. 1. */
double rt_pwm_duty(struct rt_chip *chip, uint32_t module, uint32_t submodule, bool is_b);

/* --- adc.c --- */
enum { RT_ADCS = 2 };
typedef struct rt_adc {
    uint32_t hc, cfg, gc, gs, result;
    uint64_t converts_until, calibrates_until;
    bool is_complete, is_converting, is_calibrated;
} rt_adc;
void rt_adc_reset(struct rt_chip *chip);
uint32_t rt_adc_read(struct rt_chip *chip, uint32_t number, uint32_t offset);
void rt_adc_write(struct rt_chip *chip, uint32_t number, uint32_t offset, uint32_t value);

/* --- uart.c: LPUART6 --- */
typedef struct rt_uart {
    uint32_t baud, control;
    uint64_t busy_until; /* of the byte in the shift register */
    bool is_full;        /* a byte waits in the data register */
    char text[4096];
    uint32_t text_bytes;
} rt_uart;
void rt_uart_reset(struct rt_chip *chip);
uint32_t rt_uart_read(struct rt_chip *chip, uint32_t offset);
void rt_uart_write(struct rt_chip *chip, uint32_t offset, uint32_t value);

/* --- usb.c: the device controller USB1; usb_phy.c: its transceiver --- */
enum { RT_USB_ENDPOINTS = 8 };
typedef enum rt_usb_bus {
    RT_BUS_UNPLUGGED,
    RT_BUS_POWERED,
    RT_BUS_RESET,
    RT_BUS_ACTIVE,
    RT_BUS_SUSPENDED
} rt_usb_bus;
typedef enum rt_usb_reply {
    RT_USB_SILENCE,
    RT_USB_ACK,
    RT_USB_NAK,
    RT_USB_STALL,
    RT_USB_DATA0,
    RT_USB_DATA1
} rt_usb_reply;
typedef struct rt_usb {
    uint32_t phy_control, phy_pwd;
    uint32_t command, status, interrupts, address, list, port, otg, mode;
    uint32_t setup_status, prime, flush, ready, complete, endpoint_control[RT_USB_ENDPOINTS];
    bool next_toggle[2 * RT_USB_ENDPOINTS];
    uint32_t done[2 * RT_USB_ENDPOINTS]; /* bytes of the descriptor in the overlay */
    uint64_t reset_until, prime_until, flush_until, bus_reset_until;
    rt_usb_bus bus;
    bool is_high_speed;
    uint64_t tokens;
    uint32_t frame_index;
    uint32_t idle_polls; /* reads of USBSTS with nothing to report since the last event */
} rt_usb;
void rt_usb_reset(struct rt_chip *chip);
uint32_t rt_usb_read(struct rt_chip *chip, uint32_t offset);
void rt_usb_write(struct rt_chip *chip, uint32_t offset, uint32_t value);
uint32_t rt_usb_phy_read(struct rt_chip *chip, uint32_t offset);
void rt_usb_phy_write(struct rt_chip *chip, uint32_t offset, uint32_t value);
bool rt_usb_phy_runs(struct rt_chip *chip);
bool rt_usb_is_attached(struct rt_chip *chip);
void rt_usb_plug(struct rt_chip *chip, bool plugged);
void rt_usb_bus_reset(struct rt_chip *chip, bool high_speed);
void rt_usb_suspend(struct rt_chip *chip, bool suspended);
uint64_t rt_usb_run_due(struct rt_chip *chip);
/* True after some rounds of the image's polling that found no event: time may jump to what is due next. */
bool rt_usb_is_idle(const struct rt_chip *chip);
/* One transaction of the bus. `data` holds what the host sends, or receives up to 1,024 bytes. */
typedef enum rt_usb_token { RT_TOKEN_SETUP, RT_TOKEN_OUT, RT_TOKEN_IN } rt_usb_token;
typedef struct rt_usb_packet {
    rt_usb_token token;
    uint8_t address, endpoint;
    bool is_data1, is_ack_lost;
    uint32_t bytes;
    uint8_t data[1024];
} rt_usb_packet;
rt_usb_reply rt_usb_transact(struct rt_chip *chip, rt_usb_packet *packet);

/* --- core.c: the Cortex-M7's own registers --- */
enum { RT_MPU_REGIONS = 16 };
typedef struct rt_core {
    uint32_t vtor, ccr, shcsr, cfsr, csselr, mpu_control, demcr, dwt_control;
    uint32_t enabled[8], begin[RT_MPU_REGIONS], size[RT_MPU_REGIONS], mpu_region;
    uint64_t count_begin; /* in cycles */
    uint64_t cycles;
    uint32_t lines_invalidated, invalidated[32]; /* each line of the data cache counts once */
    bool is_dwt_unlocked, are_instructions_invalidated;
} rt_core;
void rt_core_reset(struct rt_chip *chip);
uint32_t rt_core_read(struct rt_chip *chip, uint32_t address);
void rt_core_write(struct rt_chip *chip, uint32_t address, uint32_t value);
typedef enum rt_access { RT_ACCESS_READ, RT_ACCESS_WRITE, RT_ACCESS_CODE } rt_access;
bool rt_mpu_allows(const struct rt_chip *chip, uint32_t address, rt_access access);
bool rt_mpu_is_cached(const struct rt_chip *chip, uint32_t address);
bool rt_core_has_data_cache(const struct rt_chip *chip);

#endif
