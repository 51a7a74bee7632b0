// Draws the screens of the window besides the suite: start, debrief and rig.
#pragma once
#include "host/report/score.hpp"
#include "host/suite/case_card.hpp"
#include "host/suite/ui.hpp"
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace crn
{

struct PageChoice {
    enum class Kind { none, begin, again, replay, start, rig, quit } kind = Kind::none;
    std::size_t card = 0;  // of begin
    std::string recording; // of replay
};

PageChoice draw_start(Ui &ui, const std::vector<CaseCard> &cards, const std::vector<KeptRecording> &kept,
                      const std::string &trouble);

// What the debrief shows of a session that has ended.
struct Debrief {
    nlohmann::ordered_json report, score;
    std::string recording, title, fault;
    std::vector<std::string> files;
};
PageChoice draw_debrief(Ui &ui, const Debrief &debrief);

struct RigRow {
    std::string name, state;
};
// Looks for rigs on USB. A machine without USB has one row that says why.
std::vector<RigRow> rig_rows();
PageChoice draw_rig(Ui &ui, const std::vector<RigRow> &rows, const std::string &device);

} // namespace crn
