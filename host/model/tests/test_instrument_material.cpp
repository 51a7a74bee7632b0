// These tests check the material of an instrument file (docs/instruments.md, "Materials"): what the table
// [material] of a file becomes in the message `instrument`, and how well the law of this message describes a
// round core. The independent reference for the law divides the cross-section into fibres, each of which
// follows the stress-strain curve of the file.
#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <numbers>
#include <string>
#include <unistd.h>
#include <vector>

#include "host/base/text.hpp"
#include "host/model/instrument.hpp"

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

namespace
{

using crn::Instrument;

constexpr double pi = std::numbers::pi;
const std::string instruments = "shared/examples/instruments/";

// The material that the tests put into a file.
constexpr double modulus_GPa = 55, upper_MPa = 495, lower_MPa = 198, plateau = 0.05, steel_GPa = 190,
                 steel_yield_MPa = 1900;
constexpr double strain = upper_MPa / modulus_GPa / 1e3; // at the beginning of the plateau: 0.9 %
const std::string nitinol = "[material]\nkind = \"nitinol\"\n"
                            "young_modulus_GPa = { value = 55, source = \"x\" }\n"
                            "upper_plateau_MPa = { value = 495, source = \"x\" }\n"
                            "lower_plateau_MPa = { value = 198, source = \"x\" }\n"
                            "plateau_strain = { value = 0.05, source = \"x\" }\n\n";
const std::string steel =
    "[material]\nkind = \"steel\"\nyoung_modulus_GPa = { value = 190, source = \"x\" }\n"
    "yield_MPa = { value = 1900, source = \"x\" }\n\n";

std::string with_replaced(std::string text, const std::string &old_piece, const std::string &new_piece)
{
    const std::size_t place = text.find(old_piece);
    if (place == std::string::npos) fail_msg("the file does not hold '%s'", old_piece.c_str());
    return text.replace(place, old_piece.size(), new_piece);
}

std::string with_material(const std::string &file, const std::string &material)
{
    return with_replaced(crn::read_text_file(instruments + file), "[elements]\n", material + "[elements]\n");
}

Instrument instrument_of(const std::string &text, const std::string &preset = "")
{
    const std::string file_path = "/tmp/cournand_test_" + std::to_string(getpid()) + ".toml";
    std::ofstream(file_path) << text;
    try {
        const Instrument instrument = crn::read_instrument(file_path + preset);
        std::remove(file_path.c_str());
        return instrument;
    } catch (const crn::FileError &) {
        std::remove(file_path.c_str());
        throw;
    }
}

void expect_refused(const std::string &text, const std::string &expected)
{
    try {
        instrument_of(text);
    } catch (const crn::FileError &error) {
        const std::string message = error.what();
        const bool has_line = message.find(".toml:") != std::string::npos;
        if (!has_line || message.find(expected) == std::string::npos)
            fail_msg("message '%s' does not hold a line and '%s'", message.c_str(), expected.c_str());
        return;
    }
    fail_msg("accepted, instead of: %s", expected.c_str());
}

void expect_within(const char *what, double got, double expected, double tolerance)
{
    if (!(std::abs(got - expected) <= tolerance))
        fail_msg("%s = %.6g, expected %.6g within %.2g", what, got, expected, tolerance);
}

// --- the reference: a round core of fibres
// -------------------------------------------------------------------

// Follows a round core while its curvature changes. Curvatures are multiples of the curvature at which the
// surface of the core yields, and moments are multiples of the moment at that curvature. `plateau_length` is
// the length of the plateau, as a multiple of the strain at its beginning.
class FibreCore
{
  public:
    FibreCore(bool is_superelastic, double plateau_length, double lower)
        : is_superelastic_(is_superelastic), plateau_length_(plateau_length), lower_(lower),
          kept_(fibres, 0.0)
    {
    }

    double moment_at(double curvature)
    {
        double moment = 0.0;
        for (std::size_t i = 0; i < fibres; i++) {
            const double y = (static_cast<double>(i) + 0.5) / fibres, fibre_strain = curvature * y;
            // On the way out, the stress is at most 1. On the way back, a superelastic fibre follows its
            // lower plateau, and a metal yields at -1.
            const double least = fibre_strain - 1.0, most = fibre_strain - (is_superelastic_ ? lower_ : -1.0);
            kept_[i] = std::clamp(kept_[i], least, most);
            if (is_superelastic_) kept_[i] = std::clamp(kept_[i], 0.0, plateau_length_);
            const double width = 2.0 * std::sqrt(1.0 - y * y), area_moment = pi / 4.0;
            moment += 2.0 * (fibre_strain - kept_[i]) * y * width / fibres / area_moment;
        }
        return moment;
    }

  private:
    static constexpr std::size_t fibres = 2000; // of one half; the other half has the opposite strain
    bool is_superelastic_;
    double plateau_length_, lower_;
    std::vector<double> kept_; // strain that is not elastic
};

// The law of the core (firmware/core/rod_set.c), from the values of a message, in the units of FibreCore.
class StraightLaw
{
  public:
    StraightLaw(const Instrument &instrument, double yield_strain)
        : superelastic_(instrument.table.material_kind == 2),
          begin_(instrument.table.yield_strain_micro * 1e-6 / yield_strain),
          slope_(instrument.table.hardening_milli / (1000.0 - instrument.table.hardening_milli)),
          unload_(superelastic_ ? instrument.table.unload_milli * 1e-3 : -1.0),
          limit_(instrument.table.limit_milli * 1e-3)
    {
    }

    double moment_at(double curvature)
    {
        const double least = (curvature - begin_) / (1.0 + slope_),
                     most = (curvature - unload_ * begin_) / (1.0 + slope_);
        set_ = std::clamp(set_, least, most);
        if (superelastic_) set_ = std::clamp(set_, 0.0, limit_ * begin_);
        return curvature - set_;
    }

  private:
    bool superelastic_;
    double begin_, slope_, unload_, limit_, set_ = 0.0;
};

struct Errors {
    double out = 0.0, back = 0.0; // largest, as a part of the moment at which the surface yields
    double loop_share = 0.0;      // of the energy that the bend takes, law over reference, - 1
};

Errors compare(FibreCore core, StraightLaw law, double largest)
{
    Errors errors;
    constexpr int steps = 400;
    double core_energy = 0.0, law_energy = 0.0, last_core = 0.0, last_law = 0.0;
    for (int i = 1; i <= 2 * steps; i++) {
        const double curvature = largest * (i <= steps ? i : 2 * steps - i) / steps;
        const double core_moment = core.moment_at(curvature), law_moment = law.moment_at(curvature);
        double &worst = i <= steps ? errors.out : errors.back;
        worst = std::max(worst, std::abs(core_moment - law_moment));
        const double step = i <= steps ? largest / steps : -largest / steps;
        core_energy += 0.5 * (core_moment + last_core) * step;
        law_energy += 0.5 * (law_moment + last_law) * step;
        last_core = core_moment;
        last_law = law_moment;
    }
    errors.loop_share = law_energy / core_energy - 1.0;
    return errors;
}

// --- the tests --------------------------------------------------------------------------------------------

// A core whose fibres all yield has the moment 16/(3 pi) M_y; up to the yield of its surface, it is elastic.
void the_reference_has_the_known_moments(void **)
{
    FibreCore metal(false, 0.0, 0.0);
    expect_within("elastic moment", metal.moment_at(0.9), 0.9, 1e-5);
    expect_within("plastic moment", metal.moment_at(1e4), 16.0 / (3.0 * pi), 1e-4);
    // a fully plastic core that is released keeps this curvature: the moment of the release is elastic
    expect_within("moment after the release", metal.moment_at(1e4 - 16.0 / (3.0 * pi)), 0.0, 1e-4);
    FibreCore stiff(true, 5.0, 0.4);
    expect_within("moment on the plateau", stiff.moment_at(6.0), 16.0 / (3.0 * pi), 0.03);
    expect_within("moment after the way back", stiff.moment_at(0.4), 0.4, 1e-5);
}

void nitinol_becomes_the_law_of_a_round_core(void **)
{
    const Instrument wire = instrument_of(with_material("terumo_stiff_angled.toml", nitinol));
    assert_int_equal(wire.table.material_kind, CRN_WIRE_MATERIAL_SUPERELASTIC);
    assert_int_equal(wire.table.core_modulus_MPa, 55000);
    assert_int_equal(wire.table.yield_strain_micro,
                     std::lround(1.39e6 * strain)); // 1.39: of the straight law
    assert_int_equal(wire.table.unload_milli, 400);
    const FibreCore core(true, plateau / strain, lower_MPa / upper_MPa);
    const StraightLaw law(wire, strain);
    struct Case {
        double surface_strain, out, back, loop; // the bars are three times the errors
    };
    // the last case lies beyond the plateau of the surface, which ends at 5.9 %
    for (const Case &one : {Case{0.02, 0.29, 0.41, 0.57}, Case{0.04, 0.29, 0.29, 0.15},
                            Case{0.059, 0.3, 0.48, 0.36}, Case{0.077, 0.42, 0.83, 0.33}}) {
        const Errors errors = compare(core, law, one.surface_strain / strain);
        print_message("# nitinol to %.1f %%: out %.3f, back %.3f M_y, loop %+.0f %%\n",
                      100 * one.surface_strain, errors.out, errors.back, 100 * errors.loop_share);
        expect_within("error on the way out", errors.out, 0, one.out);
        expect_within("error on the way back", errors.back, 0, one.back);
        expect_within("error of the loop", errors.loop_share, 0, one.loop);
    }
}

void steel_becomes_the_law_of_a_round_core(void **)
{
    const Instrument wire = instrument_of(with_material("coronary_014.toml", steel));
    assert_int_equal(wire.table.material_kind, CRN_WIRE_MATERIAL_METAL);
    assert_int_equal(wire.table.core_modulus_MPa, 190000);
    assert_int_equal(wire.table.unload_milli + wire.table.limit_milli, 0);
    const double steel_strain = steel_yield_MPa / steel_GPa / 1e3;
    // On the way back, some fibres of a released round core yield already, and the straight law does not.
    struct Case {
        double largest, out, back, loop;
    };
    for (const Case &one : {Case{2, 0.29, 0.18, 0.48}, Case{3, 0.29, 0.85, 0.3}, Case{5, 0.29, 0.58, 0.1}}) {
        const Errors errors =
            compare(FibreCore(false, 0.0, 0.0), StraightLaw(wire, steel_strain), one.largest);
        print_message("# steel to %.0f of the yield curvature: out %.3f, back %.3f M_y, loop %+.0f %%\n",
                      one.largest, errors.out, errors.back, 100 * errors.loop_share);
        expect_within("error on the way out", errors.out, 0, one.out);
        expect_within("error on the way back", errors.back, 0, one.back);
        expect_within("error of the loop", errors.loop_share, 0, one.loop);
    }
}

// A material changes only the values of the material. A file without a material has none, and neither has a
// preset that was made from the thesis, whose rod is elastic.
void only_a_file_with_a_material_yields(void **)
{
    const std::string file = "terumo_stiff_angled.toml";
    const std::string text = with_material(file, nitinol);
    const Instrument elastic = crn::read_instrument(instruments + file),
                     fitted = instrument_of(text, ":vcsim3-fit");
    Instrument wire = instrument_of(text);
    for (const Instrument *one : {&elastic, &fitted}) {
        assert_int_equal(one->table.material_kind, CRN_WIRE_MATERIAL_ELASTIC);
        assert_int_equal(one->table.yield_strain_micro + one->table.core_modulus_MPa, 0);
        assert_int_equal(one->table.hardening_milli + one->table.unload_milli + one->table.limit_milli, 0);
    }
    wire.table.material_kind = CRN_WIRE_MATERIAL_ELASTIC;
    wire.table.yield_strain_micro = wire.table.core_modulus_MPa = 0;
    wire.table.hardening_milli = wire.table.unload_milli = wire.table.limit_milli = 0;
    std::vector<std::uint8_t> bytes[2];
    const Instrument *const both[] = {&elastic, &wire};
    for (int k = 0; k < 2; k++) {
        bytes[k].resize(CRN_WIRE_BYTES_instrument);
        crn_wire_writer writer = crn_wire_writer_make(bytes[k].data(), bytes[k].size());
        assert_true(crn_wire_put_instrument(&writer, &both[k]->table));
        bytes[k].resize(writer.length);
    }
    assert_true(bytes[0] == bytes[1]);
}

void wrong_materials_are_refused_with_their_place(void **)
{
    const auto expect = [](const std::string &old_piece, const std::string &new_piece,
                           const std::string &expected) {
        expect_refused(
            with_replaced(with_material("terumo_stiff_angled.toml", nitinol), old_piece, new_piece),
            expected);
    };
    expect("kind = \"nitinol\"", "kind = \"nitinl\"",
           "material: 'kind' is 'nitinl', did you mean 'nitinol'?");
    expect("kind = \"nitinol\"\n", "", "material: 'kind' is missing");
    expect("young_modulus_GPa = { value = 55, source", "young_modulus_GPa = { value = 55, sauce",
           "unknown key 'sauce', did you mean 'source'?");
    expect("young_modulus_GPa = { value = 55", "young_modulus_GPa = { value = 5",
           "'young_modulus_GPa' = 5 is outside 20 .. 90");
    expect("lower_plateau_MPa = { value = 198", "lower_plateau_MPa = { value = 480",
           "'lower_plateau_MPa' = 480 is outside 0 .. 470.25");
    expect("upper_plateau_MPa", "plateau_MPa", "material: unknown key 'plateau_MPa'");
    expect("plateau_strain = { value = 0.05", "plateau_strain = { value = nan", "is not a finite number");
    expect("plateau_strain = { value = 0.05", "plateau_strain = { value = 5", "outside 0.005 .. 0.1");
    expect("plateau_strain = { value = 0.05, source = \"x\" }\n", "",
           "material: 'plateau_strain' is missing");
    expect("kind = \"nitinol\"", "kind = \"steel\"", "material: unknown key 'lower_plateau_MPa'");
    expect("upper_plateau_MPa = { value = 495", "upper_plateau_MPa = { value = 100",
           "'lower_plateau_MPa' = 198 is outside 0 .. 95");
    const std::string elastic = crn::read_text_file(instruments + "terumo_stiff_angled.toml");
    expect_refused(with_replaced(elastic, "name = ", "material = 3\nname = "),
                   "'material' must be a table: [material]");
}

// The core's radius follows from EI and Young's modulus, so a low modulus would make it thicker than the
// wire: 2 (4 EI / (pi E))^(1/4) = 0.950 mm for 1.1974e-3 N m^2 at 30 GPa.
void materials_without_a_possible_core_are_refused(void **)
{
    const std::string text =
        with_material("amplatz_super_stiff.toml", with_replaced(nitinol, "{ value = 55,", "{ value = 30,"));
    expect_refused(
        text, "material: 'young_modulus_GPa' is too low: a round core with the bending stiffness 0.0011974 "
              "N m^2, at 213.333 mm from the tip, would be 0.95 mm thick in a wire of 0.89 mm");
    expect_refused(with_material("beacon_5f.toml", nitinol), "'material' is for wires");
}

// The values of a material may be possible one by one, but not together.
void contradicting_materials_are_refused(void **)
{
    const std::string file = "terumo_stiff_angled.toml";
    const std::string early =
        with_replaced(with_replaced(with_replaced(nitinol, "{ value = 495", "{ value = 200"), "{ value = 198",
                                    "{ value = 100"),
                      "{ value = 55,", "{ value = 80,");
    expect_refused(
        with_material(file, with_replaced(early, "{ value = 0.05", "{ value = 0.1")),
        "material: 'plateau_strain' must be 0.00029 to 0.058, where the plateau begins at a strain "
        "of 0.0025");
    const std::string late = with_replaced(with_replaced(steel, "{ value = 1900", "{ value = 4000"),
                                           "{ value = 190,", "{ value = 20,");
    expect_refused(
        with_material(file, late),
        "material: 'yield_MPa' and 'young_modulus_GPa' make a yield strain of 0.2, outside 0.00036 .. 0.036");
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(the_reference_has_the_known_moments),
        cmocka_unit_test(nitinol_becomes_the_law_of_a_round_core),
        cmocka_unit_test(steel_becomes_the_law_of_a_round_core),
        cmocka_unit_test(only_a_file_with_a_material_yields),
        cmocka_unit_test(wrong_materials_are_refused_with_their_place),
        cmocka_unit_test(materials_without_a_possible_core_are_refused),
        cmocka_unit_test(contradicting_materials_are_refused),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
