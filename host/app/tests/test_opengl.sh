#!/usr/bin/env bash
# Tests cournand --xray opengl: it makes the same pictures as the rasteriser, off screen and in a window, with
# no OpenGL library linked.
set -u
. "$(dirname "$0")/program.sh"
wire=shared/examples/instruments/amplatz_super_stiff.toml


# libOSMesa and libGL both export gl*: a linked one would override the other.
ldd "$program" >"$work/log"
! grep -Eq 'libGL|libOpenGL|libOSMesa|libEGL' "$work/log"
result $? "no library of OpenGL is linked"
nm -D "$program" | grep -E ' (gl[A-Z]|egl[A-Z]|OSMesa)' >"$work/log"
[ $? = 1 ]
result $? "no function of OpenGL, EGL or OSMesa is among the program's symbols"

"$program" info --opengl >"$work/log" 2>&1
[ $? = 0 ] && grep -q "opengl-osmesa.*OpenGL [34].*libOSMesa" "$work/log" &&
    grep -q "opengl-egl.*OpenGL [34].*libEGL" "$work/log"
result $? "info --opengl names driver and version of both libraries"

# A block of tissue with a bone and a straight vessel in it.
python3 - "$work" <<'PY'
import itertools, sys
FACES = ((0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4),
         (2, 6, 3), (3, 6, 7), (0, 4, 2), (2, 4, 6), (1, 3, 5), (3, 7, 5))
def box(name, low, high):
    corners = [(x, y, z) for z, y, x in itertools.product(*zip(low[::-1], high[::-1]))]
    with open("%s/%s.stl" % (sys.argv[1], name), "w") as out:
        out.write("solid box\n")
        for face in FACES:
            loop = "".join("vertex %g %g %g\n" % corners[i] for i in face)
            out.write("facet normal 0 0 0\nouter loop\n%sendloop\nendfacet\n" % loop)
        out.write("endsolid box\n")
box("lumen", (-5, -60, -5), (5, 60, 5))
box("trunk", (-70, -90, -60), (70, 90, 60))
box("bone", (20, -40, -20), (40, 50, 20))
with open(sys.argv[1] + "/scene.toml", "w") as out:
    out.write('[scene]\nname = "block"\n[lumen]\nmesh = "lumen.stl"\nunit = "mm"\n[entry]\nposition_mm = [0, -50, 0]\n'
              'direction = [0, 1, 0]\n')
    bodies = (("trunk", "soft_tissue", ""), ("bone", "bone_cortical", "trunk"), ("vessel", "blood", "trunk"))
    for name, material, inside in bodies:
        mesh = 'mesh = "lumen"' if name == "vessel" else 'mesh = "%s.stl"\nunit = "mm"' % name
        out.write('[[body]]\nname = "%s"\n%s\nmaterial = "%s"\ninside = "%s"\n' % (name, mesh, material, inside))
PY
"$build/bin/bake" "$work/scene.toml" -o "$work/block.scene" >"$work/log" 2>&1
result $? "a scene with nested bodies is baked"
printf 'begin inserted 20 mm\nfluoro on\nfield 20 cm\nc-arm LAO 25 CRA 10\nadvance 30 mm at 60 mm/s\nwait 0.3 s\n' \
    >"$work/short.session"

# Prints the largest difference of two pictures, in grey values.
worst() {
    ffmpeg -v error -i "$1" -i "$2" -filter_complex \
        "[0][1]blend=all_mode=difference,format=gray,signalstats,metadata=print:key=lavfi.signalstats.YMAX:file=-" \
        -f null - |
        sed -n 's/.*YMAX=//p'
}
for back_end in raster opengl-osmesa opengl-egl; do
    "$program" run --scene "$work/block.scene" --tool "$wire" --session "$work/short.session" --quiet --fps 4 \
        --xray $back_end --png "$work/$back_end.png" >"$work/$back_end.out" 2>"$work/$back_end.err"
    result $? "a session with --xray $back_end ends well"
done
for back_end in opengl-osmesa opengl-egl; do
    difference="$(worst "$work/raster.png" "$work/$back_end.png")"
    echo "largest difference of $back_end: $difference of 255; $(cat "$work/$back_end.err")" >"$work/log"
    # A path that differs by 1/1024 mm changes a count by about one photon, which leaves a difference of one
    # or two grey values.
    [ -n "$difference" ] && [ "$difference" -le 3 ] && grep -q "X-ray by OpenGL" "$work/$back_end.err"
    result $? "its pictures are the rasteriser's to 3 grey values, and it says which OpenGL it uses ($back_end)"
done
cmp -s <(grep -Ev "clock|written" "$work/raster.out") <(grep -Ev "clock|written" "$work/opengl-egl.out")
result $? "the session itself does not depend on who draws"

. host/app/tests/display.sh
export XDG_STATE_HOME="$work/kept"
for back_end in raster opengl; do
    "$program" view --scene "$work/block.scene" --tool "$wire" --inserted 40 --fluoro --frames 20 --no-help-panel \
        --xray $back_end --screenshot "$work/window_$back_end.png" >"$work/window_$back_end.log" 2>&1 ||
        echo failed >>"$work/window_failed"
done
cat "$work"/window_*.log >"$work/log"
difference="$(worst "$work/window_raster.png" "$work/window_opengl.png")"
echo "largest difference: $difference of 255" >>"$work/log"
[ ! -e "$work/window_failed" ] && [ -n "$difference" ] && [ "$difference" -le 3 ] &&
    grep -q "GLFW" "$work/window_opengl.log"
result $? "in the window its own context draws, and the screen shows the same"

"$program" run --tool "$wire" --session "$work/short.session" --xray vulkan >"$work/log" 2>&1
[ $? = 2 ] && grep -q "opengl-egl" "$work/log"
result $? "an unknown choice is wrong usage and lists the known ones"
"$program" view --tool "$wire" --xray opengl-osmesa >"$work/log" 2>&1
[ $? = 2 ] && grep -q "known: raster, opengl$" "$work/log"
result $? "a window takes no other library's context beside its own"
echo "1..$number"
exit $failed
