// In the editor, keys and mouse change the points of the project. After each change the editor fits and draws
// the tree again.
#include "tools/centreline/fit/editor.hpp"
#include "host/base/pending_file.hpp"
#include "host/screen/screen.hpp"
#include "tools/centreline/fit/guided.hpp"
#include "tools/centreline/fit/tree_picture.hpp"
#include "tools/centreline/formats.hpp"

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <thread>

namespace crn::centreline
{
namespace
{

constexpr int window_edge = 768;
constexpr double near_px = 9, turn_deg_per_px = 0.4;
constexpr Ink text_ink{20, 24, 34}, notice_ink{170, 30, 20};
const char *const help[] = {
    "LEFT CLICK  set a point, or take one and drag it", "S  E  B     next: start, end, bifurcation",
    "RIGHT DRAG  turn      MIDDLE DRAG  shift",         "WHEEL + -   zoom      ARROWS  turn",
    "F  fit      A  let it propose the points",         "DEL  remove the point that was taken",
    "CTRL Z, Y   undo, redo      CTRL S  save",         "H  this help     ESC  save and end"};

class Editor
{
  public:
    Editor(const Lumen &lumen, Project &project, const EditorWish &wish, bake::Progress &progress)
        : lumen_(lumen), project_(project), wish_(wish), progress_(progress),
          screen_("Cournand centreline", window_edge),
          view_(view_of(lumen.wall(), 0, 0, window_edge, window_edge))
    {
        screen_.on_key([this](const Screen::KeyEvent &event) {
            if (event.is_press || event.is_repeat) take_key(event.key);
        });
        screen_.on_pointer([this](const Screen::PointerEvent &event) { take_pointer(event); });
        notice_ = project.was_resumed()
                      ? "resumed " + project.file().filename().string() + ", H shows the keys"
                      : "click into the vessel where the blood comes in";
        if (project.was_resumed()) kind_ = PointKind::end;
        shows_help_ = !project.was_resumed();
    }

    // Returns false when a signal has closed the editor's window.
    bool run()
    {
        for (int frame = 0; wish_.frames == 0 || frame < wish_.frames; ++frame) {
            screen_.poll();
            if (screen_.wants_close() || wants_end_ || bake::Progress::interrupted()) break;
            if (is_dirty_)
                show();
            else
                std::this_thread::sleep_for(std::chrono::milliseconds(12));
        }
        const bool was_stopped = bake::Progress::interrupted();
        save();
        std::string error;
        if (!wish_.screenshot.empty() && !write_png(wish_.screenshot, screen_.read_back(), error))
            throw std::runtime_error(error);
        return !was_stopped;
    }

  private:
    void say(const std::string &text, bool is_bad = false)
    {
        notice_ = text;
        is_bad_ = is_bad;
        is_dirty_ = true;
    }

    // Calls a function that may throw a Fault; after a Fault the editor's window stays open and shows the
    // reason.
    template <typename Work> void attempt(Work work)
    {
        try {
            work();
        } catch (const Fault &fault) {
            say(fault.what(), true);
        } catch (const OutputError &error) {
            say(error.what(), true);
        }
    }

    void changed(const std::string &what)
    {
        chosen_ = std::min(chosen_, static_cast<int>(project_.points().size()) - 1);
        is_tree_old_ = true;
        say(what);
    }

    void take_key(int key)
    {
        const bool with_control =
            screen_.is_down(GLFW_KEY_LEFT_CONTROL) || screen_.is_down(GLFW_KEY_RIGHT_CONTROL);
        if (with_control) return take_control_key(key);
        switch (key) {
        case GLFW_KEY_S:
            kind_ = PointKind::start;
            return say("next click: a start");
        case GLFW_KEY_E:
            kind_ = PointKind::end;
            return say("next click: an end");
        case GLFW_KEY_B:
            kind_ = PointKind::bifurcation;
            return say("next click: a bifurcation");
        case GLFW_KEY_F:
            return fit();
        case GLFW_KEY_A:
            return propose();
        case GLFW_KEY_H:
            shows_help_ = !shows_help_;
            is_dirty_ = true;
            return;
        case GLFW_KEY_DELETE:
        case GLFW_KEY_BACKSPACE:
            return remove();
        case GLFW_KEY_LEFT:
            return turn(-5, 0);
        case GLFW_KEY_RIGHT:
            return turn(5, 0);
        case GLFW_KEY_UP:
            return turn(0, 5);
        case GLFW_KEY_DOWN:
            return turn(0, -5);
        case GLFW_KEY_EQUAL:
        case GLFW_KEY_KP_ADD:
            return zoom(1.15, window_edge / 2.0, window_edge / 2.0);
        case GLFW_KEY_MINUS:
        case GLFW_KEY_KP_SUBTRACT:
            return zoom(1 / 1.15, window_edge / 2.0, window_edge / 2.0);
        case GLFW_KEY_ESCAPE:
            wants_end_ = true;
            return;
        default:
            return;
        }
    }

    void take_control_key(int key)
    {
        // Where GLFW reports the letter that a key has in the user's keyboard layout, the editor uses this
        // letter.
        const char *name = glfwGetKeyName(key, 0);
        const char letter = name ? name[0] : static_cast<char>(key + ('a' - 'A'));
        if (letter == 's') attempt([&] { save(); });
        if (letter == 'z') project_.undo() ? changed("undone") : say("there is nothing to undo");
        if (letter == 'y') project_.redo() ? changed("done again") : say("there is nothing to do again");
    }

    void take_pointer(const Screen::PointerEvent &event)
    {
        using Kind = Screen::PointerEvent::Kind;
        const double dx = event.x - last_x_, dy = event.y - last_y_;
        last_x_ = event.x;
        last_y_ = event.y;
        if (event.kind == Kind::wheel) return zoom(std::pow(1.15, event.wheel), event.x, event.y);
        if (event.kind == Kind::press) {
            held_ = event.button;
            if (event.button == GLFW_MOUSE_BUTTON_LEFT) attempt([&] { press(event.x, event.y); });
        }
        if (event.kind == Kind::move && held_ == GLFW_MOUSE_BUTTON_RIGHT)
            turn(-dx * turn_deg_per_px, dy * turn_deg_per_px);
        if (event.kind == Kind::move && held_ == GLFW_MOUSE_BUTTON_MIDDLE) {
            view_.middle_mm -=
                view_.ray_start_mm(event.x, event.y) - view_.ray_start_mm(event.x - dx, event.y - dy);
            look_anew();
        }
        if (event.kind == Kind::move && held_ == GLFW_MOUSE_BUTTON_LEFT && is_dragging_)
            drag(event.x, event.y);
        if (event.kind != Kind::release) return;
        held_ = -1;
        if (is_dragging_) attempt([&] { drop(event.x, event.y); });
    }

    void press(double x, double y)
    {
        pressed_x_ = x;
        pressed_y_ = y;
        const std::vector<Point> &points = project_.points();
        double nearest = near_px;
        int taken = -1;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const SheetPoint at = view_.place(points[i].position_mm);
            const double distance = std::hypot(at.x - x, at.y - y);
            if (distance < nearest) nearest = distance, taken = static_cast<int>(i);
        }
        if (taken >= 0) {
            chosen_ = taken;
            is_dragging_ = true;
            dragged_from_ = points[taken].position_mm;
            return say(std::string("took the ") + kind_name(points[taken].kind) + " point " +
                       std::to_string(taken + 1) + ": drag it, or DEL");
        }
        const auto place = picked(lumen_, view_, x, y);
        if (!place) return say("there is no vessel", true);
        Point point;
        point.kind = kind_;
        point.position_mm = *place;
        project_.add(point);
        chosen_ = static_cast<int>(project_.points().size()) - 1;
        changed(std::string(kind_name(kind_)) + " point " + std::to_string(chosen_ + 1) + " set");
        if (kind_ == PointKind::start) kind_ = PointKind::end;
    }

    // Moves the selected point with the mouse pointer, at a constant distance from the viewer.
    void drag(double x, double y)
    {
        const Eigen::Vector3d along = view_.axes().row(2), on_plane = view_.ray_start_mm(x, y);
        project_.drag(static_cast<std::size_t>(chosen_),
                      on_plane + along * along.dot(dragged_from_ - on_plane));
        is_dirty_ = true;
    }

    void drop(double x, double y)
    {
        is_dragging_ = false;
        const auto which = static_cast<std::size_t>(chosen_);
        project_.drag(which, dragged_from_);
        if (std::hypot(x - pressed_x_, y - pressed_y_) < 3)
            return; // a movement this small is a selection only
        const Eigen::Vector3d along = view_.axes().row(2), on_plane = view_.ray_start_mm(x, y);
        const Eigen::Vector3d at = on_plane + along * along.dot(dragged_from_ - on_plane);
        const long voxel = lumen_.voxels().nearest(at, 1.5 * lumen_.voxels().voxel_mm());
        std::optional<Eigen::Vector3d> place;
        if (voxel >= 0)
            place = lumen_.voxels().centre_mm(lumen_.voxels().middle_near(static_cast<std::size_t>(voxel)));
        if (!place) place = picked(lumen_, view_, x, y);
        if (!place) return say("there is no vessel: the point stays where it was", true);
        project_.move(which, *place);
        changed("moved");
    }

    void remove()
    {
        if (chosen_ < 0) return say("take a point first, by a click on it");
        project_.remove(static_cast<std::size_t>(chosen_));
        chosen_ = -1;
        changed("removed");
    }

    void fit()
    {
        say("fitting ...");
        show();
        attempt([&] {
            std::vector<std::string> notes;
            tree_ = fit_points(lumen_, project_.points(), wish_.automatic.grow, notes, progress_);
            set_flow(tree_, wish_.flow);
            is_tree_old_ = false;
            say(notes.empty() ? "fitted " + std::to_string(tree_.branches.size()) + " branches"
                              : notes.front());
        });
    }

    void propose()
    {
        say("looking for ends and bifurcations ...");
        show();
        attempt([&] {
            std::vector<std::string> notes;
            const Tree found = fit_automatic(lumen_, wish_.automatic, notes, progress_);
            project_.replace(points_of(found));
            chosen_ = -1;
            changed("proposed " + std::to_string(project_.points().size()) + " points: correct them, then F");
        });
    }

    void save()
    {
        project_.save();
        if (!wish_.output.empty() && !tree_.branches.empty() && !is_tree_old_)
            write_tree(wish_.output, tree_);
        say("saved " + project_.file().filename().string());
    }

    void turn(double turn_deg, double tilt_deg)
    {
        view_.turn_deg = std::remainder(view_.turn_deg + turn_deg, 360.0);
        view_.tilt_deg = std::clamp(view_.tilt_deg + tilt_deg, -90.0, 90.0);
        look_anew();
    }

    // When the view is enlarged, the point of the vessel under the mouse pointer stays there.
    void zoom(double factor, double x, double y)
    {
        const Eigen::Vector3d before = view_.ray_start_mm(x, y);
        view_.pixels_per_mm = std::clamp(view_.pixels_per_mm * factor, 0.2, 200.0);
        view_.middle_mm += before - view_.ray_start_mm(x, y);
        look_anew();
    }

    void look_anew()
    {
        glass_.clear();
        is_dirty_ = true;
    }

    // Draws lines of text on a dark background, so that the text can be read in front of the picture.
    static void panel(Sheet &sheet, int top, const std::vector<std::string> &lines, Ink ink)
    {
        int width = 0, y = top + 8;
        for (const std::string &line : lines) width = std::max(width, Sheet::text_width(line, 2));
        for (int row = top; !lines.empty() && row < y + 20 * static_cast<int>(lines.size()); ++row)
            for (int column = 0; column < width + 20; ++column)
                sheet.blend(column, row, {255, 255, 255}, 0.85);
        for (const std::string &line : lines) {
            sheet.text(10, y, line, 2, ink);
            y += 20;
        }
    }

    void show()
    {
        if (glass_.empty()) glass_ = glass_of(lumen_.wall(), view_);
        TreeDrawing drawing;
        drawing.tree = is_tree_old_ ? nullptr : &tree_;
        drawing.points = &project_.points();
        drawing.chosen = chosen_;
        Sheet sheet = draw_tree(glass_, view_, drawing);
        std::vector<std::string> lines;
        if (shows_help_) lines.assign(std::begin(help), std::end(help));
        panel(sheet, 0, lines, text_ink);
        const std::string state =
            std::to_string(project_.points().size()) + " points, next " + kind_name(kind_) +
            (project_.is_saved() ? ", saved" : ", not saved") +
            (is_tree_old_ ? ", F fits" : ", " + std::to_string(sphere_count(tree_)) + " spheres");
        lines.clear();
        for (std::size_t at = 0; at < notice_.size() && lines.size() < 4; at += 62)
            lines.push_back(notice_.substr(at, 62));
        panel(sheet, window_edge - 74 - 20 * static_cast<int>(lines.size()), lines,
              is_bad_ ? notice_ink : text_ink);
        sheet.text(window_edge - 10 - Sheet::text_width(state, 2), window_edge - 24, state, 2, text_ink);
        screen_.show(sheet.image());
        is_dirty_ = false;
    }

    const Lumen &lumen_;
    Project &project_;
    const EditorWish &wish_;
    bake::Progress &progress_;
    Screen screen_;
    View view_;
    std::vector<float> glass_; // empty: it must be drawn again
    Tree tree_;
    bool is_tree_old_ = true, is_dirty_ = true, shows_help_ = true, wants_end_ = false, is_dragging_ = false,
         is_bad_ = false;
    PointKind kind_ = PointKind::start;
    int chosen_ = -1, held_ = -1;
    double last_x_ = 0, last_y_ = 0, pressed_x_ = 0, pressed_y_ = 0;
    Eigen::Vector3d dragged_from_ = Eigen::Vector3d::Zero();
    std::string notice_;
};

} // namespace

int run_editor(const Lumen &lumen, Project &project, const EditorWish &wish, bake::Progress &progress)
{
    if (Editor(lumen, project, wish, progress).run()) return 0;
    std::fprintf(stderr, "centreline: interrupted; the points are saved in %s\n", project.file().c_str());
    return 1;
}

} // namespace crn::centreline
