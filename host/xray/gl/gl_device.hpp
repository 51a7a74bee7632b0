// Draws the faces of bodies in one OpenGL context, with its buffers, its program, and one picture of floats
// per channel. Only files in the same folder may include this header.
#pragma once
#include "host/xray/gl/gl_context.hpp"
#include "host/xray/paths/paths.hpp"

namespace crn
{

class GlDevice
{
  public:
    // Throws GlError.
    GlDevice(const BodyMeshes &meshes, std::unique_ptr<GlContext> context);
    ~GlDevice();
    GlDevice(const GlDevice &) = delete;
    GlDevice &operator=(const GlDevice &) = delete;

    const GlDescription &description() const { return description_; }

    // Sends the vertices of the bodies marked in `is_stale` to OpenGL, draws the bodies marked in `is_drawn`,
    // and reads back the rectangle of every channel. The values read back are sums of depths along the
    // central axis, in mm, row after row from the top. Throws GlError, GlLost.
    void draw(const BodyMeshes &meshes, std::span<const std::uint8_t> is_stale,
              std::span<const std::uint8_t> is_drawn, const View &view, const PixelRect &rect,
              std::vector<std::vector<float>> &sums_mm);

  private:
    class StateGuard;

    void build(const BodyMeshes &meshes);
    void build_texture(const BodyMeshes &meshes);
    void set_texture(const View &view);
    void send_vertices(const BodyMeshes &meshes, std::span<const std::uint8_t> is_stale) const;
    void resize(std::size_t channels, int size);
    void delete_pictures();
    void set_view(const View &view, float reference_mm) const;
    void set_state(const View &view, const PixelRect &rect) const;
    void aim_at(std::size_t channel) const;
    void check(const char *doing) const;

    std::unique_ptr<GlContext> context_;
    GlFunctions gl_;
    GlDescription description_;
    unsigned program_ = 0, array_ = 0, vertices_ = 0, indices_ = 0, framebuffer_ = 0;
    int size_max_ = 0, size_ = 0;
    std::vector<unsigned> pictures_; // one texture per channel
    // The texture of trabeculae: the places of the vertices (0: no body has it), and its block of cells.
    unsigned places_ = 0, block_ = 0;
    const std::int8_t *sent_block_ = nullptr;
    float grain_mm_ = 0.0f; // h of a cell that holds 1
};

} // namespace crn
