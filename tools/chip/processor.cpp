#include "tools/chip/processor.hpp"
#include <cstring>
#include <elf.h>
#include <fstream>
#include <iterator>
#include <unicorn/unicorn.h>

namespace chip
{

namespace
{

constexpr std::uint32_t end_address = 0x00100000; // a call returns there; no code lies there

void check(uc_err status, const char *what)
{
    if (status != UC_ERR_OK) throw PriceError(std::string(what) + ": " + uc_strerror(status));
}

void on_block(uc_engine *, std::uint64_t address, std::uint32_t bytes, void *processor)
{
    Observer *observer = static_cast<Processor *>(processor)->observer();
    if (observer) observer->block(static_cast<std::uint32_t>(address), bytes);
}

void on_access(uc_engine *, uc_mem_type type, std::uint64_t address, int bytes, std::int64_t, void *processor)
{
    Observer *observer = static_cast<Processor *>(processor)->observer();
    if (observer)
        observer->access(static_cast<std::uint32_t>(address), static_cast<std::uint32_t>(bytes),
                         type == UC_MEM_WRITE);
}

} // namespace

Processor::Processor(const std::string &image)
{
    memories_ = {{0, std::vector<std::uint8_t>(192 << 10)},
                 {end_address, std::vector<std::uint8_t>(4 << 10)},
                 {state_address, std::vector<std::uint8_t>(state_bytes)},
                 {near_address, std::vector<std::uint8_t>(near_bytes)},
                 {host_address, std::vector<std::uint8_t>(512 << 10)},
                 {scene_address, std::vector<std::uint8_t>(scene_bytes)}};
    load(image);
    open();
    uc_hook hook;
    check(uc_hook_add(emulator_, &hook, UC_HOOK_BLOCK, reinterpret_cast<void *>(on_block), this, 1, 0),
          "the emulator reports no blocks");
    check(uc_hook_add(emulator_, &hook, UC_HOOK_MEM_READ | UC_HOOK_MEM_WRITE,
                      reinterpret_cast<void *>(on_access), this, 1, 0),
          "the emulator reports no accesses");
}

Processor::~Processor()
{
    if (emulator_) uc_close(emulator_);
}

void Processor::open()
{
    check(uc_open(UC_ARCH_ARM, static_cast<uc_mode>(UC_MODE_THUMB | UC_MODE_MCLASS), &emulator_),
          "the emulator does not start");
    check(uc_ctl_set_cpu_model(emulator_, UC_CPU_ARM_CORTEX_M7), "the emulator has no Cortex-M7");
    for (Memory &memory : memories_)
        check(
            uc_mem_map_ptr(emulator_, memory.address, memory.bytes.size(), UC_PROT_ALL, memory.bytes.data()),
            "the emulator takes no memory");
}

void Processor::load(const std::string &image)
{
    std::ifstream file(image, std::ios::binary);
    const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
    const auto *head = reinterpret_cast<const Elf32_Ehdr *>(bytes.data());
    if (bytes.size() < sizeof *head || std::memcmp(head->e_ident, ELFMAG, SELFMAG) != 0 ||
        head->e_machine != EM_ARM)
        throw PriceError("'" + image + "' is no image for ARM; `make budget` builds it");
    const auto *parts = reinterpret_cast<const Elf32_Phdr *>(bytes.data() + head->e_phoff);
    for (int i = 0; i < head->e_phnum; i++)
        if (parts[i].p_type == PT_LOAD && parts[i].p_filesz > 0)
            std::memcpy(at(parts[i].p_vaddr, parts[i].p_filesz), bytes.data() + parts[i].p_offset,
                        parts[i].p_filesz);
    const auto *sections = reinterpret_cast<const Elf32_Shdr *>(bytes.data() + head->e_shoff);
    for (int i = 0; i < head->e_shnum; i++) {
        if (sections[i].sh_type != SHT_SYMTAB) continue;
        const auto *symbols = reinterpret_cast<const Elf32_Sym *>(bytes.data() + sections[i].sh_offset);
        const char *names = bytes.data() + sections[sections[i].sh_link].sh_offset;
        for (std::size_t k = 0; k < sections[i].sh_size / sizeof *symbols; k++)
            symbols_[names + symbols[k].st_name] = {symbols[k].st_value, symbols[k].st_size,
                                                    ELF32_ST_TYPE(symbols[k].st_info) == STT_FUNC};
    }
}

std::uint8_t *Processor::at(std::uint32_t address, std::uint32_t bytes)
{
    for (Memory &memory : memories_)
        if (address >= memory.address && address - memory.address + bytes <= memory.bytes.size())
            return memory.bytes.data() + (address - memory.address);
    throw PriceError("the image uses memory that the board lacks; see firmware/bench/chip/chip.ld");
}

std::uint32_t Processor::address_of(const std::string &symbol) const
{
    const auto known = symbols_.find(symbol);
    if (known == symbols_.end())
        throw PriceError("the image has no '" + symbol + "'; build it anew by `make budget`");
    return known->second.address & ~1u;
}

std::string Processor::function_at(std::uint32_t address) const
{
    for (const auto &[name, symbol] : symbols_)
        if (symbol.is_function && address - (symbol.address & ~1u) < symbol.bytes) return name;
    return "?";
}

std::span<std::uint8_t> Processor::memory_of(const std::string &symbol)
{
    const std::uint32_t address = address_of(symbol), bytes = symbols_.at(symbol).bytes;
    return {at(address, bytes), bytes};
}

std::uint32_t Processor::word_of(const std::string &symbol)
{
    std::uint32_t word;
    std::memcpy(&word, memory_of(symbol).data(), sizeof word);
    return word;
}

NearWords read_near(Processor &processor)
{
    NearWords words;
    std::memcpy(&words, processor.memory_of("near_memory").data(), sizeof words);
    return words;
}

std::uint32_t Processor::return_address() const
{
    std::uint32_t address = 0;
    uc_reg_read(emulator_, UC_ARM_REG_LR, &address);
    return address & ~1u;
}

std::uint32_t Processor::call(const std::string &function, std::uint32_t argument, Observer *observer)
{
    std::uint32_t stack = address_of("chip_stack_top"), link = end_address | 1u, result = 0;
    uc_reg_write(emulator_, UC_ARM_REG_SP, &stack);
    uc_reg_write(emulator_, UC_ARM_REG_LR, &link);
    uc_reg_write(emulator_, UC_ARM_REG_R0, &argument);
    observer_ = observer;
    const uc_err status = uc_emu_start(emulator_, address_of(function) | 1u, end_address, 0, 0);
    observer_ = nullptr;
    check(status, ("the image stopped in " + function).c_str());
    uc_reg_read(emulator_, UC_ARM_REG_R0, &result);
    return result;
}

} // namespace chip
