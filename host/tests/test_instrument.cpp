// Claims: instrument files give the numbers they state; a file that is wrong is refused with file, line and key.
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <unistd.h>

#include "host/app/session_pictures.hpp"
#include "host/model/instrument.hpp"
#include "host/model/text.hpp"

// Last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

namespace
{

const std::string folder = "shared/examples/instruments/";

std::string temporary(const std::string &text)
{
    const std::string path = "/tmp/seldinger_test_" + std::to_string(getpid()) + ".toml";
    std::ofstream(path) << text;
    return path;
}

// The shipped Bentson file with one piece replaced.
void expect_error(const std::string &old_piece, const std::string &new_piece, const std::string &expected)
{
    std::string text = seld::read_text_file(folder + "bentson.toml");
    const std::size_t place = text.find(old_piece);
    assert_true(place != std::string::npos);
    text.replace(place, old_piece.size(), new_piece);
    const std::string path = temporary(text);
    std::string message;
    try {
        seld::read_instrument(path);
    } catch (const seld::FileError &error) {
        message = error.what();
    }
    std::remove(path.c_str());
    if (message.find(expected) == std::string::npos || message.rfind(path, 0) != 0) {
        fail_msg("message '%s' does not begin with the file and hold '%s'", message.c_str(),
                 expected.c_str());
    }
}

// EI in nN m^2 at an arc length, by the linear rule of the core.
double bend_at(const seld::Instrument &instrument, double arc_mm)
{
    const seld_wire_instrument &table = instrument.table;
    for (int i = 1; i < table.knots_count; i++) {
        const seld_wire_knot &a = table.knots[i - 1], &b = table.knots[i];
        if (arc_mm * 1e3 > b.arc_um || a.arc_um == b.arc_um) continue;
        const double u = (arc_mm * 1e3 - a.arc_um) / (b.arc_um - a.arc_um);
        return a.bend_stiffness_nN_m2 +
               u * (static_cast<double>(b.bend_stiffness_nN_m2) - a.bend_stiffness_nN_m2);
    }
    return 0.0;
}

void expect_bend(const seld::Instrument &instrument, double arc_mm, double expected_N_m2)
{
    const double got = bend_at(instrument, arc_mm) * 1e-9;
    if (got < 0.99 * expected_N_m2 || got > 1.01 * expected_N_m2) {
        fail_msg("%s at %.0f mm: EI = %.3e, expected %.3e N m^2 within 1 %%", instrument.name.c_str(), arc_mm,
                 got, expected_N_m2);
    }
}

// Figures of docs/instruments.md, written here a second time.
void the_shipped_wires_have_the_documented_stiffness(void **)
{
    const seld::Instrument bentson = seld::read_instrument(folder + "bentson.toml");
    expect_bend(bentson, 5, 2e-6);
    expect_bend(bentson, 149, 2e-6);
    expect_bend(bentson, 600, 3e-4);
    const seld::Instrument stiff = seld::read_instrument(folder + "amplatz_super_stiff.toml");
    expect_bend(stiff, 600, 1.85e-3);
    const seld::Instrument j_wire = seld::read_instrument(folder + "j_wire.toml");
    expect_bend(j_wire, 20, 1.5e-5);
    assert_int_equal(j_wire.table.knots[0].rest_curvature1_per_m_milli, 333300);
    for (const seld::Instrument &instrument : {bentson, stiff, j_wire}) {
        assert_int_equal(instrument.table.knots[0].arc_um, 0);
        assert_int_equal(instrument.table.knots[0].radius_outer_um, 445);
        assert_true(instrument.length_m >= 0.9);
    }
}

// Half way along a taper from a to b stands their geometric mean.
void tapers_change_by_equal_ratios(void **)
{
    const seld::Instrument bentson = seld::read_instrument(folder + "bentson.toml");
    expect_bend(bentson, 250, 2.449e-5);
}

void every_shipped_material_is_known_to_the_xray(void **)
{
    for (const char *name : {"bentson.toml", "amplatz_super_stiff.toml", "j_wire.toml"}) {
        const seld::Instrument instrument = seld::read_instrument(folder + name);
        assert_true(seld::instrument_look(instrument).sections.size() == instrument.layers.size());
        assert_true(instrument.layers.size() >= 3);
    }
}

void a_value_without_source_is_refused(void **)
{
    expect_error("mass_kg_per_m = { value = 0.0039, source = \"",
                 "mass_kg_per_m = { value = 0.0039, sauce = \"",
                 "unknown key 'sauce', did you mean 'source'?");
    expect_error("tip_mm = { value = 1.0, source = ", "tip_mm = 1.0 # ",
                 "'tip_mm' must be { value = ..., source");
}

void wrong_values_are_refused_with_their_place(void **)
{
    expect_error("bend_stiffness_N_m2 = { value = 2e-06", "bend_stiffness_N_m2 = { value = 2e-9",
                 "section 1 'marked tip': 'bend_stiffness_N_m2' = 2e-09 is outside 1e-07 .. 0.03");
    expect_error("bend_stiffness_N_m2 = { value = 2e-06", "bend_stiffness_N_m2 = { value = nan",
                 "is not a finite number");
    expect_error("from_mm = 30", "from_mm = 31", "leaves a gap or overlap");
    expect_error("to_mm = 30", "to_mm = -1", "'to_mm' = -1 is outside");
    expect_error("steps = 10", "steps = 17", "'steps' = 17 is outside 1 .. 16");
    expect_error("friction_static = { value = 0.12", "friction_static = { value = 0.05",
                 "'friction_static' is below 'friction_kinetic'");
    expect_error("format = 1", "format = 2", "'format' must be 1");
    expect_error("name = \"Bentson 0.035 in\"", "name = 7", "'name' is not a text");
    expect_error("radius_outer_mm", "radius_mm", "unknown key 'radius_mm'");
}

void broken_toml_is_refused_with_line_and_column(void **)
{
    expect_error("[elements]", "[elements", ":6:");
    expect_error("[[section]]", "[[section]] x", "");
}

void missing_files_and_folders_are_refused(void **)
{
    for (const char *path : {"does/not/exist.toml", "shared"}) {
        bool is_refused = false;
        try {
            seld::read_instrument(path);
        } catch (const seld::FileError &) {
            is_refused = true;
        }
        assert_true(is_refused);
    }
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(the_shipped_wires_have_the_documented_stiffness),
        cmocka_unit_test(tapers_change_by_equal_ratios),
        cmocka_unit_test(every_shipped_material_is_known_to_the_xray),
        cmocka_unit_test(a_value_without_source_is_refused),
        cmocka_unit_test(wrong_values_are_refused_with_their_place),
        cmocka_unit_test(broken_toml_is_refused_with_line_and_column),
        cmocka_unit_test(missing_files_and_folders_are_refused),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
