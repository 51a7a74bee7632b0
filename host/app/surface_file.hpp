// The walls round a lesion at moments of a session, as an OBJ file: how the polygons go from stenosed to healthier.
//
//   SurfaceSink sink(settings, ticks);
//   replay_recording(device, recording, &sink, {});         // writes the file at its end
//
// May include: model, frame_sink. Called by: cli_surface, tests.
#pragma once
#include "host/app/frame_sink.hpp"
#include "host/model/opened_bodies.hpp"
#include <memory>

namespace seld
{

struct SurfaceSettings {
    std::string bodies_path, scene_path; // as PictureSettings
    std::string lesion;                  // its name; empty: the first
    double around_mm = 8.0;              // of the vessel, to either side of the lesion
    std::string output;
};

class SurfaceSink final : public FrameSink
{
  public:
    // `ticks`: of the moments, in order. Throws std::runtime_error for a scene without that lesion.
    SurfaceSink(const SurfaceSettings &settings, std::vector<std::uint32_t> ticks);
    ~SurfaceSink() override;

    void command(std::uint32_t, const RoomCommand &) override {}
    std::uint32_t next_tick() const override;
    void frame(const SessionFrame &frame) override;
    void finish() override; // throws FileError

    std::size_t moments() const { return at_; } // written
    // Everything in the pose that the scene is described in, mm: for every moment the objects TIME_BODY and TIME_balloon.
    const std::string &obj() const { return obj_; }

  private:
    bool is_near(const Eigen::Vector3d &place_m) const;
    void add_body(const std::string &prefix, int body, std::span<const Eigen::Vector3i> vertices_um);
    void add_balloon(const std::string &prefix, const WireFrame &wire);

    SurfaceSettings settings_;
    std::vector<std::uint32_t> ticks_;
    Bodies bodies_;
    std::optional<Motion> motion_;
    VesselTree healthy_;
    std::size_t lesion_ = 0;
    std::optional<OpenedBodies> opened_;
    std::size_t at_ = 0, vertices_ = 0; // moments done; vertices of the file
    std::string obj_;
};

} // namespace seld
