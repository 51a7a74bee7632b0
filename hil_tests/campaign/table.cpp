#include "hil_tests/campaign/table.hpp"
#include <cstdio>
#include <fstream>

namespace hil
{

void CampaignTable::add(const Fault &fault, const Outcome &outcome)
{
    Row &row = rows_[fault.kind->name];
    row.count++;
    row.failed += !outcome.failure.empty();
    row.told += !outcome.message.empty();
    row.endings[outcome.failure.empty() ? outcome.ending : "FAILED"]++;
    row.safe_ms = std::max(row.safe_ms, outcome.safe_ms);
    row.peak_N = std::max(row.peak_N, outcome.peak_N);
    if (outcome.safe_ms >= 0) {
        const auto which = static_cast<std::size_t>(outcome.safe_class);
        worst_ms_[which] = std::max(worst_ms_[which], outcome.safe_ms);
        powered_[which]++;
    }
    const std::string line = line_of(fault);
    lines_.push_back(line + '\t' + (outcome.failure.empty() ? "ok" : "FAILED") + '\t' + outcome.ending +
                     '\t' + (outcome.safe_ms < 0 ? "" : std::to_string(outcome.safe_ms)) + '\t' +
                     text("%.3f\t%.2f\t", outcome.peak_N, outcome.peak_N_m * 1e3) +
                     (outcome.failure.empty() ? outcome.message : outcome.failure));
    if (!outcome.failure.empty())
        failures_.push_back(text("%s\n    again: build/bin/hil_campaign --level %s --only \"%s\"",
                                 outcome.failure.c_str(), level_.c_str(), line.c_str()));
}

void CampaignTable::print() const
{
    std::printf("%-25s %6s %6s %6s %8s %7s  %s\n", "fault", "count", "failed", "told", "safe ms", "max N",
                "endings");
    for (const auto &[name, row] : rows_) {
        std::string endings;
        for (const auto &[ending, count] : row.endings)
            endings += (endings.empty() ? "" : ", ") + std::to_string(count) + " " + ending;
        const std::string safe = row.safe_ms < 0 ? "-" : std::to_string(row.safe_ms);
        std::printf("%-25s %6u %6u %6u %8s %7.2f  %s\n", name.c_str(), unsigned{row.count},
                    unsigned{row.failed}, unsigned{row.told}, safe.c_str(), row.peak_N, endings.c_str());
    }
    for (std::size_t i = 1; i < safe_classes; i++) {
        const auto which = static_cast<SafeClass>(i);
        if (powered_[i] > 0)
            std::printf("time to safe, %-24s worst %2d ms of %4u, allowed %d ms\n", name_of(which),
                        worst_ms_[i], unsigned{powered_[i]}, bar_ms(which));
    }
    for (const std::string &failure : failures_) std::printf("FAILED: %s\n", failure.c_str());
    std::printf("%zu faults at %s, %zu failed\n", lines_.size(), level_.c_str(), failures_.size());
}

void CampaignTable::write(const std::string &path) const
{
    std::ofstream file(path);
    file << "fault\tresult\tending\ttime_to_safe_ms\tmotor_peak_N\tmotor_peak_mN_m\tmessage\n";
    for (std::string line : lines_) {
        for (char &c : line) c = c == '\n' ? ' ' : c;
        file << line << '\n';
    }
    if (!file.flush()) throw std::runtime_error("cannot write " + path + ": check the folder and the disk");
}

} // namespace hil
