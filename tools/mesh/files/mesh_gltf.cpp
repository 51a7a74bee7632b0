// Checks that the declarations of a glTF file (buffers, views, accessors, nodes) agree with the file's
// contents, before assimp relies on these declarations. See the glTF 2.0 specification, sections 3.5 to 3.7
// and 4.4 (binary form).
#include "tools/mesh/files/mesh_file.hpp"
#include "tools/mesh/files/mesh_words.hpp"
#include "tools/mesh/json_depth.hpp"

#include <map>
#include <nlohmann/json.hpp>
#include <set>

namespace crn::bake
{
namespace
{

using nlohmann::json;

constexpr int depth_max = 64; // nesting depth of nodes
constexpr std::size_t glb_head_bytes = 12, chunk_head_bytes = 8;
constexpr std::uint32_t json_chunk = 0x4E4F534A, bytes_chunk = 0x004E4942;

std::uint32_t word_at(std::string_view bytes, std::size_t at)
{
    std::uint32_t word = 0;
    for (std::size_t i = 4; i > 0; --i) word = word << 8 | static_cast<unsigned char>(bytes[at + i - 1]);
    return word;
}

class Gltf
{
  public:
    Gltf(std::string_view bytes, const std::string &file, const std::filesystem::path &folder)
        : file_(file), folder_(folder)
    {
        const std::string_view text = text_of(bytes);
        check_depth(text);
        try {
            root_ = json::parse(text);
        } catch (const json::exception &error) {
            fail(std::string("its text is no JSON (") + error.what() + ")");
        }
    }

    // Returns the total number of faces of all meshes if all faces are single triangles, or -1 if the file
    // has strips or fans of triangles.
    std::int64_t faces() const
    {
        std::int64_t faces = 0;
        for (const json &mesh : list("meshes"))
            for (const json &primitive : mesh.value("primitives", json::array())) {
                if (primitive.value("mode", 4) != 4) return -1;
                const bool is_indexed = primitive.contains("indices");
                if (!is_indexed && !primitive.value("attributes", json::object()).contains("POSITION"))
                    return -1;
                const json &index = is_indexed ? primitive["indices"] : primitive["attributes"]["POSITION"];
                faces += list("accessors")[index.get<std::size_t>()]["count"].get<std::int64_t>() / 3;
            }
        return faces;
    }

    void check() const
    try {
        if (!root_.is_object() || !root_.contains("asset")) fail("it has no 'asset'");
        const std::string version = root_["asset"].value("version", "");
        if (version.substr(0, 2) != "2.") fail("it is version " + shown(version) + " of glTF, 2.0 is read");
        for (const json &name : list("extensionsRequired"))
            if (name == "KHR_draco_mesh_compression" || name == "EXT_meshopt_compression")
                fail("its mesh is compressed by " + name.get<std::string>() + ": export it without");
        for (std::size_t i = 0; i < list("buffers").size(); ++i) check_buffer(i);
        for (std::size_t i = 0; i < list("bufferViews").size(); ++i) check_view(i);
        for (std::size_t i = 0; i < list("accessors").size(); ++i) check_accessor(i);
        for (std::size_t i = 0; i < list("meshes").size(); ++i) check_mesh(i);
        check_nodes();
    } catch (const json::exception &error) {
        fail(std::string("a value is of another kind than glTF's (") + error.what() + ")");
    }

  private:
    [[noreturn]] void fail(const std::string &what) const
    {
        throw Fault(file_ + ": cannot be read as glTF: " + what + ": export the mesh again");
    }

    // Returns the JSON part of a binary glTF file and sets the size of its binary part.
    std::string_view text_of(std::string_view bytes)
    {
        if (bytes.substr(0, 4) != "glTF") return bytes;
        if (bytes.size() < glb_head_bytes + chunk_head_bytes || word_at(bytes, 4) != 2)
            fail("its head is cut short or not of version 2");
        const std::size_t length = word_at(bytes, 8);
        if (length > bytes.size() || length < glb_head_bytes + chunk_head_bytes)
            fail("it declares " + std::to_string(length) + " bytes and has " + std::to_string(bytes.size()));
        std::string_view text;
        for (std::size_t at = glb_head_bytes, number = 0; at + chunk_head_bytes <= length; ++number) {
            const std::size_t count = word_at(bytes, at);
            const std::uint32_t kind = word_at(bytes, at + 4);
            at += chunk_head_bytes;
            if (count > length - at) fail("chunk " + std::to_string(number) + " is cut short");
            if ((number == 0) != (kind == json_chunk)) fail("its first chunk alone must be JSON");
            if (number == 0) text = bytes.substr(at, count);
            if (kind == bytes_chunk && own_bytes_ < 0) own_bytes_ = static_cast<std::int64_t>(count);
            at += count;
        }
        return text;
    }

    // Parsers recurse once per bracket.
    void check_depth(std::string_view text) const
    {
        const int depth = json_depth(text);
        if (depth > json_depth_max)
            fail("its brackets lie " + std::to_string(depth) + " deep in each other, at most " +
                 std::to_string(json_depth_max) + " are read");
    }

    const json &list(const char *key) const
    {
        static const json none = json::array();
        const auto found = root_.find(key);
        if (found == root_.end()) return none;
        if (!found->is_array()) fail(std::string("'") + key + "' is no list");
        return *found;
    }

    // Reads a whole number, which must be at least `low`, from a key of the JSON text. If the key is missing,
    // the function returns `otherwise`; if `otherwise` is -1, the key is required.
    std::int64_t whole(const json &of, const char *key, const std::string &place, std::int64_t low = 0,
                       std::int64_t otherwise = -1) const
    {
        const auto found = of.find(key);
        if (found == of.end() && otherwise >= 0) return otherwise;
        if (found == of.end()) fail(place + " has no " + key);
        if (!found->is_number_integer() || *found < low || *found > (std::int64_t{1} << 40))
            fail(place + ": " + key + " is " + found->dump().substr(0, 40) + ", no possible number");
        return found->get<std::int64_t>();
    }

    const json &named(const char *key, const json &index, const std::string &place) const
    {
        const json &all = list(key);
        if (!index.is_number_integer() || index < 0 || index >= all.size())
            fail(place + " names " + key + " " + index.dump().substr(0, 40) + " of " +
                 std::to_string(all.size()));
        return all[index.get<std::size_t>()];
    }

    void check_buffer(std::size_t number) const
    {
        const std::string place = "buffer " + std::to_string(number);
        const json &buffer = list("buffers")[number];
        const std::int64_t declared = whole(buffer, "byteLength", place, 1);
        std::int64_t there = -1;
        if (!buffer.contains("uri")) {
            there = own_bytes_;
        } else if (const std::string uri = buffer["uri"]; uri.substr(0, 5) == "data:") {
            const std::size_t comma = uri.find(";base64,");
            if (comma == std::string::npos) fail(place + " is text of another kind than base64");
            const std::string_view text = std::string_view(uri).substr(comma + 8);
            const std::size_t letters = text.find_last_not_of('=') + 1; // 0 where there is none
            constexpr const char *alphabet =
                "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
            if (text.size() % 4 != 0 || text.size() - letters > 2 ||
                text.substr(0, letters).find_first_not_of(alphabet) != std::string_view::npos)
                fail(place + " is no base64");
            there = static_cast<std::int64_t>(letters * 3 / 4);
        } else {
            std::error_code error;
            const auto bytes = std::filesystem::file_size(folder_ / uri, error);
            if (error)
                fail(place + " is in " + shown(uri) + ", which cannot be read: keep it beside the .gltf");
            there = static_cast<std::int64_t>(bytes);
        }
        if (there < 0) fail(place + " has neither a uri nor a binary chunk");
        if (declared > there)
            fail(place + " declares " + std::to_string(declared) + " bytes, but has " +
                 std::to_string(there));
    }

    void check_view(std::size_t number) const
    {
        const std::string place = "bufferView " + std::to_string(number);
        const json &view = list("bufferViews")[number];
        if (!view.contains("buffer")) fail(place + " has no buffer");
        const json &buffer = named("buffers", view["buffer"], place);
        const std::int64_t offset = whole(view, "byteOffset", place, 0, 0),
                           length = whole(view, "byteLength", place, 1),
                           there = whole(buffer, "byteLength", place, 1);
        if (offset + length > there)
            fail(place + " ends at byte " + std::to_string(offset + length) + " of its buffer's " +
                 std::to_string(there));
        if (view.contains("byteStride")) {
            const std::int64_t stride = whole(view, "byteStride", place, 4);
            if (stride > 252 || stride % 4 != 0) fail(place + ": byteStride is no multiple of 4 up to 252");
        }
    }

    void check_accessor(std::size_t number) const
    {
        static const std::map<std::int64_t, std::int64_t> bytes = {{5120, 1}, {5121, 1}, {5122, 2},
                                                                   {5123, 2}, {5125, 4}, {5126, 4}};
        static const std::map<std::string, std::int64_t> values = {
            {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}, {"MAT2", 4}, {"MAT3", 9}, {"MAT4", 16}};
        const std::string place = "accessor " + std::to_string(number);
        const json &accessor = list("accessors")[number];
        const auto type = values.find(accessor.value("type", ""));
        const auto component = bytes.find(whole(accessor, "componentType", place));
        if (type == values.end() || component == bytes.end()) fail(place + " is of a type that glTF has not");
        const std::int64_t count = whole(accessor, "count", place, 1);
        if (count > 1'000'000'000) fail(place + " declares " + std::to_string(count) + " values");
        if (!accessor.contains("bufferView"))
            return; // such an accessor is all zeros, which no mesh may use (see check_mesh)
        const json &view = named("bufferViews", accessor["bufferView"], place);
        const std::int64_t each = component->second * type->second,
                           stride = whole(view, "byteStride", place, 4, each),
                           offset = whole(accessor, "byteOffset", place, 0, 0),
                           there = whole(view, "byteLength", place, 1);
        if (offset % component->second != 0)
            fail(place + " begins at byte " + std::to_string(offset) + ", no multiple of its values' " +
                 std::to_string(component->second));
        if (stride < each || offset + stride * (count - 1) + each > there)
            fail(place + " ends at byte " + std::to_string(offset + stride * (count - 1) + each) +
                 " of its view's " + std::to_string(there));
    }

    void check_use(const json &index, const std::string &type, const std::set<std::int64_t> &components,
                   const std::string &place) const
    {
        const json &accessor = named("accessors", index, place);
        if (accessor.value("type", "") != type || !components.contains(accessor.value("componentType", 0)))
            fail(place + " is of another type than glTF's meshes have");
        if (!accessor.contains("bufferView") || accessor.contains("sparse"))
            fail(place + " is sparse, which is not read");
    }

    void check_mesh(std::size_t number) const
    {
        const json &mesh = list("meshes")[number];
        if (!mesh.contains("primitives")) fail("mesh " + std::to_string(number) + " has no 'primitives'");
        for (const json &primitive : mesh["primitives"]) {
            const std::string place = "mesh " + std::to_string(number);
            if (whole(primitive, "mode", place, 0, 4) > 6) fail(place + ": mode is over 6");
            const json attributes = primitive.value("attributes", json::object());
            for (const auto &[name, index] : attributes.items()) {
                const json &accessor = named("accessors", index, place + "'s " + shown(name));
                if (!attributes.contains("POSITION") ||
                    accessor["count"] != named("accessors", attributes["POSITION"], place)["count"])
                    fail(place + ": " + shown(name) + " has not one value per POSITION");
            }
            if (attributes.contains("POSITION"))
                check_use(attributes["POSITION"], "VEC3", {5126}, place + "'s POSITION");
            if (primitive.contains("indices"))
                check_use(primitive["indices"], "SCALAR", {5121, 5123, 5125}, place + "'s indices");
        }
    }

    // Checks that the nodes of the glTF file form a forest, in which every node has at most one parent and a
    // limited depth.
    void check_nodes() const
    {
        const json &nodes = list("nodes");
        std::vector<std::int64_t> parent(nodes.size(), -1);
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            const std::string place = "node " + std::to_string(i);
            if (nodes[i].contains("mesh")) named("meshes", nodes[i]["mesh"], place);
            for (const json &child : nodes[i].value("children", json::array())) {
                named("nodes", child, place);
                std::int64_t &above = parent[child.get<std::size_t>()];
                if (above >= 0) fail("node " + child.dump() + " is in two others");
                above = static_cast<std::int64_t>(i);
            }
            for (const char *key : {"matrix", "translation", "rotation", "scale"})
                for (const json &value : nodes[i].value(key, json::array()))
                    if (!value.is_number()) fail(place + ": " + key + " is not made of numbers");
        }
        for (std::size_t i = 0; i < nodes.size(); ++i) {
            int above = 1;
            for (std::int64_t at = parent[i]; at >= 0; at = parent[static_cast<std::size_t>(at)], ++above)
                if (above > depth_max)
                    fail("node " + std::to_string(i) + " lies in over " + std::to_string(depth_max) +
                         " others");
        }
        for (const json &scene : list("scenes"))
            for (const json &node : scene.value("nodes", json::array())) named("nodes", node, "a scene");
        if (root_.contains("scene")) named("scenes", root_["scene"], "the file");
    }

    const std::string &file_;
    const std::filesystem::path &folder_;
    json root_;
    std::int64_t own_bytes_ = -1; // of the binary chunk; -1: there is none
};

} // namespace

Declared check_gltf(std::string_view bytes, const std::string &file, const std::filesystem::path &folder)
{
    const Gltf gltf(bytes, file, folder);
    gltf.check();
    return {-1, gltf.faces()};
}

} // namespace crn::bake
