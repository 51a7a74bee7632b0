// Draws the window's screens other than the session itself: start, debrief and rig; prep_page.hpp draws the
// preparation.
#pragma once
#include "host/live/background_task.hpp"
#include "host/live/trainee_records.hpp"
#include "host/report/figures/score.hpp"
#include "host/suite/case_card.hpp"
#include "host/suite/ui.hpp"
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace crn
{

inline constexpr float page_margin = 60.0f; // units, at the left of the screens
// Gives the indices of the textures for the preparation and the case cards; the monitors use lower indices.
inline constexpr std::size_t prep_slot = 4, card_slot = 8;

struct PageChoice {
    enum class Kind {
        none,
        prepare,  // the case of card number `card`
        cards_on, // the next page of cards
        cards_back,
        practise,   // free practice number `card`
        toggle,     // device number `card` of the preparation
        start_case, // that is prepared
        again,
        replay,
        start,
        rig,
        save, // page and figures of the debrief
        quit
    } kind = Kind::none;
    std::size_t card = 0;
    std::string recording;  // of replay
    std::uint32_t tick = 0; // of replay: the moment that it begins with
};

// Begins a screen with its title and a line of text below the title. Call Ui::end_panel() afterwards.
void begin_page(Ui &ui, const char *name, const char *title, const char *below);

// Returns the colour of an error with this weight, 3 (moderate) to 5 (life-threatening).
ImU32 severity_colour(int weight);

struct StartView {
    const std::vector<CaseCard> *cases = nullptr, *practice = nullptr;
    const std::vector<KeptRecording> *kept = nullptr;
    std::string trouble;
    std::size_t page = 0; // of the cards
};
// A page has as many cards as keys can select.
inline std::size_t cards_per_page()
{
    return static_cast<std::size_t>(screen_control(ScreenControlId::card).keys());
}
// Returns the page after (+1) or before (-1) the given page of the cards; beyond the first and the last page
// the number stays unchanged.
std::size_t turned_page(std::size_t page, int step, std::size_t cards);
// `trainee` is the pseudonym, which the user may change on the start screen.
PageChoice draw_start(Ui &ui, const StartView &view, std::string &trainee);

// Holds the score of a session, and where the score was stored if the session was one of a case.
struct ScoredSession {
    RecordedScore score;
    std::optional<StoredSession> stored;
};

// Holds what the debrief shows about a session that has ended.
struct Debrief {
    nlohmann::ordered_json report;
    std::string recording, title, fault;
    std::vector<std::string> files;
    std::shared_ptr<const Case> lesson;                  // null: no case
    std::unique_ptr<BackgroundTask<ScoredSession>> task; // null: no recording, so no score
    // Returns the score, or null while the score is not yet known.
    const ScoredSession *scored() const
    {
        const ScoredSession *done = task ? task->result() : nullptr;
        return done && !done->score.was_stopped ? done : nullptr;
    }
};
// `said` is the last message to the user, such as the names of saved files.
PageChoice draw_debrief(Ui &ui, const Debrief &debrief, const std::string &said);

// Draws curves from the entries "tools" and "curves" of an assessment: the inserted lengths, the force on the
// walls, and the pressure of the balloon if there was one. The scale of time is that of the debrief's
// timeline.
void draw_session_curves(Ui &ui, const nlohmann::ordered_json &assessment, const UiRect &place);

struct RigRow {
    std::string name, state;
};
// Looks for rigs on USB; on a machine without USB, the only row states the reason.
std::vector<RigRow> rig_rows();
PageChoice draw_rig(Ui &ui, const std::vector<RigRow> &rows, const std::string &device);

} // namespace crn
