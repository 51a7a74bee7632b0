/* This file translates the emulated rig's registers to the port's inputs and outputs. The code limits values
 * from the memory page of the emulated rig to their ranges before it uses them. */
#include "firmware/port/mps2_an500/device/device.h"

bool rig_is_there(void)
{
    return rig_read(&rig->host.magic) == RIG_MAGIC && rig->host.version == RIG_VERSION;
}

static int32_t signed_of(uint32_t word)
{
    return word <= INT32_MAX ? (int32_t)word : -1 - (int32_t)(UINT32_MAX - word);
}

static uint8_t sensor_of(uint32_t word)
{
    return word <= CRN_PORT_SENSOR_ERROR ? (uint8_t)word : (uint8_t)CRN_PORT_SENSOR_ERROR;
}

static void take_track(const rig_track_inputs *from, crn_port_hand *hand, crn_port_track *track)
{
    *hand = (crn_port_hand){signed_of(from->translation_counts), signed_of(from->rotation_counts)};
    *track = (crn_port_track){
        .force_raw = signed_of(from->force_raw),
        .translation_sensor = sensor_of(from->translation_sensor),
        .rotation_sensor = sensor_of(from->rotation_sensor),
        .force_sensor = sensor_of(from->force_sensor),
        .over_current = from->over_current != 0,
    };
}

static void take_sample(const rig_inputs *from, crn_port_inputs *to)
{
    for (int k = 0; k < RIG_TRACK_COUNT; k++) take_track(&from->tracks[k], &to->hands[k], &to->tracks[k]);
    to->syringe_counts = signed_of(from->syringe_counts);
    to->syringe_sensor = sensor_of(from->syringe_sensor);
    to->inflator_raw = signed_of(from->inflator_raw);
    to->inflator_sensor = sensor_of(from->inflator_sensor);
    to->buttons = from->buttons;
    to->emergency_stop = (from->switches & RIG_EMERGENCY_STOP) != 0;
    to->supply_good = (from->switches & RIG_SUPPLY_GOOD) != 0;
    to->stage_on = (from->switches & RIG_STAGE_ON) != 0;
    to->local_unlock = (from->switches & RIG_LOCAL_UNLOCK) != 0;
}

/* If there is no new reading of the rig, the app treats the user's hands as motionless and decides how long
 * the session may continue without a reading. */
static void mark_stale(crn_port_inputs *inputs)
{
    for (int k = 0; k < RIG_TRACK_COUNT; k++) {
        inputs->tracks[k].translation_sensor = CRN_PORT_SENSOR_ERROR;
        inputs->tracks[k].rotation_sensor = CRN_PORT_SENSOR_ERROR;
        inputs->tracks[k].force_sensor = CRN_PORT_SENSOR_ERROR;
    }
}

bool rig_inputs_read(void *context, crn_port_inputs *inputs)
{
    static crn_port_inputs last;
    (void)context;
    if (!rig_is_there()) return false;
    for (int i = 0; i < RIG_INPUT_TRIES; i++) {
        uint32_t begin = rig_read(&rig->host.inputs_begin);
        crn_port_inputs sample = {0};
        take_sample(&rig->host.inputs, &sample);
        __atomic_thread_fence(__ATOMIC_ACQUIRE);
        if (rig_read(&rig->host.inputs_end) != begin || rig_read(&rig->host.inputs_begin) != begin) continue;
        last = sample;
        *inputs = sample;
        return true;
    }
    *inputs = last;
    mark_stale(inputs);
    return true;
}

void rig_outputs_write(void *context, const crn_port_outputs *outputs)
{
    (void)context;
    rig_outputs *page = &rig->device.outputs;
    for (int k = 0; k < RIG_TRACK_COUNT; k++) {
        rig_write(&page->axial_mN[k], (uint32_t)outputs->motors[k].axial_mN);
        rig_write(&page->torque_uN_m[k], (uint32_t)outputs->motors[k].torque_uN_m);
    }
    rig_write(&page->lamp, outputs->lamp);
    rig_write(&page->enable, outputs->enable);
    rig_write(&page->drive, outputs->drive);
}

void rig_outputs_off(void)
{
    rig_write(&rig->device.outputs.enable, 0);
    for (int k = 0; k < RIG_TRACK_COUNT; k++) {
        rig_write(&rig->device.outputs.axial_mN[k], 0);
        rig_write(&rig->device.outputs.torque_uN_m[k], 0);
    }
    rig_write(&rig->device.outputs.lamp, CRN_PORT_LAMP_FAULT);
}
