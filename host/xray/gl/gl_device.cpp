#include "host/xray/gl/gl_device.hpp"
#include "host/base/format.hpp"
#include "host/xray/gl/gl_program.hpp"
#include "host/xray/paths/trabeculae.hpp"
#include <algorithm>
#include <cmath>

namespace crn
{
namespace
{

// The camera axes are in mm: x to the right, y up, and z away from the source. x and y are multiplied by the
// focal length, in units of half a picture. OpenGL reads back the lowest row first, so the y coordinate is
// flipped to get the top row first. Only those parts of the bodies that are nearer to the source than 1 mm
// are clipped.
constexpr const char *vertex_text = R"(#version 330 core
layout(location = 0) in vec3 vertex_um;
layout(location = 1) in vec3 vertex_place;
noperspective out vec3 place;
uniform vec3 source_um, right, up, forward;
void main() {
    vec3 ray_mm = (vertex_um - source_um) * 0.001;
    float depth_mm = dot(ray_mm, forward);
    place = vertex_place;
    gl_Position = vec4(dot(ray_mm, right), -dot(ray_mm, up), depth_mm - 2.0, depth_mm);
})";

// 1 / gl_FragCoord.w is the depth, interpolated with correct perspective. The picture is drawn as seen from
// the detector and mirrored. In the mirrored picture, a face that is turned towards the source has its
// corners anticlockwise, as when the body is seen from outside. A face with the texture of trabeculae
// (host/xray/paths/trabeculae.hpp) shifts its depth like a face that the rasteriser draws.
constexpr const char *fragment_text = R"(#version 330 core
uniform float reference_mm, grain_mm, steep_per_mm2;
uniform isampler3D block;
noperspective in vec3 place;
out float sum_mm;
void main() {
    float depth_mm = 1.0 / gl_FragCoord.w;
    if (grain_mm > 0.0) {
        vec2 steps_mm = vec2(dFdx(gl_FragCoord.w), dFdy(gl_FragCoord.w)) * depth_mm * depth_mm;
        float share = max(1.0 - steep_per_mm2 * dot(steps_mm, steps_mm), 0.0);
        ivec3 cell = ivec3(floor(place)) & (textureSize(block, 0) - 1);
        depth_mm += share * grain_mm * float(texelFetch(block, cell, 0).r);
    }
    depth_mm -= reference_mm;
    sum_mm = gl_FrontFacing ? -depth_mm : depth_mm;
})";

constexpr float near_um = 1000.0f;

// Describes the pyramid of all rays of the picture; chunks of triangles outside this pyramid are skipped.
struct Pyramid {
    Eigen::Vector3f source_um, right, up, forward;
    float focal, half; // pixels

    explicit Pyramid(const View &view)
        : source_um((view.source_m * 1e6).cast<float>()), right(view.right.cast<float>()),
          up(view.up.cast<float>()), forward(view.forward.cast<float>()),
          focal(static_cast<float>(view.source_detector_m / view.pixel_m)),
          half(0.5f * static_cast<float>(view.size))
    {
    }
    float depth_um(const MeshChunk &chunk) const { return (chunk.centre_um - source_um).dot(forward); }
    bool leaves_out(const MeshChunk &chunk) const
    {
        const Eigen::Vector3f centre = chunk.centre_um - source_um;
        const float depth = centre.dot(forward);
        const float slack = chunk.radius_um * std::sqrt(half * half + focal * focal);
        return depth < -chunk.radius_um || std::fabs(centre.dot(right)) * focal > depth * half + slack ||
               std::fabs(centre.dot(up)) * focal > depth * half + slack;
    }
};

// Lists, for each channel, the ranges of consecutive chunks of triangles to draw, in the form that
// MultiDrawElements requires.
struct DrawList {
    std::vector<int> counts;
    std::vector<const void *> offsets;

    void add(std::uint32_t triangle_begin, std::uint32_t triangle_count)
    {
        const auto begin = static_cast<std::uintptr_t>(triangle_begin) * 3 * sizeof(std::uint32_t);
        const int count = static_cast<int>(triangle_count) * 3;
        if (!counts.empty() && begin == end_) {
            counts.back() += count;
        } else {
            counts.push_back(count);
            offsets.push_back(reinterpret_cast<const void *>(begin));
        }
        end_ = begin + static_cast<std::uintptr_t>(count) * sizeof(std::uint32_t);
    }

  private:
    std::uintptr_t end_ = 0;
};

struct Plan {
    std::vector<DrawList> smooth, textured; // [channel]
    bool is_source_near = false;            // whether some chunk may reach behind the source
};

Plan make_plan(const BodyMeshes &meshes, std::span<const std::uint8_t> is_drawn, const View &view)
{
    const Pyramid pyramid(view);
    const std::vector<DrawList> none(meshes.channels.size());
    Plan plan{none, none};
    for (const MeshChunk &chunk : meshes.chunks) {
        if (!is_drawn[chunk.body] || pyramid.leaves_out(chunk)) continue;
        auto &lists = chunk.grain_begin ? plan.textured : plan.smooth;
        lists[chunk.channel].add(chunk.triangle_begin, chunk.triangle_count);
        plan.is_source_near |= pyramid.depth_um(chunk) - chunk.radius_um < near_um;
    }
    return plan;
}

std::vector<std::uint32_t> all_indices(const BodyMeshes &meshes)
{
    std::vector<std::uint32_t> indices;
    indices.reserve(meshes.triangles.size() * 3);
    for (const MeshChunk &chunk : meshes.chunks)
        for (std::uint32_t i = 0; i < chunk.triangle_count; ++i)
            for (std::uint16_t corner : meshes.triangles[chunk.triangle_begin + i])
                indices.push_back(chunk.vertex_begin + corner);
    return indices;
}

// Returns the place in the texture of every vertex; of a smooth body it is not used.
std::vector<Eigen::Vector3f> all_places(const BodyMeshes &meshes)
{
    std::vector<Eigen::Vector3f> places(meshes.vertices_um.size(), Eigen::Vector3f::Zero());
    for (const MeshChunk &chunk : meshes.chunks)
        if (chunk.grain_begin)
            std::copy_n(meshes.grain_places.begin() + *chunk.grain_begin, chunk.vertex_count,
                        places.begin() + chunk.vertex_begin);
    return places;
}

template <class T> std::ptrdiff_t bytes_of(const std::vector<T> &values)
{
    return static_cast<std::ptrdiff_t>(values.size() * sizeof(T));
}

} // namespace

GlDevice::GlDevice(const BodyMeshes &meshes, std::unique_ptr<GlContext> context)
    : context_(std::move(context)), description_(describe(*context_))
{
    const GlEntered entered(*context_);
    gl_ = load_functions(*context_);
    program_ = build_program(gl_, vertex_text, fragment_text);
    build(meshes);
    check("sending the bodies");
}

void GlDevice::build(const BodyMeshes &meshes)
{
    const std::vector<std::uint32_t> indices = all_indices(meshes);
    gl_.GetIntegerv(gl::max_texture_size, &size_max_);
    gl_.GenVertexArrays(1, &array_);
    gl_.GenBuffers(1, &vertices_);
    gl_.GenBuffers(1, &indices_);
    gl_.GenFramebuffers(1, &framebuffer_);
    gl_.BindVertexArray(array_);
    gl_.BindBuffer(gl::array_buffer, vertices_);
    static_assert(sizeof(Eigen::Vector3f) == 3 * sizeof(float));
    gl_.BufferData(gl::array_buffer, bytes_of(meshes.vertices_um), meshes.vertices_um.data(),
                   gl::static_draw);
    gl_.BindBuffer(gl::element_array_buffer, indices_);
    gl_.BufferData(gl::element_array_buffer, bytes_of(indices), indices.data(), gl::static_draw);
    gl_.EnableVertexAttribArray(0);
    gl_.VertexAttribPointer(0, 3, gl::type_float, 0, 0, nullptr);
    if (!meshes.grain_places.empty()) build_texture(meshes);
    gl_.BindVertexArray(0);
}

void GlDevice::build_texture(const BodyMeshes &meshes)
{
    const std::vector<Eigen::Vector3f> places = all_places(meshes);
    gl_.GenBuffers(1, &places_);
    gl_.BindBuffer(gl::array_buffer, places_);
    gl_.BufferData(gl::array_buffer, bytes_of(places), places.data(), gl::static_draw);
    gl_.EnableVertexAttribArray(1);
    gl_.VertexAttribPointer(1, 3, gl::type_float, 0, 0, nullptr);
    gl_.BindBuffer(gl::array_buffer, 0);
    gl_.GenTextures(1, &block_);
    gl_.BindTexture(gl::texture_3d, block_);
    gl_.TexParameteri(gl::texture_3d, gl::min_filter, gl::nearest);
    gl_.TexParameteri(gl::texture_3d, gl::mag_filter, gl::nearest);
    gl_.BindTexture(gl::texture_3d, 0);
}

// Sends the cells of the view's block, unless they are there.
void GlDevice::set_texture(const View &view)
{
    const Grain grain = grain_in(view);
    gl_.BindTexture(gl::texture_3d, block_);
    if (grain.block != sent_block_) {
        gl_.PixelStorei(gl::unpack_alignment, 1);
        gl_.TexImage3D(gl::texture_3d, 0, gl::r8i, grain_cells, grain_cells, grain_cells, 0, gl::red_integer,
                       gl::type_byte, grain.block);
        gl_.PixelStorei(gl::unpack_alignment, 4);
        sent_block_ = grain.block;
    }
    gl_.Uniform1i(gl_.GetUniformLocation(program_, "block"), 0);
    gl_.Uniform1f(gl_.GetUniformLocation(program_, "steep_per_mm2"), grain.steep * 1e6f);
    grain_mm_ = grain.unit_q10mm / 1024.0f;
}

GlDevice::~GlDevice()
{
    try {
        const GlEntered entered(*context_);
        delete_pictures();
        gl_.DeleteTextures(1, &block_);
        gl_.DeleteBuffers(1, &places_);
        gl_.DeleteFramebuffers(1, &framebuffer_);
        gl_.DeleteBuffers(1, &vertices_);
        gl_.DeleteBuffers(1, &indices_);
        gl_.DeleteVertexArrays(1, &array_);
        gl_.DeleteProgram(program_);
    } catch (const GlError &) {
        // A lost OpenGL context has already deleted its buffers, textures and programs.
    }
}

void GlDevice::delete_pictures()
{
    gl_.DeleteTextures(static_cast<int>(pictures_.size()), pictures_.data());
    pictures_.clear();
    size_ = 0;
}

void GlDevice::check(const char *doing) const
{
    const unsigned code = gl_.GetError();
    if (code == gl::no_error) return;
    const std::string at = "OpenGL (" + description_.renderer + "): ";
    if (code == gl::context_lost) throw GlLost(at + "the context was lost while " + doing);
    if (code == gl::out_of_memory)
        throw GlError(at + "out of memory while " + doing + "; use a smaller --size");
    const std::string text = formatted("0x%04x", code);
    throw GlError(at + "error " + text + " while " + doing);
}

void GlDevice::resize(std::size_t channels, int size)
{
    if (size_ == size) return;
    delete_pictures();
    if (size > size_max_)
        throw GlError("OpenGL (" + description_.renderer + "): pictures have at most " +
                      std::to_string(size_max_) + " pixels along an edge, not " + std::to_string(size));
    pictures_.resize(channels);
    gl_.GenTextures(static_cast<int>(channels), pictures_.data());
    for (unsigned picture : pictures_) {
        gl_.BindTexture(gl::texture_2d, picture);
        gl_.TexParameteri(gl::texture_2d, gl::min_filter, gl::nearest);
        gl_.TexParameteri(gl::texture_2d, gl::mag_filter, gl::nearest);
        gl_.TexImage2D(gl::texture_2d, 0, gl::r32f, size, size, 0, gl::red, gl::type_float, nullptr);
    }
    gl_.BindTexture(gl::texture_2d, 0);
    check("making pictures of floats");
    size_ = size;
}

void GlDevice::send_vertices(const BodyMeshes &meshes, std::span<const std::uint8_t> is_stale) const
{
    gl_.BindBuffer(gl::array_buffer, vertices_);
    for (std::size_t i = 0; i < meshes.chunks.size();) {
        const int body = meshes.chunks[i].body;
        const std::uint32_t begin = meshes.chunks[i].vertex_begin;
        std::uint32_t end = begin;
        for (; i < meshes.chunks.size() && meshes.chunks[i].body == body; ++i)
            end = meshes.chunks[i].vertex_begin + meshes.chunks[i].vertex_count;
        if (!is_stale[body]) continue;
        constexpr std::ptrdiff_t stride = sizeof(Eigen::Vector3f);
        gl_.BufferSubData(gl::array_buffer, stride * begin, stride * (end - begin),
                          meshes.vertices_um.data() + begin);
    }
    gl_.BindBuffer(gl::array_buffer, 0);
}

void GlDevice::set_view(const View &view, float reference_mm) const
{
    const auto set = [&](const char *name, const Eigen::Vector3d &value) {
        const Eigen::Vector3f v = value.cast<float>();
        gl_.Uniform3f(gl_.GetUniformLocation(program_, name), v.x(), v.y(), v.z());
    };
    const double focal = 2.0 * view.source_detector_m / (view.pixel_m * view.size); // in half pictures
    set("source_um", view.source_m * 1e6);
    set("right", view.right * focal);
    set("up", view.up * focal);
    set("forward", view.forward);
    gl_.Uniform1f(gl_.GetUniformLocation(program_, "reference_mm"), reference_mm);
}

// Restores those OpenGL settings that the drawing changes and on which other users of the context rely. The
// other users of the OpenGL context set all other settings themselves.
class GlDevice::StateGuard
{
  public:
    explicit StateGuard(const GlFunctions &functions) : gl_(functions) {}
    ~StateGuard()
    {
        gl_.Disable(gl::blend);
        gl_.Disable(gl::scissor_test);
        gl_.BindVertexArray(0);
        gl_.BindTexture(gl::texture_3d, 0);
        gl_.BindFramebuffer(gl::framebuffer, 0);
    }
    StateGuard(const StateGuard &) = delete;
    StateGuard &operator=(const StateGuard &) = delete;

  private:
    const GlFunctions &gl_;
};

void GlDevice::set_state(const View &view, const PixelRect &rect) const
{
    gl_.BindFramebuffer(gl::framebuffer, framebuffer_);
    gl_.BindVertexArray(array_);
    gl_.Viewport(0, 0, view.size, view.size);
    gl_.Scissor(rect.x0, rect.y0, rect.x1 - rect.x0, rect.y1 - rect.y0);
    gl_.Enable(gl::scissor_test);
    gl_.Disable(gl::cull_face);
    gl_.Disable(gl::depth_test);
    gl_.Enable(gl::blend);
    gl_.BlendEquation(gl::func_add);
    gl_.BlendFunc(gl::one, gl::one);
    gl_.ClearColor(0.0f, 0.0f, 0.0f, 0.0f);
    gl_.ReadBuffer(gl::colour_attachment0);
}

void GlDevice::aim_at(std::size_t channel) const
{
    gl_.FramebufferTexture2D(gl::framebuffer, gl::colour_attachment0, gl::texture_2d, pictures_[channel], 0);
    if (gl_.CheckFramebufferStatus(gl::framebuffer) != gl::framebuffer_complete)
        throw GlError("OpenGL (" + description_.renderer + ") does not draw into pictures of floats");
}

void GlDevice::draw(const BodyMeshes &meshes, std::span<const std::uint8_t> is_stale,
                    std::span<const std::uint8_t> is_drawn, const View &view, const PixelRect &rect,
                    std::vector<std::vector<float>> &sums_mm)
{
    const Plan plan = make_plan(meshes, is_drawn, view);
    const int width = rect.x1 - rect.x0, height = rect.y1 - rect.y0;
    sums_mm.resize(meshes.channels.size());
    const GlEntered entered(*context_);
    const StateGuard guard(gl_);
    send_vertices(meshes, is_stale);
    resize(meshes.channels.size(), view.size);
    gl_.UseProgram(program_);
    // Floating-point numbers are most precise near 0, so depths are measured from the isocentre. A face
    // behind the source is not drawn. If a body has a face behind the source, one depth is missing from the
    // body's sum, so the sum depends on the origin of the depths. For a body with a face behind the source,
    // the depths are therefore measured from the source itself.
    set_view(view, plan.is_source_near ? 0.0f : static_cast<float>(view.source_isocentre_m * 1e3));
    set_state(view, rect);
    if (places_ != 0) set_texture(view);
    const auto draw_list = [&](const DrawList &list, float grain_mm) {
        if (list.counts.empty()) return;
        gl_.Uniform1f(gl_.GetUniformLocation(program_, "grain_mm"), grain_mm);
        gl_.MultiDrawElements(gl::triangles, list.counts.data(), gl::type_unsigned_int, list.offsets.data(),
                              static_cast<int>(list.counts.size()));
    };
    for (std::size_t channel = 0; channel < pictures_.size(); ++channel) {
        aim_at(channel);
        gl_.Clear(gl::colour_buffer_bit);
        draw_list(plan.smooth[channel], 0.0f);
        draw_list(plan.textured[channel], grain_mm_);
    }
    for (std::size_t channel = 0; channel < pictures_.size(); ++channel) {
        aim_at(channel);
        sums_mm[channel].resize(static_cast<std::size_t>(width) * height);
        gl_.ReadPixels(rect.x0, rect.y0, width, height, gl::red, gl::type_float, sums_mm[channel].data());
    }
    check("drawing");
}

} // namespace crn
