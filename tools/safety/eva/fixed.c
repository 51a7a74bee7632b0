/* Calls every function of firmware/core/fixed.c with every input that its header allows. Some inputs are
 * divided into parts that cover the whole range, because the analysis joins what it knows about two numbers
 * that depend on each other, unless both ranges are small. */
#include "firmware/core/vector.h"
#include "tools/safety/eva/any.h"

enum {
    ANGLE_PARTS_LOG2 = 3,
    ASIN_PARTS = 16, /* of |a| from 0 to 1/2 */
    ROOT_PARTS = 16, /* of 1 - |a| from 1/4 to 1/2 */
};

static void every_angle(void)
{
    const uint32_t size = 1u << (32 - ANGLE_PARTS_LOG2);
    for (uint32_t part = 0; part < 1u << ANGLE_PARTS_LOG2; part++) {
        int32_t sine, cosine;
        crn_sincos_turn32(any_from(part * size, part * size + (size - 1)), &sine, &cosine);
    }
}

static void asin_of_both(uint32_t low, uint32_t high)
{
    const int32_t size = Frama_C_interval((int)low, (int)high);
    crn_asin_q29(size);
    crn_asin_q29(-size);
}

static void every_asin(void)
{
    const uint32_t one = (uint32_t)CRN_ONE_Q30, size = one / 2 / ASIN_PARTS;
    for (uint32_t part = 0; part < ASIN_PARTS; part++) asin_of_both(part * size, part * size + size);
    for (uint32_t log2 = 0; log2 < 29; log2++) {
        const uint32_t from = 1u << log2, step = log2 == 28 ? from / ROOT_PARTS : from;
        for (uint32_t rest = from; rest < 2 * from; rest += step)
            asin_of_both(one - rest - (step - 1), one - rest);
    }
    asin_of_both(one - 1, one);
    crn_asin_q29(Frama_C_interval(CRN_ONE_Q30, INT32_MAX));
    crn_asin_q29(Frama_C_interval(INT32_MIN, -CRN_ONE_Q30));
}

static crn_vec3 any_vector(void)
{
    return crn_vec3_make(any_i32(), any_i32(), any_i32());
}

static void every_vector(void)
{
    int32_t length;
    for (unsigned shift = 1; shift <= 63; shift++) crn_vec3_cross(any_vector(), any_vector(), shift);
    crn_vec3_normalise(any_vector(), any_vector(), &length);
    crn_vec3_normalise(any_vector(), any_vector(), NULL);
}

void eva_main(void)
{
    crn_sqrt64(any_u64());
    crn_divide_u64(any_u64(), any_u64());
    every_angle();
    every_asin();
    every_vector();
}
