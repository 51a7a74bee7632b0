// Draws pictures that look like the fluoroscopy screen of the simulator VCSim3 (thesis, 5.3.4.1), as an
// alternative to the physical picture. This look has no attenuation. In the style of VCSim3, a surface's
// opacity depends on the angle between its normal and the direction of view; noise is added to the picture
// afterwards. The thesis gives the idea without an equation; ours is in docs/xray-style.md:
//
//   I = product over all surfaces s on the ray of (1 - A_s (1 - |n_s . v|)^p_s),   grey = 255 (b I + sigma g)
#pragma once
#include "host/xray/xray.hpp"

namespace crn
{

// Describes the opacity of a surface seen edge-on, and how the opacity decreases as the surface turns towards
// the viewer.
struct SurfaceLook {
    double edge_opacity = 0.0; // A, 0 .. 0.98; 0: not shown
    double power = 2.0;        // p
};

// Returns the opacity of a body's surface, if the body is of a kind that the thesis shows: skeleton, heart
// and filled vessels. The opacity of skin, fat, lungs and gas is 0, so they are not drawn.
SurfaceLook surface_look(const Bodies &bodies, std::size_t index);

inline constexpr double vcsim3_background = 0.84; // b, share of white
inline constexpr double vcsim3_noise = 0.035;     // sigma, share of white
inline constexpr SurfaceLook vcsim3_tool = {0.75, 0.6};
inline constexpr SurfaceLook vcsim3_contrast = {0.80, 0.7}; // undiluted

// Returns the opacity of a curve's surface: for contrast medium according to its fraction of the
// cross-section (0 .. 1), and for a strut as dark as a tool.
SurfaceLook curve_look(Material material, double share);

struct SurfaceScene; // the bodies that are shown, and the sums of the last view

class Vcsim3Look
{
  public:
    explicit Vcsim3Look(const Bodies &bodies, int threads = 0); // threads as for Xray
    ~Vcsim3Look();
    Vcsim3Look(const Vcsim3Look &) = delete;
    Vcsim3Look &operator=(const Vcsim3Look &) = delete;

    // Replaces only `grey` and `shown` of a picture; the picture's photon counts and doses remain those of
    // Xray::render. Like Xray::render, draw() gives the same result, bit for bit, for any number of threads.
    // The function uses only `carm` and `size` of the settings.
    void draw(const XraySettings &settings, const XrayFrame &frame, std::uint64_t seed, XrayPicture &picture);

    // Returns, for each of the size*size pixels of the last picture, the sum of -ln(1 - opacity) over the
    // surfaces of the bodies, in units of 1/65536.
    const std::vector<std::int32_t> &body_density_q16() const;

  private:
    std::unique_ptr<SurfaceScene> scene_;
};

} // namespace crn
