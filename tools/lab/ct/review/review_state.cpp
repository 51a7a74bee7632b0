#include "tools/lab/ct/review/review_state.hpp"
#include "host/base/format.hpp"
#include "tools/centreline/formats.hpp"
#include <algorithm>
#include <cmath>

namespace crn::ct
{

namespace
{

constexpr int picture_px = 512;
constexpr float air_HU = -300;

// The last line that a program wrote before it ended: its message.
std::string last_line(const std::string &text)
{
    const std::size_t end = text.find_last_not_of("\n\r ");
    if (end == std::string::npos) return "";
    const std::size_t begin = text.find_last_of("\n\r", end);
    return text.substr(begin == std::string::npos ? 0 : begin + 1,
                       end - (begin == std::string::npos ? 0 : begin + 1) + 1);
}

} // namespace

ReviewState::ReviewState(std::filesystem::path folder, std::vector<std::string> command)
    : folder_(std::move(folder)), command_(std::move(command))
{
    look();
    read_clicks_file();
    std::error_code no_clicks, no_report;
    const auto clicked = std::filesystem::last_write_time(folder_.file("clicks.toml"), no_clicks),
               reported = std::filesystem::last_write_time(folder_.file("report.json"), no_report);
    clicks_changed_ = !no_clicks && (no_report || clicked > reported);
}

// A file that a person has damaged stays as it is until the first click replaces it.
void ReviewState::read_clicks_file()
{
    try {
        clicks_ = read_clicks(folder_.file("clicks.toml"));
    } catch (const std::exception &error) {
        trouble_ = error.what();
    }
}

bool ReviewState::look()
{
    bool has_changed = folder_.look();
    if (has_changed) renew();
    if (has_scan() && !had_scan_) {
        const CtVolume &scan = folder_.scan;
        cross_mm_ = scan.first_mm;
        for (int axis = 0; axis < 3; ++axis)
            cross_mm_[axis] += 0.5 * (scan.size[static_cast<std::size_t>(axis)] - 1) * scan.spacing_mm[axis];
    }
    had_scan_ = has_scan();
    if (task_ && task_->is_done()) {
        const ProgramResult *result = task_->result();
        if (!result)
            trouble_ = task_->trouble();
        else if (result->was_stopped)
            trouble_ = "stopped; what was finished is kept";
        else if (result->code != 0)
            trouble_ = last_line(result->refused).empty()
                           ? formatted("the command ended with exit code %d", result->code)
                           : last_line(result->refused);
        task_.reset();
        const std::string trouble = trouble_;
        read_clicks_file(); // the command may have added those of its options
        if (!trouble.empty()) trouble_ = trouble;
        has_changed = true;
    }
    return has_changed;
}

void ReviewState::run(const std::vector<std::string> &other)
{
    if (is_running() || command_.empty()) return;
    trouble_.clear();
    clicks_changed_ = false;
    began_ = std::chrono::steady_clock::now();
    task_ = std::make_unique<BackgroundTask<ProgramResult>>(
        [command = other.empty() ? command_ : other](TaskProgress &progress) {
            return run_program(command, [&progress] { return progress.goes_on(); });
        });
}

void ReviewState::stop()
{
    if (task_) task_->cancel();
}

double ReviewState::running_s() const
{
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
}

void ReviewState::set_cross(const Eigen::Vector3d &place_mm)
{
    if (!has_scan()) return;
    const CtVolume &scan = folder_.scan;
    for (int axis = 0; axis < 3; ++axis) {
        const double last = (scan.size[static_cast<std::size_t>(axis)] - 1) * scan.spacing_mm[axis];
        cross_mm_[axis] = std::clamp(place_mm[axis], scan.first_mm[axis], scan.first_mm[axis] + last);
    }
    renew();
}

void ReviewState::step(Section section, int steps)
{
    if (!has_scan()) return;
    const int normal = static_cast<int>(section);
    Eigen::Vector3d place = cross_mm_;
    place[normal] += steps * std::max(folder_.scan.spacing_mm[normal], 0.5 * slab_mm_);
    set_cross(place);
}

double ReviewState::cross_HU() const
{
    return has_scan() ? permille_near(folder_.scan, cross_mm_) - 1000.0 : 0.0;
}

void ReviewState::set_slab(double slab_mm)
{
    slab_mm_ = slab_mm;
    renew();
}

void ReviewState::set_grey(std::size_t preset)
{
    grey_ = std::min(preset, std::size(grey_presets) - 1);
    renew();
}

bool ReviewState::add_click(ClickKind kind, const std::string &branch)
{
    const auto refused = [this](const std::string &why) {
        trouble_ = why;
        return false;
    };
    if (!has_scan()) return refused("there is no scan to click at yet");
    if (cross_HU() < static_cast<double>(air_HU))
        return refused(formatted("the cross is in air (%.0f HU): move it into the body", cross_HU()));
    if (clicks_.size() >= clicks_max)
        return refused(formatted("there are %zu clicks, and no more can be kept: remove some", clicks_max));
    if (kind == ClickKind::name && branch.empty())
        return refused("type the name of the branch before the click");
    if (kind == ClickKind::name && branch != centreline::plain_name(branch))
        return refused("the name of a branch may have letters, digits, blanks and _-.()");
    Click click;
    click.kind = kind;
    for (int axis = 0; axis < 3; ++axis) click.at_mm[axis] = std::round(cross_mm_[axis] * 10) / 10;
    click.branch = kind == ClickKind::name ? branch : "";
    trouble_.clear();
    clicks_.push_back(click);
    save_clicks();
    return true;
}

void ReviewState::remove_click(std::size_t number)
{
    if (number >= clicks_.size()) return;
    trouble_.clear();
    clicks_.erase(clicks_.begin() + static_cast<std::ptrdiff_t>(number));
    save_clicks();
}

void ReviewState::save_clicks()
{
    write_clicks(folder_.file("clicks.toml"), clicks_);
    clicks_changed_ = true;
}

void ReviewState::renew()
{
    for (View &view : views_) view.is_old = true;
}

ReviewState::View &ReviewState::view(Section section)
{
    View &view = views_[static_cast<std::size_t>(section)];
    if (view.is_old && has_scan()) {
        view.picture =
            section_of(folder_.scan, section, cross_mm_, slab_mm_, grey_presets[grey_].grey, picture_px);
        view.outline = outline_of(folder_.lumen, section, cross_mm_[static_cast<int>(section)]);
        ++view.version;
        view.is_old = false;
    }
    return view;
}

const SectionPicture &ReviewState::picture(Section section)
{
    return view(section).picture;
}

const Outline &ReviewState::outline(Section section)
{
    return view(section).outline;
}

std::uint64_t ReviewState::version(Section section) const
{
    return views_[static_cast<std::size_t>(section)].version;
}

} // namespace crn::ct
