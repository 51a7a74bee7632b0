/* This port has never run on hardware. This file reads the port's inputs and sets its outputs: encoders,
 * sensors, switches, motors and the two lines to the power stage. The power stage removes the power by itself
 * when the drive line has not toggled for 5 ms. */
#include "firmware/port/imxrt1062/board.h"
#include "firmware/port/imxrt1062/imxrt1062_registers.h"

enum { /* bits of GPIO1 and GPIO2: docs/porting.md, "Pins" */
       GPIO1_ENABLE = 31,
       GPIO1_STOP = 12,
       GPIO1_PEDAL_XRAY = 13,
       GPIO2_DRIVE = 12,
       GPIO2_LAMP = 3,
       GPIO2_PEDAL_CINE = 2,
       GPIO2_UNLOCK = 28,
       GPIO2_STAGE = 29,
       BLINK_SLOW_ticks = 500,
       BLINK_FAST_ticks = 100,
};

/* Holds the level of an input; a new level counts only after it has been constant for some ticks. */
typedef struct debounced {
    uint32_t ticks;
    bool level;
} debounced;

static struct {
    debounced pedals[2], unlock, stop;
    uint32_t lamp_ticks;
    bool was_enabled;
} rig;

static bool debounce(debounced *input, bool now, uint32_t ticks)
{
    input->ticks = now == input->level ? 0 : input->ticks + 1;
    if (input->ticks >= ticks) {
        input->level = now;
        input->ticks = 0;
    }
    return input->level;
}

static uint8_t range_of(bool is_sampled, uint16_t raw)
{
    if (!is_sampled) return CRN_PORT_SENSOR_ERROR;
    return raw < BOARD_SENSOR_MIN_raw || raw > BOARD_SENSOR_MAX_raw ? CRN_PORT_SENSOR_RANGE
                                                                    : CRN_PORT_SENSOR_OK;
}

/* The emergency stop is a wire loop that is closed to ground. An open or broken loop of the emergency stop
 * counts at once as a pressed stop button. */
static bool read_stop(uint32_t gpio1)
{
    bool is_open = gpio1 >> GPIO1_STOP & 1u;
    if (is_open) {
        rig.stop = (debounced){.level = true};
        return true;
    }
    return debounce(&rig.stop, false, BOARD_STOP_RELEASE_ticks);
}

static void read_switches(crn_port_inputs *inputs)
{
    uint32_t gpio1 = R32(BASE_GPIO1, GPIO_PSR), gpio2 = R32(BASE_GPIO2, GPIO_PSR);
    bool xray = debounce(&rig.pedals[0], (gpio1 >> GPIO1_PEDAL_XRAY & 1u) == 0, BOARD_DEBOUNCE_ticks);
    bool cine = debounce(&rig.pedals[1], (gpio2 >> GPIO2_PEDAL_CINE & 1u) == 0, BOARD_DEBOUNCE_ticks);
    inputs->buttons = (xray ? 1u : 0u) | (cine ? 2u : 0u);
    inputs->local_unlock = debounce(&rig.unlock, (gpio2 >> GPIO2_UNLOCK & 1u) == 0, BOARD_DEBOUNCE_ticks);
    inputs->emergency_stop = read_stop(gpio1);
    inputs->stage_on = gpio2 >> GPIO2_STAGE & 1u;
}

bool rig_inputs(void *context, crn_port_inputs *inputs)
{
    (void)context;
    *inputs = (crn_port_inputs){0};
    sensors_sample sample = sensors_read();
    bool is_faulted = motors_fault();
    for (uint32_t k = 0; k < CRN_PORT_TOOL_MAX; k++) {
        encoders_reading translation = encoders_read(2 * k), rotation = encoders_read(2 * k + 1);
        inputs->hands[k] = (crn_port_hand){translation.counts, rotation.counts};
        inputs->tracks[k] = (crn_port_track){
            .force_raw = (int32_t)sample.force_raw[k] - BOARD_FORCE_ZERO_raw,
            .translation_sensor = translation.sensor,
            .rotation_sensor = rotation.sensor,
            .force_sensor = range_of(sample.is_good, sample.force_raw[k]),
            .over_current = is_faulted || !sample.is_good || sample.current_raw[k] > BOARD_CURRENT_MAX_raw,
        };
    }
    encoders_reading syringe = encoders_read(ENCODERS_SYRINGE);
    inputs->syringe_counts = syringe.counts;
    inputs->syringe_sensor = syringe.sensor;
    inputs->inflator_raw = sample.inflator_raw;
    inputs->inflator_sensor = range_of(sample.is_good, sample.inflator_raw);
    inputs->supply_good = sample.is_good && sample.supply_raw >= BOARD_SUPPLY_MIN_raw &&
                          sample.supply_raw <= BOARD_SUPPLY_MAX_raw;
    read_switches(inputs);
    return true;
}

static void put(uint32_t base, uint32_t bit, bool level)
{
    if (level) {
        R32(base, GPIO_DR_SET) = 1u << bit;
    } else {
        R32(base, GPIO_DR_CLEAR) = 1u << bit;
    }
}

static bool lamp_level(uint8_t lamp)
{
    rig.lamp_ticks++;
    if (lamp == CRN_PORT_LAMP_RUNNING) return true;
    if (lamp == CRN_PORT_LAMP_ARMED) return rig.lamp_ticks % BLINK_SLOW_ticks < BLINK_SLOW_ticks / 2;
    if (lamp == CRN_PORT_LAMP_FAULT) return rig.lamp_ticks % BLINK_FAST_ticks < BLINK_FAST_ticks / 2;
    return false;
}

/* To switch the motor power on, the function sets the motors' forces first; to switch it off, the function
 * removes the power first. A latched fault of the PWM is cleared when power is requested again, which the app
 * allows only after RESET and arming. */
void rig_outputs(void *context, const crn_port_outputs *outputs)
{
    (void)context;
    if (outputs->enable) {
        if (!rig.was_enabled) motors_clear_fault();
        motors_write(outputs->motors);
        put(BASE_GPIO1, GPIO1_ENABLE, true);
        put(BASE_GPIO2, GPIO2_DRIVE, outputs->drive);
    } else {
        put(BASE_GPIO1, GPIO1_ENABLE, false);
        motors_off();
    }
    rig.was_enabled = outputs->enable;
    put(BASE_GPIO2, GPIO2_LAMP, lamp_level(outputs->lamp));
}

void rig_outputs_off(void)
{
    R32(BASE_GPIO1, GPIO_DR_CLEAR) = 1u << GPIO1_ENABLE;
    R32(BASE_GPIO2, GPIO_DR_CLEAR) = 1u << GPIO2_DRIVE | 1u << GPIO2_LAMP;
    R32(BASE_GPIO1, GPIO_GDIR) |= 1u << GPIO1_ENABLE;
    R32(BASE_GPIO2, GPIO_GDIR) |= 1u << GPIO2_DRIVE | 1u << GPIO2_LAMP;
    motors_off();
}
