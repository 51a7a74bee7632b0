/* The fault log and the way into state FAULT. Called by: this folder. */
#include "firmware/app/app_internal.h"

static bool fault_stops(seld_fault_code code)
{
    switch (code) {
#define FAULT(NAME, number, effect, safe_ms, test, text, detection, remedy)                                  \
    case SELD_FAULT_CODE_##NAME:                                                                             \
        return effect[0] == 's';
#include "shared/wire/wire_faults.def"
    case SELD_FAULT_CODE_NONE:
        break;
    }
    return false;
}

/* One line per code: when it was first, when last, how often, and the last values. */
void seld_app_fault_log(seld_app *app, seld_fault_code code, int32_t value1, int32_t value2)
{
    uint16_t i = 0;
    while (i < app->fault_count && app->faults[i].code != code) i++;
    if (i == app->fault_count && i < SELD_APP_FAULT_MAX) {
        app->faults[i] = (seld_wire_fault_entry){.code = (uint16_t)code, .tick_first = app->core.words.tick};
        app->fault_count++;
    }
    if (i >= app->fault_count) return;
    if (app->faults[i].count < UINT32_MAX) app->faults[i].count++;
    app->faults[i].tick_last = app->core.words.tick;
    app->faults[i].value1 = value1;
    app->faults[i].value2 = value2;
}

/* The first fault that stops is the cause that `status` tells; what follows from it is only in the log. */
void seld_app_fault(seld_app *app, seld_fault_code code, int32_t value1, int32_t value2)
{
    seld_app_fault_log(app, code, value1, value2);
    if (fault_stops(code)) {
        seld_app_motors_off(app);
        if (app->state != SELD_WIRE_STATE_FAULT) app->fault_code = (uint16_t)code;
        seld_app_set_state(app, SELD_WIRE_STATE_FAULT);
        seld_app_motors_off(app); /* the lamp */
    }
    seld_app_notice(app, SELD_WIRE_EVENT_FAULT, (uint16_t)code, value1, value2);
}

void seld_app_internal_error(seld_app *app, int line, int32_t value)
{
    seld_app_fault(app, SELD_FAULT_CODE_INTERNAL, line, value);
}
