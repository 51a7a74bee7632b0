// Writes out/thesis/index.html, a page with the four figures, their numbers and an explanation.
#pragma once
#include "tools/lab/figures/study.hpp"

namespace vcsim3
{

// Returns the beginning of an HTML page with the given title, the style and the first heading; the caller
// writes "</body></html>" at the end of the page.
std::string page_head(const std::string &title);

std::string page_html(const Study &study, const std::string &vessel_name);

} // namespace vcsim3
