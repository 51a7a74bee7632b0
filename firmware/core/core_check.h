/* What seld_model_build() demands of its input. Private to firmware/core. May include: core_model.h. */
#ifndef SELD_CORE_CHECK_H
#define SELD_CORE_CHECK_H

#include "firmware/core/core_model.h"

enum {
    SELD_TOOL_MIN_um = 20000,
    SELD_TOOL_MAX_um = 1600000,
};

/* Number, ranges, order and nesting of tools, and the entry. *place names the offender. */
seld_build_status seld_check_tools(const seld_instrument *tools, uint32_t tool_count,
                                   seld_build_place *place);
seld_build_status seld_check_entry(const seld_entry *entry);

#endif
