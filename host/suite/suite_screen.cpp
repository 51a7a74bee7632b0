#include "host/suite/suite_screen.hpp"
#include <algorithm>
#include <utility>

namespace crn
{
namespace
{

// Units of the layout (suite_window.hpp).
constexpr float bar_height = 36.0f, left_width = 286.0f, right_width = 318.0f, strip_height = 116.0f,
                gap = 4.0f, status_height = 30.0f, device_row = 34.0f, device_head = 26.0f;

} // namespace

SuiteActions SuiteScreen::draw(const SuiteView &view)
{
    view_ = &view;
    actions_ = {};
    collect_toasts();
    const float w = ui_.window().width(), h = ui_.window().height();
    const auto px = [&](float units) { return ui_.px(units); };
    const float top = px(bar_height + gap), left = px(left_width), right = px(right_width);
    const float devices =
        px(device_head + device_row * static_cast<float>(view.tools->size()) + rack_height());
    const float middle_x = left + px(gap), middle_w = w - left - right - 2.0f * px(gap);
    const float devices_y = h - devices, strip_y = devices_y - px(strip_height + gap);

    draw_bar({0.0f, 0.0f, w, px(bar_height)});
    const UiRect live{middle_x, top, middle_w, strip_y - px(gap + status_height) - top};
    draw_live(live);
    draw_strip({middle_x, strip_y, middle_w, px(strip_height)});
    draw_devices({middle_x, devices_y, middle_w, devices - px(rack_height())});
    draw_rack({middle_x, h - px(rack_height()), middle_w, px(rack_height())});

    const float side_h = h - top;
    const float carm_h = side_h - px(322.0f);
    draw_carm({0.0f, top, left, carm_h});
    draw_table({0.0f, top + carm_h + px(gap), left, side_h - carm_h - px(gap)});

    const float right_x = w - right, reference_h = right + px(60.0f);
    draw_reference({right_x, top, right, reference_h});
    float y = top + reference_h + px(gap);
    const float dose_h = px(112.0f), syringe_h = px(132.0f);
    draw_dose({right_x, y, right, dose_h});
    y += dose_h + px(gap);
    draw_syringe({right_x, y, right, syringe_h});
    y += syringe_h + px(gap);
    draw_inflator({right_x, y, right, h - y});
    draw_toasts({middle_x, top, middle_w, strip_y - px(gap) - top});
    if (view.shows_help) draw_help();
    return std::move(actions_);
}

} // namespace crn
