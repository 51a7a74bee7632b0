#include "hil_tests/cases/bench.hpp"
#include <chrono>
#include <thread>

namespace hil
{

void Bench::sleep(double seconds)
{
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
}

} // namespace hil
