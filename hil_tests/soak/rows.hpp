// Keeps the results of all sessions of one seed in a file of tab-separated rows, one row per session. A later
// call of the program adds rows to the same file.
#pragma once
#include "hil_tests/soak/trial.hpp"
#include <map>
#include <string>

namespace soak
{

struct Row {
    std::uint32_t index = 0;
    std::string scene, tools;
    Verdict verdict;
    std::string script; // the shrunk script; empty: nothing broke
};

std::string line_of(const Row &row);
Row row_of(const std::string &line); // throws std::runtime_error

class RowsFile
{
  public:
    // `key` identifies the program and the inputs that made the rows; a file that has another key is renamed
    // to "path.old". If the last line of the file is incomplete, the constructor deletes this line. Throws
    // std::runtime_error.
    RowsFile(const std::string &path, const std::string &key);

    void add(const Row &row); // written to the file at once
    bool has(std::uint32_t index) const { return rows_.count(index) > 0; }
    const std::map<std::uint32_t, Row> &rows() const { return rows_; }
    bool was_put_aside() const { return was_put_aside_; }

  private:
    void append(const std::string &text);

    const std::string path_;
    std::map<std::uint32_t, Row> rows_;
    bool was_put_aside_ = false;
};

struct Summary {
    std::uint64_t sessions = 0, ticks = 0, broken = 0, capped = 0;
    double penetration_mm = 0, length_pct = 0, force_N = 0, injected_mg = 0;
    std::uint32_t penetration_at = 0, length_at = 0, force_at = 0; // index of the session
    std::map<std::string, std::uint64_t> by_bar;                   // broken ones
};
Summary sum_of(const RowsFile &rows);
// Returns the totals as lines in the format of out/bench.tsv: name, value, unit, context (docs/bench.md).
std::string bench_rows(const Summary &summary, std::uint64_t seed);

} // namespace soak
