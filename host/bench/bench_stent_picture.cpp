// Measures how much the struts of a stent add to the computing time of an X-ray picture. The program can also
// write X-ray pictures: the shipped stent in the shipped heart's LAD, crimped and deployed, with and without
// contrast medium.
//
//   build/bench/bench_stent_picture picture out/stent.png      all four side by side (docs/stent.md)
#include "firmware/bench/bench.h"
#include "host/picture/picture.hpp"
#include "host/picture/session_pictures.hpp"
#include "host/stent/figures.hpp"
#include "host/stent/vessel_wall.hpp"
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <memory>

using namespace crn;
using Eigen::Vector3d;

namespace
{

constexpr double at_mm = 22.0; // of the LAD, as in the lesion of docs/lesions.md
constexpr int size = 1024, shown = 400;
const MotionMoment moment{0xC0000000u,
                          0}; // three quarters of the beat: during filling, when arteries are at rest

std::size_t branch_named(const VesselTree &tree, const char *name)
{
    for (std::size_t i = 0; i < tree.branches.size(); ++i)
        if (tree.branches[i].name == name) return i;
    bench_fail("out/heart.bodies has no LAD: make coronary");
}

class Theatre
{
  public:
    Theatre()
    {
        std::string error;
        if (!read_bodies("out/heart.bodies", bodies_, error))
            bench_fail((error + " (make coronary)").c_str());
        if (!scene_.set_bodies(bodies_, error)) bench_fail(error.c_str());
        xray_ = std::make_unique<Xray>(scene_, 2);
        motion_ = read_motion("out/heart.scene", error);
        if (!motion_) bench_fail("out/heart.scene does not move: make coronary");
        look_ = instrument_look(read_instrument("shared/examples/instruments/coronary_014.toml"));
        beating_.emplace(*motion_, bodies_);
        for (const MovingBodies::Moved &body : beating_->at(moment))
            moved_.push_back({body.body, body.vertices_um});
        lad_ = branch_named(bodies_.vessels, "LAD");
        vessel_.emplace(bodies_.vessels, lad_, at_mm - 15, at_mm + 15, &*motion_);
        opened_.assign(bodies_.vessels.lesions.size(), {1.0});
        vessel_->move(moment, opened_);
        lay_wire();
    }

    // The stent is either crimped on its folded balloon, or opened to the artery's width and deployed.
    void place_stent(bool is_deployed)
    {
        Stent stent(read_stent("shared/examples/stents/coronary_3_0x18.toml"), at_mm);
        BalloonPose folded, up;
        for (std::size_t k = 0; k < vessel_->line_mm().size(); ++k) {
            if (std::abs(vessel_->along_mm(k) - at_mm) > 11) continue;
            folded.points.push_back({vessel_->along_mm(k), vessel_->line_mm()[k], 0.42});
            up.points.push_back({vessel_->along_mm(k), vessel_->line_mm()[k], vessel_->radius_mm()[k]});
        }
        if (is_deployed) stent.step({&vessel_->wall(), &up});
        for (int i = 0; i < 10; ++i) stent.step({&vessel_->wall(), &folded});
        struts_.clear();
        for (const StentLine &line : stent_lines(stent)) struts_.push_back(curve(line, Material::steel, 1.0));
        for (const StentLine &line : stent_markers(stent.design(), at_mm, folded))
            struts_.push_back(curve(line, Material::platinum, 0.3)); // a ring round the inner shaft
    }

    void render(bool has_struts, double iodine_mg_per_ml, double nGy, XrayPicture &picture)
    {
        std::vector<SweptCurve> curves;
        if (iodine_mg_per_ml > 0) curves = medium(iodine_mg_per_ml);
        if (has_struts) curves.insert(curves.end(), struts_.begin(), struts_.end());
        WireFrame wire = wire_;
        for (WireNode &node : wire.nodes) node.contrast_mg_per_ml = iodine_mg_per_ml;
        XraySettings settings;
        settings.carm.primary_deg = -5;
        settings.carm.secondary_deg = 40;
        settings.carm.isocentre_m = vessel_->line_mm()[vessel_->line_mm().size() / 2] * 1e-3;
        settings.carm.field_m = 0.15;
        settings.beam.mode = ExposureMode::cine;
        settings.beam.dose_per_frame_nGy = nGy;
        settings.size = size;
        xray_->render(settings, XrayFrame{{&look_, 1}, wire, curves, moved_}, 1, nullptr, picture);
    }

  private:
    static SweptCurve curve(const StentLine &line, Material material, double share)
    {
        SweptCurve curve{material, {}};
        for (const Vector3d &point : line.points_mm)
            curve.points.push_back({point * 1e-3, line.radius_mm * 1e-3, share});
        return curve;
    }

    // Fills the left coronary artery with blood that contains the given concentration of iodine.
    std::vector<SweptCurve> medium(double iodine_mg_per_ml) const
    {
        std::vector<SweptCurve> curves;
        for (const VesselBranch &branch : bodies_.vessels.branches) {
            if (branch.bed != VesselBed::left_coronary) continue;
            curves.push_back({Material::iohexol_350, {}});
            for (std::size_t i = 0; i < branch.points_m.size(); ++i)
                curves.back().points.push_back({motion_->push(branch.points_m[i], moment), branch.radii_m[i],
                                                contrast_share(iodine_mg_per_ml)});
        }
        return curves;
    }

    // The guidewire runs from a point 90 mm down the LAD back through the left main and up the aorta.
    void lay_wire()
    {
        std::vector<Vector3d> path_m;
        std::size_t branch = lad_, until = 0;
        double along_m = 0.0;
        const VesselBranch &first = bodies_.vessels.branches[lad_];
        while (until + 1 < first.points_m.size() && along_m < 0.09) {
            along_m += (first.points_m[until + 1] - first.points_m[until]).norm();
            ++until;
        }
        while (bodies_.vessels.branches[branch].parent >= 0) {
            const VesselBranch &now = bodies_.vessels.branches[branch];
            for (std::size_t i = until + 1; i-- > 0;)
                path_m.push_back(motion_->push(now.points_m[i], moment));
            branch = static_cast<std::size_t>(now.parent);
            until = now.parent_point;
        }
        const VesselBranch &aorta = bodies_.vessels.branches[branch];
        for (std::size_t i = until + 4; i < std::min(until + 40, aorta.points_m.size()); ++i)
            path_m.push_back(motion_->push(aorta.points_m[i], moment));
        for (const Vector3d &place_m : path_m) {
            WireNode node;
            node.position_m = place_m;
            node.radius_m = 0.00018;
            if (!wire_.nodes.empty()) {
                const double step_m = (place_m - wire_.nodes.back().position_m).norm();
                if (step_m < 1e-6) continue;
                node.arc_m = wire_.nodes.back().arc_m + step_m;
            }
            wire_.nodes.push_back(node);
        }
        wire_.tip_arc_m = {0.0};
    }

    Bodies bodies_;
    XrayScene scene_;
    std::unique_ptr<Xray> xray_; // made after the scene has its bodies
    std::optional<Motion> motion_;
    std::optional<MovingBodies> beating_;
    std::optional<VesselWall> vessel_;
    std::vector<std::vector<double>> opened_;
    RadiopaqueInstrument look_;
    std::vector<MovedBody> moved_;
    std::vector<SweptCurve> struts_;
    std::size_t lad_ = 0;
    WireFrame wire_;
};

double frame_ms(const bench_case *self)
{
    Theatre theatre;
    theatre.place_stent(true);
    XrayPicture picture;
    double fastest_ms = 1e9;
    for (int i = 0; i < 10; ++i) {
        const double begin_us = bench_now_us();
        theatre.render(self->argument != 0, 0.0, 150.0, picture);
        fastest_ms = std::min(fastest_ms, (bench_now_us() - begin_us) * 1e-3);
    }
    return fastest_ms;
}

// Writes the central part of four pictures: the crimped and the deployed stent, each without and with
// contrast medium.
int write_picture(const char *path)
{
    Theatre theatre;
    Image image{4 * shown, shown, 1, std::vector<std::uint8_t>(4u * shown * shown)};
    XrayPicture picture;
    for (int k = 0; k < 4; ++k) {
        theatre.place_stent(k >= 2);
        theatre.render(true, k % 2 == 1 ? 200.0 : 0.0, 300.0, picture);
        constexpr int edge = (size - shown) / 2;
        for (int row = 0; row < shown; ++row)
            std::copy_n(picture.grey.begin() + (row + edge) * size + edge, shown,
                        image.bytes.begin() + (row * 4 + k) * shown);
    }
    std::string error;
    if (!write_png(path, image, error)) bench_fail(error.c_str());
    std::printf("Written: %s\n", path);
    return 0;
}

const bench_case cases[] = {
    {"stent.frame_ms", "ms", "size=1024 threads=2 struts=none", nullptr, 0, frame_ms, 0},
    {"stent.frame_ms", "ms", "size=1024 threads=2 struts=144", nullptr, 0, frame_ms, 1},
};

} // namespace

int main(int argc, char **argv)
{
    if (argc == 3 && std::strcmp(argv[1], "picture") == 0) return write_picture(argv[2]);
    return bench_main(argc, argv, cases, sizeof(cases) / sizeof(cases[0]));
}
