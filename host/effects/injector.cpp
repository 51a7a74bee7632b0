#include "host/effects/injector.hpp"
#include <algorithm>

namespace crn
{

std::uint64_t Injector::inject(std::uint32_t tick, std::int32_t volume_ul, std::int32_t rate_ul_s,
                               double iodine_mg_per_ml)
{
    if (volume_ul <= 0 || rate_ul_s <= 0) return 0;
    injections_.push_back(
        {++asked_, tick, UINT32_MAX, std::int64_t{volume_ul} * 1000, rate_ul_s, iodine_mg_per_ml});
    return asked_;
}

void Injector::stop(std::uint32_t tick)
{
    for (Injection &injection : injections_) injection.tick_end = std::min(injection.tick_end, tick);
}

void Injector::cancel(std::uint64_t injection)
{
    std::erase_if(injections_, [=](const Injection &one) { return one.number == injection; });
}

std::uint32_t Injector::first_tick() const
{
    std::uint32_t first = injections_.front().tick;
    for (const Injection &injection : injections_) first = std::min(first, injection.tick);
    return first;
}

void Injector::drop_ended()
{
    std::erase_if(injections_, [](const Injection &injection) { return injection.left_nl <= 0; });
}

void Injector::skip_to(std::uint32_t tick)
{
    for (Injection &injection : injections_)
        if (tick > injection.tick_end)
            injection.left_nl = 0;
        else if (injection.tick < tick)
            injection.left_nl -= injection.rate_nl * (tick - injection.tick);
    drop_ended();
}

void Injector::archive(StateArchive &state)
{
    constexpr std::int64_t volume_max_nl = 1'000'000'000, rate_max_nl = 1'000'000; // of one injection
    state.list(injections_, [&](Injection &one) {
        state.integer(one.number);
        state.integer(one.tick);
        state.integer(one.tick_end);
        state.integer<std::int64_t>(one.left_nl, 0, volume_max_nl);
        state.integer<std::int64_t>(one.rate_nl, 1, rate_max_nl);
        state.real(one.iodine_mg_per_ml, 0.0, 1000.0);
    });
    state.integer<std::int64_t>(injected_nl_, 0, INT64_MAX / 2);
    state.integer(asked_);
}

InjectedFluid Injector::take(std::uint32_t tick)
{
    std::int64_t sum_nl = 0;
    double iodine = 0.0;
    for (Injection &injection : injections_) {
        if (injection.tick >= tick) continue;
        if (tick > injection.tick_end) injection.left_nl = 0;
        const std::int64_t nl = std::min(injection.rate_nl, injection.left_nl);
        injection.left_nl -= nl;
        sum_nl += nl;
        iodine += static_cast<double>(nl) * injection.iodine_mg_per_ml;
    }
    drop_ended();
    injected_nl_ += sum_nl;
    if (sum_nl == 0) return {};
    return {static_cast<double>(sum_nl) * 1e-3, iodine / static_cast<double>(sum_nl)}; // nl per ms are ul/s
}

} // namespace crn
