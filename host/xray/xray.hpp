// Makes X-ray pictures of bodies and tools. To make a picture, the program computes path lengths, tube
// spectrum, exposure control, scatter, blur, quantum noise, lag and display.
//
//   XrayScene scene; scene.set_bodies(bodies, error);
//   Xray xray(scene, threads);
//   xray.render(settings, tools, frame, seed, picture);            a single picture
//   XrayMemory memory;                                             {}: generator and detector just switched on
//   xray.render(settings, tools, frame, seed, memory, picture);    one of a sequence; memory carries over
//
// A picture depends only on bodies, tools, WireFrame with its tick, settings, seed and memory. The picture is
// equal bit for bit with any number of threads, any compiler and any optimisation level. The path lengths of
// the bodies are kept as long as the C-arm does not move. See docs/xray.md.
#pragma once
#include "host/model/bodies.hpp"
#include "host/xray/exposure.hpp"
#include "host/xray/paths/carm.hpp"
#include "host/xray/paths/moved.hpp"
#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace crn
{

struct XrayBeam {
    ExposureMode mode = ExposureMode::fluoro;
    // The dose per frame is the mean over the measuring field, behind patient and grid. Automatic exposure
    // aims at the demanded dose per frame, and the gain of the detector is chosen for this dose. Usual values
    // are 20 .. 60 in fluoroscopy, 100 .. 250 in cine, and 500 .. 3000 in DSA.
    double dose_per_frame_nGy = 40.0;
    double frame_period_ms = 1000.0 / 15.0; // for the limit of the dose rate
    // If a technique (voltage, current, pulse width and filter) is fixed by the user or locked by a DSA run,
    // automatic exposure is not used. The fixed technique is limited to the ranges of the tube.
    std::optional<XrayTechnique> fixed_technique;
    bool noise = true;
    bool scatter = true;
    bool circular_field = false;     // round image intensifier instead of a square flat detector
    double open_width_share = 0.97;  // of the field between the blades left and right, 0.05 .. 1
    double open_height_share = 0.97; // of the field between the blades above and below, 0.05 .. 1
};

struct XrayDisplay {
    double contrast = 1.0;   // slope of the display curve
    double brightness = 0.0; // -1 .. 1
    double harmonise = 0.65; // 0: plain log image; towards 1: slow changes of density are levelled
    // `window` and `level` select the displayed part of the 12-bit values `shown` (DICOM PS3.3 C.11.2.1.2):
    // the values from level - window/2 to level + window/2 cover all greys.
    double window = 4096.0;
    double level = 2048.0;
};

struct XraySettings {
    CArm carm;
    XrayBeam beam;
    XrayDisplay display;
    int size = 512; // pixels along each edge, 64 .. 2048
};

// Returns the size in pixels of the picture that is made: a multiple of 16 within 64 .. 2048.
int held_size(int size);

// Raw values are 14 bits. The demanded dose gives raw_of_wanted_dose.
inline constexpr std::uint16_t raw_max = 16383;
inline constexpr double raw_of_wanted_dose = 1024.0;

// All pictures consist of size*size pixels, with row 0 on top.
struct XrayPicture {
    int size = 0;
    std::uint32_t tick = 0;
    std::vector<std::uint8_t> grey;   // on the screen
    std::vector<std::uint16_t> shown; // before window and level, 12 bits
    std::vector<std::uint16_t>
        raw; // of the detector, 14 bits, in proportion to the quanta; behind blur and lag
    std::vector<std::uint32_t>
        photons; // quanta drawn per pixel, before the scintillator's blur; 0 outside the collimator

    double photons_open = 0.0;   // mean count of an unattenuated pixel
    double raw_per_photon = 0.0; // gain
    XrayTechnique technique;
    bool is_underexposed = false; // automatic exposure is at a limit
    double air_kerma_uGy =
        0.0;                 // of this frame at the reference point, 15 cm from the isocentre toward the tube
    double kap_Gy_cm2 = 0.0; // kerma times the collimated field's area, the same at every distance
};

// Holds what the generator and the detector remember from picture to picture. XrayMemory is plain data: a
// copy saves it, and {} resets it.
struct XrayMemory {
    bool is_used = false;
    ExposureState exposure;
    std::uint32_t tick = 0;     // of the last picture
    int size = 0;               // of `trapped`
    double field_m = 0.0;       // in another field or size pixels have other places: their traps are empty
    std::vector<float> trapped; // quanta held back by the photodiodes
};

class XrayScene;
struct XrayChain;
class BodyPaths;
struct BodyMeshes;

// Makes the back end that computes the path lengths of the bodies (paths.hpp).
using BodyPathsMaker = std::function<std::unique_ptr<BodyPaths>(const BodyMeshes &meshes, int threads)>;

// The bodies of a scene. The bodies do not change after set_bodies(), and any number of Xray objects may use
// them.
class XrayScene
{
  public:
    XrayScene();
    ~XrayScene();
    XrayScene(const XrayScene &) = delete;
    XrayScene &operator=(const XrayScene &) = delete;
    // Returns false if a material or parent is unknown; in that case `error` gives the body's name and the
    // cause, and the scene is empty. If `bodies` have a CT, the scene keeps it, and two more copies of its
    // voxels.
    bool set_bodies(const Bodies &bodies, std::string &error);
    std::size_t triangle_count() const;
    struct Meshes;
    const Meshes &meshes() const { return *meshes_; }

  private:
    std::unique_ptr<Meshes> meshes_;
};

class Xray
{
  public:
    // If `threads` is 0, Xray uses one thread per processor, and at most 4. If `make_paths` is empty,
    // RasterPaths draws the bodies. A scene with a CT is always drawn by VolumePaths.
    explicit Xray(const XrayScene &scene, int threads = 0, const BodyPathsMaker &make_paths = {});
    ~Xray();
    Xray(const Xray &) = delete;
    Xray &operator=(const Xray &) = delete;

    // `tools` lists the nested tools from the innermost outwards; each is drawn along the part of their
    // common centreline that it covers (wire.tip_arc_m).
    void render(const XraySettings &settings, std::span<const RadiopaqueInstrument> tools,
                const WireFrame &wire, std::uint64_t seed, XrayPicture &picture);

    // Makes the next picture of a sequence: its exposure depends on the earlier pictures, and the detector
    // has lag. A picture without `memory` is made with the exposure at which automatic exposure settles, and
    // without lag.
    void render(const XraySettings &settings, std::span<const RadiopaqueInstrument> tools,
                const WireFrame &wire, std::uint64_t seed, XrayMemory &memory, XrayPicture &picture);

    // Makes the next picture with everything that can move: tools, struts, contrast medium and beating
    // bodies. `memory` may be null.
    void render(const XraySettings &settings, const XrayFrame &frame, std::uint64_t seed, XrayMemory *memory,
                XrayPicture &picture);

    // The next functions return the path lengths of the last picture in 1/1024 mm, size*size pixels each.
    // body_path_q10mm() returns those of the bodies, where nested bodies are subtracted from their parents.
    // instrument_path_q10mm() returns those of tools and curves, negative where these displace a material.
    // The returned list of path lengths is empty if the picture does not contain the material.
    std::vector<std::int32_t> body_path_q10mm(Material material) const;
    std::vector<std::int32_t> instrument_path_q10mm(Material material) const;
    bool last_render_used_cache() const;
    std::string_view back_end() const;         // the back end that draws the bodies
    const std::string &back_end_error() const; // why the requested back end was abandoned; empty: it was not

  private:
    std::unique_ptr<XrayChain> chain_;
};

} // namespace crn
