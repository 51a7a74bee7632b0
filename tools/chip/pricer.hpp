// Prices the ticks of the core that an emulated processor computes: instructions, cycles of the pipeline,
// lines and bricks of the scene, misses of the cache (docs/budget.md).
#pragma once
#include "tools/chip/board.hpp"
#include "tools/chip/branches.hpp"
#include "tools/chip/cache.hpp"
#include "tools/chip/processor.hpp"
#include <map>
#include <utility>
#include <vector>

namespace chip
{

struct TickPrice {
    std::uint32_t instructions = 0;
    std::uint32_t core_cycles = 0;        // of the pipeline, with branches, without misses
    std::uint32_t branch_cycles = 0;      // ... those of wrong predictions
    std::uint32_t lines = 0, bricks = 0;  // different ones of the scene
    std::uint32_t motion_rows = 0;        // different rows of the heart's lattice, 52 bytes each
    std::uint32_t misses = 0;             // of the scene's lines
    std::uint32_t near_misses = 0;        // of lines of near memory, and changed ones that are written back
    std::uint32_t state_misses = 0;       // of the state's lines where the state is cached with the scene
    std::uint32_t scene_misses = 0;       // ... and of the scene's lines there
    std::uint32_t near_shared_misses = 0; // ... and of near memory
    double cycles(const Board &board) const;
    double share(const Board &board) const { return cycles(board) / board.tick_cycles(); }
};

// Where the parts of the lumen lie in the memory of the processor.
struct SceneLayout {
    std::uint32_t motion = 0, motion_bytes = 0;          // 0: the vessel does not move
    std::uint32_t near_bricks = 0, near_brick_count = 0; // copies in near memory
};

// What the priced ticks spent in the code of one block.
struct Spent {
    std::uint32_t address = 0;
    std::uint64_t cycles = 0, misses = 0, near_misses = 0; // cycles without misses
};

class Pricer final : public Observer
{
  public:
    // `step` is the function whose calls are priced.
    Pricer(const Processor &processor, const std::map<std::uint32_t, Instruction> &code,
           const std::string &step);

    void set_scene(const SceneLayout &scene) { scene_ = scene; }
    void block(std::uint32_t address, std::uint32_t bytes) override;
    void access(std::uint32_t address, std::uint32_t bytes, bool is_write) override;

    std::vector<TickPrice> take_ticks() { return std::exchange(ticks_, {}); }
    // Price of everything that ran outside of `step`, since the last call.
    TickPrice take_rest() { return std::exchange(rest_, {}); }

    // By block, over all ticks that ran while it was kept, as it is from the beginning.
    std::vector<Spent> spent() const;
    void keep_spent(bool is_kept) { is_spent_kept_ = is_kept; }

  private:
    struct Predecessor {
        std::uint32_t block, cycles;
    };
    struct Block {
        std::uint32_t address, bytes, last; // last: address of its last instruction
        Flow flow;
        bool knows_flags_early;
        std::vector<Instruction> code;
        std::vector<Predecessor> predecessors;
        Spent spent;
    };
    static constexpr std::uint32_t none = UINT32_MAX;

    std::uint32_t block_at(std::uint32_t address, std::uint32_t bytes);
    std::uint32_t straight_cycles(std::uint32_t before, std::uint32_t now);
    std::uint32_t branch_cycles(std::uint32_t address);
    void begin_tick();
    void end_tick();

    const Processor &processor_;
    const std::map<std::uint32_t, Instruction> &code_;
    std::uint32_t step_, return_address_ = none;
    SceneLayout scene_;
    std::vector<Block> blocks_;
    std::vector<std::uint32_t> block_by_address_;
    std::uint32_t before_ = none; // the block that ran last
    BranchPredictor branches_;
    Cache scene_cache_{cache_bytes}, shared_cache_{cache_bytes};
    void access_near(std::uint32_t address, bool is_write);

    Distinct lines_, near_lines_, bricks_, motion_;
    bool is_in_step_ = false, is_spent_kept_ = true;
    TickPrice tick_, rest_;
    std::vector<TickPrice> ticks_;
};

} // namespace chip
