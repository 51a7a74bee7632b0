/* This header declares the checks of the input of crn_model_build(). This header is private to
 * firmware/core. */
#ifndef CRN_CORE_CHECK_H
#define CRN_CORE_CHECK_H

#include "firmware/core/core_model.h"

enum {
    CRN_TOOL_MIN_um = 20000,
    CRN_TOOL_MAX_um = 1600000,
};

/* The functions of this header check the tools (number, ranges of their values, order and nesting) and the
 * place of entry. *place receives the tool and the knot that caused a refusal. */
crn_build_status crn_check_tools(const crn_instrument *tools, uint32_t tool_count, crn_build_place *place);
crn_build_status crn_check_entry(const crn_entry *entry);

#endif
