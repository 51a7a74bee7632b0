// A Link is a conversation with a device: handshake, set-up, steps, shape of the tools, and snapshots.
//
//   SimTransport pipe;
//   Link link(pipe);
//   link.hello();                                  // throws LinkError when the two do not match
//   link.load_scene(bytes);                        // optional; free space without
//   link.load_tools(tables); link.set_entry(entry); link.set_rig(rig);   // tools from the innermost to the outermost
//   link.arm(); link.start();
//   auto states = link.step(inputs, true);         // one tick per input, at most Link::steps_max
//   link.nodes();                                  // the shape after the last of them
//
// Every refusal by the device becomes a LinkError, whose text names the refused request, the cause and the
// remedy.
#pragma once
#include "host/link/patience.hpp"
#include "host/link/transport.hpp"
#include "shared/wire/wire_frame.h"
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace crn
{

// `reject` is the device's refusal. The code in `reject` is 0 if the LinkError has a cause other than
// a refusal, for example a silent device, a fault or a different version.
class LinkError : public std::runtime_error
{
  public:
    explicit LinkError(const std::string &text, const crn_wire_reject &reject_ = {})
        : std::runtime_error(text), reject(reject_)
    {
    }
    crn_wire_reject reject;
};

struct Hash64 {
    std::uint32_t tick = 0;
    std::uint64_t hash = 0;
};

class Link
{
  public:
    static constexpr std::size_t steps_max = CRN_WIRE_MAX_step_inputs;
    // The following limits hold for the frames that a device sends before an answer, for the bytes of a
    // snapshot, and for the notices that wait for the host. No correct device exceeds them.
    static constexpr std::uint32_t frames_at_once_max = 10000, snapshot_bytes_max = 1 << 20,
                                   notices_max = 4096, live_ticks_max = 1 << 16;

    static constexpr std::size_t bytes_without_frame_max = 1 << 18; // a frame has 12 kB at most

    // `patience` is the total time for which the device may keep the host waiting (patience.hpp).
    explicit Link(Transport &transport, Patience::Span patience = Patience::budget_default);

    // Begins a conversation. The device refuses a conversation while another program controls powered motors.
    // A program that has disconnected loses this control after at most 50 ms.
    crn_wire_hello_reply hello();
    void load_scene(std::span<const std::uint8_t> scene);
    void load_scene(std::span<const std::uint8_t> scene, std::uint32_t crc32); // of the bytes
    // `line` holds one number for each position of the line (the nested tools): the number of its tool in the
    // session's table, from 1, or 0 if the position has no tool. If `line` is empty, all tools of the
    // session's table are in use.
    void load_tools(std::span<const crn_wire_instrument> tools, std::span<const std::uint8_t> line = {});
    void set_entry(const crn_wire_entry &entry);
    void set_rig(const crn_wire_rig &rig);
    crn_wire_status arm();        // also reads the node table
    crn_wire_status arm_motors(); // FREE_RUN with a rig: the next start() powers the motors
    crn_wire_status start();
    crn_wire_status stop();
    crn_wire_status stop_at(std::uint32_t tick); // stops once that many ticks are done
    crn_wire_status reset();
    void set_stream(const crn_wire_stream &stream); // events and pictures without a request
    crn_wire_status use_lockstep();
    crn_wire_status use_free_run();

    // In the mode LOCKSTEP, step() advances the device by one tick per input. The list of ticks that step()
    // returns is valid until the next call. If a fault stops the device, step() stores the ticks that were
    // finished and then throws an exception; tick() returns the last of these ticks.
    std::span<const crn_wire_tick_state> step(std::span<const crn_wire_tick_input> inputs, bool want_nodes);
    std::uint32_t tick() const { return tick_; }

    // In the mode FREE_RUN, free_run() sends the newest input, waits for the given time and receives what the
    // device sends meanwhile. During the wait the host repeats the last input at least every heartbeat_ms,
    // because the device reduces the forces to zero after 30 ms of silence.
    static constexpr std::uint32_t heartbeat_ms = 10;
    void send_input(const crn_wire_tick_input &input); // without orders
    void say_present();                                // one heartbeat; nothing is received
    std::vector<crn_wire_tick_state> free_run(std::uint32_t milliseconds);
    // In the mode FREE_RUN, the device carries out these commands ("orders") in the next tick that has no
    // other commands. In the mode LOCKSTEP, commands to the core are part of a tick's input. `orders` must
    // contain at least one command. Throws LinkError.
    void give_orders(const crn_wire_order_list &orders);
    // The next functions return the ticks of the last call (with inputs, sensors and flags) and the events
    // since that call, also after an exception.
    const std::vector<crn_wire_live_tick> &live_ticks() const { return live_ticks_; }
    std::uint32_t ticks_lost() const { return live_.ticks_lost; }
    std::uint32_t ticks_missing() const
    {
        return ticks_missing_;
    } // number of ticks that were lost by the device or the cable
    std::vector<crn_wire_notice> take_notices();

    const crn_wire_nodes &nodes() const { return nodes_; } // last received
    const crn_wire_nodes &read_nodes();
    const crn_wire_node_table &node_table() const { return node_table_; } // read by arm()
    const crn_wire_contacts &read_contacts(); // forces with which the wall holds the line now
    Hash64 read_hash64();
    // Last one of those that the device sends every 100 ticks without a request.
    static constexpr std::uint32_t hash64_every_ticks = 100;
    std::optional<Hash64> last_hash64() const { return hash64_; }
    crn_wire_status read_status();
    crn_wire_fault_log read_fault_log();
    crn_wire_rig read_rig();         // the active configuration
    crn_wire_set_up read_set_up();   // what the device already has
    crn_wire_sensors read_sensors(); // the rig's last sample
    std::vector<std::uint8_t> read_snapshot();
    void write_snapshot(std::span<const std::uint8_t> snapshot); // LOCKSTEP, armed
    // Tells the Link that SimTransport::put_snapshot has set the device to a snapshot of this tick.
    void continue_at(std::uint32_t tick)
    {
        tick_ = tick;
        hash64_.reset();
    }

  private:
    void send(std::uint16_t type, const crn_wire_writer &payload);
    template <class Message, class Put>
    void send_message(std::uint16_t type, const Message &message, Put put, bool goes_on = false);
    void write(std::span<const std::uint8_t> bytes);
    void take_what_came(std::uint32_t &frames);
    [[noreturn]] void broken(const char *what) const; // for a message of wrong form
    [[noreturn]] void silent() const;
    void check_patience();
    bool receive(); // reads the next frame into decoder_; false when the device is silent
    bool receive_one_of(std::uint32_t &frames);
    bool is_late_refusal() const;
    bool ask_hello(const crn_wire_hello &hello);
    crn_wire_hello_reply hello_once();
    // Receives frames until a frame of type `type` arrives; `ticks` is the number of ticks that the device
    // has to compute first. Frames of other types are stored, and a frame that reports a refusal causes an
    // exception.
    void receive_answer(std::uint16_t type, std::size_t ticks = 0);
    void file_frame();
    void file_stream();
    void file_live();
    void beat();
    void drop_given();
    crn_wire_status command(std::uint8_t action);
    void get(std::uint8_t what, std::uint16_t answer);

    Transport &transport_;
    Patience patience_;
    std::uint16_t waits_for_ = 0; // type of the expected answer; 0: none in particular
    std::size_t bytes_without_frame_ = 0;
    crn_wire_decoder decoder_;
    std::vector<std::uint8_t> incoming_, outgoing_, frame_;
    std::size_t incoming_position_ = 0, incoming_count_ = 0;
    std::uint16_t sequence_ = 0, asked_from_ = 0; // last frame sent, and the first one of this request
    std::uint32_t tick_ = 0;
    std::optional<std::uint32_t>
        live_tick_; // last tick that came without a request; none: the next batch gives the device's tick
    std::vector<crn_wire_tick_state> free_run_states_;
    std::vector<crn_wire_live_tick> live_ticks_;
    std::size_t ticks_given_ = 0; // of both, at the last free_run()
    std::vector<crn_wire_notice> notices_;
    crn_wire_live live_{};
    std::uint32_t ticks_missing_ = 0;
    std::optional<crn_wire_tick_input> last_input_;
    bool has_spoken_ = false; // since the last heartbeat was due
    crn_wire_rig rig_{};
    crn_wire_set_up set_up_{};
    crn_wire_sensors sensors_{};
    crn_wire_hello_reply hello_reply_{};
    crn_wire_status status_{};
    crn_wire_ticks ticks_{};
    crn_wire_nodes nodes_{};
    crn_wire_node_table node_table_{};
    crn_wire_contacts contacts_{};
    crn_wire_fault_log fault_log_{};
    std::optional<Hash64> hash64_;
    Hash64 received_hash64_; // last one, requested or not
    crn_wire_snapshot_begin snapshot_begin_{};
    std::vector<std::uint8_t> snapshot_;
};

// "the device refused scene_end: SCENE_CRC: the scene's CRC-32 differs ... [1, 2]. Remedy: upload again"
std::string describe(const crn_wire_reject &reject, const std::string &device = "the device");

} // namespace crn
