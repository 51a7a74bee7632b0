// Declares what a script's session needs of its device: a device that may go away and come back (device.hpp),
// or the device of a world of the C library (host/library/play.hpp).
#pragma once
#include "host/link/link.hpp"
#include "host/model/instrument.hpp"
#include "host/model/tool_line.hpp"
#include <functional>
#include <optional>
#include <span>
#include <vector>

namespace crn
{

class SteppedDevice
{
  public:
    virtual ~SteppedDevice() = default;
    virtual Link &link() = 0;                                 // the same object throughout
    virtual const std::vector<Instrument> &tools() const = 0; // the table
    virtual const LineNumbers &line() const = 0;              // at the start of the session
    std::size_t positions() const { return line().size(); }
    // Advances the device by these inputs, and reads the shape of the tools after the last one if
    // `want_nodes` is true. The functions of this class throw LinkError.
    virtual std::span<const crn_wire_tick_state> step(std::span<const crn_wire_tick_input> inputs,
                                                      bool want_nodes) = 0;
    virtual void ask(const std::function<void(Link &)> &request) = 0; // sends any other request
    virtual Hash64 read_hash64() = 0;                                 // of the last tick
    virtual std::optional<Hash64> last_hash64() = 0;                  // last one that came without a request
    virtual std::vector<std::uint8_t> read_snapshot() = 0;
    virtual std::uint32_t resumes() const { return 0; } // how often the device went away and came back
};

} // namespace crn
