#include "host/base/html_page.hpp"
#include "host/base/format.hpp"
#include <cmath>

namespace crn
{

namespace
{

const char *const common_style =
    "body{font:15px/1.45 sans-serif;color:#1c2530;max-width:64em;margin:2em auto;padding:0 1em}"
    "h1{font-size:1.5em;margin:0}h2{font-size:1.1em;margin:1.8em 0 "
    ".4em}table{border-collapse:collapse;width:100%}"
    "th,td{text-align:left;padding:.25em .6em;border-bottom:1px solid #dde3ea;vertical-align:top}"
    "td.n,th.n{text-align:right;white-space:nowrap}.sum{font-size:2.6em;font-weight:600}.soft{color:#66727f}"
    ".bad{color:#b3261e}.good{color:#1b6e3c}figure{display:inline-block;margin:0 1em 1em 0}"
    "figure "
    "img{width:300px;height:300px;background:#000}figcaption{font-size:.85em;color:#66727f;max-width:300px}"
    "svg{max-width:100%;height:auto}svg text{font:11px sans-serif;fill:#66727f}@media print{body{margin:0}}";

} // namespace

std::string page_begin(const std::string &title, const std::string &style)
{
    return "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
           "content=\"width=device-width\"><title>" +
           html_text(title) + "</title><style>" + common_style + style + "</style></head><body>\n";
}

std::string page_end(const std::string &remark)
{
    return "<p class=\"soft\">" + remark + "</p>\n</body></html>\n";
}

double axis_step(double range)
{
    const double power = std::pow(10.0, std::floor(std::log10(range / 5.0)));
    for (double factor : {1.0, 2.0, 5.0})
        if (range / (factor * power) <= 5.0) return factor * power;
    return 10.0 * power;
}

} // namespace crn
