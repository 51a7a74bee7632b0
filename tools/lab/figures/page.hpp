// Writes out/thesis/index.html, which has the four figures with their numbers and an explanation.
#pragma once
#include "tools/lab/figures/study.hpp"

namespace vcsim3
{

// Returns the beginning of a page with this title, the style and the first heading; the caller ends the page
// with "</body></html>".
std::string page_head(const std::string &title);

std::string page_html(const Study &study, const std::string &vessel_name);

} // namespace vcsim3
