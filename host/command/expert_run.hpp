// Provides the expert's run of a case, which the replay shows beside the trainee's. The expert's script is
// played once, by a process of its own, and its recording is kept in the user's cache.
#pragma once
#include "host/cases/case.hpp"
#include <functional>
#include <string>

namespace crn
{

// Returns the path of the recording. The name of the file is a hash of the case, its script, its scene and
// the core, so a changed case gets a new recording. `goes_on` is called about ten times per second while the
// run is recorded; if it returns false, the work ends. Throws SceneStopped then, and std::runtime_error with
// the message of the process if it fails.
std::string expert_recording(const Case &lesson, const std::function<bool()> &goes_on);

} // namespace crn
