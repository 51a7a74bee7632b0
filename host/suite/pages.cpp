#include "host/suite/pages.hpp"
#include "host/base/format.hpp"
#include "host/link/usb_devices.hpp"
#include <algorithm>

namespace crn
{
namespace
{

constexpr float margin = 60.0f;

void begin_page(Ui &ui, const char *name, const char *title, const char *below)
{
    ui.begin_panel(name, {0.0f, 0.0f, ui.window().width(), ui.window().height()}, "");
    ImGui::SetCursorScreenPos({ui.px(margin), ui.px(34.0f)});
    ImGui::PushFont(ui.fonts().large);
    ui.text(tint::text, "%s", title);
    ImGui::PopFont();
    ImGui::SetCursorScreenPos({ui.px(margin), ui.px(74.0f)});
    ui.text(tint::dim, "%s", below);
}

// Draws one card; returns true when its button was pressed.
bool draw_card(Ui &ui, const CaseCard &card, std::size_t index, const UiRect &place)
{
    ImDrawList *draw = ImGui::GetWindowDrawList();
    draw->AddRectFilled({place.x, place.y}, {place.x + place.width, place.y + place.height}, tint::background,
                        ui.px(6.0f));
    const float pad = ui.px(16.0f);
    ImGui::SetCursorScreenPos({place.x + pad, place.y + pad});
    ImGui::BeginGroup();
    ImGui::PushTextWrapPos(ImGui::GetCursorPosX() + place.width - 2.0f * pad);
    ImGui::PushFont(ui.fonts().bold);
    ui.text(tint::text, "%s", card.name.c_str());
    ImGui::PopFont();
    ui.text(tint::dim, "%s", card.story.c_str());
    ui.text(tint::sky, "%s", card.goal.c_str());
    if (!card.best.empty()) ui.text(tint::green, "Best: %s", card.best.c_str());
    if (!card.trouble.empty()) ui.text(tint::orange, "%s", card.trouble.c_str());
    ImGui::PopTextWrapPos();
    ImGui::EndGroup();
    if (!card.trouble.empty()) return false;
    ImGui::SetCursorScreenPos({place.x + pad, place.y + place.height - ui.px(42.0f)});
    const std::string name = "card " + std::to_string(index + 1);
    const std::string label = "Begin (" + std::to_string(index + 1) + ")";
    return ui.plain_button(name.c_str(), label.c_str(), 110.0f, card.goal.c_str());
}

void draw_metrics(Ui &ui, const nlohmann::ordered_json &score)
{
    if (!score.contains("metrics")) return;
    for (const auto &metric : score["metrics"]) {
        const bool has_points = metric.contains("points") && metric["points"].is_number();
        const std::string title = metric.value("title", "");
        const std::string value =
            metric["value"].is_number()
                ? formatted("%.4g %s", metric["value"].get<double>(), metric.value("unit", "").c_str())
                : std::string("not known");
        ImGui::TableNextRow();
        ImGui::TableNextColumn();
        ui.text(tint::text, "%s", title.c_str());
        ImGui::TableNextColumn();
        ui.text(tint::dim, "%s", value.c_str());
        ImGui::TableNextColumn();
        if (has_points) ui.text(tint::text, "%.1f", metric["points"].get<double>());
    }
}

} // namespace

PageChoice draw_start(Ui &ui, const std::vector<CaseCard> &cards, const std::vector<KeptRecording> &kept,
                      const std::string &trouble)
{
    begin_page(ui, "start", "Cournand", "Choose a card, or press its number. Esc ends the program.");
    PageChoice choice;
    const float width = ui.px(350.0f), height = ui.px(230.0f), gap = ui.px(18.0f);
    const float right = ui.window().width() - ui.px(margin + 330.0f);
    float x = ui.px(margin), y = ui.px(116.0f);
    for (std::size_t i = 0; i < cards.size(); ++i) {
        if (draw_card(ui, cards[i], i, {x, y, width, height})) choice = {PageChoice::Kind::begin, i, ""};
        x += width + gap;
        if (x + width <= right) continue;
        x = ui.px(margin);
        y += height + gap;
    }
    if (!trouble.empty()) {
        ImGui::SetCursorScreenPos({ui.px(margin), ui.window().height() - ui.px(60.0f)});
        ImGui::PushTextWrapPos(right);
        ui.text(tint::red, "%s", trouble.c_str());
        ImGui::PopTextWrapPos();
    }
    ImGui::SetCursorScreenPos({right + gap, ui.px(116.0f)});
    ImGui::BeginGroup();
    ui.text(tint::text, "Replay");
    if (kept.empty()) ui.small_text(tint::dim, "No recording is kept yet.");
    for (std::size_t i = 0; i < kept.size(); ++i) {
        const std::string name = "replay " + std::to_string(i + 1);
        const std::string label =
            kept[i].when + formatted("   %.1f MB", static_cast<double>(kept[i].bytes) * 1e-6);
        if (ui.plain_button(name.c_str(), label.c_str(), 290.0f, kept[i].path.c_str()))
            choice = {PageChoice::Kind::replay, 0, kept[i].path};
    }
    ImGui::Dummy({1.0f, ui.px(14.0f)});
    if (ui.plain_button("rig", "Rig", 290.0f, "Shows which rigs are plugged in."))
        choice.kind = PageChoice::Kind::rig;
    if (ui.plain_button("quit", "End (Esc)", 290.0f)) choice.kind = PageChoice::Kind::quit;
    ImGui::EndGroup();
    ui.end_panel();
    return choice;
}

PageChoice draw_debrief(Ui &ui, const Debrief &debrief)
{
    begin_page(ui, "debrief", "Debrief", debrief.title.c_str());
    PageChoice choice;
    ImGui::SetCursorScreenPos({ui.px(margin), ui.px(110.0f)});
    ImGui::BeginGroup();
    const nlohmann::ordered_json &report = debrief.report;
    if (!debrief.fault.empty()) ui.text(tint::red, "%s", debrief.fault.c_str());
    ui.text(tint::text, "%.1f s,  fluoroscopy %.1f s", report.value("ticks", 0.0) * 1e-3,
            report.value(nlohmann::json::json_pointer("/room/fluoroscopy_min"), 0.0) * 60.0);
    ui.text(tint::text, "%.2f mGy,  %.3f Gy cm\u00b2",
            report.value(nlohmann::json::json_pointer("/room/total/reference_air_kerma_mGy"), 0.0),
            report.value(nlohmann::json::json_pointer("/room/total/kap_Gy_cm2"), 0.0));
    const auto &score = debrief.score;
    if (score.contains("percent") && score["percent"].is_number()) {
        ImGui::PushFont(ui.fonts().large);
        ui.text(tint::orange, "%.0f %%", score["percent"].get<double>());
        ImGui::PopFont();
    } else {
        ui.text(tint::dim, "This session has no score, because it treats no lesion.");
    }
    ImGui::Dummy({1.0f, ui.px(8.0f)});
    if (ImGui::BeginTable("metrics", 3, ImGuiTableFlags_SizingFixedFit | ImGuiTableFlags_RowBg,
                          {ui.px(760.0f), 0.0f})) {
        draw_metrics(ui, score);
        ImGui::EndTable();
    }
    ImGui::Dummy({1.0f, ui.px(14.0f)});
    if (!debrief.recording.empty()) {
        if (ui.plain_button("replay", "Replay (1)", 150.0f, "Shows any moment from any angle."))
            choice = {PageChoice::Kind::replay, 0, debrief.recording};
        ImGui::SameLine();
    }
    if (ui.plain_button("again", "Again (2)", 150.0f)) choice.kind = PageChoice::Kind::again;
    ImGui::SameLine();
    if (ui.plain_button("start", "Start screen (Esc)", 190.0f)) choice.kind = PageChoice::Kind::start;
    for (const std::string &file : debrief.files) ui.small_text(tint::dim, "written %s", file.c_str());
    ImGui::EndGroup();
    ui.end_panel();
    return choice;
}

std::vector<RigRow> rig_rows()
{
    std::vector<RigRow> rows = {{"sim", "in this program; always there"}};
    try {
        const UsbContext context = usb_context();
        for (const UsbRig &rig : usb_rigs(context.get()))
            rows.push_back({"usb:" + rig.serial + "  " + rig.product,
                            rig.trouble.empty() ? rig.place : rig.place + ": " + rig.trouble});
        if (rows.size() == 1) rows.push_back({"usb", "no rig is plugged in"});
    } catch (const std::exception &error) {
        rows.push_back({"usb", error.what()});
    }
    return rows;
}

PageChoice draw_rig(Ui &ui, const std::vector<RigRow> &rows, const std::string &device)
{
    begin_page(ui, "rig page", "Rig", "Devices that can run the physics");
    PageChoice choice;
    ImGui::SetCursorScreenPos({ui.px(margin), ui.px(116.0f)});
    ImGui::BeginGroup();
    for (const RigRow &row : rows) {
        ui.text(tint::text, "%s", row.name.c_str());
        ImGui::SameLine(ui.px(420.0f));
        ui.text(tint::dim, "%s", row.state.c_str());
    }
    ImGui::Dummy({1.0f, ui.px(10.0f)});
    ui.text(tint::dim, "Sessions of this window use '%s'. The option --device names another device.",
            device.c_str());
    ui.text(tint::dim, "`cournand rig selftest` tests a rig, and `cournand rig calibrate` calibrates it.");
    ImGui::Dummy({1.0f, ui.px(14.0f)});
    if (ui.plain_button("start", "Start screen (Esc)", 190.0f)) choice.kind = PageChoice::Kind::start;
    ImGui::EndGroup();
    ui.end_panel();
    return choice;
}

} // namespace crn
