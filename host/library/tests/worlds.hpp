// Makes worlds for the tests of the library: in free space, and in the shipped aorta, which each program
// unpacks once.
#pragma once
#include "host/base/tests/folder.hpp"
#include "host/cases/unpack.hpp"
#include "host/library/cournand.h"
#include "host/library/tests/seal.hpp"
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace crn::tests
{

inline const std::string instruments = "shared/examples/instruments/";
inline const std::string stents = "shared/examples/stents/";

// If the call has failed, the test fails with the library's error text.
inline void done(cournand_status status)
{
    if (status != COURNAND_OK)
        throw std::runtime_error(std::string(cournand_status_name(status)) + ": " + cournand_error_text());
}

// Returns an empty struct of the API in which struct_bytes is set.
template <class Struct> Struct sized()
{
    Struct made{};
    made.struct_bytes = sizeof made;
    return made;
}

inline std::string aorta_path()
{
    static const Folder kept("library-scene");
    static const std::string folder = [] {
        const std::string path = kept.file("aorta");
        unpack_scene("shared/examples/scenes/aorta.tar.xz", path,
                     [](std::size_t, std::size_t) { return true; });
        return path;
    }();
    return folder + "/aorta.scene";
}

inline cournand_scene *aorta()
{
    static cournand_scene *const scene = [] {
        cournand_scene *opened = nullptr;
        done(cournand_scene_open(aorta_path().c_str(), nullptr, &opened));
        return opened;
    }();
    return scene;
}

inline cournand_scene *free_space()
{
    static cournand_scene *const scene = [] {
        cournand_scene *opened = nullptr;
        done(cournand_scene_open(nullptr, nullptr, &opened));
        return opened;
    }();
    return scene;
}

inline cournand_tool *tool(const std::string &name)
{
    cournand_tool *opened = nullptr;
    done(cournand_tool_open((instruments + name + ".toml").c_str(), &opened));
    return opened;
}

inline cournand_world *world(cournand_scene *scene, const std::vector<std::string> &names = {"j_wire"},
                             const cournand_world_options *options = nullptr)
{
    std::vector<cournand_tool *> tools;
    for (const std::string &name : names) tools.push_back(tool(name));
    cournand_world *made = nullptr;
    const cournand_status status = cournand_world_create(scene, tools.data(), tools.size(), options, &made);
    for (cournand_tool *one : tools) done(cournand_tool_free(one));
    done(status);
    return made;
}

// Pushes the innermost tool at 60 mm/s and turns it.
inline void push(cournand_world *world, std::uint32_t ticks, float push_m_per_s = 0.06f,
                 float turn_rad_per_s = 1.0f)
{
    const float action[COURNAND_ACTION_FLOATS] = {push_m_per_s, 0, 0, turn_rad_per_s};
    done(cournand_world_move(world, action, ticks));
}

inline std::uint64_t hash(cournand_world *world)
{
    std::uint64_t value = 0;
    done(cournand_world_hash(world, &value));
    return value;
}

inline cournand_reading reading(cournand_world *world)
{
    auto read = sized<cournand_reading>();
    done(cournand_world_read(world, &read));
    return read;
}

inline cournand_pose pose(cournand_world *world)
{
    auto read = sized<cournand_pose>();
    done(cournand_world_pose(world, &read));
    return read;
}

inline std::vector<std::uint8_t> saved(cournand_world *world)
{
    std::size_t count = 0;
    done(cournand_world_snapshot_bytes(world, &count));
    std::vector<std::uint8_t> bytes(count);
    done(cournand_world_save(world, bytes.data(), bytes.size()));
    return bytes;
}

} // namespace crn::tests
