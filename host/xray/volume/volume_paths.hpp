// Computes the path lengths of a patient that consists of a CT, and of meshes beside it, such as a table. The
// path lengths of the CT are added to those of the meshes.
//
// A voxel is a mixture of soft tissue, fat and cortical bone (docs/xray.md, "A CT instead of meshes"). Lung
// is soft tissue of low density.
#pragma once
#include "host/xray/paths/raster_paths.hpp"
#include "host/xray/volume/ray_caster.hpp"

namespace crn
{

// Describes the mixtures by attenuations relative to that of water at the scanner's effective energy.
struct CtMixture {
    double soft_tissue = 1.0, fat = 0.92, bone = 2.6;
    double fat_width = 0.1;    // between fat - width and fat + width there is fat
    double bone_begins = 1.13; // 130 HU, the usual limit of calcium

    std::array<double, knot_count> knots_permille() const
    {
        return {(fat - fat_width) * 1e3, fat * 1e3, (fat + fat_width) * 1e3, bone_begins * 1e3};
    }
};

class VolumePaths : public BodyPaths
{
  public:
    // The last body of `meshes` stands for the CT; it has no triangles. The caster has the mixture's knots.
    VolumePaths(std::shared_ptr<const RayCaster> caster, const CtMixture &mixture, const BodyMeshes &meshes,
                int threads);

    std::string_view name() const override { return "ct"; }
    void move(int body, std::span<const Eigen::Vector3i> vertices_um) override
    {
        meshes_.move(body, vertices_um);
    }
    bool draw(const View &view, std::span<const std::uint8_t> is_drawn, const PixelRect &rect, PathForm form,
              PathPictures &pictures, std::string &error) override;
    // The CT does not move, so it is always among the bodies of `still`.
    bool draw_on(const PathPictures &still, bool is_new, const View &view,
                 std::span<const std::uint8_t> is_drawn, const PixelRect &rect, PathPictures &pictures,
                 std::string &error) override
    {
        return meshes_.draw_on(still, is_new, view, is_drawn, rect, pictures, error);
    }

  private:
    void mix();
    void add(const View &view, const PixelRect &rect, PathForm form, PathPictures &pictures);

    std::shared_ptr<const RayCaster> caster_;
    CtMixture mixture_;
    RasterPaths meshes_;
    int threads_;
    RayGrid grid_;
    RaySums sums_;
    std::array<std::vector<float>, 3> lengths_mm_; // of each ray: soft tissue, fat and bone
};

// Appends to `meshes` the body without triangles that stands for a CT, and the channels of its materials.
void append_ct(BodyMeshes &meshes);

// Chooses the rays of a picture: one ray per pixel, or fewer where the pixels are finer than the voxels.
RayGrid grid_for(const View &view, const CtVolume &volume);

} // namespace crn
