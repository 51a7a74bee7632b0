/* Pushes a Rosen wire from the groin round the aortic arch, and prints the tip and the vessel in which it
 * lies.
 *
 *   cc round_the_arch.c $(pkg-config --cflags --libs cournand) -o round_the_arch
 *   ./round_the_arch aorta.scene rosen.toml
 *
 * The J of the wire may catch in an artery. If the J catches, the wire goes back to a snapshot taken below
 * the arch, and tries again with its tip turned by another 30 degrees. */
#include <cournand.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void done(cournand_status status)
{
    if (status == COURNAND_OK) return;
    fprintf(stderr, "%s: %s\n", cournand_status_name(status), cournand_error_text());
    exit(1);
}

static cournand_place tip_of(cournand_world *world)
{
    cournand_place place = {.struct_bytes = sizeof place};
    done(cournand_world_tip(world, 0, &place));
    return place;
}

int main(int argc, char **argv)
{
    if (argc != 3) return fprintf(stderr, "usage: round_the_arch SCENE INSTRUMENT\n"), 2;
    cournand_scene *scene;
    cournand_tool *wire;
    cournand_world *world;
    size_t bytes;
    done(cournand_scene_open(argv[1], NULL, &scene));
    done(cournand_tool_open(argv[2], &wire));
    done(cournand_world_create(scene, &wire, 1, NULL, &world));
    done(cournand_world_snapshot_bytes(world, &bytes));
    void *snapshot = malloc(bytes);
    if (snapshot == NULL) return 1;

    const float push[COURNAND_ACTION_FLOATS] = {0.06f}; /* m/s */
    done(cournand_world_move(world, push, 9000));
    done(cournand_world_save(world, snapshot, bytes));
    cournand_place tip = tip_of(world);
    for (int turns = 0; turns < 12 && strcmp(tip.name, "ascending aorta") != 0; turns++) {
        const float turn[COURNAND_ACTION_FLOATS] = {0, 0, 0, 0.5236f * (float)turns}; /* rad/s */
        done(cournand_world_restore(world, snapshot, bytes));
        done(cournand_world_move(world, turn, 1000));
        for (int step = 0; step < 60 && strcmp(tip_of(world).name, "ascending aorta") != 0; step++)
            done(cournand_world_move(world, push, 133));
        tip = tip_of(world);
    }
    printf("tip at %.1f %.1f %.1f mm in %s\n", tip.tip_m[0] * 1e3, tip.tip_m[1] * 1e3, tip.tip_m[2] * 1e3,
           tip.name);
    free(snapshot);
    done(cournand_world_free(world));
    done(cournand_tool_free(wire));
    done(cournand_scene_free(scene));
    return 0;
}
