// Renders a moment of a recording from another angle of the C-arm, and writes the picture as PGM.
//
//   c++ another_angle.cpp $(pkg-config --cflags --libs cournand) -o another_angle
//   ./another_angle mine.rec aorta.scene 2.5 40 0 picture.pgm          at 2.5 s, LAO 40, cranial 0
#include <algorithm>
#include <cournand.h>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>

namespace
{

void done(cournand_status status)
{
    if (status != COURNAND_OK) throw std::runtime_error(cournand_error_text());
}

template <class Handle> using Owned = std::unique_ptr<Handle, cournand_status (*)(Handle *)>;

void render(char **words)
{
    cournand_recording *opened = nullptr;
    cournand_scene *opened_scene = nullptr;
    cournand_world *made = nullptr;
    cournand_renderer *made_renderer = nullptr;
    done(cournand_recording_open(words[1], &opened));
    const Owned<cournand_recording> recording(opened, cournand_recording_free);
    done(cournand_scene_open(words[2], nullptr, &opened_scene));
    const Owned<cournand_scene> scene(opened_scene, cournand_scene_free);
    done(cournand_recording_world(recording.get(), scene.get(), COURNAND_WITH_PATIENT, &made));
    const Owned<cournand_world> world(made, cournand_world_free);
    done(cournand_world_replay(world.get(), recording.get(),
                               static_cast<uint32_t>(std::atof(words[3]) * 1000)));

    cournand_pose pose = {};
    pose.struct_bytes = sizeof pose;
    done(cournand_world_pose(world.get(), &pose));
    cournand_view view = {};
    view.struct_bytes = sizeof view;
    view.primary_deg = std::atof(words[4]);
    view.secondary_deg = std::atof(words[5]);
    std::copy_n(pose.positions_m, 3, view.isocentre_m); // the leading tip is in the middle
    done(cournand_renderer_create(scene.get(), 2, &made_renderer));
    const Owned<cournand_renderer> renderer(made_renderer, cournand_renderer_free);
    cournand_picture picture = {};
    picture.struct_bytes = sizeof picture;
    done(cournand_render(renderer.get(), world.get(), &view, &picture));

    std::ofstream file(words[6], std::ios::binary);
    file << "P5\n" << picture.size << " " << picture.size << "\n255\n";
    file.write(reinterpret_cast<const char *>(picture.grey), std::streamsize{picture.size} * picture.size);
    if (!file.flush()) throw std::runtime_error(std::string(words[6]) + " cannot be written");
    std::printf("tick %u at %.0f kV: %s\n", picture.tick, picture.tube_voltage_kV, words[6]);
}

} // namespace

int main(int count, char **words)
{
    if (count != 7) {
        std::fprintf(stderr, "usage: another_angle RECORDING SCENE SECONDS PRIMARY SECONDARY PICTURE\n");
        return 2;
    }
    try {
        render(words);
    } catch (const std::exception &error) {
        std::fprintf(stderr, "another_angle: %s\n", error.what());
        return 1;
    }
    return 0;
}
