// This fuzz target calls the C library in random order with random arguments: valid, freed, foreign and null
// handles, numbers of every size, and structs of wrong sizes. It also restores damaged snapshots, some of
// them with a correct checksum, and some of them from worlds with a patient. No call may crash, every refusal
// must have a text, and a refused call must not change the state hash of its world. The sanitizers watch the
// memory.
#include "host/library/tests/seal.hpp"
// After cournand.h:
#include "host/library/cournand_play.h"
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *bytes, std::size_t count);
extern "C" std::size_t fuzz_seed(unsigned index, std::uint8_t *bytes, std::size_t capacity);

namespace
{

constexpr std::uint32_t ticks_max = 160; // of one input: a tick takes long under the sanitizers
constexpr std::size_t worlds_max = 4, calls_max = 64;
constexpr std::uint8_t plays_from = 240; // of the bytes that choose a call

void promise(bool kept)
{
    if (!kept) std::abort();
}

// Returns the bytes of the fuzz input as numbers; after the end of the input, the numbers are zero.
class Bytes
{
  public:
    Bytes(const std::uint8_t *bytes, std::size_t count) : bytes_(bytes), left_(count) {}
    bool is_empty() const { return left_ == 0; }
    std::uint8_t one()
    {
        if (left_ == 0) return 0;
        left_--;
        return *bytes_++;
    }
    template <class Number> Number number()
    {
        std::uint8_t raw[sizeof(Number)];
        for (std::uint8_t &byte : raw) byte = one();
        Number value;
        std::memcpy(&value, raw, sizeof value);
        return value;
    }
    // Returns the usual value in three of four cases, and any bit pattern (infinite, not a number, or huge)
    // in the fourth case.
    template <class Number> Number near(Number usual) { return one() % 4 != 0 ? usual : number<Number>(); }
    std::uint32_t size_of(std::size_t right)
    {
        return one() % 8 != 0 ? static_cast<std::uint32_t>(right) : number<std::uint32_t>();
    }

  private:
    const std::uint8_t *bytes_;
    std::size_t left_;
};

struct Shared {
    cournand_scene *scene = nullptr;
    cournand_tool *tools[3] = {};
    cournand_script *script = nullptr;
    Shared()
    {
        const char *const names[] = {"shared/examples/instruments/coronary_014.toml",
                                     "shared/examples/instruments/balloon_3x20.toml",
                                     "shared/examples/instruments/guide_jl4_6f.toml"};
        promise(cournand_scene_open(nullptr, nullptr, &scene) == COURNAND_OK);
        for (int i = 0; i < 3; i++) promise(cournand_tool_open(names[i], &tools[i]) == COURNAND_OK);
        promise(cournand_script_open("shared/examples/sessions/free_space.session", "novice:1", &script) ==
                COURNAND_OK);
    }
};

class Caller
{
  public:
    Caller(const std::uint8_t *bytes, std::size_t count) : in_(bytes, count) {}
    ~Caller()
    {
        for (cournand_world *world : worlds_) cournand_world_free(world);
        cournand_play_free(play_);
        cournand_renderer_free(renderer_);
        cournand_pool_free(pool_);
    }
    void run()
    {
        for (std::size_t i = 0; i < calls_max && !in_.is_empty(); i++) call();
    }

  private:
    static const Shared &shared()
    {
        static const Shared kept;
        return kept;
    }
    void answer(cournand_status status)
    {
        if (status >= COURNAND_INTERNAL) std::fprintf(stderr, "%s\n", cournand_error_text());
        promise(status >= COURNAND_OK && status < COURNAND_INTERNAL);
        promise(status == COURNAND_OK || *cournand_error_text() != '\0');
        promise(std::strcmp(cournand_status_name(status), "UNKNOWN") != 0);
    }
    // Returns a world that this fuzz input has made (valid or freed), or a handle that is not a world.
    cournand_world *world()
    {
        const std::uint8_t which = in_.one();
        if (which == 255) return nullptr;
        if (which == 254) return reinterpret_cast<cournand_world *>(shared().scene);
        if (which == 253) return reinterpret_cast<cournand_world *>(in_.number<std::uintptr_t>());
        return worlds_.empty() ? nullptr : worlds_[which % worlds_.size()];
    }
    std::uint32_t ticks()
    {
        const std::uint32_t wanted = in_.near<std::uint32_t>(1u + in_.one() % 20u);
        if (wanted > COURNAND_TICKS_MAX) return wanted; // is refused
        const std::uint32_t given = std::min(wanted, ticks_left_);
        ticks_left_ -= given;
        return given;
    }
    void call();
    void create();
    void move();
    void advance();
    void order();
    void restore();
    void read();
    void render();
    void share();
    void patient();
    void play();
    // Makes a call that may change the world only if the call succeeds.
    template <class Call> void change(cournand_world *world, Call call)
    {
        std::uint64_t before = 0, after = 0;
        const bool is_known = cournand_world_hash(world, &before) == COURNAND_OK;
        const cournand_status status = call();
        answer(status);
        if (status == COURNAND_OK || !is_known) return;
        promise(cournand_world_hash(world, &after) == COURNAND_OK && before == after);
    }

    Bytes in_;
    std::uint32_t ticks_left_ = ticks_max;
    std::vector<cournand_world *> worlds_; // also freed ones
    std::vector<std::uint8_t> snapshot_;
    cournand_renderer *renderer_ = nullptr;
    cournand_pool *pool_ = nullptr;
    cournand_play *play_ = nullptr; // also a freed one
};

void Caller::call()
{
    const std::uint8_t kind = in_.one();
    if (kind >= plays_from) return play();
    switch (kind % 12) {
    case 0:
        return create();
    case 1:
        return answer(cournand_world_free(world()));
    case 2:
    case 3:
        return move();
    case 4:
        return advance();
    case 5:
        return order();
    case 6:
    case 7:
        return restore();
    case 8:
        return read();
    case 9:
        return render();
    case 10:
        return share();
    default:
        return patient();
    }
}

void Caller::create()
{
    if (worlds_.size() >= worlds_max) return;
    cournand_world_options options{};
    options.struct_bytes = in_.size_of(sizeof options);
    if (options.struct_bytes > sizeof options) options.struct_bytes = UINT32_MAX; // the memory ends here
    options.flags = in_.near<std::uint32_t>(in_.one() % 4 == 0 ? COURNAND_WITH_PATIENT : 0);
    options.line_count = in_.near<std::uint32_t>(in_.one() % 4);
    for (std::uint32_t &number : options.line) number = in_.one() % 5;
    options.inserted_count = in_.near<std::uint32_t>(3);
    for (float &length_m : options.inserted_m) length_m = in_.near<float>(0.05f);
    options.contact_ticks = in_.one();
    const char *const stents[] = {"shared/examples/stents/coronary_3_0x18.toml", nullptr};
    options.stents = in_.one() % 8 ? stents : nullptr;
    options.stent_count = in_.near<std::uint32_t>(options.flags == COURNAND_WITH_PATIENT ? 1 : 0);
    cournand_tool *tools[COURNAND_TOOLS_MAX];
    for (std::size_t i = 0; i < COURNAND_TOOLS_MAX; i++) tools[i] = shared().tools[i % 3];
    if (in_.one() % 8 == 0) tools[in_.one() % 3] = nullptr;
    cournand_world *made = nullptr;
    const std::size_t count = in_.near<std::size_t>(1u + in_.one() % 3u);
    answer(cournand_world_create(shared().scene, tools, count, in_.one() % 4 ? &options : nullptr, &made));
    if (made) worlds_.push_back(made);
}

void Caller::move()
{
    float action[COURNAND_ACTION_FLOATS] = {};
    for (int i = 0; i < 3; i++) action[i] = in_.one() % 2 ? in_.near<float>(0.001f * in_.one()) : 0.0f;
    for (int i = 3; i < 6; i++) action[i] = in_.one() % 2 ? in_.near<float>(0.1f * in_.one()) : 0.0f;
    action[6] = in_.near<float>(10.0f * in_.one());
    cournand_world *moved = world();
    change(moved, [&] { return cournand_world_move(moved, in_.one() ? action : nullptr, ticks()); });
}

void Caller::advance()
{
    std::vector<cournand_input> inputs(std::min<std::uint32_t>(ticks(), ticks_max));
    for (cournand_input &input : inputs) {
        input.push_um[0] = in_.near<std::int32_t>(40 * in_.one());
        input.turn_counts[0] = in_.near<std::int32_t>(in_.one());
        input.inflator_kPa = in_.near<std::int32_t>(in_.one());
        input.buttons = in_.one() % 16 ? 0 : in_.number<std::uint32_t>();
        input.order_count = in_.one() % 8 ? 0 : in_.one();
        for (cournand_order &one : input.orders) one = {in_.one() % 6u, {in_.one() % 8, in_.one()}};
    }
    cournand_world *advanced = world();
    change(advanced, [&] { return cournand_world_advance(advanced, inputs.data(), inputs.size()); });
}

void Caller::order()
{
    cournand_order given = {in_.near<std::uint32_t>(1u + in_.one() % 4u), {}};
    for (std::int32_t &value : given.values)
        value = in_.one() % 2 ? in_.near<std::int32_t>(in_.one() % 9) : 0;
    cournand_world *ordered = world();
    change(ordered, [&] { return cournand_world_order(ordered, in_.one() ? &given : nullptr); });
}

void Caller::restore()
{
    cournand_world *restored = world();
    std::size_t bytes = 0;
    const bool saves = snapshot_.empty() || in_.one() % 4 == 0; // sometimes another one
    if (saves && cournand_world_snapshot_bytes(restored, &bytes) == COURNAND_OK) {
        std::vector<std::uint8_t> saved(in_.near<std::uint8_t>(0) == 0 ? bytes : in_.one());
        const cournand_status status = cournand_world_save(restored, saved.data(), saved.size());
        answer(saved.empty() && status == COURNAND_OK ? COURNAND_INTERNAL : status);
        if (status == COURNAND_OK) snapshot_ = std::move(saved);
        return;
    }
    std::vector<std::uint8_t> offered = snapshot_;
    for (std::uint8_t changes = in_.one() % 4; changes > 0 && !offered.empty(); changes--)
        offered[in_.number<std::uint32_t>() % offered.size()] = in_.one();
    if (in_.one() % 8 == 0) offered.resize(in_.number<std::uint16_t>());
    if (in_.one() % 2 == 0) crn::tests::seal(offered);
    change(restored, [&] { return cournand_world_restore(restored, offered.data(), offered.size()); });
}

void Caller::read()
{
    cournand_world *from = world();
    cournand_pose pose{};
    pose.struct_bytes = in_.size_of(sizeof pose) <= sizeof pose ? sizeof pose : 0;
    answer(cournand_world_pose(from, &pose));
    float sum = 0.0f; // the sanitizers see a view that ends too early
    for (std::uint32_t i = 0; i < pose.node_count; i++)
        sum += pose.positions_m[3 * i + 2] + pose.arcs_m[i] + pose.radii_m[i] + pose.positions_q30[3 * i + 2];
    for (std::uint32_t k = 0; k < pose.position_count; k++) sum += pose.tip_arcs_m[k] + pose.inserted_m[k];
    cournand_reading reading{};
    reading.struct_bytes = sizeof reading;
    answer(cournand_world_read(from, &reading));
    cournand_contacts contacts{};
    contacts.struct_bytes = sizeof contacts;
    answer(cournand_world_contacts(from, &contacts));
    for (std::uint32_t i = 0; i < contacts.count; i++)
        sum += contacts.forces_N[3 * i + 2] + contacts.nodes[i];
    cournand_place place{};
    place.struct_bytes = sizeof place;
    answer(cournand_world_tip(from, in_.near<std::uint32_t>(in_.one() % 4), &place));
    cournand_fault faults[4];
    std::size_t count = 0;
    answer(cournand_world_faults(from, faults, in_.one() % 5, &count));
    promise(cournand_world_error_text(from) != nullptr && !(sum > 1e30f));
}

void Caller::render()
{
    if (!renderer_) answer(cournand_renderer_create(shared().scene, 1, &renderer_));
    cournand_view view{};
    view.struct_bytes = in_.size_of(sizeof view) <= sizeof view ? sizeof view : 0;
    view.flags = in_.near<std::uint32_t>(in_.one() % 32);
    view.primary_deg = in_.near<double>(in_.one() - 120);
    view.secondary_deg = in_.near<double>(in_.one() % 50);
    for (double &place : view.isocentre_m) place = in_.near<double>(0.001 * in_.one());
    view.dose_nGy = in_.near<double>(in_.one());
    view.size = in_.one() % 8 == 0 ? in_.one() : 64;
    cournand_picture picture{};
    picture.struct_bytes = sizeof picture;
    answer(cournand_render(renderer_, world(), &view, &picture));
    std::size_t sum = 0;
    for (std::size_t i = 0; i < std::size_t{picture.size} * picture.size; i++)
        sum += (picture.grey ? picture.grey[i] + picture.raw[i] : 0u) +
               (picture.labels ? picture.labels[i] : 0u);
    double matrix[12];
    answer(cournand_view_matrix(&view, matrix));
    promise(sum < SIZE_MAX);
}

void Caller::share()
{
    if (!pool_) answer(cournand_pool_create(2, &pool_));
    cournand_world *worlds[] = {world(), world()};
    const float actions[2 * COURNAND_ACTION_FLOATS] = {in_.near<float>(0.01f)};
    std::int32_t statuses[2];
    const std::uint32_t each = ticks();
    const std::size_t count = in_.one() % 3;
    cournand_pool *const by = in_.one() ? pool_ : nullptr;
    if (in_.one() % 2 == 0) return answer(cournand_pool_move(by, worlds, count, actions, each, statuses));
    const auto hashes = [](void *context, std::size_t i) {
        std::uint64_t hash = 0;
        cournand_world_hash(static_cast<cournand_world **>(context)[i], &hash);
    };
    answer(cournand_pool_step(by, worlds, count, actions, each, hashes, worlds, statuses));
}

void Caller::patient()
{
    cournand_world *treated = world();
    const double volume_ml = in_.near<double>(in_.one()), flow_ml_per_s = in_.near<double>(in_.one());
    const std::int32_t position = in_.near<std::int32_t>(in_.one() % 4 - 1);
    answer(cournand_world_inject(treated, volume_ml, flow_ml_per_s, position, in_.near<double>(300.0)));
    answer(cournand_world_load_stent(treated));
    cournand_patient_reading reading{};
    reading.struct_bytes = sizeof reading;
    answer(cournand_world_read_patient(treated, &reading));
    answer(cournand_world_record(treated, "/nowhere/x.rec", "fuzz"));
    answer(cournand_world_end_recording(treated));
}

// Begins or continues a play; its world becomes one of the worlds that the other calls use.
void Caller::play()
{
    auto *const tools = const_cast<cournand_tool **>(shared().tools);
    cournand_play_options options{};
    options.struct_bytes = in_.size_of(sizeof options) <= sizeof options ? sizeof options : 0;
    const char *const stents[] = {"shared/examples/stents/coronary_3_0x18.toml", nullptr};
    options.stents = in_.one() % 8 ? stents : nullptr;
    options.stent_count = in_.near<std::uint32_t>(0);
    if (!play_) {
        const std::size_t count = in_.near<std::size_t>(1u + in_.one() % 3u);
        answer(cournand_play_create(in_.one() % 8 ? shared().script : nullptr, shared().scene, tools, count,
                                    in_.one() % 2 ? &options : nullptr, &play_));
    }
    answer(cournand_play_advance(play_, ticks(), in_.near<std::uint32_t>(COURNAND_PLAY_TO_PULSE)));
    cournand_play_state state{};
    state.struct_bytes = in_.size_of(sizeof state) <= sizeof state ? sizeof state : 0;
    answer(cournand_play_read(play_, &state));
    cournand_view view{};
    view.struct_bytes = sizeof view;
    answer(cournand_play_view(play_, &view));
    const char *json = nullptr;
    answer(cournand_play_report(play_, &json));
    promise(json == nullptr || *json == '{');
    cournand_world *world = nullptr;
    if (worlds_.size() < worlds_max)
        answer(in_.one() % 2 ? cournand_play_world(play_, &world) : cournand_play_new_world(play_, &world));
    if (world) worlds_.push_back(world);
    if (in_.one() % 8 == 0) answer(cournand_play_free(play_)); // its handle stays here
}

} // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t *bytes, std::size_t count)
{
    Caller(bytes, count).run();
    return 0;
}

// Each of the first seed inputs makes a world and repeats one kind of call. The last seed inputs make a world
// with a patient and a stent, save it, inflate its balloon, and restore the snapshot with a changed byte and
// a correct checksum.
std::size_t fuzz_seed(unsigned index, std::uint8_t *bytes, std::size_t capacity)
{
    constexpr unsigned kinds = 13, patients = 8;
    if (index >= kinds + patients || capacity < 256) return 0;
    if (index < kinds) {
        for (std::size_t i = 0; i < 256; i++)
            bytes[i] = static_cast<std::uint8_t>(i % 48 < 40 ? 1 + i % 3 : index < 12 ? index : plays_from);
        bytes[0] = 0;
        return 256;
    }
    // The comments name the values that a call takes from the input; see the functions of Caller.
    std::vector<std::uint8_t> made = {0, 1, 0, 1, 0, 1, 0,
                                      0, 0, 1, 1, 1, 1, 0};               // create: a patient, all tools
    made.insert(made.end(), {1, 1, 1, 2, 1, 1});                          // a stent, three tools
    const std::vector<std::uint8_t> treat = {11, 0, 5, 1, 2, 1, 0, 1, 1}; // inject, load the stent
    const std::vector<std::uint8_t> inflate = {2, 0, 0, 0, 0, 0, 0, 90, 1, 0, 1, 15, 1}, save = {6, 0, 1};
    const auto byte = static_cast<std::uint8_t>(37 * index);
    const std::vector<std::uint8_t> restore = {6, 0, 1, 1, byte, byte, byte, 0, 0, 1, 0};
    for (const auto &part :
         {treat, inflate, save, inflate, inflate, restore, inflate, restore, inflate, restore})
        made.insert(made.end(), part.begin(), part.end());
    std::copy(made.begin(), made.end(), bytes);
    return made.size();
}
