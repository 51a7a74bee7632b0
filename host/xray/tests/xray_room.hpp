// Makes pictures of simple bodies for the tests of the signal chain.
#pragma once
#include "host/xray/tests/xray_shapes.hpp"
#include "host/xray/xray.hpp"
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <memory>
extern "C" {
#include <cmocka.h>
}

namespace crn
{

struct Room {
    XrayScene scene;
    std::unique_ptr<Xray> xray;

    explicit Room(const Bodies &bodies)
    {
        std::string error;
        if (!scene.set_bodies(bodies, error)) fail_msg("%s", error.c_str());
        xray = std::make_unique<Xray>(scene, 2);
    }
    XrayPicture picture(const XraySettings &settings, std::uint32_t tick = 0)
    {
        XrayPicture picture;
        xray->render(settings, {}, WireFrame{.tick = tick, .nodes = {}, .tip_arc_m = {}}, 7, picture);
        return picture;
    }
    XrayPicture next(const XraySettings &settings, std::uint32_t tick, XrayMemory &memory)
    {
        XrayPicture picture;
        xray->render(settings, {}, WireFrame{.tick = tick, .nodes = {}, .tip_arc_m = {}}, 7, memory, picture);
        return picture;
    }
};

// Makes a slab that covers the whole field; its middle is at the isocentre.
inline Bodies slab(double thickness_m, const char *material = "soft_tissue")
{
    return {
        {box_body("slab", material, -1, {-0.5, -0.5, -0.5 * thickness_m}, {0.5, 0.5, 0.5 * thickness_m})}};
}

inline XraySettings fixed(double kV, double mA, double ms, double copper_mm = 0.2)
{
    XraySettings settings;
    settings.beam.fixed_technique = XrayTechnique{kV, mA, ms, copper_mm, 0.4};
    return settings;
}

// Returns the value that automatic exposure measures: the geometric mean of the signal over the round
// measuring field.
inline double measured_raw(const XrayPicture &picture)
{
    const double half = 0.5 * picture.size, reach = 0.65 * half;
    double sum = 0.0, count = 0.0;
    for (int y = 0; y < picture.size; ++y)
        for (int x = 0; x < picture.size; ++x) {
            if (std::hypot(x + 0.5 - half, y + 0.5 - half) > reach) continue;
            sum += std::log(picture.raw[static_cast<std::size_t>(y) * picture.size + x] + 0.5);
            count += 1.0;
        }
    return std::exp(sum / count);
}

} // namespace crn
