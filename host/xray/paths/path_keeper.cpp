// Determines which parts of the scene have changed since the last frame, and which back end draws them.
#include "host/xray/paths/path_keeper.hpp"
#include "host/xray/paths/lanes.hpp"
#include "host/xray/paths/parallel.hpp"
#include "host/xray/paths/raster_paths.hpp"
#include "host/xray/paths/tube.hpp"
#include <algorithm>
#include <cmath>
#include <cstring>

namespace crn
{
namespace
{

constexpr int far_um = 2'000'000; // the same limit as in check_bodies

// Makes a picture of path lengths for every material that a channel uses, and no picture for other materials.
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

// Returns the box around a list of points, which must not be empty. The coordinates of eight points are
// compared together, because a heart has 100 000 points.
CRN_WIDE PointBox box_around(std::span<const Eigen::Vector3i> points)
{
    constexpr std::size_t block = 3 * lane_count;
    const int *numbers = points.data()->data();
    const std::size_t count = 3 * points.size();
    PointBox box{points[0], points[0]};
    Lanes_i least[3], greatest[3], now[3];
    std::size_t i = 0;
    if (count >= block)
        std::memcpy(least, numbers, sizeof least), std::memcpy(greatest, numbers, sizeof least);
    for (; i + block <= count; i += block) {
        std::memcpy(now, numbers + i, sizeof now);
        for (int k = 0; k < 3; ++k) {
            least[k] = now[k] < least[k] ? now[k] : least[k];
            greatest[k] = now[k] > greatest[k] ? now[k] : greatest[k];
        }
    }
    for (std::size_t k = 0; k < (i > 0 ? block : 0); ++k) {
        const auto axis = static_cast<Eigen::Index>(k % 3);
        box.low[axis] = std::min(box.low[axis], least[k / lane_count][k % lane_count]);
        box.high[axis] = std::max(box.high[axis], greatest[k / lane_count][k % lane_count]);
    }
    for (; i < count; ++i) {
        const auto axis = static_cast<Eigen::Index>(i % 3);
        box.low[axis] = std::min(box.low[axis], numbers[i]);
        box.high[axis] = std::max(box.high[axis], numbers[i]);
    }
    return box;
}

bool is_near(const PointBox &box)
{
    return box.low.minCoeff() >= -far_um && box.high.maxCoeff() <= far_um;
}

PixelRect around_both(const PixelRect &a, const PixelRect &b)
{
    if (a.is_empty()) return b;
    if (b.is_empty()) return a;
    return {std::min(a.x0, b.x0), std::min(a.y0, b.y0), std::max(a.x1, b.x1), std::max(a.y1, b.y1)};
}

// Returns the rectangle of pixels that the box around the points can cover. If the box around the points
// reaches behind the source, the function returns the whole picture.
PixelRect covered(const View &view, const PointBox &box_um)
{
    const auto &[low, high] = box_um;
    Eigen::Vector2d least(1e9, 1e9), greatest(-1e9, -1e9);
    for (int corner = 0; corner < 8; ++corner) {
        const Eigen::Vector3d at_um(corner & 1 ? high.x() : low.x(), corner & 2 ? high.y() : low.y(),
                                    corner & 4 ? high.z() : low.z());
        Eigen::Vector2d pixel;
        if (!project(view, at_um * 1e-6, pixel)) return {0, 0, view.size, view.size};
        least = least.cwiseMin(pixel);
        greatest = greatest.cwiseMax(pixel);
    }
    auto held = [&](double at) { return static_cast<int>(std::clamp(at, 0.0, 1.0 * view.size)); };
    return {held(std::floor(least.x()) - 1.0), held(std::floor(least.y()) - 1.0),
            held(std::ceil(greatest.x()) + 1.0), held(std::ceil(greatest.y()) + 1.0)};
}

bool has_material(const BodyMeshes &meshes, Material material)
{
    return std::any_of(meshes.channels.begin(), meshes.channels.end(), [&](const MeshChannel &channel) {
        return channel.own == static_cast<int>(material) || channel.parent == static_cast<int>(material);
    });
}

} // namespace

PathKeeper::PathKeeper(const BodyMeshes &meshes, std::unique_ptr<BodyPaths> back_end, int threads)
    : meshes_(meshes), back_end_(std::move(back_end)), threads_(threads),
      is_moved_(meshes.vertex_counts.size(), 0), moved_(meshes.vertex_counts.size())
{
    if (!has_material(meshes, Material::blood) && has_material(meshes, Material::soft_tissue))
        displaced_ = Material::soft_tissue;
}

// Continues with the rasteriser after a back end has failed.
void PathKeeper::take_raster()
{
    back_end_ = std::make_unique<RasterPaths>(meshes_, threads_);
    for (std::size_t i = 0; i < moved_.size(); ++i)
        if (!moved_[i].vertices_um.empty()) back_end_->move(static_cast<int>(i), moved_[i].vertices_um);
}

void PathKeeper::draw(std::span<const std::uint8_t> is_drawn, const PixelRect &rect, PathForm form,
                      PathPictures &pictures)
{
    if (back_end_->draw(view_, is_drawn, rect, form, pictures, error_)) return;
    take_raster();
    std::string none;
    back_end_->draw(view_, is_drawn, rect, form, pictures, none);
}

bool PathKeeper::move(const XrayFrame &frame)
{
    std::vector<std::uint8_t> wanted(is_moved_.size(), 0);
    bool has_changed = false;
    for (const MovedBody &body : frame.bodies) {
        if (body.body < 0 || static_cast<std::size_t>(body.body) >= moved_.size()) continue;
        if (body.vertices_um.size() != meshes_.vertex_counts[body.body] || body.vertices_um.empty()) continue;
        if (wanted[body.body]) continue;
        Moved &kept = moved_[body.body];
        if (std::equal(kept.vertices_um.begin(), kept.vertices_um.end(), body.vertices_um.begin(),
                       body.vertices_um.end())) {
            wanted[body.body] = 1;
            continue;
        }
        const PointBox box_um = box_around(body.vertices_um);
        if (!is_near(box_um)) continue;
        wanted[body.body] = 1;
        kept.vertices_um.assign(body.vertices_um.begin(), body.vertices_um.end());
        kept.box_um = box_um;
        back_end_->move(body.body, kept.vertices_um);
        has_changed = true;
    }
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        if (wanted[i] || !is_moved_[i]) continue;
        back_end_->move(static_cast<int>(i), body_vertices_um(meshes_, static_cast<int>(i)));
        moved_[i].vertices_um.clear();
    }
    if (wanted != is_moved_) is_filled_ = false;
    is_moved_ = std::move(wanted);
    return has_changed;
}

PixelRect PathKeeper::moved_rect() const
{
    PixelRect rect;
    for (const Moved &body : moved_)
        if (!body.vertices_um.empty()) rect = around_both(rect, covered(view_, body.box_um));
    return rect;
}

void PathKeeper::see_view()
{
    const int size = view_.size;
    changed_ = {0, 0, size, size};
    size_pictures(meshes_, size, bodies_);
    std::vector<std::uint8_t> is_still(is_moved_.size());
    bool is_any_moved = false;
    for (std::size_t i = 0; i < is_still.size(); ++i) {
        is_still[i] = !is_moved_[i];
        is_any_moved = is_any_moved || is_moved_[i];
    }
    still_ = {};
    moving_rect_ = {};
    if (is_any_moved) {
        size_pictures(meshes_, size, still_);
        draw(is_still, changed_, PathForm::axis_sums, still_);
    } else {
        draw(is_still, changed_, PathForm::ray_lengths, bodies_);
    }
    is_filled_ = true;
}

// Redraws the pixels that the moved bodies cover now or covered before, on the sums of those that do not
// move.
void PathKeeper::see_moved(bool is_new_view)
{
    const PixelRect whole{0, 0, view_.size, view_.size}, now = moved_rect();
    changed_ = is_new_view ? whole : around_both(moving_rect_, now);
    moving_rect_ = now;
    if (changed_.is_empty()) return;
    if (back_end_->draw_on(still_, is_new_view, view_, is_moved_, changed_, bodies_, error_)) return;
    take_raster();
    changed_ = whole;
    std::string none;
    back_end_->draw_on(still_, true, view_, is_moved_, whole, bodies_, none);
}

bool PathKeeper::see(const CArm &carm, int size, const XrayFrame &frame)
{
    const bool have_moved = move(frame);
    const bool is_new = !is_filled_ || !(carm_ == carm) || view_.size != size;
    if (is_new) {
        carm_ = carm;
        view_ = make_view(carm, size);
    }
    changed_ = {};
    const bool is_any_moved = std::find(is_moved_.begin(), is_moved_.end(), 1) != is_moved_.end();
    const bool are_bodies_drawn = is_new || (is_any_moved && have_moved);
    // One thread draws the tools and curves while the other threads draw the bodies.
    const int lines = are_bodies_drawn && threads_ > 1 ? 2 : 1;
    run_on_threads(lines, [&](int line) {
        if (line == 0 && is_new) see_view();
        if (line == 0 && is_any_moved && are_bodies_drawn) see_moved(is_new);
        if (line == lines - 1) draw_tubes(frame, view_, displaced_, tools_);
    });
    return is_new || have_moved;
}

} // namespace crn
