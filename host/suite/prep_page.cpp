#include "host/suite/prep_page.hpp"
#include "host/base/format.hpp"
#include "host/base/number_text.hpp"
#include "host/cases/measures.hpp"
#include "host/patient/stents.hpp"
#include <algorithm>
#include <bit>
#include <filesystem>

namespace crn
{
namespace
{

constexpr double french_mm = 1.0 / 3.0;
constexpr float side_text = 190.0f; // units, below the reference picture
constexpr double unstated_mm = 5.0; // a device at a position that the case begins without
std::uint64_t pages_opened = 0;     // each page's picture is a new version of the texture

double outer_mm(const Instrument &tool)
{
    std::uint32_t um = 0;
    for (std::uint16_t i = 0; i < tool.table.knots_count; ++i)
        um = std::max(um, tool.table.knots[i].radius_outer_um);
    return 2e-3 * um;
}

// Returns the narrowest inner diameter of the device, or 0 if the device has no lumen.
double inner_mm(const Instrument &tool)
{
    std::uint32_t um = tool.table.knots_count > 0 ? tool.table.knots[0].radius_inner_um : 0;
    for (std::uint16_t i = 0; i < tool.table.knots_count; ++i)
        um = std::min(um, tool.table.knots[i].radius_inner_um);
    return 2e-3 * um;
}

std::string mm_text(double mm)
{
    return decimals_text(mm, 2) + " mm";
}

} // namespace

DeviceCabinet::DeviceCabinet(const Case &lesson) : lesson_(lesson)
{
    for (const std::string &path : lesson.offered) devices_.push_back({path, read_instrument(path), false});
    // The same kind of device may be offered twice; the session begins with as many of these devices as the
    // case names.
    for (const std::string &path : lesson.start.tools) {
        const auto found = std::find_if(devices_.begin(), devices_.end(), [&](const CabinetDevice &device) {
            return device.path == path && !device.is_on_line;
        });
        if (found != devices_.end()) found->is_on_line = true;
    }
    for (const std::string &path : lesson.stents) stents_.push_back(read_stent(path));
    look_at_line();
}

void DeviceCabinet::look_at_line()
{
    line_ = sorted_line();
    findings_ = found();
}

void DeviceCabinet::toggle(std::size_t device)
{
    CabinetDevice &chosen = devices_.at(device);
    if (!chosen.is_on_line && line_.size() >= line_max) return;
    chosen.is_on_line = !chosen.is_on_line;
    look_at_line();
}

std::vector<std::size_t> DeviceCabinet::sorted_line() const
{
    std::vector<std::size_t> line;
    for (std::size_t i = 0; i < devices_.size(); ++i)
        if (devices_[i].is_on_line) line.push_back(i);
    // Devices of the same width, such as a balloon and a catheter, are sorted in the order that the case
    // states.
    const auto rank = [&](std::size_t i) {
        const auto &start = lesson_.start.tools;
        return std::find(start.begin(), start.end(), devices_[i].path) - start.begin();
    };
    std::stable_sort(line.begin(), line.end(), [&](std::size_t a, std::size_t b) {
        const double wide_a = outer_mm(devices_[a].instrument), wide_b = outer_mm(devices_[b].instrument);
        return wide_a != wide_b ? wide_a < wide_b : rank(a) < rank(b);
    });
    return line;
}

std::vector<std::string> DeviceCabinet::paths() const
{
    std::vector<std::string> paths;
    for (const CabinetDevice &device : devices_) paths.push_back(device.path);
    return paths;
}

// Tries every choice of positions that stay without a device. The best choice has the most devices at the
// positions that the case states; among equal choices, a device without a lumen should be innermost, and the
// outermost device as far outside as possible.
std::vector<std::optional<std::size_t>> DeviceCabinet::positions() const
{
    const std::size_t count = lesson_.start.tools.size();
    std::vector<std::optional<std::size_t>> best(count);
    int best_points = -1;
    for (unsigned taken = 0; taken < 1u << count; ++taken) {
        if (static_cast<std::size_t>(std::popcount(taken)) != std::min(line_.size(), count)) continue;
        std::vector<std::optional<std::size_t>> way(count);
        int points = 0;
        std::size_t next = 0;
        for (std::size_t k = 0; k < count; ++k) {
            if (!(taken >> k & 1u)) continue;
            way[k] = line_[next++];
            const CabinetDevice &device = devices_[*way[k]];
            const bool has_lumen = inner_mm(device.instrument) > 0.0;
            points += (device.path == lesson_.start.tools[k] ? 4 : 0) + (k == 0 && !has_lumen ? 2 : 0) +
                      (k + 1 == count && has_lumen ? 1 : 0);
        }
        if (points > best_points) {
            best_points = points;
            best = way;
        }
    }
    return best;
}

std::vector<std::string> DeviceCabinet::line_words() const
{
    std::vector<std::string> words;
    for (const auto &device : positions())
        words.push_back(device ? std::to_string(*device + 1) : std::string(free_position));
    return words;
}

std::vector<double> DeviceCabinet::inserted_mm() const
{
    std::vector<double> lengths;
    const auto at = positions();
    for (std::size_t k = 0; k < at.size() && k < lesson_.start.inserted_um.size(); ++k) {
        const double stated_mm = lesson_.start.inserted_um[k] * 1e-3;
        lengths.push_back(!at[k] ? 0.0 : stated_mm > 0.0 ? stated_mm : unstated_mm);
    }
    return lengths;
}

std::vector<DeviceCabinet::Finding> DeviceCabinet::found() const
{
    std::vector<Finding> findings;
    for (std::size_t k = 0; k + 1 < line_.size(); ++k) {
        const Instrument &inside = devices_[line_[k]].instrument,
                         &outside = devices_[line_[k + 1]].instrument;
        const std::string refusal = nesting_refusal(inside, outside);
        if (!refusal.empty())
            findings.push_back({false, refusal + ". Choose a wider or a thinner device."});
        else
            findings.push_back(
                {true, "'" + inside.name + "' (" + mm_text(outer_mm(inside)) + " outside) passes '" +
                           outside.name + "' (" + mm_text(inner_mm(outside)) +
                           " inside): " + mm_text(inner_mm(outside) - outer_mm(inside)) + " of room."});
    }
    for (const StentDesign &stent : stents_) {
        const auto fits = std::find_if(devices_.begin(), devices_.end(), [&](const CabinetDevice &device) {
            return device.instrument.table.balloon_count > 0 &&
                   mount_refusal(stent, {device.instrument}).empty();
        });
        if (fits == devices_.end())
            findings.push_back(
                {false, "The stent '" + stent.name + "' cannot be used: no device carries it."});
        else
            findings.push_back({true, "The stent '" + stent.name + "' fits '" + fits->instrument.name + "'" +
                                          (fits->is_on_line ? "." : ", which stays on the table.")});
    }
    return findings;
}

std::string DeviceCabinet::refusal() const
{
    const std::size_t most = lesson_.start.tools.size(), have = line_.size();
    if (have == 0) return "No device is on the line: put at least one there.";
    if (have > most)
        return formatted("The line of this case has %zu position%s, and %zu devices are chosen.", most,
                         most == 1 ? "" : "s", have);
    for (const Finding &finding : findings_)
        if (!finding.is_good) return finding.text;
    return "";
}

PrepPage::PrepPage(Ui &ui, CaseCard card)
    : ui_(ui), version_(++pages_opened), card_(std::move(card)), cabinet_(*card_.options.lesson),
      scene_([recipe = card_.options.lesson->recipe](TaskProgress &progress) {
          return prepare_scene(recipe, [&](const SceneProgress &made) {
              const std::string text = made.steps > 0
                                           ? formatted("%s (step %d of %d, %.0f s)", made.stage.c_str(),
                                                       made.step, made.steps, made.seconds)
                                           : made.stage;
              return progress.tell(text, -1.0);
          });
      })
{
}

WindowOptions PrepPage::options() const
{
    WindowOptions options = card_.options;
    options.scene = scene_.result()->scene;
    options.pictures.bodies_path = scene_.result()->bodies;
    options.tools = cabinet_.paths();
    options.line = cabinet_.line_words();
    options.inserted_mm = cabinet_.inserted_mm();
    return options;
}

void PrepPage::toggle(std::size_t device)
{
    if (device < cabinet_.devices().size()) cabinet_.toggle(device);
}

PageChoice PrepPage::draw()
{
    PageChoice choice;
    begin_page(ui_, "prep", card_.name.c_str(), card_.goal.c_str());
    const float w = ui_.window().width(), h = ui_.window().height();
    const float margin = ui_.px(page_margin), top = ui_.px(112.0f), gap = ui_.px(28.0f);
    const float height = h - top - ui_.px(24.0f);
    const float side = std::min(0.37f * w, height - ui_.px(side_text));
    ImGui::SetCursorScreenPos({margin, top});
    ImGui::BeginChild("task", {w - 2.0f * margin - side - gap, height}); // scrolls in a small window
    if (ImGui::BeginTable("texts", 2, ImGuiTableFlags_SizingStretchProp)) {
        ImGui::TableSetupColumn("patient", ImGuiTableColumnFlags_WidthStretch, 0.45f);
        ImGui::TableSetupColumn("goals", ImGuiTableColumnFlags_WidthStretch, 0.55f);
        ImGui::TableNextColumn();
        draw_patient();
        ImGui::TableNextColumn();
        draw_goals();
        ImGui::EndTable();
    }
    ImGui::Dummy({1.0f, ui_.px(14.0f)});
    draw_cabinet();
    ImGui::EndChild();
    draw_side({w - margin - side, top, side, height}, choice);
    ui_.end_panel();
    return choice;
}

void PrepPage::draw_patient()
{
    const Case &lesson = *card_.options.lesson;
    ImGui::PushTextWrapPos(0.0f);
    ui_.small_text(tint::dim, "PATIENT (invented)");
    ImGui::PushFont(ui_.fonts().bold);
    ui_.text(tint::text, "%s", lesson.patient.name.c_str());
    ImGui::PopFont();
    ui_.text(tint::text, "%s, %d years", lesson.patient.sex.c_str(), lesson.patient.age_years);
    ImGui::Dummy({1.0f, ui_.px(6.0f)});
    ui_.small_text(tint::dim, "INDICATION");
    ui_.text(tint::text, "%s", lesson.patient.indication.c_str());
    if (!lesson.patient.history.empty()) {
        ui_.small_text(tint::dim, "HISTORY");
        ui_.text(tint::text, "%s", lesson.patient.history.c_str());
    }
    ImGui::Dummy({1.0f, ui_.px(6.0f)});
    ui_.small_text(tint::dim, "STORY");
    std::string story = lesson.story;
    std::replace(story.begin(), story.end(), '\n', ' ');
    ui_.text(tint::text, "%s", story.c_str());
    ImGui::PopTextWrapPos();
}

void PrepPage::draw_goals()
{
    const Case &lesson = *card_.options.lesson;
    ImGui::PushTextWrapPos(0.0f);
    ui_.small_text(tint::dim, "GOALS");
    for (const CaseGoal &goal : lesson.goals)
        ui_.text(tint::sky, "\u25cb %s  (%.0f marks)", goal.text.c_str(), goal.marks);
    if (!lesson.limits.empty()) {
        ImGui::Dummy({1.0f, ui_.px(6.0f)});
        ui_.small_text(tint::dim, "LIMITS");
        for (const CaseLimit &limit : lesson.limits) ui_.text(tint::text, "%s", limit_text(limit).c_str());
    }
    ImGui::PopTextWrapPos();
}

void PrepPage::draw_device(std::size_t device, const std::vector<std::optional<std::size_t>> &line)
{
    const CabinetDevice &shown = cabinet_.devices()[device];
    const auto place = std::find(line.begin(), line.end(), device);
    ImGui::TableNextRow();
    ImGui::TableNextColumn();
    ImGui::AlignTextToFramePadding();
    const std::string key = screen_key_text(ScreenControlId::cabinet, device);
    ui_.text(tint::dim, "%s", key.c_str());
    ImGui::TableNextColumn();
    const std::string name = "device " + std::to_string(device + 1);
    const std::string label = !shown.is_on_line ? "put on the line"
                              : place == line.end()
                                  ? "no position left"
                                  : formatted("on the line: %d", static_cast<int>(place - line.begin()) + 1);
    if (shown.is_on_line) ImGui::PushStyleColor(ImGuiCol_Text, tint::orange);
    const bool is_pressed = ui_.plain_button(
        name.c_str(), label.c_str(), 124.0f,
        ("Puts the device on the line, or takes it off. Position 1 is the innermost.\nKey: " + key).c_str());
    if (shown.is_on_line) ImGui::PopStyleColor();
    if (is_pressed) cabinet_.toggle(device);
    const Instrument &tool = shown.instrument;
    ImGui::TableNextColumn();
    ImGui::AlignTextToFramePadding();
    ui_.text(tint::text, "%s", tool.name.c_str());
    ui_.note_last_item("cabinet " + std::to_string(device + 1), label + "  " + tool.name);
    ui_.tooltip(tool.description);
    ImGui::TableNextColumn();
    ImGui::AlignTextToFramePadding();
    ui_.text(tint::text, "%s", mm_text(outer_mm(tool)).c_str());
    ui_.tooltip(formatted("%.1f French", outer_mm(tool) / french_mm));
    ImGui::TableNextColumn();
    ImGui::AlignTextToFramePadding();
    const double inside = inner_mm(tool);
    ui_.text(inside > 0.0 ? tint::text : tint::dim, "%s",
             inside > 0.0 ? mm_text(inside).c_str() : "no lumen");
    ImGui::TableNextColumn();
    ImGui::AlignTextToFramePadding();
    ui_.text(tint::dim, "%.0f cm", tool.length_m * 100.0);
}

void PrepPage::draw_cabinet()
{
    ui_.small_text(tint::dim,
                   "DEVICES     what is not on the line stays on the device table, and can be loaded later");
    const std::vector<std::optional<std::size_t>> line = cabinet_.positions();
    if (ImGui::BeginTable("devices", 6, ImGuiTableFlags_SizingStretchProp | ImGuiTableFlags_RowBg)) {
        ImGui::TableSetupColumn("key", ImGuiTableColumnFlags_WidthFixed, ui_.px(28.0f));
        ImGui::TableSetupColumn("", ImGuiTableColumnFlags_WidthFixed, ui_.px(130.0f));
        ImGui::TableSetupColumn("device");
        ImGui::TableSetupColumn("outside", ImGuiTableColumnFlags_WidthFixed, ui_.px(76.0f));
        ImGui::TableSetupColumn("inside", ImGuiTableColumnFlags_WidthFixed, ui_.px(76.0f));
        ImGui::TableSetupColumn("length", ImGuiTableColumnFlags_WidthFixed, ui_.px(66.0f));
        ImGui::TableHeadersRow();
        for (std::size_t i = 0; i < cabinet_.devices().size(); ++i) draw_device(i, line);
        ImGui::EndTable();
    }
    ImGui::PushTextWrapPos(0.0f);
    for (const DeviceCabinet::Finding &finding : cabinet_.findings())
        ui_.text(finding.is_good ? tint::green : tint::orange, "%s %s", finding.is_good ? "\u25cf" : "\u25b2",
                 finding.text.c_str());
    const std::string refusal = cabinet_.refusal();
    if (!refusal.empty()) ui_.text(tint::orange, "%s", refusal.c_str());
    ImGui::PopTextWrapPos();
}

void PrepPage::draw_scene_state()
{
    ImGui::PushTextWrapPos(0.0f);
    if (scene_.result())
        ui_.small_text(tint::green, "The anatomy is ready.");
    else if (!scene_.trouble().empty())
        ui_.small_text(tint::red, "%s", scene_.trouble().c_str());
    else
        ui_.small_text(tint::yellow,
                       "Please wait: %s.\nA new anatomy takes one to three minutes; it is kept.",
                       scene_.progress().stage().c_str());
    ImGui::PopTextWrapPos();
}

void PrepPage::draw_side(const UiRect &place, PageChoice &choice)
{
    ImGui::SetCursorScreenPos({place.x, place.y});
    ImGui::BeginChild("prep side", {place.width, place.height});
    ui_.small_text(tint::dim, "REFERENCE PICTURE (of an expert's run)");
    const ImVec2 at = ImGui::GetCursorScreenPos();
    const float edge = std::min(place.width, place.height - ui_.px(side_text));
    ImDrawList *draw = ImGui::GetWindowDrawList();
    draw->AddRectFilled(at, {at.x + edge, at.y + edge}, IM_COL32(8, 10, 12, 255));
    if (!card_.picture.bytes.empty()) {
        void *texture =
            ui_.window().texture(prep_slot, card_.picture.width, card_.picture.bytes, version_, false);
        draw->AddImage(texture, at, {at.x + edge, at.y + edge});
    }
    ImGui::Dummy({edge, edge + ui_.px(10.0f)});
    draw_scene_state();
    ImGui::Dummy({1.0f, ui_.px(6.0f)});
    const bool can_begin = is_ready();
    ImGui::PushStyleColor(ImGuiCol_Button, can_begin ? tint::orange : tint::raised);
    ImGui::PushStyleColor(ImGuiCol_ButtonHovered, can_begin ? tint::orange : tint::raised);
    ImGui::PushStyleColor(ImGuiCol_Text, can_begin ? tint::background : tint::dim);
    const bool is_pressed = ui_.screen_button(ScreenControlId::begin, "Start", -1.0f);
    ImGui::PopStyleColor(3);
    if (can_begin) ui_.note("ready", {at.x, at.y, edge, edge});
    if (is_pressed && can_begin) choice.kind = PageChoice::Kind::start_case;
    if (ui_.screen_button(ScreenControlId::leave_prep, scene_.is_done() ? "Back" : "Cancel", -1.0f))
        choice.kind = PageChoice::Kind::start;
    if (!card_.best.empty()) ui_.small_text(tint::green, "Best score: %s", card_.best.c_str());
    ImGui::EndChild();
}

std::string limit_text(const CaseLimit &limit)
{
    const Measure &measure = measure_named(limit.measure);
    const std::string unit = *measure.unit ? std::string(" ") + measure.unit : std::string();
    const bool is_little_good = limit.full_at < limit.none_at;
    return formatted("%s: %.0f marks %s %s%s, none %s %s%s", measure.title, limit.marks,
                     is_little_good ? "up to" : "from", number_text(limit.full_at, 3).c_str(), unit.c_str(),
                     is_little_good ? "from" : "up to", number_text(limit.none_at, 3).c_str(), unit.c_str());
}

} // namespace crn
