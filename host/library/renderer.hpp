// Renders pictures and label images of worlds (simulated sessions). The picture is computed by the X-ray
// room's code (host/xray).
#pragma once
#include "host/library/world.hpp"
#include "host/patient/body_poses.hpp"
#include "host/patient/pulse_shot.hpp"
#include "host/xray/paths/paths.hpp"
#include <memory>

namespace crn::library
{

// Returns the X-ray settings for a view. Throws Refused.
XraySettings xray_settings(const cournand_view &view);
// Writes the projection matrix of a view, row by row.
void write_matrix(const cournand_view &view, double matrix[12]);

class Renderer
{
  public:
    Renderer(std::shared_ptr<const Scene> scene, std::uint32_t threads);
    void render(World &world, const cournand_view &view, cournand_picture &picture);

    OneAtATime door;

  private:
    PulseShot shot_at(World &world);
    // Chooses the bits of the label image for the tools and curves of this shot.
    void choose_labels(World &world, const PulseShot &shot);

    std::shared_ptr<const Scene> scene_;
    Xray xray_;
    BodyPoses poses_;
    XrayMemory memory_;
    XrayPicture picture_;
    ToolPaths paths_;
    TubeLabels labels_;
};

template <> struct HandleOf<cournand_renderer> {
    using Object = Renderer;
    static constexpr HandleKind kind = HandleKind::renderer;
    static constexpr char name[] = "renderer";
};

} // namespace crn::library
