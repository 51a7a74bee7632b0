#include "tools/lab/ct/patient/xray_pictures.hpp"
#include "host/model/bodies.hpp"
#include "host/model/ct_volume.hpp"
#include "host/picture/picture.hpp"
#include "host/xray/xray.hpp"
#include "tools/mesh/fault.hpp"

namespace crn::ct
{

namespace
{

// The tree's branches full of undiluted contrast medium of half the strength.
std::vector<SweptCurve> filled(const VesselTree &tree)
{
    std::vector<SweptCurve> curves;
    for (const VesselBranch &branch : tree.branches) {
        SweptCurve curve{Material::iohexol_350, {}};
        for (std::size_t i = 0; i < branch.points_m.size(); ++i)
            curve.points.push_back({branch.points_m[i], branch.radii_m[i], contrast_share(80.0)});
        curves.push_back(std::move(curve));
    }
    return curves;
}

} // namespace

void show_xray(const std::filesystem::path &file, Page &page)
{
    Bodies bodies;
    std::string error;
    if (!read_bodies(file.string(), bodies, error)) throw Fault(error);
    XrayScene scene;
    if (!scene.set_bodies(bodies, error)) throw Fault(file.string() + ": " + error);
    Xray xray(scene, 2);
    const std::vector<SweptCurve> medium = filled(bodies.vessels);
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    if (bodies.ct)
        for (int axis = 0; axis < 3; ++axis)
            middle[axis] = 1e-3 * (bodies.ct->first_mm[axis] +
                                   0.5 * bodies.ct->spacing_mm[axis] * bodies.ct->size[axis]);
    struct Shot {
        const char *name, *what;
        double primary_deg;
        bool is_filled;
    };
    const Shot shots[] = {
        {"xray_ap.png", "X-ray picture through the CT from the front.", 0, false},
        {"xray_ap_filled.png", "The same with contrast medium in the tree of vessels.", 0, true},
        {"xray_lao.png", "LAO 45 with contrast medium.", 45, true}};
    const WireFrame no_tools;
    for (const Shot &shot : shots) {
        XraySettings settings;
        settings.carm.primary_deg = shot.primary_deg;
        settings.carm.isocentre_m = middle;
        settings.carm.field_m = 0.42;
        settings.beam.mode = ExposureMode::cine;
        settings.beam.dose_per_frame_nGy = 170;
        settings.size = 768;
        XrayPicture picture;
        const XrayFrame frame{{}, no_tools, std::span(medium).first(shot.is_filled ? medium.size() : 0)};
        xray.render(settings, frame, 1, nullptr, picture);
        const Image image{picture.size, picture.size, 1, picture.grey};
        if (!write_png((page.folder() / shot.name).string(), image, error)) throw Fault(error);
        page.add(shot.name, shot.what);
    }
}

} // namespace crn::ct
