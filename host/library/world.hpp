// Implements a world of the API: one simulated device in this process, with the tools, orders and readings of
// one session, and a patient if the world has one. Device, link and patient are the same code as in `cournand
// run`, so equal orders give equal hashes. Snapshots are in snapshot.hpp.
#pragma once
#include "host/library/scene.hpp"
#include "host/library/tool.hpp"
#include "host/link/link.hpp"
#include "host/link/sim_transport.hpp"
#include "host/model/order_queue.hpp"
#include "host/model/tool_line.hpp"
#include "host/patient/patient.hpp"
#include "host/session/range_watch.hpp"
#include "host/session/recording.hpp"
#include "host/session/set_up.hpp"
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace crn::library
{

struct WorldSettings {
    std::shared_ptr<const Scene> scene;
    std::vector<Instrument> tools; // the table
    LineNumbers line{};            // as Device has it
    crn_wire_entry entry{};
    crn_wire_rig rig{};
    bool has_patient = false;
    std::uint32_t contact_ticks = 0; // 0: the wall forces are not sampled
    std::vector<StentDesign> stents{};
};

// Returns the world settings that the caller's C struct states. Throws Refused.
WorldSettings world_settings(std::shared_ptr<const Scene> scene, std::vector<Instrument> tools,
                             const cournand_world_options *options);

// Returns a number that differs between two worlds that cannot restore each other's snapshots.
std::uint64_t fingerprint(const SceneFile &scene, const std::vector<Instrument> &tools,
                          const LineNumbers &line, const crn_wire_entry &entry, const crn_wire_rig &rig);

class World
{
  public:
    // Throws Refused, LinkError.
    explicit World(WorldSettings settings);

    OneAtATime door;
    char error_text[text_bytes] = ""; // of the last refusal

    // Throws Refused if an earlier fault has stopped the world.
    void check_alive() const;
    // Throws Refused if a script leads the world (play.hpp).
    void check_free() const;

    // --- advancing (world_advance.cpp) ---
    struct Speeds { // of the hands in 1e-6 counts per tick
        std::int64_t push[COURNAND_POSITIONS_MAX] = {}, turn[COURNAND_POSITIONS_MAX] = {};
        std::int32_t inflator_kPa = 0;
    };
    // Throws Refused as move() would.
    Speeds checked_speeds(std::span<const float> action, std::uint32_t ticks) const;
    void move(std::span<const float> action, std::uint32_t ticks);
    void order(const cournand_order &order);
    void advance(std::span<const cournand_input> inputs);
    void replay(std::shared_ptr<const Recording> recording, std::uint32_t tick);
    std::uint32_t tick() const { return link_.tick(); }

    // --- reading (world_read.cpp) ---
    const WireFrame &frame(); // the shape now; the patient is at the same tick
    void read(cournand_pose &pose);
    void read(cournand_reading &reading);
    void read(cournand_contacts &contacts);
    void read(std::uint32_t position, cournand_place &place);
    void read(cournand_patient_reading &reading);
    // Writes where points of the tissue, which are given in the reference pose, are now. Rows of x, y, z in
    // m.
    void moved(std::span<const double> rest_m, std::span<double> now_m);
    std::uint64_t hash();
    std::size_t read(std::span<cournand_fault> faults);

    // --- the patient ---
    void inject(double volume_ml, double flow_ml_per_s, std::int32_t position, double iodine_mg_per_ml);
    void load_stent();
    Patient *patient() { return patient_.get(); }

    // --- snapshots (snapshot.cpp) ---
    std::size_t snapshot_bytes(); // of a snapshot now
    void save(std::span<std::uint8_t> bytes);
    void restore(std::span<const std::uint8_t> bytes);

    // --- recording (world_record.cpp) ---
    void record(const std::string &path, const std::string &session);
    void end_recording();
    RecordingHeader recording_header(const std::string &session) const;

    const WorldSettings &settings() const { return settings_; }
    const Scene &scene() const { return *settings_.scene; }
    std::size_t positions() const { return settings_.line.size(); }
    const std::vector<Instrument> &tools_on_line();
    // Returns how the tools in use look in X-ray pictures. Throws std::runtime_error if a material is
    // unknown.
    const std::vector<RadiopaqueInstrument> &looks_on_line();

  private:
    friend class LedWorld;             // of a play
    void require_may_be_saved() const; // throws Refused between two decisions of a script
    // Fills in the input of a tick; the number of the tick counts from 0 in each call of the library.
    using Fill = std::function<void(std::uint32_t, crn_wire_tick_input &)>;
    struct Source {
        const Fill &fill;
        const Recording *recording; // null: the inputs are new
        bool sets_hands;            // the hands continue from the last input
    };
    void run(std::uint32_t ticks, const Source &source);
    std::uint32_t batch_size(std::uint32_t left, const Recording *recording) const;
    void batch(std::uint32_t done, std::uint32_t count, const Source &source);
    void take(const crn_wire_tick_input &input, const crn_wire_tick_state &state);
    void note(const crn_wire_tick_state &state);
    void compare(const crn_wire_tick_state &state, const Recording &recording) const;
    void sample_contacts();
    void feel();
    void take_hands(const crn_wire_tick_input &input);
    void check_ticks(std::size_t ticks) const;
    void try_orders(const crn_wire_order_list &orders);
    crn_wire_tick_input present_input() const;
    void pass_recorded(const Recording &recording);
    void resume_recorded(const Recording &recording);
    void put_device(std::span<const std::uint8_t> bytes, std::uint32_t tick);
    void forget_views();
    void reserve_views();
    std::span<const std::uint8_t> saved_patient(); // until its next call; empty: the world has none
    bool restore_patient(std::span<const std::uint8_t> bytes, std::uint32_t tick,
                         const crn_wire_tick_state &state);
    template <class Work>
    void with_patient(std::span<const std::uint8_t> bytes, std::uint32_t tick,
                      const crn_wire_tick_state &state, Work work);
    void settle(); // brings the patient to this tick
    void command(const RoomCommand &command);
    Patient &need_patient();
    void record_state();
    // Calls `work` with the world's recorder, if there is one. If the recording cannot be written, the
    // recording ends, and the world continues.
    template <class Work> void recording_work(Work work)
    {
        if (!recorder_) return;
        try {
            work(*recorder_);
        } catch (const RecordingError &error) {
            recorder_failure_ = error.what();
            recorder_.reset();
        }
    }
    const crn_wire_nodes &nodes();
    void follow_line();

    WorldSettings settings_;
    std::uint64_t fingerprint_ = 0;
    SimTransport pipe_;
    Link link_;
    std::uint32_t core_version_ = 0;
    std::unique_ptr<Patient> patient_;
    bool was_commanded_ = false; // the patient has received a command
    std::vector<std::uint8_t> patient_bytes_;
    bool is_led_ = false, may_be_saved_ = true; // by a script; at this tick
    std::string stopped_;                       // why the world cannot continue; empty: it can

    // Holds the positions of the hands in 1e-6 counts since tick 0, and the pressure of the inflator.
    std::int64_t push_[COURNAND_POSITIONS_MAX] = {}, turn_[COURNAND_POSITIONS_MAX] = {};
    std::int32_t inflator_kPa_ = 0;
    OrderQueue orders_;
    std::vector<crn_wire_tick_input> inputs_; // of the present batch
    crn_wire_tick_state state_{};             // of the last tick
    RangeWatch range_;
    std::optional<std::uint32_t> out_of_range_tick_;
    double wall_N_ = 0.0, wall_peak_N_ = 0.0;

    // The following views of the world's state are valid until its next change.
    bool has_nodes_ = false, has_contacts_ = false;
    WireFrame frame_;
    LineNumbers line_now_;
    std::vector<Instrument> tools_now_;
    std::vector<RadiopaqueInstrument> looks_, looks_now_;
    std::vector<float> positions_m_, arcs_m_, radii_m_, tip_arcs_m_, inserted_m_, forces_N_;
    std::vector<std::uint32_t> contact_nodes_;
    std::string stage_text_;

    std::unique_ptr<Recorder> recorder_;
    std::string recorder_failure_;
    std::uint32_t recorded_hash_tick_ = 0;

    std::shared_ptr<const Recording> replayed_; // whose commands the patient receives
    std::size_t replayed_command_ = 0;          // the next one
};

// Returns the checksum of a snapshot's bytes; the snapshot contains it in its bytes 24 to 31.
inline constexpr std::size_t snapshot_check_at = 24;
std::uint64_t snapshot_check(std::span<const std::uint8_t> snapshot);

// Returns the status with which cournand_world_move() would refuse these arguments.
cournand_status check_move(const cournand_world *world, const float *action, std::uint32_t ticks) noexcept;

template <> struct HandleOf<cournand_world> {
    using Object = World;
    static constexpr HandleKind kind = HandleKind::world;
    static constexpr char name[] = "world";
};

} // namespace crn::library
