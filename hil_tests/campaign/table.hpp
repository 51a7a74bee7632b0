// Prints the results of a campaign as a table and writes them to a file of tab-separated values. The table
// has one line per kind of fault. The table also gives, for each class of faults, the longest time until the
// rig was safe.
#pragma once
#include "hil_tests/campaign/judge.hpp"
#include <map>

namespace hil
{

class CampaignTable
{
  public:
    explicit CampaignTable(const std::string &level = "L0") : level_(level) {}
    void add(const Fault &fault, const Outcome &outcome);
    void print() const;
    void write(const std::string &path) const; // throws std::runtime_error
    std::size_t failures() const { return failures_.size(); }
    std::size_t count() const { return lines_.size(); }

  private:
    struct Row {
        std::uint32_t count = 0, failed = 0, told = 0;
        std::map<std::string, std::uint32_t> endings;
        int safe_ms = -1;
        double peak_N = 0.0;
    };
    std::string level_;
    std::map<std::string, Row> rows_;
    int worst_ms_[safe_classes] = {-1, -1, -1, -1, -1, -1};
    std::uint32_t powered_[safe_classes] = {};
    std::vector<std::string> lines_, failures_;
};

} // namespace hil
