#include "tools/anatomy/heart_sequence.hpp"
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <stdexcept>

namespace anatomy
{

namespace
{

const MovingBody &body_of(const HeartSequence &sequence, const std::string &name)
{
    for (const MovingBody &body : sequence.bodies)
        if (body.name == name) return body;
    throw std::runtime_error("the heart has no body " + name);
}

std::vector<double> volumes_ml(const MovingBody &body)
{
    std::vector<double> volumes;
    for (const std::vector<Vec3> &frame : body.frames_mm)
        volumes.push_back(mesh_volume_mm3({frame, body.triangles}) * 1e-3);
    return volumes;
}

double ejection(const std::vector<double> &volumes)
{
    const auto [least, most] = std::minmax_element(volumes.begin(), volumes.end());
    return 1.0 - *least / *most;
}

/* Holds the mean descent and the mean rotation of the vertices in one slice across the heart's axis; the
 * slice is taken at the end of diastole. */
struct Slice {
    double descent_mm = 0.0, turn_deg = 0.0;
};

Slice slice_of(const MovingBody &body, double low, double high, size_t frame)
{
    const HeartAxes &axes = heart_axes();
    Slice slice;
    double count = 0.0, cross = 0.0, along = 0.0;
    for (size_t i = 0; i < body.frames_mm[0].size(); i++) {
        const Vec3 &rest = body.frames_mm[0][i], &moved = body.frames_mm[frame][i];
        const double height = axes.height(rest);
        if (height < low || height > high) continue;
        const Vec3 from = axes.across(rest), to = axes.across(moved);
        slice.descent_mm += (rest - moved).dot(axes.up);
        cross -= from.cross(to).dot(axes.up); // counter-clockwise as seen from the apex
        along += from.dot(to);
        count += 1.0;
    }
    if (count == 0.0) throw std::runtime_error(body.name + " has no vertices at this height");
    slice.descent_mm /= count;
    slice.turn_deg = std::atan2(cross, along) * 180.0 / std::numbers::pi;
    return slice;
}

/* Holds the centre towards which the vertices of the left ventricle move. The centre minimises the summed
 * squares of the displacement components perpendicular to the line towards the centre. `radial_share` is the
 * share of the summed squared displacements that is due to motion towards or away from the centre. */
struct Centre {
    Vec3 place = Vec3::Zero();
    double radial_share = 0.0;
};

Centre centre_of(const std::vector<Vec3> &from, const std::vector<Vec3> &to)
{
    constexpr int ROUNDS = 12; // the weights 1 / distance^2 converge within a few rounds
    Centre centre;
    for (const Vec3 &p : from) centre.place += p / static_cast<double>(from.size());
    for (int round = 0; round < ROUNDS; round++) {
        Eigen::Matrix3d left = 1e-9 * Eigen::Matrix3d::Identity();
        Vec3 right = Vec3::Zero();
        double across = 0.0, all = 0.0;
        for (size_t i = 0; i < from.size(); i++) {
            const Vec3 step = to[i] - from[i], way = centre.place - from[i];
            const double square = step.squaredNorm();
            // |step x (c - x)|^2 = (c - x)' (|step|^2 I - step step') (c - x)
            const Eigen::Matrix3d form =
                (square * Eigen::Matrix3d::Identity() - step * step.transpose()) / way.squaredNorm();
            left += form;
            right += form * from[i];
            across += way.dot(form * way);
            all += square;
        }
        centre.radial_share = all > 0.0 ? 1.0 - across / all : 0.0;
        centre.place = left.inverse() * right;
    }
    return centre;
}

/* Returns the length of the longest interval in which the curve is at rest, that is, in which no point moves
 * by more than `within_mm`. Between two frames, the points are moved along straight lines. The middle of the
 * interval at rest must lie in the part [from, to) of the beat, where `from` and `to` are fractions of the
 * beat. */
double rest_ms(const std::vector<Curve> &frames, double within_mm, double from, double to)
{
    constexpr int FINE = 240;
    const auto count = static_cast<int>(frames.size());
    const size_t points = frames[0].size();
    const auto place = [&](size_t point, int step) {
        const double at = static_cast<double>(step % FINE) / FINE * count;
        const int frame = static_cast<int>(at);
        const double share = at - frame;
        return Vec3((1.0 - share) * frames[static_cast<size_t>(frame)][point].position_mm +
                    share * frames[static_cast<size_t>((frame + 1) % count)][point].position_mm);
    };
    const auto rests = [&](int begin, int end) {
        for (size_t point = 0; point < points; point += 2) {
            std::vector<Vec3> way;
            for (int step = begin; step <= end; step += 2) way.push_back(place(point, step));
            way.push_back(place(point, end));
            for (size_t a = 0; a < way.size(); a++)
                for (size_t b = a + 1; b < way.size(); b++)
                    if ((way[a] - way[b]).norm() > within_mm) return false;
        }
        return true;
    };
    int longest = 0;
    for (int begin = 0; begin < FINE; begin++)
        while (begin + longest + 1 < begin + FINE && rests(begin, begin + longest + 1)) {
            const double middle = std::fmod((begin + 0.5 * (longest + 1)) / FINE, 1.0);
            if (middle < from || middle >= to) break;
            longest++;
        }
    return longest * BEAT_MS / FINE;
}

VesselFigures figures_of(const MovingVessel &vessel)
{
    constexpr double REST_MM = 1.0,
                     EARLY = 0.55; // share of the beat; systole lies before it, most of diastole after it
    VesselFigures figures{vessel.name, vessel.frames[0].back().arc_mm, 0.0, 0.0, 0.0};
    for (size_t point = 0; point < vessel.frames[0].size(); point++)
        for (size_t a = 0; a < vessel.frames.size(); a++)
            for (size_t b = a + 1; b < vessel.frames.size(); b++)
                figures.excursion_mm = std::max(
                    figures.excursion_mm,
                    (vessel.frames[a][point].position_mm - vessel.frames[b][point].position_mm).norm());
    figures.systole_rest_ms = rest_ms(vessel.frames, REST_MM, 0.25, EARLY);
    figures.diastole_rest_ms = rest_ms(vessel.frames, REST_MM, EARLY, 0.95);
    return figures;
}

} // namespace

HeartFigures heart_figures(const HeartSequence &sequence)
{
    const MovingBody &left = body_of(sequence, "left_ventricle");
    HeartFigures figures;
    figures.left_ml = volumes_ml(left);
    figures.right_ml = volumes_ml(body_of(sequence, "right_ventricle"));
    figures.left_atrium_ml = volumes_ml(body_of(sequence, "left_atrium"));
    figures.right_atrium_ml = volumes_ml(body_of(sequence, "right_atrium"));
    figures.left_ejection = ejection(figures.left_ml);
    figures.right_ejection = ejection(figures.right_ml);
    const auto least = std::min_element(figures.left_ml.begin(), figures.left_ml.end());
    figures.systole_frame = static_cast<int>(least - figures.left_ml.begin());
    const auto systole = static_cast<size_t>(figures.systole_frame);
    // The highest tenth of the left ventricle represents the ring of the mitral valve, and its lowest fifth
    // represents the apex.
    const Slice base = slice_of(left, 0.86, 1.2, systole), apex = slice_of(left, -0.2, 0.3, systole);
    figures.base_descent_mm = base.descent_mm;
    figures.base_turn_deg = base.turn_deg;
    figures.apex_turn_deg = apex.turn_deg;
    figures.twist_deg = apex.turn_deg - base.turn_deg;
    Centre first, last;
    for (size_t frame = 1; frame <= systole; frame++) {
        const Centre centre = centre_of(left.frames_mm[frame - 1], left.frames_mm[frame]);
        figures.radial_share += centre.radial_share / static_cast<double>(systole);
        if (frame == 2) first = centre;
        if (frame + 1 == systole) last = centre;
    }
    figures.centre_path_mm = (last.place - first.place).norm();
    for (const MovingVessel &vessel : sequence.vessels) figures.vessels.push_back(figures_of(vessel));
    return figures;
}

std::string figures_json(const HeartFigures &figures)
{
    nlohmann::ordered_json vessels = nlohmann::ordered_json::array();
    for (const VesselFigures &vessel : figures.vessels)
        vessels.push_back({{"name", vessel.name},
                           {"length_mm", vessel.length_mm},
                           {"excursion_mm", vessel.excursion_mm},
                           {"rest_after_systole_ms", vessel.systole_rest_ms},
                           {"rest_in_diastole_ms", vessel.diastole_rest_ms}});
    const nlohmann::ordered_json json = {{"beat_ms", BEAT_MS},
                                         {"frames", BEAT_FRAMES},
                                         {"left_ventricle_ml", figures.left_ml},
                                         {"right_ventricle_ml", figures.right_ml},
                                         {"left_atrium_ml", figures.left_atrium_ml},
                                         {"right_atrium_ml", figures.right_atrium_ml},
                                         {"end_of_systole_frame", figures.systole_frame},
                                         {"left_ejection_fraction", figures.left_ejection},
                                         {"right_ejection_fraction", figures.right_ejection},
                                         {"base_descent_mm", figures.base_descent_mm},
                                         {"base_turn_deg", figures.base_turn_deg},
                                         {"apex_turn_deg", figures.apex_turn_deg},
                                         {"twist_deg", figures.twist_deg},
                                         {"radial_share", figures.radial_share},
                                         {"centre_path_mm", figures.centre_path_mm},
                                         {"least_volume_factor", figures.least_volume_factor},
                                         {"arteries", vessels}};
    return json.dump(1) + "\n";
}

} // namespace anatomy
