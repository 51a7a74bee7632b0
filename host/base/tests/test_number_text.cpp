// These tests check the following. For numbers of every size and in every locale, the conversion gives the
// same bytes as printf.
#include "host/base/format.hpp"
#include "host/base/number_text.hpp"

#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <locale>
#include <random>
extern "C" {
#include <cmocka.h>
}

namespace
{

void same(const std::string &got, const std::string &wanted)
{
    assert_string_equal(got.c_str(), wanted.c_str());
}

void compare(double value)
{
    for (int digits = 1; digits <= 17; ++digits) {
        same(crn::number_text(value, digits), crn::formatted("%.*g", digits, value));
        same(crn::decimals_text(value, digits - 1), crn::formatted("%.*f", digits - 1, value));
    }
    same(crn::number_text(value), crn::formatted("%g", value));
}

void numbers_of_every_size_are_as_by_printf(void **)
{
    for (const double value : {0.0, -0.0, 0.5, 1.5, 2.5, 1e6, 999999.5, 1e-5, 123456789.0, -1e300, 5e-324})
        compare(value);
    for (const double value : {std::numeric_limits<double>::max(), std::numeric_limits<double>::infinity(),
                               -std::numeric_limits<double>::infinity()})
        compare(value);
    std::mt19937_64 random(7);
    for (int n = 0; n < 3000; ++n) {
        const std::uint64_t bits = random();
        double value;
        std::memcpy(&value, &bits, sizeof value);
        if (!std::isnan(value)) compare(value);
        compare(std::ldexp(static_cast<double>(bits % 2000001) - 1e6, -static_cast<int>(bits % 30)));
    }
}

void decimals_lose_the_zeros_at_their_end(void **)
{
    same(crn::trimmed_text(1.25, 6), "1.25");
    same(crn::trimmed_text(100, 6), "100");
    same(crn::trimmed_text(100, 0), "100");
    same(crn::trimmed_text(-1e-9, 6), "0");
    same(crn::trimmed_text(-0.5, 6), "-0.5");
    same(crn::trimmed_text(0.0000004, 6), "0");
}

void hashes_have_leading_zeros(void **)
{
    same(crn::hex_text(0x123abc), "0000000000123abc");
    same(crn::hex_text(~std::uint64_t{0}), "ffffffffffffffff");
    same(crn::hex_text(0xab, 4), "00ab");
    same(crn::hex_text(0xabcde, 4), "abcde");
}

struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
};

void a_locale_with_a_comma_changes_nothing(void **)
{
    const std::locale before = std::locale::global(std::locale(std::locale(), new Comma));
    const std::string number = crn::number_text(1.5), decimals = crn::decimals_text(1.5, 2);
    std::locale::global(before);
    same(number, "1.5");
    same(decimals, "1.50");
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(numbers_of_every_size_are_as_by_printf),
        cmocka_unit_test(decimals_lose_the_zeros_at_their_end),
        cmocka_unit_test(hashes_have_leading_zeros),
        cmocka_unit_test(a_locale_with_a_comma_changes_nothing),
    };
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
