#include "tools/lab/ct/cta/cta.hpp"
#include "host/base/format.hpp"
#include "host/base/output_files.hpp"
#include "host/base/pending_file.hpp"
#include "tools/lab/ct/commands.hpp"
#include "tools/lab/ct/cta/painting.hpp"
#include "tools/lab/ct/cta/person.hpp"
#include "tools/lab/ct/volume/volume_io.hpp"
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <numbers>

namespace crn::ct
{

namespace
{

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double air_mm = 15.0;     // around the body
constexpr double labelled_m = 1e-3; // radius from which a vessel without lumen is labelled
// An artery beside a lung runs under the pleura, and never bare in air.
constexpr double sheath_mm = 1.2;
constexpr std::int16_t sheath_HU = 30, lung_most_HU = -500;
constexpr double whole_above_mm = 60.0; // of the stretch: over the top of the arch

// Only the arteries that are labelled have exactly the HU of the options, so that their samples can be
// counted.
struct Scene {
    Person person;
    std::vector<CutMesh> bodies;
    CutMesh lumen;
    CutBalls wide, small; // vessels without lumen, from the labelled radius on, and below it
    CutBalls sheath;      // wall and fat around them
};

Eigen::AlignedBox3d box_of(const bake::Mesh &mesh, double low_mm, double high_mm)
{
    Eigen::AlignedBox3d box;
    for (const Vector3d &vertex : mesh.vertices_mm)
        if (vertex.y() >= low_mm && vertex.y() <= high_mm) box.extend(vertex);
    return box;
}

// The stretch from the groins to the top of the aorta.
void choose_stretch(const Person &person, CtaOptions &options)
{
    if (options.low_mm > options.high_mm)
        throw UsageError("--low-mm and --high-mm: give both ends of the stretch, the lower one first");
    if (options.low_mm != options.high_mm) return;
    const VesselBranch &aorta = person.tree.branches.front();
    double low_m = 1e9, high_m = -1e9;
    for (const Vector3d &point : aorta.points_m) high_m = std::max(high_m, point.y());
    for (std::size_t i = 0; i < person.with_lumen; ++i)
        for (const Vector3d &point : person.tree.branches[i].points_m) low_m = std::min(low_m, point.y());
    options.low_mm = std::max(low_m * 1e3 - 10.0, -320.0);
    options.high_mm = high_m * 1e3 + whole_above_mm;
}

Volume empty_volume(const Person &person, const CtaOptions &options)
{
    const Eigen::AlignedBox3d box = box_of(person.bodies.front().mesh, options.low_mm, options.high_mm);
    if (box.isEmpty())
        throw Fault(options.person.string() +
                    formatted(": the body does not reach from %.0f to %.0f mm: give another stretch",
                              options.low_mm, options.high_mm));
    Volume volume;
    volume.name = options.output.string();
    volume.spacing_mm = {options.pixel_mm, options.pixel_mm, options.slice_mm};
    const auto count = [](double length_mm, double step_mm) {
        return static_cast<int>(std::ceil(length_mm / step_mm));
    };
    volume.size = {count(box.sizes().x() + 2 * air_mm, options.pixel_mm),
                   count(box.sizes().z() + 2 * air_mm, options.pixel_mm),
                   count(options.high_mm - options.low_mm, options.slice_mm)};
    volume.origin_mm = lps_from_scene(
        {box.min().x() - air_mm, options.low_mm + options.slice_mm / 2, box.max().z() + air_mm});
    check_plausible({volume.size[0], volume.size[1], volume.size[2]}, volume.spacing_mm, volume.name);
    volume.hu.assign(volume.count(), -1000.0f);
    return volume;
}

// Slices are taken one after the other, so that heart and breath move them against each other. The breath
// moves what lies above the pelvis up and down, the heart what lies around it to the sides.
struct Motion {
    const CtaOptions &options;
    Vector3d heart_mm;

    double height(double height_mm) const
    {
        const double share = std::clamp((height_mm + 150.0) / 200.0, 0.0, 1.0);
        return height_mm + options.breath_mm * share * std::sin(2.0 * std::numbers::pi * height_mm / 90.0);
    }
    Vector2d shift(double height_mm) const
    {
        const double from_heart = (height_mm - heart_mm.y()) / 80.0;
        const double size = options.pulse_mm * std::exp(-from_heart * from_heart);
        const double phase = 2.0 * std::numbers::pi * height_mm / 35.0;
        return {size * std::sin(phase), 0.6 * size * std::cos(phase)};
    }
};

void paint_plane(const Scene &scene, const CtaOptions &options, double height_mm, const SampleGrid &grid,
                 Samples &samples)
{
    const Motion motion{options, scene.person.heart_mm};
    const double height = motion.height(height_mm) + 1e-5; // off the vertices
    const Vector2d shift = motion.shift(height_mm), still = Vector2d::Zero();
    const auto artery = static_cast<std::int16_t>(std::lround(options.artery_HU));
    std::fill(samples.begin(), samples.end(), std::int16_t{-1000});
    bool is_lumen_painted = false;
    const auto paint_arteries = [&] {
        scene.sheath.paint(samples, grid, height, shift, sheath_HU, lung_most_HU);
        scene.small.paint(samples, grid, height, shift, static_cast<std::int16_t>(artery - 1));
        scene.wide.paint(samples, grid, height, shift, artery);
        scene.lumen.paint(samples, grid, height, shift, artery);
        is_lumen_painted = true;
    };
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
        const PersonBody &body = scene.person.bodies[i];
        if (!is_lumen_painted && body.is_plaque) paint_arteries();
        const auto hu = body.hu == artery ? static_cast<std::int16_t>(artery - 1) : body.hu;
        scene.bodies[i].paint(samples, grid, height, body.beats ? shift : still, hu);
    }
    if (!is_lumen_painted) paint_arteries();
}

// Paints all slices. `lumen` receives the share of each voxel that is in the lumen of the arteries, if it is
// wanted.
void paint(const Scene &scene, const CtaOptions &options, Volume &volume, Volume *lumen, const Report &report)
{
    SampleGrid grid;
    const Vector3d first = scene_from_lps(volume.origin_mm);
    grid.step_mm = options.pixel_mm / samples_along;
    grid.row_mm = options.pixel_mm / rows_per_pixel;
    grid.samples = volume.size[0] * samples_along;
    grid.rows = volume.size[1] * rows_per_pixel;
    grid.left_mm = first.x() - options.pixel_mm / 2 + grid.step_mm / 2;
    grid.front_mm = first.z() + options.pixel_mm / 2 - grid.row_mm / 2;
    const auto artery = static_cast<std::int16_t>(std::lround(options.artery_HU));
    constexpr float each = 1.0f / (samples_along * rows_per_pixel * planes_per_slice);
    Samples samples(static_cast<std::size_t>(grid.samples) * static_cast<std::size_t>(grid.rows));
    for (int k = 0; k < volume.size[2]; ++k) {
        report("painting", double(k) / volume.size[2]);
        float *slice = &volume.hu[volume.at(0, 0, k)];
        std::fill_n(slice, volume.at(0, 0, 1), 0.0f);
        for (int plane = 0; plane < planes_per_slice; ++plane) {
            const double height = first.y() + options.slice_mm * (k - 0.5 + (plane + 0.5) / planes_per_slice);
            paint_plane(scene, options, height, grid, samples);
            for (std::size_t at = 0; at < samples.size(); ++at) {
                const std::size_t row = at / static_cast<std::size_t>(grid.samples),
                                  along = at % static_cast<std::size_t>(grid.samples);
                const std::size_t pixel =
                    row / rows_per_pixel * static_cast<std::size_t>(volume.size[0]) + along / samples_along;
                slice[pixel] += each * static_cast<float>(samples[at]);
                if (lumen && samples[at] == artery) lumen->hu[volume.at(0, 0, k) + pixel] += each;
            }
        }
    }
    report("painting", 1);
}

std::vector<float> gaussian(double sigma)
{
    const int reach = std::max(1, static_cast<int>(std::ceil(3 * sigma)));
    std::vector<float> weights;
    float sum = 0;
    for (int i = -reach; i <= reach; ++i) {
        weights.push_back(static_cast<float>(std::exp(-0.5 * i * i / (sigma * sigma))));
        sum += weights.back();
    }
    for (float &weight : weights) weight /= sum;
    return weights;
}

// Blurs along one axis; the border is repeated.
void blur(Volume &volume, std::size_t axis, double sigma_mm)
{
    const double sigma = sigma_mm / volume.spacing_mm[static_cast<Eigen::Index>(axis)];
    if (sigma < 0.1) return;
    const std::vector<float> weights = gaussian(sigma);
    const int reach = static_cast<int>(weights.size() / 2), length = volume.size[axis];
    const std::size_t stride = axis == 0 ? 1 : axis == 1 ? volume.at(0, 1, 0) : volume.at(0, 0, 1);
    std::vector<float> line(static_cast<std::size_t>(length));
    for (std::size_t start = 0; start < volume.count(); ++start) {
        if (start / stride % static_cast<std::size_t>(length) != 0) continue;
        for (int i = 0; i < length; ++i)
            line[static_cast<std::size_t>(i)] = volume.hu[start + stride * static_cast<std::size_t>(i)];
        for (int i = 0; i < length; ++i) {
            float sum = 0;
            for (int j = -reach; j <= reach; ++j)
                sum += weights[static_cast<std::size_t>(j + reach)] *
                       line[static_cast<std::size_t>(std::clamp(i + j, 0, length - 1))];
            volume.hu[start + stride * static_cast<std::size_t>(i)] = sum;
        }
    }
}

void blur(Volume &volume, const CtaOptions &options)
{
    for (std::size_t axis = 0; axis < 3; ++axis)
        blur(volume, axis, axis == 2 ? options.blur_slice_mm : options.blur_mm);
}

// White noise with the scanner's point spread, scaled to the wanted standard deviation.
void add_noise(Volume &volume, const CtaOptions &options)
{
    Volume noise = volume.like(0);
    std::uint64_t state = options.seed * 2862933555777941757ull + 3037000493ull;
    for (float &value : noise.hu) {
        float sum = -2;
        for (int n = 0; n < 4; ++n) {
            state ^= state << 13, state ^= state >> 7, state ^= state << 17;
            sum += static_cast<float>(state >> 40) / 16777216.0f;
        }
        value = sum;
    }
    blur(noise, options);
    double square = 0;
    for (const float value : noise.hu) square += static_cast<double>(value) * static_cast<double>(value);
    const auto scale =
        static_cast<float>(options.noise_HU / std::sqrt(square / static_cast<double>(noise.count())));
    for (std::size_t at = 0; at < noise.count(); ++at) volume.hu[at] += scale * noise.hu[at];
}

// The table of a label map: map.csv of map.nii.gz.
std::filesystem::path table_of(std::filesystem::path map)
{
    while (map.has_extension()) map.replace_extension();
    return map.string() + ".csv";
}

// The structure of a voxel is that of the centreline whose tube reaches farthest over it.
void write_labels(const Scene &scene, const Volume &lumen, const CtaOptions &options)
{
    std::map<std::string, int> numbers;
    std::vector<std::pair<const VesselBranch *, int>> labelled;
    for (const VesselBranch &branch : scene.person.tree.branches) {
        const double widest_m = *std::max_element(branch.radii_m.begin(), branch.radii_m.end());
        if (branch.is_vein || widest_m < labelled_m) continue;
        const int next = static_cast<int>(numbers.size()) + 1;
        labelled.push_back({&branch, numbers.try_emplace(structure_name(branch.name), next).first->second});
    }
    Volume map = lumen.like(0);
    const auto nx = static_cast<std::size_t>(map.size[0]), plane = map.at(0, 0, 1);
    for (std::size_t at = 0; at < map.count(); ++at) {
        if (lumen.hu[at] < 0.5f) continue;
        const Vector3d place_m =
            map.scene({double(at % nx), double(at % plane / nx), double(at / plane)}) * 1e-3;
        double least = 1e9;
        for (const auto &[branch, number] : labelled)
            for (std::size_t j = 0; j < branch->points_m.size(); ++j) {
                const double over = (branch->points_m[j] - place_m).norm() / branch->radii_m[j];
                if (over < least) least = over, map.hu[at] = static_cast<float>(number);
            }
    }
    write_volume(map, options.labels);
    std::string table = "id,structure\n";
    for (const auto &[name, number] : numbers) table += std::to_string(number) + "," + name + "\n";
    write_whole_file(table_of(options.labels).string(), table);
}

void write_truth(const Scene &scene, const CtaOptions &options)
{
    std::string text = "name,parent,small,x_mm,y_mm,z_mm,radius_mm\n";
    for (std::size_t i = 0; i < scene.person.tree.branches.size(); ++i) {
        const VesselBranch &branch = scene.person.tree.branches[i];
        if (branch.is_vein) continue;
        for (std::size_t j = 0; j < branch.points_m.size(); ++j) {
            const Vector3d p = branch.points_m[j] * 1e3;
            if (p.y() < options.low_mm || p.y() > options.high_mm) continue;
            text += formatted("%s,%d,%d,%.3f,%.3f,%.3f,%.3f\n", structure_name(branch.name).c_str(),
                              branch.parent, i >= scene.person.with_lumen, p.x(), p.y(), p.z(),
                              branch.radii_m[j] * 1e3);
        }
    }
    write_whole_file(options.truth.string(), text);
}

Scene scene_of(Person person, const CtaOptions &options)
{
    const double low = options.low_mm - 10, high = options.high_mm + 10;
    Scene scene{std::move(person),  {}, CutMesh({}, low, high), CutBalls(low, high), CutBalls(low, high),
                CutBalls(low, high)};
    for (const PersonBody &body : scene.person.bodies) scene.bodies.emplace_back(body.mesh, low, high);
    scene.lumen = CutMesh(scene.person.lumen, low, high);
    for (std::size_t i = scene.person.with_lumen; i < scene.person.tree.branches.size(); ++i) {
        const VesselBranch &branch = scene.person.tree.branches[i];
        if (branch.is_vein) continue;
        for (std::size_t j = 1; j < branch.points_m.size(); ++j) {
            const Vector3d from_mm = branch.points_m[j - 1] * 1e3, to_mm = branch.points_m[j] * 1e3;
            const double from = branch.radii_m[j - 1] * 1e3, to = branch.radii_m[j] * 1e3;
            (std::min(from, to) < labelled_m * 1e3 ? scene.small : scene.wide).add(from_mm, from, to_mm, to);
            scene.sheath.add(from_mm, from + sheath_mm, to_mm, to + sheath_mm);
        }
    }
    return scene;
}

} // namespace

void command_cta(const CtaOptions &given)
{
    CtaOptions options = given;
    std::vector<NamedPath> outputs = {{"--output", options.output.string()}};
    if (!options.labels.empty()) {
        outputs.push_back({"--labels", options.labels.string()});
        outputs.push_back({"the table of --labels", table_of(options.labels).string()});
    }
    if (!options.truth.empty()) outputs.push_back({"--truth", options.truth.string()});
    check_outputs({{"PERSON", (options.person / "scene.toml").string()}}, outputs);
    const Report report = terminal_report();
    Person person = read_person(options.person);
    choose_stretch(person, options);
    Volume volume = empty_volume(person, options);
    const Scene scene = scene_of(std::move(person), options);
    Volume lumen;
    if (!options.labels.empty()) lumen = volume.like(0);
    paint(scene, options, volume, options.labels.empty() ? nullptr : &lumen, report);
    blur(volume, options);
    add_noise(volume, options);
    for (float &value : volume.hu) value = std::clamp(value, -1024.0f, 3071.0f);
    write_volume(volume, options.output);
    if (!options.labels.empty()) write_labels(scene, lumen, options);
    if (!options.truth.empty()) write_truth(scene, options);
    std::printf("%s: %d x %d x %d voxels of %.2f x %.2f x %.2f mm, %.0f to %.0f mm\n",
                options.output.string().c_str(), volume.size[0], volume.size[1], volume.size[2],
                volume.spacing_mm.x(), volume.spacing_mm.y(), volume.spacing_mm.z(), options.low_mm,
                options.high_mm);
}

} // namespace crn::ct
