// Makes small X-ray runs like those of the simulated X-ray room, for tests. The runs contain rendered frames
// of a sphere in a box, and every value that a DICOM file contains.
#pragma once
#include "host/xray/run.hpp"
#include "host/xray/tests/xray_shapes.hpp"
#include "host/xray/xray.hpp"

namespace crn
{

inline constexpr int run_size = 64;

// Makes frames at the pulse rate of the run; the first frame is at tick 1000. If `moves` is true, the angles,
// the table and the tube values differ from frame to frame.
inline XrayRun sample_run(RunKind kind, int frame_count, bool moves = false)
{
    Bodies bodies;
    bodies.bodies.push_back(box_body("water", "soft_tissue", -1, {-0.1, -0.1, -0.05}, {0.1, 0.1, 0.05}));
    bodies.bodies.push_back(sphere_body("ball", "bone_cortical", 0, {0.02, 0.01, 0.0}, 0.02, 8));
    XrayScene scene;
    std::string error;
    scene.set_bodies(bodies, error);
    Xray xray(scene, 1);
    XrayRun run;
    run.kind = kind;
    run.number = 3;
    run.size = run_size;
    run.pulses_per_s = kind == RunKind::dsa ? 4.0 : 15.0;
    run.window_centre = 1200.0;
    run.window_width = 2000.0;
    run.collimator = {false, 1, 63, 2, 62, 0.0, 0.0, 0.0};
    run.filters = {{"aluminum", 2.5}, {"copper", 0.2}};
    run.focal_spot_mm = 0.6;
    if (kind == RunKind::dsa) {
        run.mask = RunMask{{0, 1}, 1.5, -0.25};
        run.contrast = RunContrast{"iohexol", 350.0, 12.0, 6.0, 1500, 2.0};
    }
    for (int i = 0; i < frame_count; i++) {
        RunFrame frame;
        frame.tick = 1000 + static_cast<std::uint32_t>((i * 1000 + run.pulses_per_s - 1) / run.pulses_per_s);
        frame.carm.primary_deg = moves ? 10.0 + i * 2.5 : 40.0;
        frame.carm.secondary_deg = moves ? -i * 1.25 : -30.0;
        frame.carm.isocentre_m = {moves ? -0.001 * i : 0.01, moves ? 0.002 * i : 0.02,
                                  moves ? 0.003 * i : 0.0};
        frame.tube_voltage_kV = 75.0 + i;
        frame.tube_current_mA = 100.0 + 0.5 * i;
        frame.pulse_ms = 5.0;
        frame.air_kerma_uGy = 20.0 + i;
        frame.kap_Gy_cm2 = 0.004;
        XraySettings settings;
        settings.carm = frame.carm;
        settings.size = run_size;
        WireFrame wire;
        wire.tick = frame.tick;
        XrayPicture picture;
        xray.render(settings, {}, wire, 7, picture);
        frame.raw = picture.raw;
        run.frames.push_back(std::move(frame));
    }
    return run;
}

} // namespace crn
