// Writes out/thesis/index.html: the four figures with their numbers and an explanation.
#pragma once
#include "tools/lab/figures/study.hpp"

namespace vcsim3
{

// Returns the beginning of a page, including this title, style and first heading; "</body></html>" ends the
// page.
std::string page_head(const std::string &title);

std::string page_html(const Study &study, const std::string &vessel_name);

} // namespace vcsim3
