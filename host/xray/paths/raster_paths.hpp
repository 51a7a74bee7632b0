// RasterPaths is the reference for computing path lengths: an integer rasteriser that uses all processor
// cores. The depth sums are equal for any number of threads.
#pragma once
#include "host/xray/paths/raster.hpp"

namespace crn
{

class RasterPaths : public BodyPaths
{
  public:
    RasterPaths(const BodyMeshes &meshes, int threads);

    std::string_view name() const override { return "raster"; }
    void move(int body, std::span<const Eigen::Vector3i> vertices_um) override;
    bool draw(const View &view, std::span<const std::uint8_t> is_drawn, const PixelRect &rect, PathForm form,
              PathPictures &pictures, std::string &error) override;

  private:
    // Holds the depth sums of one tile of the picture, on which one thread works, and marks the channels that
    // have a body in the tile.
    struct Tile {
        std::vector<std::int32_t> sums; // [channel][tile_ints]
        std::vector<std::uint8_t> has_channel;
        std::vector<float> oblique; // of each pixel: length along the ray over depth
    };
    void project(const Camera &camera, std::span<const std::uint8_t> is_drawn, const PixelRect &rect);
    void sum_tile(const Camera &camera, const PixelRect &rect, Tile &tile) const;
    void resolve_tile(const View &view, const PixelRect &rect, Tile &tile, PathForm form,
                      PathPictures &pictures) const;
    void resolve_material(const View &view, const PixelRect &rect, const Tile &tile, int material,
                          PathForm form, PathPictures &pictures) const;

    const BodyMeshes *meshes_;
    std::unique_ptr<BodyMeshes> moved_; // own copy, made at the first move
    RasterVertices vertices_;
    std::vector<int> materials_; // named by any channel
    int threads_;
    Projection projection_;
    std::vector<Tile> tiles_; // of each thread
};

} // namespace crn
