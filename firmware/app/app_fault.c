/* The fault log, and the one place that enters the state FAULT. */
#include "firmware/app/app_internal.h"

static bool fault_stops(crn_fault_code code)
{
    switch (code) {
#define FAULT(NAME, number, effect, safe_ms, test, text, detection, remedy)                                  \
    case CRN_FAULT_CODE_##NAME:                                                                              \
        return effect[0] == 's';
#include "shared/wire/wire_faults.def"
    case CRN_FAULT_CODE_NONE:
        break;
    }
    return false;
}

/* The fault log has one entry for each fault code: the ticks of the fault's first and last occurrence, the
 * number of occurrences, and the last values. */
void crn_app_fault_log(crn_app *app, crn_fault_code code, int32_t value1, int32_t value2)
{
    uint16_t i = 0;
    while (i < app->faults.count && app->faults.entries[i].code != code) i++;
    if (i == app->faults.count && i < CRN_APP_FAULT_MAX) {
        app->faults.entries[i] =
            (crn_wire_fault_entry){.code = (uint16_t)code, .tick_first = app->core.words.tick};
        app->faults.count++;
    }
    if (i >= app->faults.count) return;
    if (app->faults.entries[i].count < UINT32_MAX) app->faults.entries[i].count++;
    app->faults.entries[i].tick_last = app->core.words.tick;
    app->faults.entries[i].value1 = value1;
    app->faults.entries[i].value2 = value2;
}

/* The message `status` reports the first fault that stops the device as the cause; faults that follow from
 * the first one are only in the log. */
/* Requirement: SR-09 */
void crn_app_fault(crn_app *app, crn_fault_code code, int32_t value1, int32_t value2)
{
    crn_app_fault_log(app, code, value1, value2);
    if (fault_stops(code)) {
        crn_app_motors_off(app);
        if (app->state != CRN_WIRE_STATE_FAULT) app->faults.stopped_by = (uint16_t)code;
        crn_app_set_state(app, CRN_WIRE_STATE_FAULT);
        crn_app_motors_off(app); /* the lamp */
    }
    crn_app_notice(app, CRN_WIRE_EVENT_FAULT, (uint16_t)code, value1, value2);
}

/* Reports the faults that one part of the app has found, in the order in which this part found them. */
void crn_app_report(crn_app *app, const crn_findings *findings)
{
    for (uint32_t i = 0; i < findings->count; i++) {
        const crn_finding *finding = &findings->list[i];
        crn_app_fault(app, finding->code, finding->value1, finding->value2);
    }
}

void crn_app_port_error(crn_app *app, int32_t value)
{
    crn_app_internal_error(app, 0, value);
}

void crn_app_internal_error(crn_app *app, int line, int32_t value)
{
    crn_app_fault(app, CRN_FAULT_CODE_INTERNAL, line, value);
}
