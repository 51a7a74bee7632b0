// The frame that all HTML pages of the program share: one look, without scripts, links or other files.
#pragma once
#include <string>

namespace crn
{

// Returns the page up to the begin of its body. The title is escaped. `style` holds further rules of the
// page's style.
std::string page_begin(const std::string &title, const std::string &style = "");
// Returns the end of the page with a remark in small grey letters, which may contain markup.
std::string page_end(const std::string &remark);
// Returns a step that divides a range into at most five parts; the step is 1, 2 or 5 times a power of ten.
double axis_step(double range);

} // namespace crn
