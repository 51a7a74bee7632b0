// Reads the headers of NRRD, MetaImage and NIfTI files, as specified in
// teem.sourceforge.net/nrrd/format.html, itk.org/Wiki/MetaIO/Documentation and nifti1.h.
#include "tools/lab/ct/volume/volume_declared.hpp"
#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <memory>
#include <set>
#include <vector>
#include <zlib.h>

namespace crn::ct
{

namespace
{

namespace fs = std::filesystem;

constexpr std::size_t head_bytes_max = 1 << 20;
constexpr double deflate_growth = 1040; // 1032 for its longest runs, and the trailer
constexpr double bzip2_growth = 50000;

// Holds one field of a header, with the position in the file that error messages state.
struct Field {
    const std::string &file;
    std::size_t line = 0;
    std::string name, value;

    [[noreturn]] void fail(const std::string &what) const
    {
        std::string shown;
        for (const char c : value.substr(0, 60)) shown += c >= ' ' && c <= '~' ? c : '?';
        throw Fault(file + ":" + std::to_string(line) + ": " + name + " is '" + shown + "': " + what +
                    "; export the volume again");
    }

    std::vector<std::string> words() const
    {
        std::vector<std::string> words;
        for (std::size_t at = value.find_first_not_of(" \t"); at != std::string::npos;) {
            const std::size_t end = std::min(value.find_first_of(" \t", at), value.size());
            words.push_back(value.substr(at, end - at));
            at = value.find_first_not_of(" \t", end);
        }
        return words;
    }

    double number(std::string_view word) const
    {
        double number = 0;
        if (!word.empty() && word.front() == '+') word.remove_prefix(1);
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
        if (word.empty() || error != std::errc() || end != word.data() + word.size() ||
            !std::isfinite(number))
            fail("finite numbers are needed");
        return number;
    }

    std::vector<double> numbers(std::size_t count) const
    {
        std::vector<double> numbers;
        for (const std::string &word : words()) numbers.push_back(number(word));
        if (numbers.size() != count) fail(std::to_string(count) + " numbers are needed");
        return numbers;
    }

    long whole(double low, double high) const
    {
        const double number = numbers(1)[0];
        if (number != std::floor(number) || number < low || number > high)
            fail("a whole number from " + std::to_string(long(low)) + " to " + std::to_string(long(high)) +
                 " is needed");
        return static_cast<long>(number);
    }
};

std::string small(std::string text)
{
    for (char &c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    return text;
}

std::string trimmed(std::string_view text)
{
    const std::size_t begin = text.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos) return "";
    return std::string(text.substr(begin, text.find_last_not_of(" \t\r") - begin + 1));
}

// Holds the lines of a header; each line has the form "name SEPARATOR value".
class Fields
{
  public:
    explicit Fields(const std::string &file) : file_(file) {}

    void add(std::size_t line, std::string name, std::string value)
    {
        const Field field{file_, line, name, std::move(value)};
        if (!fields_.emplace(std::move(name), field).second) field.fail("it is given twice");
    }
    const Field *find(const std::string &name) const
    {
        const auto found = fields_.find(name);
        return found == fields_.end() ? nullptr : &found->second;
    }
    const Field &need(const std::string &name) const
    {
        if (const Field *field = find(name)) return *field;
        throw Fault(file_ + ": its header has no '" + name +
                    "', so that its size or scale is unknown: export the volume again");
    }

  private:
    const std::string &file_;
    std::map<std::string, Field> fields_;
};

void take_size(DeclaredVolume &declared, const Field &field, std::size_t axes, std::uint64_t each_bytes)
{
    const std::vector<double> sizes = field.numbers(axes);
    double values = 1;
    for (std::size_t axis = 0; axis < axes; ++axis) {
        if (sizes[axis] != std::floor(sizes[axis]) || sizes[axis] < 1 || sizes[axis] > 1e6)
            field.fail("whole numbers from 1 to 1000000 are needed");
        if (axis >= 3 && sizes[axis] > 1)
            field.fail("there are " + std::to_string(long(sizes[axis])) +
                       " volumes in one file, of which one is needed");
        if (axis < 3) declared.size[axis] = static_cast<long>(sizes[axis]);
        values *= sizes[axis];
    }
    declared.value_bytes = static_cast<std::uint64_t>(values * static_cast<double>(each_bytes));
}

void take_spacing(DeclaredVolume &declared, const Field &field, const std::vector<double> &spacing_mm)
{
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!(spacing_mm[axis] > 0 && spacing_mm[axis] < 1e6)) field.fail("spacings above 0 mm are needed");
        declared.spacing_mm[static_cast<Eigen::Index>(axis)] = spacing_mm[axis];
    }
}

// --- NRRD ---
std::uint64_t nrrd_bytes(const Field &type)
{
    static const std::map<std::string, std::uint64_t> stems = {
        {"char", 1},  {"int8", 1}, {"short", 2}, {"int16", 2}, {"int", 4},
        {"int32", 4}, {"long", 8}, {"int64", 8}, {"float", 4}, {"double", 8}};
    std::string name = small(type.value);
    if (name == "longlong" || name == "long long" || name == "long long int" || name == "signed long long" ||
        name == "signed long long int" || name == "ulonglong" || name == "unsigned long long" ||
        name == "unsigned long long int")
        return 8;
    for (const char *prefix : {"signed ", "unsigned "})
        if (name.rfind(prefix, 0) == 0) name.erase(0, std::strlen(prefix));
    if (name.size() > 1 && name[0] == 'u') name.erase(0, 1);
    if (name.ends_with(" int")) name.erase(name.size() - 4);
    if (name.ends_with("_t")) name.erase(name.size() - 2);
    const auto found = stems.find(name);
    if (found == stems.end() || name == "long") type.fail("no type of NRRD that holds Hounsfield units");
    return found->second;
}

// "(1,0,0)"
std::vector<double> nrrd_vector(const Field &field, const std::string &word)
{
    if (word.size() < 2 || word.front() != '(' || word.back() != ')')
        field.fail("a vector (x,y,z) is needed for every axis, 'none' gives no scale");
    std::vector<double> numbers;
    for (std::size_t at = 1; at < word.size();) {
        const std::size_t end = std::min(word.find(',', at), word.size() - 1);
        numbers.push_back(field.number(trimmed(word.substr(at, end - at))));
        at = end + 1;
    }
    if (numbers.size() != 3) field.fail("three numbers are needed in every vector");
    return numbers;
}

// Blanks within brackets do not separate values.
Field without_inner_blanks(Field field)
{
    int depth = 0;
    std::string value;
    for (const char c : field.value) {
        depth += c == '(' ? 1 : c == ')' ? -1 : 0;
        if (depth == 0 || (c != ' ' && c != '\t')) value += c;
    }
    field.value = value;
    return field;
}

void nrrd_scale(DeclaredVolume &declared, const Fields &fields)
{
    if (const Field *units = fields.find("space units"))
        if (units->value.find_first_not_of(" \t\"m") != std::string::npos ||
            std::count(units->value.begin(), units->value.end(), 'm') != 6)
            units->fail("give \"mm\" \"mm\" \"mm\"");
    const Field *directions = fields.find("space directions"), *spacings = fields.find("spacings");
    if (!directions) {
        const Field &field = fields.need("spacings");
        take_spacing(declared, field, field.numbers(3));
        return;
    }
    if (spacings) spacings->fail("space directions are there as well, of which only one may be");
    const Field field = without_inner_blanks(*directions);
    std::vector<double> spacing_mm;
    for (const std::string &word : field.words()) {
        const std::vector<double> v = nrrd_vector(field, word);
        spacing_mm.push_back(std::hypot(v[0], v[1], v[2]));
    }
    if (spacing_mm.size() != 3) field.fail("three vectors are needed");
    take_spacing(declared, field, spacing_mm);
    if (const Field *origin = fields.find("space origin"))
        nrrd_vector(*origin, without_inner_blanks(*origin).words().empty()
                                 ? ""
                                 : without_inner_blanks(*origin).words()[0]);
}

// --- MetaImage ---
std::uint64_t meta_bytes(const Field &type)
{
    static const std::map<std::string, std::uint64_t> types = {
        {"MET_CHAR", 1},      {"MET_UCHAR", 1},      {"MET_SHORT", 2}, {"MET_USHORT", 2},
        {"MET_INT", 4},       {"MET_UINT", 4},       {"MET_LONG", 4},  {"MET_ULONG", 4},
        {"MET_LONG_LONG", 8}, {"MET_ULONG_LONG", 8}, {"MET_FLOAT", 4}, {"MET_DOUBLE", 8}};
    const auto found = types.find(type.value);
    if (found == types.end()) type.fail("no type that holds Hounsfield units");
    return found->second;
}

bool is_true(const Field *field)
{
    if (!field) return false;
    const std::string value = small(field->value);
    if (value == "true" || value == "t" || value == "1") return true;
    if (value == "false" || value == "f" || value == "0") return false;
    field->fail("True or False is needed");
}

// --- NIfTI ---

// Reads the numbers of a binary header in either byte order.
struct Binary {
    std::string_view head;
    bool is_swapped = false;

    template <class Value> Value at(std::size_t place) const
    {
        std::array<char, sizeof(Value)> bytes;
        std::copy_n(head.begin() + static_cast<std::ptrdiff_t>(place), sizeof(Value), bytes.begin());
        if (is_swapped) std::reverse(bytes.begin(), bytes.end());
        return std::bit_cast<Value>(bytes);
    }
};

std::uint64_t nifti_bytes(int type)
{
    switch (type) {
    case 2:
    case 256:
        return 1;
    case 4:
    case 512:
        return 2;
    case 8:
    case 16:
    case 768:
        return 4;
    case 64:
    case 1024:
    case 1280:
        return 8;
    default:
        return 0;
    }
}

std::string first_bytes(const fs::path &path)
{
    // If a file is not compressed, zlib returns its bytes unchanged.
    const std::unique_ptr<gzFile_s, int (*)(gzFile)> packed(
        small(path.string()).ends_with(".gz") ? gzopen(path.c_str(), "rb") : nullptr, gzclose);
    std::string head(head_bytes_max, '\0');
    if (packed) {
        const int got = gzread(packed.get(), head.data(), 1 << 12);
        head.resize(static_cast<std::size_t>(std::max(got, 0)));
        return head;
    }
    std::ifstream stream(path, std::ios::binary);
    stream.read(head.data(), static_cast<std::streamsize>(head.size()));
    head.resize(static_cast<std::size_t>(std::max<std::streamsize>(stream.gcount(), 0)));
    return head;
}

// Checks that compressed values can be decompressed, and that their number and checksum agree with the file;
// ITK does not check this.
void check_packed(const DeclaredVolume &declared, std::uint64_t bytes, const fs::path &data,
                  const std::string &file)
{
    std::ifstream stream(data, std::ios::binary);
    stream.seekg(static_cast<std::streamoff>(declared.data_file.empty() ? declared.head_bytes : 0));
    z_stream zip{};
    if (inflateInit2(&zip, 15 + 32) != Z_OK) throw std::bad_alloc(); // accepts zlib and gzip
    const std::unique_ptr<z_stream, int (*)(z_stream *)> ended(&zip, inflateEnd);
    std::vector<unsigned char> in(1 << 16), out(1 << 16);
    std::uint64_t unpacked = 0;
    int result = Z_OK;
    while (result == Z_OK) {
        if (zip.avail_in == 0) {
            stream.read(reinterpret_cast<char *>(in.data()), static_cast<std::streamsize>(in.size()));
            zip.next_in = in.data(), zip.avail_in = static_cast<unsigned>(stream.gcount());
        }
        zip.next_out = out.data(), zip.avail_out = static_cast<unsigned>(out.size());
        result = inflate(&zip, Z_NO_FLUSH);
        unpacked += out.size() - zip.avail_out;
    }
    if (result != Z_STREAM_END || unpacked != bytes)
        throw Fault(file + ": is truncated or damaged: of the " + std::to_string(bytes) +
                    " bytes that its header promises " + std::to_string(unpacked) +
                    (result == Z_STREAM_END ? " are there" : " can be unpacked") +
                    ": copy or export it again");
    if (declared.packed_bytes > 0 && declared.packed_bytes != zip.total_in)
        throw Fault(file + ": its CompressedDataSize is " + std::to_string(declared.packed_bytes) +
                    ", but its compressed values have " + std::to_string(zip.total_in) +
                    " bytes: copy or export it again");
}

} // namespace

DeclaredVolume declared_nrrd(std::string_view head, const std::string &file)
{
    Fields fields(file);
    DeclaredVolume declared;
    if (head.substr(0, 7) != "NRRD000" || head.size() < 8 || head[7] < '1' || head[7] > '5')
        throw Fault(file +
                    ": does not begin with NRRD0001 to NRRD0005, so it is no NRRD file: export it again");
    std::size_t line = 0;
    for (std::size_t at = 0; at < head.size(); ++line) {
        const std::size_t end = std::min(head.find('\n', at), head.size());
        const std::string text = trimmed(head.substr(at, end - at));
        at = std::min(end + 1, head.size());
        declared.head_bytes = at;
        if (line == 0 || (!text.empty() && text[0] == '#')) continue;
        if (text.empty()) break;
        const std::size_t colon = text.find(": "), key = text.find(":=");
        if (key < colon) continue; // a note of the exporter
        if (colon == std::string::npos && text.back() != ':')
            throw Fault(file + ":" + std::to_string(line + 1) +
                        ": is no line of a NRRD header: export the volume again");
        const std::size_t border = std::min(colon, text.size() - 1);
        fields.add(line + 1, small(trimmed(text.substr(0, border))), trimmed(text.substr(border + 1)));
    }
    const Field &dimension = fields.need("dimension");
    if (dimension.whole(1, 16) != 3) dimension.fail("one volume with one value per voxel has 3");
    take_size(declared, fields.need("sizes"), 3, nrrd_bytes(fields.need("type")));
    nrrd_scale(declared, fields);
    const std::string encoding = small(fields.need("encoding").value);
    declared.is_deflated = encoding == "gzip" || encoding == "gz";
    if (declared.is_deflated) declared.bytes_per_file_byte = deflate_growth;
    for (const char *name : {"line skip", "lineskip", "byte skip", "byteskip"})
        if (const Field *skip = fields.find(name); skip && skip->whole(-1, 1e9) != 0)
            declared.is_deflated = false;
    if (encoding == "bzip2" || encoding == "bz2") declared.bytes_per_file_byte = bzip2_growth;
    if (encoding == "ascii" || encoding == "txt" || encoding == "text")
        declared.bytes_per_file_byte = 4; // "0 " for a value of 8 bytes
    for (const char *name : {"data file", "datafile"})
        if (const Field *data = fields.find(name)) {
            declared.data_file = data->value;
            declared.is_many_files = data->value.find(' ') != std::string::npos || data->value == "LIST";
        }
    return declared;
}

DeclaredVolume declared_meta(std::string_view head, const std::string &file)
{
    Fields fields(file);
    DeclaredVolume declared;
    std::size_t line = 0;
    for (std::size_t at = 0; at < head.size() && !fields.find("ElementDataFile");) {
        const std::size_t end = std::min(head.find('\n', at), head.size());
        const std::string text = trimmed(head.substr(at, end - at));
        at = std::min(end + 1, head.size());
        declared.head_bytes = at;
        ++line;
        if (text.empty()) continue;
        const std::size_t border = text.find('=');
        if (border == std::string::npos)
            throw Fault(file + ":" + std::to_string(line) +
                        ": is no line 'name = value' of a MetaImage: export the volume again");
        fields.add(line, trimmed(text.substr(0, border)), trimmed(text.substr(border + 1)));
    }
    const auto axes = static_cast<std::size_t>(fields.need("NDims").whole(3, 4));
    if (const Field *channels = fields.find("ElementNumberOfChannels"))
        if (channels->whole(1, 1000) != 1)
            channels->fail("one value per voxel is needed, in Hounsfield units");
    take_size(declared, fields.need("DimSize"), axes, meta_bytes(fields.need("ElementType")));
    take_spacing(declared, fields.need("ElementSpacing"), fields.need("ElementSpacing").numbers(axes));
    if (const Field *units = fields.find("DistanceUnits"))
        if (small(units->value) != "mm") units->fail("mm is needed");
    std::set<std::string> given;
    for (const char *name : {"TransformMatrix", "Rotation", "Orientation"})
        if (const Field *field = fields.find(name)) field->numbers(axes * axes), given.insert(name);
    for (const char *name : {"Offset", "Position", "Origin"})
        if (const Field *field = fields.find(name)) field->numbers(axes);
    if (given.size() > 1) fields.need(*given.begin()).fail("the axes are given twice, under two names");
    declared.is_deflated = is_true(fields.find("CompressedData"));
    if (declared.is_deflated) {
        declared.bytes_per_file_byte = deflate_growth;
        // Without it, ITK reads zeros.
        declared.packed_bytes = static_cast<std::uint64_t>(fields.need("CompressedDataSize").whole(1, 1e12));
    }
    if (const Field *binary = fields.find("BinaryData"))
        if (!is_true(binary)) declared.bytes_per_file_byte = 4;
    const Field &data = fields.need("ElementDataFile");
    if (data.value != "LOCAL" && data.value != "Local" && data.value != "local") {
        declared.data_file = data.value;
        declared.is_many_files =
            data.value.rfind("LIST", 0) == 0 || data.value.find('%') != std::string::npos;
    }
    return declared;
}

DeclaredVolume declared_nifti(std::string_view head, const std::string &file)
{
    constexpr std::size_t head_bytes = 348;
    const auto fail = [&](const std::string &what) {
        throw Fault(file + ": " + what + ": export the volume again");
    };
    if (head.size() < head_bytes)
        fail("is truncated: its header has " + std::to_string(head.size()) + " of 348 bytes");
    Binary binary{head};
    if (binary.at<std::int32_t>(0) != 348) binary.is_swapped = true;
    if (binary.at<std::int32_t>(0) != 348) fail("has no header of NIfTI-1");
    if (head.substr(344, 3) != "n+1" || head[347] != '\0') fail("is no NIfTI-1 file with its values in it");
    DeclaredVolume declared;
    const int axes = binary.at<std::int16_t>(40), type = binary.at<std::int16_t>(70);
    if (axes < 3 || axes > 7) fail("has " + std::to_string(axes) + " axes, a volume has 3");
    const std::uint64_t each = nifti_bytes(type);
    if (each == 0 || static_cast<std::uint64_t>(binary.at<std::int16_t>(72)) != 8 * each)
        fail("has values of type " + std::to_string(type) + " with " +
             std::to_string(binary.at<std::int16_t>(72)) + " bits, which hold no Hounsfield units");
    declared.has_place = binary.at<std::int16_t>(252) > 0 || binary.at<std::int16_t>(254) > 0;
    declared.value_bytes = each;
    for (int axis = 0; axis < axes; ++axis) {
        const auto place = static_cast<std::size_t>(axis);
        const long size = binary.at<std::int16_t>(42 + 2 * place);
        if (size < 1) fail("has " + std::to_string(size) + " voxels along axis " + std::to_string(axis + 1));
        if (axis >= 3 && size > 1)
            fail("has " + std::to_string(size) + " volumes in one file, of which one is needed");
        if (axis >= 3) continue;
        declared.size[place] = size;
        declared.value_bytes *= static_cast<std::uint64_t>(size);
        const int unit = head[123] & 7; // 1 m, 2 mm, 3 um; 0 counts as mm
        const double unit_mm = unit == 1 ? 1000 : unit == 3 ? 1e-3 : 1;
        const double spacing_mm = unit_mm * double(binary.at<float>(80 + 4 * place));
        if (!(std::isfinite(spacing_mm) && spacing_mm > 0))
            fail("has a spacing of " + std::to_string(spacing_mm) + " mm along axis " +
                 std::to_string(axis + 1));
        declared.spacing_mm[axis] = spacing_mm;
    }
    const double offset = double(binary.at<float>(108));
    if (!(offset >= 348 && offset < 1e6)) fail("has its values at byte " + std::to_string(offset));
    declared.head_bytes = static_cast<std::uint64_t>(offset);
    return declared;
}

DeclaredVolume declared_volume(const fs::path &path)
{
    const std::string file = path.string(), name = small(path.filename().string());
    const std::string head = first_bytes(path);
    DeclaredVolume declared =
        name.find(".nrrd") != std::string::npos || name.find(".nhdr") != std::string::npos
            ? declared_nrrd(head, file)
        : name.find(".nii") != std::string::npos ? declared_nifti(head, file)
                                                 : declared_meta(head, file);
    std::uint64_t packed_bytes = declared.value_bytes;
    if (name.ends_with(".gz")) { // bytes_per_file_byte includes its header
        packed_bytes += declared.head_bytes;
        declared.bytes_per_file_byte = deflate_growth;
        declared.is_deflated = true;
        declared.head_bytes = 0;
    }
    if (declared.is_many_files) return declared;
    const fs::path data = declared.data_file.empty() ? path : path.parent_path() / declared.data_file;
    std::error_code error;
    const auto bytes = fs::is_regular_file(data, error) ? fs::file_size(data, error) : 0;
    if (error || bytes == 0)
        throw Fault(file + ": its values are in " + data.string() +
                    ", which cannot be read: keep both together");
    const std::uint64_t before = declared.data_file.empty() ? declared.head_bytes : 0;
    const double there =
        static_cast<double>(bytes < before ? 0 : bytes - before) * declared.bytes_per_file_byte;
    if (there < static_cast<double>(declared.value_bytes))
        throw Fault(file + ": is truncated: its header promises " + std::to_string(declared.value_bytes) +
                    " bytes of values, " + data.string() + " has room for " +
                    std::to_string(static_cast<std::uint64_t>(there)) + ": copy or export it again");
    if (declared.is_deflated) check_packed(declared, packed_bytes, data, file);
    return declared;
}

void check_agreement(const DeclaredVolume &declared, const std::array<long, 3> &size,
                     const Eigen::Vector3d &spacing_mm, const std::string &file)
{
    const bool is_alike =
        (spacing_mm - declared.spacing_mm).cwiseAbs().maxCoeff() <= 1e-4 * declared.spacing_mm.maxCoeff();
    if (size == declared.size && is_alike) return;
    const auto text = [](const std::array<long, 3> &n, const Eigen::Vector3d &mm) {
        std::string line;
        for (std::size_t axis = 0; axis < 3; ++axis)
            line += (axis ? " x " : "") + std::to_string(n[axis]) + " of " +
                    std::to_string(mm[static_cast<Eigen::Index>(axis)]) + " mm";
        return line;
    };
    throw Fault(file + ": its header declares " + text(declared.size, declared.spacing_mm) +
                ", its reader understands " + text(size, spacing_mm) + ": export the volume again, as .nrrd");
}

} // namespace crn::ct
