#include "host/app/surface_file.hpp"
#include "host/model/lesion_wall.hpp"
#include "host/model/pending_file.hpp"
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <stdexcept>

namespace seld
{
namespace
{

using Eigen::Vector3d;

constexpr double vessel_radii = 1.8; // what lies farther from the vessel's line is other vessels'
constexpr std::size_t balloon_around = 24;

std::string line(const char *format, double a, double b, double c)
{
    char text[100];
    std::snprintf(text, sizeof text, format, a, b, c);
    return text;
}

// Place of the line at an arc length from its leading tip, and its direction there.
bool place_at(const WireFrame &wire, double arc_m, Vector3d &place_m, Vector3d &along)
{
    for (std::size_t i = 0; i + 1 < wire.nodes.size(); ++i) {
        const WireNode &a = wire.nodes[i], &b = wire.nodes[i + 1];
        if (arc_m < a.arc_m || arc_m > b.arc_m || !(b.arc_m > a.arc_m)) continue;
        along = (b.position_m - a.position_m).normalized();
        place_m = a.position_m + (arc_m - a.arc_m) / (b.arc_m - a.arc_m) * (b.position_m - a.position_m);
        return true;
    }
    return false;
}

std::size_t lesion_called(const VesselTree &tree, const std::string &name)
{
    std::string names;
    for (std::size_t k = 0; k < tree.lesions.size(); ++k) {
        if (name.empty() || tree.lesions[k].name == name) return k;
        names += (names.empty() ? "" : ", ") + tree.lesions[k].name;
    }
    throw std::runtime_error(
        name.empty() ? "the scene has no lesion: bake one with a [[lesion]]"
                     : "--lesion: the scene has no '" + name + "'" +
                           (names.empty() ? "; it has none: bake one with a [[lesion]]" : ", but " + names));
}

} // namespace

SurfaceSink::SurfaceSink(const SurfaceSettings &settings, std::vector<std::uint32_t> ticks)
    : settings_(settings), ticks_(std::move(ticks))
{
    std::string error;
    if (settings.bodies_path.empty())
        throw std::runtime_error("there is no .bodies file beside the scene: it has the walls");
    if (!read_bodies(settings.bodies_path, bodies_, error)) throw std::runtime_error(error);
    motion_ = read_motion(settings.scene_path, error);
    if (!error.empty()) throw std::runtime_error(error);
    const std::vector<LesionStations> stations = read_lesion_stations(settings.scene_path, error);
    if (!error.empty()) throw std::runtime_error(error);
    lesion_ = lesion_called(bodies_.vessels, settings.lesion);
    healthy_ = healthy_tree(bodies_.vessels);
    opened_.emplace(bodies_, LesionOpening(bodies_.vessels, stations), nullptr); // in the reference pose
    if (opened_->is_empty())
        throw std::runtime_error(
            settings.bodies_path +
            ": no body of blood has the lesion's vessel in it: give the scene's text one, such as "
            "[[body]] mesh = \"lumen\"");
}

SurfaceSink::~SurfaceSink() = default;

std::uint32_t SurfaceSink::next_tick() const
{
    return at_ < ticks_.size() ? ticks_[at_] : std::numeric_limits<std::uint32_t>::max();
}

// Along the healthy vessel no farther than asked, and rather this vessel's than another one's.
bool SurfaceSink::is_near(const Vector3d &place_m) const
{
    const VesselLesion &lesion = bodies_.vessels.lesions[lesion_];
    const VesselBranch &branch = healthy_.branches[lesion.branch];
    const VesselFoot foot = vessel_foot(branch, place_m);
    if (foot.radii > vessel_radii) return false;
    const auto arc_m = [&](std::size_t point, double share) {
        double sum_m = 0.0;
        for (std::size_t i = 0; i < point; ++i) sum_m += (branch.points_m[i + 1] - branch.points_m[i]).norm();
        return sum_m +
               (share > 0.0 ? share * (branch.points_m[point + 1] - branch.points_m[point]).norm() : 0.0);
    };
    const double here_m = arc_m(foot.point, foot.share), begin_m = arc_m(lesion.first_point, 0.0),
                 end_m = arc_m(lesion.first_point + lesion.size() - 1, 0.0);
    return here_m >= begin_m - settings_.around_mm * 1e-3 && here_m <= end_m + settings_.around_mm * 1e-3;
}

// Triangles all of whose corners are near, seen where they are in the healthy vessel so that every moment has the same ones.
void SurfaceSink::add_body(const std::string &prefix, int body, std::span<const Eigen::Vector3i> vertices_um)
{
    const Body &of = bodies_.bodies[static_cast<std::size_t>(body)];
    std::vector<std::size_t> number(of.vertices_um.size(), 0);
    std::vector<signed char> near(of.vertices_um.size(), -1);
    const auto is_kept = [&](std::uint32_t corner) {
        if (near[corner] < 0) near[corner] = is_near(of.vertices_um[corner].cast<double>() * 1e-6);
        return near[corner] == 1;
    };
    std::string vertices, faces;
    for (const auto &corners : of.triangles) {
        if (!std::all_of(corners.begin(), corners.end(), is_kept)) continue;
        faces += "f";
        for (const std::uint32_t corner : corners) {
            if (number[corner] == 0) {
                number[corner] = ++vertices_;
                const Vector3d at_mm = vertices_um[corner].cast<double>() * 1e-3;
                vertices += line("v %.3f %.3f %.3f\n", at_mm.x(), at_mm.y(), at_mm.z());
            }
            faces += " " + std::to_string(number[corner]);
        }
        faces += "\n";
    }
    obj_ += "o " + prefix + "_" + of.name + "\n" + vertices + faces;
}

// The balloon as a surface of revolution about the line through its balls.
void SurfaceSink::add_balloon(const std::string &prefix, const WireFrame &wire)
{
    std::size_t rings = 0;
    const std::size_t first = vertices_ + 1;
    std::string vertices;
    Vector3d across = Vector3d::UnitX();
    const MotionMoment moment{wire.heart_phase32, wire.breath_phase32};
    for (std::size_t j = 0; j < wire.balloon_radii_m.size(); ++j) {
        Vector3d place_m, along;
        const double arc_m = wire.balloon_arc_m + static_cast<double>(j) * wire.balloon_spacing_m;
        if (!place_at(wire, arc_m, place_m, along)) continue;
        if (rings == 0 && std::fabs(along.x()) > 0.9) across = Vector3d::UnitY();
        across = (across - across.dot(along) * along).normalized();
        const Vector3d third = along.cross(across);
        for (std::size_t k = 0; k < balloon_around; ++k) {
            const double angle = 2 * std::numbers::pi * static_cast<double>(k) / balloon_around;
            const Vector3d there_m =
                place_m + wire.balloon_radii_m[j] * (std::cos(angle) * across + std::sin(angle) * third);
            const Vector3d at_mm = (motion_ ? motion_->pull(there_m, moment) : there_m) * 1e3;
            vertices += line("v %.3f %.3f %.3f\n", at_mm.x(), at_mm.y(), at_mm.z());
        }
        ++rings;
    }
    if (rings < 2) return;
    vertices_ += rings * balloon_around;
    obj_ += "o " + prefix + "_balloon\n" + vertices;
    const auto add = [this](std::size_t a, std::size_t b, std::size_t c) {
        obj_ += "f " + std::to_string(a) + " " + std::to_string(b) + " " + std::to_string(c) + "\n";
    };
    for (std::size_t k = 0; k < balloon_around; ++k) {
        const std::size_t next = (k + 1) % balloon_around, last = first + (rings - 1) * balloon_around;
        for (std::size_t row = 0; row + 1 < rings; ++row) {
            const std::size_t a = first + row * balloon_around, b = a + balloon_around;
            add(a + k, a + next, b + k);
            add(a + next, b + next, b + k);
        }
        if (k > 0 && next > 0) add(first, first + next, first + k);
        if (k > 0 && next > 0) add(last, last + k, last + next);
    }
}

void SurfaceSink::frame(const SessionFrame &frame)
{
    if (at_ >= ticks_.size() || frame.wire.tick < ticks_[at_]) return;
    char prefix[40];
    std::snprintf(prefix, sizeof prefix, "t%07.3f", frame.wire.tick * 1e-3);
    const std::vector<MovingBodies::Moved> &moved = opened_->at({}, frame.wire.lesions_open);
    for (const int body : opened_->bodies()) {
        const auto now = std::find_if(moved.begin(), moved.end(),
                                      [body](const MovingBodies::Moved &one) { return one.body == body; });
        add_body(prefix, body,
                 now != moved.end() ? now->vertices_um
                                    : bodies_.bodies[static_cast<std::size_t>(body)].vertices_um);
    }
    add_balloon(prefix, frame.wire);
    while (at_ < ticks_.size() && ticks_[at_] <= frame.wire.tick) ++at_;
}

void SurfaceSink::finish()
{
    write_whole_file(settings_.output, "# Walls round a lesion, mm, patient frame: docs/lesions.md\n" + obj_);
}

} // namespace seld
