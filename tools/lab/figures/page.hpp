// out/thesis/index.html: the four figures with their numbers and what to make of them.
#pragma once
#include "tools/lab/figures/study.hpp"

namespace vcsim3
{

// The beginning of a page with this title, style and first heading included; "</body></html>" ends it.
std::string page_head(const std::string &title);

std::string page_html(const Study &study, const std::string &vessel_name);

} // namespace vcsim3
