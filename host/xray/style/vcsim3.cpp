// Draws the surfaces of the bodies and a tube around each tool, and adds noise.
#include "host/xray/style/vcsim3.hpp"
#include "host/xray/float_math.hpp"
#include "host/xray/paths/parallel.hpp"
#include "host/xray/style/surface.hpp"
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace crn
{

using Eigen::Vector3d;

struct SurfaceScene {
    struct Part { // a body that is shown, in its place of rest
        std::size_t body = 0;
        SurfaceLook look;
        std::vector<Eigen::Vector3i> vertices_um;
        std::vector<std::array<std::uint32_t, 3>> triangles;
    };
    std::vector<Part> parts;
    int threads = 1;
    // State of the last view.
    bool is_filled = false;
    CArm carm;
    int size = 0;
    std::vector<std::uint8_t> is_moved; // per part: excluded from still_sums
    std::vector<std::int32_t> still_sums, sums, tool_sums;
};

namespace
{

constexpr int tool_grid = 2;   // samples per pixel along each edge: a guidewire is hardly wider than a pixel
constexpr int tool_sides = 12; // of the tube around a tool
constexpr int tool_pieces = 4; // between two nodes
constexpr double contrast_depth =
    8.0; // a quarter of undiluted medium looks nearly as dark as undiluted medium
constexpr double density_per_log2 = 1.4426950408889634 / 65536.0; // converts 1/65536 nepers to powers of two

// Returns the optical density -ln(1 - A (1 - |n.v|)^p) of a surface with the normal n, seen along v, in units
// of 1/65536; A is the opacity seen edge-on, and p states how fast it decreases.
std::int32_t density_q16(const SurfaceLook &look, double cosine)
{
    const double opacity = look.edge_opacity * std::pow(1.0 - std::min(1.0, std::abs(cosine)), look.power);
    return static_cast<std::int32_t>(std::lround(-std::log1p(-opacity) * 65536.0));
}

// Returns the corners of a body's mesh in a view; the normal at a corner is the mean over its triangles,
// weighted by area.
std::vector<SurfaceCorner> corners_of(const SurfaceScene::Part &part,
                                      std::span<const Eigen::Vector3i> places_um, const View &view)
{
    std::vector<Vector3d> at_m, normals(places_um.size(), Vector3d::Zero());
    for (const Eigen::Vector3i &place_um : places_um) at_m.push_back(place_um.cast<double>() * 1e-6);
    for (const auto &[a, b, c] : part.triangles) {
        const Vector3d normal = (at_m[b] - at_m[a]).cross(at_m[c] - at_m[a]);
        normals[a] += normal;
        normals[b] += normal;
        normals[c] += normal;
    }
    std::vector<SurfaceCorner> corners;
    for (std::size_t i = 0; i < at_m.size(); ++i) {
        const double length = normals[i].norm();
        if (length > 0.0) normals[i] /= length;
        const double cosine = (at_m[i] - view.source_m).normalized().dot(normals[i]);
        corners.push_back(surface_corner(view, at_m[i], density_q16(part.look, cosine)));
    }
    return corners;
}

// If `moved` is true, adds the bodies that have moved to the density sums, and otherwise the bodies that have
// not moved.
void add_parts(const SurfaceScene &scene, std::span<const std::span<const Eigen::Vector3i>> places_um,
               bool moved, const View &view, std::vector<std::int32_t> &sums)
{
    std::vector<std::vector<SurfaceCorner>> corners(scene.parts.size());
    for (std::size_t k = 0; k < scene.parts.size(); ++k)
        if (scene.is_moved[k] == moved) corners[k] = corners_of(scene.parts[k], places_um[k], view);
    run_on_threads(scene.threads, [&](int thread) {
        const RowRange rows = rows_of_thread(thread, scene.threads, view.size);
        for (std::size_t k = 0; k < scene.parts.size(); ++k) {
            if (corners[k].empty()) continue;
            for (const auto &[a, b, c] : scene.parts[k].triangles)
                add_surface({corners[k][a], corners[k][b], corners[k][c]}, view.size, rows.begin, rows.end,
                            sums.data());
        }
    });
}

// Keeps, from picture to picture, the density sums of the bodies that do not move, and redraws the bodies
// that have moved.
void fill_bodies(SurfaceScene &scene, const CArm &carm, int size, std::span<const MovedBody> moved)
{
    std::vector<std::uint8_t> is_moved(scene.parts.size(), 0);
    std::vector<std::span<const Eigen::Vector3i>> places_um;
    for (std::size_t k = 0; k < scene.parts.size(); ++k) {
        const SurfaceScene::Part &part = scene.parts[k];
        places_um.emplace_back(part.vertices_um);
        for (const MovedBody &body : moved) {
            if (body.body != static_cast<int>(part.body) ||
                body.vertices_um.size() != part.vertices_um.size())
                continue;
            places_um[k] = body.vertices_um;
            is_moved[k] = 1;
        }
    }
    const View view = make_view(carm, size);
    if (!scene.is_filled || !(scene.carm == carm) || scene.size != size || scene.is_moved != is_moved) {
        scene.is_moved = is_moved;
        scene.still_sums.assign(static_cast<std::size_t>(size) * size, 0);
        add_parts(scene, places_um, false, view, scene.still_sums);
        scene.carm = carm;
        scene.size = size;
        scene.is_filled = true;
    }
    scene.sums = scene.still_sums;
    add_parts(scene, places_um, true, view, scene.sums);
}

double radius_m(const RadiopaqueInstrument &tool, double arc_m, double node_radius_m)
{
    if (tool.radii.empty()) return node_radius_m;
    const auto after = std::upper_bound(tool.radii.begin(), tool.radii.end(), arc_m,
                                        [](double arc, const RadiopaqueRadius &r) { return arc < r.arc_m; });
    if (after == tool.radii.begin()) return after->outer_m;
    if (after == tool.radii.end()) return after[-1].outer_m;
    const double share = (arc_m - after[-1].arc_m) / (after->arc_m - after[-1].arc_m);
    return after[-1].outer_m + share * (after->outer_m - after[-1].outer_m);
}

// Returns a point on the curve through the nodes (Catmull-Rom), at the fraction `share` of the distance from
// node i to the next node.
Vector3d on_curve(const std::vector<WireNode> &nodes, std::size_t i, double share)
{
    const Vector3d &b = nodes[i].position_m, &c = nodes[std::min(i + 1, nodes.size() - 1)].position_m;
    const Vector3d a = i > 0 ? nodes[i - 1].position_m : Vector3d(2 * b - c);
    const Vector3d d = i + 2 < nodes.size() ? nodes[i + 2].position_m : Vector3d(2 * c - b);
    const double t = share;
    return 0.5 *
           (2 * b + t * (c - a) + t * t * (2 * a - 5 * b + 4 * c - d) + t * t * t * (3 * b - a - 3 * c + d));
}

struct Ring {
    std::array<SurfaceCorner, tool_sides> corners;
};

Ring ring_at(const View &view, const Vector3d &centre, const Vector3d &axis, double radius,
             const SurfaceLook &look)
{
    Vector3d across = view.forward.cross(axis);
    if (across.norm() < 1e-6) across = view.up.cross(axis);
    across.normalize();
    const Vector3d toward = axis.cross(across);
    Ring ring;
    for (int k = 0; k < tool_sides; ++k) {
        const double angle = 2.0 * 3.14159265358979323846 * k / tool_sides;
        const Vector3d normal = std::cos(angle) * across + std::sin(angle) * toward;
        const Vector3d at = centre + radius * normal;
        const double cosine = (at - view.source_m).normalized().dot(normal);
        ring.corners[static_cast<std::size_t>(k)] = surface_corner(view, at, density_q16(look, cosine));
    }
    return ring;
}

void add_band(SurfaceScene &scene, const View &view, const Ring &from, const Ring &to)
{
    for (std::size_t k = 0; k < tool_sides; ++k) {
        const std::size_t n = (k + 1) % tool_sides;
        add_surface({from.corners[k], from.corners[n], to.corners[k]}, view.size, 0, view.size,
                    scene.tool_sums.data());
        add_surface({to.corners[k], from.corners[n], to.corners[n]}, view.size, 0, view.size,
                    scene.tool_sums.data());
    }
}

// Draws contrast medium in a vessel, or a strut, as a tube along the curve; the tube is open at its ends.
void add_curve(SurfaceScene &scene, const View &view, const SweptCurve &curve)
{
    Ring last;
    for (std::size_t i = 0; i < curve.points.size(); ++i) {
        const SweptPoint &point = curve.points[i];
        const Vector3d axis = curve.points[std::min(i + 1, curve.points.size() - 1)].at_m -
                              curve.points[i > 0 ? i - 1 : 0].at_m;
        if (!point.at_m.allFinite() || axis.norm() < 1e-9) return;
        const Ring ring = ring_at(view, point.at_m, axis.normalized(), point.radius_m,
                                  curve_look(curve.material, point.share));
        if (i > 0) add_band(scene, view, last, ring);
        last = ring;
    }
}

void add_tool(SurfaceScene &scene, const View &view, const RadiopaqueInstrument &tool, const WireFrame &wire,
              double tip_arc_m)
{
    Ring last;
    bool has_last = false;
    for (std::size_t i = 0; i + 1 < wire.nodes.size(); ++i) {
        const WireNode &node = wire.nodes[i], &next = wire.nodes[i + 1];
        if (next.arc_m <= tip_arc_m) continue;
        for (int piece = 0; piece <= (i + 2 == wire.nodes.size() ? tool_pieces : tool_pieces - 1); ++piece) {
            const double share = static_cast<double>(piece) / tool_pieces;
            const double arc = node.arc_m + share * (next.arc_m - node.arc_m) - tip_arc_m;
            if (arc < 0.0) continue;
            const Vector3d centre = on_curve(wire.nodes, i, share);
            const Vector3d axis =
                (on_curve(wire.nodes, i, share + 0.05) - on_curve(wire.nodes, i, share - 0.05));
            if (axis.norm() < 1e-9) continue;
            const Ring ring =
                ring_at(view, centre, axis.normalized(), radius_m(tool, arc, node.radius_m), vcsim3_tool);
            if (has_last) add_band(scene, view, last, ring);
            last = ring;
            has_last = true;
        }
    }
}

// Returns an approximately normal random number of mean 0 and standard deviation 1: the sum of four uniform
// numbers from a hash of key and pixel.
float noise_at(std::uint64_t key, std::uint32_t pixel)
{
    std::uint64_t x = key + 0x9e3779b97f4a7c15u * (pixel + 1ull);
    x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
    x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
    x ^= x >> 31;
    const auto sum =
        static_cast<std::int32_t>((x & 0xffff) + (x >> 16 & 0xffff) + (x >> 32 & 0xffff) + (x >> 48));
    constexpr float deviation = 37837.2f; // of the sum: 65536 / sqrt(3)
    return static_cast<float>(sum - 131070) / deviation;
}

std::uint8_t grey_of(float share, float noise)
{
    const float value =
        255.0f * (static_cast<float>(vcsim3_background) * share + static_cast<float>(vcsim3_noise) * noise);
    return static_cast<std::uint8_t>(std::clamp(value, 0.0f, 255.0f));
}

// Returns the fraction of light that passes the tools in front of one pixel.
float tool_share(const SurfaceScene &scene, int x, int y)
{
    float share = 0.0f;
    const int wide = scene.size * tool_grid;
    for (int k = 0; k < tool_grid * tool_grid; ++k) {
        const int at = (y * tool_grid + k / tool_grid) * wide + x * tool_grid + k % tool_grid;
        share += exp2_negative(
            static_cast<float>(scene.tool_sums[static_cast<std::size_t>(at)] * density_per_log2));
    }
    return share / (tool_grid * tool_grid);
}

} // namespace

SurfaceLook surface_look(const Bodies &bodies, std::size_t index)
{
    const Body &body = bodies.bodies[index];
    const std::optional<Material> material = material_from_name(body.material);
    const auto parent =
        body.parent >= 0 ? material_from_name(bodies.bodies[static_cast<std::size_t>(body.parent)].material)
                         : std::nullopt;
    if (material == Material::bone_cortical) return {0.55, 2.0};
    if (material == Material::iohexol_350) return vcsim3_contrast;
    const bool is_heart = body.name.rfind("heart", 0) == 0;
    if (is_heart && (material == Material::muscle || material == Material::blood)) return {0.25, 2.0};
    if (material == Material::blood && parent != Material::lung) return {0.12, 2.0};
    return {};
}

SurfaceLook curve_look(Material material, double share)
{
    if (material != Material::iohexol_350) return vcsim3_tool;
    const double seen = 1.0 - std::exp(-contrast_depth * std::clamp(share, 0.0, 1.0));
    return {vcsim3_contrast.edge_opacity * seen, vcsim3_contrast.power};
}

Vcsim3Look::Vcsim3Look(const Bodies &bodies, int threads) : scene_(std::make_unique<SurfaceScene>())
{
    const int processors = static_cast<int>(std::thread::hardware_concurrency());
    scene_->threads = std::min(threads > 0 ? threads : std::clamp(processors, 1, 4), 16);
    for (std::size_t i = 0; i < bodies.bodies.size(); ++i) {
        const SurfaceLook look = surface_look(bodies, i);
        const Body &body = bodies.bodies[i];
        if (look.edge_opacity > 0.0) scene_->parts.push_back({i, look, body.vertices_um, body.triangles});
    }
}
Vcsim3Look::~Vcsim3Look() = default;

void Vcsim3Look::draw(const XraySettings &settings, const XrayFrame &frame, std::uint64_t seed,
                      XrayPicture &picture)
{
    const WireFrame &wire = frame.wire;
    const CArm carm = clamp_carm(settings.carm);
    const int size = held_size(settings.size);
    SurfaceScene &scene = *scene_;
    fill_bodies(scene, carm, size, frame.bodies);
    const View fine = make_view(carm, size * tool_grid);
    scene.tool_sums.assign(static_cast<std::size_t>(fine.size) * fine.size, 0);
    for (const SweptCurve &curve : frame.curves) add_curve(scene, fine, curve);
    for (std::size_t k = 0; k < frame.tools.size(); ++k)
        add_tool(scene, fine, frame.tools[k], wire, k < wire.tip_arc_m.size() ? wire.tip_arc_m[k] : 0.0);
    picture.size = size;
    picture.tick = wire.tick;
    picture.grey.resize(scene.sums.size());
    picture.shown.resize(scene.sums.size());
    const std::uint64_t key = seed * 0x2545f4914f6cdd1du + wire.tick * 0xd1342543de82ef95u;
    run_on_threads(scene.threads, [&](int thread) {
        const RowRange rows = rows_of_thread(thread, scene.threads, size);
        for (int y = rows.begin; y < rows.end; ++y)
            for (int x = 0; x < size; ++x) {
                const auto pixel = static_cast<std::uint32_t>(y * size + x);
                const float bodies = exp2_negative(static_cast<float>(scene.sums[pixel] * density_per_log2));
                picture.grey[pixel] = grey_of(bodies * tool_share(scene, x, y), noise_at(key, pixel));
                picture.shown[pixel] = static_cast<std::uint16_t>(16 * picture.grey[pixel]);
            }
    });
}

const std::vector<std::int32_t> &Vcsim3Look::body_density_q16() const
{
    return scene_->sums;
}

} // namespace crn
