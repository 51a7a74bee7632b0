// A Cortex-M7 with the memories of the i.MX RT1062, in which the functions of an image are called one by one.
// An observer sees every block that runs and every access to memory.
#pragma once
#include "tools/chip/instruction.hpp"
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

struct uc_struct;

namespace chip
{

// What a priced call reports.
class Observer
{
  public:
    virtual ~Observer() = default;
    virtual void block(std::uint32_t address, std::uint32_t bytes) = 0;
    virtual void access(std::uint32_t address, std::uint32_t bytes, bool is_write) = 0;
};

class Processor
{
  public:
    static constexpr std::uint32_t scene_address = 0x70000000, scene_bytes = 16 << 20;
    static constexpr std::uint32_t near_address = 0x2021c000,
                                   near_bytes = 400 << 10;    // firmware/core/near/near.h
    static constexpr std::uint32_t host_address = 0x30000000; // buffers between `chip` and the image
    static constexpr std::uint32_t state_address = 0x20000000, state_bytes = 320 << 10;

    // Throws PriceError when the image is missing or is no image for this board.
    explicit Processor(const std::string &image);
    ~Processor();
    Processor(const Processor &) = delete;
    Processor &operator=(const Processor &) = delete;

    // Calls a function of the image and returns its result. With an observer, the call is priced.
    std::uint32_t call(const std::string &function, std::uint32_t argument = 0, Observer *observer = nullptr);
    std::uint32_t address_of(const std::string &symbol) const;
    std::string function_at(std::uint32_t address) const;
    // The memory of a variable of the image.
    std::span<std::uint8_t> memory_of(const std::string &symbol);
    std::uint32_t return_address() const; // of the function that begins now; only in Observer::block
    std::uint32_t word_of(const std::string &symbol);

    Observer *observer() const { return observer_; }

  private:
    struct Memory {
        std::uint32_t address;
        std::vector<std::uint8_t> bytes;
    };
    struct Symbol {
        std::uint32_t address = 0, bytes = 0;
        bool is_function = false;
    };
    void load(const std::string &image);
    void open();
    std::uint8_t *at(std::uint32_t address, std::uint32_t bytes);

    std::vector<Memory> memories_;
    std::map<std::string, Symbol> symbols_;
    Observer *observer_ = nullptr;
    uc_struct *emulator_ = nullptr;
};

// The beginning of crn_near (firmware/core/near/near.h), as a processor with words of 32 bits has it.
struct NearWords {
    std::uint32_t tick, spans, entries, child_begin, slots, slot_count, slot_next, brick_count, bricks, lists,
        nodes, node_count, node_next, numbers, slices_copied, nodes_copied;
};
NearWords read_near(Processor &processor);

} // namespace chip
