// Controls the screens of the window without a session: which one is shown, and what its keys and buttons do.
#include "host/base/pending_file.hpp"
#include "host/records/record.hpp"
#include "host/report/session_summary.hpp"
#include "host/suite/suite_app.hpp"
#include <cfloat>
#include <filesystem>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>
#include <algorithm>

namespace crn
{

namespace
{

std::vector<ReplayError> errors_of(const Debrief &debrief)
{
    std::vector<ReplayError> errors;
    const ScoredSession *scored = debrief.scored();
    if (!scored) return errors;
    for (const auto &error : scored->score.report["assessment"]["errors"])
        errors.push_back(
            {error["tick"].get<std::uint32_t>(), error.value("weight", 3), error.value("title", "")});
    return errors;
}

std::string without_outer_blanks(const std::string &text)
{
    const std::size_t first = text.find_first_not_of(' ');
    return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(' ') + 1 - first);
}

} // namespace

void SuiteApp::go_on(Page page)
{
    page_ = page;
    said_.clear();
    if (page != Page::replay) replay_.reset();
    if (page != Page::prep) prep_.reset();
    if (page == Page::start) {
        cards_ = case_cards(options_, best_scores(trainee_));
        practice_ = practice_cards(options_);
        card_page_ = turned_page(card_page_, 0, cards_.size());
        kept_ = kept_recordings(static_cast<std::size_t>(screen_control(ScreenControlId::recording).keys()));
    }
    if (page == Page::rig) rigs_ = rig_rows();
}

// Throws the exceptions of check_pseudonym(), because no session can be stored under an invalid pseudonym.
void SuiteApp::open_prep(const CaseCard &card)
{
    trainee_ = without_outer_blanks(trainee_);
    if (!trainee_.empty()) check_pseudonym(trainee_);
    auto prep = std::make_unique<PrepPage>(ui_, card);
    go_on(Page::prep);
    prep_ = std::move(prep);
    if (!trainee_.empty()) remember_trainee(trainee_);
}

void SuiteApp::open_replay(const std::string &recording, std::uint32_t tick)
{
    before_replay_ = page_;
    input_.emplace(1);
    ui_.serve(*input_);
    const bool is_debriefed = page_ == Page::debrief && host_->debrief().recording == recording;
    replay_ = std::make_unique<ReplayPage>(
        ui_, recording, options_.pictures, is_debriefed ? host_->debrief().lesson : nullptr,
        is_debriefed ? errors_of(host_->debrief()) : std::vector<ReplayError>());
    replay_->go_to(tick);
    page_ = Page::replay;
}

// Opens a session in the background, because reading a beating heart takes seconds.
void SuiteApp::begin_opening(const WindowOptions &options)
{
    opening_ = std::make_unique<BackgroundTask<std::unique_ptr<SessionHost>>>(
        [this, chosen = session_options(options), number = ++sessions_](TaskProgress &) {
            auto host = std::make_unique<SessionHost>(chosen, [this] { return window_.context(); });
            host->begin(number);
            return host;
        });
}

// Shows the session that was opened, or the reason why opening it failed.
void SuiteApp::look_at_opening()
{
    if (!opening_ || !opening_->is_done()) return;
    const auto opened = std::move(opening_);
    if (!opened->result()) {
        trouble_ = said_ = opened->trouble();
        if (page_ == Page::prep) go_on(Page::start);
        return;
    }
    host_ = opened->take();
    enter_session();
}

void SuiteApp::show_opening()
{
    const char *text = "The session is being prepared.";
    ImFont *font = ui_.fonts().bold;
    const ImVec2 size = font->CalcTextSizeA(font->FontSize, FLT_MAX, 0.0f, text);
    const ImVec2 at{0.5f * (window_.width() - size.x), window_.height() - ui_.px(44.0f)};
    const float pad = ui_.px(12.0f);
    ImDrawList *draw = ImGui::GetForegroundDrawList();
    draw->AddRectFilled({at.x - pad, at.y - pad}, {at.x + size.x + pad, at.y + size.y + pad}, tint::raised,
                        pad);
    draw->AddText(font, font->FontSize, at, tint::yellow, text);
}

void SuiteApp::show_page()
{
    PageChoice choice;
    window_.begin_frame();
    ui_.begin_screen();
    if (page_ == Page::start)
        choice = draw_start(ui_, {&cards_, &practice_, &kept_, trouble_, card_page_}, trainee_);
    else if (page_ == Page::prep)
        choice = prep_->draw();
    else if (page_ == Page::debrief)
        choice = draw_debrief(ui_, host_->debrief(), said_);
    else if (page_ == Page::rig)
        choice = draw_rig(ui_, rigs_, options_.device);
    else
        replay_->draw();
    if (opening_) show_opening();
    window_.end_frame();
    write_layout();
    if (!opening_) follow(choice);
    look_at_opening();
}

// If a card or a recording cannot be opened, the same screen stays and shows the reason.
void SuiteApp::follow(const PageChoice &choice)
{
    if (choice.kind == PageChoice::Kind::none) return;
    try {
        carry_out(choice);
        trouble_.clear();
    } catch (const std::exception &error) {
        trouble_ = said_ = error.what();
        if (page_ != Page::start && page_ != Page::debrief && begins_at_start_) go_on(Page::start);
    }
}

void SuiteApp::carry_out(const PageChoice &choice)
{
    switch (choice.kind) {
    case PageChoice::Kind::prepare:
        if (choice.card < cards_.size() && cards_[choice.card].trouble.empty())
            open_prep(cards_[choice.card]);
        break;
    case PageChoice::Kind::practise:
        if (choice.card < practice_.size() && practice_[choice.card].trouble.empty())
            begin_opening(practice_[choice.card].options);
        break;
    case PageChoice::Kind::cards_on:
    case PageChoice::Kind::cards_back:
        card_page_ =
            turned_page(card_page_, choice.kind == PageChoice::Kind::cards_on ? 1 : -1, cards_.size());
        break;
    case PageChoice::Kind::toggle:
        prep_->toggle(choice.card);
        break;
    case PageChoice::Kind::start_case:
        if (prep_->is_ready()) begin_opening(prep_->options());
        break;
    case PageChoice::Kind::again:
        begin_opening(host_->options());
        break;
    case PageChoice::Kind::replay:
        if (!choice.recording.empty()) open_replay(choice.recording, choice.tick);
        break;
    case PageChoice::Kind::save:
        save_debrief();
        break;
    case PageChoice::Kind::start:
        go_on(Page::start);
        break;
    case PageChoice::Kind::rig:
        go_on(Page::rig);
        break;
    case PageChoice::Kind::quit:
        wants_quit_ = true;
        break;
    case PageChoice::Kind::none:
        break;
    }
}

// Writes the page of the debrief and its figures as files beside the recording.
void SuiteApp::save_debrief()
{
    const Debrief &debrief = host_->debrief();
    const ScoredSession *scored = debrief.scored();
    if (!scored) return;
    std::filesystem::path path(debrief.recording);
    const std::string page = path.replace_extension(".html").string();
    const std::string figures = path.replace_extension(".json").string();
    write_debrief(page, scored->score.report["assessment"]);
    write_report(figures, scored->score.report);
    said_ = "written " + page + "\nwritten " + figures;
}

// Returns the choice that a key makes on a screen without a session (controls_table.cpp). A key of a range,
// such as "1 to 9", makes the choice with the key's position in the range.
PageChoice SuiteApp::choice_of_key(int key) const
{
    using Kind = PageChoice::Kind;
    const ScreenId screen = page_ == Page::start     ? ScreenId::start
                            : page_ == Page::prep    ? ScreenId::prep
                            : page_ == Page::debrief ? ScreenId::debrief
                                                     : ScreenId::rig;
    const ScreenControl *row = screen_control_of_key(screen, key);
    if (!row) return {};
    const auto place = static_cast<std::size_t>(std::max(key - row->key, 0));
    switch (row->id) {
    case ScreenControlId::card:
        return {Kind::prepare, card_page_ * cards_per_page() + place, "", 0};
    case ScreenControlId::cards_on:
        return {Kind::cards_on, 0, "", 0};
    case ScreenControlId::cards_back:
        return {Kind::cards_back, 0, "", 0};
    case ScreenControlId::practice:
        return {Kind::practise, place, "", 0};
    case ScreenControlId::recording:
        return {Kind::replay, 0, place < kept_.size() ? kept_[place].path : "", 0};
    case ScreenControlId::to_rig:
        return {Kind::rig, 0, "", 0};
    case ScreenControlId::quit:
        return {Kind::quit, 0, "", 0};
    case ScreenControlId::cabinet:
        return {Kind::toggle, place, "", 0};
    case ScreenControlId::begin:
        return {Kind::start_case, 0, "", 0};
    case ScreenControlId::to_replay:
        return {Kind::replay, 0, host_->debrief().recording, 0};
    case ScreenControlId::again:
        return {Kind::again, 0, "", 0};
    case ScreenControlId::save:
        return {Kind::save, 0, "", 0};
    default: // the screens' ways back
        return {Kind::start, 0, "", 0};
    }
}

void SuiteApp::take_page_key(int key)
{
    if (opening_) return; // the screen is about to change
    if (page_ != Page::replay) return follow(choice_of_key(key));
    const ScreenControl *row = screen_control_of_key(ScreenId::replay, key);
    if (!row) return; // Esc is a control of the session as well, and act_own() carries it out
    if (row->id == ScreenControlId::play) replay_->toggle_play();
    if (row->id == ScreenControlId::expert) replay_->toggle_expert();
    if (row->id == ScreenControlId::next_error) replay_->go_to_error(true);
    if (row->id == ScreenControlId::error_before) replay_->go_to_error(false);
    if (row->id == ScreenControlId::second_back) replay_->jump(-1.0);
    if (row->id == ScreenControlId::second_on) replay_->jump(1.0);
}

} // namespace crn
