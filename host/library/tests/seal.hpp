// Corrects the checksum of a changed snapshot, so that tests reach the checks of its contents.
#pragma once
#include "host/library/world.hpp"
#include <cstdint>
#include <vector>

namespace crn::tests
{

inline void seal(std::vector<std::uint8_t> &snapshot)
{
    const auto write = [&](std::size_t at, std::uint64_t number, std::size_t bytes) {
        for (std::size_t i = 0; i < bytes && at + i < snapshot.size(); i++)
            snapshot[at + i] = static_cast<std::uint8_t>(number >> (8 * i));
    };
    constexpr std::size_t size_at = 8; // of the number of bytes
    write(size_at, snapshot.size(), 4);
    write(library::snapshot_check_at, library::snapshot_check(snapshot), 8);
}

} // namespace crn::tests
