// Plays a session script (docs/session.md) in a world, as `cournand run` plays it on a device: with hands
// that slip and steer, expectations, the X-ray room, a recording and a report.
#pragma once
#include "host/library/world.hpp"
// After cournand.h:
#include "host/library/cournand_play.h"
#include "host/script/expect.hpp"
#include "host/script/session.hpp"
#include "host/session/session_run.hpp"
#include "host/session/stepped_device.hpp"

namespace crn::library
{

// Lets a session step a world. The patient and the recorder belong to the session meanwhile, and every other
// call that would change the world is refused.
class LedWorld final : public SteppedDevice
{
  public:
    explicit LedWorld(std::shared_ptr<World> world);
    Link &link() override;
    const std::vector<Instrument> &tools() const override;
    const LineNumbers &line() const override;
    std::span<const crn_wire_tick_state> step(std::span<const crn_wire_tick_input> inputs,
                                              bool want_nodes) override;
    void ask(const std::function<void(Link &)> &request) override;
    Hash64 read_hash64() override;
    std::optional<Hash64> last_hash64() override;
    std::vector<std::uint8_t> read_snapshot() override;
    RecordingHeader recording_header(const std::string &session) const;
    void begin_call();           // the readings of the wall forces begin anew
    void allow_saving(bool may); // false: the patient has already given orders for coming ticks

  private:
    std::shared_ptr<World> world_;
};

struct PlaySettings {
    std::shared_ptr<const Scene> scene;
    std::vector<NamedTool> tools;
    std::vector<std::string> stents; // paths
    std::string record;              // path; empty: no recording
};

class Play
{
  public:
    // Throws FileError with the place in the script, Refused, LinkError.
    Play(const Session &session, PlaySettings settings);

    // The world that the script leads. Its door is also the door of the play.
    const std::shared_ptr<World> &world() const { return world_; }
    // Advances by at most `ticks`; if `to_pulse` is true, at most to the next pulse of the X-ray room. At the
    // script's end, the recording is completed and the report is made. Throws Refused.
    void advance(std::uint32_t ticks, bool to_pulse);
    void read(cournand_play_state &state) const;
    void read(cournand_view &view) const; // the C-arm of the X-ray room
    const std::string &report() const;    // throws Refused until the script has ended

  private:
    void make_report(RunResult result);

    Session session_;
    std::shared_ptr<World> world_;
    LedWorld device_;
    std::unique_ptr<Recorder> recorder_;
    std::optional<EffectsWitness> witness_;
    std::optional<SessionRun> run_; // none: the script has ended
    bool is_at_pulse_ = false;
    std::string report_, failures_, broken_;
    std::uint32_t exit_status_ = 0;
};

void describe(const Session &session, cournand_script_info &info);

template <> struct HandleOf<cournand_script> {
    using Object = Session;
    static constexpr HandleKind kind = HandleKind::script;
    static constexpr char name[] = "script";
};

template <> struct HandleOf<cournand_play> {
    using Object = Play;
    static constexpr HandleKind kind = HandleKind::play;
    static constexpr char name[] = "play";
};

} // namespace crn::library
