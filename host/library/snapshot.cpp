// Snapshots of worlds. All numbers are little-endian:
//
//   magic u32 | version u32 | bytes u32 | out of range: tick + 1, or 0, u32 | fingerprint u64 | check u64 |
//   hands i64 x 6 in 1e-6 counts | inflator i32 | bytes of the tick's result u32 | wall force of the last
//   sample and largest one of the last move f64 x 2 in N | result of the last tick, padded | the device's
//   snapshot (docs/wire.md) | with a patient: its fingerprint u64 | its part (Patient::archive)
//
// The patient's part of a snapshot has its own version, which depends on the byte order of the machine, so a
// snapshot with the other byte order is refused.
//
// Snapshots of version 1 lack the wall forces of the saved world, so they are refused. The checksum covers
// all bytes of the snapshot that follow it. The device also checks its own part of the snapshot.
#include "host/library/world.hpp"
#include "host/stent/design.hpp"
#include <algorithm>
#include <bit>

namespace crn::library
{

namespace
{

constexpr std::uint32_t magic = 0x534e5243; // "CRNS"
constexpr std::uint32_t version = 2;
constexpr std::size_t head_bytes = 32, hands_bytes = 6 * 8 + 4 + 4 + 2 * 8;
constexpr double wall_max_N = 1e9; // far above what a tool can press
constexpr std::size_t state_bytes = (CRN_WIRE_BYTES_tick_state + 7u) / 8u * 8u;
// Even in the longest session, the positions of the hands stay within the limit below; larger values could
// make sums overflow.
constexpr std::uint64_t parts_max = 4'000'000'000'000'000'000;
constexpr std::size_t device_at = head_bytes + hands_bytes + state_bytes;

std::uint64_t word(const std::uint8_t *bytes)
{
    std::uint64_t value;
    std::memcpy(&value, bytes, sizeof value);
    if constexpr (std::endian::native == std::endian::big) value = __builtin_bswap64(value);
    return value;
}

[[noreturn]] void refuse(const std::string &why)
{
    throw Refused(COURNAND_BAD_SNAPSHOT, "the snapshot " + why);
}

void mix(std::uint64_t &hash, std::uint64_t number)
{
    hash = std::rotl((hash ^ number) * 0x9e3779b97f4a7c15ull, 29);
}

// Returns a number that differs between two patients that cannot restore each other's parts of snapshots. The
// scene and the tools are part of the world's fingerprint.
std::uint64_t patient_fingerprint(std::span<const StentDesign> stents)
{
    std::uint64_t hash = stents.size();
    for (const StentDesign &stent : stents) {
        for (const StentNumber &number : stent_numbers())
            mix(hash, std::bit_cast<std::uint64_t>(stent.*number.value));
        for (const StentCount &count : stent_counts())
            mix(hash, static_cast<std::uint64_t>(stent.*count.value));
        mix(hash, static_cast<std::uint64_t>(stent.connection));
    }
    return hash;
}

std::size_t fixed_bytes()
{
    return device_at + SimTransport::snapshot_bytes();
}

} // namespace

// Four independent chains of multiplications keep the processor busy; a byte-by-byte checksum would take
// longer than the restoring of the snapshot.
std::uint64_t snapshot_check(std::span<const std::uint8_t> snapshot)
{
    constexpr std::uint64_t prime = 0x9e3779b97f4a7c15ull;
    const std::span<const std::uint8_t> bytes = snapshot.subspan(std::min(head_bytes, snapshot.size()));
    std::uint64_t lanes[4] = {1, 2, 3, 4};
    std::size_t at = 0;
    for (; at + 32 <= bytes.size(); at += 32)
        for (int i = 0; i < 4; i++) {
            const std::uint64_t mixed = (lanes[i] ^ word(bytes.data() + at + 8 * i)) * prime;
            lanes[i] = mixed ^ mixed >> 29;
        }
    std::uint64_t hash = bytes.size();
    for (; at < bytes.size(); at++) hash = (hash ^ bytes[at]) * prime;
    for (const std::uint64_t lane : lanes) hash = std::rotl((hash ^ lane) * prime, 31);
    return hash;
}

// The size of the patient's part depends on the history of the session, so the function saves the part to
// measure it.
std::size_t World::snapshot_bytes()
{
    require_may_be_saved();
    return fixed_bytes() + saved_patient().size();
}

void World::require_may_be_saved() const
{
    if (!may_be_saved_)
        throw Refused(COURNAND_BAD_STATE,
                      "the script is between two of its decisions: save the world at a tick "
                      "that is a multiple of 16, at a pulse, or at the end");
}

std::span<const std::uint8_t> World::saved_patient()
{
    patient_bytes_.clear();
    if (!patient_) return patient_bytes_;
    StateArchive archive = StateArchive::saving(patient_bytes_);
    std::uint64_t kind = patient_fingerprint(settings_.stents);
    archive.integer(kind);
    archive.flag(was_commanded_);
    patient_->archive(archive, tick(), state_);
    return patient_bytes_;
}

bool World::restore_patient(std::span<const std::uint8_t> bytes, std::uint32_t tick,
                            const crn_wire_tick_state &state)
{
    StateArchive archive = StateArchive::restoring(bytes);
    std::uint64_t kind = 0;
    archive.integer(kind);
    archive.flag(was_commanded_);
    patient_->archive(archive, tick, state);
    return !archive.is_refused() && archive.is_at_end();
}

// Restores the patient, and then calls work() to restore the rest of the world. If one of the two refuses its
// part of the snapshot, the patient returns to its present state.
template <class Work>
void World::with_patient(std::span<const std::uint8_t> bytes, std::uint32_t tick,
                         const crn_wire_tick_state &state, Work work)
{
    if (!patient_) return work();
    std::uint64_t kind = 0;
    StateArchive::restoring(bytes).integer(kind);
    if (kind != patient_fingerprint(settings_.stents)) refuse("is of a world with other stents");
    saved_patient();
    try {
        if (!restore_patient(bytes, tick, state)) refuse("is damaged: its patient is out of range");
        work();
    } catch (...) {
        if (!restore_patient(patient_bytes_, this->tick(), state_))
            stopped_ = "its patient could not be restored";
        throw;
    }
}

void World::save(std::span<std::uint8_t> bytes)
{
    require_may_be_saved();
    if (!orders_.is_empty())
        throw Refused(COURNAND_BAD_STATE, "an order waits for the next tick: advance the world first");
    const std::span<const std::uint8_t> patient = saved_patient();
    const std::size_t fixed = fixed_bytes(), count = fixed + patient.size();
    require(bytes.size() >= count, "the memory is smaller than cournand_world_snapshot_bytes()");
    bytes = bytes.first(count);
    if (!pipe_.take_snapshot(bytes.subspan(device_at, fixed - device_at)))
        throw Refused(COURNAND_INTERNAL, "the device gives no snapshot");
    std::copy(patient.begin(), patient.end(), bytes.begin() + static_cast<std::ptrdiff_t>(fixed));
    std::fill_n(bytes.begin(), device_at, std::uint8_t{0});
    crn_wire_writer hands = crn_wire_writer_make(bytes.data() + head_bytes, hands_bytes + state_bytes);
    for (std::size_t k = 0; k < COURNAND_POSITIONS_MAX; k++) {
        crn_wire_write(&hands, static_cast<std::uint64_t>(push_[k]), 8);
        crn_wire_write(&hands, static_cast<std::uint64_t>(turn_[k]), 8);
    }
    crn_wire_write(&hands, static_cast<std::uint32_t>(inflator_kPa_), 4);
    std::uint8_t state[CRN_WIRE_BYTES_tick_state];
    crn_wire_writer result = crn_wire_writer_make(state, sizeof state);
    crn_wire_put_tick_state(&result, &state_);
    crn_wire_write(&hands, result.length, 4);
    for (const double force_N : {wall_N_, wall_peak_N_})
        crn_wire_write(&hands, std::bit_cast<std::uint64_t>(force_N), 8);
    std::copy_n(state, result.length, bytes.data() + head_bytes + hands_bytes);
    crn_wire_writer head = crn_wire_writer_make(bytes.data(), head_bytes);
    crn_wire_write(&head, magic, 4);
    crn_wire_write(&head, version, 4);
    crn_wire_write(&head, count, 4);
    crn_wire_write(&head, out_of_range_tick_ ? *out_of_range_tick_ + 1u : 0u, 4);
    crn_wire_write(&head, fingerprint_, 8);
    crn_wire_write(&head, snapshot_check(bytes), 8);
}

void World::restore(std::span<const std::uint8_t> bytes)
{
    check_free();
    if (recorder_) throw Refused(COURNAND_BAD_STATE, "the world is being recorded: end its recording first");
    const std::size_t fixed = fixed_bytes();
    const auto refuse_size = [&] {
        refuse("has " + std::to_string(bytes.size()) + " bytes, not " + std::to_string(fixed) +
               (patient_ ? " and those of a patient" : ""));
    };
    if (bytes.size() < head_bytes) refuse_size();
    crn_wire_reader head = crn_wire_reader_make(bytes.data(), head_bytes);
    if (crn_wire_read(&head, 4) != magic) refuse("is none of this library");
    const std::uint64_t saved_version = crn_wire_read(&head, 4);
    if (saved_version != version)
        refuse("has version " + std::to_string(saved_version) + ", and this release reads version " +
               std::to_string(version) + ": save it with this release");
    if (patient_ ? bytes.size() < fixed : bytes.size() != fixed) refuse_size();
    if (patient_ && bytes.size() == fixed) refuse("is of a world without a patient");
    if (crn_wire_read(&head, 4) != bytes.size()) refuse("is damaged: its size differs");
    const auto range_tick = static_cast<std::uint32_t>(crn_wire_read(&head, 4));
    if (crn_wire_read(&head, 8) != fingerprint_)
        refuse("is of a world with another scene, other tools or options");
    if (crn_wire_read(&head, 8) != snapshot_check(bytes)) refuse("is damaged: its check differs");
    crn_wire_reader hands = crn_wire_reader_make(bytes.data() + head_bytes, hands_bytes);
    std::uint64_t counts[6];
    for (std::uint64_t &count : counts) {
        count = crn_wire_read(&hands, 8);
        if (count + parts_max > 2 * parts_max) refuse("is damaged: a hand is out of range"); // either sign
    }
    const auto inflator = static_cast<std::int32_t>(crn_wire_read(&hands, 4));
    const std::uint64_t result_bytes = crn_wire_read(&hands, 4);
    double walls_N[2];
    for (double &force_N : walls_N) {
        force_N = std::bit_cast<double>(crn_wire_read(&hands, 8));
        if (!(force_N >= 0.0 && force_N <= wall_max_N)) refuse("is damaged: a wall force is out of range");
    }
    crn_wire_tick_state state{};
    if (result_bytes > state_bytes || inflator < 0 || inflator > 4000)
        refuse("is damaged: a number is out of range");
    crn_wire_reader result = crn_wire_reader_make(bytes.data() + head_bytes + hands_bytes, result_bytes);
    if (!crn_wire_get_tick_state(&result, &state)) refuse("is damaged: its last result cannot be read");
    const std::span<const std::uint8_t> device = bytes.subspan(device_at, fixed - device_at);
    crn_wire_reader reader = crn_wire_reader_make(device.data() + 4, 4); // behind the version
    const auto tick = static_cast<std::uint32_t>(crn_wire_read(&reader, 4));
    with_patient(bytes.subspan(fixed), tick, state, [&] { put_device(device, tick); });
    // From here on nothing fails.
    replayed_.reset(); // a replay looks for its next command again
    for (std::size_t k = 0; k < COURNAND_POSITIONS_MAX; k++) {
        push_[k] = static_cast<std::int64_t>(counts[2 * k]);
        turn_[k] = static_cast<std::int64_t>(counts[2 * k + 1]);
    }
    inflator_kPa_ = inflator;
    state_ = state;
    orders_.clear();
    range_ = {};
    out_of_range_tick_.reset();
    if (range_tick != 0) out_of_range_tick_ = range_tick - 1;
    const bool samples_wall = settings_.contact_ticks > 0;
    wall_N_ = samples_wall ? walls_N[0] : 0.0;
    wall_peak_N_ = samples_wall ? walls_N[1] : 0.0;
}

} // namespace crn::library
