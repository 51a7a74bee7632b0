/* Claim: the board's port orders at most 8 N and 20 mN m of each motor, whatever the app asks for, and below
 * that exactly what it asks for. This program compiles firmware/port/imxrt1062/motors.c unchanged, with an
 * array in place of the chip's registers. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { AREA_BYTES = 1 << 14, HAND_MAX_mN = 8000, HAND_MAX_uN_m = 20000 };
static uint32_t area[4][AREA_BYTES / 4]; /* PWM2, PWM3, GPIO3, crossbar */
static void *place(uint32_t base, uint32_t offset);
#define R16(base, offset) (*(volatile uint16_t *)place(base, offset))
#define R32(base, offset) (*(volatile uint32_t *)place(base, offset))
#include "firmware/port/imxrt1062/motors.c"

/* A place within an area, from the area's base or from the base of one of its submodules. */
static void *place(uint32_t base, uint32_t offset)
{
    static const uint32_t bases[] = {BASE_PWM2, BASE_PWM3, BASE_GPIO3, BASE_XBARA1};
    for (size_t i = 0; i < sizeof bases / sizeof bases[0]; i++) {
        if (base < bases[i] || base - bases[i] + offset >= AREA_BYTES) continue;
        return (uint8_t *)area[i] + (base - bases[i] + offset);
    }
    fail_msg("the port accesses 0x%08x", (unsigned)(base + offset));
    return area;
}

static uint32_t duty_of(uint32_t motor)
{
    const struct output *output = &outputs[motor];
    const uint32_t at = output->base + output->submodule * SUBMODULE_BYTES;
    return output->is_b ? R16(at, PWM_SMVAL5_0) : R16(at, PWM_SMVAL3_0);
}

/* The force or torque of a motor's duty, rounded. */
static int32_t ordered(uint32_t motor)
{
    const int64_t full = motor % 2 == 0 ? BOARD_AXIAL_FULL_mN : BOARD_TORQUE_FULL_uN_m;
    return (int32_t)((duty_of(motor) * full + PERIOD_counts / 2) / PERIOD_counts);
}

static void write_all(int32_t axial_mN, int32_t torque_uN_m)
{
    crn_port_motor motors[CRN_PORT_TOOL_MAX];
    for (uint32_t k = 0; k < CRN_PORT_TOOL_MAX; k++) motors[k] = (crn_port_motor){axial_mN, torque_uN_m};
    motors_write(motors);
}

/* Requirement: SR-28 */
static void no_order_exceeds_the_limits_of_the_hand(void **state)
{
    (void)state;
    static const int32_t wild[] = {8001, 12000, 20001, 22300, 30000, 1 << 24, INT32_MAX, INT32_MIN};
    motors_start();
    for (size_t i = 0; i < sizeof wild / sizeof wild[0]; i++) {
        for (int32_t sign = 1; sign >= -1; sign -= 2) {
            const int32_t value = wild[i] == INT32_MIN ? INT32_MIN : sign * wild[i];
            write_all(value, value);
            for (uint32_t motor = 0; motor < MOTORS; motor++) {
                const int32_t most = motor % 2 == 0 ? HAND_MAX_mN : HAND_MAX_uN_m;
                if (ordered(motor) > most)
                    fail_msg("motor %u: %d asked, %d ordered, at most %d allowed", motor, value,
                             ordered(motor), most);
            }
        }
    }
}

/* A count of the PWM is 1.6 mN or 4 uN m; the direction line has the sign. */
static void an_order_within_the_limits_is_exact(void **state)
{
    (void)state;
    motors_start();
    for (int32_t axial_mN = -8000; axial_mN <= 8000; axial_mN += 40) {
        const int32_t torque_uN_m = axial_mN / 40 * 100;
        write_all(axial_mN, torque_uN_m);
        for (uint32_t motor = 0; motor < MOTORS; motor++) {
            const int32_t asked = motor % 2 == 0 ? axial_mN : torque_uN_m;
            assert_int_equal(ordered(motor), abs(asked));
            const uint32_t pin = 1u << (DIRECTION_BIT + motor);
            const uint32_t line = asked < 0 ? R32(BASE_GPIO3, GPIO_DR_SET) : R32(BASE_GPIO3, GPIO_DR_CLEAR);
            if (motor == MOTORS - 1) assert_int_equal(line, pin);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_order_exceeds_the_limits_of_the_hand),
        cmocka_unit_test(an_order_within_the_limits_is_exact),
    };
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
