// Fuzz target: passes arbitrary bytes, as the header of a scan, to the strict functions that read headers
// before ITK does. The first byte selects the format (NRRD, MetaImage, NIfTI). The target checks that every
// accepted header states sizes and a finite spacing, and declares enough bytes for its voxels.
#include "tools/lab/ct/volume/volume_declared.hpp"
#include "tools/lab/ct/volume/volume_io.hpp"
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *bytes, std::size_t count);
extern "C" std::size_t fuzz_seed(unsigned index, std::uint8_t *bytes, std::size_t capacity);

namespace
{

using namespace crn::ct;

const char *const texts[] = {
    "NRRD0004\n# a comment\ntype: short\ndimension: 3\nspace: left-posterior-superior\nsizes: 7 9 5\n"
    "space directions: (0.5,0,0) (0, 0.6,0) (0,0,1)\nspace origin: (1,2,3)\nspace units: \"mm\" \"mm\" "
    "\"mm\"\n"
    "endian: little\nencoding: gzip\nnote:=x\n\n",
    "ObjectType = Image\nNDims = 3\nBinaryData = True\nBinaryDataByteOrderMSB = False\nCompressedData = "
    "False\n"
    "TransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 0 0 0\nElementSpacing = 0.5 0.6 1\nDimSize = 7 9 5\n"
    "ElementType = MET_SHORT\nElementDataFile = LOCAL\n"};

} // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t *bytes, std::size_t count)
{
    if (count == 0) return 0;
    const std::vector<char> exact(bytes + 1,
                                  bytes + count); // an exact copy, so that a read past the end is detected
    const std::string_view head(exact.data(), exact.size());
    try {
        const DeclaredVolume declared = bytes[0] % 3 == 0   ? declared_nrrd(head, "fuzz")
                                        : bytes[0] % 3 == 1 ? declared_meta(head, "fuzz")
                                                            : declared_nifti(head, "fuzz");
        if (!declared.spacing_mm.allFinite() || declared.spacing_mm.minCoeff() <= 0) std::abort();
        if (*std::min_element(declared.size.begin(), declared.size.end()) < 1) std::abort();
        if (declared.head_bytes > 1000000) std::abort();
        check_plausible(declared.size, declared.spacing_mm, "fuzz");
        const auto voxels =
            static_cast<std::uint64_t>(declared.size[0] * declared.size[1] * declared.size[2]);
        if (declared.value_bytes < voxels || declared.value_bytes > 8 * voxels) std::abort();
    } catch (const crn::Fault &fault) {
        if (std::strncmp(fault.what(), "fuzz:", 5) != 0) std::abort();
    }
    return 0;
}

std::size_t fuzz_seed(unsigned index, std::uint8_t *bytes, std::size_t capacity)
{
    std::vector<std::uint8_t> file = {static_cast<std::uint8_t>(index)};
    if (index < 2) {
        file.insert(file.end(), texts[index], texts[index] + std::strlen(texts[index]));
    } else if (index == 2) {
        file.resize(1 + 348);
        const auto put = [&](std::size_t at, auto value) {
            std::memcpy(file.data() + 1 + at, &value, sizeof value);
        };
        put(0, std::int32_t{348});
        for (std::size_t i = 0; i < 4; ++i) put(40 + 2 * i, static_cast<std::int16_t>(3 + i));
        for (std::size_t i = 0; i < 4; ++i) put(76 + 4 * i, 0.5f);
        put(70, std::int16_t{4}), put(72, std::int16_t{16}), put(108, 352.0f);
        file[1 + 123] = 2;
        std::memcpy(file.data() + 1 + 344, "n+1", 4);
    } else {
        return 0;
    }
    if (file.size() > capacity) return 0;
    std::copy(file.begin(), file.end(), bytes);
    return file.size();
}
