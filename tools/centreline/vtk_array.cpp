// Decodes an array of a VTK file in four steps: base64 text, header, zlib compression, numbers.
#include "tools/centreline/vtk_array.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <regex>
#include <zlib.h>

namespace crn::centreline
{
namespace
{

// Decodes base64 text in several chunks, because VTK pads the text of the header and of the data separately.
class Base64
{
  public:
    explicit Base64(std::string_view text) : text_(text) {}

    // Reads exactly `count` bytes; returns false when the text is too short or contains a letter that is not
    // base64.
    bool read(std::size_t count, std::string &bytes)
    {
        while (held_.size() < count)
            if (!quad()) return false;
        bytes.assign(held_, 0, count);
        held_.erase(0, count);
        return true;
    }

  private:
    static int value(char c)
    {
        if (c >= 'A' && c <= 'Z') return c - 'A';
        if (c >= 'a' && c <= 'z') return c - 'a' + 26;
        if (c >= '0' && c <= '9') return c - '0' + 52;
        return c == '+' ? 62 : c == '/' ? 63 : -1;
    }

    bool quad()
    {
        // The code decodes at most 4,096 groups of four letters in advance, because read() moves all
        // remaining decoded bytes whenever it removes some.
        for (int n = 0; n < 4096; ++n) {
            std::uint32_t bits = 0;
            int digits = 0, padding = 0;
            while (digits + padding < 4 && at_ < text_.size()) {
                const char c = text_[at_++];
                if (c == ' ' || c == '\n' || c == '\r' || c == '\t') continue;
                if (c == '=')
                    ++padding;
                else if (padding > 0 || value(c) < 0)
                    return false;
                else
                    bits = bits << 6 | static_cast<std::uint32_t>(value(c)), ++digits;
            }
            if (digits + padding == 0) return n > 0;
            if (digits + padding < 4 || digits < 2) return false;
            bits <<= 6 * padding;
            for (int k = 0; k < digits - 1; ++k) held_ += static_cast<char>(bits >> (16 - 8 * k) & 0xff);
        }
        return true;
    }

    std::string_view text_;
    std::size_t at_ = 0;
    std::string held_;
};

struct Type {
    const char *name;
    std::size_t bytes;
    bool is_float, is_signed;
};
constexpr Type types[] = {{"Float32", 4, true, true}, {"Float64", 8, true, true},
                          {"Int8", 1, false, true},   {"UInt8", 1, false, false},
                          {"Int16", 2, false, true},  {"UInt16", 2, false, false},
                          {"Int32", 4, false, true},  {"UInt32", 4, false, false},
                          {"Int64", 8, false, true},  {"UInt64", 8, false, false}};

std::uint64_t word_of(const char *bytes, std::size_t count, bool is_big_end_first)
{
    std::uint64_t word = 0;
    for (std::size_t i = 0; i < count; ++i)
        word |= static_cast<std::uint64_t>(
                    static_cast<unsigned char>(bytes[is_big_end_first ? count - 1 - i : i]))
                << (8 * i);
    return word;
}

double decoded(const Type &type, const char *bytes, bool is_big_end_first)
{
    const std::uint64_t word = word_of(bytes, type.bytes, is_big_end_first);
    if (type.is_float && type.bytes == 4) return std::bit_cast<float>(static_cast<std::uint32_t>(word));
    if (type.is_float) return std::bit_cast<double>(word);
    if (!type.is_signed) return static_cast<double>(word);
    const unsigned unused = static_cast<unsigned>(64 - 8 * type.bytes);
    return static_cast<double>(static_cast<std::int64_t>(word << unused) >> unused);
}

struct TwiceNamed : pugi::xml_tree_walker {
    std::string name; // the first attribute that occurs twice in one element
    bool for_each(pugi::xml_node &node) override
    {
        int count = 0;
        for (pugi::xml_attribute a = node.first_attribute(); a; a = a.next_attribute()) {
            if (++count > 64) name = a.name(); // more than any VTK file has
            for (pugi::xml_attribute b = node.first_attribute(); b != a && name.empty();
                 b = b.next_attribute())
                if (std::strcmp(a.name(), b.name()) == 0) name = a.name();
            if (!name.empty()) return false;
        }
        return true;
    }
};

// Returns true if a file begins with a correct XML declaration, or has none (W3C, "Extensible Markup Language
// 1.0", sections 2.8 and 4.3.3). The library pugixml accepts any text in place of the declaration. A
// declaration counts as correct only if its encoding represents digits as ASCII does.
bool has_correct_declaration(const pugi::xml_document &document, const std::string &text)
{
    constexpr std::size_t letters_max = 256; // a declaration of VTK has about 20
    static const std::regex correct(
        R"re(<\?xml\s+version\s*=\s*("1\.\d+"|'1\.\d+'))re"
        R"re((\s+encoding\s*=\s*("(UTF-8|utf-8|US-ASCII|ISO-8859-1)"|'(UTF-8|utf-8|US-ASCII|ISO-8859-1)'))?)re"
        R"re((\s+standalone\s*=\s*("(yes|no)"|'(yes|no)'))?\s*\?>)re");
    constexpr std::string_view byte_order_mark = "\xEF\xBB\xBF";
    std::ptrdiff_t count = 0;
    for (const pugi::xml_node &node : document) count += node.type() == pugi::node_declaration;
    if (count == 0) return true;
    const std::string head =
        text.substr(text.starts_with(byte_order_mark) ? byte_order_mark.size() : 0, letters_max);
    return count == 1 && std::regex_search(head, correct, std::regex_constants::match_continuous);
}

} // namespace

VtkFile::VtkFile(const std::string &text, const std::string &name) : name_(name)
{
    if (text.find("encoding=\"raw\"") != text.npos)
        fail("holds raw appended data, which is no XML: save it as ASCII, or with base64 (EncodeAppendedData "
             "on)");
    // Without parse_fragment, pugixml ignores text after the root element in silence.
    const pugi::xml_parse_result result = document_.load_buffer(
        text.data(), text.size(), pugi::parse_default | pugi::parse_declaration | pugi::parse_fragment);
    if (!result) {
        const auto end =
            text.begin() +
            static_cast<std::ptrdiff_t>(std::min<std::size_t>(
                static_cast<std::size_t>(std::max<std::ptrdiff_t>(result.offset, 0)), text.size()));
        throw Fault(name_ + ":" + std::to_string(std::count(text.begin(), end, '\n') + 1) +
                    ": is no XML text: " + result.description() + ": export the file again");
    }
    if (!has_correct_declaration(document_, text))
        fail("has an XML declaration that is not correct, such as <?xml version=\"1.0\"?> in the first line: "
             "export the file again");
    int roots = 0;
    for (const pugi::xml_node &node : document_) {
        roots += node.type() == pugi::node_element;
        if (roots > 1 || node.type() == pugi::node_pcdata || node.type() == pugi::node_cdata)
            fail("has text outside of its root element: the file is damaged, export it again");
    }
    // XML permits an attribute name only once in an element; if a name occurs twice, pugixml would silently
    // use the first attribute.
    TwiceNamed twice;
    if (document_.traverse(twice); !twice.name.empty())
        fail("has the attribute '" + twice.name.substr(0, 40) +
             "' twice in one element: export the file again");
    const pugi::xml_node root = document_.child("VTKFile");
    if (std::string(root.attribute("type").value()) != "PolyData")
        fail("is no VTKFile of type PolyData: save the centreline as .vtp");
    is_big_end_first_ = std::string(root.attribute("byte_order").value()) == "BigEndian";
    header_bytes_ = std::string(root.attribute("header_type").value()) == "UInt64" ? 8 : 4;
    const std::string compressor = root.attribute("compressor").value();
    is_compressed_ = !compressor.empty();
    if (is_compressed_ && compressor != "vtkZLibDataCompressor")
        fail("is compressed by " + compressor + ": save it with zlib, or uncompressed");
}

// Returns the bytes of an array that is stored in binary form. `what` is the array's name for error messages.
std::string VtkFile::bytes_of(const pugi::xml_node &array, const std::string &what) const
{
    std::string_view text = array.child_value();
    if (std::string(array.attribute("format").value()) == "appended") {
        const pugi::xml_node appended = document_.child("VTKFile").child("AppendedData");
        text = appended.child_value();
        const std::size_t mark = text.find('_');
        const auto offset = static_cast<std::size_t>(array.attribute("offset").as_ullong());
        if (mark == text.npos || offset >= text.size() - mark)
            fail(what + " lies beyond the appended data: the file is cut short, export it again");
        text.remove_prefix(mark + 1 + offset);
    }
    Base64 stream(text);
    const auto read = [&](std::size_t count) {
        std::string bytes;
        if (count > array_bytes_max || !stream.read(count, bytes))
            fail(what + " is cut short or no base64: export the file again");
        return bytes;
    };
    const auto header = [&] {
        const std::uint64_t word = word_of(read(header_bytes_).data(), header_bytes_, is_big_end_first_);
        if (word > array_bytes_max)
            fail(what + " claims to be over 256 MiB: the file is damaged, export it again");
        return static_cast<std::size_t>(word);
    };
    if (!is_compressed_) return read(header());
    const std::size_t blocks = header(), whole = header(), rest = header();
    if (blocks > 65536 || blocks * whole > array_bytes_max)
        fail(what + " claims to be over 256 MiB: the file is damaged, export it again");
    std::vector<std::size_t> packed(blocks);
    for (std::size_t &size : packed) size = header();
    std::string bytes;
    for (std::size_t b = 0; b < blocks; ++b) {
        const std::string block = read(packed[b]);
        std::string plain(b + 1 == blocks && rest > 0 ? rest : whole, '\0');
        uLongf size = static_cast<uLongf>(plain.size());
        if (::uncompress(reinterpret_cast<Bytef *>(plain.data()), &size,
                         reinterpret_cast<const Bytef *>(block.data()),
                         static_cast<uLong>(block.size())) != Z_OK ||
            size != plain.size())
            fail(what + " cannot be unpacked by zlib: the file is damaged, export it again");
        bytes += plain;
    }
    return bytes;
}

std::vector<double> VtkFile::values(const pugi::xml_node &array, std::size_t count) const
{
    const std::string title = array.attribute("Name").value(),
                      what = "array '" + title + "' (" + array.parent().name() + ")";
    const std::string format = array.attribute("format").value(), type_name = array.attribute("type").value();
    const Type *type =
        std::find_if(std::begin(types), std::end(types), [&](const Type &t) { return type_name == t.name; });
    if (type == std::end(types))
        fail(what + " is of type '" + type_name + "': use Float32, Float64, Int32 or Int64");
    std::vector<double> numbers;
    if (format == "ascii") {
        for (std::string_view word : words_of(array.child_value())) {
            numbers.push_back(number_of(word));
            if (!std::isfinite(numbers.back()))
                fail(what + " holds '" + std::string(word.substr(0, 40)) +
                     "', which is no number: correct it");
        }
    } else if (format == "binary" || format == "appended") {
        const std::string bytes = bytes_of(array, what);
        for (std::size_t at = 0; at + type->bytes <= bytes.size(); at += type->bytes) {
            numbers.push_back(decoded(*type, bytes.data() + at, is_big_end_first_));
            if (!std::isfinite(numbers.back()))
                fail(what + " holds a value that is no number: export it again");
        }
    } else {
        fail(what + " has the format '" + format + "': use ascii, binary or appended");
    }
    if (numbers.size() != count)
        fail(what + " has " + std::to_string(numbers.size()) + " values, " + std::to_string(count) +
             " are expected: the file is damaged, export it again");
    return numbers;
}

} // namespace crn::centreline
