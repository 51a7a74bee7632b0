// Defines the allowed values of a stent's numbers, and computes the lengths that follow from the stent's
// geometry.
#include "host/stent/design.hpp"
#include "host/base/number_text.hpp"
#include <algorithm>
#include <cmath>
#include <numbers>

namespace crn
{

namespace
{

constexpr StentNumber numbers[] = {
    {"diameter_mm", &StentDesign::diameter_mm, 1.5, 14},
    {"diameter_max_mm", &StentDesign::diameter_max_mm, 1.5, 20},
    {"crimped_diameter_mm", &StentDesign::crimped_diameter_mm, 0.5, 4},
    {"length_mm", &StentDesign::length_mm, 4, 80},
    {"strut_length_mm", &StentDesign::strut_length_mm, 0.4, 6},
    {"strut_width_mm", &StentDesign::strut_width_mm, 0.03, 0.4},
    {"strut_thickness_mm", &StentDesign::strut_thickness_mm, 0.03, 0.4},
    {"recoil_percent", &StentDesign::recoil, 0, 20, 100},
    {"marker_length_mm", &StentDesign::marker_length_mm, 0.3, 3},
    {"ring_stiffness_N_per_mm", &StentDesign::ring_stiffness_N_per_mm, 0.5, 100},
    {"retention_N", &StentDesign::retention_N, 0.05, 30},
};
constexpr StentCount count_fields[] = {
    {"rings", &StentDesign::rings, 2, 60},
    {"crowns", &StentDesign::crowns, 4, 24},
    {"links", &StentDesign::links, 1, 24},
};

} // namespace

std::span<const StentNumber> stent_numbers()
{
    return numbers;
}

std::span<const StentCount> stent_counts()
{
    return count_fields;
}

double StentDesign::chord_mm(double radius_mm) const
{
    return 2 * radius_mm * std::sin(std::numbers::pi / (2 * crowns));
}

double StentDesign::ring_height_mm(double radius_mm) const
{
    const double chord = chord_mm(radius_mm);
    return std::sqrt(std::max(strut_length_mm * strut_length_mm - chord * chord, 0.0));
}

double StentDesign::link_length_mm() const
{
    const double height = ring_height_mm(crimped_radius_mm());
    const double taken = connection == StentConnection::facing ? rings * height : height;
    return (length_mm - taken) / (rings - 1);
}

double StentDesign::length_at_mm(double radius_mm) const
{
    const double height = ring_height_mm(radius_mm);
    return (rings - 1) * link_length_mm() + (connection == StentConnection::facing ? rings * height : height);
}

StentFault stent_fault(const StentDesign &stent)
{
    if (stent.links > stent.crowns)
        return {"links", "'links' = " + number_text(stent.links) + " is more than the " +
                             number_text(stent.crowns) + " 'crowns' of a ring"};
    if (stent.crimped_diameter_mm >= stent.diameter_mm)
        return {"crimped_diameter_mm",
                "'crimped_diameter_mm' is not below 'diameter_mm' = " + number_text(stent.diameter_mm)};
    if (stent.diameter_max_mm < stent.diameter_mm)
        return {"diameter_max_mm",
                "'diameter_max_mm' is below 'diameter_mm' = " + number_text(stent.diameter_mm)};
    const double widest = stent.chord_mm(stent.radius_on_mm(stent.diameter_max_mm / 2));
    if (stent.strut_length_mm < 1.05 * widest)
        return {"strut_length_mm", "'strut_length_mm' = " + number_text(stent.strut_length_mm) +
                                       " does not reach from crown to crown at 'diameter_max_mm': " +
                                       number_text(1.05 * widest) + " at least, or more 'crowns'"};
    const double height = stent.ring_height_mm(stent.crimped_radius_mm());
    const bool is_facing = stent.connection == StentConnection::facing;
    const double least = is_facing ? 0.0 : stent.strut_width_mm;
    const double room = stent.link_length_mm() - (is_facing ? 0.0 : height);
    if (room < least)
        return {"rings", "'rings' = " + number_text(stent.rings) + " of " + number_text(height) +
                             " mm do not fit into 'length_mm' = " + number_text(stent.length_mm) +
                             ": fewer, or shorter struts"};
    return {};
}

bool is_possible(const StentDesign &stent)
{
    const auto is_in = [&](const auto &row, double value) { return value >= row.low && value <= row.high; };
    return std::all_of(std::begin(numbers), std::end(numbers),
                       [&](const StentNumber &row) {
                           return is_in(row, stent.*row.value * row.per_file); // false for NaN
                       }) &&
           std::all_of(std::begin(count_fields), std::end(count_fields),
                       [&](const StentCount &row) { return is_in(row, stent.*row.value); }) &&
           stent_fault(stent).key.empty();
}

} // namespace crn
