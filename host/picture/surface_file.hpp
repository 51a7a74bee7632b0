// Writes the walls around a lesion at several moments of a session as an OBJ file, which shows how the mesh
// changes during the treatment.
//
//   SurfaceSink sink(settings, ticks);
//   replay_recording(device, recording, &sink, {});         // writes the file at its end
#pragma once
#include "host/model/opened_bodies.hpp"
#include "host/picture/surface_picture.hpp"
#include "host/session/frame_sink.hpp"

namespace crn
{

struct SurfaceSettings {
    std::string bodies_path, scene_path; // as in PictureSettings
    std::string lesion;                  // its name; empty: the first
    double around_mm = 8.0;              // length of vessel on either side of the lesion
    std::string output;                  // the OBJ file
    std::string png;                     // also a picture; empty: none
};

class SurfaceSink final : public FrameSink
{
  public:
    // `ticks` lists the ticks at which the walls are written, in ascending order. Throws std::runtime_error
    // if the scene does not have the requested lesion.
    SurfaceSink(const SurfaceSettings &settings, std::vector<std::uint32_t> ticks);
    ~SurfaceSink() override;

    std::uint32_t next_tick() const override;
    void frame(const SessionFrame &frame) override;
    void finish() override; // throws FileError

    // Returns one panel for each requested tick that the session reached, with the vessels in the reference
    // pose of the scene.
    const std::vector<SurfacePanel> &panels() const { return panels_; }

  private:
    bool is_near(const Eigen::Vector3d &place_m) const;
    SurfaceMesh mesh_of(int body, std::span<const Eigen::Vector3i> vertices_um) const;
    SurfaceMesh balloon_of(const WireFrame &wire) const;
    SurfaceView side_view() const;

    SurfaceSettings settings_;
    std::vector<std::uint32_t> ticks_;
    Bodies bodies_;
    std::optional<Motion> motion_;
    VesselTree healthy_;
    std::size_t lesion_ = 0;
    std::optional<OpenedBodies> opened_;
    std::size_t at_ = 0; // number of finished moments
    std::vector<SurfacePanel> panels_;
};

} // namespace crn
