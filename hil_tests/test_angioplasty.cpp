// These tests check balloon and stent in whole sessions, from the script to the recording. The stent must be
// opened and deployed, and must keep the lumen as wide as the balloon has opened it. The core receives the
// stent as part of the recorded inputs, so a replay with or without pictures is equal bit for bit. After a
// failure the session must report the outcome, and the recording must be complete. The tests cause these
// failures: the balloon is pulled under pressure, bursts, is released where no wall holds the stent, or is
// inflated in a guiding catheter; or the device loses its power. The scene is an artery of 3 mm behind a wide
// vessel of 10 mm, with a stenosis of 50 % that a balloon can open; the tests bake this scene.
#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <numbers>
#include <string>
#include <unistd.h>
#include <vector>

#include "firmware/port/sim/sim.h"
#include "host/picture/session_pictures.hpp"
#include "host/session/replay.hpp"
#include "host/session/run.hpp"

// The header cmocka.h comes last, because its macros (fail, ...) would change other headers.
extern "C" {
#include <cmocka.h>
}

namespace
{

namespace fs = std::filesystem;
using namespace crn;

constexpr int length_mm = 110, around = 24;
constexpr double lesion_mm = 70.0; // its middle
const char *const wire = "coronary_014.toml", *const balloon = "balloon_3x20.toml";
fs::path folder;

double radius_mm(double y)
{
    const double share = std::clamp((y - 30.0) / 10.0, 0.0, 1.0);
    return 5.0 + share * (1.5 - 5.0);
}

void write_tube()
{
    std::ofstream mesh(folder / "tube.obj"), line(folder / "artery.csv");
    line << "branch,x_mm,y_mm,z_mm,radius_mm\n";
    for (int i = 0; i <= length_mm; ++i) {
        // The radius in the scene file is that of the circle inside the polygon.
        const double r = radius_mm(i) / std::cos(std::numbers::pi / around);
        for (int k = 0; k < around; ++k) {
            const double angle = 2 * std::numbers::pi * k / around;
            mesh << "v " << r * std::cos(angle) << ' ' << i << ' ' << -r * std::sin(angle) << '\n';
        }
        line << "0,0," << i << ",0," << radius_mm(i) << '\n';
    }
    for (int i = 0; i < length_mm; ++i)
        for (int k = 0; k < around; ++k) {
            const int a = 1 + i * around + k, b = 1 + i * around + (k + 1) % around;
            mesh << "f " << a << ' ' << a + around << ' ' << b + around << "\nf " << a << ' ' << b + around
                 << ' ' << b << '\n';
        }
    std::ofstream(folder / "scene.toml")
        << "[scene]\nname = \"Artery\"\n[lumen]\nmesh = \"tube.obj\"\nunit = \"mm\"\ncap = true\n"
           "level_max = 2\ntolerance_mm = 0.05\n[tree]\ncentrelines = [\"artery.csv\"]\n"
           "flow_ml_min = { artery = 60 }\n[entry]\nposition_mm = [0, 2, 0]\ndirection = [0, 1, 0]\n"
           "[[lesion]]\nname = \"plaque\"\nbranch = \"artery\"\nat_mm = 70\nlength_mm = 12\n"
           "stenosis_percent = 50\nyield_kPa = 300\nfull_kPa = 300\nrecoil = 0.35\n";
}

int bake_scene(void **)
{
    folder = fs::temp_directory_path() / ("cournand_angioplasty_" + std::to_string(getpid()));
    fs::create_directories(folder);
    write_tube();
    const char *build = std::getenv("BUILD"); // set by the test runner
    const std::string command = std::string(build ? build : "build") + "/bin/bake '" +
                                (folder / "scene.toml").string() + "' -o '" +
                                (folder / "artery.scene").string() + "' --points 100 --poses 0 > '" +
                                (folder / "log").string() + "' 2>&1";
    if (std::system(command.c_str()) == 0) return 0;
    std::fprintf(stderr, "failed: %s\n", command.c_str());
    return 1;
}

int remove_scene(void **)
{
    fs::remove_all(folder);
    return 0;
}

// Describes a session, runs it, and holds all its results.
struct Case {
    std::string script;
    std::vector<std::string> tools = {wire, balloon};
    std::size_t stents = 1;
    bool has_pictures = false;
    std::string record = "case.rec";

    RunResult result{};
    std::vector<StentResult> placed{};
    std::vector<std::string> refusals{};
    std::vector<double> open{};    // the lesion's stations at the end
    std::vector<WireNode> nodes{}; // and the line

    void run()
    {
        const SceneFile scene = read_scene((folder / "artery.scene").string());
        std::vector<Instrument> instruments;
        for (const std::string &tool : tools)
            instruments.push_back(read_instrument("shared/examples/instruments/" + tool));
        PictureSettings settings;
        settings.bodies_path = (folder / "artery.bodies").string();
        settings.scene_path = scene.path;
        settings.stents = read_stents(
            std::vector<std::string>(stents, "shared/examples/stents/coronary_3_0x18.toml"), instruments);
        settings.size = 64;
        const Session session = parse_session(script, "case");
        const crn_wire_entry entry = entry_of(scene, instruments.size(), session.inserted_um);
        Device device(scene, instruments, entry, host_rig());
        const SceneAnatomy anatomy = read_anatomy(settings);
        const std::unique_ptr<Patient> patient = make_patient(settings, anatomy, instruments);
        std::unique_ptr<SessionPictures> pictures;
        if (has_pictures)
            pictures = std::make_unique<SessionPictures>(settings, instruments, *patient, anatomy);
        Recorder recorder((folder / record).string(), {device.identity().core_version,
                                                       device.identity().schema_hash,
                                                       static_cast<std::uint32_t>(scene.bytes.size()),
                                                       scene.crc32,
                                                       scene.path,
                                                       "case",
                                                       instruments,
                                                       {},
                                                       entry,
                                                       device.rig(),
                                                       settings.stents});
        RunSettings how;
        if (script.find("load stent") == std::string::npos && stents > 0)
            how.begin.push_back({RoomAction::load_stent, {}});
        result = run_session(device, *patient, session, &recorder, pictures.get(), how);
        if (PatientStents *kept = patient->stents()) {
            placed = kept->results();
            refusals = kept->refusals();
        }
        device.link().read_nodes();
        open = session_frame(device, {}, {}).wire.lesions_open;
        nodes = session_frame(device, {}, {}).wire.nodes;
    }

    // Returns the smallest opening (0 to 1) of the lesion in its middle third. Near its ends the lesion does
    // not narrow the vessel, so the balloon opens nothing there.
    double least_open() const
    {
        const auto third = static_cast<std::ptrdiff_t>(open.size() / 3);
        return *std::min_element(open.begin() + third, open.end() - third);
    }
    // Replays the recording. If `at_end` is given, the function compares no hashes, and writes the shape of
    // the nested tools at the end of the replay to `at_end`.
    ReplayResult replay(const Recording &recording, std::vector<WireNode> *at_end = nullptr,
                        double from_s = 0.0) const
    {
        const SceneFile scene = read_scene((folder / "artery.scene").string());
        const RecordingHeader &header = recording.header;
        Device device(scene, header.tools, header.entry, header.rig);
        ReplaySettings settings;
        settings.verifies = at_end == nullptr;
        settings.from_s = from_s;
        const ReplayResult replayed = replay_recording(device, recording, nullptr, nullptr, settings);
        if (at_end) {
            device.link().read_nodes();
            *at_end = session_frame(device, {}, {}).wire.nodes;
        }
        return replayed;
    }
    Recording recorded() const { return read_recording((folder / record).string()); }
};

void assert_replays(const Case &one)
{
    const Recording recording = one.recorded();
    const ReplayResult replayed = one.replay(recording);
    if (replayed.first_difference_tick)
        fail_msg("tick %u: %s", *replayed.first_difference_tick, replayed.difference.c_str());
    assert_true(recording.is_complete && replayed.ticks_compared == one.result.figures.ticks);
    assert_true(replayed.hash == one.result.hash);
}

// The balloon's middle lies 15 mm behind the catheter's tip, and the introducer sheath ends at 2 mm.
std::string begin_at(double y_mm)
{
    char text[120];
    std::snprintf(text, sizeof text, "begin catheter inserted %g mm\nbegin wire inserted %g mm\n",
                  y_mm + 13.0, std::min(y_mm + 28.0, 105.0));
    return text;
}

const std::string up_and_down =
    "inflate to 10 bar at 25 bar/s\nwait 0.4 s\ndeflate at 25 bar/s\nwait 0.6 s\n";

// Places a stent in the lesion, without pictures; the session runs once for all tests that examine it.
Case &usual_case()
{
    static Case usual{begin_at(lesion_mm) + up_and_down};
    if (usual.placed.empty()) {
        usual.record = "usual.rec";
        usual.run();
    }
    return usual;
}

std::size_t count_of(const Recording &recording, std::uint8_t kind)
{
    std::size_t count = 0;
    for (const RecordedTick &tick : recording.ticks) count += order_of(tick.input.orders, kind) != nullptr;
    return count;
}

std::size_t holds_of(const Recording &recording)
{
    return count_of(recording, CRN_WIRE_KIND_scaffold);
}

std::size_t rings_of(const Recording &recording)
{
    return count_of(recording, CRN_WIRE_KIND_strut);
}

// Without a stent, the lumen loses about a third of its gain in diameter by recoil (a share of 0.35); with a
// stent, the lumen keeps its gain. The balloon has a diameter of 3 mm in an artery of 3 mm. The outside of
// the stent therefore lies on the wall, and the stent's inner diameter is smaller than the artery's diameter
// by twice the strut thickness of 0.081 mm.
void a_stent_holds_what_its_balloon_has_opened(void **)
{
    Case &stented = usual_case(), bare{begin_at(lesion_mm) + up_and_down};
    bare.stents = 0;
    bare.record = "bare.rec";
    bare.run();
    assert_int_equal(stented.placed.size(), 1);
    const StentResult &stent = stented.placed[0];
    std::printf(
        "# open %.3f with the stent, %.3f without; apposed %.0f %%, inside %.2f mm, deployed at %u ms\n",
        stented.least_open(), bare.least_open(), stent.figures.apposed_share * 100,
        stent.figures.diameter_min_mm, stent.released_tick.value_or(0));
    assert_true(stent.stage == StentStage::deployed && stent.branch == "artery");
    assert_true(stent.released_tick && stent.opened_tick && *stent.opened_tick < *stent.released_tick);
    assert_true(bare.least_open() < 0.7 && stented.least_open() > 0.8);
    assert_true(stent.figures.apposed_share > 0.95);
    const double throat_mm = 3.0 * (0.5 + 0.5 * stented.open[stented.open.size() / 2]) - 2 * 0.081;
    assert_true(std::abs(stent.figures.diameter_min_mm - throat_mm) < 0.1);
    assert_true(stent.lesions.size() == 1 && !stent.lesions[0].coverage.misses());
    assert_true(holds_of(stented.recorded()) > 0 && holds_of(bare.recorded()) == 0);
    assert_replays(stented);
    assert_replays(bare);
}

// The test repeats the session with pictures. The X-ray pulses for the pictures lie between the updates of
// the stent, but the core must get the same inputs in every tick.
void pictures_change_nothing(void **)
{
    Case &unseen = usual_case(), seen{begin_at(lesion_mm) + "fluoro on rate 15 p/s\n" + up_and_down};
    seen.has_pictures = true;
    seen.record = "seen.rec";
    seen.run();
    // The X-ray pedal is a button of the rig, which the core ignores.
    assert_true(seen.result.hash == unseen.result.hash);
    const Recording a = unseen.recorded(), b = seen.recorded();
    assert_int_equal(a.ticks.size(), b.ticks.size());
    for (std::size_t i = 0; i < a.ticks.size(); ++i) {
        const crn_wire_order *hold = order_of(a.ticks[i].input.orders, CRN_WIRE_KIND_scaffold),
                             *same = order_of(b.ticks[i].input.orders, CRN_WIRE_KIND_scaffold);
        assert_true((hold == nullptr) == (same == nullptr));
        if (!hold) continue;
        assert_int_equal(hold->scaffold.lesion, same->scaffold.lesion);
        assert_int_equal(hold->scaffold.open_q15, same->scaffold.open_q15);
    }
    assert_true(a.header.stents.size() == 1 && a.header.stents[0].name == b.header.stents[0].name);
    assert_replays(seen);
}

// The session has two stents, which are placed one behind the other; the second stent is loaded outside of
// the patient. The commands to load a stent while the balloon is in the patient, and to load more stents than
// there are, must be refused.
void a_second_stent_is_loaded_outside_of_the_patient(void **)
{
    Case two{begin_at(-10.0) + "load stent\nadvance catheter until inserted 83 mm at 200 mm/s\n" +
             up_and_down +
             "load stent\nwithdraw catheter until inserted 3 mm at 200 mm/s\nload stent\nload stent\n"
             "advance catheter until inserted 73 mm at 200 mm/s\n" +
             up_and_down};
    two.stents = 2;
    two.run();
    assert_int_equal(two.placed.size(), 2);
    assert_int_equal(two.refusals.size(), 2);
    assert_non_null(std::strstr(two.refusals[0].c_str(), "in the patient"));
    assert_non_null(std::strstr(two.refusals[1].c_str(), "NO STENT LEFT"));
    for (const StentResult &stent : two.placed) assert_true(stent.stage == StentStage::deployed);
    std::printf("# overlap %.2f mm of 17.8\n", two.placed[1].overlap_mm);
    assert_true(two.placed[1].overlap_mm > 5.0 && two.placed[1].overlap_mm < 10.0);
    assert_replays(two);
}

void released_where_the_vessel_is_wide_it_is_lost(void **)
{
    Case lost{begin_at(17.0) + up_and_down};
    lost.run();
    assert_int_equal(lost.placed.size(), 1);
    assert_true(lost.placed[0].stage == StentStage::adrift && lost.placed[0].branch.empty());
    assert_true(lost.placed[0].figures.apposed_share == 0.0);
    assert_int_equal(holds_of(lost.recorded()), 0);
    assert_int_equal(rings_of(lost.recorded()), 0);
    assert_replays(lost);
}

// Inside a guiding catheter a stent does not open; it stays crimped on its balloon and is withdrawn with the
// balloon.
void inflated_in_the_guide_it_stays_on_its_balloon(void **)
{
    Case guided{"begin guide inserted 40 mm\nbegin catheter inserted 32 mm\nbegin wire inserted 60 mm\n" +
                up_and_down + "withdraw catheter until inserted 3 mm at 200 mm/s\n"};
    guided.tools.push_back("guide_ntr_6f.toml");
    guided.run();
    const StentResult &stent = guided.placed.at(0);
    assert_true(stent.stage == StentStage::on_balloon && !stent.opened_tick);
    assert_true(guided.result.figures.balloon.peaks.at(0).pressure_kPa == 1000);
    assert_replays(guided);
}

// At a balloon pressure of 8 bar, friction (0.1 times the wall force) resists the hand with 5.3 N. The
// balloon moves with the hand, and the stent moves with the balloon. The stent is deployed at its new
// position when the pressure is released. In the tested session, the nested tools are stretched by 0.77 %. If
// the balloon were inflated to 10 bar, friction would hold it with 6.2 N, and the balloon would come loose
// suddenly when the pressure had fallen to 9 bar. The tools would then be stretched by 1.30 % under 10 N,
// beyond the limit of 1 % at which a run ends as out of range (range_watch.hpp).
void pulled_without_deflation_the_balloon_holds_its_stent(void **)
{
    Case pulled{begin_at(lesion_mm) +
                "inflate to 8 bar at 25 bar/s\nwithdraw catheter 10 mm at 50 mm/s\ndeflate at 25 bar/s\n"
                "wait 0.6 s\n"};
    pulled.run();
    const StentResult &stent = pulled.placed.at(0);
    const ToolFigures &catheter = pulled.result.figures.tools.at(1);
    std::printf("# pulled with %.2f N; the stent from %.1f to %.1f mm, %s\n", catheter.axial_max_N,
                stent.lesions.empty() ? 0.0 : stent.lesions[0].coverage.from_mm,
                stent.lesions.empty() ? 0.0 : stent.lesions[0].coverage.to_mm,
                std::string(stent_stage_text(stent.stage)).c_str());
    const double wall_N = pulled.result.figures.balloon.wall_max_N;
    assert_true(catheter.axial_max_N > 0.08 * wall_N && catheter.axial_max_N < 0.15 * wall_N);
    assert_false(pulled.result.figures.range.is_left());
    assert_true(stent.stage == StentStage::deployed && stent.lesions.size() == 1);
    const double from_mm = stent.lesions[0].coverage.from_mm; // 61.1 where it was mounted, 51.1 after 10 mm
    assert_true(std::abs(from_mm - 51.1) < 0.5 && stent.lesions[0].coverage.misses());
    assert_replays(pulled);
}

// Returns a point's distance from the centreline of the vessel, which is the y axis.
double off_axis_mm(const WireNode &node)
{
    return std::hypot(node.position_m.x(), node.position_m.z()) * 1e3;
}

Recording without_struts(Recording recording)
{
    for (RecordedTick &tick : recording.ticks) {
        crn_wire_order_list others{};
        for (const crn_wire_order &order : orders_of(tick.input))
            if (order.kind != CRN_WIRE_KIND_strut) others.items[others.items_count++] = order;
        tick.input.orders = others;
    }
    return recording;
}

// The middle of the stent lies 42 mm along the vessel. Half of the stent lies on the wall of the artery. The
// other half of the stent, from 33 to 40 mm along the vessel, is malapposed, because the vessel is wider
// there. The wire is drawn back out of the stent and advanced again along the wall. If the wire is advanced
// again along the wall, it passes beside the struts and stays outside the stent. In a replay without the
// stent's struts, but with everything else equal, the wire advances into the artery.
void a_wire_beside_a_stent_meets_its_struts(void **)
{
    Case beside{
        begin_at(42.0) + up_and_down +
        "withdraw catheter until inserted 3 mm at 200 mm/s\nwithdraw wire until inserted 18 mm at 200 mm/s\n"
        "rotate wire 90 deg\nadvance wire until inserted 40 mm at 8 mm/s\nwait 0.3 s\n"};
    beside.record = "beside.rec";
    beside.run();
    assert_true(beside.placed.at(0).stage == StentStage::deployed);
    assert_true(beside.placed[0].figures.apposed_share < 0.8);
    const Recording recording = beside.recorded();
    assert_int_equal(rings_of(recording), 12); // once
    constexpr double outside_mm = 1.48 + 0.081, wire_mm = 0.178;
    std::size_t held = 0;
    for (const WireNode &node : beside.nodes) {
        if (node.position_m.y() < 33.3e-3) continue;
        ++held;
        assert_true(off_axis_mm(node) > outside_mm + wire_mm - 0.05);
    }
    const WireNode &tip = beside.nodes.front();
    std::vector<WireNode> through;
    beside.replay(without_struts(recording), &through);
    std::printf("# %zu nodes beside the struts, tip at %.1f mm, %.2f mm off the axis; without struts at %.1f "
                "mm, %.2f mm off it\n",
                held, tip.position_m.y() * 1e3, off_axis_mm(tip), through.front().position_m.y() * 1e3,
                off_axis_mm(through.front()));
    assert_true(held > 0);
    assert_true(through.front().position_m.y() > tip.position_m.y() + 3e-3);
    assert_replays(beside);
    // The replay begins at the snapshot at 5 s, which contains the rings of struts.
    const ReplayResult late = beside.replay(recording, nullptr, 5.1);
    assert_false(late.first_difference_tick.has_value());
    assert_true(late.hash == beside.result.hash && late.ticks_compared < beside.result.figures.ticks);
}

// The balloon bursts at 22 bar when the inflator rises to 30 bar. After the burst the balloon has no
// pressure. When the balloon bursts, the stent is already expanded, so it is deployed.
void burst_balloon_leaves_its_stent_open(void **)
{
    Case burst{begin_at(lesion_mm) + "inflate to 30 bar at 40 bar/s\nwait 0.8 s\n"};
    burst.run();
    const BalloonFigures &figures = burst.result.figures.balloon;
    assert_true(figures.burst_tick && *figures.burst_tick > 500 && *figures.burst_tick < 620);
    assert_true(figures.peaks.at(0).pressure_kPa >= 2190 && figures.peaks.at(0).pressure_kPa <= 2250);
    assert_true(burst.placed.at(0).stage == StentStage::deployed);
    assert_true(figures.series.back().pressure_kPa == 0.0f && figures.series.back().diameter_max_mm < 2.0f);
    assert_int_equal(burst.result.faults.entries_count, 0);
    assert_replays(burst);
}

// The test cuts off the recording's file in the middle of a chunk, at a time when the balloon is under
// pressure. The file still has all ticks of its complete chunks. The ticks of the complete chunks replay
// together with the stent's commands to the core.
void a_recording_cut_in_mid_inflation_replays_to_the_cut(void **)
{
    const Case &whole = usual_case();
    const Recording all = whole.recorded();
    std::ifstream file(folder / whole.record, std::ios::binary);
    std::string bytes((std::istreambuf_iterator<char>(file)), {});
    // The test cuts the file such that the chunk of ticks 501 to 1000 is complete and the next chunk is
    // incomplete.
    std::size_t cut = 0;
    Recording read;
    for (std::size_t share = 95; share > 5 && read.ticks.size() != 500; share -= 1) {
        cut = bytes.size() * share / 100;
        const std::vector<std::uint8_t> part(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(cut));
        read = parse_recording(part, "cut");
    }
    assert_int_equal(read.ticks.size(), 500);
    assert_false(read.is_complete);
    assert_true(read.ticks.back().input.inflator_raw > 900); // under pressure
    assert_true(holds_of(read) > 0);
    const ReplayResult replayed = whole.replay(read);
    assert_false(replayed.first_difference_tick.has_value());
    assert_int_equal(replayed.ticks_compared, 500);
    assert_true(read.ticks.back().hash_lane[0] == all.ticks[499].hash_lane[0]);
}

// Simulates a device with a rig whose inflator rises to 10 bar, stays at this pressure and falls again.
class PumpedRig final : public Transport
{
  public:
    PumpedRig() : sim_(crn_sim_create(16u << 20), crn_sim_destroy) { pass_time_ms(1); }
    void write(std::span<const std::uint8_t> bytes) override
    {
        crn_sim_write(sim_.get(), bytes.data(), bytes.size());
    }
    std::size_t read(std::span<std::uint8_t> bytes) override
    {
        return crn_sim_read(sim_.get(), bytes.data(), bytes.size());
    }
    void pass_time_ms(std::uint32_t milliseconds) override
    {
        for (std::uint32_t i = 0; i < milliseconds; ++i, ++passed_ms_) {
            crn_port_inputs inputs = crn_sim_healthy_inputs();
            inputs.inflator_sensor = CRN_PORT_SENSOR_OK;
            inputs.inflator_raw = passed_ms_ < 1000 ? std::min(passed_ms_ * 5, 1000) : 0;
            crn_sim_set_inputs(sim_.get(), &inputs);
            crn_sim_timer(sim_.get(), 1);
        }
    }

  private:
    std::unique_ptr<crn_sim, void (*)(crn_sim *)> sim_;
    std::int32_t passed_ms_ = 0;
};

// In FREE_RUN sessions the host sends the commands about the stent as requests. Each request about the stent
// is recorded in the tick in which the device's core carried it out.
void in_free_run_the_core_is_told_by_requests_and_the_ticks_replay(void **)
{
    const Case &like = usual_case(); // the same tools and stent
    const RecordingHeader before = like.recorded().header;
    const SceneFile scene = read_scene((folder / "artery.scene").string());
    PictureSettings settings;
    settings.bodies_path = (folder / "artery.bodies").string();
    settings.scene_path = scene.path;
    settings.stents = before.stents;
    DeviceChoice choice;
    choice.free_run = true;
    choice.opens = [] { return std::make_unique<PumpedRig>(); };
    Device device(scene, before.tools, before.entry, host_rig(), choice);
    const std::unique_ptr<Patient> patient = make_patient(settings, read_anatomy(settings), before.tools);
    RecordingHeader header = before;
    header.rig = device.rig();
    Case led{""};
    led.record = "led.rec";
    {
        Recorder recorder((folder / led.record).string(), header);
        led.result =
            run_free_session(device, *patient, {{RoomAction::load_stent, {}}}, 2.0, &recorder, nullptr, {});
    }
    assert_string_equal(led.result.stopped_by.c_str(), "");
    assert_true(led.result.figures.balloon.peaks.at(0).pressure_kPa == 1000);
    assert_true(patient->stents()->stents()[0].stage() == StentStage::deployed);
    assert_true(holds_of(led.recorded()) > 0);
    assert_int_equal(rings_of(led.recorded()), 12);
    assert_replays(led);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(a_stent_holds_what_its_balloon_has_opened),
        cmocka_unit_test(pictures_change_nothing),
        cmocka_unit_test(a_second_stent_is_loaded_outside_of_the_patient),
        cmocka_unit_test(released_where_the_vessel_is_wide_it_is_lost),
        cmocka_unit_test(inflated_in_the_guide_it_stays_on_its_balloon),
        cmocka_unit_test(pulled_without_deflation_the_balloon_holds_its_stent),
        cmocka_unit_test(a_wire_beside_a_stent_meets_its_struts),
        cmocka_unit_test(burst_balloon_leaves_its_stent_open),
        cmocka_unit_test(in_free_run_the_core_is_told_by_requests_and_the_ticks_replay),
        cmocka_unit_test(a_recording_cut_in_mid_inflation_replays_to_the_cut),
    };
    return cmocka_run_group_tests(tests, bake_scene, remove_scene);
}
