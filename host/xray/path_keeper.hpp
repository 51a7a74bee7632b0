// Path lengths of one view, kept between frames: the bodies are drawn again only when the view or they themselves have
// changed, the tools in every frame.
#pragma once
#include "host/xray/paths.hpp"
#include "host/xray/xray.hpp"

namespace seld
{

class PathKeeper
{
  public:
    PathKeeper(const BodyMeshes &meshes, std::unique_ptr<BodyPaths> back_end, int threads);

    // Draws what has changed since the last call. True when `bodies()` has changed.
    bool see(const CArm &carm, int size, std::span<const RadiopaqueInstrument> tools, const WireFrame &wire);

    const View &view() const { return view_; }
    const PathPictures &bodies() const { return bodies_; } // ray lengths
    const ToolPaths &tools() const { return tools_; }
    std::string_view back_end() const { return back_end_->name(); }
    const std::string &back_end_error() const { return error_; } // why another back end was given up

  private:
    void draw(std::span<const std::uint8_t> is_drawn, const PixelRect &rect, PathForm form,
              PathPictures &pictures);

    const BodyMeshes &meshes_;
    std::unique_ptr<BodyPaths> back_end_;
    int threads_;
    std::string error_;

    bool is_filled_ = false;
    CArm carm_;
    View view_;
    PathPictures bodies_;
    ToolPaths tools_;
};

} // namespace seld
