#include "host/suite/ui.hpp"
#include "host/base/format.hpp"
#include "host/suite/ui_text.hpp"
#include <algorithm>
#include <cstdarg>
#include <imgui_internal.h>

namespace crn
{

void Ui::begin_panel(const char *name, const UiRect &place, const char *title)
{
    ImGui::SetNextWindowPos({place.x, place.y});
    ImGui::SetNextWindowSize({place.width, place.height});
    ImGui::Begin(name, nullptr,
                 ImGuiWindowFlags_NoDecoration | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoSavedSettings |
                     ImGuiWindowFlags_NoNav | ImGuiWindowFlags_NoBringToFrontOnFocus |
                     ImGuiWindowFlags_NoScrollWithMouse);
    if (!title || !*title) return;
    ImGui::PushFont(fonts().small_text);
    ImGui::TextDisabled("%s", title);
    ImGui::PopFont();
}

void Ui::end_panel()
{
    ImGui::End();
}

void Ui::note_last_item(const std::string &name, const std::string &text)
{
    const ImVec2 low = ImGui::GetItemRectMin(), high = ImGui::GetItemRectMax();
    note(name, {low.x, low.y, high.x - low.x, high.y - low.y}, text);
}

std::string Ui::layout_text() const
{
    std::string text;
    for (const PlacedControl &control : placed_) {
        text += formatted("%s\t%.0f\t%.0f\t%.0f\t%.0f", control.name.c_str(), control.place.x,
                          control.place.y, control.place.width, control.place.height);
        text += (control.text.empty() ? "" : "\t" + control.text) + "\n";
    }
    return text;
}

std::string Ui::tooltip_of(const Control &control)
{
    std::string text(control.what);
    text.append("\nKey: ").append(control.key_text);
    if (!control.pad_text.empty()) text.append("    Gamepad: ").append(control.pad_text);
    return text;
}

void Ui::tooltip(const std::string &text)
{
    if (!ImGui::IsItemHovered()) return;
    ImGui::BeginTooltip();
    ImGui::PushTextWrapPos(px(380.0f));
    this->text(tint::text, "%s", text.c_str());
    ImGui::PopTextWrapPos();
    ImGui::EndTooltip();
}

void Ui::button(ControlId id, const char *label, float width, bool is_lit)
{
    const Control &found = control(id);
    std::string shown(label ? std::string_view(label) : found.name);
    if (!shown.empty() && shown[0] >= 'a' && shown[0] <= 'z')
        shown[0] = static_cast<char>(shown[0] - 'a' + 'A');
    // A button of a fixed width has less space beside its label than a button that is as wide as its label.
    const float beside = width > 0.0f ? px(3.0f) : ImGui::GetStyle().FramePadding.x;
    const bool is_cut = width > 0.0f && ImGui::CalcTextSize(shown.c_str()).x > px(width) - 2.0f * beside;
    const std::string text = shown + "##" + std::string(found.name);
    if (is_lit) {
        ImGui::PushStyleColor(ImGuiCol_Button, tint::orange);
        ImGui::PushStyleColor(ImGuiCol_ButtonHovered, tint::orange);
        ImGui::PushStyleColor(ImGuiCol_Text, tint::background);
    }
    ImGui::PushStyleVar(ImGuiStyleVar_FramePadding, {beside, ImGui::GetStyle().FramePadding.y});
    ImGui::Button(text.c_str(), {width > 0.0f ? px(width) : width, px(26.0f)});
    ImGui::PopStyleVar();
    if (is_lit) ImGui::PopStyleColor(3);
    if (ImGui::IsItemActivated()) input_->press(id);
    if (ImGui::IsItemDeactivated()) input_->release(id);
    note_last_item(std::string(found.name), is_cut ? "its label does not fit" : "");
    tooltip(tooltip_of(found));
}

bool Ui::screen_button(ScreenControlId id, const std::string &label, float width)
{
    const ScreenControl &row = screen_control(id);
    const std::string key(row.key_text);
    const std::string text = width < 0.0f || width > 120.0f ? label + " (" + key + ")" : label;
    return plain_button(std::string(row.name).c_str(), text.c_str(), width,
                        (std::string(row.what) + "\nKey: " + key).c_str());
}

bool Ui::plain_button(const char *name, const char *label, float width, const char *hint)
{
    const bool is_pressed = ImGui::Button((std::string(label) + "##" + name).c_str(),
                                          {width > 0.0f ? px(width) : width, px(28.0f)});
    const bool is_cut =
        width > 0.0f && ImGui::CalcTextSize(label).x > px(width) - 2.0f * ImGui::GetStyle().FramePadding.x;
    note_last_item(name, is_cut ? "its label does not fit" : "");
    if (hint) tooltip(hint);
    return is_pressed;
}

// Draws the text with a font; if ImGui has a width for line breaks, the text is broken into lines here.
void Ui::draw_text(ImFont *font, ImU32 colour, const char *format, va_list arguments)
{
    std::string text = formatted_with(format, arguments);
    if (font) ImGui::PushFont(font);
    const float wrap = ImGui::GetCurrentWindow()->DC.TextWrapPos;
    if (wrap >= 0.0f) {
        const float width = ImGui::CalcWrapWidthForPos(ImGui::GetCursorScreenPos(), wrap);
        text = joined_lines(lines_of(
            text, width, [](const std::string &line) { return ImGui::CalcTextSize(line.c_str()).x; }));
    }
    ImGui::PushStyleColor(ImGuiCol_Text, colour);
    ImGui::TextUnformatted(text.c_str());
    ImGui::PopStyleColor();
    if (font) ImGui::PopFont();
}

void Ui::text(ImU32 colour, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    draw_text(nullptr, colour, format, arguments);
    va_end(arguments);
}

void Ui::small_text(ImU32 colour, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    draw_text(fonts().small_text, colour, format, arguments);
    va_end(arguments);
}

void Ui::bar(float share, ImU32 colour, const char *label, float width)
{
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float high = px(14.0f), half = 0.5f * width;
    ImDrawList *draw = ImGui::GetWindowDrawList();
    draw->AddRectFilled(at, {at.x + width, at.y + high}, tint::line, px(3.0f));
    const float end = at.x + half + std::clamp(share, -1.0f, 1.0f) * half;
    draw->AddRectFilled({std::min(at.x + half, end), at.y + px(2.0f)},
                        {std::max(at.x + half, end), at.y + high - px(2.0f)}, colour);
    draw->AddLine({at.x + half, at.y}, {at.x + half, at.y + high}, tint::dim);
    ImGui::Dummy({width, high});
    if (!label) return;
    ImGui::SameLine();
    small_text(tint::text, "%s", label);
}

} // namespace crn
