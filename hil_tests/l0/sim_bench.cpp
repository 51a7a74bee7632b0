#include "hil_tests/l0/sim_bench.hpp"
#include "host/link/link.hpp"
#include <new>

namespace hil
{

SimBench::SimBench(const PlantSettings &settings) : Bench(settings), sim_(crn_sim_create(8u << 20))
{
    if (sim_ == nullptr) throw std::bad_alloc();
    crn_sim_set_plant(sim_, &plant().inputs());
}

SimBench::~SimBench()
{
    crn_sim_destroy(sim_);
}

crn_port_outputs SimBench::edge(const crn_port_inputs &inputs)
{
    crn_sim_set_plant(sim_, &inputs);
    crn_sim_timer(sim_, 1);
    return crn_sim_read_outputs(sim_);
}

void SimBench::pass_frozen_ms()
{
    crn_sim_freeze(sim_, 1);
}

crn_port_outputs SimBench::restart()
{
    crn_sim_reset(sim_);
    has_restarted_ = true;
    return crn_sim_read_outputs(sim_);
}

void SimBench::write(std::span<const std::uint8_t> bytes)
{
    if (has_restarted_) {
        has_restarted_ = false;
        throw crn::LinkError("the device started again; begin with HELLO");
    }
    crn_sim_write(sim_, bytes.data(), bytes.size());
}

std::size_t SimBench::read(std::span<std::uint8_t> bytes)
{
    return crn_sim_read(sim_, bytes.data(), bytes.size());
}

void SimBench::pass_time_ms(std::uint32_t milliseconds)
{
    advance(milliseconds);
}

} // namespace hil
