// Computes path lengths of bodies by OpenGL 3.3 core. Where a ray leaves a body, the face there adds its
// depth to a picture of floats; where the ray enters, the face subtracts its depth. The order of the faces
// does not matter, so neither a depth buffer nor sorting is needed. The class RasterPaths computes the same
// path lengths with independent code; host/xray/tests/test_gl.cpp compares the results of both. See
// docs/xray.md.
#pragma once
#include "host/xray/gl/gl_context.hpp"
#include "host/xray/paths/paths.hpp"
#include <functional>

namespace crn
{

// Opens an OpenGL context; GlPaths calls this function at the start, and again after a context was lost.
using GlOpener = std::function<std::unique_ptr<GlContext>()>;

class GlDevice;

class GlPaths final : public BodyPaths
{
  public:
    // GlPaths reads back the sums of depths, and `threads` threads convert them to integers. Throws GlError
    // if no context is available, a function is missing, or the driver refuses a shader.
    GlPaths(const BodyMeshes &meshes, GlOpener open, int threads);
    ~GlPaths() override;

    std::string_view name() const override { return "opengl"; }
    void move(int body, std::span<const Eigen::Vector3i> vertices_um) override;
    bool draw(const View &view, std::span<const std::uint8_t> is_drawn, const PixelRect &rect, PathForm form,
              PathPictures &pictures, std::string &error) override;
    bool draw_on(const PathPictures &still, bool is_new, const View &view,
                 std::span<const std::uint8_t> is_drawn, const PixelRect &rect, PathPictures &pictures,
                 std::string &error) override;
    const GlDescription &description() const { return description_; }

  private:
    void open_device();
    bool draw_rows(const PathPictures *still, const View &view, std::span<const std::uint8_t> is_drawn,
                   const PixelRect &rect, PathForm form, PathPictures &pictures, std::string &error);
    void resolve_row(const PathPictures *still, const View &view, const PixelRect &rect, int row,
                     PathForm form, PathPictures &pictures) const;

    const BodyMeshes *meshes_;
    std::unique_ptr<BodyMeshes> moved_; // own copy, made at the first move
    GlOpener open_;
    int threads_;
    GlDescription description_;
    std::unique_ptr<GlDevice> device_; // everything that lives in one context
    std::vector<std::uint8_t>
        is_stale_; // of each body: whether it moved since its vertices went to the device
    std::vector<std::vector<float>> sums_mm_; // [channel], rectangle of the last draw
};

} // namespace crn
