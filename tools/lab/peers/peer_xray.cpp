// Makes the pictures that tools/lab/peers/run_xray_peers.py compares with those of gVirtualXray
// (docs/bench.md). The pictures show a patient's bodies from several sides with a beam of five energies.
//
//   peer_xray BODIES FOLDER SIZE ROUNDS
//
// The program writes FOLDER/body_N.stl (binary, mm), FOLDER/scene.json (materials, geometry of each view,
// spectrum) and FOLDER/ours_V.f32 (transmissions, row 0 on top). The program also prints one line of
// key=value pairs. Bodies inside other bodies within the skin (marrow, vessels of the lungs) are left out,
// because gVirtualXray allows only one level of nested bodies.
#include "host/base/format.hpp"
#include "host/xray/detector.hpp"
#include "host/xray/xray.hpp"
#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <fstream>
#include <string>
#include <vector>

using namespace crn;

namespace
{

// The following photon energies are midpoints of steps in the attenuation table, where no interpolation is
// needed; `shares` holds the fraction of the beam's energy at each of them.
constexpr double energies_keV[] = {36.5, 44.5, 52.5, 60.5, 68.5};
constexpr double shares[] = {0.21, 0.28, 0.26, 0.18, 0.07};

[[noreturn]] void stop(const std::string &sentence)
{
    std::fprintf(stderr, "peer_xray: %s\n", sentence.c_str());
    std::exit(1);
}

double now_ms()
{
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

// Returns the processor time that all threads of this process have used.
double processor_ms()
{
    return static_cast<double>(std::clock()) * 1e3 / CLOCKS_PER_SEC;
}

double median(std::vector<double> values)
{
    std::sort(values.begin(), values.end());
    return values[values.size() / 2];
}

struct Look {
    double primary_deg, secondary_deg, y_m;
};
constexpr Look looks[] = {{0, 0, 0.0}, {30, 15, 0.08}, {90, 0, 0.0}, {-40, -25, -0.1}};

Bodies first_level(const Bodies &all)
{
    Bodies kept;
    for (const Body &body : all.bodies) {
        const bool is_outer = body.parent < 0;
        if (!is_outer && all.bodies[body.parent].parent >= 0) continue;
        if (is_outer && !kept.bodies.empty()) stop("the bodies have more than one skin");
        kept.bodies.push_back(body);
        kept.bodies.back().parent = is_outer ? -1 : 0;
    }
    return kept;
}

void write_file(const std::string &path, const std::string &bytes)
{
    std::ofstream file(path, std::ios::binary);
    file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (!file.flush()) stop(path + ": cannot be written");
}

template <class Value> void put(std::string &bytes, Value value)
{
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    bytes.append(raw, sizeof value);
}

std::string stl_of(const Body &body)
{
    std::string bytes(80, ' ');
    put(bytes, static_cast<std::uint32_t>(body.triangles.size()));
    for (const auto &triangle : body.triangles) {
        Eigen::Vector3f corner[3];
        for (int k = 0; k < 3; ++k) corner[k] = body.vertices_um[triangle[k]].cast<float>() * 1e-3f;
        Eigen::Vector3f normal = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
        if (normal.squaredNorm() > 0.0f) normal.normalize();
        for (int axis = 0; axis < 3; ++axis) put(bytes, normal[axis]);
        for (const Eigen::Vector3f &at : corner)
            for (int axis = 0; axis < 3; ++axis) put(bytes, at[axis]);
        put(bytes, std::uint16_t{0});
    }
    return bytes;
}

std::string list_of(const Eigen::Vector3d &v)
{
    return formatted("[%.9g, %.9g, %.9g]", v.x(), v.y(), v.z());
}

XraySettings settings_of(const Look &look, int size)
{
    XraySettings settings;
    settings.carm.primary_deg = look.primary_deg;
    settings.carm.secondary_deg = look.secondary_deg;
    settings.carm.isocentre_m = {0.0, look.y_m, 0.0};
    settings.size = size;
    return settings;
}

std::string scene_text(const Bodies &bodies, int size)
{
    std::string text = "{\"bodies\": [";
    for (std::size_t i = 0; i < bodies.bodies.size(); ++i) {
        const Body &body = bodies.bodies[i];
        text += (i > 0 ? ", " : "") + std::string("{\"file\": \"body_") + std::to_string(i) +
                ".stl\", \"material\": \"" + std::string(material_name(*material_from_name(body.material))) +
                "\", \"is_outer\": " + (body.parent < 0 ? "true" : "false") + "}";
    }
    text += "],\n\"spectrum\": [";
    for (std::size_t k = 0; k < std::size(energies_keV); ++k) {
        const std::string line = formatted("%s[%.9g, %.9g]", k > 0 ? ", " : "", energies_keV[k], shares[k]);
        text += line;
    }
    const std::string pixel =
        formatted(", \"pixel_mm\": %.9g", make_view(settings_of(looks[0], size).carm, size).pixel_m * 1e3);
    text += "],\n\"size\": " + std::to_string(size) + pixel + ", \"views\": [";
    for (std::size_t i = 0; i < std::size(looks); ++i) {
        const View view = make_view(settings_of(looks[i], size).carm, size);
        const Eigen::Vector3d detector_m = view.source_m + view.forward * view.source_detector_m;
        text += std::string(i > 0 ? ",\n" : "\n") + "{\"source_mm\": " + list_of(view.source_m * 1e3) +
                ", \"detector_mm\": " + list_of(detector_m * 1e3) + ", \"up\": " + list_of(view.up) +
                ", \"right\": " + list_of(view.right) + "}";
    }
    return text + "]}\n";
}

// Returns the transmission of the picture that was rendered last.
std::string transmissions(const Xray &xray, int size)
{
    const BeamTable beam = make_line_table(energies_keV, shares);
    std::vector<std::vector<std::int32_t>> paths;
    for (int m = 0; m < material_count; ++m) paths.push_back(xray.body_path_q10mm(static_cast<Material>(m)));
    std::vector<float> share(static_cast<std::size_t>(size) * size);
    for (int row = 0; row < size; ++row) {
        const std::size_t begin = static_cast<std::size_t>(row) * size;
        std::array<const std::int32_t *, material_count> lines{};
        for (int m = 0; m < material_count; ++m)
            if (!paths[m].empty()) lines[m] = paths[m].data() + begin;
        transmission_row(beam, lines, size, share.data() + begin);
    }
    return {reinterpret_cast<const char *>(share.data()), share.size() * sizeof(float)};
}

} // namespace

int main(int argc, char **argv)
{
    if (argc != 5) {
        std::fprintf(stderr, "usage: peer_xray BODIES FOLDER SIZE ROUNDS\n");
        return 2;
    }
    const std::string folder = argv[2];
    const int size = held_size(std::atoi(argv[3])), rounds = std::clamp(std::atoi(argv[4]), 1, 1000);
    Bodies all;
    std::string error;
    if (!read_bodies(argv[1], all, error)) stop(error);
    const Bodies bodies = first_level(all);
    XrayScene scene;
    if (!scene.set_bodies(bodies, error)) stop(error);
    for (std::size_t i = 0; i < bodies.bodies.size(); ++i)
        write_file(folder + "/body_" + std::to_string(i) + ".stl", stl_of(bodies.bodies[i]));
    write_file(folder + "/scene.json", scene_text(bodies, size));
    Xray xray(scene, 2);
    XrayPicture picture;
    std::vector<double> times_ms, processor_times_ms;
    for (int round = 0; round <= rounds; ++round)
        for (std::size_t i = 0; i < std::size(looks); ++i) {
            const double begin = now_ms(), processor_begin = processor_ms();
            xray.render(settings_of(looks[i], size), {}, WireFrame{}, 7, picture);
            if (round == 0) {
                write_file(folder + "/ours_" + std::to_string(i) + ".f32", transmissions(xray, size));
                continue;
            }
            times_ms.push_back(now_ms() - begin);
            processor_times_ms.push_back(processor_ms() - processor_begin);
        }
    std::printf("code=cournand version=1 size=%d triangles=%zu views=%zu ms_min=%.4f ms_median=%.4f "
                "processor_ms_median=%.4f\n",
                size, scene.triangle_count(), std::size(looks),
                *std::min_element(times_ms.begin(), times_ms.end()), median(times_ms),
                median(processor_times_ms));
    return 0;
}
