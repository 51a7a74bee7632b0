/* This file eliminates a row of the matrix on a Cortex-M7. It computes what the C code of rod_solve.c
 * computes, bit for bit and in the same order. r0 holds the address of the row all the time, and the other 13
 * registers hold what is computed, so that nothing is moved to the stack and back. The row keeps the caller's
 * registers. The numbers in the code are the offsets that the assertions state. */
#include "firmware/core/rod_block.h"

#if CRN_ROW_BY_ASSEMBLY

_Static_assert(offsetof(crn_factor, p_q29) == 36 && offsetof(crn_row, factor) == 36 &&
                   offsetof(crn_row, last) == 40 && offsetof(crn_row, p_before) == 44 &&
                   offsetof(crn_row, tangent_q30) == 48 && offsetof(crn_row, spring4) == 52 &&
                   offsetof(crn_row, minus_second8) == 60 && offsetof(crn_row, second) == 68 &&
                   offsetof(crn_row, second_before) == 72 && offsetof(crn_row, rest) == 76,
               "as the code has it");
_Static_assert(offsetof(crn_row, t) == 100 && offsetof(crn_row, v_q29) == 136 &&
                   offsetof(crn_row, inverse) == 172 && offsetof(crn_row, exponent) == 196 &&
                   offsetof(crn_row, force_N_q22) == 200 && offsetof(crn_row, solution_m_q33) == 204 &&
                   offsetof(crn_row, r) == 208 && offsetof(crn_row, r_before) == 220 &&
                   offsetof(crn_row, force_exponent) == 232 && offsetof(crn_row, wall) == 236,
               "as the code has it");
_Static_assert(sizeof(crn_work) == 196 && offsetof(crn_work, u) == 116 &&
                   offsetof(crn_work, solution_m_q33) == 184,
               "as the code has it");
_Static_assert(offsetof(crn_work, around_q30) == 24 && offsetof(crn_work, normal_q30) == 60 &&
                   offsetof(crn_work, wall_round) == 80 && offsetof(crn_work, wall_normal) == 84 &&
                   offsetof(crn_work, wall_friction) == 88 && offsetof(crn_work, touching) == 112,
               "as the code has it");

/* clang-format off */

/* hi:lo = a x + b y + c z, and what is added to such a sum. */
#define ADD_PRODUCTS(lo, hi, a, b, c, x, y, z) \
    "smlal " lo ", " hi ", " a ", " x "; smlal " lo ", " hi ", " b ", " y "; smlal " lo ", " hi ", " c ", " z "\n"
#define PRODUCTS(lo, hi, a, b, c, x, y, z) \
    "smull " lo ", " hi ", " a ", " x "; smlal " lo ", " hi ", " b ", " y "; smlal " lo ", " hi ", " c ", " z "\n"

/* lo = (hi:lo + 2^28) >> 29. The carry is the last bit that is shifted out. */
#define ROUND29(lo, hi) "lsrs " lo ", " lo ", #29; orr " lo ", " lo ", " hi ", lsl #3; adc " lo ", " lo ", #0\n"

/* out = hi:lo >> n, where power = 2^(32 - n): crn_narrow64() by two products. Destroys `high`. */
#define NARROW(out, lo, hi, power, high) \
    "umull " lo ", " high ", " lo ", " power "; mla " out ", " hi ", " power ", " high "\n"

/* --- the blocks ----------------------------------------------------------------------------------------- */

/* Adds k v v^T to the block in r6, r7, r8, r10, r12, lr. r11 holds 4 k, and r3 to r5 hold v. Destroys r1. */
#define ADD_ALONG \
    "smmulr r2, r11, r3; smmulr r1, r11, r4; lsl r2, r2, #2; smmulr r11, r11, r5; lsl r1, r1, #2\n" \
    "smmlar r6, r2, r3, r6; lsl r11, r11, #2; smmlar r7, r2, r4, r7; smmlar r8, r2, r5, r8\n" \
    "smmlar r10, r1, r4, r10; smmlar r12, r1, r5, r12; smmlar lr, r11, r5, lr\n"

/* The wall of a touching node, as add_wall() adds it. r9 holds the stiffness across the normal. */
#define ADD_WALL \
    "stm r0, {r4-r11, lr}\n" \
    "ldr r1, [r0, #236]; cmp r1, #0; beq 5f\n" \
    "ldr r9, [r1, #88]; ldr r11, [r1, #80]; ldr r2, [r1, #112]; cmp r11, #0; it ne; cmpne r2, #0; beq 6f\n" \
    "ldr r2, [r0, #48]; add r6, r1, #60; ldm r2, {r3, r4, r5}; ldm r6, {r6, r7, r8}\n" \
    PRODUCTS("r10", "r12", "r3", "r4", "r5", "r6", "r7", "r8") \
    "add r12, r12, r10, lsr #31; lsl r12, r12, #2\n" \
    "smmulr r10, r11, r12; lsl r10, r10, #2; smmulr r10, r10, r12; add r9, r9, r10, lsl #2\n" \
    "add r12, r0, #76; ldm r12, {r6, r7, r8, r10, r12, lr}\n" \
    "add r3, r1, #24; ldm r3, {r3, r4, r5}; lsl r11, r11, #2\n" ADD_ALONG \
    "ldr r1, [r0, #236]\n" \
    "7: add r6, r6, r9; add r10, r10, r9; add lr, lr, r9\n" \
    "add r3, r1, #60; ldm r3, {r3, r4, r5}; ldr r11, [r1, #84]; sub r11, r11, r9; lsl r11, r11, #2\n" ADD_ALONG \
    "add r2, r0, #76; stm r2, {r6, r7, r8, r10, r12, lr}\n" \
    "5:\n"

/* The entries of R' + Q' + Q'^T + R - T'^T V' - kb'' P''. r3 to r5 hold a column of V', r6 to r8 one of T', r11
 * points to P'', and r12 holds kb''. A step sums the products of an entry and meanwhile rounds the sum of the entry
 * before and stores the one before that, because the processor starts two instructions in a cycle if neither waits
 * for the other. */
#define COLUMN_OF_V(v, third) "ldrd r3, r4, [r0, #" v "]; ldr r5, [r0, #" third "]\n"
#define REST_SUM(t, third, p, lo, hi) \
    "ldrd r6, r7, [r0, #" t "]; ldr " lo ", [r11, #" p "]; ldr r8, [r0, #" third "]\n" \
    "smull " lo ", " hi ", " lo ", r12\n" ADD_PRODUCTS(lo, hi, "r6", "r7", "r8", "r3", "r4", "r5")
#define REST_STEP(t, third, p, lo, hi, store, last_lo, last_hi, rest) \
    "ldrd r6, r7, [r0, #" t "]; " store "lsrs " last_lo ", " last_lo ", #29; ldr " lo ", [r11, #" p "]\n" \
    "orr " last_lo ", " last_lo ", " last_hi ", lsl #3; ldr r8, [r0, #" third "]; adc " last_lo ", " last_lo ", #0\n" \
    "smull " lo ", " hi ", " lo ", r12; ldr lr, [r0, #" rest "]; smlal " lo ", " hi ", r6, r3\n" \
    "sub lr, lr, " last_lo "; smlal " lo ", " hi ", r7, r4; smlal " lo ", " hi ", r8, r5\n"
#define STORE_REST(rest) "str lr, [r0, #" rest "]; "
#define GATHER_REST \
    "ldr r11, [r0, #44]; ldr r12, [r0, #72]\n" \
    COLUMN_OF_V("136", "144") REST_SUM("100", "108", "0", "r9", "r10") \
    COLUMN_OF_V("148", "156") REST_STEP("100", "108", "4", "r1", "r2", "", "r9", "r10", "76") \
    REST_STEP("112", "120", "12", "r9", "r10", STORE_REST("76"), "r1", "r2", "80") \
    COLUMN_OF_V("160", "168") REST_STEP("100", "108", "8", "r1", "r2", STORE_REST("80"), "r9", "r10", "88") \
    REST_STEP("112", "120", "16", "r9", "r10", STORE_REST("88"), "r1", "r2", "84") \
    REST_STEP("124", "132", "20", "r1", "r2", STORE_REST("84"), "r9", "r10", "92") \
    STORE_REST("92") "ldr lr, [r0, #96]\n" ROUND29("r1", "r2") "sub lr, lr, r1; " STORE_REST("96") "\n"

/* Q by columns from the rows of V', T = R + Q, and R + Q + Q^T for the next row. r1 to r6 hold R. */
#define GATHER_UPPER \
    "add r12, r0, #76; ldm r12, {r1-r6}; ldr r12, [r0, #40]; ldrd r7, r8, [r0, #60]\n" \
    "ldm r12!, {r9, r10, r11}; smmlar r9, r9, r7, r8; smmulr r10, r10, r7; smmulr r11, r11, r7\n" \
    "add lr, r1, r9; str lr, [r0, #100]; add lr, lr, r9; str lr, [r0, #76]\n" \
    "add r10, r10, r2; add r11, r11, r3; strd r10, r11, [r0, #104]\n" \
    "ldm r12!, {r9, r10, r11}; smmulr r9, r9, r7; smmlar r10, r10, r7, r8; smmulr r11, r11, r7\n" \
    "ldr lr, [r0, #104]; add lr, lr, r9; str lr, [r0, #80]; add r9, r9, r2\n" \
    "add lr, r4, r10; add r10, r10, lr; str r10, [r0, #88]; strd r9, lr, [r0, #112]\n" \
    "add r11, r11, r5; str r11, [r0, #120]\n" \
    "ldm r12, {r9, r10, r12}; smmulr r9, r9, r7; smmulr r10, r10, r7; smmlar r12, r12, r7, r8\n" \
    "ldr lr, [r0, #108]; add lr, lr, r9; str lr, [r0, #84]; add r11, r11, r10; str r11, [r0, #92]\n" \
    "add r9, r9, r3; add r10, r10, r5; strd r9, r10, [r0, #124]\n" \
    "add lr, r6, r12; str lr, [r0, #132]; add lr, lr, r12; str lr, [r0, #96]\n"

/* D = R + S. r10, r11 hold 4 (k_s - k_g) and k_g, and r7 to r9 the tangent. */
#define ADD_EDGE \
    "ldr r12, [r0, #48]; ldrd r10, r11, [r0, #52]; ldm r12, {r7, r8, r9}\n" \
    "add r1, r1, r11; add r4, r4, r11; add r6, r6, r11\n" \
    "smmulr r12, r10, r7; smmulr lr, r10, r8; lsl r12, r12, #2; smmulr r10, r10, r9; lsl lr, lr, #2\n" \
    "smmlar r1, r12, r7, r1; lsl r10, r10, #2; smmlar r2, r12, r8, r2; smmlar r3, r12, r9, r3\n" \
    "smmlar r4, lr, r8, r4; smmlar r5, lr, r9, r5; smmlar r6, r10, r9, r6\n"

/* The adjugate of D: its diagonal in r8, r10, r12 and its entries xy, xz, yz in r11, r6, r4. A minor is a sum of
 * products in which one factor is negated, so r2, r3, r5 become -xy, -xz, -yz. r7 is the power of two that shifts to
 * 30 bits. */
#define ADJUGATE \
    "rsb r7, r5, #0; smull r8, r9, r4, r6; smlal r8, r9, r5, r7; mov r5, r7\n" \
    "rsb r7, r3, #0; smull r10, r11, r1, r6; smlal r10, r11, r3, r7; mov r3, r7\n" \
    "rsb r7, r2, #0; smull r12, lr, r1, r4; smlal r12, lr, r2, r7; mov r2, r7\n" \
    "orr r7, r9, r11; orr r7, r7, lr; bic r7, r7, #0x80000000; clz r7, r7; cmp r7, #32; beq 1f\n" \
    "2: sub r7, r7, #2; lsl r9, r9, r7; lsl r11, r11, r7; lsl lr, lr, r7; rsb r7, r7, #32\n" \
    "lsr r8, r8, r7; lsr r10, r10, r7; lsr r12, r12, r7; orr r8, r8, r9; orr r10, r10, r11; orr r12, r12, lr\n" \
    "rsb r9, r7, #32; mov r7, #1; smull r11, lr, r3, r5; lsl r7, r7, r9; smlal r11, lr, r2, r6\n" \
    NARROW("r11", "r11", "lr", "r7", "r9") \
    "smull r6, lr, r2, r5; smlal r6, lr, r3, r4\n" NARROW("r6", "r6", "lr", "r7", "r9") \
    "smull r4, lr, r2, r3; smlal r4, lr, r1, r5\n" NARROW("r4", "r4", "lr", "r7", "r9")

/* The determinant in r7:r5, its leading zeros in r9, its mantissa in r7, and the reciprocal of the mantissa in r1,
 * as crn_reciprocal_q30() computes it. */
#define RECIPROCAL \
    "rsb r2, r2, #0; rsb r3, r3, #0\n" PRODUCTS("r5", "r7", "r1", "r2", "r3", "r8", "r11", "r6") \
    "cmp r7, #0; ble 3f\n" \
    "clz r9, r7; lsl r7, r7, r9; rsb lr, r9, #32; lsr r5, r5, lr; orr r7, r7, r5; lsr r7, r7, #1\n" \
    "4: ubfx r1, r7, #23, #7; ldr r2, =crn_reciprocal_lines; ubfx r5, r7, #0, #23\n" \
    "add r2, r2, r1, lsl #3; ldrd r1, r3, [r2]\n" \
    "umull r3, r5, r3, r5; lsr r3, r3, #23; orr r3, r3, r5, lsl #9; sub r1, r1, r3\n" \
    "umull r3, r5, r7, r1; rsbs r3, r3, #0; mov r2, #0x20000000; sbc r5, r2, r5\n" \
    "lsr r3, r3, #14; orr r3, r3, r5, lsl #18\n" \
    "smull r3, r5, r1, r3; add r5, r5, #0x4000; add r1, r1, r5, asr #15; sub r1, r1, r1, lsr #31\n"

/* D^-1 in r2, r3, r5 to r8, and its exponent. r9 becomes the power of two that shifts V and P: 2^(61 - exponent). */
#define INVERSE \
    "smmulr r2, r8, r1; smmulr r3, r11, r1; smmulr r5, r6, r1\n" \
    "smmulr r6, r10, r1; smmulr r7, r4, r1; smmulr r8, r12, r1\n" \
    "rsb r9, r9, #62; add r1, r0, #172; stm r1, {r2, r3, r5, r6, r7, r8, r9}\n" \
    "rsb r9, r9, #61; mov r10, #1; lsl r9, r10, r9\n"

/* A column of V = D^-1 T, and two entries of P = kb D^-1. An entry is stored while the next one is summed. */
#define V_ENTRY(a, b, c, store) \
    PRODUCTS("r12", "lr", a, b, c, "r1", "r4", "r11") store NARROW("r10", "r12", "lr", "r9", "r10")
#define STORE_V(at) "str r10, [r0, #" at "]\n"
#define V_COLUMN(t, t_third, store, first, second) \
    "ldrd r1, r4, [r0, #" t "]; ldr r11, [r0, #" t_third "]\n" V_ENTRY("r2", "r3", "r5", store) \
    V_ENTRY("r3", "r6", "r7", STORE_V(first)) V_ENTRY("r5", "r7", "r8", STORE_V(second))
#define P_ENTRIES(n, next) \
    "smull r12, lr, " n ", r1; smull r4, r11, " next ", r1\n" \
    "umull r12, r10, r12, r9; umull r4, r12, r4, r9\n" \
    "mla " n ", lr, r9, r10; mla " next ", r11, r9, r12\n"
#define FACTOR \
    V_COLUMN("100", "108", "", "136", "140") V_COLUMN("112", "120", STORE_V("144"), "148", "152") \
    V_COLUMN("124", "132", STORE_V("156"), "160", "164") STORE_V("168") \
    "ldr r1, [r0, #68]\n" P_ENTRIES("r2", "r3") P_ENTRIES("r5", "r6") P_ENTRIES("r7", "r8")

/* Stores P, and V by rows. */
#define STORE \
    "ldr r1, [r0, #36]; add r12, r0, #136; add r4, r1, #36; stm r4, {r2, r3, r5, r6, r7, r8}\n" \
    "ldm r12!, {r2, r5, r8}; ldm r12!, {r3, r6, r9}; ldm r12, {r4, r7, r10}; stm r1, {r2-r10}\n" \
    "ldm r0, {r4-r11, pc}\n"

/* A wall that is not round. An adjugate whose diagonal is below 2^32. A determinant below 2^32 counts as at least
 * 2^31. */
#define RARE \
    "6: add r12, r0, #76; ldm r12, {r6, r7, r8, r10, r12, lr}; b 7b\n" \
    "1: orr r7, r8, r10; orr r7, r7, r12; lsr r7, r7, #31; rsb r7, r7, #33; b 2b\n" \
    "3: it mi; movmi r5, #0; cmp r5, #0; it pl; movpl r5, #0x80000000; lsr r7, r5, #1; mov r9, #32; b 4b\n"

__attribute__((naked)) void crn_row_factor(crn_row *row __attribute__((unused)))
{
    __asm__(".syntax unified\n" ADD_WALL GATHER_REST GATHER_UPPER ADD_EDGE ADJUGATE RECIPROCAL INVERSE FACTOR STORE
            RARE ".ltorg\n");
}

/* --- the right side ------------------------------------------------------------------------------------- */

/* V'^T r' in r3:r2, r5:r4, r7:r6, row by row of V'. */
#define ROW_OF_V(multiply, r) \
    "ldr r11, [r0, #" r "]; ldm r1!, {r8, r9, r10}\n" \
    multiply " r2, r3, r8, r11; " multiply " r4, r5, r9, r11; " multiply " r6, r7, r10, r11\n"
#define LAST_ROW "stm r0, {r4-r11, lr}; ldr r1, [r0, #40]\n" \
    ROW_OF_V("smull", "208") ROW_OF_V("smlal", "212") ROW_OF_V("smlal", "216")

/* + P'' r'' */
#define ROW_BEFORE \
    "ldr r1, [r0, #44]; ldr lr, [r0, #220]; ldm r1, {r1, r8, r9, r10, r11, r12}\n" \
    "smlal r2, r3, r1, lr; smlal r4, r5, r8, lr; smlal r6, r7, r9, lr; ldrd r1, lr, [r0, #224]\n" \
    "smlal r2, r3, r8, r1; smlal r4, r5, r10, r1; smlal r6, r7, r11, r1\n" \
    "smlal r2, r3, r9, lr; smlal r4, r5, r11, lr; smlal r6, r7, r12, lr\n"

/* r = f + r' less that, in r2, r4, r6. The sums and r must be below 128 N in magnitude. */
#define FORCE \
    "ldr r1, [r0, #200]\n" ROUND29("r2", "r3") ROUND29("r4", "r5") ROUND29("r6", "r7") \
    "add r3, r3, #0x04000000; add r5, r5, #0x04000000; add r7, r7, #0x04000000; orr r3, r3, r5; orr r3, r3, r7\n" \
    "ldm r1, {r8, r9, r10}; ldrd r11, r12, [r0, #208]; ldr lr, [r0, #216]\n" \
    "qadd r8, r8, r11; qadd r9, r9, r12; qadd r10, r10, lr; qsub r2, r8, r2; qsub r4, r9, r4; qsub r6, r10, r6\n" \
    "add r1, r2, #0x20000000; add r5, r4, #0x20000000; add r7, r6, #0x20000000; orr r1, r1, r5; orr r1, r1, r7\n" \
    "lsr r3, r3, #27; orrs r3, r3, r1, lsr #30; bne 9f\n"

/* D^-1 r in r1, r3, r5 by a shift of 1 to 31 (r10; lr = 32 - r10). A component must fit 32 bits. */
#define PART(out, a, b, c) \
    PRODUCTS("r11", "r12", a, b, c, "r2", "r4", "r6") \
    "lsl " out ", r12, lr; lsrs r11, r11, r10; orr " out ", " out ", r11; asr r11, r12, r10\n" \
    "eor r11, r11, " out ", asr #31; adc " out ", " out ", #0; cmp r11, #0; bne 9f\n"
#define APPLY \
    "add r12, r0, #172; ldr lr, [r0, #232]; ldm r12, {r1, r3, r5, r7, r8, r9, r10}; sub r10, r10, lr\n" \
    "cmp r10, #32; bhs 1f; cmp r10, #0; beq 9f; rsb lr, r10, #32\n" \
    PART("r1", "r1", "r3", "r5") PART("r3", "r3", "r7", "r8") PART("r5", "r5", "r8", "r9")

/* Stores all, unless a component is above 62 mm. */
#define STORE_FORCE \
    "2: add r8, r1, #0x20000000; add r9, r3, #0x20000000; add r11, r5, #0x20000000\n" \
    "orr r8, r8, r9; orr r8, r8, r11; lsrs r8, r8, #30; bne 9f\n" \
    "ldr r12, [r0, #204]; ldrd r8, r9, [r0, #208]; ldr r11, [r0, #216]; stm r12, {r1, r3, r5}\n" \
    "strd r8, r9, [r0, #220]; str r11, [r0, #228]; strd r2, r4, [r0, #208]; str r6, [r0, #216]\n" \
    "ldm r0, {r4-r11, lr}; mov r0, #1; bx lr\n"

/* By a shift above 32, the high words are enough. */
#define PART_HIGH(out, a, b, c) \
    PRODUCTS("r11", "r12", a, b, c, "r2", "r4", "r6") "asrs r12, r12, r10; adc " out ", r12, #0\n"
#define APPLY_HIGH \
    "1: subs r10, r10, #32; beq 9f\n" \
    PART_HIGH("r1", "r1", "r3", "r5") PART_HIGH("r3", "r3", "r7", "r8") PART_HIGH("r5", "r5", "r8", "r9") "b 2b\n"

__attribute__((naked)) bool crn_row_usual_force(crn_row *row __attribute__((unused)))
{
    __asm__(".syntax unified\n" LAST_ROW ROW_BEFORE FORCE APPLY STORE_FORCE APPLY_HIGH
            "9: ldm r0, {r4-r11, lr}; mov r0, #0; bx lr\n");
}

/* --- the back substitution --------------------------------------------------------------------------------- */

/* A component of D^-1 r + delta[i+1] - V delta[i+1] - P delta[i+2]. r2 to r4 hold delta[i+1], r5 to r7 delta[i+2], and
 * p, p_second, p_third are the offsets of a row of P. A sum of 2^59 or more goes to label `far`, and a component above
 * 62 mm to label `over`. */
#define DEVIATION(v, v_third, p, p_second, p_third, solution, next, over, back, far) \
    "ldrd r10, r11, [r0, #" v "]; ldr lr, [r0, #" v_third "]; smull r8, r9, r10, r2; ldr r10, [r0, #" p "]\n" \
    "smlal r8, r9, r11, r3; ldr r11, [r0, #" p_second "]; smlal r8, r9, lr, r4; ldr lr, [r0, #" p_third "]\n" \
    "smlal r8, r9, r10, r5; ldr r10, [r0, #" solution "]; smlal r8, r9, r11, r6; add r10, r10, " next "\n" \
    "smlal r8, r9, lr, r7; add r11, r9, #0x08000000; lsrs r11, r11, #28; bne " far "\n" \
    ROUND29("r8", "r9") "qsub r10, r10, r8; ssat r11, #30, r10; cmp r11, r10; bne " over "\n" \
    back ": str r10, [r0, #" solution "]\n"
#define LIMIT(label, back) \
    label ": cmp r10, #0; it ge; movge r10, #0x20000000; it lt; movlt r10, #0xe0000000; b " back "\n"
#define RETURN(label, part) label ": lsl r0, r1, #2; add r0, r0, #" part "; ldm r12, {r4-r11, pc}\n"

__attribute__((naked)) uint32_t crn_row_substitute(crn_work *last __attribute__((unused)),
                                                   uint32_t count __attribute__((unused)),
                                                   uint32_t *saved __attribute__((unused)))
{
    __asm__(".syntax unified\n" "stm r2, {r4-r11, lr}; mov r12, r2; add r7, r0, #380\n"
            "ldrd r2, r3, [r0, #380]; ldr r4, [r0, #388]; ldr r5, [r7, #196]; ldr r6, [r7, #200]; ldr r7, [r7, #204]\n"
            "10:\n"
            DEVIATION("116", "124", "152", "156", "160", "184", "r2", "11f", "12", "21f")
            DEVIATION("128", "136", "156", "164", "168", "188", "r3", "13f", "14", "22f")
            DEVIATION("140", "148", "160", "168", "172", "192", "r4", "15f", "16", "23f")
            "mov r5, r2; mov r6, r3; mov r7, r4; ldrd r2, r3, [r0, #184]; ldr r4, [r0, #192]\n"
            "sub r0, r0, #196; subs r1, r1, #1; bne 10b\n"
            "mov r0, #0; ldm r12, {r4-r11, pc}\n"
            LIMIT("11", "12b") LIMIT("13", "14b") LIMIT("15", "16b")
            RETURN("21", "0") RETURN("22", "1") RETURN("23", "2"));
}

/* --- a sample of the lumen (lumen.c) ----------------------------------------------------------------------- */

/* As row_of(), for three rows: values in r9, r11, lr, and slopes in r10, r12, r8. r2 to r5 hold the weights and the
 * shift, and r6 the upper bytes. A row's steps stand between those of its neighbours, so that few of them wait. */
#define SUM_ROWS(first, second, third) \
    "ldr r7, [r1, #" first "]; ldr r11, [r1, #" second "]; ldr lr, [r1, #" third "]\n" \
    "lsl r7, r7, r5; lsl r11, r11, r5; and r8, r7, r6; and r7, r6, r7, lsl #8\n" \
    "smuad r9, r8, r2; lsl lr, lr, r5; smuad r10, r8, r3; and r8, r11, r6; smlatb r9, r7, r4, r9\n" \
    "and r12, r6, r11, lsl #8; smlatt r10, r7, r4, r10; and r7, lr, r6; smuad r11, r8, r2\n" \
    "and r5, r6, lr, lsl #8; smuad r8, r8, r3; smuad lr, r7, r2; smuad r7, r7, r3; smlatb r11, r12, r4, r11\n" \
    "smlatt r12, r12, r4, r8; smlatb lr, r5, r4, lr; smlatt r8, r5, r4, r7\n"
/* As plane_of(): value in r8, slopes along y and x in r9 and r10. */
#define SUM_PLANE(first, second, third) \
    "add r7, r0, #36; mov r6, #0xff00ff00; ldm r7, {r2-r5}\n" SUM_ROWS(first, second, third) \
    "add r7, r0, #56; ldm r7, {r2-r6}\n" \
    "smull r7, r10, r10, r2; smlal r7, r10, r12, r3; sub r12, r11, r9; smlal r7, r10, r8, r4\n" \
    "smull r7, r8, r9, r2; sub r9, lr, r11; smlal r7, r8, r11, r3; smlal r7, r8, lr, r4\n" \
    "smull r7, r11, r9, r6; smlal r7, r11, r12, r5; mov r9, r11\n"
/* Along z. */
#define SUM_PLANES \
    "add r7, r0, #76; ldm r7, {r2-r6}; ldr r11, [r0, #104]; ldr r12, [r0, #116]\n" \
    "smull r7, r11, r11, r2; smlal r7, r11, r12, r3; smlal r7, r11, r10, r4; str r11, [r0, #124]\n" \
    "ldr r10, [r0, #100]; ldr r12, [r0, #112]\n" \
    "smull r7, r10, r10, r2; smlal r7, r10, r12, r3; smlal r7, r10, r9, r4; str r10, [r0, #128]\n" \
    "ldr r9, [r0, #96]; ldr r12, [r0, #108]\n" \
    "smull r7, lr, r9, r2; smlal r7, lr, r12, r3; smlal r7, lr, r8, r4; str lr, [r0, #120]\n" \
    "sub r8, r8, r12; sub r12, r12, r9; smull r7, r9, r12, r5; smlal r7, r9, r8, r6; str r9, [r0, #132]\n"

__attribute__((naked)) void crn_lumen_sum_27(void *sum __attribute__((unused)))
{
    __asm__(".syntax unified\n" "stm r0, {r4-r11, lr}; ldr r1, [r0, #52]\n"
            SUM_PLANE("0", "10", "20") "strd r8, r9, [r0, #96]; str r10, [r0, #104]\n"
            SUM_PLANE("100", "110", "120") "strd r8, r9, [r0, #108]; str r10, [r0, #116]\n"
            SUM_PLANE("200", "210", "220") SUM_PLANES "ldm r0, {r4-r11, pc}\n");
}
/* clang-format on */

#endif
