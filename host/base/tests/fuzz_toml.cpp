// Fuzz target: any text may be given as a TOML text. An accepted text must give a result that can be
// traversed, copied and destroyed. The parsed text must not be nested more deeply than the check before
// parsing permits. If a text is refused, the error must have a message.
#include "host/base/toml.hpp"
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *bytes, std::size_t count);
extern "C" std::size_t fuzz_seed(unsigned index, std::uint8_t *bytes, std::size_t capacity);

namespace
{

// The deepest accepted text has 32 nested brackets, each with a key of 32 names, below a header of 32 names.
// The values themselves add one level of nesting.
constexpr int depth_max =
    crn::toml_brackets_max + (crn::toml_brackets_max + 2) * (crn::toml_key_names_max + 1);

int depth(const toml::node &node)
{
    int deepest = 0;
    if (const toml::table *table = node.as_table())
        for (const auto &[key, inner] : *table) deepest = std::max(deepest, depth(inner));
    if (const toml::array *array = node.as_array())
        for (const toml::node &inner : *array) deepest = std::max(deepest, depth(inner));
    return deepest + 1;
}

} // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t *bytes, std::size_t count)
{
    const std::vector<char> exact(bytes, bytes + count);
    try {
        const toml::table table = crn::parse_toml({exact.data(), exact.size()}, "fuzz");
        if (depth(table) > depth_max) std::abort();
        const toml::table copy = table;
    } catch (const crn::TomlError &error) {
        if (*error.what() == '\0') std::abort();
    }
    return 0;
}

std::size_t fuzz_seed(unsigned index, std::uint8_t *bytes, std::size_t capacity)
{
    static const char *const texts[] = {
        "[scene]\nname = \"a\" # one\n[lumen]\nmesh = 'a.ply'\nunit = \"mm\"\noffset_mm = [0, -1.5, 2e3]\n",
        "a.b.\"c d\".e = {x = 1, y.z = [true, {w = 1979-05-27T07:32:00Z}]}\n[[body]]\nname = "
        "\"\"\"b\"\"\"\"\n[[body]]\n",
        "format = 2\ntip_mm = { value = 1.0, source = \"@tips\" "
        "}\n[preset.physical]\n[[preset.physical.section]]\nto_mm = inf\n",
        "x = [[[[[[1]]]], 0x1F, 0b10, 0o7, nan, '''\n'''], \"\\u00e4\"]\n"};
    if (index >= std::size(texts)) return 0;
    const std::string_view text = texts[index];
    if (text.size() > capacity) return 0;
    std::copy(text.begin(), text.end(), bytes);
    return text.size();
}
