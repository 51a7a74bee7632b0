// RasterPaths is the reference for computing path lengths: an integer rasteriser that uses all processor
// cores. The depth sums are equal for any number of threads.
#pragma once
#include "host/xray/paths/parallel.hpp"
#include "host/xray/paths/raster.hpp"

namespace crn
{

struct DepthSums;

class RasterPaths : public BodyPaths
{
  public:
    RasterPaths(const BodyMeshes &meshes, int threads);

    std::string_view name() const override { return "raster"; }
    void move(int body, std::span<const Eigen::Vector3i> vertices_um) override;
    bool draw(const View &view, std::span<const std::uint8_t> is_drawn, const PixelRect &rect, PathForm form,
              PathPictures &pictures, std::string &error) override;
    bool draw_on(const PathPictures &still, bool is_new, const View &view,
                 std::span<const std::uint8_t> is_drawn, const PixelRect &rect, PathPictures &pictures,
                 std::string &error) override;

  private:
    // Holds the depth sums of one tile of the picture, on which one thread works. Rows count from the top of
    // the tile.
    struct Tile {
        PixelRect rect;
        std::vector<std::uint32_t> chunks; // that touch the tile
        std::vector<RowRange> rows;        // of each channel: outside them it has no body, and no valid sums
        std::vector<std::int32_t> sums;    // [channel][tile_ints]
        std::vector<float> oblique;        // of each pixel: length along the ray over depth
    };
    // Describes what becomes of the sums of a tile.
    struct Task {
        const View &view;
        PathForm form;
        const PathPictures *still; // depth sums that are added; nullptr: none
        PathPictures &pictures;
    };
    template <class Resolve>
    void draw_tiles(const Camera &camera, const PixelRect &rect, const Resolve &resolve);
    void project(const Camera &camera, std::span<const std::uint8_t> is_drawn, const PixelRect &rect);
    void sum_tile(const Camera &camera, Tile &tile) const;
    void measure_rays(const View &view, Tile &tile) const;
    void list_sums(const Tile &tile, int material, int row, int &end, DepthSums &sums) const;
    void resolve_rows(const Task &task, const Tile &tile, int material, const RowRange &rows) const;
    RowRange rows_of_material(const Tile &tile, int material) const;

    const BodyMeshes *meshes_;
    std::unique_ptr<BodyMeshes> moved_; // own copy, made at the first move
    RasterVertices vertices_;
    std::vector<int> materials_; // named by any channel
    int threads_;
    Projection projection_;
    std::vector<Tile> tiles_; // of each thread
    // The rows of each tile that bodies of each material covered at the last draw_on(): [tile][material].
    std::vector<RowRange> covered_;
    std::vector<std::uint8_t> has_still_; // whether a material's sums at rest are not 0: [tile][material]
};

} // namespace crn
