#include "hil_tests/soak/rows.hpp"
#include "host/base/pending_file.hpp"
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace soak
{

namespace
{

namespace fs = std::filesystem;

const char columns[] =
    "index\tscene\ttools\tscript\tbroken\tticks\tbroken_at_tick\tpenetration_mm\tlength_pct"
    "\tforce_N\tcapped_ticks\tiodine_mg\thash\twhy\n";

std::string or_dash(const std::string &text)
{
    return text.empty() ? "-" : text;
}

std::string or_empty(const std::string &text)
{
    return text == "-" ? "" : text;
}

std::string read_whole(const std::string &path)
{
    std::ifstream in(path, std::ios::binary);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}

} // namespace

std::string line_of(const Row &row)
{
    return std::to_string(row.index) + "\t" + or_dash(row.scene) + "\t" + or_dash(row.tools) + "\t" +
           or_dash(row.script) + "\t" + line_of(row.verdict);
}

Row row_of(const std::string &line)
{
    Row row;
    std::string rest = line;
    const auto next = [&] {
        const std::size_t end = rest.find('\t');
        if (end == std::string::npos) throw std::runtime_error("'" + line + "' is no row of a soak");
        const std::string word = rest.substr(0, end);
        rest.erase(0, end + 1);
        return word;
    };
    const std::string index = next();
    if (index.empty() || index.find_first_not_of("0123456789") != std::string::npos || index.size() > 9)
        throw std::runtime_error("'" + line + "' is no row of a soak");
    row.index = static_cast<std::uint32_t>(std::stoul(index));
    row.scene = or_empty(next());
    row.tools = or_empty(next());
    row.script = or_empty(next());
    row.verdict = verdict_of(rest);
    return row;
}

RowsFile::RowsFile(const std::string &path, const std::string &key) : path_(path)
{
    const std::string head = "# " + key + "\n" + columns;
    std::string text = read_whole(path);
    if (!text.empty() && !text.starts_with(head)) {
        fs::rename(path, path + ".old");
        was_put_aside_ = true;
        text.clear();
    }
    const std::size_t whole = text.rfind('\n') + 1; // 0 when there is none
    const std::size_t first = std::min(head.size(), whole);
    std::istringstream lines(text.substr(first, whole - first));
    std::string kept = head;
    for (std::string line; std::getline(lines, line);) {
        const Row row = row_of(line);
        rows_[row.index] = row;
    }
    for (const auto &[index, row] : rows_) kept += line_of(row) + "\n";
    crn::write_whole_file(path, kept);
}

void RowsFile::append(const std::string &text)
{
    std::FILE *file = std::fopen(path_.c_str(), "ab");
    const bool is_written = file && std::fwrite(text.data(), 1, text.size(), file) == text.size();
    const int why = errno;
    if ((file && std::fclose(file) != 0) || !is_written)
        throw std::runtime_error(path_ + ": cannot be written: " + std::strerror(why));
}

void RowsFile::add(const Row &row)
{
    append(line_of(row) + "\n");
    rows_[row.index] = row;
}

Summary sum_of(const RowsFile &rows)
{
    Summary sum;
    const auto take = [](double value, std::uint32_t index, double &worst, std::uint32_t &at) {
        if (value <= worst) return;
        worst = value;
        at = index;
    };
    for (const auto &[index, row] : rows.rows()) {
        const Verdict &verdict = row.verdict;
        sum.sessions++;
        sum.ticks += verdict.ticks;
        sum.capped += verdict.capped > 0 ? 1 : 0;
        sum.injected_mg += verdict.injected_mg;
        take(verdict.penetration_mm, index, sum.penetration_mm, sum.penetration_at);
        take(verdict.length_pct, index, sum.length_pct, sum.length_at);
        take(verdict.force_N, index, sum.force_N, sum.force_at);
        if (verdict.broken.empty()) continue;
        sum.broken++;
        sum.by_bar[verdict.broken]++;
    }
    return sum;
}

std::string bench_rows(const Summary &sum, std::uint64_t seed)
{
    std::ostringstream text;
    const std::string context = "seed=" + std::to_string(seed);
    const auto at = [&](std::uint32_t index) { return context + " session=" + std::to_string(index); };
    text << "soak.sessions\t" << sum.sessions << "\t1\t" << context << "\n";
    text << "soak.ticks\t" << sum.ticks << "\tticks\t" << context << "\n";
    text << "soak.broken\t" << sum.broken << "\t1\t" << context << "\n";
    for (const auto &[bar, count] : sum.by_bar)
        text << "soak.broken_by\t" << count << "\t1\t" << context << " bar=" << bar << "\n";
    text << "soak.step_capped\t" << sum.capped << "\tsessions\t" << context << "\n";
    text << "soak.penetration_mm\t" << sum.penetration_mm << "\tmm\t" << at(sum.penetration_at) << "\n";
    text << "soak.length_pct\t" << sum.length_pct << "\t%\t" << at(sum.length_at) << "\n";
    text << "soak.force_N\t" << sum.force_N << "\tN\t" << at(sum.force_at) << "\n";
    text << "soak.iodine_mg\t" << sum.injected_mg << "\tmg\t" << context << "\n";
    return text.str();
}

} // namespace soak
