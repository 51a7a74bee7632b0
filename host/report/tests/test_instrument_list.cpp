// Tests the list of instruments: it must hold every shipped file, as text, JSON and picture, and the
// documents must contain the same table.
#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <numbers>
#include <string>

#include "host/base/text.hpp"
#include "host/model/instrument.hpp"
#include "host/picture/session_pictures.hpp"
#include "host/report/instrument_list.hpp"
#include <nlohmann/json.hpp>

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

namespace
{

using crn::Instrument;
using crn::Stiffness;

const std::string folder = "shared/examples/instruments/";

void expect_near(const std::string &what, double got, double expected, double share)
{
    if (std::abs(got - expected) > share * std::abs(expected)) {
        fail_msg("%s = %.6g, expected %.6g within %.2g %%", what.c_str(), got, expected, share * 100);
    }
}

void expect_bend(const Instrument &instrument, double arc_mm, double expected_N_m2)
{
    expect_near(instrument.name + " EI at " + std::to_string(arc_mm) + " mm",
                crn::stiffness_at(instrument, Stiffness::bend, arc_mm * 1e-3), expected_N_m2, 0.01);
}

// The expected values are copied by hand from docs/instruments.md and its sources, so that they do not depend
// on the instrument files.
void the_shipped_instruments_have_the_documented_stiffness(void **)
{
    struct Expected {
        const char *file;
        double length_mm, outer_mm, inner_mm, tip_N_m2, shaft_N_m2, shaft_ratio;
    };
    const Expected all[] = {
        {"amplatz_super_stiff", 1450, 0.889, 0, 1e-5, 1.85e-3, 0.77},
        {"cook_straight", 1450, 0.889, 0, 1.5e-5, 2.9e-4, 0.77},
        {"bentson", 1450, 0.889, 0, 2e-6, 3e-4, 0.77},
        {"terumo_stiff_angled", 1500, 0.889, 0, 6e-6, 3.5e-4, 0.77},
        {"terumo_angled", 1500, 0.889, 0, 6e-6, 1.43e-4, 0.77},
        {"j_wire", 1450, 0.889, 0, 1.5e-5, 2.9e-4, 0.77},
        {"rosen", 1450, 0.889, 0, 2e-6, 4.0e-4, 0.77},
        {"beacon_5f", 1000, 1.67, 0.97, 1.01e-4, 5.07e-4, 1.5},
        {"terumo_4f", 1000, 1.40, 1.04, 3.93e-5, 1.57e-4, 1.5},
        {"terumo_5f", 1000, 1.70, 1.10, 1.01e-4, 4.06e-4, 1.5},
        {"coronary_014", 1600, 0.356, 0, 1e-7, 1.12e-4, 0.77},
        {"guide_jl3_6f", 1000, 2.08, 1.80, 1.21e-4, 7.65e-4, 1.5},
        {"guide_jl4_6f", 1000, 2.08, 1.80, 1.21e-4, 7.65e-4, 1.5},
        {"guide_jr4_6f", 1000, 2.08, 1.80, 1.21e-4, 7.65e-4, 1.5},
        {"guide_ntr_6f", 1000, 2.08, 1.80, 1.21e-4, 7.65e-4, 1.5},
        {"pigtail_5f", 1100, 1.67, 1.20, 8.4e-5, 4.2e-4, 1.5},
        {"simmons_2_5f", 1000, 1.67, 0.97, 1.01e-4, 5.07e-4, 1.5},
        {"balloon_3x20", 1350, 0.90, 0.42, 1.0145e-6, 4.6e-05, 0.71},
        {"balloon_6x20", 900, 1.66, 0.94, 8.3685e-6, 0.000502, 0.71},
    };
    for (const Expected &expected : all) {
        const Instrument one = crn::read_instrument(folder + expected.file + ".toml");
        const crn_wire_knot &hub = one.table.knots[one.table.knots_count - 1];
        expect_near(one.name + " length", one.length_m * 1e3, expected.length_mm, 1e-9);
        expect_near(one.name + " OD", hub.radius_outer_um * 2e-3, expected.outer_mm, 2e-3);
        expect_near(one.name + " ID", one.table.knots[one.table.knots_count - 1].radius_inner_um * 2e-3,
                    expected.inner_mm, 2e-3);
        expect_bend(one, 1, expected.tip_N_m2);
        expect_bend(one, 900, expected.shaft_N_m2);
        expect_near(one.name + " GJ", crn::stiffness_at(one, Stiffness::twist, 0.9),
                    expected.shaft_ratio * expected.shaft_N_m2, 0.01);
        assert_int_equal(one.table.knots[0].arc_um, 0);
        assert_int_equal(one.kind == crn::InstrumentKind::wire, expected.inner_mm == 0.0);
        assert_int_equal(one.table.lumen_friction_milli > 0, expected.inner_mm > 0.0);
    }
    assert_int_equal(crn::list_instruments({}, "").size(), std::size(all));
}

// The values of Table 5.1 of the thesis are copied by hand: Eb (1e7), radius (1e3), density (1e5), Kp (1e3).
void the_fits_hold_the_table_of_the_thesis(void **)
{
    struct Row {
        const char *file, *row;
        double modulus, radius, density, kp;
    };
    const Row rows[] = {
        {"amplatz_super_stiff", "Amplatz", 3.65, 8.9, 8.47, 1.63},
        {"cook_straight", "Cook Str.", 3.28, 6.5, 3.09, 39.9},
        {"bentson", "Bentson", 9.03, 7.5, 88.2, 4.05},
        {"terumo_stiff_angled", "Terumo Stiff", 5.45, 6.2, 15.0, 31.2},
        {"j_wire", "Cook J", 17.6, 6.8, 1.33, 10.2},
        {"rosen", "Rosen", 3.90, 6.7, 7.24, 37.7},
        {"beacon_5f", "Beacon 5FR", 3.53, 7.4, 36.5, 30.2},
        {"terumo_4f", "Terumo ST4F", 3.66, 6.2, 1.80, 8.92},
        {"terumo_5f", "Terumo ST5F", 3.54, 6.3, 11.4, 31.7},
    };
    for (const Row &row : rows) {
        const Instrument base = crn::read_instrument(folder + row.file + ".toml");
        const Instrument fit = crn::read_instrument(folder + row.file + ".toml:vcsim3-fit");
        assert_true(fit.thesis.has_value());
        assert_string_equal(fit.thesis->row.c_str(), row.row);
        expect_near("Eb", fit.thesis->young_modulus, row.modulus * 1e7, 1e-9);
        expect_near("radius", fit.thesis->radius_m, row.radius * 1e-4, 1e-9);
        expect_near("density", fit.thesis->density, row.density * 1e5, 1e-9);
        expect_near("Kp", fit.thesis->kp, row.kp * 1e3, 1e-9);
        const double bend = row.modulus * 1e7 * std::numbers::pi / 4.0 * std::pow(row.radius * 1e-4, 4);
        expect_bend(fit, 900, bend);
        expect_bend(fit, 1,
                    std::max(1e-7, bend * crn::stiffness_at(base, Stiffness::bend, 1e-3) /
                                       crn::stiffness_at(base, Stiffness::bend, 0.9)));
        assert_int_equal(fit.table.knots[0].radius_outer_um, std::lround(row.radius * 100));
        assert_true(crn::stiffness_at(fit, Stiffness::bend, 0.9) <
                    0.2 * crn::stiffness_at(base, Stiffness::bend, 0.9));
        assert_string_equal(fit.name.c_str(), (base.name + " (vcsim3-fit)").c_str());
        assert_int_equal(fit.table.knots[0].rest_curvature1_per_m_milli,
                         base.table.knots[0].rest_curvature1_per_m_milli);
    }
    assert_int_equal(crn::list_instruments({}, "vcsim3-fit").size(), std::size(rows));
}

// Half-way along a taper the stiffness is the geometric mean of the stiffnesses at its two ends.
void tapers_change_by_equal_ratios(void **)
{
    expect_bend(crn::read_instrument(folder + "bentson.toml"), 250, 2.449e-5);
}

void every_shipped_material_is_known_to_the_xray(void **)
{
    for (const crn::ListedInstrument &item : crn::list_instruments({}, "")) {
        assert_true(crn::instrument_look(item.instrument).sections.size() == item.instrument.layers.size());
        assert_true(item.instrument.layers.size() >= 3);
        for (const Instrument &other : item.others) {
            assert_true(crn::instrument_look(other).sections.size() == item.instrument.layers.size());
        }
    }
}

void the_document_has_the_table_of_the_files(void **)
{
    const std::string text = crn::read_text_file("docs/instruments.md");
    const std::size_t begin = text.find(crn::table_begin), end = text.find(crn::table_end);
    assert_true(begin != std::string::npos && end != std::string::npos);
    const std::string table =
        text.substr(begin + crn::table_begin.size(), end - begin - crn::table_begin.size());
    if (table != crn::instruments_markdown(crn::list_instruments({}, ""))) {
        fail_msg("the table in docs/instruments.md is not that of the files: run `make docs`");
    }
}

void a_list_has_text_json_and_picture(void **)
{
    const auto list =
        crn::list_instruments({folder + "j_wire.toml", folder + "beacon_5f.toml:vcsim3-fit"}, "");
    assert_int_equal(list.size(), 2);
    const std::string text = crn::instruments_text(list);
    assert_true(text.find("\nj_wire     Cook J 0.035 in, 3 mm ") != std::string::npos);
    assert_true(text.find("5F Beacon, Kumpe (vcsim3-fit)") != std::string::npos);
    const nlohmann::json json = nlohmann::json::parse(crn::instruments_json(list));
    assert_int_equal(json.size(), 2);
    expect_near("JSON EI", json[0]["bend_stiffness_shaft_N_m2"].get<double>(), 2.9e-4, 1e-3);
    assert_string_equal(json[1]["table_5_1"]["row"].get<std::string>().c_str(), "Beacon 5FR");
    assert_false(json[0].contains("material"));
    const crn::Image one = crn::instruments_picture({list[0]}), two = crn::instruments_picture(list);
    assert_true(two.height > one.height && two.width == one.width);
    // Every row of the picture must contain dark pixels, so that no row is empty.
    auto dark = [](const crn::Image &image) {
        return std::count_if(image.bytes.begin(), image.bytes.end(),
                             [](std::uint8_t byte) { return byte < 100; });
    };
    assert_true(dark(one) > 3000 && dark(two) > dark(one) + 3000);
}

// The wire's core begins to transform at 500 MPa / 55 GPa; docs/instruments.md has the factors 1.39 and 1.2.
void only_the_superelastic_wire_has_a_material(void **)
{
    for (const auto &item : crn::list_instruments({}, ""))
        assert_int_equal(item.instrument.table.material_kind != CRN_WIRE_MATERIAL_ELASTIC,
                         item.file.find("/terumo_angled.toml") != std::string::npos);
    const auto list = crn::list_instruments({folder + "terumo_angled.toml"}, "");
    const nlohmann::json material = nlohmann::json::parse(crn::instruments_json(list))[0]["material"];
    assert_string_equal(material["kind"].get<std::string>().c_str(), "superelastic");
    expect_near("strain", material["yield_strain"].get<double>(), 1.39 * 500 / 55e3, 1e-3);
    expect_near("modulus", material["young_modulus_GPa"].get<double>(), 55, 1e-9);
    expect_near("unload", material["unload"].get<double>(), 0.4, 1e-9);
    expect_near("limit", material["limit"].get<double>(), 1.2 * 0.05 / (1.39 * 500 / 55e3), 1e-3);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(the_shipped_instruments_have_the_documented_stiffness),
        cmocka_unit_test(the_fits_hold_the_table_of_the_thesis),
        cmocka_unit_test(tapers_change_by_equal_ratios),
        cmocka_unit_test(every_shipped_material_is_known_to_the_xray),
        cmocka_unit_test(the_document_has_the_table_of_the_files),
        cmocka_unit_test(a_list_has_text_json_and_picture),
        cmocka_unit_test(only_the_superelastic_wire_has_a_material),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
