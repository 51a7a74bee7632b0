// Fuzz target: reads arbitrary bytes as a centreline file in one of four formats; the first byte selects the
// format. The JSON and XML parsers run in the process of the fuzz target. Every accepted tree must fulfil the
// rules of check_tree, and it must be unchanged when it is written and read again.
#include "tools/centreline/formats.hpp"
#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *bytes, std::size_t count);
extern "C" std::size_t fuzz_seed(unsigned index, std::uint8_t *bytes, std::size_t capacity);

namespace
{

using namespace crn::centreline;

Tree read(unsigned format, const std::string &text)
{
    switch (format % 4) {
    case 0:
        return read_csv(text, "fuzz");
    case 1:
        return read_markups(text, "fuzz");
    case 2:
        return read_polydata(text, "fuzz");
    default:
        return read_polyline(text, "fuzz");
    }
}

std::string written(unsigned format, const Tree &tree)
{
    switch (format % 4) {
    case 0:
        return csv_text(tree);
    case 1:
        return markups_text(tree);
    case 2:
        return polydata_text(tree);
    default:
        return polyline_text(tree);
    }
}

Tree sample()
{
    Tree tree;
    tree.branches.resize(2);
    for (int i = 0; i < 4; ++i) tree.branches[0].spheres.push_back({{0, 10.0 * i, 0.5}, 4.0, 120});
    tree.branches[0].name = "trunk";
    tree.branches[1] = {"side", 0, 2, {tree.branches[0].spheres[2], {{6, 20, 0.5}, 2.0, 80, true}}};
    return tree;
}

} // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t *bytes, std::size_t count)
{
    if (count == 0) return 0;
    const std::string text(reinterpret_cast<const char *>(bytes + 1), count - 1);
    try {
        const Tree tree = read(bytes[0], text);
        check_tree(tree, "fuzz");
        const std::string again = written(bytes[0], tree);
        if (again.empty()) std::abort();
    } catch (const crn::Fault &fault) {
        if (std::strncmp(fault.what(), "fuzz", 4) != 0) std::abort();
    }
    return 0;
}

std::size_t fuzz_seed(unsigned index, std::uint8_t *bytes, std::size_t capacity)
{
    if (index >= 4) return 0;
    const std::string text = static_cast<char>(index) + written(index, sample());
    if (text.size() > capacity) return 0;
    std::copy(text.begin(), text.end(), bytes);
    return text.size();
}
