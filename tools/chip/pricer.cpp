#include "tools/chip/pricer.hpp"
#include "tools/chip/pipeline.hpp"
#include <algorithm>

namespace chip
{

namespace
{

constexpr std::uint32_t brick_bytes = 1000;    // CRN_LUMEN_BRICK_SAMPLES
constexpr std::uint32_t motion_row_bytes = 52; // CRN_MOTION_ROW numbers of 16 bits
constexpr std::uint32_t code_bytes = 192 << 10;
constexpr std::uint32_t stack_bytes = 4096; // stays in tightly coupled memory on every board

} // namespace

double TickPrice::cycles(const Board &board) const
{
    const double per_ns = board.core_MHz * 1e-3;
    const bool is_state_cached = board.state_line_ns > 0.0;
    return core_cycles + (is_state_cached ? scene_misses : misses) * board.line_ns * per_ns +
           (is_state_cached ? near_shared_misses : near_misses) * board.near_line_ns * per_ns +
           (is_state_cached ? state_misses * board.state_line_ns * per_ns : 0.0);
}

Pricer::Pricer(const Processor &processor, const std::map<std::uint32_t, Instruction> &code,
               const std::string &step)
    : processor_(processor), code_(code), step_(processor.address_of(step)),
      block_by_address_(code_bytes / 2, none), lines_(Processor::scene_bytes / line_bytes),
      near_lines_(Processor::near_bytes / line_bytes), bricks_(Processor::near_bytes / brick_bytes + 1),
      motion_(Processor::scene_bytes / motion_row_bytes + 1)
{
}

std::uint32_t Pricer::block_at(std::uint32_t address, std::uint32_t bytes)
{
    std::uint32_t &known = block_by_address_.at(address / 2);
    if (known != none && blocks_[known].bytes == bytes) return known;
    Block block{address, bytes, address, Flow::straight, false, {}, {}, {address}};
    Pipeline pipeline;
    for (std::uint32_t at = address; at < address + bytes;) {
        const auto one = code_.find(at);
        if (one == code_.end())
            throw PriceError("the disassembler shows no instruction where the processor ran one");
        block.code.push_back(one->second);
        pipeline.issue(one->second);
        block.last = at;
        block.flow = one->second.flow;
        at += one->second.bytes;
    }
    block.knows_flags_early = pipeline.since_flags() >= 3;
    known = static_cast<std::uint32_t>(blocks_.size());
    blocks_.push_back(std::move(block));
    return known;
}

// The cycles that a block adds to the block before it: the difference between both together and the first.
std::uint32_t Pricer::straight_cycles(std::uint32_t before, std::uint32_t now)
{
    for (const Predecessor &known : blocks_[now].predecessors)
        if (known.block == before) return known.cycles;
    Pipeline pipeline;
    if (before != none) {
        for (const Instruction &one : blocks_[before].code) pipeline.issue(one);
        if (blocks_[before].address + blocks_[before].bytes != blocks_[now].address) pipeline.end_pair();
    }
    const std::int64_t begin = pipeline.cycles();
    for (const Instruction &one : blocks_[now].code) pipeline.issue(one);
    const auto cycles = static_cast<std::uint32_t>(pipeline.cycles() - begin);
    blocks_[now].predecessors.push_back({before, cycles});
    return cycles;
}

// The cycles that the way from the block before to this address takes beyond its instructions.
std::uint32_t Pricer::branch_cycles(std::uint32_t address)
{
    if (before_ == none || blocks_[before_].flow == Flow::straight) return 0;
    const Block &last = blocks_[before_];
    return branches_.cycles(
        {last.last, address, last.address + last.bytes != address, last.flow, last.knows_flags_early});
}

void Pricer::begin_tick()
{
    is_in_step_ = true;
    return_address_ = processor_.return_address();
    tick_ = {};
    lines_.begin();
    near_lines_.begin();
    bricks_.begin();
    motion_.begin();
}

void Pricer::end_tick()
{
    is_in_step_ = false;
    tick_.lines = lines_.count() + near_lines_.count();
    tick_.bricks = bricks_.count();
    tick_.motion_rows = motion_.count();
    ticks_.push_back(tick_);
}

void Pricer::block(std::uint32_t address, std::uint32_t bytes)
{
    if (is_in_step_ && address == return_address_) end_tick();
    if (!is_in_step_ && address == step_) begin_tick();
    const std::uint32_t now = block_at(address, bytes);
    TickPrice &price = is_in_step_ ? tick_ : rest_;
    price.instructions += static_cast<std::uint32_t>(blocks_[now].code.size());
    const std::uint32_t straight = straight_cycles(before_, now), branch = branch_cycles(address);
    price.core_cycles += straight + branch;
    price.branch_cycles += branch;
    if (is_in_step_ && is_spent_kept_) blocks_[now].spent.cycles += straight + branch;
    before_ = now;
}

void Pricer::access_near(std::uint32_t address, bool is_write)
{
    const auto cost = [](const Cache::Access &access) {
        return (access.is_missing ? 1u : 0u) + (access.written_back != 0 ? 1u : 0u);
    };
    near_lines_.take((address - Processor::near_address) / line_bytes);
    const std::uint32_t lines = cost(scene_cache_.access(address, is_write));
    tick_.near_misses += lines;
    if (is_spent_kept_) blocks_[before_].spent.near_misses += lines;
    tick_.near_shared_misses += cost(shared_cache_.access(address, is_write));
    if (address >= scene_.near_bricks && address - scene_.near_bricks < scene_.near_brick_count * brick_bytes)
        bricks_.take((address - scene_.near_bricks) / brick_bytes);
}

void Pricer::access(std::uint32_t address, std::uint32_t, bool is_write)
{
    if (!is_in_step_) return;
    const bool is_scene = address >= Processor::scene_address;
    const std::uint32_t state_end = Processor::state_address + Processor::state_bytes - stack_bytes;
    const bool is_state = address >= Processor::state_address && address < state_end;
    if (is_state) tick_.state_misses += shared_cache_.access(address, false).is_missing;
    if (address >= Processor::near_address && address - Processor::near_address < Processor::near_bytes)
        return access_near(address, is_write);
    if (!is_scene) return;
    lines_.take((address - Processor::scene_address) / line_bytes);
    const Cache::Access access = scene_cache_.access(address, is_write);
    tick_.misses += access.is_missing;
    tick_.near_misses += access.written_back != 0;
    if (is_spent_kept_) blocks_[before_].spent.misses += access.is_missing;
    tick_.scene_misses += shared_cache_.access(address, is_write).is_missing;
    if (address >= scene_.motion && address - scene_.motion < scene_.motion_bytes)
        motion_.take((address - scene_.motion) / motion_row_bytes);
}

std::vector<Spent> Pricer::spent() const
{
    std::vector<Spent> all;
    for (const Block &block : blocks_) all.push_back(block.spent);
    return all;
}

} // namespace chip
