#include "host/suite/pages.hpp"
#include "host/link/usb_devices.hpp"
#include <algorithm>

namespace crn
{

std::size_t turned_page(std::size_t page, int step, std::size_t cards)
{
    const std::size_t last = cards == 0 ? 0 : (cards - 1) / cards_per_page();
    if (step < 0) return page == 0 ? 0 : std::min(page - 1, last);
    return std::min(page + (step > 0 ? 1 : 0), last);
}

ImU32 severity_colour(int weight)
{
    return weight >= 5 ? tint::red : weight == 4 ? tint::orange : tint::yellow;
}

void begin_page(Ui &ui, const char *name, const char *title, const char *below)
{
    ui.begin_panel(name, {0.0f, 0.0f, ui.window().width(), ui.window().height()}, "");
    ImGui::SetCursorScreenPos({ui.px(page_margin), ui.px(30.0f)});
    ImGui::PushFont(ui.fonts().large);
    ui.text(tint::text, "%s", title);
    ImGui::PopFont();
    ImGui::SetCursorScreenPos({ui.px(page_margin), ui.px(70.0f)});
    ui.text(tint::dim, "%s", below);
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
    ImGui::SetCursorScreenPos({ui.px(page_margin), ui.px(116.0f)});
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
    if (ui.screen_button(ScreenControlId::leave_rig, "Start screen", 190.0f))
        choice.kind = PageChoice::Kind::start;
    ImGui::EndGroup();
    ui.end_panel();
    return choice;
}

} // namespace crn
