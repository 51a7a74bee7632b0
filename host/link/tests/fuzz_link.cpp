// Fuzz target: the host's side of the byte protocol, with a device that may send anything. The input is a
// list of the host's requests, each followed by the device's messages:
//
//   call u8 modulo 21, then answers until the call ends:
//     0     silence: the call under way fails
//     1     raw bytes: length u8, bytes
//     2     the expected message: length u8, payload
//     3     the expected message with the last byte repeated: length u16, times u8
//     4     any type, answering another frame: type u8, back u8, length u8, payload
//     5     raw bytes as 1, then the answer as 2
//     6 ..  an unasked message of type u8: length u8, payload
//
// Whatever a device sends, each call ends with a result or with a LinkError that has a text, and the host's
// counters remain consistent.
#include "host/link/link.hpp"
#include <algorithm>
#include <cstdlib>
#include <cstring>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *bytes, std::size_t count);
extern "C" std::size_t fuzz_seed(unsigned index, std::uint8_t *bytes, std::size_t capacity);

namespace
{

constexpr int calls_max = 16;

void promise(bool kept)
{
    if (!kept) std::abort();
}

class Input
{
  public:
    Input(const std::uint8_t *bytes, std::size_t count) : bytes_(bytes), left_(count) {}
    bool is_empty() const { return left_ == 0; }
    std::uint8_t take()
    {
        if (left_ == 0) return 0;
        left_--;
        return *bytes_++;
    }
    std::span<const std::uint8_t> block(std::size_t count)
    {
        count = std::min(count, left_);
        const std::span<const std::uint8_t> taken(bytes_, count);
        bytes_ += count;
        left_ -= count;
        return taken;
    }

  private:
    const std::uint8_t *bytes_;
    std::size_t left_;
};

// Returns the type of the answer that a host expects to a request whose type is `type`.
std::uint16_t answer_of(std::uint16_t type, std::uint8_t what)
{
    static constexpr std::uint16_t gets[] = {0,
                                             CRN_WIRE_TYPE_status,
                                             CRN_WIRE_TYPE_nodes,
                                             CRN_WIRE_TYPE_node_table,
                                             CRN_WIRE_TYPE_hash64,
                                             CRN_WIRE_TYPE_snapshot_end,
                                             CRN_WIRE_TYPE_fault_log,
                                             CRN_WIRE_TYPE_contacts,
                                             CRN_WIRE_TYPE_rig,
                                             CRN_WIRE_TYPE_set_up,
                                             CRN_WIRE_TYPE_sensors};
    if (type == CRN_WIRE_TYPE_hello) return CRN_WIRE_TYPE_hello_reply;
    if (type == CRN_WIRE_TYPE_step) return CRN_WIRE_TYPE_ticks;
    if (type == CRN_WIRE_TYPE_get && what < std::size(gets)) return gets[what];
    return CRN_WIRE_TYPE_status;
}

class FuzzedDevice final : public crn::Transport
{
  public:
    explicit FuzzedDevice(Input &in) : in_(in) {}

    // The host's frames are valid. The first bytes of a request's frame, after decoding from COBS, show which
    // answer the host expects.
    void write(std::span<const std::uint8_t> bytes) override
    {
        std::uint8_t body[9] = {};
        std::size_t place = 0, code = bytes[0];
        for (std::size_t i = 1; i < bytes.size() && place < sizeof body; i++, place++) {
            body[place] = --code > 0 ? bytes[i] : std::uint8_t{0};
            if (code == 0) code = bytes[i];
        }
        if (place < sizeof body) return; // the zero before a HELLO
        asked_ = static_cast<std::uint16_t>(body[0] | body[1] << 8);
        answer_ = answer_of(static_cast<std::uint16_t>(body[4] | body[5] << 8), body[8]);
    }

    std::size_t read(std::span<std::uint8_t> bytes) override
    {
        ready_.clear();
        if (!in_.is_empty()) say(in_.take());
        promise(ready_.size() <= bytes.size());
        std::copy(ready_.begin(), ready_.end(), bytes.begin());
        return ready_.size();
    }

    void pass_time_ms(std::uint32_t) override {}

  private:
    void say(std::uint8_t how)
    {
        if (how == 0) return;
        if (how == 1 || how == 5) raw(in_.block(in_.take()));
        if (how == 2 || how == 5) frame(answer_, asked_, in_.block(in_.take()));
        if (how == 3) {
            const auto low = in_.take(), high = in_.take(), times = in_.take();
            const auto begin = in_.block(low | (high % 8) << 8);
            std::vector<std::uint8_t> payload(begin.begin(), begin.end());
            payload.resize(payload.size() + 8u * times, payload.empty() ? 0 : payload.back());
            frame(answer_, asked_, payload);
        }
        if (how == 4) {
            const std::uint8_t type = in_.take(), back = in_.take();
            frame(type, static_cast<std::uint16_t>(asked_ - back), in_.block(in_.take()));
        }
        if (how >= 6) frame(in_.take(), 0, in_.block(in_.take()));
    }

    void raw(std::span<const std::uint8_t> bytes) { ready_.insert(ready_.end(), bytes.begin(), bytes.end()); }

    void frame(std::uint16_t type, std::uint16_t answers, std::span<const std::uint8_t> payload)
    {
        static std::uint8_t bytes[CRN_WIRE_FRAME_MAX];
        const crn_wire_header header = {++sequence_, answers, type};
        const std::size_t size = crn_wire_frame_encode(
            &header, payload.data(), std::min<std::size_t>(payload.size(), CRN_WIRE_PAYLOAD_MAX), bytes,
            sizeof bytes);
        raw({bytes, size});
    }

    Input &in_;
    std::vector<std::uint8_t> ready_;
    std::uint16_t sequence_ = 0, asked_ = 0, answer_ = 0;
};

void call(crn::Link &link, std::uint8_t which)
{
    static const std::vector<std::uint8_t> scene(1100, 7), snapshot(1100, 9);
    static const crn_wire_instrument tool{};
    static const crn_wire_tick_input inputs[3] = {};
    if (which % 21 == 20)
        return link.give_orders({1, {crn_wire_order_of_rhythm({CRN_WIRE_RHYTHM_HEART_RATE, 80})}});
    switch (which % 21) {
    case 0:
        promise(link.hello().accepted != 0);
        break;
    case 1:
        link.load_scene(scene);
        break;
    case 2:
        link.load_tools({&tool, 1});
        break;
    case 3:
        link.set_entry({});
        break;
    case 4:
        link.set_rig({});
        break;
    case 5:
        link.arm();
        break;
    case 6:
        link.start();
        break;
    case 7:
        promise(link.step(inputs, true).size() == 3);
        break;
    case 8:
        link.free_run(25);
        break;
    case 9:
        link.stop();
        break;
    case 10:
        link.read_snapshot();
        break;
    case 11:
        link.write_snapshot(snapshot);
        break;
    case 12:
        link.read_fault_log();
        break;
    case 13:
        link.read_contacts();
        break;
    case 14:
        link.read_nodes();
        break;
    case 15:
        link.read_hash64();
        break;
    case 16:
        link.arm_motors();
        break;
    case 17:
        link.read_sensors();
        break;
    case 18:
        link.read_set_up();
        break;
    default:
        link.read_rig();
        break;
    }
}

void check_books(crn::Link &link)
{
    promise(link.nodes().positions_count <= CRN_WIRE_MAX_nodes_positions);
    promise(link.node_table().arcs_m_q30_count <= CRN_WIRE_MAX_node_table_arcs_m_q30);
    promise(link.take_notices().size() <= crn::Link::notices_max);
    promise(link.live_ticks().size() <= crn::Link::live_ticks_max);
    for (const crn_wire_live_tick &live : link.live_ticks())
        promise(live.state.tools_count <= CRN_WIRE_TOOL_MAX);
}

// --- seeds: a session that succeeds, and some that fail ---

class Script
{
  public:
    Script &ask(std::uint8_t which)
    {
        bytes.push_back(which);
        return *this;
    }
    template <class Message, class Put> Script &answer(const Message &message, Put put, std::uint8_t type = 0)
    {
        std::uint8_t payload[CRN_WIRE_PAYLOAD_MAX];
        crn_wire_writer writer = crn_wire_writer_make(payload, sizeof payload);
        promise(put(&writer, &message));
        if (type != 0) {
            bytes.insert(bytes.end(), {6, type, static_cast<std::uint8_t>(writer.length)});
        } else {
            bytes.insert(bytes.end(), {3, static_cast<std::uint8_t>(writer.length),
                                       static_cast<std::uint8_t>(writer.length >> 8), 0});
        }
        bytes.insert(bytes.end(), payload, payload + writer.length);
        return *this;
    }
    Script &status(std::uint8_t state, std::uint32_t tick)
    {
        crn_wire_status status{};
        status.state = state;
        status.tick = tick;
        status.arm_code = 77;
        return answer(status, crn_wire_put_status);
    }
    Script &hello()
    {
        crn_wire_hello_reply reply{};
        reply.accepted = 1;
        reply.snapshot_bytes = 40000;
        return ask(0).answer(reply, crn_wire_put_hello_reply);
    }
    std::vector<std::uint8_t> bytes;
};

crn_wire_tick_state tick_state(std::uint32_t tick)
{
    crn_wire_tick_state state{};
    state.tick = tick;
    state.tools_count = 1;
    return state;
}

Script lockstep()
{
    Script script;
    crn_wire_node_table table{};
    table.arcs_m_q30_count = 3;
    crn_wire_ticks ticks{};
    ticks.states_count = 3;
    for (std::uint32_t i = 0; i < 3; i++) ticks.states[i] = tick_state(i + 1);
    script.hello().ask(1).answer(crn_wire_set_up{}, crn_wire_put_set_up).status(1, 0).status(1, 0);
    script.ask(2).status(1, 0).ask(3).status(1, 0).ask(4).status(1, 0);
    script.ask(5).status(2, 0).answer(table, crn_wire_put_node_table).ask(6).status(3, 0);
    script.ask(7).answer(ticks, crn_wire_put_ticks).ask(9).status(2, 3);
    return script;
}

Script free_run()
{
    Script script;
    crn_wire_live live{};
    live.ticks_count = 2;
    live.ticks[0].state = tick_state(1);
    live.ticks[1].state = tick_state(2);
    crn_wire_notice notice{};
    notice.number = 1;
    script.hello().ask(16).status(2, 0).status(2, 0).ask(6).status(3, 0).ask(20).status(3, 0).ask(8);
    script.answer(live, crn_wire_put_live, CRN_WIRE_TYPE_live);
    script.answer(notice, crn_wire_put_notice, CRN_WIRE_TYPE_notice);
    script.answer(live, crn_wire_put_live, CRN_WIRE_TYPE_live);
    return script;
}

Script reading()
{
    Script script;
    crn_wire_snapshot_chunk chunk{};
    chunk.data_count = 20;
    const crn_wire_snapshot_begin begin = {5, 20, crn_wire_crc32(0, chunk.data, 20)};
    script.hello().ask(10).answer(begin, crn_wire_put_snapshot_begin, CRN_WIRE_TYPE_snapshot_begin);
    script.answer(chunk, crn_wire_put_snapshot_chunk, CRN_WIRE_TYPE_snapshot_chunk);
    script.answer(crn_wire_snapshot_end{20}, crn_wire_put_snapshot_end);
    script.ask(11).status(2, 0).status(2, 5).ask(12).answer(crn_wire_fault_log{}, crn_wire_put_fault_log);
    script.ask(13).answer(crn_wire_contacts{}, crn_wire_put_contacts);
    script.ask(14).answer(crn_wire_nodes{}, crn_wire_put_nodes);
    script.ask(15).answer(crn_wire_hash64{5, 6}, crn_wire_put_hash64);
    script.ask(17).answer(crn_wire_sensors{}, crn_wire_put_sensors);
    script.ask(19).answer(crn_wire_rig{}, crn_wire_put_rig);
    return script;
}

Script refused()
{
    Script script;
    script.hello().ask(6);
    script.answer(crn_wire_reject{CRN_WIRE_TYPE_command, CRN_REJECT_WRONG_STATE, 1, 2}, crn_wire_put_reject,
                  CRN_WIRE_TYPE_reject);
    script.bytes.insert(script.bytes.end(),
                        {4, CRN_WIRE_TYPE_reject, 0, 12, 0x16, 0, 4, 0, 1, 0, 0, 0, 2, 0, 0, 0});
    script.bytes.insert(script.bytes.end(), {0, 1, 5, 9, 1, 2, 3, 0});
    return script;
}

} // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t *bytes, std::size_t count)
{
    Input in(bytes, count);
    FuzzedDevice device(in);
    crn::Link link(device);
    for (int i = 0; i < calls_max && !in.is_empty(); i++) {
        try {
            call(link, in.take());
        } catch (const crn::LinkError &error) {
            promise(*error.what() != '\0');
        }
        check_books(link);
    }
    return 0;
}

std::size_t fuzz_seed(unsigned index, std::uint8_t *bytes, std::size_t capacity)
{
    static Script (*const scripts[])() = {lockstep, free_run, reading, refused};
    if (index >= std::size(scripts)) return 0;
    const Script script = scripts[index]();
    promise(script.bytes.size() <= capacity);
    std::copy(script.bytes.begin(), script.bytes.end(), bytes);
    return script.bytes.size();
}
