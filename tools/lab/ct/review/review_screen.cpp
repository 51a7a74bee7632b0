#include "tools/lab/ct/review/review_screen.hpp"
#include "host/base/format.hpp"
#include <algorithm>
#include <cmath>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace crn::ct
{

namespace
{

constexpr float side_units = 330.0f, margin_units = 12.0f, top_units = 12.0f, title_units = 26.0f;

struct ClickButton {
    ClickKind kind;
    const char *name, *label, *hint;
    int key;
    char letter; // of the mark in the pictures
};
constexpr ClickButton click_buttons[] = {
    {ClickKind::artery, "click artery", "Artery (A)",
     "The cross is inside an artery that must be in the lumen.", GLFW_KEY_A, 'A'},
    {ClickKind::cut, "click cut", "Cut (C)",
     "The lumen leaks here into bone or a vein: what goes through the cross is no artery.", GLFW_KEY_C, 'C'},
    {ClickKind::bridge, "click bridge", "Bridge (B)",
     "The lumen has a gap here: the two ends nearest to the cross are one vessel.", GLFW_KEY_B, 'B'},
    {ClickKind::entry, "click entry", "Entry (E)",
     "Instruments enter at the end of the arteries that is nearest to the cross.", GLFW_KEY_E, 'E'},
    {ClickKind::name, "click name", "Name (N)", "The branch nearest to the cross gets the name in the field.",
     GLFW_KEY_N, 'N'}};
constexpr double slabs_mm[] = {0, 10, 20, 40};

constexpr ImU32 wall_colour = tint::red, line_colour = tint::yellow, click_colour = tint::green,
                cross_colour = IM_COL32(86, 180, 233, 150);

} // namespace

ReviewWish ReviewScreen::draw()
{
    ReviewWish wish;
    ui_.begin_screen();
    const float margin = ui_.px(margin_units), top = ui_.px(top_units);
    const float width = ui_.window().width(), height = ui_.window().height();
    const float side = ui_.px(side_units);
    ui_.begin_panel("side", {0, 0, side + margin, height}, "");
    ImGui::PushTextWrapPos(side);
    draw_steps(wish);
    ImGui::PopTextWrapPos();
    ui_.end_panel();
    const float left = side + 2 * margin;
    const float edge =
        std::min((width - left - 3 * margin) / 3, height - top - ui_.px(title_units) - ui_.px(300.0f));
    // A panel cuts off what lies in its own margin.
    ui_.begin_panel("pictures", {side + margin, 0, width - side - margin, height}, "");
    const struct {
        Section section;
        const char *name, *title;
    } sections[] = {{Section::axial, "axial", "Axial: from the feet, front up"},
                    {Section::coronal, "coronal", "Coronal: from the front"},
                    {Section::sagittal, "sagittal", "Sagittal: from the left"}};
    float x = left;
    for (const auto &section : sections) {
        draw_section(section.section, section.name, section.title, {x, top, edge, edge});
        x += edge + margin;
    }
    const float below = top + ui_.px(title_units) + edge + ui_.px(14.0f);
    const float half = 0.5f * (width - left - 2 * margin);
    draw_findings({left, below, half, height - below - margin});
    draw_clicks({left + half + margin, below, half, height - below - margin});
    ui_.end_panel();
    return wish;
}

void ReviewScreen::draw_steps(ReviewWish &wish)
{
    ImGui::PushFont(ui_.fonts().large);
    ui_.text(tint::text, "Your own CT");
    ImGui::PopFont();
    const bool is_running = state_.is_running();
    bool is_next = true; // the first step that is not done is the one that runs
    for (const ReviewStep &step : state_.folder().steps()) {
        const bool runs = is_running && !step.is_done && is_next;
        if (!step.is_done) is_next = false;
        ui_.text(step.is_done ? tint::green
                 : runs       ? tint::orange
                              : tint::dim,
                 "%s  %s",
                 step.is_done ? "\u25a0"
                 : runs       ? "\u25b6"
                              : "\u25a1",
                 step.title);
        ui_.note_last_item(std::string("step ") + step.name, step.is_done ? "done" : runs ? "runs" : "waits");
    }
    ImGui::Dummy({1.0f, ui_.px(4.0f)});
    draw_progress();
    ImGui::Dummy({1.0f, ui_.px(6.0f)});
    constexpr float button_units = 156.0f;
    if (is_running) {
        if (ui_.plain_button("stop", "Stop (S)", button_units, "Ends the command. Finished steps are kept."))
            state_.stop();
    } else if (ui_.plain_button("run", "Make again (R)", button_units,
                                "Runs the steps whose inputs or clicks have changed.")) {
        state_.run();
    }
    ImGui::SameLine();
    if (state_.folder().has_scene() && !is_running) {
        if (ui_.plain_button("play", "Play (P)", button_units, "Closes this window and opens the session."))
            wish.plays = true;
    } else {
        ImGui::Dummy({1.0f, 1.0f});
    }
    ImGui::Dummy({1.0f, ui_.px(6.0f)});
    draw_tools();
    ImGui::Dummy({1.0f, ui_.px(10.0f)});
    if (ui_.plain_button("end", "End (Esc)", button_units, "Everything is kept in the folder."))
        wish.ends = true;
}

void ReviewScreen::draw_progress()
{
    std::string text;
    ImU32 colour = tint::dim;
    if (state_.is_running()) {
        text = formatted("Working for %.0f s. You can look around meanwhile.", state_.running_s());
        colour = tint::orange;
    } else if (!state_.trouble().empty()) {
        text = state_.trouble();
        colour = tint::red;
    } else if (!state_.folder().trouble.empty()) {
        text = state_.folder().trouble;
        colour = tint::red;
    } else if (state_.needs_run()) {
        text = "The clicks have changed: make the scene again.";
        colour = tint::yellow;
    } else if (state_.folder().has_scene()) {
        text = "The scene is ready. Look at the red outline in all sections, then play it.";
    } else {
        text = "There is no scene yet.";
    }
    ui_.text(colour, "%s", text.c_str());
    ui_.note_last_item("progress", text);
}

void ReviewScreen::draw_tools()
{
    ui_.small_text(tint::dim,
                   "Red is the wall of the lumen, yellow a centreline, green a click. A press in a "
                   "picture moves the cross, and the wheel goes through the slices. These buttons "
                   "click at the cross:");
    for (std::size_t i = 0; i < std::size(click_buttons); ++i) {
        if (i % 2 == 1) ImGui::SameLine();
        const ClickButton &button = click_buttons[i];
        if (ui_.plain_button(button.name, button.label, 156.0f, button.hint))
            state_.add_click(button.kind, branch_);
    }
    ImGui::SameLine();
    ImGui::PushItemWidth(ui_.px(156.0f));
    ImGui::InputTextWithHint("##branch", "name of a branch", branch_, sizeof branch_);
    ui_.note_last_item("branch", (ImGui::IsItemActive() ? "typing: " : "") + std::string(branch_));
    ImGui::PopItemWidth();
    ImGui::Dummy({1.0f, ui_.px(6.0f)});
    ui_.small_text(tint::dim, "Brightest voxels of a slab of:");
    for (std::size_t i = 0; i < std::size(slabs_mm); ++i) {
        if (i > 0) ImGui::SameLine();
        const std::string label = slabs_mm[i] > 0 ? formatted("%.0f mm", slabs_mm[i]) : "1 slice";
        const bool is_lit = state_.slab_mm() == slabs_mm[i];
        if (is_lit) ImGui::PushStyleColor(ImGuiCol_Text, tint::orange);
        if (ui_.plain_button(formatted("slab %zu", i).c_str(), label.c_str(), 75.0f))
            state_.set_slab(slabs_mm[i]);
        if (is_lit) ImGui::PopStyleColor();
    }
    ui_.small_text(tint::dim, "Grey range:");
    for (std::size_t i = 0; i < std::size(grey_presets); ++i) {
        if (i % 2 == 1) ImGui::SameLine();
        const bool is_lit = state_.grey() == i;
        if (is_lit) ImGui::PushStyleColor(ImGuiCol_Text, tint::orange);
        if (ui_.plain_button(formatted("grey %zu", i).c_str(), grey_presets[i].name, 156.0f))
            state_.set_grey(i);
        if (is_lit) ImGui::PopStyleColor();
    }
}

void ReviewScreen::draw_section(Section section, const char *name, const char *title, const UiRect &place)
{
    ImGui::SetCursorScreenPos({place.x, place.y});
    ui_.text(tint::dim, "%s", title);
    const UiRect at{place.x, place.y + ui_.px(title_units), place.width, place.height};
    ImDrawList *draw = ImGui::GetWindowDrawList();
    draw->AddRectFilled({at.x, at.y}, {at.x + at.width, at.y + at.height}, IM_COL32(0, 0, 0, 255));
    ImGui::SetCursorScreenPos({at.x, at.y});
    const bool is_pressed = ImGui::InvisibleButton(name, {at.width, at.height});
    ui_.note_last_item(name);
    if (!state_.has_scan()) return;
    const bool is_hovered = ImGui::IsItemHovered();
    const SectionPicture &picture = state_.picture(section);
    void *texture = ui_.window().texture(static_cast<std::size_t>(section), picture.edge_px, picture.grey,
                                         state_.version(section), false);
    draw->AddImage(texture, {at.x, at.y}, {at.x + at.width, at.y + at.height});
    draw->PushClipRect({at.x, at.y}, {at.x + at.width, at.y + at.height}, true);
    draw_marks(picture, at);
    draw->PopClipRect();
    const float wheel = ImGui::GetIO().MouseWheel;
    if (is_hovered && wheel != 0.0f) {
        state_.step(section, wheel > 0 ? 1 : -1);
    } else if (is_pressed) {
        const ImVec2 mouse = ImGui::GetIO().MousePos;
        const double scale = picture.edge_px / static_cast<double>(at.width);
        state_.set_cross(picture.place((mouse.x - at.x) * scale, (mouse.y - at.y) * scale));
    }
}

void ReviewScreen::draw_marks(const SectionPicture &picture, const UiRect &place)
{
    ImDrawList *draw = ImGui::GetWindowDrawList();
    const float scale = place.width / static_cast<float>(picture.edge_px);
    const auto pixel = [&](const Eigen::Vector3d &at_mm) {
        const Eigen::Vector2d at = picture.pixel(at_mm);
        return ImVec2(place.x + scale * static_cast<float>(at.x()),
                      place.y + scale * static_cast<float>(at.y()));
    };
    const int normal = static_cast<int>(picture.section);
    // A mark is shown where it lies in the slab, or within a few millimetres of a single slice.
    const double near_mm = std::max(0.5 * state_.slab_mm(), 4.0);
    const auto is_near = [&](const Eigen::Vector3d &at_mm) {
        return std::fabs(at_mm[normal] - state_.cross_mm()[normal]) <= near_mm;
    };
    for (const auto &[from, to] : state_.outline(picture.section))
        draw->AddLine(pixel(from), pixel(to), wall_colour, ui_.px(1.2f));
    for (const centreline::Branch &branch : state_.folder().tree.branches)
        for (std::size_t i = 1; i < branch.spheres.size(); ++i) {
            const Eigen::Vector3d &a = branch.spheres[i - 1].centre_mm, &b = branch.spheres[i].centre_mm;
            if (is_near(a) && is_near(b)) draw->AddLine(pixel(a), pixel(b), line_colour, ui_.px(1.5f));
        }
    for (const Click &click : state_.clicks()) {
        if (!is_near(click.at_mm)) continue;
        const ImVec2 at = pixel(click.at_mm);
        const char letter[2] = {click_buttons[static_cast<std::size_t>(click.kind)].letter, 0};
        draw->AddCircle(at, ui_.px(6.0f), click_colour, 0, ui_.px(1.8f));
        draw->AddText(ui_.fonts().bold, ui_.px(14.0f), {at.x + ui_.px(8.0f), at.y - ui_.px(8.0f)},
                      click_colour, letter);
    }
    const ImVec2 cross = pixel(state_.cross_mm());
    draw->AddLine({place.x, cross.y}, {place.x + place.width, cross.y}, cross_colour);
    draw->AddLine({cross.x, place.y}, {cross.x, place.y + place.height}, cross_colour);
    const char *sides[][2] = {{"F", "B"}, {"R", "L"}, {"R", "L"}}; // left and right edge of each section
    const std::size_t side = static_cast<std::size_t>(picture.section);
    draw->AddText({place.x + ui_.px(4.0f), place.y + 0.5f * place.height}, tint::dim, sides[side][0]);
    draw->AddText({place.x + place.width - ui_.px(14.0f), place.y + 0.5f * place.height}, tint::dim,
                  sides[side][1]);
}

void ReviewScreen::draw_findings(const UiRect &place)
{
    ImGui::SetCursorScreenPos({place.x, place.y});
    ImGui::BeginChild("findings", {place.width, place.height});
    ImGui::PushTextWrapPos(place.width - ui_.px(16.0f));
    const PatientFolder &folder = state_.folder();
    const struct {
        const char *head;
        const std::vector<std::string> &lines;
        ImU32 colour;
    } lists[] = {{"Check these", folder.check, tint::yellow},
                 {"Assumed", folder.assumed, tint::text},
                 {"Measured", folder.facts, tint::text}};
    for (const auto &list : lists) {
        if (list.lines.empty()) continue;
        ui_.text(tint::dim, "%s", list.head);
        for (const std::string &line : list.lines) ui_.small_text(list.colour, "\u2022 %s", line.c_str());
    }
    ImGui::PopTextWrapPos();
    ImGui::EndChild();
    ui_.note("findings", place, formatted("%zu checks", folder.check.size()));
}

void ReviewScreen::draw_clicks(const UiRect &place)
{
    ImGui::SetCursorScreenPos({place.x, place.y});
    ImGui::BeginChild("clicks", {place.width, place.height});
    const Eigen::Vector3d cross = state_.cross_mm();
    if (state_.has_scan()) {
        ui_.text(tint::sky, "Cross (%.1f, %.1f, %.1f) mm: %.0f HU", cross.x(), cross.y(), cross.z(),
                 state_.cross_HU());
        ui_.note_last_item(
            "cross", formatted("%.1f %.1f %.1f %.0f", cross.x(), cross.y(), cross.z(), state_.cross_HU()));
    }
    ui_.text(tint::dim, "Clicks");
    if (state_.clicks().empty()) ui_.small_text(tint::dim, "None: the arteries were found without help.");
    std::size_t removed = state_.clicks().size();
    for (std::size_t i = 0; i < state_.clicks().size(); ++i) {
        const Click &click = state_.clicks()[i];
        if (ui_.plain_button(formatted("remove %zu", i + 1).c_str(), "Remove", 72.0f)) removed = i;
        ImGui::SameLine();
        ui_.text(click_colour, "%zu  %s%s%s", i + 1, kind_name(click.kind), click.branch.empty() ? "" : " ",
                 click.branch.c_str());
        ImGui::SameLine(ui_.px(330.0f));
        if (ui_.plain_button(formatted("show %zu", i + 1).c_str(), "Show", 60.0f))
            state_.set_cross(click.at_mm);
    }
    if (removed < state_.clicks().size()) state_.remove_click(removed);
    ui_.note("clicks", place, formatted("%zu clicks", state_.clicks().size()));
    const auto &branches = state_.folder().tree.branches;
    if (!branches.empty()) ui_.text(tint::dim, "Branches");
    for (std::size_t i = 0; i < branches.size(); ++i) {
        const centreline::Branch &branch = branches[i];
        if (ui_.plain_button(formatted("branch %zu", i + 1).c_str(), "Show", 60.0f))
            state_.set_cross(branch.spheres[branch.spheres.size() / 2].centre_mm);
        ImGui::SameLine();
        ui_.text(tint::text, "%s", branch.name.c_str());
        ImGui::SameLine(ui_.px(330.0f));
        ui_.text(tint::dim, "%.0f mm long", centreline::length_mm(branch));
    }
    ImGui::EndChild();
}

ReviewWish ReviewScreen::press(int key)
{
    ReviewWish wish;
    for (const ClickButton &button : click_buttons)
        if (key == button.key) state_.add_click(button.kind, branch_);
    switch (key) {
    case GLFW_KEY_R:
        state_.run();
        break;
    case GLFW_KEY_S:
        state_.stop();
        break;
    case GLFW_KEY_P:
        wish.plays = state_.folder().has_scene() && !state_.is_running();
        break;
    case GLFW_KEY_ESCAPE:
        wish.ends = true;
        break;
    default:
        break;
    }
    return wish;
}

} // namespace crn::ct
