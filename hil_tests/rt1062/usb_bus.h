/* The bus between the model's USB controller and a host that speaks tokens through the mailbox of
 * shared/mailbox: a test in this process, or a bridge in another one (hil_tests/l3/bridge.c). */
#ifndef CRN_RT1062_USB_BUS_H
#define CRN_RT1062_USB_BUS_H

#include "hil_tests/rt1062/chip.h"
#include "shared/mailbox/mailbox.h"

typedef struct rt_bus {
    rt_chip *chip;
    crn_mailbox *mailbox;
    uint64_t change_until; /* of the bus: a reset takes its time; 0: none waits */
} rt_bus;

/* Powers the mailbox up, after the chip has been; a host is connected. */
void rt_bus_start(rt_bus *bus, rt_chip *chip, crn_mailbox *mailbox);
/* Answers the host's token or change of the bus, if there is one; true: it did. */
bool rt_bus_serve(rt_bus *bus);

#endif
