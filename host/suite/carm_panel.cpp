// Draws the panel of the C-arm: a small spatial view of arm, table and patient, the dial of the angles, the
// standard views, a cross for the table's position, and the field.
#include "host/base/format.hpp"
#include "host/picture/room_text.hpp"
#include "host/suite/suite_screen.hpp"
#include "host/suite/ui_text.hpp"
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace crn
{
namespace
{

struct Face {
    std::array<ImVec2, 4> corners;
    float depth = 0.0f;
    ImU32 colour = 0;
};

// The spatial view of the C-arm looks at the isocentre from above the patient's left foot, without
// perspective.
class SpaceView
{
  public:
    SpaceView(const Eigen::Vector3d &middle_m, const UiRect &place) : middle_m_(middle_m), place_(place)
    {
        forward_ = Eigen::Vector3d(-0.55, 0.68, -0.50).normalized();
        right_ = forward_.cross(Eigen::Vector3d::UnitZ()).normalized();
        up_ = right_.cross(forward_);
        scale_ = std::min(place.width / 2.3f, place.height / 2.0f); // pixels per metre
    }
    ImVec2 point(const Eigen::Vector3d &at_m) const
    {
        const Eigen::Vector3d from = at_m - middle_m_;
        return {place_.x + 0.5f * place_.width + scale_ * static_cast<float>(from.dot(right_)),
                place_.y + 0.5f * place_.height - scale_ * static_cast<float>(from.dot(up_))};
    }
    float depth(const Eigen::Vector3d &at_m) const
    {
        return static_cast<float>((at_m - middle_m_).dot(forward_));
    }
    bool faces(const Eigen::Vector3d &normal) const { return normal.dot(forward_) < 0.0; }

    void add(const Box &box, ImU32 colour, std::vector<Face> &faces_out) const
    {
        for (int axis = 0; axis < 3; ++axis)
            for (int side : {-1, 1}) {
                const Eigen::Vector3d normal = side * box.axes[axis];
                if (!faces(normal)) continue;
                const Eigen::Vector3d u = box.axes[(axis + 1) % 3] * box.half[(axis + 1) % 3];
                const Eigen::Vector3d v = box.axes[(axis + 2) % 3] * box.half[(axis + 2) % 3];
                const Eigen::Vector3d middle = box.centre + normal * box.half[axis];
                const double light = 0.55 + 0.45 * std::fabs(normal.z());
                faces_out.push_back({{point(middle - u - v), point(middle + u - v), point(middle + u + v),
                                      point(middle - u + v)},
                                     depth(middle),
                                     shaded(colour, light)});
            }
    }

  private:
    static ImU32 shaded(ImU32 colour, double light)
    {
        const auto part = [&](int shift) {
            return static_cast<int>(static_cast<double>((colour >> shift) & 0xff) * light);
        };
        return IM_COL32(part(IM_COL32_R_SHIFT), part(IM_COL32_G_SHIFT), part(IM_COL32_B_SHIFT), 255);
    }

    Eigen::Vector3d middle_m_, forward_, right_, up_;
    UiRect place_;
    float scale_;
};

// Returns boxes that represent a person on the table; they serve only for orientation, because the interlock
// does not check the patient.
std::vector<Box> patient_boxes()
{
    const auto box = [](double y, double half_x, double half_y, double half_z) {
        return Box{{0.0, y, -0.13 + half_z},
                   {Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitZ()},
                   {half_x, half_y, half_z}};
    };
    return {box(0.10, 0.17, 0.33, 0.11), box(0.55, 0.08, 0.11, 0.10), box(-0.65, 0.14, 0.42, 0.07)};
}

} // namespace

void SuiteScreen::draw_space(const UiRect &place)
{
    const Room &room = view_->state->room;
    const GantryPose &pose = room.gantry().pose();
    const CArm carm = room.gantry().carm(room.field_m());
    const SpaceView space(carm.isocentre_m, place);
    const GantryBoxes boxes = gantry_boxes(pose);
    const ImU32 arm = room.state().is_blocked ? tint::red : IM_COL32(150, 165, 180, 255);
    std::vector<Face> faces;
    space.add(boxes.table, IM_COL32(70, 84, 98, 255), faces);
    for (const Box &part : patient_boxes()) space.add(part, IM_COL32(186, 150, 128, 255), faces);
    space.add(boxes.tube, arm, faces);
    space.add(boxes.collimator, arm, faces);
    space.add(boxes.detector, arm, faces);
    std::sort(faces.begin(), faces.end(), [](const Face &a, const Face &b) { return a.depth > b.depth; });
    ImDrawList *draw = ImGui::GetWindowDrawList();
    draw->PushClipRect({place.x, place.y}, {place.x + place.width, place.y + place.height}, true);
    draw->AddRectFilled({place.x, place.y}, {place.x + place.width, place.y + place.height},
                        tint::background);
    for (const Face &face : faces) {
        draw->AddConvexPolyFilled(face.corners.data(), 4, face.colour);
        draw->AddPolyline(face.corners.data(), 4, IM_COL32(10, 12, 14, 160), ImDrawFlags_Closed, 1.0f);
    }
    const View view = make_view(clamp_carm(carm), 16);
    draw->AddLine(space.point(view.source_m),
                  space.point(view.source_m + carm.source_detector_m * view.forward),
                  room.is_beam_on() ? tint::yellow : IM_COL32(200, 200, 200, 90), ui_.px(1.5f));
    draw->PopClipRect();
}

// Draws the dial of the C-arm's angles: LAO and RAO lie on the horizontal axis, CRA and CAU on the vertical
// axis. A click aims the C-arm.
void SuiteScreen::draw_dial(const UiRect &place)
{
    constexpr float primary_max = 120.0f, secondary_max = 50.0f;
    ImDrawList *draw = ImGui::GetWindowDrawList();
    const Gantry &gantry = view_->state->room.gantry();
    const auto at = [&](const GantryPose &pose) {
        return ImVec2{place.x +
                          place.width * (0.5f + 0.5f * static_cast<float>(pose[axis_primary]) / primary_max),
                      place.y + place.height *
                                    (0.5f - 0.5f * static_cast<float>(pose[axis_secondary]) / secondary_max)};
    };
    draw->AddRectFilled({place.x, place.y}, {place.x + place.width, place.y + place.height},
                        tint::background);
    const ImVec2 middle{place.x + 0.5f * place.width, place.y + 0.5f * place.height};
    draw->AddLine({middle.x, place.y}, {middle.x, place.y + place.height}, tint::line);
    draw->AddLine({place.x, middle.y}, {place.x + place.width, middle.y}, tint::line);
    ImGui::PushFont(ui_.fonts().small_text);
    const float pad = ui_.px(4.0f), line = ImGui::GetFontSize();
    draw->AddText({place.x + pad, middle.y - line - 1.0f}, tint::dim, "RAO");
    draw->AddText({place.x + place.width - ImGui::CalcTextSize("LAO").x - pad, middle.y - line - 1.0f},
                  tint::dim, "LAO");
    draw->AddText({middle.x + pad, place.y + 1.0f}, tint::dim, "CRA");
    draw->AddText({middle.x + pad, place.y + place.height - line - 2.0f}, tint::dim, "CAU");
    ImGui::PopFont();
    draw->AddCircle(at(gantry.target()), ui_.px(7.0f), tint::sky, 0, ui_.px(1.5f));
    draw->AddCircleFilled(at(gantry.pose()), ui_.px(4.5f), tint::orange);
    ImGui::SetCursorScreenPos({place.x, place.y});
    ImGui::InvisibleButton("dial", {place.width, place.height});
    ui_.note_last_item("dial");
    if (!ImGui::IsItemActive()) ui_.tooltip("Click: the C-arm turns to these angles.");
    if (!ImGui::IsItemActivated()) return;
    const ImVec2 mouse = ImGui::GetIO().MousePos;
    const auto mdeg = [](float share, float most) {
        return static_cast<std::int32_t>(std::lround(std::clamp(share, -1.0f, 1.0f) * most)) * 1000;
    };
    actions_.commands.push_back({RoomAction::angles,
                                 {mdeg(2.0f * (mouse.x - middle.x) / place.width, primary_max),
                                  mdeg(2.0f * (middle.y - mouse.y) / place.height, secondary_max), 0}});
}

void SuiteScreen::draw_carm(const UiRect &place)
{
    ui_.begin_panel("carm", place, "C-ARM");
    const RoomState room = view_->state->room.state();
    ImGui::SameLine();
    ui_.text(room.is_blocked  ? tint::red
             : room.is_moving ? tint::orange
                              : tint::text,
             "  %s", with_degrees(angles_text(room.carm)).c_str());
    const float pad = ui_.px(9.0f), inner = place.width - 2.0f * pad;
    constexpr float buttons = 236.0f, head = 30.0f;
    const float free_h = std::max(place.height - ui_.px(buttons + head), ui_.px(60.0f));
    const float space_h = 0.6f * free_h, dial_h = 0.4f * free_h - ui_.px(6.0f);
    draw_space({place.x + pad, place.y + ui_.px(head), inner, space_h});
    draw_dial({place.x + pad, place.y + ui_.px(head + 6.0f) + space_h, inner, dial_h});
    ImGui::SetCursorScreenPos({place.x + pad, place.y + ui_.px(head + 12.0f) + space_h + dial_h});
    ImGui::BeginGroup();
    const float third = (inner / ui_.px(1.0f) - 12.0f) / 3.0f,
                quarter = (inner / ui_.px(1.0f) - 18.0f) / 4.0f;
    const auto row = [&](std::initializer_list<ControlId> ids, float width) {
        bool is_first = true;
        for (ControlId id : ids) {
            if (!is_first) ImGui::SameLine();
            is_first = false;
            ui_.button(id, nullptr, width);
        }
    };
    using enum ControlId;
    row({rao, lao, cranial, caudal}, quarter);
    row({view_ap, view_lateral}, quarter);
    ImGui::SameLine();
    ui_.button(angles_zero, "0\u00b0 / 0\u00b0", quarter);
    ImGui::SameLine();
    ui_.button(halt, nullptr, quarter);
    ImGui::PushFont(ui_.fonts().small_text);
    row({view_spider, view_rao_caudal, view_rao_cranial}, third);
    row({view_lao_cranial, view_rca_lao, view_rca_rao}, third);
    row({view_arch, view_renal_left, view_renal_right}, third);
    row({view_iliac_left, view_iliac_right}, third);
    ImGui::SameLine();
    ui_.button(view_rao_caudal_steep, "RAO steep", third);
    ImGui::PopFont();
    row({sid_less, sid_more}, (inner / ui_.px(1.0f) - 6.0f) / 2.0f);
    ImGui::EndGroup();
    ui_.end_panel();
}

void SuiteScreen::draw_table(const UiRect &place)
{
    ui_.begin_panel("table", place, "TABLE AND FIELD");
    const RoomState room = view_->state->room.state();
    const float width = (place.width - ui_.px(18.0f)) / ui_.px(1.0f);
    const float third = (width - 12.0f) / 3.0f, quarter = (width - 18.0f) / 4.0f;
    using enum ControlId;
    ImGui::Dummy({ui_.px(third), ui_.px(26.0f)});
    ImGui::SameLine();
    ui_.button(table_head, "head", third);
    ImGui::SameLine();
    ui_.button(table_up, "up", third);
    ui_.button(table_right, "right", third);
    ImGui::SameLine();
    ui_.button(follow, "follow", third, room.follows_tip);
    ImGui::SameLine();
    ui_.button(table_left, "left", third);
    ImGui::Dummy({ui_.px(third), ui_.px(26.0f)});
    ImGui::SameLine();
    ui_.button(table_feet, "feet", third);
    ImGui::SameLine();
    ui_.button(table_down, "down", third);
    const Eigen::Vector3d &at_m = room.carm.isocentre_m;
    const auto towards = [](double along_m, const char *plus, const char *minus) {
        return formatted("%s %.0f", along_m < 0.0 ? minus : plus, std::fabs(along_m) * 1e3);
    };
    ui_.small_text(tint::text, "centre: %s, %s, %s mm", towards(at_m.x(), "left", "right").c_str(),
                   towards(at_m.y(), "head", "feet").c_str(), towards(at_m.z(), "front", "back").c_str());
    ui_.tooltip("Where the middle of the picture lies, from the middle of the patient.");
    ui_.button(field_smaller, nullptr, third);
    ImGui::SameLine();
    ui_.button(field_larger, nullptr, third);
    ImGui::SameLine();
    ui_.button(round, "round", third, room.is_round);
    ui_.small_text(tint::text, "field %.0f cm;  blades %.0f %% x %.0f %%", room.carm.field_m * 100.0,
                   room.open_width_share * 100.0, room.open_height_share * 100.0);
    ImGui::PushFont(ui_.fonts().small_text);
    ui_.button(blades_narrower, "width -", quarter);
    ImGui::SameLine();
    ui_.button(blades_wider, "width +", quarter);
    ImGui::SameLine();
    ui_.button(blades_lower, "height -", quarter);
    ImGui::SameLine();
    ui_.button(blades_higher, "height +", quarter);
    ImGui::PopFont();
    ui_.end_panel();
}

} // namespace crn
