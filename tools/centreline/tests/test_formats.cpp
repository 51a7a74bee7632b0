// These tests check the following. A tree is unchanged after writing and reading in every format, and VTK's
// encodings can be read. For a file that holds no tree, the message is one sentence that names the file and
// line. The test writes and reads trees, reads arrays that this file encodes as VTK does, and reads files
// that are damaged at random positions.
#include "host/base/pending_file.hpp"
#include "tools/centreline/tests/trees.hpp"

#include <cstdlib>
#include <cstring>
#include <random>
#include <zlib.h>

using namespace crn::centreline;
using namespace crn::centreline::tests;

namespace
{

void every_format_gives_back_the_tree_it_was_given(void **)
{
    const Tree tree = y_tree();
    assert_same_tree(read_csv(csv_text(tree), "t"), tree);
    assert_same_tree(read_markups(markups_text(tree), "t"), tree, false); // the format has no speed
    assert_same_tree(read_polydata(polydata_text(tree), "t"), tree);
    const Tree lines = read_polyline(polyline_text(tree), "t");
    assert_int_equal(lines.branches[2].parent, 0);
    assert_int_equal(lines.branches[2].parent_sphere, 5);
    assert_true((lines.branches[1].spheres[3].centre_mm - tree.branches[1].spheres[3].centre_mm).norm() <
                1e-5);
    assert_true(std::abs(lines.branches[1].spheres[3].radius_mm - tree.branches[1].spheres[3].radius_mm) <
                1e-5);
}

std::string base64(const std::string &bytes)
{
    static const char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t bits = 0;
        for (std::size_t k = 0; k < 3; ++k)
            bits = bits << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0);
        for (std::size_t k = 0; k < 4; ++k)
            text += i + k > bytes.size() ? '=' : letters[bits >> (18 - 6 * k) & 63];
    }
    return text;
}

template <typename T> std::string bytes_of(const std::vector<T> &values)
{
    return std::string(reinterpret_cast<const char *>(values.data()), values.size() * sizeof(T));
}

// Encodes an array as vtkXMLWriter does. The encoded array is either one base64 text of header and data, or a
// base64 header followed by the compressed blocks.
std::string packed(const std::string &bytes, bool is_zlib)
{
    if (!is_zlib) return base64(bytes_of<std::uint32_t>({static_cast<std::uint32_t>(bytes.size())}) + bytes);
    constexpr std::size_t block = 40; // small, so that there are several blocks and a shorter last one
    std::vector<std::uint32_t> header = {static_cast<std::uint32_t>((bytes.size() + block - 1) / block),
                                         block, static_cast<std::uint32_t>(bytes.size() % block)};
    std::string data;
    for (std::size_t at = 0; at < bytes.size(); at += block) {
        const std::string piece = bytes.substr(at, block);
        std::string out(200, '\0');
        uLongf size = out.size();
        assert_int_equal(compress(reinterpret_cast<Bytef *>(out.data()), &size,
                                  reinterpret_cast<const Bytef *>(piece.data()), piece.size()),
                         Z_OK);
        header.push_back(static_cast<std::uint32_t>(size));
        data += out.substr(0, size);
    }
    return base64(bytes_of(header)) + base64(data);
}

// Makes the text of a file with a line of three points, in the form that VMTK writes.
std::string vmtk_file(bool is_zlib, bool is_appended)
{
    std::string appended;
    const auto array = [&](const std::string &type, const std::string &name, int components,
                           const std::string &bytes) {
        const std::string text = packed(bytes, is_zlib);
        std::string head = "<DataArray type=\"" + type + "\" Name=\"" + name + "\" NumberOfComponents=\"" +
                           std::to_string(components) + "\" ";
        if (!is_appended) return head + "format=\"binary\">\n" + text + "\n</DataArray>\n";
        head += "format=\"appended\" offset=\"" + std::to_string(appended.size()) + "\"/>\n";
        appended += text;
        return head;
    };
    std::string file =
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"0.1\" byte_order=\"LittleEndian\"" +
        std::string(is_zlib ? " compressor=\"vtkZLibDataCompressor\"" : "") +
        ">\n<PolyData>\n<Piece NumberOfPoints=\"3\" NumberOfLines=\"1\">\n<PointData>\n";
    file += array("Float64", "MaximumInscribedSphereRadius", 1, bytes_of<double>({3.5, 3.25, 3.0}));
    file += "</PointData>\n<Points>\n" +
            array("Float32", "Points", 3, bytes_of<float>({0, 0, 0, 0, 1.5f, 0, 0, 3, 0.25f})) +
            "</Points>\n<Lines>\n" + array("Int64", "connectivity", 1, bytes_of<std::int64_t>({0, 1, 2})) +
            array("Int64", "offsets", 1, bytes_of<std::int64_t>({3})) + "</Lines>\n</Piece>\n</PolyData>\n";
    if (is_appended) file += "<AppendedData encoding=\"base64\">\n_" + appended + "\n</AppendedData>\n";
    return file + "</VTKFile>\n";
}

void base64_and_zlib_of_vtk_are_read(void **)
{
    for (bool is_zlib : {false, true})
        for (bool is_appended : {false, true}) {
            const Tree tree = read_polydata(vmtk_file(is_zlib, is_appended), "v.vtp");
            assert_int_equal(tree.branches.size(), 1);
            assert_int_equal(tree.branches[0].spheres.size(), 3);
            assert_true(tree.branches[0].spheres[1].radius_mm == 3.25);
            assert_true(tree.branches[0].spheres[2].centre_mm == Eigen::Vector3d(0, 3, 0.25));
        }
}

void faults_name_place_and_remedy(void **)
{
    const std::string csv = csv_text(y_tree());
    const auto csv_with = [&](const std::string &from, const std::string &to) {
        std::string text = csv;
        assert_true(text.find(from) != text.npos);
        return text.replace(text.find(from), from.size(), to);
    };
    says([&] { read_csv(csv_with("radius_mm", "raduis_mm"), "t.csv"); },
         {"t.csv:2", "raduis_mm", "radius_mm"});
    says([&] { read_csv(csv_with(",0,1,0,1,0,1.9", ",0,1,0,1e999,0,1.9"), "t.csv"); },
         {"t.csv:", "y_mm", "1e999"});
    says([&] { read_csv(csv_with("\n1,left,0,", "\n1,left,7,"), "t.csv"); }, {"branch 1", "7"});
    says([&] { read_csv("branch,x_mm,y_mm,z_mm,radius_mm\n0,0,0,0,1\n2,0,0,1,1\n", "t.csv"); },
         {"t.csv:3", "branch 2"});
    says([&] { read_csv("branch,x_mm,y_mm,z_mm,radius_mm\n0,0,0,0,-1\n0,0,0,1,1\n", "t.csv"); },
         {"sphere 0", "radius"});
    says([&] { read_csv("", "t.csv"); }, {"t.csv", "no branch"});
    says([&] { read_polyline("v 0 0 0\nv 0 0 1\nl 1 3\n", "t.obj"); }, {"t.obj:3", "point 3 does not exist"});
    says([&] { read_polyline("v 0 0 0\nv 0 0 1\nl 1 2\n", "t.obj"); }, {"radius", "--radii-from"});
    says([&] { read_polyline("v 0 0 0\nf 1 1 1\n", "t.obj"); }, {"holds no line"});
    says([&] { read_polydata("<VTKFile type=\"PolyData\"><a></VTKFile>", "t.vtp"); }, {"t.vtp:1", "XML"});
    says([&] { read_polydata("<VTKFile type=\"ImageData\"/>", "t.vtp"); }, {"PolyData"});
    const std::string whole = polydata_text(y_tree()); // XML permits one root element, and no text beside it
    says([&] { read_polydata(whole + "le>\n", "t.vtp"); }, {"t.vtp", "outside of its root"});
    says([&] { read_polydata("le>" + whole.substr(whole.find("<VTKFile")), "t.vtp"); },
         {"t.vtp", "outside of its root"});
    says([&] { read_polydata(whole + "<VTKFile/>", "t.vtp"); }, {"t.vtp", "outside of its root"});
    std::string vtp = vmtk_file(true, true);
    vtp.replace(vtp.find("MaximumInscribed"), 16, "MinimumInscribed");
    says([&] { read_polydata(vtp, "t.vtp"); }, {"MaximumInscribedSphereRadius", "VMTK"});
    vtp = vmtk_file(false, false);
    vtp.replace(vtp.find("NumberOfPoints=\"3\""), 18, "NumberOfPoints=\"4\"");
    says([&] { read_polydata(vtp, "t.vtp"); }, {"'Points'", "9 values", "12"});
    says([&] { read_markups("{\"markups\": [{\"type\": \"Fiducial\"}]}", "t.mrk.json"); },
         {"Fiducial", "Curve"});
    says([&] { read_markups("{\"markups\": 5}", "t.mrk.json"); }, {"markups"});
    says([] { read_tree("/no/such.csv"); }, {"/no/such.csv"});
    says([] { read_tree("/etc/hostname"); }, {".csv", ".vtp"});
}

// No input may cause a crash: each damaged text is either accepted as a valid tree or refused with a Fault.
void damaged_files_are_trees_or_faults(void **)
{
    using Read = Tree (*)(const std::string &, const std::string &);
    const Tree tree = y_tree();
    const std::pair<Read, std::string> formats[] = {
        {[](const std::string &t, const std::string &n) { return read_csv(t, n); }, csv_text(tree)},
        {[](const std::string &t, const std::string &n) { return read_polyline(t, n); }, polyline_text(tree)},
        {[](const std::string &t, const std::string &n) { return read_markups(t, n); }, markups_text(tree)},
        {[](const std::string &t, const std::string &n) { return read_polydata(t, n); }, polydata_text(tree)},
        {[](const std::string &t, const std::string &n) { return read_polydata(t, n); },
         vmtk_file(true, true)},
        {[](const std::string &t, const std::string &n) { return read_polydata(t, n); },
         vmtk_file(false, false)}};
    const char *seed_text = std::getenv("CRN_SEED");
    const unsigned seed = seed_text ? static_cast<unsigned>(std::atoi(seed_text)) : 5;
    std::printf("# CRN_SEED=%u shows the same damage again\n", seed);
    std::mt19937 random(seed);
    const auto draw = [&](std::size_t count) { return static_cast<std::size_t>(random() % count); };
    std::size_t trees = 0, faults = 0;
    for (const auto &[read, good] : formats)
        for (int n = 0; n < 700; ++n) {
            std::string text = good;
            for (std::size_t k = 1 + draw(3); k > 0 && !text.empty(); --k) {
                const std::size_t at = draw(text.size());
                static const char *const words[] = {"-1", "1e308", "nan", "99999999999", "\"", "<",
                                                    ",",  "0",     "[",   "=",           ""};
                switch (draw(4)) {
                case 0:
                    text[at] = static_cast<char>(random());
                    break;
                case 1:
                    text.resize(at);
                    break;
                case 2:
                    text.erase(at, 1 + draw(20));
                    break;
                default:
                    text.insert(at, words[draw(std::size(words))]);
                }
            }
            try {
                check_tree(read(text, "damaged"), "damaged");
                ++trees;
            } catch (const crn::Fault &fault) {
                assert_true(std::string(fault.what()).rfind("damaged", 0) == 0);
                ++faults;
            }
        }
    assert_true(trees > 100 && faults > 1000);
}

// The declaration is the first line of an XML file; pugixml accepts any text in its place.
void a_vtk_file_begins_with_a_correct_xml_declaration_or_with_none(void **)
{
    const std::string whole = polydata_text(y_tree()), declaration = "<?xml version=\"1.0\"?>";
    assert_int_equal(whole.find(declaration), 0);
    const std::string rest = whole.substr(declaration.size());
    for (const char *right : {"", "<?xml version='1.0' encoding=\"utf-8\" standalone='no' ?>",
                              "\xEF\xBB\xBF<?xml version=\"1.0\"?>"})
        assert_same_tree(read_polydata(right + rest, "t.vtp"), y_tree());
    for (const char *wrong :
         {"<?xml version\"1.0\"?>", "<?xml version=1.0?>", "<?xml version=\"#.0\"?>", "<?xml?>",
          "<?xml version=\"1.0\" encoding=\"x\"?>", "<?Xml version=\"1.0\"?>", " <?xml version=\"1.0\"?>",
          "<?xml version=\"1.0\"standalone=\"yes\"?>", "<?xml version=\"1.0\"?><?xml version=\"1.0\"?>"}) {
        try {
            read_polydata(wrong + rest, "t.vtp");
            fail_msg("a file that begins with %s was accepted", wrong);
        } catch (const crn::Fault &fault) {
            assert_non_null(std::strstr(fault.what(), "t.vtp"));
        }
    }
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(every_format_gives_back_the_tree_it_was_given),
        cmocka_unit_test(base64_and_zlib_of_vtk_are_read),
        cmocka_unit_test(a_vtk_file_begins_with_a_correct_xml_declaration_or_with_none),
        cmocka_unit_test(faults_name_place_and_remedy), cmocka_unit_test(damaged_files_are_trees_or_faults)};
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
