#include "tools/anatomy/heart_sequence.hpp"
#include "host/base/format.hpp"
#include "host/base/pending_file.hpp"
#include "tools/anatomy/output.hpp"
#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

namespace anatomy
{

namespace
{

std::string numbered(const char *stem, int frame, const char *ending)
{
    return crn::formatted("%s_%02d%s", stem, frame, ending);
}

/* Returns the text of an OBJ file that has one object per body of the heart. If `frame` is -1, the text
 * describes the heart's shape at the end of inspiration. */
std::string frame_text(const HeartSequence &sequence, int frame)
{
    std::string text;
    if (frame < 0)
        text += "# Cournand heart: the first frame at the end of inspiration, millimetres\n";
    else
        text += crn::formatted(
            "# Cournand heart: frame %d of %d of a beat from the end of diastole, millimetres\n", frame,
            BEAT_FRAMES);
    uint32_t first = 1;
    for (const MovingBody &body : sequence.bodies) {
        const std::vector<Vec3> &vertices =
            frame < 0 ? body.inhaled_mm : body.frames_mm[static_cast<size_t>(frame)];
        text += "o " + body.name + "\n";
        for (const Vec3 &v : vertices) text += crn::formatted("v %.3f %.3f %.3f\n", v.x(), v.y(), v.z());
        for (const auto &t : body.triangles)
            text += crn::formatted("f %u %u %u\n", first + t[0], first + t[1], first + t[2]);
        first += static_cast<uint32_t>(vertices.size());
    }
    return text;
}

} // namespace

bool is_of_heart(const std::string &body)
{
    for (const char *name : {"heart", "left_ventricle", "right_ventricle", "left_atrium", "right_atrium",
                             "aortic_root", "coronaries_left", "coronaries_right"})
        if (body == name) return true;
    return false;
}

bool moves_with_heart(const std::string &body)
{
    return is_of_heart(body) ||
           body.rfind("lung_", 0) == 0; // their border is the heart's border in the picture
}

MovingBody moving_body(const std::string &name, const Mesh &rest, const HeartBeat &beat)
{
    MovingBody moving{name, rest.triangles, std::vector<std::vector<Vec3>>(BEAT_FRAMES), {}};
    for (const Vec3 &v : rest.vertices_mm) {
        const std::vector<Vec3> places = beat.frames(v);
        for (size_t frame = 0; frame < BEAT_FRAMES; frame++) moving.frames_mm[frame].push_back(places[frame]);
        moving.inhaled_mm.push_back(beat.inhaled(v));
    }
    return moving;
}

MovingVessel moving_vessel(const Vessel &vessel, const HeartBeat &beat)
{
    constexpr double STEP_MM = 2.0;
    const Curve rest = vessel_curve(vessel, STEP_MM);
    MovingVessel moving{vessel.name, std::vector<Curve>(BEAT_FRAMES, rest)};
    for (size_t i = 0; i < rest.size(); i++) {
        const std::vector<Vec3> places = beat.frames(rest[i].position_mm);
        for (size_t frame = 0; frame < BEAT_FRAMES; frame++) {
            Curve &curve = moving.frames[frame];
            curve[i].position_mm = places[frame];
            if (i > 0)
                curve[i].arc_mm = curve[i - 1].arc_mm + (places[frame] - curve[i - 1].position_mm).norm();
        }
    }
    return moving;
}

void write_lumen_frames(const std::filesystem::path &folder, const Mesh &rest, const HeartBeat &beat,
                        double scale)
{
    std::filesystem::create_directories(folder);
    MovingBody moving = moving_body("lumen", rest, beat);
    moving.frames_mm.push_back(moving.inhaled_mm);
    for (std::vector<Vec3> &frame : moving.frames_mm)
        for (Vec3 &point : frame) point *= scale;
    for (int frame = 0; frame < BEAT_FRAMES; frame++)
        write_ply(folder / numbered("lumen", frame, ".ply"),
                  {moving.frames_mm[static_cast<size_t>(frame)], rest.triangles}, "lumen");
    write_ply(folder.string() + "_inhaled.ply", {moving.frames_mm.back(), rest.triangles}, "lumen");
}

void write_sequence(const std::filesystem::path &folder, const HeartSequence &sequence)
{
    std::filesystem::create_directories(folder);
    for (int frame = 0; frame < BEAT_FRAMES; frame++) {
        std::vector<NamedCurve> curves;
        for (const MovingVessel &vessel : sequence.vessels)
            curves.push_back({vessel.name, vessel.frames[static_cast<size_t>(frame)]});
        crn::write_whole_file((folder / numbered("frame", frame, ".obj")).string(),
                              frame_text(sequence, frame));
        write_centrelines(folder / numbered("centrelines", frame, ".mrk.json"), curves);
    }
    crn::write_whole_file(folder.string() + "_inhaled.obj", frame_text(sequence, -1));
}

} // namespace anatomy
