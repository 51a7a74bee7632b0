// Keeps the path lengths of one view between frames. Bodies that do not move are redrawn only when the view
// changes, and a moving body is redrawn when its vertices change. Tools and curves are redrawn in every
// frame.
#pragma once
#include "host/xray/paths/moved.hpp"
#include "host/xray/paths/paths.hpp"

namespace crn
{

// Describes the smallest box, with sides along the axes, that contains all points of a list.
struct PointBox {
    Eigen::Vector3i low = Eigen::Vector3i::Zero(), high = Eigen::Vector3i::Zero();
};

class PathKeeper
{
  public:
    PathKeeper(const BodyMeshes &meshes, std::unique_ptr<BodyPaths> back_end, int threads);

    // Redraws whatever has changed in the scene since the last call of this function. True when `bodies()`
    // has changed.
    bool see(const CArm &carm, int size, const XrayFrame &frame);

    const View &view() const { return view_; }
    const PathPictures &bodies() const { return bodies_; } // ray lengths
    const PixelRect &changed() const { return changed_; }  // the part of them that the last call changed
    const ToolPaths &tools() const { return tools_; }      // tools and curves
    std::string_view back_end() const { return back_end_->name(); }
    const std::string &back_end_error() const { return error_; } // why another back end was abandoned

  private:
    // Moves the bodies of the back end to their positions in the frame. True when any has changed.
    bool move(const XrayFrame &frame);
    void see_view();
    void see_moved(bool is_new_view);
    PixelRect moved_rect() const;
    void take_raster();
    void draw(std::span<const std::uint8_t> is_drawn, const PixelRect &rect, PathForm form,
              PathPictures &pictures);

    const BodyMeshes &meshes_;
    std::unique_ptr<BodyPaths> back_end_;
    int threads_;
    std::string error_;

    bool is_filled_ = false;
    CArm carm_;
    View view_;
    std::vector<std::uint8_t> is_moved_; // of each body
    struct Moved {
        std::vector<Eigen::Vector3i> vertices_um; // empty: as in the scene
        PointBox box_um;
    };
    std::vector<Moved> moved_; // of each body
    PathPictures still_;       // axis sums; empty while no body is moved
    PixelRect moving_rect_, changed_;
    PathPictures bodies_;
    ToolPaths tools_;
    Material displaced_ = Material::blood;
};

} // namespace crn
