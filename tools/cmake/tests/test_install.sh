#!/usr/bin/env bash
# `make install` gives other projects the core and the host: a C program against the core by pkg-config, a C++ program
# against the host by pkg-config and by CMake, and the installed program, all outside this tree. Prints TAP.
set -u
cd "$(dirname "$0")/../../.." || exit 1
root=$PWD build="$PWD/${BUILD:-build}"
programs="cournand anatomy bake centreline"
# shellcheck source=tools/check/tool.sh
. tools/check/tool.sh
cmake --install "$build" --prefix "$work/prefix" >"$work/said" 2>&1
report "it installs into a folder" $?
export PKG_CONFIG_PATH="$work/prefix/lib/pkgconfig"
cat >"$work/core.c" <<'C'
#include "firmware/core/core.h"
#include <stdio.h>
int main(void)
{
    void (*step)(const crn_model *, crn_state *, const crn_input *, crn_output *) = crn_step;
    printf("core %d\n", step != NULL ? (int)CRN_CORE_VERSION : 0);
    return 0;
}
C
cat >"$work/host.cpp" <<'C'
#include "host/model/instrument.hpp"
#include "host/session/device.hpp"
#include <cstdio>
int main(int, char **argv)
{
    const crn::Instrument tool = crn::read_instrument(argv[1]);
    std::printf("%s\n", tool.name.c_str());
    return 0;
}
C
cd "$work" || exit 1
# shellcheck disable=SC2046
gcc -std=c11 core.c $(pkg-config --cflags --libs cournand-core) -o core >said 2>&1 && ./core >said 2>&1 &&
    grep -q "^core [1-9]" said
report "a C program finds the core by pkg-config" $?
tool="$work/prefix/share/cournand/examples/instruments/j_wire.toml"
# shellcheck disable=SC2046
g++ -std=c++20 host.cpp $(pkg-config --cflags --libs cournand-host) -o host >said 2>&1 &&
    ./host "$tool" >said 2>&1 && [ -s said ]
report "a C++ program finds the host by pkg-config, and reads an instrument that was installed" $?
cat >CMakeLists.txt <<'C'
cmake_minimum_required(VERSION 3.25)
project(mine C CXX)
set(CMAKE_CXX_STANDARD 20)
find_package(cournand 0.1 CONFIG REQUIRED)
add_executable(mine host.cpp)
target_link_libraries(mine cournand::host)
add_executable(mine_core core.c)
target_link_libraries(mine_core cournand::core)
C
cmake -S . -B b -DCMAKE_PREFIX_PATH="$work/prefix" >said 2>&1 &&
    cmake --build b >said 2>&1 && b/mine "$tool" >said 2>&1 && b/mine_core >>said
report "a CMake project finds both by find_package" $?
"$work/prefix/bin/cournand" instruments "$tool" >said 2>&1
report "the installed program runs" $?
export XDG_CACHE_HOME="$work/cache" XDG_STATE_HOME="$work/state"
"$work/prefix/bin/cournand" instruments >said 2>&1 && grep -q "^j_wire " said
report "the installed program lists its instruments from every folder" $?
"$work/prefix/bin/cournand" run demo --record demo.rec >said 2>&1 && [ -s demo.rec ] &&
    ls "$work"/cache/cournand/scenes/*/aorta.bodies >said 2>&1
report "the installed program runs a session by its name, and unpacks the scene that comes with it" $?
man -l "$work/prefix/share/man/man1/cournand-run.1" 2>said | grep -q "cournand run demo" &&
    [ -s "$work/prefix/share/man/man1/bake.1" ] &&
    [ -s "$work/prefix/share/bash-completion/completions/cournand" ] &&
    [ -s "$work/prefix/share/zsh/site-functions/_cournand" ] &&
    [ -s "$work/prefix/share/fish/vendor_completions.d/cournand.fish" ]
report "man pages and completion scripts are installed" $?
! grep -rIl "$root" "$work/prefix/lib/pkgconfig" "$work/prefix/lib/cmake" >said 2>&1
report "no installed description names the folder that it was built in" $?
echo "1..$number"
exit $failed
