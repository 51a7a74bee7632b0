// Places stents in lesions of an artery, in whole sessions: the balloon at its lesion is inflated and
// deflated.
#include "host/picture/session_pictures.hpp"
#include "host/session/run.hpp"
#include "tools/bake/bake.hpp"
#include "tools/lab/literature/experiments.hpp"
#include "tools/mesh/progress.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <unistd.h>

namespace crn::literature
{

namespace
{

namespace fs = std::filesystem;

constexpr int length_mm = 110, around = 24;
constexpr double artery_mm = 3.0, entry_mm = 10.0, lesion_mm = 70.0, stenosis_percent = 65;
constexpr double narrow_mm = artery_mm * (1 - stenosis_percent / 100);

// A folder that goes with its experiment.
struct Folder {
    fs::path path;
    Folder()
    {
        static std::atomic<int> number{0};
        path = fs::temp_directory_path() /
               ("cournand_literature_" + std::to_string(getpid()) + "_" + std::to_string(number++));
        fs::create_directories(path);
    }
    ~Folder()
    {
        std::error_code ignored;
        fs::remove_all(path, ignored);
    }
    Folder(const Folder &) = delete;
    Folder &operator=(const Folder &) = delete;
};

double radius_mm(double y_mm)
{
    const double share = std::clamp((y_mm - 30.0) / 10.0, 0.0, 1.0);
    return (entry_mm + share * (artery_mm - entry_mm)) / 2;
}

// A straight artery behind a wider vessel, with a concentric lesion that a folded balloon just passes.
void write_artery(const fs::path &folder, double calcified_deg)
{
    std::ofstream mesh(folder / "tube.obj"), line(folder / "artery.csv");
    line << "branch,x_mm,y_mm,z_mm,radius_mm\n";
    for (int i = 0; i <= length_mm; i++) {
        const double outside = radius_mm(i) / std::cos(M_PI / around); // of the polygon around the circle
        for (int k = 0; k < around; k++) {
            const double angle = 2 * M_PI * k / around;
            mesh << "v " << outside * std::cos(angle) << ' ' << i << ' ' << -outside * std::sin(angle)
                 << '\n';
        }
        line << "0,0," << i << ",0," << radius_mm(i) << '\n';
    }
    for (int i = 0; i < length_mm; i++) {
        for (int k = 0; k < around; k++) {
            const int a = 1 + i * around + k, b = 1 + i * around + (k + 1) % around;
            mesh << "f " << a << ' ' << a + around << ' ' << b + around << "\nf " << a << ' ' << b + around
                 << ' ' << b << '\n';
        }
    }
    // Without yield_kPa, bake takes its usual 300 kPa, and 2 kPa more per degree of calcium.
    std::ofstream(folder / "scene.toml")
        << "[scene]\nname = \"Artery\"\n[lumen]\nmesh = \"tube.obj\"\nunit = \"mm\"\ncap = true\n"
           "level_max = 2\ntolerance_mm = 0.05\n[tree]\ncentrelines = [\"artery.csv\"]\n"
           "flow_ml_min = { artery = 60 }\n[entry]\nposition_mm = [0, 2, 0]\ndirection = [0, 1, 0]\n"
           "[[lesion]]\nname = \"plaque\"\nbranch = \"artery\"\nat_mm = "
        << lesion_mm << "\nlength_mm = 12\nstenosis_percent = 65\nyield_kPa = " << 300 + 2 * calcified_deg
        << '\n';
}

struct Dilated {
    double narrowest_mm = 0, widest_mm = 0; // of the balloon when it is fullest
    double lumen_mm = 0;                    // smallest diameter of the artery afterwards
    double stent_mm = 0;                    // smallest diameter inside the stent; 0 without one
};

// Makes the scene, and plays the session in it.
Dilated dilate(double calcified_deg, int bar, bool has_stent)
{
    const Folder folder;
    write_artery(folder.path, calcified_deg);
    bake::Options options;
    options.scene = folder.path / "scene.toml";
    options.output = folder.path / "artery.scene";
    options.folders = {folder.path.string(), folder.path.string()};
    options.poses = 0;
    options.points = 100;
    bake::Progress progress;
    bake::bake(options, progress);

    const SceneFile scene = read_scene(options.output.string());
    std::vector<Instrument> tools;
    for (const char *tool : {"coronary_014", "balloon_3x20"})
        tools.push_back(read_instrument(std::string("shared/examples/instruments/") + tool + ".toml"));
    PictureSettings settings;
    settings.bodies_path = (folder.path / "artery.bodies").string();
    settings.scene_path = scene.path;
    if (has_stent) settings.stents = read_stents({"shared/examples/stents/coronary_3_0x18.toml"}, tools);
    settings.size = 64;
    const Session session =
        parse_session("begin catheter inserted 83 mm\nbegin wire inserted 98 mm\ninflate to " +
                          std::to_string(bar) + " bar at 8 bar/s\nwait 2 s\ndeflate at 8 bar/s\nwait 1 s\n",
                      "experiment");
    const crn_wire_entry entry = entry_of(scene, tools.size(), session.inserted_um);
    Device device(scene, tools, entry, host_rig());
    const SceneAnatomy anatomy = read_anatomy(settings);
    const std::unique_ptr<Patient> patient = make_patient(settings, anatomy, tools);
    RunSettings how;
    if (has_stent) how.begin.push_back({RoomAction::load_stent, {}});
    const RunResult result = run_session(device, *patient, session, nullptr, nullptr, how);

    Dilated dilated;
    for (const BalloonSample &sample : result.figures.balloon.series) {
        dilated.narrowest_mm = std::max(dilated.narrowest_mm, double(sample.diameter_min_mm));
        dilated.widest_mm = std::max(dilated.widest_mm, double(sample.diameter_max_mm));
    }
    device.link().read_nodes();
    const std::vector<double> open = session_frame(device, {}, {}).wire.lesions_open;
    if (open.empty()) throw std::runtime_error("the scene has no lesion that can open");
    dilated.lumen_mm = narrow_mm + open[open.size() / 2] * (artery_mm - narrow_mm);
    if (!has_stent) return dilated;
    const std::vector<StentResult> stents = patient->stents()->results();
    if (stents.empty() || stents[0].stage != StentStage::deployed)
        throw std::runtime_error("the stent was not deployed");
    dilated.stent_mm = stents[0].figures.diameter_min_mm;
    return dilated;
}

// No source states its plaques: a soft lesion and two with calcium are assumed.
Dilated mean_of_three(int bar, bool has_stent)
{
    Dilated mean;
    for (double calcified_deg : {0.0, 100.0, 200.0}) {
        const Dilated one = dilate(calcified_deg, bar, has_stent);
        mean.narrowest_mm += one.narrowest_mm / 3;
        mean.widest_mm += one.widest_mm / 3;
        mean.lumen_mm += one.lumen_mm / 3;
        mean.stent_mm += one.stent_mm / 3;
    }
    return mean;
}

Figures stent_expansion()
{
    constexpr double chart_mm = 3.12; // of the shipped balloon at 12 bar
    const Dilated mean = mean_of_three(12, true);
    return {{{"below_chart", 100 * (1 - mean.stent_mm / chart_mm)},
             {"balloon_deficit", chart_mm - mean.narrowest_mm},
             {"recoil", mean.narrowest_mm - mean.stent_mm}},
            {}};
}

// Lesions that have come back after an angioplasty are soft.
Figures balloon_and_stent()
{
    const Dilated bare = dilate(0, 8, false), stented = dilate(0, 8, true);
    return {{{"lumen_before", narrow_mm},
             {"lumen_after_balloon", bare.lumen_mm},
             {"recoil_after_balloon", bare.widest_mm - bare.lumen_mm},
             {"lumen_after_stent", stented.stent_mm},
             {"recoil_after_stent", stented.widest_mm - stented.stent_mm}},
            {}};
}

// The shipped balloon of 3.0 mm, below and above 10 bar.
Figures balloon_pressure()
{
    constexpr double nominal_mm = 3.0;
    const Dilated low = mean_of_three(7, false), high = mean_of_three(12, false);
    const auto percent = [](const Dilated &one) {
        return 50 * (one.narrowest_mm + one.widest_mm) / nominal_mm;
    };
    return {{{"balloon_below_10", percent(low)},
             {"balloon_above_10", percent(high)},
             {"recoil_below_10", nominal_mm - low.lumen_mm},
             {"recoil_above_10", nominal_mm - high.lumen_mm}},
            {}};
}

Figures balloon_recoil()
{
    const Dilated mean = mean_of_three(10, false);
    return {{{"recoil", mean.widest_mm - mean.lumen_mm}}, {}};
}

} // namespace

std::vector<Experiment> stent_experiments()
{
    return {{"stent_expansion", stent_expansion},
            {"balloon_and_stent", balloon_and_stent},
            {"balloon_pressure", balloon_pressure},
            {"balloon_recoil", balloon_recoil}};
}

} // namespace crn::literature
