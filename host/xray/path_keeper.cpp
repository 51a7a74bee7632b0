// What changed, and who draws it.
#include "host/xray/path_keeper.hpp"
#include "host/xray/raster_paths.hpp"
#include "host/xray/tube.hpp"

namespace seld
{
namespace
{

// A picture for every material that a channel names, and none for the others.
void size_pictures(const BodyMeshes &meshes, int size, PathPictures &pictures)
{
    const std::size_t pixels = static_cast<std::size_t>(size) * size;
    for (auto &picture : pictures)
        if (picture.size() != pixels) picture.clear();
    for (const MeshChannel &channel : meshes.channels) {
        pictures[channel.own].resize(pixels);
        if (channel.parent >= 0) pictures[channel.parent].resize(pixels);
    }
}

} // namespace

PathKeeper::PathKeeper(const BodyMeshes &meshes, std::unique_ptr<BodyPaths> back_end, int threads)
    : meshes_(meshes), back_end_(std::move(back_end)), threads_(threads)
{
}

void PathKeeper::draw(std::span<const std::uint8_t> is_drawn, const PixelRect &rect, PathForm form,
                      PathPictures &pictures)
{
    if (back_end_->draw(view_, is_drawn, rect, form, pictures, error_)) return;
    back_end_ = std::make_unique<RasterPaths>(meshes_, threads_);
    std::string none;
    back_end_->draw(view_, is_drawn, rect, form, pictures, none);
}

bool PathKeeper::see(const CArm &carm, int size, std::span<const RadiopaqueInstrument> tools,
                     const WireFrame &wire)
{
    const bool is_new = !is_filled_ || !(carm_ == carm) || view_.size != size;
    if (is_new) {
        carm_ = carm;
        view_ = make_view(carm, size);
        size_pictures(meshes_, size, bodies_);
        const std::vector<std::uint8_t> all(meshes_.channel_of_body.size(), 1);
        draw(all, {0, 0, size, size}, PathForm::ray_lengths, bodies_);
        is_filled_ = true;
    }
    draw_tools(tools, wire, view_, tools_);
    return is_new;
}

} // namespace seld
