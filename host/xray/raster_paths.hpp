// The reference back end: the integer rasteriser on all cores. Equal sums for any number of threads.
#pragma once
#include "host/xray/paths.hpp"

namespace seld
{

class RasterPaths : public BodyPaths
{
  public:
    RasterPaths(const BodyMeshes &meshes, int threads) : meshes_(&meshes), threads_(threads) {}

    std::string_view name() const override { return "raster"; }
    void move(int body, std::span<const Eigen::Vector3i> vertices_um) override;
    bool draw(const View &view, std::span<const std::uint8_t> is_drawn, const PixelRect &rect, PathForm form,
              PathPictures &pictures, std::string &error) override;

  private:
    void sum_chunks(const View &view, std::span<const std::uint8_t> is_drawn);
    void resolve_row(const View &view, const PixelRect &rect, int row, PathForm form, PathPictures &pictures);

    const BodyMeshes *meshes_;
    std::unique_ptr<BodyMeshes> moved_; // own copy, from the first move on
    int threads_;
    std::vector<std::vector<std::int32_t>> sums_; // [thread], channel after channel
};

} // namespace seld
