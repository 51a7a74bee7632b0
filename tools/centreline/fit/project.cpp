// For each undo step the project stores the whole, short list of points.
#include "tools/centreline/fit/project.hpp"
#include "host/base/pending_file.hpp"

namespace crn::centreline
{
namespace
{

constexpr std::size_t steps_max = 1000;

bool is_equal(const std::vector<Point> &a, const std::vector<Point> &b)
{
    return points_text({"", "mm", a}) == points_text({"", "mm", b});
}

} // namespace

Project::Project(const std::filesystem::path &file, const std::string &mesh, const std::string &unit)
    : file_(file)
{
    std::error_code ignored;
    if (std::filesystem::exists(file, ignored)) {
        text_ = read_points(file);
        if (!text_.mesh.empty() && text_.mesh != mesh)
            throw Fault(file.string() + ": belongs to the mesh " + text_.mesh + ", not to " + mesh +
                        ": name that mesh, or another --project");
        was_resumed_ = true;
        saved_ = points_text(text_);
    }
    text_.mesh = mesh;
    text_.unit = unit;
    if (was_resumed_) saved_ = points_text(text_);
}

// A drag with the mouse has already changed the points since the last undo step, so `move` itself records the
// points before the drag.
void Project::keep()
{
    before_.push_back(text_.points);
    if (before_.size() > steps_max) before_.erase(before_.begin());
    after_.clear();
}

void Project::add(const Point &point)
{
    if (text_.points.size() >= points_max)
        throw Fault("there are already " + std::to_string(points_max) + " points");
    keep();
    text_.points.push_back(point);
}

void Project::move(std::size_t point, const Eigen::Vector3d &to_mm)
{
    keep();
    text_.points[point].position_mm = to_mm;
}

void Project::remove(std::size_t point)
{
    keep();
    text_.points.erase(text_.points.begin() + static_cast<std::ptrdiff_t>(point));
}

void Project::replace(std::vector<Point> points)
{
    if (is_equal(points, text_.points)) return;
    keep();
    text_.points = std::move(points);
}

bool Project::undo()
{
    if (before_.empty()) return false;
    after_.push_back(std::move(text_.points));
    text_.points = std::move(before_.back());
    before_.pop_back();
    return true;
}

bool Project::redo()
{
    if (after_.empty()) return false;
    before_.push_back(std::move(text_.points));
    text_.points = std::move(after_.back());
    after_.pop_back();
    return true;
}

void Project::save()
{
    write_points(file_, text_);
    saved_ = points_text(text_);
}

} // namespace crn::centreline
