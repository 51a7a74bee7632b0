// Draws the curves of a session in the debrief, above the timeline.
#include "host/base/format.hpp"
#include "host/suite/pages.hpp"
#include <algorithm>
#include <cfloat>

namespace crn
{
namespace
{

using Json = nlohmann::ordered_json;

constexpr ImU32 tool_tints[] = {tint::sky, tint::orange, tint::green};

struct Curve {
    std::string name;
    std::vector<double> values;
    ImU32 colour;
};

struct CurveLane {
    std::string title, unit;
    std::vector<Curve> curves;
    double highest() const
    {
        double most = 0.0;
        for (const Curve &curve : curves)
            for (const double value : curve.values) most = std::max(most, value);
        return most;
    }
};

std::vector<double> numbers(const Json &list)
{
    std::vector<double> values;
    for (const Json &one : list) values.push_back(one.is_number() ? one.get<double>() : 0.0);
    return values;
}

std::vector<CurveLane> lanes_of(const Json &assessment)
{
    const Json &curves = assessment["curves"];
    std::vector<CurveLane> lanes(1);
    lanes[0] = {"inserted length", "mm", {}};
    for (std::size_t k = 0; k < curves["inserted_mm"].size(); ++k)
        lanes[0].curves.push_back(
            {k < assessment["tools"].size() ? assessment["tools"][k].value("name", "") : "",
             numbers(curves["inserted_mm"][k]), tool_tints[k % std::size(tool_tints)]});
    if (curves["wall_N"].is_array())
        lanes.push_back({"force on the walls", "N", {{"", numbers(curves["wall_N"]), tint::yellow}}});
    CurveLane balloon{"pressure of the balloon", "bar", {{"", numbers(curves["balloon_bar"]), tint::cyan}}};
    if (balloon.highest() > 0.0) lanes.push_back(std::move(balloon));
    return lanes;
}

// The title and the names of the curves are written in one line above the curves.
void draw_title(Ui &ui, const CurveLane &lane, const UiRect &place)
{
    ImDrawList *draw = ImGui::GetWindowDrawList();
    ImFont *font = ui.fonts().small_text;
    float x = place.x;
    const auto write = [&](const std::string &text, ImU32 colour) {
        draw->AddText(font, font->FontSize, {x, place.y}, colour, text.c_str());
        x += font->CalcTextSizeA(font->FontSize, FLT_MAX, 0.0f, text.c_str()).x + ui.px(14.0f);
    };
    write(formatted("%s, 0 to %.3g %s", lane.title.c_str(), lane.highest(), lane.unit.c_str()), tint::dim);
    for (const Curve &curve : lane.curves)
        if (!curve.name.empty()) write(curve.name, curve.colour);
}

void draw_lane(Ui &ui, const CurveLane &lane, const std::vector<double> &time_s, double end_s,
               const UiRect &place)
{
    const float head = ui.px(17.0f);
    draw_title(ui, lane, place);
    const UiRect area{place.x, place.y + head, place.width, place.height - head - ui.px(5.0f)};
    ImDrawList *draw = ImGui::GetWindowDrawList();
    draw->AddRectFilled({area.x, area.y}, {area.x + area.width, area.y + area.height}, tint::background,
                        ui.px(4.0f));
    const double most = std::max(lane.highest(), 1e-9);
    const float pad = ui.px(3.0f);
    for (const Curve &curve : lane.curves) {
        std::vector<ImVec2> points;
        for (std::size_t i = 0; i < std::min(time_s.size(), curve.values.size()); ++i) {
            const double share = std::clamp(curve.values[i] / most, 0.0, 1.0);
            points.push_back(
                {area.x + area.width * static_cast<float>(std::min(time_s[i] / end_s, 1.0)),
                 area.y + area.height - pad - (area.height - 2.0f * pad) * static_cast<float>(share)});
        }
        draw->AddPolyline(points.data(), static_cast<int>(points.size()), curve.colour, 0, ui.px(1.5f));
    }
}

} // namespace

void draw_session_curves(Ui &ui, const Json &assessment, const UiRect &place)
{
    const std::vector<CurveLane> lanes = lanes_of(assessment);
    const std::vector<double> time_s = numbers(assessment["curves"]["time_s"]);
    const double end_s = std::max(assessment["ticks"].get<double>() * 1e-3, 1e-3);
    const float height = place.height / static_cast<float>(lanes.size());
    for (std::size_t i = 0; i < lanes.size(); ++i)
        draw_lane(ui, lanes[i], time_s, end_s,
                  {place.x, place.y + height * static_cast<float>(i), place.width, height});
    ui.note("curves", place, std::to_string(lanes.size()));
}

} // namespace crn
