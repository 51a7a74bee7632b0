/* The fault log and the way into state FAULT. Called by: this folder. */
#include "firmware/app/app_internal.h"

static bool fault_stops(seld_fault_code code)
{
    switch (code) {
#define FAULT(NAME, number, effect, text, remedy)                                                            \
    case SELD_FAULT_CODE_##NAME:                                                                             \
        return effect[0] == 's';
#include "shared/wire/wire_faults.def"
    case SELD_FAULT_CODE_NONE:
        break;
    }
    return false;
}

void seld_app_fault(seld_app *app, seld_fault_code code, int32_t value1, int32_t value2)
{
    uint16_t i = 0;
    while (i < app->fault_count && app->faults[i].code != code) i++;
    if (i == app->fault_count && i < SELD_APP_FAULT_MAX) {
        app->faults[i] = (seld_wire_fault_entry){(uint16_t)code, app->core.words.tick, 0, 0, 0};
        app->fault_count++;
    }
    if (i < app->fault_count) {
        if (app->faults[i].count < UINT32_MAX) app->faults[i].count++;
        app->faults[i].value1 = value1;
        app->faults[i].value2 = value2;
    }
    if (fault_stops(code)) {
        app->state = SELD_WIRE_STATE_FAULT;
        app->fault_code = (uint16_t)code;
        seld_app_motors_off(app);
    }
}

void seld_app_internal_error(seld_app *app, int line, int32_t value)
{
    seld_app_fault(app, SELD_FAULT_CODE_INTERNAL, line, value);
}
