#include "host/room/run_store.hpp"
#include "host/room/command.hpp"
#include <algorithm>

namespace crn
{
namespace
{

std::size_t bytes_of(const RunFrame &frame, const std::vector<std::uint8_t> &grey)
{
    return frame.raw.size() * sizeof frame.raw[0] + grey.size();
}

std::size_t bytes_of(const StoredRun &stored)
{
    std::size_t bytes = 0;
    for (std::size_t i = 0; i < stored.grey.size(); ++i)
        bytes += bytes_of(stored.run.frames[i], stored.grey[i]);
    return bytes;
}

} // namespace

void RunStore::begin(int number, RunKind kind)
{
    runs_.push_back(std::make_unique<StoredRun>());
    runs_.back()->run.kind = kind;
    runs_.back()->run.number = number;
    is_open_ = true;
}

bool RunStore::make_room(std::size_t bytes)
{
    for (const auto &stored : runs_) {
        if (bytes_ + bytes <= bytes_max_) break;
        if (stored->is_dropped || (is_open_ && stored == runs_.back())) continue;
        bytes_ -= bytes_of(*stored);
        stored->grey.clear();
        stored->run.frames.clear();
        stored->is_dropped = true;
    }
    return bytes_ + bytes <= bytes_max_;
}

bool RunStore::add(RunFrame frame, std::vector<std::uint8_t> grey)
{
    if (!is_open_) return false;
    const std::size_t bytes = bytes_of(frame, grey);
    if (!make_room(bytes)) return false;
    bytes_ += bytes;
    runs_.back()->run.frames.push_back(std::move(frame));
    runs_.back()->grey.push_back(std::move(grey));
    return true;
}

void RunStore::finish(bool was_made)
{
    if (!is_open_) return;
    is_open_ = false;
    if (!runs_.back()->run.frames.empty()) return;
    if (was_made)
        runs_.back()->is_dropped = true;
    else
        runs_.pop_back();
}

void RunStore::pass(const XrayRun &header, RunFrame frame, std::vector<std::uint8_t> grey)
{
    if (header.size != passed_header_.size) {
        passed_.clear();
        passed_bytes_ = 0;
    }
    passed_header_ = header;
    passed_bytes_ += bytes_of(frame, grey);
    passed_.push_back({std::move(frame), std::move(grey)});
    const std::uint32_t now = passed_.back().frame.tick;
    while (passed_.size() > 1 &&
           (now - passed_.front().frame.tick >= static_cast<std::uint32_t>(store_max_ms) ||
            passed_bytes_ > bytes_max_ / 2)) {
        passed_bytes_ -= bytes_of(passed_.front().frame, passed_.front().grey);
        passed_.pop_front();
    }
}

void RunStore::keep_passed(int number, std::uint32_t tick, std::uint32_t milliseconds)
{
    begin(number, RunKind::fluoro);
    runs_.back()->run = passed_header_;
    runs_.back()->run.number = number;
    for (const StoredFrame &passed : passed_)
        if (tick - passed.frame.tick < milliseconds && !add(passed.frame, passed.grey)) break;
    finish(true);
}

StoredRun *RunStore::find(int number) const
{
    if (runs_.empty()) return nullptr;
    if (number == 0) return runs_.back().get();
    const auto found = std::find_if(runs_.begin(), runs_.end(),
                                    [&](const auto &stored) { return stored->run.number == number; });
    return found == runs_.end() ? nullptr : found->get();
}

StoredRun *RunStore::last_of(RunKind kind) const
{
    const auto found = std::find_if(runs_.rbegin(), runs_.rend(),
                                    [&](const auto &stored) { return stored->run.kind == kind; });
    return found == runs_.rend() ? nullptr : found->get();
}

} // namespace crn
