#include "hil_tests/rt1062/bench/board_bench.hpp"
#include "host/link/link.hpp"
#include <cstdlib>
#include <stdexcept>

namespace hil
{

namespace
{

constexpr double force_per_count_N = 9766e-6; // BOARD_FORCE_uN_per_count of the port
constexpr std::uint32_t debounce_ms = 20;
constexpr int answer_max_ms = 4000; // the longest request is a scene's validation

rt_chip &new_chip(rt_chip *&chip)
{
    chip = rt_chip_create();
    if (chip == nullptr) throw std::bad_alloc();
    return *chip;
}

} // namespace

BoardBench::BoardBench(const PlantSettings &settings, const std::string &image)
    : Bench(settings), pins_(new_chip(chip_))
{
    const char *error = nullptr;
    pins_.put(plant().inputs());
    engine_ = rt_engine_create(chip_, image.c_str(), &error);
    stream_ = engine_ != nullptr ? rt_stream_create(engine_) : nullptr;
    if (stream_ == nullptr) {
        rt_engine_destroy(engine_);
        rt_chip_destroy(chip_);
        throw std::runtime_error(image + ": " +
                                 (error != nullptr ? error : "there is no memory for the host"));
    }
    open();
}

BoardBench::~BoardBench()
{
    rt_stream_destroy(stream_);
    rt_engine_destroy(engine_);
    rt_chip_destroy(chip_);
}

void BoardBench::open()
{
    const char *trouble = rt_stream_open(stream_);
    if (trouble != nullptr) throw crn::LinkError(std::string("the emulated board: ") + trouble);
    microframe_ = 0;
}

// A wait that is only a little old may yet be answered.
void BoardBench::check_report()
{
    check_trouble();
    for (int i = 0; i < 100 && rt_unanswered(chip_, 0) != nullptr; i++) rt_engine_run_us(engine_, 10);
    char *text = nullptr;
    std::size_t bytes = 0;
    std::FILE *file = open_memstream(&text, &bytes);
    const std::uint32_t count = rt_report(chip_, file, rt_engine_place, engine_);
    std::fclose(file);
    const std::string report(text);
    std::free(text);
    if (count != 0) throw std::runtime_error("the chip's model reports:\n" + report);
}

void BoardBench::check_trouble() const
{
    const std::string trouble = rt_engine_trouble(engine_);
    if (!trouble.empty()) throw std::runtime_error("the chip's model stops: " + trouble);
}

void BoardBench::run_microframe()
{
    if (microframe_ == 0) pins_.put(plant().inputs());
    rt_stream_microframe(stream_);
    microframe_++;
    if (stream_->has_restarted) has_restarted_ = true;
}

crn_port_outputs BoardBench::edge(const crn_port_inputs &)
{
    while (microframe_ < RT_MICROFRAMES_PER_ms) run_microframe();
    microframe_ = 0;
    return pins_.outputs();
}

// A processor that a debugger halts: its timers go on, and its watchdog stands if the image allows that.
void BoardBench::pass_frozen_ms()
{
    rt_watchdogs_halt(chip_, RT_INSTANTS_PER_us * 1000);
    rt_chip_pass_us(chip_, 1000);
}

crn_port_outputs BoardBench::restart()
{
    rt_engine_power_cycle(engine_);
    rt_stream_restarted(stream_);
    has_restarted_ = true;
    return pins_.outputs();
}

bool BoardBench::push(std::span<const std::uint8_t> bytes)
{
    return rt_stream_write(stream_, bytes.data(), static_cast<std::uint32_t>(bytes.size()));
}

std::size_t BoardBench::take(std::span<std::uint8_t> bytes)
{
    return rt_stream_read(stream_, bytes.data(), static_cast<std::uint32_t>(bytes.size()));
}

// After a restart of the device, the next call throws once, and later calls reach the restarted device.
void BoardBench::check_life()
{
    if (!has_restarted_) return;
    has_restarted_ = false;
    rt_stream_restarted(stream_);
    open();
    throw crn::LinkError("the device started again; begin with HELLO");
}

void BoardBench::write(std::span<const std::uint8_t> bytes)
{
    check_life();
    for (int i = 0; !rt_stream_write(stream_, bytes.data(), static_cast<std::uint32_t>(bytes.size())); i++) {
        check_trouble();
        if (i == answer_max_ms)
            throw crn::LinkError(std::to_string(bytes.size()) +
                                 " bytes do not fit into the stream to the device");
        advance(1);
    }
}

// Returns 0 only when the device has taken all its input and has nothing more to do.
std::size_t BoardBench::read(std::span<std::uint8_t> bytes)
{
    check_life();
    for (int i = 0; i < answer_max_ms * RT_MICROFRAMES_PER_ms; i++) {
        const std::uint32_t count =
            rt_stream_read(stream_, bytes.data(), static_cast<std::uint32_t>(bytes.size()));
        if (count > 0) return count;
        if (stream_->out.begin == stream_->out.end && stream_->was_idle) break;
        if (microframe_ + 1 < RT_MICROFRAMES_PER_ms)
            run_microframe();
        else
            advance(1);
        if (has_restarted_) check_life();
    }
    check_trouble();
    return 0;
}

std::unique_ptr<Bench> BoardLevel::make(const PlantSettings &settings)
{
    PlantSettings of_board = settings;
    of_board.force_per_count_N = force_per_count_N;
    auto bench = std::make_unique<BoardBench>(of_board, image_);
    // The cases state the damping of the simulated rig. The board's builder has measured none (board.h), so
    // the device takes it only while the switch inside the rig is closed.
    bench->plant().local_unlock = true;
    bench->advance(debounce_ms);
    return bench;
}

} // namespace hil
