/* Faults as values. A part returns what it found, in the order in which it is to be reported; the app logs
 * the findings, and only the app enters the state FAULT. */
#ifndef CRN_FINDING_H
#define CRN_FINDING_H

#include "firmware/port/port.h"
#include "shared/wire/fault_code.h"

typedef struct crn_finding {
    crn_fault_code code;
    int32_t value1, value2; /* as shared/wire/wire_faults.def explains them */
} crn_finding;

/* One call of a check reports at most one finding (a fault) per track. */
typedef struct crn_findings {
    uint32_t count;
    crn_finding list[CRN_PORT_TOOL_MAX];
} crn_findings;

static inline void crn_findings_add(crn_findings *findings, crn_fault_code code, int32_t value1,
                                    int32_t value2)
{
    if (findings->count == CRN_PORT_TOOL_MAX) return;
    findings->list[findings->count++] = (crn_finding){code, value1, value2};
}

#endif
