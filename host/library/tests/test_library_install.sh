#!/usr/bin/env bash
# The C library is installed into an empty prefix, and programs use it from there alone: by pkg-config and by CMake's
# find_package, shared and static. It needs no window, no OpenGL and no DICOM, and exports exactly the functions of its
# header. Prints TAP.
set -u
cd "$(dirname "$0")/../../.." || exit 1
build="$PWD/${BUILD:-build}" root=$PWD
programs=cournand
# shellcheck source=tools/check/tool.sh
. tools/check/tool.sh
program="$build/bin/cournand" tools="$root/shared/examples/instruments"
DESTDIR="$work/tree" cmake --install "$build" --prefix /usr --component library >"$work/said" 2>&1
report "make install DESTDIR= has a component for the library" $?
export PKG_CONFIG_PATH="$work/tree/usr/lib/pkgconfig" LD_LIBRARY_PATH="$work/tree/usr/lib"
installed="$work/tree/usr/lib" examples="$work/tree/usr/share/cournand/examples/library"
mkdir "$work/scene" && tar -xJf shared/examples/scenes/aorta.tar.xz -C "$work/scene"
scene=$(find "$work/scene" -name aorta.scene)

# --- what it needs, and what it shows ---
readelf -d "$installed/libcournand.so" | grep -q 'SONAME.*\[libcournand\.so\.0\]'
report "the shared library has a soname" $?
ldd "$installed/libcournand.so" >"$work/said" 2>&1
! grep -qiE 'libX|libGL|libEGL|glfw|OSMesa|dcm|ofstd|usb|png|archive|openh264|sqlite|pq|not found' "$work/said"
report "the shared library needs no X11, GL, GLFW, DCMTK, libusb or libpng" $?
cat "$work"/tree/usr/include/cournand{,_play}.h | tr '\n' ' ' | grep -oE 'COURNAND_API [^;(]*\(' |
    grep -oE 'cournand_[a-z0-9_]+\(' | tr -d '(' | sort >"$work/header"
nm -D --defined-only "$installed/libcournand.so" | awk '$2 == "T" {sub(/@.*/, "", $3); print $3}' | sort >"$work/shared"
diff "$work/header" "$work/shared" >"$work/said" && [ "$(wc -l <"$work/header")" -ge 40 ]
report "the shared library exports exactly the functions of the header" $?
nm -D --defined-only "$installed/libcournand.so" | awk '$2 != "T" && $3 !~ /^COURNAND_/' >"$work/said"
[ ! -s "$work/said" ]
report "the shared library exports no data" $?
nm -g --defined-only "$installed/libcournand.a" | awk '$2 ~ /[TWVDBR]/ {print $3}' | sort >"$work/static"
diff "$work/header" "$work/static" >"$work/said"
report "the static library shows exactly the functions of the header" $?

# --- a C and a C++ program by pkg-config ---
cd "$work" || exit 1
# shellcheck disable=SC2046
gcc -std=c11 -Wall -Wextra -Wpedantic -Werror "$examples/round_the_arch.c" $(pkg-config --cflags --libs cournand) \
    -o arch >said 2>&1 && ./arch "$scene" "$tools/rosen.toml" >said 2>&1 && grep -q "mm in ascending aorta$" said
report "the C example brings a wire round the arch" $?
cp said arch_said
# shellcheck disable=SC2046
gcc -std=c11 "$examples/round_the_arch.c" $(pkg-config --cflags cournand) "$installed/libcournand.a" \
    $(pkg-config --libs --static cournand | sed 's/-lcournand//') -o arch_static >said 2>&1 &&
    ! ldd arch_static | grep -q libcournand && ./arch_static none.scene none.toml >said 2>&1
[ $? = 1 ] && grep -q "BAD_FILE: none.scene" said
report "the static library links into a program that needs no shared one" $?
# shellcheck disable=SC2046
g++ -std=c++11 -Wall -Wextra -Wpedantic -Werror "$examples/another_angle.cpp" $(pkg-config --cflags --libs cournand) \
    -o angle >said 2>&1
report "the C++ example compiles as C++11" $?
printf '#include <cournand.h>\n#include <cournand_play.h>\n' >header.cpp
# shellcheck disable=SC2046
g++ -std=c++11 -Wall -Wextra -Wpedantic -Werror -c header.cpp $(pkg-config --cflags cournand) >said 2>&1
report "both headers compile as C++11" $?
cat >short.session <<'S'
begin inserted 5 mm
advance 100 mm at 60 mm/s
S
"$program" run short.session --scene "$scene" --instrument "$tools/j_wire.toml" --record short.rec --quiet >said 2>&1 &&
    ./angle short.rec "$scene" 1.5 40 10 picture.pgm >said 2>&1 && grep -q "^tick 1500 at" said &&
    [ "$(head -c 15 picture.pgm | tr '\n' ' ')" = "P5 512 512 255 " ] && [ "$(wc -c <picture.pgm)" = 262159 ]
report "the C++ example renders a moment of a recording of cournand run" $?
./angle short.rec "$scene" 1.5 40 10 again.pgm >said 2>&1 && cmp picture.pgm again.pgm >said 2>&1
report "it renders the same picture twice" $?
./angle short.rec "$scene" 1.5 -40 10 other.pgm >said 2>&1 && ! cmp -s picture.pgm other.pgm
report "it renders another picture from another angle" $?

cat >play.session <<'S'
begin inserted 5 mm
fluoro on rate 15 p/s
advance 100 mm at 60 mm/s while rotate 1 turn
fluoro off
expect inserted at least 100 mm
S
# shellcheck disable=SC2046
gcc -std=c11 -Wall -Wextra -Wpedantic -Werror "$examples/play_a_script.c" $(pkg-config --cflags --libs cournand) \
    -o play >said 2>&1 && "$program" run play.session --scene "$scene" --instrument "$tools/j_wire.toml" --quiet \
    --record run.rec --json run.json >said 2>&1 &&
    ./play play.session "$scene" "$tools/j_wire.toml" play.rec >play.json 2>said && grep -q "^tick .* N$" said &&
    cmp run.json play.json >said 2>&1 && cmp run.rec play.rec >said 2>&1
report "the C example plays a script to the report and the recording of cournand run, byte for byte" $?
echo "expect inserted at least 900 mm" >>play.session
./play play.session "$scene" "$tools/j_wire.toml" play.rec >play.json 2>said
[ $? = 1 ] && grep -q "play.session:6" said
report "it ends with 1 when an expectation does not hold" $?

# --- by CMake ---
cat >CMakeLists.txt <<'C'
cmake_minimum_required(VERSION 3.25)
project(mine C CXX)
find_package(cournand 0.1 CONFIG REQUIRED)
add_executable(arch_shared ${EXAMPLES}/round_the_arch.c)
target_link_libraries(arch_shared cournand::cournand)
add_executable(arch_one_file ${EXAMPLES}/round_the_arch.c)
target_link_libraries(arch_one_file cournand::static)
add_executable(angle_shared ${EXAMPLES}/another_angle.cpp)
target_link_libraries(angle_shared cournand::cournand)
C
unset LD_LIBRARY_PATH # CMake's build tree has a run path
cmake -S . -B b -DCMAKE_PREFIX_PATH="$work/tree/usr" "-DEXAMPLES=$examples" >said 2>&1 &&
    cmake --build b >said 2>&1 && ./b/angle_shared short.rec "$scene" 1.5 40 10 cmake.pgm >said 2>&1 &&
    cmp picture.pgm cmake.pgm >said 2>&1
report "a CMake project finds the library and renders the same picture" $?
./b/arch_one_file >said 2>&1
[ $? = 2 ] && grep -q usage said
report "a CMake project links the static library" $?
! grep -rIl "$root" "$work/tree/usr/lib/pkgconfig" "$work/tree/usr/lib/cmake" >said 2>&1
report "no installed description names the folder that it was built in" $?
echo "1..$number"
exit $failed
