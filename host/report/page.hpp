// Makes parts of the HTML pages about a session: texts, numbers and curves. Each page needs no other file.
#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

namespace crn
{

// Returns the text of an entry, escaped for HTML; an absent entry gives an empty text.
std::string page_text(const nlohmann::ordered_json &from, const char *key);
// Returns a number, rounded to three significant digits, without an exponent; if the value is not a number,
// returns a dash.
std::string page_figure(const nlohmann::ordered_json &value);
// Returns a list of numbers, which is empty if the list is absent.
std::vector<double> page_numbers(const nlohmann::ordered_json &from, const char *key);

struct PageCurve {
    const char *title, *colour;
    std::vector<double> values; // not negative
};
// Returns curves over the time as SVG, or an empty text if no value is above 0. The line of a curve is
// interrupted where samples are missing.
std::string page_plot(const std::string &title, const std::vector<double> &time_s,
                      const std::vector<PageCurve> &curves);

} // namespace crn
