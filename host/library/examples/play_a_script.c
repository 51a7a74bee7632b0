/* Plays a session script with one tool, prints the force on the hand at each X-ray pulse on stderr, and the
 * report of the session on stdout.
 *
 *   cc play_a_script.c $(pkg-config --cflags --libs cournand) -o play_a_script
 *   ./play_a_script demo.session aorta.scene j_wire.toml demo.rec >report.json
 *
 * The report and the recording are equal to those of `cournand run --json --record` with the same paths. The
 * exit code is that of `cournand run`. */
#include <cournand.h>
#include <cournand_play.h>
#include <stdio.h>
#include <stdlib.h>

static void done(cournand_status status)
{
    if (status == COURNAND_OK) return;
    cournand_error_place place = {.struct_bytes = sizeof place};
    fprintf(stderr, "%s: %s\n", cournand_status_name(status), cournand_error_text());
    if (cournand_error_where(&place) == COURNAND_OK && place.line > 0)
        fprintf(stderr, "the mistake is in line %u, column %u\n", (unsigned)place.line,
                (unsigned)place.column);
    exit(1);
}

int main(int argc, char **argv)
{
    if (argc != 5) return fprintf(stderr, "usage: play_a_script SCRIPT SCENE INSTRUMENT RECORDING\n"), 2;
    cournand_script *script;
    cournand_scene *scene;
    cournand_tool *tool;
    cournand_play *play;
    cournand_world *world;
    const char *json;
    done(cournand_script_open(argv[1], NULL, &script));
    done(cournand_scene_open(argv[2], NULL, &scene));
    done(cournand_tool_open(argv[3], &tool));
    cournand_play_options options = {.struct_bytes = sizeof options, .record = argv[4]};
    done(cournand_play_create(script, scene, &tool, 1, &options, &play));
    done(cournand_play_world(play, &world));
    cournand_play_state state = {.struct_bytes = sizeof state};
    cournand_reading reading = {.struct_bytes = sizeof reading};
    do {
        done(cournand_play_advance(play, 1000, COURNAND_PLAY_TO_PULSE));
        done(cournand_play_read(play, &state));
        done(cournand_world_read(world, &reading));
        if (state.is_at_pulse) fprintf(stderr, "tick %u: %.3f N\n", (unsigned)state.tick, reading.force_N[0]);
    } while (!state.is_over);
    done(cournand_play_report(play, &json));
    fputs(json, stdout);
    fputs(state.failures, stderr);
    return (int)state.exit_status;
}
