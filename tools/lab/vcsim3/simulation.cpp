#include "tools/lab/vcsim3/simulation.hpp"
#include <algorithm>
#include <charconv>
#include <chrono>

namespace vcsim3
{
namespace
{

constexpr double tick_s = 1e-3;

RodProperties with_mode(RodProperties properties, const SimulationSettings &settings)
{
    // In each step, the penalty spring removes the same fraction of a length error as Baumgarte's term. When
    // the spring force Ks/l C (Ks: stiffness, l: length of the segment, C: length error) pushes two points of
    // mass m apart for a time h, their relative velocity changes by 2 h Ks C/(l m). The spring changes the
    // velocity by beta C/h for a length error C, as Baumgarte's term does, if Ks = beta m l/(2 h^2), where l
    // is the length of a segment.
    const double step_s = tick_s / settings.substeps;
    const double mass_kg = properties.mass_kg_per_m * properties.element_m;
    properties.stretch_N =
        settings.mode.kind == Mode::Kind::penalty
            ? settings.distance.baumgarte * mass_kg * properties.element_m / (2.0 * step_s * step_s)
            : 0.0;
    return properties;
}

// Adds the time since the last call to the time of one phase of the step.
class Stopwatch
{
  public:
    explicit Stopwatch(bool is_on) : is_on_(is_on) { mark_ = now(); }
    void add_to(double *phase_s)
    {
        if (!is_on_) return;
        const auto present = now();
        *phase_s += std::chrono::duration<double>(present - mark_).count();
        mark_ = present;
    }

  private:
    using Clock = std::chrono::steady_clock;
    Clock::time_point now() const { return is_on_ ? Clock::now() : Clock::time_point(); }
    bool is_on_;
    Clock::time_point mark_;
};

} // namespace

std::string Mode::name() const
{
    if (kind == Kind::global) return "1 Global";
    if (kind == Kind::penalty) return "1 Penalty";
    return std::to_string(iterations) + " Local";
}

std::string Mode::token() const
{
    if (kind == Kind::global) return "global";
    if (kind == Kind::penalty) return "penalty";
    return "local" + std::to_string(iterations);
}

bool operator==(const Mode &a, const Mode &b)
{
    return a.token() == b.token();
}

bool parse_mode(const std::string &token, Mode &mode)
{
    if (token == "global" || token == "penalty") {
        mode = {token == "global" ? Mode::Kind::global : Mode::Kind::penalty, 1};
        return true;
    }
    if (token.rfind("local", 0) != 0) return false;
    int count = 0;
    const char *first = token.data() + 5, *last = token.data() + token.size();
    const auto [end, error] = std::from_chars(first, last, count);
    if (error != std::errc() || end != last || count < 1 || count > 10000) return false;
    mode = {Mode::Kind::local, count};
    return true;
}

const std::vector<Mode> &thesis_modes()
{
    using Kind = Mode::Kind;
    static const std::vector<Mode> modes = {{Kind::global, 1}, {Kind::penalty, 1}, {Kind::local, 1},
                                            {Kind::local, 5},  {Kind::local, 10},  {Kind::local, 25},
                                            {Kind::local, 50}, {Kind::local, 100}, {Kind::local, 200}};
    return modes;
}

Simulation::Simulation(const RodProperties &properties, const Inserter &inserter, const Wall &wall,
                       const SimulationSettings &settings, double inserted_m)
    : settings_(settings), inserter_(inserter), wall_(wall),
      rod_(inserter.make_rod(with_mode(properties, settings), inserted_m)), distances_(settings.distance),
      inserted_m_(inserted_m), step_s_(tick_s / settings.substeps)
{
}

void Simulation::tick(double feed_m, double turn_rad)
{
    handle_mean_N_ = 0.0;
    for (int i = 0; i < settings_.substeps; i++) {
        inserted_m_ += feed_m / settings_.substeps;
        turn_rad_ += turn_rad / settings_.substeps;
        inserter_.feed(rod_, inserted_m_, feed_m / tick_s, turn_rad_);
        step(nullptr);
        handle_mean_N_ += handle_axial_N() / settings_.substeps;
    }
}

void Simulation::step(PhaseTimes *times)
{
    PhaseTimes unused;
    PhaseTimes &spent = times ? *times : unused;
    Stopwatch watch(times != nullptr);
    add_elastic_forces(rod_);
    watch.add_to(&spent.cosserat_s);
    integrate_velocities(rod_, step_s_);
    watch.add_to(&spent.integrator_s);
    find_contacts(rod_, wall_, contacts_);
    watch.add_to(&spent.collisions_s);
    hold_lengths();
    watch.add_to(&spent.constraints_s);
    integrate_positions(rod_, step_s_);
    watch.add_to(&spent.integrator_s);
}

double Simulation::handle_axial_N() const
{
    if (rod_.free_count >= rod_.node_count()) return 0.0;
    const Vector impulse =
        settings_.mode.kind == Mode::Kind::penalty ? Vector::Zero() : distances_.hand_impulse();
    return -inserter_.direction().dot(rod_.force[rod_.free_count] + impulse / step_s_);
}

void Simulation::hold_lengths()
{
    const double baumgarte = settings_.distance.baumgarte;
    if (settings_.mode.kind == Mode::Kind::penalty) {
        answer_contacts(rod_, contacts_, baumgarte, step_s_);
        return;
    }
    distances_.prepare(rod_, step_s_);
    const bool is_global = settings_.mode.kind == Mode::Kind::global;
    for (int i = 0; i < (is_global ? 1 : settings_.mode.iterations); i++) {
        if (is_global) {
            distances_.solve_global(rod_);
        } else {
            distances_.sweep_local(rod_);
        }
        answer_contacts(rod_, contacts_, baumgarte, step_s_);
    }
}

std::vector<double> Simulation::save() const
{
    std::vector<double> numbers = {static_cast<double>(rod_.free_count), inserted_m_, turn_rad_};
    const auto put = [&](const auto &list) {
        for (const auto &item : list) numbers.insert(numbers.end(), item.data(), item.data() + item.size());
    };
    put(rod_.position);
    put(rod_.velocity);
    for (const Quaternion &q : rod_.orientation)
        numbers.insert(numbers.end(), q.coeffs().data(), q.coeffs().data() + 4);
    put(rod_.spin);
    return numbers;
}

bool Simulation::restore(const std::vector<double> &numbers)
{
    if (numbers.size() != save().size()) return false;
    if (!(numbers[0] >= 0.0 && numbers[0] <= rod_.node_count())) return false;
    rod_.free_count = static_cast<int>(numbers[0]);
    inserted_m_ = numbers[1];
    turn_rad_ = numbers[2];
    const double *next = numbers.data() + 3;
    const auto take = [&](auto &list) {
        for (auto &item : list) {
            std::copy(next, next + item.size(), item.data());
            next += item.size();
        }
    };
    take(rod_.position);
    take(rod_.velocity);
    for (Quaternion &q : rod_.orientation) {
        std::copy(next, next + 4, q.coeffs().data());
        next += 4;
    }
    take(rod_.spin);
    return true;
}

} // namespace vcsim3
