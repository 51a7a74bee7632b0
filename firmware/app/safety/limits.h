/* This header has the limits that protect the hand at the rig, for all code that can move a motor. */
#ifndef CRN_LIMITS_H
#define CRN_LIMITS_H

enum {
    CRN_APP_EDGE_us = 1000, /* from one edge of the timer to the next */
    CRN_APP_FORCE_LIMIT_mN =
        8000, /* three times a hand's hardest push (0.8 N) and a stuck guidewire's 2 N together */
    CRN_APP_TORQUE_LIMIT_uN_m = 20000,   /* a hand turns a 0.9 mm guidewire with about 5 mN m */
    CRN_APP_FORCE_SLEW_mN_per_tick = 50, /* 50 N/s: full scale in 160 ms */
    CRN_APP_TORQUE_SLEW_uN_m_per_tick = 125,
    CRN_APP_JUMP_um = 5000,         /* in one tick, 5 m/s: no hand does that */
    CRN_APP_HOST_SILENT_ticks = 30, /* a frame is due within this time; then the forces begin to fade */
    CRN_APP_FADE_ticks = 12,   /* no force is left after this; with 8 ms for a motor's lag, 50 ms in all */
    CRN_APP_CODE_ticks = 2000, /* between ARM_MOTORS and CONFIRM, and between CONFIRM and START */
    CRN_APP_ASKED_ticks = 8,   /* a force measured now may have been requested this long ago */
    CRN_APP_GIVEN_MAX_mJ = 10, /* what tools and coupling may give that they held before START */
};

/* Names the two axes of a track, along and about the direction of insertion. */
enum { CRN_APP_ALONG, CRN_APP_ABOUT };

#endif
