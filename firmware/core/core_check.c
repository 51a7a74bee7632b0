/* This file checks the tools and the place of entry that the caller gives, before any constant is derived
 * from them. */
#include "firmware/core/balloon.h"

static bool in_range(uint32_t value, uint32_t low, uint32_t high)
{
    return value >= low && value <= high;
}

static bool curvature_in_range(int32_t per_m_milli)
{
    return per_m_milli >= -1000000 && per_m_milli <= 1000000;
}

static bool knot_in_range(const crn_knot *k)
{
    return in_range(k->bend_stiffness_nN_m2, 100, 30000000) &&
           in_range(k->twist_stiffness_nN_m2, 100, 30000000) && in_range(k->mass_mg_per_m, 500, 100000) &&
           in_range(k->radius_outer_um, 100, 2000) && k->radius_inner_um < k->radius_outer_um &&
           k->friction_static_milli <= 1000 && k->friction_kinetic_milli <= k->friction_static_milli &&
           curvature_in_range(k->rest_curvature1_per_m_milli) &&
           curvature_in_range(k->rest_curvature2_per_m_milli);
}

static bool material_in_range(const crn_material *m)
{
    if (m->kind == CRN_ELASTIC) {
        return (m->yield_strain_micro | m->core_modulus_MPa | m->hardening_milli | m->unload_milli |
                m->limit_milli) == 0;
    }
    const bool has_yield = in_range(m->yield_strain_micro, 500, 50000) &&
                           in_range(m->core_modulus_MPa, 1000, 300000) && m->hardening_milli <= 900;
    if (m->kind == CRN_PLASTIC) {
        return has_yield && m->unload_milli == 0 && m->limit_milli == 0;
    }
    return m->kind == CRN_SUPERELASTIC && has_yield && m->unload_milli <= 950 &&
           in_range(m->limit_milli, 100, 20000);
}

static crn_build_status check_knots(const crn_instrument *tool, crn_build_place *place)
{
    if (!in_range(tool->knot_count, 2, CRN_KNOT_MAX) || tool->knots[0].arc_um != 0) {
        return CRN_BUILD_KNOTS;
    }
    for (uint32_t i = 0; i < tool->knot_count; i++) {
        place->knot = i;
        if (!knot_in_range(&tool->knots[i])) {
            return CRN_BUILD_RANGE;
        }
        if (i > 0 && tool->knots[i].arc_um < tool->knots[i - 1].arc_um) {
            return CRN_BUILD_KNOTS;
        }
    }
    if (!in_range(tool->knots[tool->knot_count - 1].arc_um, CRN_TOOL_MIN_um, CRN_TOOL_MAX_um)) {
        return CRN_BUILD_LENGTH;
    }
    place->knot = 0;
    return CRN_BUILD_OK;
}

static crn_build_status check_tool(const crn_instrument *tool, crn_build_place *place)
{
    crn_build_status status = check_knots(tool, place);
    if (status != CRN_BUILD_OK) {
        return status;
    }
    if (!in_range(tool->axial_stiffness_max_N, 100, 10000) || tool->lumen_friction_milli > 1000) {
        return CRN_BUILD_RANGE;
    }
    if (!material_in_range(&tool->material)) {
        return CRN_BUILD_RANGE;
    }
    if (tool->whole_um > CRN_WHOLE_MAX_um || tool->rail_um > CRN_WHOLE_MAX_um) {
        return CRN_BUILD_RANGE;
    }
    if (!in_range(tool->element_tip_um, 200, CRN_ELEMENT_MAX_um) ||
        !in_range(tool->element_shaft_um, tool->element_tip_um, CRN_ELEMENT_MAX_um) ||
        tool->element_fine_um > CRN_TOOL_MAX_um) {
        return CRN_BUILD_ELEMENTS;
    }
    return crn_balloon_check(tool) ? CRN_BUILD_OK : CRN_BUILD_BALLOON;
}

/* Returns whether the thickest part of the tool `inner` fits through the narrowest part of the tool `outer`.
 * *knot receives the number of the knot (point of the table of properties) at which the outer tool is
 * narrowest. */
static bool fits_inside(const crn_instrument *inner, const crn_instrument *outer, uint32_t *knot)
{
    uint32_t thickest_um = 0;
    for (uint32_t i = 0; i < inner->knot_count; i++) {
        uint32_t radius_um = inner->knots[i].radius_outer_um;
        thickest_um = radius_um > thickest_um ? radius_um : thickest_um;
    }
    for (*knot = 0; *knot < outer->knot_count; (*knot)++) {
        if (outer->knots[*knot].radius_inner_um < thickest_um) {
            return false;
        }
    }
    return true;
}

crn_build_status crn_check_table(const crn_instrument *table, uint32_t table_count, crn_build_place *place)
{
    *place = (crn_build_place){0, 0};
    if (!in_range(table_count, 1, CRN_TABLE_MAX)) {
        return CRN_BUILD_TOOLS;
    }
    for (uint32_t i = 0; i < table_count; i++) {
        *place = (crn_build_place){i, 0};
        crn_build_status status = check_tool(&table[i], place);
        if (status != CRN_BUILD_OK) {
            return status;
        }
    }
    *place = (crn_build_place){0, 0};
    return CRN_BUILD_OK;
}

bool crn_line_numbers_are_valid(uint32_t table_count, const uint32_t *line, uint32_t line_count)
{
    uint32_t seen_bits = 0;
    for (uint32_t k = 0; k < line_count; k++) {
        if (line[k] > table_count || (line[k] != 0 && (seen_bits >> line[k] & 1u) != 0)) {
            return false;
        }
        seen_bits |= 1u << line[k];
    }
    return seen_bits > 1u;
}

crn_build_status crn_check_line(const crn_instrument *table, uint32_t table_count, const uint32_t *line,
                                uint32_t line_count, crn_build_place *place)
{
    *place = (crn_build_place){0, 0};
    if (!in_range(line_count, 1, CRN_TOOL_MAX) ||
        !crn_line_numbers_are_valid(table_count, line, line_count)) {
        return CRN_BUILD_TOOLS;
    }
    const crn_instrument *inner = NULL;
    bool has_balloon = false;
    for (uint32_t k = 0; k < line_count; k++) {
        if (line[k] == 0) {
            continue;
        }
        const crn_instrument *tool = &table[line[k] - 1];
        *place = (crn_build_place){line[k] - 1, 0};
        if (inner != NULL && !fits_inside(inner, tool, &place->knot)) {
            return CRN_BUILD_NESTING;
        }
        if (has_balloon && tool->balloon.point_count > 0) {
            return CRN_BUILD_BALLOON;
        }
        has_balloon |= tool->balloon.point_count > 0;
        inner = tool;
    }
    *place = (crn_build_place){0, 0};
    return CRN_BUILD_OK;
}

crn_build_status crn_check_entry(const crn_entry *entry)
{
    const int32_t limit_m_q30 = 2040109465; /* 1.9 m */
    int64_t square = 0;
    if (entry->blood_kg_m3 > 2000) {
        return CRN_BUILD_ENTRY;
    }
    for (int k = 0; k < 3; k++) {
        int32_t position = entry->position_m_q30.v[k];
        if (position > limit_m_q30 || position < -limit_m_q30) {
            return CRN_BUILD_ENTRY;
        }
        int64_t component = entry->direction_q30.v[k] >> 2;
        if (component > (1 << 28) + 4 || component < -(1 << 28) - 4) {
            return CRN_BUILD_ENTRY;
        }
        square += component * component;
    }
    int64_t error = square - ((int64_t)1 << 56);
    return (error > ((int64_t)1 << 37) || error < -((int64_t)1 << 37)) ? CRN_BUILD_ENTRY : CRN_BUILD_OK;
}
