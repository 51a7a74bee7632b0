// Checks STL and OBJ files by reading them strictly before assimp reads them. The strict reading is needed
// because assimp reads a damaged text without an error and returns a wrong mesh.
#include "tools/mesh/files/mesh_file.hpp"
#include "tools/mesh/files/mesh_words.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace crn::bake
{
namespace
{

constexpr std::size_t stl_head_bytes = 84, stl_facet_bytes = 50;
constexpr double farthest = 1e9; // of a coordinate in any unit; assimp reads numbers of 20 digits as others

std::int64_t binary_facets(std::string_view bytes)
{
    if (bytes.size() < stl_head_bytes) return -1;
    std::uint32_t count = 0;
    for (std::size_t i = 4; i > 0; --i) count = count << 8 | static_cast<unsigned char>(bytes[79 + i]);
    return count;
}

void expect(Words &words, std::string_view wanted)
{
    const std::string_view word = words.word();
    if (word != wanted)
        words.fail(shown(word) + " stands where '" + std::string(wanted) +
                   "' is expected: export the mesh again");
}

void numbers(Words &words, int count)
{
    double value = 0;
    for (int i = 0; i < count; ++i) {
        const std::string_view word = words.word();
        if (!is_number(word, value)) words.fail(shown(word) + " is no number: export the mesh again");
        if (std::fabs(value) > farthest) words.fail(shown(word) + " is too far away: export the mesh again");
    }
}

void facet(Words &words)
{
    expect(words, "normal");
    numbers(words, 3);
    expect(words, "outer");
    expect(words, "loop");
    for (int corner = 0; corner < 3; ++corner) {
        expect(words, "vertex");
        numbers(words, 3);
    }
    expect(words, "endloop");
    expect(words, "endfacet");
}

// --- OBJ ---
class Obj
{
  public:
    Obj(std::string_view bytes, const std::string &file) : words_(bytes, file) {}

    Declared check()
    {
        bool is_line = true;
        std::string joined;
        for (;;) {
            line_ = words_.line();
            std::string_view line = words_.rest_of_line(is_line);
            if (!is_line) break;
            // In an OBJ file, a line that ends with \ continues on the next line.
            while (!line.empty() && line.back() == '\\') {
                joined += std::string(line.substr(0, line.size() - 1)) + " ";
                line = words_.rest_of_line(is_line);
            }
            if (joined.empty()) {
                take(line);
            } else {
                joined += line;
                take(joined);
                joined.clear();
            }
        }
        for (const Kind &kind : kinds_)
            if (kind.highest > kind.count)
                words_.fail_at(kind.highest_line, "a face has " + std::string(kind.what) + " " +
                                                      std::to_string(kind.highest) + ", but there are " +
                                                      std::to_string(kind.count) +
                                                      " (numbered from 1): export the mesh again");
        return {-1, faces_};
    }

  private:
    struct Kind {
        const char *key, *what;
        std::int64_t count = 0, highest = 0;
        std::size_t highest_line = 0;
    };

    void take(std::string_view line)
    {
        std::size_t at = 0;
        const auto word = [&] {
            while (at < line.size() && is_blank(line[at])) ++at;
            const std::size_t begin = at;
            while (at < line.size() && !is_blank(line[at])) ++at;
            return line.substr(begin, at - begin);
        };
        const std::string_view key = word();
        for (Kind &kind : kinds_)
            if (key == kind.key) {
                ++kind.count;
                if (&kind == &kinds_[0]) point(word);
                return;
            }
        if (key != "f") return;
        std::size_t corners = 0;
        for (std::string_view corner = word(); !corner.empty() && corner[0] != '#';
             corner = word(), ++corners)
            reference(corner);
        if (corners < 3)
            words_.fail_at(line_,
                           "a face with " + std::to_string(corners) + " corners: export the mesh again");
        ++faces_;
    }

    template <class Word> void point(const Word &word) const
    {
        double value = 0;
        for (int i = 0; i < 3; ++i) {
            const std::string_view number = word();
            if (!is_number(number, value))
                words_.fail_at(line_, shown(number) +
                                          " is no coordinate: a point is v x y z; export the mesh again");
            if (std::fabs(value) > farthest)
                words_.fail_at(line_, shown(number) + " is too far away: export the mesh again");
        }
    }

    // Reads a face's corner of the form "point/texture/normal"; texture and normal are optional.
    void reference(std::string_view corner)
    {
        std::size_t begin = 0;
        for (std::size_t k = 0; k < 3 && begin <= corner.size(); ++k) {
            const std::size_t end = std::min(corner.find('/', begin), corner.size());
            const std::string_view number = corner.substr(begin, end - begin);
            begin = end + 1;
            if (number.empty() && k > 0) continue;
            std::int64_t index = 0;
            Kind &kind = kinds_[k];
            if (!is_whole(number, index) || index == 0 || index < -kind.count)
                words_.fail_at(line_, shown(corner) + " names no " + kind.what + " of the " +
                                          std::to_string(kind.count) + " before it: export the mesh again");
            if (index > kind.highest) kind.highest = index, kind.highest_line = line_;
        }
        if (begin <= corner.size())
            words_.fail_at(line_, shown(corner) + " is no corner: export the mesh again");
    }

    Words words_;
    std::size_t line_ = 1;
    std::int64_t faces_ = 0;
    Kind kinds_[3] = {{"v", "vertex"}, {"vt", "texture point"}, {"vn", "normal"}};
};

} // namespace

Declared check_stl(std::string_view bytes, const std::string &file)
{
    const std::int64_t facets = binary_facets(bytes);
    if (facets >= 0 && stl_head_bytes + stl_facet_bytes * static_cast<std::uint64_t>(facets) == bytes.size())
        return {-1, facets};
    Words words(bytes, file);
    std::string_view word = words.word();
    if (word != "solid") {
        const std::int64_t fits = static_cast<std::int64_t>(
            bytes.size() < stl_head_bytes ? 0 : (bytes.size() - stl_head_bytes) / stl_facet_bytes);
        throw Fault(file + ": cannot be read: " +
                    (facets < 0 ? "it is no STL file"
                                : "it declares " + std::to_string(facets) + " triangles, but has room for " +
                                      std::to_string(fits) + ": it is cut short or damaged") +
                    "; export the mesh again");
    }
    std::int64_t found = 0;
    for (; word == "solid"; word = words.word()) {
        bool is_line = true;
        words.rest_of_line(is_line); // its name
        for (word = words.word(); word == "facet"; word = words.word(), ++found) facet(words);
        if (word != "endsolid")
            words.fail(shown(word) +
                       " stands where 'facet' or 'endsolid' is expected: export the mesh again");
        words.rest_of_line(is_line);
    }
    if (!word.empty()) words.fail(shown(word) + " stands behind the last 'endsolid': export the mesh again");
    return {-1, found};
}

Declared check_obj(std::string_view bytes, const std::string &file)
{
    return Obj(bytes, file).check();
}

Declared check_mesh_bytes(std::string_view bytes, const std::string &file, const std::string &ending,
                          const std::filesystem::path &folder)
{
    if (ending == ".ply") return check_ply(bytes, file);
    if (ending == ".stl") return check_stl(bytes, file);
    if (ending == ".obj") return check_obj(bytes, file);
    return check_gltf(bytes, file, folder);
}

} // namespace crn::bake
