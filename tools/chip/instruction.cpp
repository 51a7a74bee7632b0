#include "tools/chip/instruction.hpp"
#include "tools/chip/mnemonic.hpp"
#include <algorithm>
#include <bit>
#include <cctype>
#include <cstdio>
#include <cstring>
#include <memory>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace chip
{

namespace
{

// Splits at commas outside of brackets and braces.
std::vector<std::string> parts_of(const std::string &operands)
{
    std::vector<std::string> parts;
    std::string part;
    int depth = 0;
    for (const char letter : operands) {
        if (letter == '[' || letter == '{') depth++;
        if (letter == ']' || letter == '}') depth--;
        if (letter == ',' && depth == 0) {
            parts.push_back(part);
            part.clear();
        } else if (letter != ' ' || !part.empty()) {
            part += letter;
        }
    }
    if (!part.empty()) parts.push_back(part);
    return parts;
}

std::uint32_t bit_of(const std::string &text)
{
    static const std::unordered_map<std::string, int> names = {{"sb", 9},  {"sl", 10}, {"fp", 11}, {"ip", 12},
                                                               {"sp", 13}, {"lr", 14}, {"pc", 15}};
    const auto known = names.find(text);
    if (known != names.end()) return 1u << known->second;
    if (text.size() < 2 || text[0] != 'r' || !std::isdigit(static_cast<unsigned char>(text[1]))) return 0;
    const int number = std::stoi(text.substr(1));
    return number < 16 ? 1u << number : 0;
}

// The bits of all registers in a text such as "{r4, r5, lr}" or "[r0, r1, lsl #2]".
std::uint32_t bits_in(const std::string &text)
{
    std::uint32_t bits = 0;
    std::string word;
    for (const char letter : text + " ") {
        if (std::isalnum(static_cast<unsigned char>(letter))) {
            word += letter;
        } else {
            if (!word.empty()) bits |= bit_of(word);
            word.clear();
        }
    }
    return bits;
}

bool is_constant_shifted(const std::string &text, bool is_wide_name)
{
    const std::uint32_t value = static_cast<std::uint32_t>(std::stoll(text.substr(1), nullptr, 0));
    if (value < 256 || is_wide_name) return false;
    const std::uint32_t low = value & 0xff;
    const bool repeats =
        value == low * 0x00010001 || value == low * 0x01010101 || value == (value >> 8 & 0xff) * 0x01000100;
    return !repeats;
}

// The second operand of an arithmetic instruction, which begins at part `first`.
void take_second(Instruction &one, const Name &name, const std::vector<std::string> &parts, std::size_t first)
{
    if (first >= parts.size()) return;
    const bool is_shifted = first + 1 < parts.size();
    if (parts[first][0] == '#') {
        const bool is_wide = name.base.back() == 'w' || name.base == "movt";
        one.has_shifter = is_constant_shifted(parts[first], is_wide);
    } else if (is_shifted) {
        one.has_shifter = true;
        one.early |= bits_in(parts[first]);
        one.early |= bits_in(parts[first + 1]);
    } else {
        one.late |= bit_of(parts[first]);
    }
}

void take_arithmetic(Instruction &one, const Name &name, const std::vector<std::string> &parts)
{
    one.unit = Unit::arithmetic;
    const bool is_compare = name.form == Form::compare, is_move = name.form == Form::move;
    if (!is_compare) one.defines |= bit_of(parts[0]);
    std::size_t second = 1;
    if (is_compare || name.base == "movt") {
        one.late |= bit_of(parts[0]);
    } else if (!is_move) {
        const bool has_three = parts.size() > 2 && (bit_of(parts[2]) != 0 || parts[2][0] == '#');
        one.late |= bit_of(parts[has_three ? 1 : 0]);
        second = has_three ? 2 : 1;
    }
    take_second(one, name, parts, second);
    const bool is_simple =
        name.base == "add" || name.base == "sub" || name.base == "addw" || name.base == "subw" || is_move;
    one.may_run_early = is_simple && !one.has_shifter && name.base != "mvn";
    if (name.base == "adc" || name.base == "sbc") one.late |= flags_bit;
    if (is_compare || name.sets_flags) one.defines |= flags_bit;
}

void take_shift(Instruction &one, const Name &name, const std::vector<std::string> &parts)
{
    one.unit = Unit::shift;
    one.may_run_early = name.base != "rrx";
    one.defines = bit_of(parts[0]) | (name.sets_flags ? flags_bit : 0);
    for (std::size_t i = parts.size() > 2 ? 1 : 0; i < parts.size(); i++) one.early |= bit_of(parts[i]);
}

void take_bits(Instruction &one, const Name &name, const std::vector<std::string> &parts)
{
    one.unit = Unit::bits;
    one.defines = bit_of(parts[0]);
    const bool is_insert = name.base == "bfi" || name.base == "bfc";
    const bool is_extract =
        name.base == "ubfx" || name.base == "sbfx" || name.base.starts_with("r") || is_insert;
    if (is_insert) one.late |= one.defines;
    for (std::size_t i = 1; i < parts.size(); i++) (is_extract ? one.early : one.late) |= bit_of(parts[i]);
    if (name.base.find("xta") != std::string::npos || name.base.starts_with("pkh")) {
        one.late &= ~bit_of(parts[2]);
        one.early |= bit_of(parts[2]);
    }
    one.has_shifter = is_extract || one.early != 0;
}

void take_product(Instruction &one, const Name &name, const std::vector<std::string> &parts)
{
    one.unit = Unit::multiply;
    one.defines = bit_of(parts[0]) | (name.sets_flags ? flags_bit : 0);
    const bool is_long = name.base == "smull" || name.base == "umull" || name.form == Form::long_accumulate;
    if (is_long) one.defines |= bit_of(parts[1]);
    if (name.form == Form::long_accumulate) one.accumulate = one.defines;
    const std::size_t first = is_long ? 2 : parts.size() > 2 ? 1 : 0;
    for (std::size_t i = first; i < first + 2 && i < parts.size(); i++) one.late |= bit_of(parts[i]);
    if (name.form == Form::accumulate) one.accumulate = bit_of(parts[3]);
}

// "[r0, #4]", "[r0], #4", "[r0, #4]!", "[r0, r1, lsl #2]", "[pc, #8]"
void take_address(Instruction &one, const std::vector<std::string> &parts, std::size_t at)
{
    const std::string &text = parts[at];
    one.early |= bits_in(text);
    const std::string inside = text.substr(1, text.find(']') - 1);
    const std::uint32_t base = bit_of(inside.substr(0, inside.find(',')));
    if (text.back() == '!' || at + 1 < parts.size()) one.defines |= base;
    if (std::popcount(bits_in(text)) == 1 && text.back() != '!') {
        one.base = base;
        const std::size_t number = inside.find('#');
        if (number != std::string::npos && at + 1 == parts.size())
            one.offset = static_cast<std::int32_t>(std::stoi(inside.substr(number + 1)));
    }
}

void take_memory(Instruction &one, const Name &name, const std::vector<std::string> &parts)
{
    const bool is_load = name.form == Form::load || name.form == Form::narrow || name.form == Form::load_two;
    const std::size_t registers = name.form == Form::load_two || name.form == Form::store_two ? 2 : 1;
    one.unit = registers == 2              ? Unit::several
               : name.form == Form::narrow ? Unit::narrow_load
               : is_load                   ? Unit::load
                                           : Unit::store;
    for (std::size_t i = 0; i < registers && is_load; i++) one.defines |= bit_of(parts[i]);
    take_address(one, parts, registers);
    if (one.defines & bit_of("pc")) one.flow = Flow::indirect;
}

void take_many(Instruction &one, const Name &name, const std::vector<std::string> &parts)
{
    one.unit = Unit::several;
    const std::uint32_t list = bits_in(parts.back());
    const bool is_stack = parts.size() == 1;
    const std::uint32_t base = is_stack ? bit_of("sp") : bits_in(parts[0]);
    one.early = base;
    if (is_stack || parts[0].back() == '!') one.defines = base;
    if (name.form == Form::load_many) one.defines |= list;
    one.cycles = static_cast<std::uint32_t>(std::popcount(list) + 1) / 2;
    if (name.form == Form::load_many && (list & bit_of("pc"))) one.flow = Flow::indirect;
}

void take_branch(Instruction &one, const Name &name, const std::vector<std::string> &parts)
{
    one.unit = Unit::branch;
    const bool is_indirect = name.base == "bx" || name.base == "blx" || name.base.starts_with("tb");
    one.flow = is_indirect                                             ? Flow::indirect
               : name.is_conditional || name.form == Form::test_branch ? Flow::conditional
                                                                       : Flow::direct;
    if (is_indirect || name.form == Form::test_branch) one.late = bits_in(parts[0]);
    if (name.base == "bl" || name.base == "blx") one.defines = bit_of("lr");
}

void take(Instruction &one, const Name &name, const std::vector<std::string> &parts)
{
    switch (name.form) {
    case Form::compute:
    case Form::move:
    case Form::compare:
        return take_arithmetic(one, name, parts);
    case Form::shift:
        return take_shift(one, name, parts);
    case Form::bits:
        return take_bits(one, name, parts);
    case Form::product:
    case Form::accumulate:
    case Form::long_accumulate:
        return take_product(one, name, parts);
    case Form::divide:
        one.unit = Unit::divide;
        one.defines = bit_of(parts[0]);
        one.late = bit_of(parts[1]) | (parts.size() > 2 ? bit_of(parts[2]) : one.defines);
        return;
    case Form::load:
    case Form::narrow:
    case Form::load_two:
    case Form::store:
    case Form::store_two:
        return take_memory(one, name, parts);
    case Form::load_many:
    case Form::store_many:
        return take_many(one, name, parts);
    case Form::branch:
    case Form::test_branch:
        return take_branch(one, name, parts);
    case Form::nothing:
        return;
    }
}

} // namespace

Instruction decode(std::uint32_t address, std::uint32_t bytes, const std::string &mnemonic,
                   const std::string &operands)
{
    Instruction one;
    one.address = address;
    one.bytes = bytes;
    const auto name = name_of(mnemonic);
    if (!name)
        throw PriceError("the model of the pipeline does not know '" + mnemonic + " " + operands +
                         "'; add it to tools/chip/instruction.cpp");
    if (name->form != Form::nothing) take(one, *name, parts_of(operands));
    // what a condition leaves out keeps its old value, so that value is an operand too
    if (name->is_conditional && one.unit != Unit::branch) one.late |= flags_bit | (one.defines & ~flags_bit);
    return one;
}

std::map<std::uint32_t, Instruction> disassemble(const std::string &image)
{
    const std::string command = "arm-none-eabi-objdump -d '" + image + "'";
    const std::unique_ptr<FILE, int (*)(FILE *)> pipe(popen(command.c_str(), "r"), pclose);
    std::map<std::uint32_t, Instruction> all;
    char line[512];
    while (pipe && std::fgets(line, sizeof line, pipe.get())) {
        // "     178:\tb538      \tpush\t{r3, r4, r5, lr}"
        unsigned address = 0;
        char code[16], mnemonic[32], operands[256] = "";
        if (std::sscanf(line, " %x:\t%11[0-9a-f ]\t%31[^\t\n]\t%255[^\n@;<]", &address, code, mnemonic,
                        operands) < 3)
            continue;
        // Constants: a word behind a '.', or a line of bytes, which has no second tab.
        if (mnemonic[0] == '.' || std::count(line, line + std::strlen(line), '\t') < 2) continue;
        std::uint32_t digits = 0;
        for (const char *c = code; *c != '\0'; c++) digits += *c != ' ';
        std::string text = operands;
        while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.pop_back();
        all[address] = decode(address, digits / 2, mnemonic, text);
    }
    if (all.empty())
        throw PriceError("'" + image +
                         "' has no code that arm-none-eabi-objdump shows; `make budget` builds it "
                         "and installs the disassembler");
    return all;
}

} // namespace chip
