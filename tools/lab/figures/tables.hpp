// Converts the results of a study to tables (TSV) and to one JSON file, both of which contain the numbers of
// the figures.
#pragma once
#include "tools/lab/figures/study.hpp"

namespace vcsim3
{

// Holds a table of texts; every row has as many cells as the table's header.
struct Table {
    std::vector<std::string> head;
    std::vector<std::vector<std::string>> rows;
};

Table compression_table(const Study &study); // Figures 5.11 and 5.13
Table times_table(const Study &study);       // Figure 5.14
Table shape_table(const Study &study);       // Figure 5.12, one row per node
Table preset_table();                        // Table 5.1 as read
Table stability_table(const Study &study);

std::string to_tsv(const Table &table);
std::string to_html(const Table &table);
std::string to_json(const Study &study);

} // namespace vcsim3
