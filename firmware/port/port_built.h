/* What a port says of the rig that it was built for. */
#ifndef CRN_PORT_BUILT_H
#define CRN_PORT_BUILT_H

#include <stdint.h>

/* What the rig's builder knows of every track. What a host may state without somebody at the rig is measured
 * against it (docs/haptics.md, "Who may state what"); 0 where the builder does not say. */
typedef struct crn_port_built {
    uint32_t translation_pm_per_count; /* 0: 1,000,000 */
    uint32_t rotation_counts_per_turn; /* 0: 65,536 */
    uint32_t
        damping_mN_s_per_m; /* own damping, the least of all tracks; 0: none that a coupling may count on */
    uint32_t damping_nN_m_s_per_rad; /* the same about the axis */
    uint32_t actuator_lag_us;        /* the longest of all tracks */
    uint32_t options;                /* CRN_WIRE_OPTION_*: which encoders count the other way */
} crn_port_built;

#endif
