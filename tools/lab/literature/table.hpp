// Reads the published tables with which `literature` compares the simulator (docs/literature.md). Each file
// in the folder `tables` holds one published table: source, experiment, figures, and what their spread is.
// The reader refuses a table that is incomplete, so that no figure stands without its source and its spread.
#pragma once
#include <optional>
#include <string>
#include <vector>

namespace crn::literature
{

// A figure counts as reproduced if ours lies within so many published standard deviations of the published
// mean: 95 % of a normal population do.
inline constexpr double deviations_allowed = 2.0;

struct Row {
    std::string name; // stable; the experiment gives its figure under this name
    std::string what, unit;
    std::optional<double> mean, deviation; // mean, and its standard deviation if the source states one
    std::optional<double> low, high;       // published range, of which one end may be open
    bool fitted = false;                   // the simulator was adjusted to this figure, so it proves nothing

    bool has_spread() const { return deviation || low || high; }
    double lowest() const;  // of what is accepted; minus infinity if that end is open
    double highest() const; // infinity if that end is open
    std::string published() const;
};

enum class Kind {
    validation,      // our figure follows from other inputs than the published figure
    input,           // the published figure is an input of the simulator
    not_reproducible // the source does not state what the experiment would need
};

struct Table {
    std::string name; // of the file
    std::string title, source, identifier, experiment, simulation, spread, comment;
    Kind kind = Kind::validation;
    std::vector<Row> rows; // none if the table is not reproducible
};

// Reads every FILE.toml of a folder, in the order of the names. Throws crn::FileError with file, line and
// remedy if a table is incomplete, and std::runtime_error if the folder has no table.
std::vector<Table> read_tables(const std::string &folder);

} // namespace crn::literature
