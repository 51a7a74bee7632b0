// Makes the frame that all HTML pages of the program share: one appearance, without scripts, links or other
// files.
#pragma once
#include <string>

namespace crn
{

// Returns the page up to the beginning of its body. The title is escaped. `style` holds additional style
// rules (CSS) for the page.
std::string page_begin(const std::string &title, const std::string &style = "");
// Returns the end of the page with a remark in small grey letters, which may contain markup.
std::string page_end(const std::string &remark);
// Returns a step that divides the range of an axis into at most five parts; the step is 1, 2 or 5 times a
// power of ten.
double axis_step(double range);

} // namespace crn
