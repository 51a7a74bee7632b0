// Makes unique identifiers (UIDs) from content: equal content gets equal UIDs, and different content gets
// different UIDs. The UIDs have the form of DICOM PS3.5 B.2: "2.25." and a 128-bit number, without a
// registered root.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

namespace crn
{

// Computes the 128-bit FNV-1a hash (draft-eastlake-fnv) of all data that were added, in the order in which
// they were added.
class Digest
{
  public:
    void add(const void *bytes, std::size_t count);
    void add(std::string_view text); // adds its length too, so that "ab", "c" differs from "a", "bc"
    // Returns 32 hexadecimal digits.
    std::string hex() const;
    // Returns "2.25." and a decimal number, at most 44 characters in all. The number is a UUID of version 8
    // (RFC 9562) that is made from the digest.
    std::string uid() const;

  private:
    unsigned __int128 value_ =
        (static_cast<unsigned __int128>(0x6c62272e07bb0142ULL) << 64) | 0x62b821756295c58dULL;
};

} // namespace crn
