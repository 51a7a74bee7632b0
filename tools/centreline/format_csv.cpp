// Reads and writes the project's own table of centrelines (.csv), which has one sphere per line and names its
// columns in the first line.
#include "host/base/number_text.hpp"
#include "tools/centreline/formats.hpp"

#include <array>
#include <cmath>

namespace crn::centreline
{
namespace
{

enum Column {
    branch,
    name,
    parent,
    parent_sphere,
    sphere,
    x_mm,
    y_mm,
    z_mm,
    radius_mm,
    speed_mm_s,
    manual,
    columns
};
constexpr std::array<std::string_view, columns> titles = {
    "branch", "name", "parent",    "parent_sphere", "sphere", "x_mm",
    "y_mm",   "z_mm", "radius_mm", "speed_mm_s",    "manual"};
constexpr std::array<Column, 5> needed = {branch, x_mm, y_mm, z_mm, radius_mm};

std::vector<std::string_view> cells_of(std::string_view line)
{
    std::vector<std::string_view> cells;
    for (std::size_t at = 0;;) {
        const std::size_t end = std::min(line.find(',', at), line.size());
        std::string_view cell = line.substr(at, end - at);
        while (!cell.empty() && cell.front() == ' ') cell.remove_prefix(1);
        while (!cell.empty() && cell.back() == ' ') cell.remove_suffix(1);
        cells.push_back(cell);
        if (end == line.size()) return cells;
        at = end + 1;
    }
}

// Holds one line of the table, with the file's name and line number for error messages.
struct Row {
    std::string where; // "tree.csv:12: "
    const std::array<int, columns> &order;
    std::vector<std::string_view> cells;

    bool has(Column column) const { return order[column] >= 0 && !cells[order[column]].empty(); }
    double number(Column column) const
    {
        const double value = has(column) ? number_of(cells[order[column]]) : NAN;
        if (std::isfinite(value)) return value;
        throw Fault(where + std::string(titles[column]) + " is '" +
                    (has(column) ? std::string(cells[order[column]].substr(0, 40)) : "") +
                    "', which is no number: correct it");
    }
    long long whole(Column column, double low) const
    {
        const double value = number(column);
        if (value == std::floor(value) && value >= low && value < 1e9) return static_cast<long long>(value);
        throw Fault(where + std::string(titles[column]) + " must be a whole number from " +
                    trimmed_text(low, file_decimals));
    }
};

std::array<int, columns> order_of(std::string_view head, const std::string &where)
{
    std::array<int, columns> order;
    order.fill(-1);
    const std::vector<std::string_view> cells = cells_of(head);
    for (std::size_t i = 0; i < cells.size(); ++i) {
        std::size_t column = 0;
        while (column < columns && titles[column] != cells[i]) ++column;
        if (column == columns) {
            std::string list;
            for (std::string_view title : titles) list += (list.empty() ? "" : ", ") + std::string(title);
            throw Fault(where + "has no column '" + std::string(cells[i].substr(0, 40)) + "': use " + list);
        }
        if (order[column] >= 0)
            throw Fault(where + "names column " + std::string(titles[column]) + " twice: remove one");
        order[column] = static_cast<int>(i);
    }
    for (Column column : needed)
        if (order[column] < 0)
            throw Fault(where + "lacks the column " + std::string(titles[column]) +
                        ": add it to the first line");
    return order;
}

void add(Tree &tree, const Row &row)
{
    const long long number = row.whole(branch, 0);
    const auto count = static_cast<long long>(tree.branches.size());
    if (number != count && number != count - 1)
        throw Fault(row.where + "branch " + std::to_string(number) + " follows branch " +
                    std::to_string(count - 1) + ": write the branches one after the other, from 0");
    if (number == count) {
        if (tree.branches.size() == branches_max)
            throw Fault(row.where + "begins branch " + std::to_string(number) + ": at most " +
                        std::to_string(branches_max) + " are read");
        Branch made;
        if (row.has(name)) made.name = plain_name(std::string(row.cells[row.order[name]]));
        if (row.has(parent)) made.parent = static_cast<int>(row.whole(parent, -1));
        if (made.parent >= 0) made.parent_sphere = static_cast<std::size_t>(row.whole(parent_sphere, 0));
        tree.branches.push_back(std::move(made));
    }
    Branch &own = tree.branches.back();
    if (row.has(sphere) && row.whole(sphere, 0) != static_cast<long long>(own.spheres.size()))
        throw Fault(row.where + "sphere is " + std::string(row.cells[row.order[sphere]]) + ", expected " +
                    std::to_string(own.spheres.size()) + ": a line is missing or stands in another place");
    Sphere made;
    made.centre_mm = {row.number(x_mm), row.number(y_mm), row.number(z_mm)};
    made.radius_mm = row.number(radius_mm);
    if (row.has(speed_mm_s)) made.speed_mm_s = row.number(speed_mm_s);
    if (row.has(manual)) made.is_manual = row.whole(manual, 0) != 0;
    own.spheres.push_back(made);
}

} // namespace

Tree read_csv(const std::string &text, const std::string &file)
{
    Tree tree;
    std::array<int, columns> order{};
    bool has_head = false;
    for (const TextLine &line : lines_of(text)) {
        if (words_of(line.text).empty() || line.text.front() == '#') continue;
        const std::string where = file + ":" + std::to_string(line.number) + ": ";
        if (!has_head) {
            order = order_of(line.text, where);
            has_head = true;
            continue;
        }
        const Row row{where, order, cells_of(line.text)};
        std::size_t wanted = 0;
        for (int place : order) wanted = std::max(wanted, static_cast<std::size_t>(place + 1));
        if (row.cells.size() != wanted)
            throw Fault(where + "has " + std::to_string(row.cells.size()) + " cells, the first line has " +
                        std::to_string(wanted) + ": a comma is missing or too many");
        add(tree, row);
    }
    check_tree(tree, file);
    return tree;
}

std::string csv_text(const Tree &tree)
{
    std::string text =
        "# Vessel tree of inscribed spheres, millimetres; a branch's first sphere is its parent's.\n";
    for (std::size_t i = 0; i < columns; ++i) text += (i ? "," : "") + std::string(titles[i]);
    text += "\n";
    for (std::size_t b = 0; b < tree.branches.size(); ++b) {
        const Branch &own = tree.branches[b];
        const std::string head = std::to_string(b) + "," + plain_name(own.name) + "," +
                                 std::to_string(own.parent) + "," + std::to_string(own.parent_sphere) + ",";
        for (std::size_t i = 0; i < own.spheres.size(); ++i) {
            const Sphere &s = own.spheres[i];
            text += head + std::to_string(i);
            for (double value :
                 {s.centre_mm.x(), s.centre_mm.y(), s.centre_mm.z(), s.radius_mm, s.speed_mm_s})
                text += "," + trimmed_text(value, file_decimals);
            text += s.is_manual ? ",1\n" : ",0\n";
        }
    }
    return text;
}

} // namespace crn::centreline
