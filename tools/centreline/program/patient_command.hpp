// The command `centreline patient`: a playable scene from a person's own vessel meshes (docs/own_mesh.md).
#pragma once
#include "tools/patient/options.hpp"

namespace crn::patient
{

void add_patient(CLI::App &app, SceneOptions &options, std::vector<std::string> &meshes);
int command_patient(const SceneOptions &options, const std::vector<std::string> &meshes);

} // namespace crn::patient
