// Provides the expert's run of a case, which the replay shows beside the trainee's. The expert's script is
// played once, in a separate process, and its recording is kept in the user's cache.
#pragma once
#include "host/cases/case.hpp"
#include <functional>
#include <string>

namespace crn
{

// Returns the path of the recording of the expert's run. The name of the file is a hash of the case, its
// script, its scene and the core, so a changed case gets a new recording. `goes_on` is called about ten times
// per second while the run is recorded; if it returns false, the work ends. If `goes_on` returned false, the
// function throws SceneStopped; if the process fails, the function throws a std::runtime_error with the
// message of the process.
std::string expert_recording(const Case &lesson, const std::function<bool()> &goes_on);

} // namespace crn
