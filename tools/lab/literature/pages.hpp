// Writes the results of `literature`: a table of figures, a picture of each published table, and the
// generated part of docs/literature.md.
#pragma once
#include "tools/lab/literature/verdict.hpp"

#include <string>
#include <vector>

namespace crn::literature
{

// One line per figure, with the columns name, value, unit, table's kind, published, lowest, highest,
// distance, verdict. If all tables were measured, the last lines are the numbers of tables for `make bars`.
std::string tsv(const std::vector<Measured> &all, bool is_whole);

// Draws one line per figure: the accepted range as a bar, the published mean, and our figure as a dot. Every
// line has its own scale, in which the accepted range always has the same width.
std::string picture(const Measured &one);

// Returns the generated part of the page: an overview, and a section per table with source, set-up, figures
// and comment.
std::string markdown(const std::vector<Measured> &all, const std::vector<Table> &tables);

} // namespace crn::literature
