// Draws the start screen: cards of the cases, free practice, stored recordings, the trainee, and the rig.
#include "host/base/format.hpp"
#include "host/suite/pages.hpp"
#include "host/suite/ui_text.hpp"
#include <algorithm>
#include <cfloat>
#include <cmath>

namespace crn
{
namespace
{

constexpr float side_units = 320.0f, card_width = 356.0f, card_height = 196.0f, card_gap = 14.0f;
constexpr float picture_units = 104.0f;

// Draws text in a rectangle, broken into as many lines as fit; three dots at the end show that text is
// missing. Returns the height of the drawn lines.
float wrapped(ImDrawList *draw, ImFont *font, const UiRect &place, ImU32 colour, const std::string &text)
{
    const float line = font->FontSize;
    const auto most = static_cast<std::size_t>(std::max(place.height / line, 0.0f));
    const auto width_of = [&](const std::string &part) {
        return font->CalcTextSizeA(line, FLT_MAX, 0.0f, part.c_str()).x;
    };
    std::vector<std::string> lines = lines_of(text, place.width, width_of);
    if (lines.size() > most) {
        lines.resize(most);
        if (!lines.empty()) {
            std::string &last = lines.back();
            while (!last.empty() && width_of(last + "\u2026") > place.width) last.pop_back();
            while (!last.empty() && (last.back() == ' ' || last.back() == ',')) last.pop_back();
            last += "\u2026";
        }
    }
    draw->AddText(font, line, {place.x, place.y}, colour, joined_lines(lines).c_str());
    return static_cast<float>(lines.size()) * line;
}

struct CardState {
    bool is_pressed = false, is_hovered = false;
};

// Draws one card. The whole card of a case is a button.
CardState draw_card(Ui &ui, const CaseCard &card, std::size_t index, float width, float height)
{
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float pad = ui.px(12.0f);
    const std::string name = "card " + std::to_string(index + 1);
    const bool is_pressed = ImGui::InvisibleButton(name.c_str(), {width, height});
    const bool is_hovered = ImGui::IsItemHovered() && card.trouble.empty();
    if (ImGui::IsItemVisible()) ui.note_last_item(name);
    ImDrawList *draw = ImGui::GetWindowDrawList();
    draw->AddRectFilled(at, {at.x + width, at.y + height}, is_hovered ? tint::raised : tint::background,
                        ui.px(6.0f));
    float x = at.x + pad;
    if (!card.picture.bytes.empty()) {
        const float edge = ui.px(picture_units);
        void *texture =
            ui.window().texture(card_slot + index, card.picture.width, card.picture.bytes, 1, false);
        draw->AddImage(texture, {x, at.y + pad}, {x + edge, at.y + pad + edge});
        x += edge + pad;
    }
    const float right = at.x + width - pad, bottom = at.y + height - pad;
    const float foot = ui.px(18.0f);
    float y = at.y + pad;
    y += wrapped(draw, ui.fonts().bold, {x, y, right - x, bottom - y}, tint::text, card.name) + ui.px(4.0f);
    y += wrapped(draw, ui.fonts().small_text, {x, y, right - x, bottom - foot - y}, tint::sky, card.goal);
    if (!card.trouble.empty())
        wrapped(draw, ui.fonts().small_text, {x, y, right - x, bottom - y}, tint::orange, card.trouble);
    // The case's description ("story") is drawn below the picture, over the whole width of the card.
    const float story_y = std::max(
        y + ui.px(4.0f), at.y + pad + (card.picture.bytes.empty() ? 0.0f : ui.px(picture_units + 6.0f)));
    ImFont *small_font = ui.fonts().small_text;
    const float story_w = right - at.x - pad;
    wrapped(draw, small_font, {at.x + pad, story_y, story_w, bottom - foot - story_y}, tint::dim, card.story);
    const std::string key = "key " + screen_key_text(ScreenControlId::card, index % cards_per_page());
    draw->AddText(small_font, small_font->FontSize, {at.x + pad, bottom - small_font->FontSize}, tint::dim,
                  key.c_str());
    if (!card.best.empty()) {
        const std::string best = "best " + card.best;
        const ImVec2 size = small_font->CalcTextSizeA(small_font->FontSize, FLT_MAX, 0.0f, best.c_str());
        draw->AddText(small_font, small_font->FontSize, {right - size.x, bottom - size.y}, tint::green,
                      best.c_str());
    }
    return {is_pressed && card.trouble.empty(), is_hovered};
}

struct CardsState {
    std::optional<std::size_t> pressed, hovered;
};

// Draws one page of case cards as a grid, which scrolls in a small window.
CardsState draw_cards(Ui &ui, const std::vector<CaseCard> &cards, std::size_t page, const UiRect &place)
{
    CardsState state;
    ImGui::SetCursorScreenPos({place.x, place.y});
    ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {ui.px(card_gap), ui.px(card_gap)});
    ImGui::BeginChild("cards", {place.width, place.height});
    const float available = ImGui::GetContentRegionAvail().x;
    const int columns =
        std::max(1, static_cast<int>((available + ui.px(card_gap)) / ui.px(card_width + card_gap)));
    const float width =
        (available - ui.px(card_gap) * static_cast<float>(columns - 1)) / static_cast<float>(columns);
    // The rows of a full page of cards share the height of the window, so that in a large window the cards
    // show more of the cases' descriptions.
    const auto rows = static_cast<float>((cards_per_page() + static_cast<std::size_t>(columns) - 1) /
                                         static_cast<std::size_t>(columns));
    const float height =
        std::max(ui.px(card_height), std::floor((place.height - ui.px(card_gap) * (rows - 1.0f)) / rows));
    const std::size_t first = page * cards_per_page();
    for (std::size_t i = first; i < std::min(cards.size(), first + cards_per_page()); ++i) {
        if ((i - first) % static_cast<std::size_t>(columns) != 0) ImGui::SameLine();
        const CardState card = draw_card(ui, cards[i], i, width, height);
        if (card.is_pressed) state.pressed = i;
        if (card.is_hovered) state.hovered = i;
    }
    ImGui::EndChild();
    ImGui::PopStyleVar();
    return state;
}

// Writes which cards are shown, and draws the buttons that show other cards; draws nothing if one page holds
// all cards.
void draw_pager(Ui &ui, const StartView &view, float right, PageChoice &choice)
{
    const std::size_t count = view.cases->size(), first = view.page * cards_per_page();
    if (count <= cards_per_page()) return;
    constexpr float button_units = 150.0f;
    const std::string shown =
        formatted("cases %zu to %zu of %zu", first + 1, std::min(count, first + cards_per_page()), count);
    const float y = ui.px(66.0f), left = right - ui.px(2.0f * button_units + 6.0f);
    ImGui::SetCursorScreenPos({left - ImGui::CalcTextSize(shown.c_str()).x - ui.px(14.0f), y + ui.px(5.0f)});
    ui.text(tint::dim, "%s", shown.c_str());
    ImGui::SetCursorScreenPos({left, y});
    if (ui.screen_button(ScreenControlId::cards_back, "Before", button_units))
        choice = {PageChoice::Kind::cards_back, 0, "", 0};
    ImGui::SameLine();
    if (ui.screen_button(ScreenControlId::cards_on, "Next", button_units))
        choice = {PageChoice::Kind::cards_on, 0, "", 0};
}

void draw_side(Ui &ui, const StartView &view, const CaseCard *hovered, std::string &trainee,
               PageChoice &choice)
{
    const float width = side_units - 20.0f;
    ui.text(tint::text, "Trainee");
    ImGui::PushItemWidth(ui.px(width));
    char text[65] = {};
    trainee.copy(text, sizeof text - 1);
    if (ImGui::InputTextWithHint("##trainee", "a pseudonym; without one: guest", text, sizeof text))
        trainee = text;
    ui.note_last_item("trainee", (ImGui::IsItemActive() ? "typing: " : "") + trainee);
    ui.tooltip("Marks are stored under this pseudonym on this machine (docs/records.md).");
    ImGui::PopItemWidth();
    ImGui::Dummy({1.0f, ui.px(8.0f)});
    ui.text(tint::text, "Free practice");
    for (std::size_t i = 0; i < view.practice->size(); ++i) {
        const CaseCard &card = (*view.practice)[i];
        const std::string name = "practice " + std::to_string(i + 1);
        const std::string label = card.name + " (" + screen_key_text(ScreenControlId::practice, i) + ")";
        const std::string hint = card.trouble.empty() ? card.story + " " + card.goal : card.trouble;
        if (ui.plain_button(name.c_str(), label.c_str(), width, hint.c_str()))
            choice = {PageChoice::Kind::practise, i, "", 0};
    }
    ImGui::Dummy({1.0f, ui.px(8.0f)});
    ui.text(tint::text, "Replay");
    if (view.kept->empty()) ui.small_text(tint::dim, "No recording is kept yet.");
    for (std::size_t i = 0; i < view.kept->size(); ++i) {
        const KeptRecording &kept = (*view.kept)[i];
        const std::string name = "replay " + std::to_string(i + 1);
        const std::string label = kept.when +
                                  formatted("   %.1f MB", static_cast<double>(kept.bytes) * 1e-6) + " (" +
                                  screen_key_text(ScreenControlId::recording, i) + ")";
        if (ui.plain_button(name.c_str(), label.c_str(), width, kept.path.c_str()))
            choice = {PageChoice::Kind::replay, 0, kept.path, 0};
    }
    ImGui::Dummy({1.0f, ui.px(8.0f)});
    if (ui.screen_button(ScreenControlId::to_rig, "Rig", width)) choice.kind = PageChoice::Kind::rig;
    if (ui.screen_button(ScreenControlId::quit, "End", width)) choice.kind = PageChoice::Kind::quit;
    if (!hovered) return;
    // The full description of the card under the pointer is drawn here, because a tooltip would cover other
    // cards.
    ImGui::Dummy({1.0f, ui.px(8.0f)});
    ui.text(tint::text, "%s", hovered->name.c_str());
    ui.note_last_item("story", hovered->name);
    ui.small_text(tint::dim, "%s", hovered->story.c_str());
}

} // namespace

PageChoice draw_start(Ui &ui, const StartView &view, std::string &trainee)
{
    begin_page(ui, "start", "Cournand", "Choose a case: click its card, or press its number.");
    PageChoice choice;
    const float margin = ui.px(page_margin), top = ui.px(112.0f),
                bottom = ui.window().height() - ui.px(24.0f);
    const float side_x = ui.window().width() - ui.px(side_units + 20.0f);
    const float trouble_h = view.trouble.empty() ? 0.0f : ui.px(60.0f);
    draw_pager(ui, view, side_x - ui.px(24.0f), choice);
    const CardsState cards = draw_cards(
        ui, *view.cases, view.page, {margin, top, side_x - margin - ui.px(24.0f), bottom - trouble_h - top});
    if (cards.pressed) choice = {PageChoice::Kind::prepare, *cards.pressed, "", 0};
    if (!view.trouble.empty()) {
        ImGui::SetCursorScreenPos({margin, bottom - trouble_h + ui.px(8.0f)});
        ImGui::PushTextWrapPos(side_x - ui.px(24.0f));
        ui.text(tint::red, "%s", view.trouble.c_str());
        ImGui::PopTextWrapPos();
    }
    ImGui::SetCursorScreenPos({side_x, ui.px(40.0f)});
    ImGui::BeginChild("side", {ui.px(side_units), bottom - ui.px(40.0f)});
    ImGui::PushTextWrapPos(0.0f);
    draw_side(ui, view, cards.hovered ? &(*view.cases)[*cards.hovered] : nullptr, trainee, choice);
    ImGui::PopTextWrapPos();
    ImGui::EndChild();
    ui.end_panel();
    return choice;
}

} // namespace crn
