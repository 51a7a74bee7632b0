// Holds the data that the editor works on: points, undo steps and the saved text.
#pragma once
#include "tools/centreline/fit/points.hpp"

namespace crn::centreline
{

class Project
{
  public:
    // Reads the project file if it exists, and otherwise begins a new project. The name `mesh` is written
    // into the project file as given. Throws Fault.
    Project(const std::filesystem::path &file, const std::string &mesh, const std::string &unit);

    const std::vector<Point> &points() const { return text_.points; }
    // Each of the next four functions changes the points and adds one undo step.
    void add(const Point &point);
    void move(std::size_t point, const Eigen::Vector3d &to_mm);
    void remove(std::size_t point);
    void replace(std::vector<Point> points);
    // While a point is dragged, its intermediate positions are not recorded; the call of `move` at the end
    // records the whole drag as one undo step.
    void drag(std::size_t point, const Eigen::Vector3d &to_mm) { text_.points[point].position_mm = to_mm; }
    bool undo();
    bool redo();

    bool is_saved() const { return points_text(text_) == saved_; }
    void save(); // the file is written completely or not at all
    const std::filesystem::path &file() const { return file_; }
    bool was_resumed() const { return was_resumed_; }

  private:
    void keep();

    std::filesystem::path file_;
    PointText text_;
    std::string saved_;
    bool was_resumed_ = false;
    std::vector<std::vector<Point>> before_, after_;
};

} // namespace crn::centreline
