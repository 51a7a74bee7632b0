// One instruction of a Cortex-M7 image, as the model of the pipeline sees it (docs/budget.md). The text comes
// from the disassembler of the same toolchain that compiled the image.
#pragma once
#include <cstdint>
#include <map>
#include <stdexcept>
#include <string>

namespace chip
{

// The program cannot price the image; the text says why and what to do.
class PriceError : public std::runtime_error
{
  public:
    using std::runtime_error::runtime_error;
};

enum class Unit {
    arithmetic,  // adds, logic, moves, comparisons: the late ALU, if need be
    shift,       // moves with a shift
    bits,        // bit fields, extensions, saturating additions: one a cycle, as the older of a pair
    multiply,    // products, with and without accumulation
    load,        // one word
    narrow_load, // byte or halfword
    store,
    several, // loads and stores of several registers: alone
    divide,
    branch,
    nothing // nop, IT
};

enum class Flow { straight, conditional, direct, indirect };

inline constexpr std::uint32_t flags_bit = 1u << 16; // beside the bits of r0 to r15

struct Instruction {
    std::uint32_t address = 0, bytes = 0;
    Unit unit = Unit::nothing;
    Flow flow = Flow::straight;
    std::uint32_t late = 0;       // registers that the late ALU consumes, one bit each
    std::uint32_t early = 0;      // ... and those for addresses and shifters, needed a cycle earlier
    std::uint32_t accumulate = 0; // ... and those to which a product is added, needed later
    std::uint32_t defines = 0;
    std::uint32_t cycles = 1;   // that it takes when it issues alone
    bool has_shifter = false;   // shifted register, or a constant of a byte that is shifted
    bool may_run_early = false; // add, sub, mov: its result may serve the younger of the same pair
    std::uint32_t base = 0;     // of a load: bit of its base register; 0: not base + constant
    std::int32_t offset = 0;    // of a load
    bool writes(std::uint32_t bits) const { return (defines & bits) != 0; }
};

// Reads one line of `objdump -d`: mnemonic and operands. Throws PriceError for a mnemonic that it does not
// know.
Instruction decode(std::uint32_t address, std::uint32_t bytes, const std::string &mnemonic,
                   const std::string &operands);

// All instructions of an image by their addresses. Throws PriceError.
std::map<std::uint32_t, Instruction> disassemble(const std::string &image);

} // namespace chip
