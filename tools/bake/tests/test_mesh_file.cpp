// These tests check the following. No mesh file can crash the program, even if it declares more data than it
// holds, names a missing vertex, nests without end, or is no mesh at all. For each wrong mesh file the error
// message gives the file's name, the position of the fault and the remedy. A child process with limited
// memory, time and stack reads the file. A valid mesh file is read without any change.
#include "host/base/guarded_read.hpp"
#include "tools/bake/mesh.hpp"
#include "tools/bake/tests/shapes.hpp"
#include "tools/bake/tests/texts.hpp"
#include "tools/mesh/files/mesh_file.hpp"

#include <atomic>
#include <chrono>
#include <csetjmp>
#include <csignal>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <thread>
#include <unistd.h>
extern "C" {
#include <cmocka.h>
}

using namespace crn::bake;
using namespace crn::bake::tests;
using nlohmann::json;
using namespace std::chrono_literals;

namespace
{

// Returns the error message, or "" if the file was accepted.
std::string said(const std::function<void()> &work)
{
    try {
        work();
    } catch (const std::exception &fault) {
        return fault.what();
    }
    return "";
}

std::string reading(const Folder &folder, const std::string &name, const std::string &content)
{
    const std::filesystem::path file = folder.write(name, content);
    return said([&] { read_mesh_file(file, {}); });
}

std::string ply_head(const std::string &format, const std::string &vertices, const std::string &faces)
{
    return "ply\nformat " + format + " 1.0\nelement vertex " + vertices +
           "\nproperty float x\nproperty float y\nproperty float z\nelement face " + faces +
           "\nproperty list uchar int vertex_indices\nend_header\n";
}

template <class Value> void put(std::string &bytes, Value value)
{
    bytes.append(reinterpret_cast<const char *>(&value), sizeof value);
}

// Returns a tetrahedron with three edges of 20 mm in which one corner number of face 2 is replaced by
// `corner`.
std::string binary_ply(std::int32_t corner, const std::string &vertices = "4")
{
    std::string bytes = ply_head("binary_little_endian", vertices, "4");
    for (float value : {0, 0, 0, 20, 0, 0, 0, 20, 0, 0, 0, 20}) put(bytes, value);
    for (std::int32_t face = 0; face < 4; ++face) {
        static const std::int32_t corners[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
        bytes += '\3';
        for (int k = 0; k < 3; ++k) put(bytes, face == 2 && k == 1 ? corner : corners[face][k]);
    }
    return bytes;
}

void an_index_beyond_the_vertices_is_named(void **)
{
    const Folder folder;
    assert_string_equal(reading(folder, "good.ply", binary_ply(3)).c_str(), "");
    contains(reading(folder, "a.ply", binary_ply(2147483647)),
             {"a.ply", "face 2 has vertex 2147483647", "there are 4", "export"});
    contains(reading(folder, "b.ply", binary_ply(-1)), {"b.ply", "face 2 has vertex -1"});
    contains(reading(folder, "c.obj", "v 0 0 0\nv 9 0 0\nv 0 9 0\nf 1 2 4\n"),
             {"c.obj:4", "vertex 4", "there are 3"});
    contains(reading(folder, "d.obj", "v 0 0 0\nv 9 0 0\nv 0 9 0\nf 1 2 -4\n"), {"d.obj:4", "'-4'"});
}

// 0x0a and 0x0d are line ends, which end the header; one in 128 first coordinates begins with one of them.
void binary_data_may_begin_with_a_line_end(void **)
{
    const Folder folder;
    for (const std::uint32_t bits : {0x41a3e60au, 0x41a3e60du, 0x41a30a0au, 0x0a0d0a0du}) {
        std::string bytes = binary_ply(3);
        const std::size_t begin = bytes.find("end_header\n") + 11;
        std::memcpy(&bytes[begin], &bits, sizeof bits);
        const std::vector<MeshPiece> pieces = read_mesh_file(folder.write("a.ply", bytes), {});
        float expected = 0;
        std::memcpy(&expected, &bits, sizeof bits);
        assert_int_equal(pieces.size(), 1);
        assert_int_equal(pieces[0].triangles.size(), 4);
        assert_true(pieces[0].vertices[0][0] == expected && pieces[0].vertices[0][1] == 0);
    }
}

// The program checks the data from the library assimp; this check must find a bad vertex index, whatever data
// assimp returns.
void pieces_with_an_index_beyond_their_vertices_are_refused(void **)
{
    const std::vector<MeshPiece> good = {{"left", {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}}};
    check_pieces(good, "a.glb");
    std::vector<MeshPiece> bad = {good[0], good[0]};
    bad[1].name = "right";
    bad[1].triangles[0][2] = 3;
    contains(said([&] { check_pieces(bad, "a.glb"); }),
             {"a.glb", "face 1", "part 'right'", "vertex 3", "there are 3"});
    bad = good;
    bad[0].vertices[1][1] = INFINITY;
    contains(said([&] { check_pieces(bad, "a.glb"); }), {"a.glb", "vertex 1", "infinite"});
}

void counts_are_held_against_the_size_of_the_file(void **)
{
    const Folder folder;
    contains(reading(folder, "a.ply", binary_ply(3, "10")),
             {"a.ply", "declares 10 of element 'vertex'", "are left for them"});
    contains(reading(folder, "b.ply", ply_head("ascii", "99999999999999999999", "1") + "0 0 0\n3 0 0 0\n"),
             {"b.ply:3", "declares '99999999999999999999'"});
    contains(reading(folder, "c.ply", ply_head("binary_little_endian", "900000000", "1") + "0123456789ab"),
             {"c.ply", "declares 900000000 of element 'vertex'", "12 bytes are left"});
    contains(reading(folder, "d.ply", binary_ply(3) + "more"),
             {"d.ply", "4 bytes more than its header declares"});
    std::string stl(80, 'b');
    put(stl, std::uint32_t{4000000000});
    contains(reading(folder, "e.stl", stl + std::string(100, '\0')),
             {"e.stl", "declares 4000000000 triangles", "room for 2"});
}

json box_of(std::size_t offset, int count)
{
    json root;
    root["asset"]["version"] = "2.0";
    root["scenes"] = {{{"nodes", {0}}}};
    root["nodes"] = {{{"mesh", 0}}};
    root["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", 0}}}}}}}};
    root["accessors"] = {{{"bufferView", 0},
                          {"byteOffset", offset},
                          {"componentType", 5126},
                          {"count", count},
                          {"type", "VEC3"}}};
    root["bufferViews"] = {{{"buffer", 0}, {"byteLength", 36}}};
    root["buffers"] = {{{"byteLength", 36}, {"uri", "data:;base64," + std::string(48, 'A')}}};
    return root;
}

void an_accessor_that_leaves_its_view_is_named(void **)
{
    const Folder folder;
    assert_string_equal(reading(folder, "good.gltf", box_of(0, 3).dump()).c_str(), "");
    contains(reading(folder, "a.gltf", box_of(99, 3).dump()), {"a.gltf", "accessor 0", "byte 99"});
    contains(reading(folder, "b.gltf", box_of(96, 3).dump()),
             {"b.gltf", "accessor 0 ends at byte 132", "36"});
    contains(reading(folder, "c.gltf", box_of(0, 2000000000).dump()), {"c.gltf", "accessor 0"});
    json large = box_of(0, 3);
    large["buffers"][0]["byteLength"] = 1000000000000;
    contains(reading(folder, "d.gltf", large.dump()),
             {"d.gltf", "buffer 0 declares 1000000000000", "has 36"});
}

void nests_without_end_are_refused(void **)
{
    const Folder folder;
    json deep = box_of(0, 3);
    deep["nodes"] = json::array();
    for (int i = 1; i <= 100000; ++i) deep["nodes"].push_back({{"children", {i}}});
    deep["nodes"].push_back({{"mesh", 0}});
    contains(reading(folder, "a.gltf", deep.dump()), {"a.gltf", "lies in over 64 others"});
    deep = box_of(0, 3);
    deep["nodes"] = {{{"children", {1}}}, {{"children", {0}}}};
    contains(reading(folder, "b.gltf", deep.dump()), {"b.gltf", "node"});
    contains(reading(folder, "c.gltf", std::string(1000000, '[') + std::string(1000000, ']')),
             {"c.gltf", "1000000 deep", "64"});
}

void damaged_texts_are_named_by_line(void **)
{
    const Folder folder;
    contains(reading(folder, "a.obj", "v 0 0 0\nv 9 zero 0\nv 0 9 0\nf 1 2 3\n"), {"a.obj:2", "'zero'"});
    contains(reading(folder, "b.stl", "solid b\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertx 1 0 0\n"),
             {"b.stl:5", "'vertx'", "'vertex'"});
    contains(reading(folder, "c.ply", ply_head("ascii", "3", "1") + "0 0 0\n9 0 0\n0 ten 0\n3 0 1 2\n"),
             {"c.ply:12", "'ten'", "vertex"});
    contains(reading(folder, "d.ply", ply_head("ascii", "3", "2") + "0 0 0\n9 0 0\n0 9 0\n3 0 1 2\n\n"),
             {"d.ply", "'face' 1 of 2"});
}

// --- the child ---

// The process that reads a mesh file may take 15 s of elapsed time, because on a busy machine a new process
// may wait for seconds.
const crn::ReadLimits small = {std::uint64_t{64} << 20, 2, 15, std::uint64_t{8} << 20};

std::string apart(const std::function<void(crn::Outbox &)> &parse, const crn::ReadLimits &limits = small)
{
    std::uint64_t got = 0;
    const auto began = std::chrono::steady_clock::now();
    const std::string text = said([&] {
        crn::read_apart("a.ply", limits, parse, [&](crn::Inbox &in) { got = in.value<std::uint64_t>(); });
    });
    if (text.empty()) assert_int_equal(got, 42);
    assert_true(std::chrono::steady_clock::now() - began < 20s);
    return text;
}

void a_reader_that_crashes_ends_alone(void **)
{
    assert_string_equal(apart([](crn::Outbox &out) { out.value<std::uint64_t>(42); }).c_str(), "");
    contains(apart([](crn::Outbox &) { throw std::runtime_error("a.ply: no mesh"); }), {"a.ply: no mesh"});
    contains(
        apart([](crn::Outbox &) {
            std::fprintf(stderr, "library: \033[31mbad\n");
            std::abort();
        }),
        {"a.ply: is damaged in a way that ends its reader (Aborted: library:  [31mbad)", "export it again"});
    contains(apart([](crn::Outbox &) { ::raise(SIGSEGV); }), {"a.ply", "ends its reader"});
    contains(apart([](crn::Outbox &) { ::_exit(7); }), {"a.ply", "it stopped"});
    contains(apart([](crn::Outbox &out) { out.value<char>('x'); }), {"a.ply", "it stopped"});
}

int deeper(int level, volatile char *above)
{
    volatile char here[4096];
    here[0] = *above;
    return level == 0 ? here[0] : deeper(level - 1, here) + here[0];
}

void a_reader_has_limits_of_stack_memory_and_time(void **)
{
    volatile char zero = 0;
    contains(apart([&](crn::Outbox &) { deeper(1 << 20, &zero); }), {"a.ply", "Segmentation fault"});
    contains(apart([](crn::Outbox &) {
                 std::vector<std::vector<char>> all;
                 for (;;) all.emplace_back(1 << 20, 'x');
             }),
             {"a.ply", "takes over 64 MiB of memory"});
    contains(apart([](crn::Outbox &) { std::this_thread::sleep_for(60s); },
                   {std::uint64_t{64} << 20, 2, 3, std::uint64_t{8} << 20}),
             {"a.ply", "not done after 3 s"});
    contains(apart(
                 [](crn::Outbox &) {
                     for (std::atomic<int> i = 0;; ++i) {
                     }
                 },
                 {std::uint64_t{64} << 20, 1, 15, std::uint64_t{8} << 20}),
             {"a.ply", "not done after"});
    // If the process that reads a mesh crashes, it must not leave a file behind.
    const Folder folder;
    const std::string litter = folder.write("litter", "").string();
    apart([&](crn::Outbox &) {
        std::FILE *file = std::fopen(litter.c_str(), "w");
        std::fputs("half", file);
        std::fflush(file);
        std::abort();
    });
    assert_int_equal(std::filesystem::file_size(litter), 0);
}

// If the process that reads a mesh reports impossible counts or values, the program does not use its data.
void counts_from_the_child_are_bounded(void **)
{
    contains(said([] {
                 crn::read_apart(
                     "a.ply", small, [](crn::Outbox &out) { out.value<std::uint64_t>(1ull << 60); },
                     [](crn::Inbox &in) { in.list<double>(1000); });
             }),
             {"a.ply", "1152921504606846976 values", "1000"});
    contains(said([] {
                 crn::read_apart(
                     "a.ply", small,
                     [](crn::Outbox &out) { out.value<std::uint64_t>(1), out.value<char>('x'); },
                     [](crn::Inbox &in) { in.value<std::uint64_t>(); });
             }),
             {"a.ply", "more than it announced"});
}

bool is_stopped = false;

void ctrl_c_ends_the_reader_within_a_second(void **)
{
    crn::stop_reading_when([] { return is_stopped; });
    std::signal(SIGINT, [](int) { is_stopped = true; });
    const pid_t self = ::getpid();
    const auto began = std::chrono::steady_clock::now();
    contains(apart([&](crn::Outbox &) {
                 ::kill(self, SIGINT); // as from outside, to the parent alone
                 std::this_thread::sleep_for(60s);
             }),
             {"a.ply", "interrupted"});
    assert_true(std::chrono::steady_clock::now() - began < 1s);
    std::signal(SIGINT, SIG_DFL);
    crn::stop_reading_when(nullptr);
    is_stopped = false;
}

void the_time_grows_with_the_file_and_the_memory_has_an_end(void **)
{
    assert_true(crn::read_limits(1000, 64).wall_s <= 20);
    assert_true(crn::read_limits(std::uint64_t{2} << 20, 64).wall_s <= 20);
    assert_true(crn::read_limits(std::uint64_t{512} << 20, 64).wall_s > 600);
    assert_true(crn::read_limits(std::uint64_t{4} << 30, 1100).memory_bytes < 2000000000);
}

} // namespace

int main()
{
    const CMUnitTest tests[] = {
        cmocka_unit_test(an_index_beyond_the_vertices_is_named),
        cmocka_unit_test(binary_data_may_begin_with_a_line_end),
        cmocka_unit_test(pieces_with_an_index_beyond_their_vertices_are_refused),
        cmocka_unit_test(counts_are_held_against_the_size_of_the_file),
        cmocka_unit_test(an_accessor_that_leaves_its_view_is_named),
        cmocka_unit_test(nests_without_end_are_refused),
        cmocka_unit_test(damaged_texts_are_named_by_line),
        cmocka_unit_test(a_reader_that_crashes_ends_alone),
        cmocka_unit_test(a_reader_has_limits_of_stack_memory_and_time),
        cmocka_unit_test(counts_from_the_child_are_bounded),
        cmocka_unit_test(ctrl_c_ends_the_reader_within_a_second),
        cmocka_unit_test(the_time_grows_with_the_file_and_the_memory_has_an_end),
    };
    cmocka_set_message_output(CM_OUTPUT_TAP);
    return cmocka_run_group_tests(tests, nullptr, nullptr);
}
