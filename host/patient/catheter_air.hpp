// Records whether the lumen of the catheter may hold air. Air can enter when a tool is taken out of the
// lumen. Before the next injection the operator aspirates blood, which removes the air (docs/contrast.md,
// "Aspiration").
#pragma once
#include "host/base/state_archive.hpp"
#include "host/model/tool_line.hpp"
#include "shared/wire/wire.h"
#include <cstdint>
#include <optional>
#include <vector>

namespace crn
{

class CatheterAir
{
  public:
    // The assumed volume fills the lumen of the longest catheter of the project; the program assumes it for
    // all catheters.
    static constexpr std::int32_t enough_ul = 2000;

    // The catheter is the outermost of `tools` that has a lumen. The catheter is flushed with saline before
    // the session.
    explicit CatheterAir(const std::vector<Instrument> &tools);

    // Call this function after tools in use were replaced. A newly inserted catheter has been flushed; a tool
    // that was removed from the catheter's lumen may have let air in.
    void set_tools(const std::vector<Instrument> &tools, ChangedPositions changed);

    // Receives every tick.
    void tick(const crn_wire_tick_state &state);
    void aspirate(std::int32_t volume_ul);
    void inject(std::uint32_t tick);

    bool may_hold_air() const { return may_hold_air_; }
    // Returns the ticks of the injections that were given while the lumen might hold air.
    const std::vector<std::uint32_t> &injections() const { return injections_; }

    // Saves or restores the state; `tools` lists the tools in use, by position.
    void archive(StateArchive &state, const std::vector<Instrument> &tools);

  private:
    std::optional<std::size_t> tool_;
    std::uint32_t inside_bits_ = 0; // bit k: tool k lay in the lumen at the last tick
    std::int32_t aspirated_ul_ = 0;
    bool may_hold_air_ = false;
    std::vector<std::uint32_t> injections_;
};

} // namespace crn
