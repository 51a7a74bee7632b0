#include "host/session/run.hpp"
#include "host/session/session_run.hpp"

namespace crn
{

RunResult run_session(SteppedDevice &device, Patient &patient, const Session &session, Recorder *recorder,
                      FrameSink *sink, const RunSettings &settings)
{
    SessionRun run(device, patient, session, recorder, sink, settings);
    run.advance_to(UINT32_MAX);
    return run.end();
}

} // namespace crn
