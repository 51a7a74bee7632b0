// All code of the host converts numbers to text by the functions of this header. Each function gives the
// bytes that printf gives in the locale "C", with a point as the decimal mark in every locale. The function
// formatted() of format.hpp makes whole sentences with numbers.
#pragma once
#include "host/base/format.hpp"
#include <cstdint>
#include <string>

namespace crn
{

std::string number_text(double value, int digits = 6); // significant digits, as %.*g does
std::string decimals_text(double value, int decimals); // as %.*f does
std::string trimmed_text(double value, int decimals); // without zeros at the end of the decimals; "-0" is "0"
std::string hex_text(std::uint64_t value, int digits = 16); // with leading zeros, as %016llx does

} // namespace crn
