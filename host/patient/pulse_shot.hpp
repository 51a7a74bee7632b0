// Holds what an X-ray pulse sees of a session: tools, contrast medium, struts of stents, and bodies that
// move.
#pragma once
#include "host/model/instrument.hpp"
#include "host/model/tool_line.hpp"
#include "host/patient/patient.hpp"
#include "host/xray/paths/moved.hpp"
#include <span>
#include <vector>

namespace crn
{

// Throws std::runtime_error if a material is unknown; the message names the section and the known materials.
RadiopaqueInstrument instrument_look(const Instrument &instrument);

// Returns what X-rays see of the tools in use: one entry for each position (tool_line.hpp). A position
// without a tool is invisible to X-rays.
std::vector<RadiopaqueInstrument> looks_on(std::span<const RadiopaqueInstrument> table,
                                           std::span<const std::uint8_t> line);

// Holds everything that the picture of one X-ray pulse needs from the patient.
struct PulseShot {
    WireFrame shape;  // the tools, with the concentration of iodine around them
    LineNumbers line; // which tools these are
    std::vector<SweptCurve> curves;
    // The vertices of the bodies that move belong to the patient until own() has copied them.
    std::vector<MovedBody> bodies;
    void own();

    PulseShot() = default;
    PulseShot(PulseShot &&) = default; // a copy would refer to the vertices of the original
    PulseShot &operator=(PulseShot &&) = default;

  private:
    std::vector<std::vector<Eigen::Vector3i>> vertices_um_;
};

// Returns what an X-ray pulse at `tick` sees. The returned PulseShot refers to the patient's bodies until
// they move, unless PulseShot::own() is called. `shape` is the shape of the tools at the pulse.
PulseShot shot_of(Patient &patient, const WireFrame &shape, std::uint32_t tick, double iodine_mg_per_ml);

} // namespace crn
