// Draws the text and the traces of the display over the picture. The sizes of letters are stated for a
// picture of 512 pixels; in larger pictures the letters are larger.
#include "host/picture/overlay.hpp"
#include "host/base/format.hpp"
#include "host/picture/font.hpp"
#include "host/picture/room_text.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{
namespace
{

constexpr std::size_t tools_max = 8; // lines at the bottom; a line of tools has three
constexpr int name_letters = 24;
constexpr Colour white{235, 240, 240}, dim{196, 206, 210}, amber{255, 196, 64}, red{255, 96, 80},
    green{110, 235, 130}, pink{255, 150, 150}, dark{0, 0, 0};

void put(Image &rgb, int x, int y, Colour colour)
{
    if (x < 0 || y < 0 || x >= rgb.width || y >= rgb.height) return;
    std::uint8_t *pixel = rgb.bytes.data() + 3 * (static_cast<std::size_t>(y) * rgb.width + x);
    pixel[0] = colour.red;
    pixel[1] = colour.green;
    pixel[2] = colour.blue;
}

void fill_box(Image &rgb, int x0, int y0, int x1, int y1, Colour colour)
{
    for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) put(rgb, x, y, colour);
}

// Reduces the picture's brightness to a third, as a background for text.
void dim_box(Image &rgb, int x0, int y0, int x1, int y1)
{
    for (int y = std::max(y0, 0); y < std::min(y1, rgb.height); ++y)
        for (int x = std::max(x0, 0); x < std::min(x1, rgb.width); ++x) {
            std::uint8_t *pixel = rgb.bytes.data() + 3 * (static_cast<std::size_t>(y) * rgb.width + x);
            for (int c = 0; c < 3; ++c) pixel[c] = static_cast<std::uint8_t>(pixel[c] / 4);
        }
}

void draw_letters(Image &rgb, int x, int y, std::string_view text, int scale, Colour colour)
{
    for (char letter : text) {
        const auto rows = glyph(letter);
        for (int row = 0; row < glyph_rows; ++row)
            for (int column = 0; column < glyph_columns; ++column) {
                if (!(rows[row] >> (glyph_columns - 1 - column) & 1)) continue;
                const int px = x + column * scale, py = y + row * scale;
                fill_box(rgb, px, py, px + scale, py + scale, colour);
            }
        x += (glyph_columns + 1) * scale;
    }
}

class Display
{
  public:
    Display(Image &rgb, const OverlayInfo &info)
        : rgb_(rgb), info_(info), scale_(std::max(1, (rgb.width + 128) / 512)), margin_(16 * scale_),
          line_(11 * scale_)
    {
    }

    void draw()
    {
        draw_geometry();
        draw_dose();
        draw_tools();
        draw_orientation();
        if (info_.pulse) draw_pulse();
        if (!info_.notice.empty()) draw_notice();
        if (!info_.panel.empty()) draw_panel();
    }

  private:
    void left(int y, const std::string &text, Colour colour)
    {
        draw_text(rgb_, margin_, y, text, scale_, colour);
    }
    void right(int y, const std::string &text, Colour colour)
    {
        draw_text(rgb_, rgb_.width - margin_ - text_width(text, scale_), y, text, scale_, colour);
    }

    void draw_geometry()
    {
        const RoomStatus &room = info_.room;
        left(margin_, angles_text(room.carm), room.is_blocked ? red : room.is_moving ? amber : white);
        left(margin_ + line_,
             formatted("SID %.0f  FD %.0f cm", finite_or_zero(room.carm.source_detector_m) * 100.0,
                       finite_or_zero(room.carm.field_m) * 100.0),
             dim);
        left(margin_ + 2 * line_,
             formatted("FL %g p/s  %s %g/s", room.fluoro_pulses_per_s, name_of(room.program),
                       room.program_pulses_per_s),
             dim);
        int y = margin_ + 3 * line_;
        for (const std::string &text : processing_texts(room)) {
            left(y, text, room.roadmap == RoadmapState::moved ? amber : white);
            y += line_;
        }
        draw_balloon(y);
    }

    // Shows the balloon's pressure and diameter. While a lesion narrows the balloon to a waist, the function
    // shows the balloon's largest and smallest diameter.
    void draw_balloon(int y)
    {
        const OverlayBalloon &balloon = info_.balloon;
        if (!balloon.is_shown) return;
        const double wide = finite_or_zero(balloon.diameter_max_mm),
                     narrow = finite_or_zero(balloon.diameter_min_mm);
        constexpr double waist_mm = 0.05;
        const std::string pressure = formatted("BALLOON %.1f bar", finite_or_zero(balloon.pressure_bar));
        left(y, balloon.is_burst ? "BALLOON BURST" : pressure,
             balloon.is_burst             ? red
             : balloon.pressure_bar > 0.0 ? amber
                                          : dim);
        left(y + line_,
             wide - narrow > waist_mm ? formatted("  %.2f mm, waist %.2f mm", wide, narrow)
                                      : formatted("  %.2f mm", wide),
             balloon.pressure_bar > 0.0 ? white : dim);
        if (!balloon.stent.empty())
            left(y + 2 * line_, "STENT " + balloon.stent, balloon.stent.starts_with("lost") ? red : white);
    }

    // Shows the reference air kerma and its rate, the kerma-area product and the fluoroscopy time, as IEC
    // 60601-2-43 requires.
    void draw_dose()
    {
        const RoomStatus &room = info_.room;
        right(margin_, state_text(room), room.is_beam_on ? amber : dim);
        right(margin_ + line_, formatted("FL %.1f min", finite_or_zero(info_.fluoro_min)), white);
        right(margin_ + 2 * line_,
              info_.kerma_rate_mGy_min > 0.0
                  ? formatted("%.1f mGy  %.1f mGy/min", finite_or_zero(info_.kerma_mGy),
                              finite_or_zero(info_.kerma_rate_mGy_min))
                  : formatted("%.1f mGy", finite_or_zero(info_.kerma_mGy)),
              info_.dose_alert_Gy > 0.0 ? red : white);
        right(margin_ + 3 * line_, formatted("%.2f Gy cm2", finite_or_zero(info_.kap_Gy_cm2)), white);
        if (room.source != ScreenSource::nothing && (room.is_beam_on || room.source == ScreenSource::held)) {
            const XrayTechnique &with = room.technique;
            right(margin_ + 4 * line_,
                  formatted("%.0f kV  %.0f mA  %.1f ms", with.tube_voltage_kV, with.tube_current_mA,
                            with.pulse_ms),
                  room.is_underexposed ? amber : dim);
        }
        if (info_.contrast_ml > 0.0 || info_.contrast_ml_s > 0.0)
            right(margin_ + 5 * line_,
                  info_.contrast_ml_s > 0.0
                      ? formatted("INJECTION %.1f ml  %.1f ml/s", info_.contrast_ml, info_.contrast_ml_s)
                      : formatted("CONTRAST %.1f ml", info_.contrast_ml),
                  info_.contrast_ml_s > 0.0 ? amber : white);
        if (info_.dose_alert_Gy > 0.0)
            right(margin_ + 6 * line_, formatted("DOSE ABOVE %g Gy", info_.dose_alert_Gy), red);
        if (info_.fluoro_reminder_min > 0)
            right(margin_ + 7 * line_, formatted("FLUOROSCOPY %u MIN", info_.fluoro_reminder_min), amber);
    }

    // Draws the bottom line of text: on the left the forces that the user's hands feel, on the right the
    // session's time.
    void draw_tools()
    {
        const int y = rgb_.height - margin_ - 8 * scale_;
        right(y, session_clock(info_.time_s), white);
        if (info_.tools.size() == 1) return draw_one_tool(y, info_.tools.front());
        const int count = static_cast<int>(std::min(info_.tools.size(), tools_max));
        for (int k = 0; k < count; ++k) draw_line(y - (count - 1 - k) * line_, info_.tools[k]);
    }

    void draw_one_tool(int y, const OverlayTool &tool)
    {
        left(y - 3 * line_, tool.name, dim);
        left(y - 2 * line_, place(tool), white);
        left(y - line_, force(tool), white);
        draw_force_bar(y + scale_, tool.axial_N);
    }

    // Draws one row of text with the values of one of several tools; the force has the colour of the force
    // bar in the display of a single tool.
    void draw_line(int y, const OverlayTool &tool)
    {
        const int letter = 6 * scale_;
        const Colour colour = tool.is_chosen ? amber : dim;
        if (tool.is_chosen) draw_text(rgb_, margin_, y, ">", scale_, amber);
        draw_text(rgb_, margin_ + 2 * letter, y, std::string_view(tool.name).substr(0, name_letters), scale_,
                  colour);
        const int x = margin_ + (name_letters + 4) * letter;
        draw_text(rgb_, x, y,
                  formatted("%4.0f mm %+5.0f\x7f", rounded_to(tool.inserted_mm, 1.0),
                            rounded_to(tool.turned_deg, 1.0)),
                  scale_, white);
        draw_text(rgb_, x + 16 * letter, y,
                  formatted("%5.2f N %5.1f mNm", rounded_to(tool.axial_N, 100.0),
                            rounded_to(tool.torque_mN_m, 10.0)),
                  scale_, force_colour(tool.axial_N));
    }

    static std::string place(const OverlayTool &tool)
    {
        return formatted("%.0f mm  %+.0f\x7f", rounded_to(tool.inserted_mm, 1.0),
                         rounded_to(tool.turned_deg, 1.0));
    }
    static std::string force(const OverlayTool &tool)
    {
        return formatted("%.2f N  %.1f mNm", rounded_to(tool.axial_N, 100.0),
                         rounded_to(tool.torque_mN_m, 10.0));
    }

    double force_share(double axial_N) const
    {
        return std::clamp(finite_or_zero(std::fabs(axial_N) / info_.axial_full_scale_N), 0.0, 1.0);
    }
    Colour force_colour(double axial_N) const
    {
        const double share = force_share(axial_N);
        return share < 0.4 ? white : share < 0.75 ? amber : red;
    }

    void draw_force_bar(int y, double axial_N)
    {
        const int width = 96 * scale_, height = 5 * scale_;
        fill_box(rgb_, margin_ - scale_, y - scale_, margin_ + width + scale_, y + height + scale_, dim);
        fill_box(rgb_, margin_, y, margin_ + width, y + height, dark);
        fill_box(rgb_, margin_, y, margin_ + static_cast<int>(force_share(axial_N) * width), y + height,
                 force_colour(axial_N));
    }

    // Shows the orientation of the patient at the four edges of the picture, with DICOM's letters.
    void draw_orientation()
    {
        const View view = make_view(clamp_carm(info_.room.carm), 16);
        const int middle = rgb_.height / 2 - 4 * scale_, bottom = rgb_.height - margin_ - 8 * scale_;
        const auto centred = [&](int y, const std::string &text) {
            draw_text(rgb_, (rgb_.width - text_width(text, scale_)) / 2, y, text, scale_, white);
        };
        right(middle, patient_side(view.right), white);
        left(middle, patient_side(-view.right), white);
        centred(margin_, patient_side(view.up));
        if (info_.tools.size() < 2) centred(bottom, patient_side(-view.up)); // otherwise tools fill the line
    }

    // Draws the electrocardiogram and the aortic pressure above the clock. New values overwrite the old
    // traces of the monitor from left to right.
    void draw_pulse()
    {
        const PulseMonitor &pulse = *info_.pulse;
        const int width = 144 * scale_, lane = 26 * scale_, lines = static_cast<int>(info_.tools.size()) - 1;
        const int x = rgb_.width - margin_ - width,
                  bottom = rgb_.height - margin_ - 12 * scale_ - std::max(lines, 0) * line_;
        const int pressure_y = bottom - lane, ecg_y = pressure_y - line_ - lane;
        dim_box(rgb_, x - 2 * scale_, ecg_y - line_, x + width + 2 * scale_, bottom + 2 * scale_);
        const double rate = pulse.rate_per_min();
        draw_text(rgb_, x, ecg_y - line_ + scale_,
                  rate > 0.0 ? formatted("ECG %.0f/min", rate) : std::string("ECG no beat"), scale_,
                  rate > 0.0 ? green : red);
        if (pulse.holds_breath())
            draw_text(rgb_, x + width - text_width("BREATH HELD", scale_), ecg_y - line_ + scale_,
                      "BREATH HELD", scale_, amber);
        draw_text(rgb_, x, pressure_y - line_ + scale_,
                  pulse.systolic_mmHg() > 0.0
                      ? formatted("AO %.0f/%.0f mmHg", pulse.systolic_mmHg(), pulse.diastolic_mmHg())
                      : std::string("AO"),
                  scale_, pink);
        if (info_.is_pressure_damped)
            draw_text(rgb_, x + width - text_width("DAMPED", scale_), pressure_y - line_ + scale_, "DAMPED",
                      scale_, amber);
        draw_trace(x, ecg_y, width, lane, green,
                   [](const PulseMonitor::Sample &s) { return (s.ecg_mV + 0.6) / 2.2; });
        draw_trace(x, pressure_y, width, lane, pink,
                   [](const PulseMonitor::Sample &s) { return (s.pressure_mmHg - 30.0) / 120.0; });
    }

    // In each pixel column of a trace, draws a vertical stroke over the range of the samples in that column.
    // A gap in the trace separates the newest column of pixels from the older samples.
    template <class Height>
    void draw_trace(int x, int y, int width, int height, Colour colour, Height share_of)
    {
        constexpr int gap_columns = 6;
        const auto &samples = info_.pulse->samples();
        const auto count = static_cast<int>(samples.size());
        const int written = static_cast<int>(info_.pulse->newest()) * width / count;
        const auto row = [&](int sample) {
            const double share = std::clamp(finite_or_zero(share_of(samples[sample])), 0.0, 1.0);
            return y + height - 1 - static_cast<int>(std::lround(share * (height - 1)));
        };
        for (int column = 1; column < width; ++column) {
            const bool is_old = column > written;
            if (is_old && (!info_.pulse->is_full() || column <= written + gap_columns * scale_)) continue;
            int low = rgb_.height, high = 0;
            for (int i = (column - 1) * count / width; i <= column * count / width && i < count; ++i) {
                low = std::min(low, row(i));
                high = std::max(high, row(i));
            }
            fill_box(rgb_, x + column, low, x + column + 1, high + scale_, colour);
        }
    }

    void draw_notice()
    {
        const int width = text_width(info_.notice, scale_), x = (rgb_.width - width) / 2, y = rgb_.height / 4;
        dim_box(rgb_, x - 4 * scale_, y - 4 * scale_, x + width + 4 * scale_, y + 12 * scale_);
        draw_text(rgb_, x, y, info_.notice, scale_, amber);
    }

    void draw_panel()
    {
        int width = 0;
        for (const std::string &text : info_.panel) width = std::max(width, text_width(text, scale_));
        const int height = static_cast<int>(info_.panel.size()) * line_;
        const int x = (rgb_.width - width) / 2, y = (rgb_.height - height) / 2;
        dim_box(rgb_, x - 10 * scale_, y - 10 * scale_, x + width + 10 * scale_, y + height + 8 * scale_);
        for (std::size_t i = 0; i < info_.panel.size(); ++i)
            draw_text(rgb_, x, y + static_cast<int>(i) * line_, info_.panel[i], scale_,
                      i == 0 ? amber : white);
    }

    Image &rgb_;
    const OverlayInfo &info_;
    int scale_, margin_, line_;
};

} // namespace

int text_width(std::string_view text, int scale)
{
    return text.empty() ? 0 : (static_cast<int>(text.size()) * (glyph_columns + 1) - 1) * scale;
}

void draw_text(Image &rgb, int x, int y, std::string_view text, int scale, Colour colour)
{
    for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx)
            if (dx != 0 || dy != 0) draw_letters(rgb, x + dx * scale, y + dy * scale, text, scale, dark);
    draw_letters(rgb, x, y, text, scale, colour);
}

Image compose_display(const XrayPicture &picture, const OverlayInfo &info)
{
    Image rgb{picture.size, picture.size, 3, {}};
    rgb.bytes.resize(picture.grey.size() * 3);
    for (std::size_t i = 0; i < picture.grey.size(); ++i) {
        rgb.bytes[3 * i] = picture.grey[i];
        rgb.bytes[3 * i + 1] = picture.grey[i];
        rgb.bytes[3 * i + 2] = picture.grey[i];
    }
    Display(rgb, info).draw();
    return rgb;
}

} // namespace crn
