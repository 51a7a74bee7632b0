/* This header has the numeric codes of the device's faults, without the messages of the wire protocol. C11
 * and C++20. */
#ifndef CRN_FAULT_CODE_H
#define CRN_FAULT_CODE_H

/* clang-format off */
#define FAULT(NAME, code, effect, safe_ms, test, text, detection, remedy) CRN_FAULT_CODE_##NAME = code,
typedef enum crn_fault_code {
    CRN_FAULT_CODE_NONE = 0,
#include "shared/wire/wire_faults.def"
} crn_fault_code;
/* clang-format on */

#endif
