/* The board's image on its chip, for the tests that run it. */
#ifndef CRN_RT1062_IMAGE_ROOM_H
#define CRN_RT1062_IMAGE_ROOM_H

#include "hil_tests/rt1062/engine.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Makes a chip with the image in its flash; the drivers report no fault, and no USB cable is plugged. Returns
 * false, after a message, if the image cannot be loaded. */
static inline bool begin_image(rt_chip **chip, rt_engine **engine)
{
    char path[512];
    const char *build = getenv("BUILD"), *error = "no memory";
    snprintf(path, sizeof path, "%s/firmware/cournand-imxrt1062.elf", build != NULL ? build : "build");
    *chip = rt_chip_create();
    *engine = *chip == NULL ? NULL : rt_engine_create(*chip, path, &error);
    if (*engine == NULL) {
        fprintf(stderr, "%s: %s\n", path, error);
        return false;
    }
    rt_pin_drive(*chip, RT_PIN_FAULT, RT_HIGH, 0);
    return true;
}

static inline void end_image(rt_chip *chip, rt_engine *engine)
{
    rt_engine_destroy(engine);
    rt_chip_destroy(chip);
}

static inline bool console_says(const rt_chip *chip, const char *text)
{
    return strstr(chip->uart.text, text) != NULL;
}

#endif
