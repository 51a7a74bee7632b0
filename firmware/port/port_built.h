/* This header declares the data that the builder of a rig gives to the port of this rig. */
#ifndef CRN_PORT_BUILT_H
#define CRN_PORT_BUILT_H

#include <stdint.h>

/* The data of crn_port_built come from the rig's builder and hold for every track. The builder's data limit
 * the values that a host may set without a person at the rig (docs/haptics.md, "Who may state what"). A field
 * with the value 0 means that the rig's builder gives no such value. */
typedef struct crn_port_built {
    uint32_t translation_pm_per_count; /* 0: 1,000,000 */
    uint32_t rotation_counts_per_turn; /* 0: 65,536 */
    uint32_t damping_mN_s_per_m; /* the rig's own damping, the least of all tracks; 0: none that a coupling
                                    may rely on */
    uint32_t damping_nN_m_s_per_rad; /* the same for rotation */
    uint32_t actuator_lag_us;        /* the longest lag of all tracks */
    uint32_t options; /* CRN_WIRE_OPTION_*: the encoders that count in the opposite direction */
} crn_port_built;

#endif
