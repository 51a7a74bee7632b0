// Tests the snapshots of worlds with a patient. A restored world must continue bit for bit, with contrast
// medium, stents, balloon, pressures, heart rhythm and the X-ray room of a replay. A damaged snapshot must
// change nothing.
#include <algorithm>
#include <chrono>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "host/library/tests/worlds.hpp"
#include "host/patient/patient.hpp"
#include "host/session/run.hpp"
#include "host/session/set_up.hpp"

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

namespace
{

using namespace crn::tests;

cournand_world *treated(cournand_scene *scene, const std::vector<std::string> &tools,
                        const std::vector<std::string> &names = {}, float inserted_m = -1.0f)
{
    std::vector<std::string> paths;
    for (const std::string &name : names) paths.push_back(stents + name + ".toml");
    std::vector<const char *> given;
    for (const std::string &path : paths) given.push_back(path.c_str());
    auto options = sized<cournand_world_options>();
    options.flags = COURNAND_WITH_PATIENT;
    options.stents = given.data();
    options.stent_count = static_cast<std::uint32_t>(given.size());
    if (inserted_m >= 0.0f) options.inserted_count = static_cast<std::uint32_t>(tools.size());
    for (float &length_m : options.inserted_m) length_m = inserted_m;
    return world(scene, tools, &options);
}

// Pushes the innermost tool while the balloon has a pressure.
void move(cournand_world *world, std::uint32_t ticks, float push_m_per_s, float kPa = 0.0f)
{
    const float action[COURNAND_ACTION_FLOATS] = {push_m_per_s, 0, 0, 0.5f, 0, 0, kPa};
    done(cournand_world_move(world, action, ticks));
}

// Holds everything that a caller can read from a world with a patient: the hash, the patient's values, and a
// picture.
struct Seen {
    std::uint64_t hash = 0;
    double injected_ml = 0, flow = 0, pressure = 0, rate = 0;
    std::string stage, notice;
    std::vector<std::uint16_t> raw;
    std::vector<std::uint8_t> labels;
    bool operator==(const Seen &) const = default;
    std::size_t pixels_with(std::uint8_t bit) const
    {
        return static_cast<std::size_t>(
            std::count_if(labels.begin(), labels.end(), [&](std::uint8_t one) { return (one & bit) != 0; }));
    }
};

Seen seen(cournand_world *world, cournand_scene *scene)
{
    cournand_renderer *renderer = nullptr;
    done(cournand_renderer_create(scene, 1, &renderer));
    auto view = sized<cournand_view>();
    const cournand_pose shape = pose(world);
    for (int axis = 0; axis < 3; axis++) view.isocentre_m[axis] = shape.positions_m[axis];
    view.flags = COURNAND_VIEW_LABELS;
    view.field_m = 0.15;
    view.size = 256;
    auto picture = sized<cournand_picture>();
    done(cournand_render(renderer, world, &view, &picture));
    auto read = sized<cournand_patient_reading>();
    done(cournand_world_read_patient(world, &read));
    Seen seen{hash(world),
              read.injected_ml,
              read.injection_flow_ml_per_s,
              read.pressure_mmHg,
              read.heart_rate_per_min,
              read.stent_stage,
              read.notice,
              {},
              {}};
    seen.raw.assign(picture.raw, picture.raw + 256 * 256);
    seen.labels.assign(picture.labels, picture.labels + 256 * 256);
    done(cournand_renderer_free(renderer));
    return seen;
}

void restore(cournand_world *world, const std::vector<std::uint8_t> &bytes)
{
    done(cournand_world_restore(world, bytes.data(), bytes.size()));
}

// The test pushes a catheter to the aorta and injects medium: the medium flows, and the pressure at the
// catheter's tip is measured.
cournand_world *injected()
{
    cournand_world *made = treated(aorta(), {"terumo_5f"});
    move(made, 911, 0.06f);
    done(cournand_world_inject(made, 8.0, 6.0, -1, 300.0));
    const cournand_order rate = {COURNAND_ORDER_RHYTHM, {1, 95}};
    done(cournand_world_order(made, &rate));
    move(made, 417, 0.02f);
    return made;
}

void medium_and_pressure_continue_bit_for_bit(void **)
{
    cournand_world *first = injected(), *other = treated(aorta(), {"terumo_5f"});
    const std::vector<std::uint8_t> bytes = saved(first);
    const Seen then = seen(first, aorta());
    print_message("%zu bytes, %zu pixels with medium, %.1f mmHg\n", bytes.size(),
                  then.pixels_with(COURNAND_LABEL_MEDIUM), then.pressure);
    assert_true(then.pixels_with(COURNAND_LABEL_MEDIUM) > 500);
    assert_true(then.flow > 5.0);
    move(first, 1303, 0.03f);
    const Seen after = seen(first, aorta());
    const std::vector<std::uint8_t> later = saved(first);
    assert_true(after.injected_ml > 7.99 && after.rate > then.rate);
    double best_us = 1e9; // for docs/library.md
    for (int round = 0; round < 10; round++) {
        const auto begin = std::chrono::steady_clock::now();
        restore(first, bytes);
        const std::chrono::duration<double, std::micro> took = std::chrono::steady_clock::now() - begin;
        best_us = std::min(best_us, took.count());
    }
    print_message("restore: %.1f us\n", best_us);
    for (cournand_world *restored : {first, other}) {
        restore(restored, bytes);
        assert_true(saved(restored) == bytes);
        assert_true(seen(restored, aorta()) == then);
        restore(restored, bytes);
        move(restored, 1303, 0.03f);
        assert_true(seen(restored, aorta()) == after);
        assert_true(saved(restored) == later);
        done(cournand_world_free(restored));
    }
}

// The test mounts a stent, expands it with its balloon, and leaves it in the vessel.
void a_stent_on_its_balloon_continues_bit_for_bit(void **)
{
    const std::vector<std::string> tools = {"coronary_014", "balloon_3x20"};
    const auto made = [&] { return treated(free_space(), tools, {"coronary_3_0x18"}, 0.06f); };
    cournand_world *first = made(), *other = made();
    done(cournand_world_load_stent(first));
    move(first, 60, 0.01f);
    std::vector<std::vector<std::uint8_t>> snapshots;
    std::vector<Seen> views;
    for (const float kPa : {0.0f, 900.0f, 900.0f, 0.0f, 0.0f}) {
        snapshots.push_back(saved(first));
        views.push_back(seen(first, free_space()));
        move(first, 407, 0.0f, kPa);
    }
    views.push_back(seen(first, free_space()));
    print_message("%zu bytes, stages:", snapshots.back().size());
    for (const Seen &one : views) print_message(" '%s'", one.stage.c_str());
    print_message("\n");
    assert_true(views[0].stage == "on its balloon" && views.back().stage != "on its balloon");
    assert_true(views[2].pixels_with(COURNAND_LABEL_STENT) > 50);
    for (std::size_t i = snapshots.size(); i-- > 0;)
        for (cournand_world *restored : {first, other}) {
            restore(restored, snapshots[i]);
            assert_true(seen(restored, free_space()) == views[i]);
            restore(restored, snapshots[i]);
            for (std::size_t k = i; k < snapshots.size(); k++)
                move(restored, 407, 0.0f, k == 1 || k == 2 ? 900.0f : 0.0f);
            assert_true(seen(restored, free_space()) == views.back());
        }
    done(cournand_world_free(first));
    done(cournand_world_free(other));
}

// In a replay the patient has an X-ray room with pedals, motors and dose.
void the_room_of_a_replay_is_part_of_a_snapshot(void **)
{
    const Folder folder("library-patient");
    const std::string path = folder.file("room.rec");
    const crn::SceneFile scene = crn::read_scene(aorta_path());
    const std::vector<crn::Instrument> tools = {crn::read_instrument(instruments + "terumo_5f.toml")};
    const crn::Session session = crn::parse_session("begin inserted 5 mm\nfollow tip\n"
                                                    "fluoro on rate 15 p/s\nc-arm LAO 20 CRA 10\n"
                                                    "advance 60 mm at 60 mm/s\nfluoro off\nwait 1 s",
                                                    "test");
    crn::Device device(scene, tools, crn::entry_of(scene, 1, session.inserted_um), crn::host_rig());
    crn::Patient patient({}, tools);
    crn::Recorder recorder(path, device.recording_header("test"));
    crn::run_session(device, patient, session, &recorder, nullptr, {});
    cournand_recording *recording = nullptr;
    done(cournand_recording_open(path.c_str(), &recording));
    auto info = sized<cournand_recording_info>();
    done(cournand_recording_describe(recording, &info));
    cournand_world *whole = nullptr, *restored = nullptr;
    for (cournand_world **made : {&whole, &restored})
        done(cournand_recording_world(recording, aorta(), COURNAND_WITH_PATIENT, made));
    done(cournand_world_replay(whole, recording, 733));
    const std::vector<std::uint8_t> bytes = saved(whole);
    done(cournand_world_replay(whole, recording, info.tick_count));
    const std::vector<std::uint8_t> last = saved(whole);
    for (int round = 0; round < 2; round++) {
        restore(restored, bytes);
        done(cournand_world_replay(restored, recording, info.tick_count));
        assert_true(saved(restored) == last);
    }
    assert_true(last != bytes);
    done(cournand_recording_free(recording));
    done(cournand_world_free(whole));
    done(cournand_world_free(restored));
}

void a_snapshot_of_another_patient_is_refused(void **)
{
    const std::vector<std::string> tools = {"coronary_014", "balloon_3x20"};
    cournand_world *plain = world(free_space(), tools), *bare = treated(free_space(), tools),
                   *stented = treated(free_space(), tools, {"coronary_3_0x18"});
    cournand_world *worlds[] = {plain, bare, stented};
    const char *const reasons[3][3] = {{"", "bytes", "bytes"},
                                       {"without a patient", "", "other stents"},
                                       {"without a patient", "other stents", ""}};
    for (std::size_t to = 0; to < 3; to++)
        for (std::size_t from = 0; from < 3; from++) {
            const std::vector<std::uint8_t> bytes = saved(worlds[from]);
            const cournand_status status = cournand_world_restore(worlds[to], bytes.data(), bytes.size());
            assert_int_equal(status, to == from ? COURNAND_OK : COURNAND_BAD_SNAPSHOT);
            if (to != from) assert_non_null(std::strstr(cournand_error_text(), reasons[to][from]));
        }
    for (cournand_world *one : worlds) done(cournand_world_free(one));
}

// Changes bytes of the patient's part of a snapshot, and corrects the checksum. If a world accepts a
// snapshot, it must be able to continue; if it refuses one, the world and its patient must stay unchanged.
void damaged_patients_are_refused_or_can_continue(void **)
{
    cournand_world *healthy = injected(), *tried = treated(aorta(), {"terumo_5f"}),
                   *plain = world(aorta(), {"terumo_5f"});
    const std::vector<std::uint8_t> bytes = saved(healthy), own = saved(tried);
    const std::size_t begin = saved(plain).size();
    std::size_t refused = 0, accepted = 0;
    std::uint64_t random = 7;
    for (std::size_t round = 0; round < 600; round++) {
        random = random * 6364136223846793005ull + 1442695040888963407ull;
        std::vector<std::uint8_t> bad = bytes;
        bad[begin + (random >> 20) % (bytes.size() - begin)] = static_cast<std::uint8_t>(random >> 56);
        if (round % 8 == 0) bad.resize(begin + (random >> 20) % (bytes.size() - begin));
        seal(bad);
        restore(tried, own);
        if (cournand_world_restore(tried, bad.data(), bad.size()) == COURNAND_OK) {
            accepted++;
            move(tried, 2, 0.01f);
            continue;
        }
        refused++;
        assert_true(saved(tried) == own);
    }
    print_message("%zu refused, %zu accepted\n", refused, accepted);
    assert_true(refused > 100 && accepted > 100);
    for (cournand_world *one : {healthy, tried, plain}) done(cournand_world_free(one));
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(medium_and_pressure_continue_bit_for_bit),
        cmocka_unit_test(a_stent_on_its_balloon_continues_bit_for_bit),
        cmocka_unit_test(the_room_of_a_replay_is_part_of_a_snapshot),
        cmocka_unit_test(a_snapshot_of_another_patient_is_refused),
        cmocka_unit_test(damaged_patients_are_refused_or_can_continue),
    };
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
