// Checks that the header of a PLY file agrees with its data. The code first reads the header, and then the
// data element by element.
#include "tools/mesh/files/mesh_file.hpp"
#include "tools/mesh/files/mesh_words.hpp"

#include <bit>
#include <cstring>
#include <utility>

namespace crn::bake
{
namespace
{

constexpr std::size_t header_bytes_max = 1 << 16;
constexpr std::size_t corners_max = 65536; // of one face

struct Type {
    const char *name, *other;
    std::size_t bytes;
    bool is_signed, is_float;
};
constexpr Type types[] = {{"char", "int8", 1, true, false},    {"uchar", "uint8", 1, false, false},
                          {"short", "int16", 2, true, false},  {"ushort", "uint16", 2, false, false},
                          {"int", "int32", 4, true, false},    {"uint", "uint32", 4, false, false},
                          {"float", "float32", 4, true, true}, {"double", "float64", 8, true, true}};

struct Property {
    const Type *type = nullptr, *count = nullptr; // count: of a list
    std::string name;
    bool is_corners = false;
};

struct Element {
    std::string name;
    std::int64_t count = 0;
    std::vector<Property> properties;
    bool is_vertex() const { return name == "vertex"; }
    bool is_face() const { return name == "face"; }
};

const Type *type_of(std::string_view word, const Words &words)
{
    for (const Type &type : types)
        if (word == type.name || word == type.other) return &type;
    words.fail("no type of PLY is called " + shown(word) + ": export the mesh again");
}

// The whole number in these bytes, at most eight.
std::uint64_t word_of(std::string_view bytes, bool is_big_end_first)
{
    std::uint64_t word = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i) {
        const std::size_t at = is_big_end_first ? bytes.size() - 1 - i : i;
        word |= std::uint64_t{static_cast<unsigned char>(bytes[at])} << (8 * i);
    }
    return word;
}

class Header
{
  public:
    Header(std::string_view bytes, const std::string &file) : words_(bytes.substr(0, header_bytes_max), file)
    {
        bool is_line = true;
        if (words_.rest_of_line(is_line) != "ply") words_.fail_at(1, "is no PLY file: export the mesh again");
        for (std::string_view line; (line = words_.rest_of_line(is_line), is_line);) {
            Words own(line, file, words_.line() - 1);
            const std::string_view key = own.word();
            if (key == "end_header") {
                finish(own);
                return;
            }
            if (key == "format")
                format(own);
            else if (key == "element")
                element(own);
            else if (key == "property")
                property(own);
            else if (key != "comment" && key != "obj_info" && !key.empty())
                own.fail(shown(key) + " is no keyword of a PLY header: export the mesh again");
        }
        words_.fail("has no end_header: export the mesh again");
    }

    bool is_ascii = false, is_big_end_first = false;
    std::vector<Element> elements;
    std::size_t bytes() const { return words_.at(); }
    std::size_t lines() const { return words_.line(); }
    std::int64_t count(bool (Element::*is_wanted)() const) const
    {
        for (const Element &e : elements)
            if ((e.*is_wanted)()) return e.count;
        return -1;
    }

  private:
    void format(Words &own)
    {
        const std::string_view name = own.word();
        is_ascii = name == "ascii", is_big_end_first = name == "binary_big_endian";
        has_format_ = is_ascii || is_big_end_first || name == "binary_little_endian";
        if (!has_format_) own.fail("the format " + shown(name) + " is unknown: export the mesh again");
    }
    void element(Words &own)
    {
        Element made;
        made.name = own.word();
        const std::string_view count = own.word();
        if (!is_whole(count, made.count) || made.count < 0 || made.count > 1'000'000'000)
            own.fail("declares " + shown(count) + " of element " + shown(made.name) +
                     ": no mesh has so many; export it again");
        for (const Element &e : elements)
            if (e.name == made.name) own.fail("declares element " + shown(made.name) + " twice");
        if (elements.size() == 64) own.fail("declares over 64 elements: export the mesh alone");
        elements.push_back(made);
    }
    void property(Words &own)
    {
        if (elements.empty()) own.fail("has a property before the first element: export the mesh again");
        if (elements.back().properties.size() == 256)
            own.fail("declares over 256 properties: export the mesh alone");
        Property made;
        std::string_view word = own.word();
        if (word == "list") {
            made.count = type_of(own.word(), own);
            if (made.count->is_float) own.fail("counts a list by broken numbers: export the mesh again");
            word = own.word();
        }
        made.type = type_of(word, own);
        const std::string_view name = own.word();
        made.name = name;
        for (const Property &p : elements.back().properties)
            if (p.name == made.name) own.fail("declares property " + shown(name) + " twice");
        made.is_corners = name == "vertex_indices" || name == "vertex_index";
        if (made.is_corners && (!made.count || made.type->is_float))
            own.fail("has " + std::string(name) +
                     " that are no list of whole numbers: export the mesh again");
        elements.back().properties.push_back(made);
    }
    void finish(const Words &own) const
    {
        if (!has_format_) own.fail("does not say its format: export the mesh again");
        for (const auto &[element, name] : {std::pair{"vertex", "x"}, {"vertex", "y"}, {"vertex", "z"}})
            if (!has(element, name, false))
                own.fail("the header declares no property " + std::string(name) +
                         " of element vertex: export the mesh again");
        if (!has("face", "vertex_indices", true) && !has("face", "vertex_index", true))
            own.fail("the header declares no element face with the list vertex_indices: export the surface "
                     "as triangles");
    }

    bool has(std::string_view element, std::string_view property, bool is_list) const
    {
        for (const Element &e : elements)
            for (const Property &p : e.properties)
                if (e.name == element && p.name == property && (p.count != nullptr) == is_list) return true;
        return false;
    }

    Words words_;
    bool has_format_ = false;
};

// Reads the numbers of one record of a PLY file, which is stored as text or in binary form.
class Body
{
  public:
    Body(std::string_view bytes, const Header &header, const std::string &file)
        : bytes_(bytes.substr(header.bytes())), words_(bytes_, file, header.lines()), header_(header),
          file_(file)
    {
    }

    void check()
    {
        for (const Element &element : header_.elements) check(element);
        if (header_.is_ascii) {
            if (!words_.word().empty())
                words_.fail("holds more than its header declares: the counts are wrong; export it again");
            return;
        }
        while (at_ < bytes_.size() && is_blank(bytes_[at_])) ++at_;
        if (at_ < bytes_.size())
            fail("has " + std::to_string(bytes_.size() - at_) +
                 " bytes more than its header declares: the counts are wrong; export it again");
    }

  private:
    [[noreturn]] void fail(const std::string &what) const
    {
        throw Fault(file_ + ": cannot be read: " + what);
    }

    void check(const Element &element)
    {
        // The smallest possible size of a record is the sum of the sizes of its numbers. In a text file each
        // number takes at least a digit and a blank.
        std::size_t least = 0;
        bool has_list = false;
        for (const Property &p : element.properties) {
            least += header_.is_ascii ? 2 : (p.count ? p.count : p.type)->bytes;
            has_list |= p.count != nullptr;
        }
        const std::size_t left = bytes_.size() - at() + 1, count = static_cast<std::size_t>(element.count);
        if (count > 0 && (least == 0 || count > left / least))
            fail("declares " + std::to_string(count) + " of element " + shown(element.name) + ", but only " +
                 std::to_string(left - 1) +
                 " bytes are left for them: the file is cut short or damaged; export it again");
        if (!has_list && !header_.is_ascii) {
            at_ += least * count;
            return;
        }
        for (record_ = 0; record_ < element.count; ++record_)
            for (const Property &p : element.properties) check(element, p);
    }

    void check(const Element &element, const Property &p)
    {
        if (!p.count) {
            number(*p.type, element);
            return;
        }
        const std::int64_t count = number(*p.count, element);
        if (count < 0 || count > static_cast<std::int64_t>(corners_max))
            fail(shown(element.name) + " " + std::to_string(record_) + " has a list of " +
                 std::to_string(count) + " numbers: export the mesh again");
        if (!p.is_corners && !header_.is_ascii)
            return skip(static_cast<std::size_t>(count) * p.type->bytes, element);
        const std::int64_t vertices = header_.count(&Element::is_vertex);
        for (std::int64_t k = 0; k < count; ++k) {
            const std::int64_t corner = number(*p.type, element);
            if (p.is_corners && element.is_face() && (corner < 0 || corner >= vertices))
                fail("face " + std::to_string(record_) + " has vertex " + std::to_string(corner) +
                     ", but there are " + std::to_string(std::max<std::int64_t>(vertices, 0)) +
                     " (numbered from 0): export the mesh again");
        }
    }

    std::size_t at() const { return header_.is_ascii ? words_.at() : at_; }

    void skip(std::size_t bytes, const Element &element)
    {
        if (bytes > bytes_.size() - at_)
            fail("ends within " + shown(element.name) + " " + std::to_string(record_) + " of " +
                 std::to_string(element.count) + ": the file is cut short; export it again");
        at_ += bytes;
    }

    // Returns the number if its type is a whole number; a number of any other type is only checked, and the
    // function returns 0.
    std::int64_t number(const Type &type, const Element &element)
    {
        if (header_.is_ascii) return number_of_text(type, element);
        const std::size_t begin = at_;
        skip(type.bytes, element);
        if (type.is_float) return 0;
        const std::uint64_t word = word_of(bytes_.substr(begin, type.bytes), header_.is_big_end_first);
        const unsigned unused = static_cast<unsigned>(64 - 8 * type.bytes);
        return type.is_signed ? static_cast<std::int64_t>(word << unused) >> unused
                              : static_cast<std::int64_t>(word);
    }

    std::int64_t number_of_text(const Type &type, const Element &element)
    {
        const std::string_view word = words_.word();
        if (word.empty())
            fail("ends within " + shown(element.name) + " " + std::to_string(record_) + " of " +
                 std::to_string(element.count) + ": the file is cut short; export it again");
        std::int64_t whole = 0;
        double value = 0;
        const std::int64_t most =
            (std::int64_t{1} << (8 * std::min<std::size_t>(type.bytes, 4) - type.is_signed)) - 1;
        if (!type.is_float && is_whole(word, whole) && whole <= most &&
            whole >= (type.is_signed ? -most - 1 : 0))
            return whole;
        if (type.is_float && is_number(word, value)) return 0;
        words_.fail(shown(word) + " in " + shown(element.name) + " " + std::to_string(record_) +
                    " is no number of type " + type.name + ": the file is damaged; export it again");
    }

    std::string_view bytes_;
    Words words_;
    const Header &header_;
    const std::string &file_;
    std::size_t at_ = 0;
    std::int64_t record_ = 0;
};

} // namespace

namespace
{

// The number in the first bytes of the data.
double first_number(std::string_view data, const Type &type, bool is_big_end_first)
{
    const std::uint64_t word = word_of(data.substr(0, type.bytes), is_big_end_first);
    return type.bytes == 8 ? std::bit_cast<double>(word)
                           : static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(word)));
}

} // namespace

PlyStart ply_start(std::string_view bytes, const std::string &file)
{
    const Header header(bytes, file);
    const std::size_t begin = header.bytes();
    const Element &first = header.elements.front();
    const bool is_number = first.is_vertex() && first.count > 0 && !first.properties.front().count &&
                           first.properties.front().type->is_float && first.properties.front().name == "x";
    if (header.is_ascii || !is_number || (bytes[begin] != '\n' && bytes[begin] != '\r')) return {};
    PlyStart start{std::string(bytes), first_number(bytes.substr(begin), *first.properties.front().type,
                                                    header.is_big_end_first)};
    ++start.changed[begin];
    return start;
}

Declared check_ply(std::string_view bytes, const std::string &file)
{
    const Header header(bytes, file);
    Body(bytes, header, file).check();
    return {header.count(&Element::is_vertex), header.count(&Element::is_face)};
}

} // namespace crn::bake
