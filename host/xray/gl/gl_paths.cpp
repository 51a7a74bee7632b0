#include "host/xray/gl/gl_paths.hpp"
#include "host/xray/gl/gl_device.hpp"
#include "host/xray/paths/parallel.hpp"
#include <algorithm>

namespace crn
{

namespace
{

// Rounds a path length to the nearest multiple of 1/1024 mm. A value that is impossible for a body, such as
// NaN from a driver, counts as 0.
std::int32_t q10mm(float length_mm)
{
    const float q10 = length_mm * 1024.0f;
    const bool is_length = q10 > -1e9f && q10 < 1e9f;
    return is_length ? static_cast<std::int32_t>(q10 + (q10 < 0.0f ? -0.5f : 0.5f)) : 0;
}

} // namespace

GlPaths::GlPaths(const BodyMeshes &meshes, GlOpener open, int threads)
    : meshes_(&meshes), open_(std::move(open)), threads_(threads), is_stale_(meshes.channel_of_body.size(), 0)
{
    open_device();
}
GlPaths::~GlPaths() = default;

void GlPaths::open_device()
{
    device_.reset();
    device_ = std::make_unique<GlDevice>(*meshes_, open_());
    description_ = device_->description();
    std::fill(is_stale_.begin(), is_stale_.end(), std::uint8_t{0});
}

void GlPaths::move(int body, std::span<const Eigen::Vector3i> vertices_um)
{
    if (!moved_) moved_ = std::make_unique<BodyMeshes>(*meshes_);
    meshes_ = moved_.get();
    move_body(*moved_, body, vertices_um);
    is_stale_[body] = 1;
}

bool GlPaths::draw(const View &view, std::span<const std::uint8_t> is_drawn, const PixelRect &rect,
                   PathForm form, PathPictures &pictures, std::string &error)
{
    return draw_rows(nullptr, view, is_drawn, rect, form, pictures, error);
}

bool GlPaths::draw_on(const PathPictures &still, bool, const View &view,
                      std::span<const std::uint8_t> is_drawn, const PixelRect &rect, PathPictures &pictures,
                      std::string &error)
{
    return draw_rows(&still, view, is_drawn, rect, PathForm::ray_lengths, pictures, error);
}

bool GlPaths::draw_rows(const PathPictures *still, const View &view, std::span<const std::uint8_t> is_drawn,
                        const PixelRect &rect, PathForm form, PathPictures &pictures, std::string &error)
{
    if (rect.is_empty()) return true;
    try {
        try {
            if (!device_) open_device();
            device_->draw(*meshes_, is_stale_, is_drawn, view, rect, sums_mm_);
        } catch (const GlLost &) {
            open_device();
            device_->draw(*meshes_, is_stale_, is_drawn, view, rect, sums_mm_);
        }
    } catch (const GlError &failure) {
        error = failure.what();
        return false;
    }
    std::fill(is_stale_.begin(), is_stale_.end(), std::uint8_t{0});
    run_on_threads(threads_, [&](int thread) {
        const RowRange rows = rows_of_thread(thread, threads_, rect.y1 - rect.y0);
        for (int row = rows.begin; row < rows.end; ++row) resolve_row(still, view, rect, row, form, pictures);
    });
    return true;
}

// Converts a row of depth sums in mm to the pictures of the materials in 1/1024 mm; `row` is counted from the
// top of the rectangle. The sums of `still`, if any, are added.
void GlPaths::resolve_row(const PathPictures *still, const View &view, const PixelRect &rect, int row,
                          PathForm form, PathPictures &pictures) const
{
    const int width = rect.x1 - rect.x0;
    const std::size_t begin = static_cast<std::size_t>(rect.y0 + row) * view.size + rect.x0;
    for (const MeshChannel &channel : meshes_->channels)
        for (int material : {channel.own, channel.parent})
            if (material >= 0 && still)
                std::copy_n((*still)[material].data() + begin, width, pictures[material].data() + begin);
            else if (material >= 0)
                std::fill_n(pictures[material].data() + begin, width, 0);
    for (std::size_t channel = 0; channel < meshes_->channels.size(); ++channel) {
        const MeshChannel &of = meshes_->channels[channel];
        const float *sum_mm = sums_mm_[channel].data() + static_cast<std::size_t>(row) * width;
        std::int32_t *own = pictures[of.own].data() + begin;
        std::int32_t *parent = of.parent >= 0 ? pictures[of.parent].data() + begin : nullptr;
        for (int x = 0; x < width; ++x) {
            const std::int32_t sum = scaled_sum(q10mm(sum_mm[x]), of.scale_q10);
            own[x] += sum;
            if (parent) parent[x] -= sum;
        }
    }
    if (form == PathForm::axis_sums) return;
    for (std::vector<std::int32_t> &picture : pictures)
        if (!picture.empty())
            finish_row(view, rect.y0 + row, rect.x0, rect.x1,
                       picture.data() + static_cast<std::size_t>(rect.y0 + row) * view.size);
}

} // namespace crn
