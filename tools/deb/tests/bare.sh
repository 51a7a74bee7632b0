#!/bin/bash
# Runs inside a bare Debian as root: installs the packages of the folder /packages, uses them as a user without rights,
# and removes them. test_deb_installed.sh starts it, and prints the TAP that this script prints.
set -u
export DEBIAN_FRONTEND=noninteractive LC_ALL=C.UTF-8
ours="cournand libcournand0 libcournand-dev python3-cournand"
data=/usr/share/cournand/examples
number=0
failed=0

report() { # report NAME STATUS: below a failure it prints the last program's output, stored in $said
    number=$((number + 1))
    [ "$2" = 0 ] && echo "ok $number - $1" && return
    echo "not ok $number - $1"
    failed=1
    tail -n 40 "$said" | sed 's/^/# /'
}
user() { (cd /home/trainee && HOME=/home/trainee runuser -u trainee -- "$@"); }
# Every file outside the folders of apt, of logs and of users, with its kind and the target of a link.
everything() {
    find / -xdev \( -path /proc -o -path /sys -o -path /dev -o -path /run -o -path /tmp -o -path /home -o \
        -path /packages -o -path /var/cache/apt -o -path /var/lib/apt -o -path /var/lib/dpkg -o -path /var/log \) \
        -prune -o -printf '%p %y %l\n' | sort
}
said=$(mktemp)
chmod 644 "$said"
useradd --create-home trainee

# --- installation ---
begin=$SECONDS
apt-get update >"$said" 2>&1 && apt-get install -y --no-install-recommends /packages/*.deb >"$said" 2>&1
report "apt installs the packages with what they depend on" $?
echo "# installed in $((SECONDS - begin)) s; $(grep '^After this operation' "$said")"
dpkg --audit >"$said" 2>&1 && [ ! -s "$said" ]
report "dpkg finds no fault in the installed packages" $?
for program in cournand anatomy bake centreline; do user "$program" --version || exit 1; done >"$said" 2>&1
report "every program starts" $?

# --- the programs ---
user cournand case list >"$said" 2>&1 && [ "$(wc -l <"$said")" -ge 10 ] && grep -q '^first_push ' "$said"
report "cournand lists the cases that come with it" $?
user cournand instruments >"$said" 2>&1 && grep -q '^j_wire ' "$said"
report "cournand lists the instruments that come with it" $?
user cournand >"$said" 2>&1 && grep -q 'cournand run demo' "$said"
report "cournand alone says what can be done without a display" $?
user cournand run demo --quiet --record demo.rec --png demo.png >"$said" 2>&1 &&
    grep '^final hash' "$said" | diff - /packages/expected >>"$said"
report "the session demo by its name, in the scene that was installed, has the hash of the build folder" $?
user cournand replay demo.rec --verify >"$said" 2>&1 && [ "$(head -c 4 /home/trainee/demo.png | tail -c 3)" = PNG ]
report "its recording replays bit for bit, and it has written a picture" $?
user cournand case play first_push --script expert >"$said" 2>&1
report "an expert plays the first case, whose scene anatomy and bake make" $?
user cournand rig selftest --device sim >"$said" 2>&1
report "the simulated rig passes its test" $?
grep -q '^SUBSYSTEM=="usb"' /lib/udev/rules.d/60-cournand.rules >"$said" 2>&1
report "udev has the rule for rigs" $?

# --- the window ---
cat >/packages/window.sh <<'S'
cournand view --frames 200 --size 128 --screenshot window.png --no-record &
for _ in $(seq 300); do xprop -name Cournand WM_CLASS 2>/dev/null | grep STRING && break; sleep 0.1; done
wait $!
S
apt-get install -y --no-install-recommends xvfb xauth x11-utils libgl1-mesa-dri >"$said" 2>&1 &&
    user xvfb-run -a -s '-screen 0 1280x1024x24' bash /packages/window.sh >"$said" 2>&1 &&
    [ "$(head -c 4 /home/trainee/window.png | tail -c 3)" = PNG ]
report "the window opens with the font of the package fonts-dejavu-core" $?
class=$(sed -n 's/^StartupWMClass=//p' /usr/share/applications/cournand.desktop)
grep -qF "= \"$class\", \"$class\"" "$said"
report "the window has the class by which a desktop finds its icon" $?

# --- the library ---
apt-get install -y --no-install-recommends gcc g++ libc6-dev pkg-config cmake make xz-utils >"$said" 2>&1 &&
    user tar -xJf $data/scenes/aorta.tar.xz >"$said" 2>&1
report "a compiler is installed, and the scene of the examples is unpacked" $?
scene=$(cd /home/trainee && find . -name aorta.scene -path './*' -not -path './.*/*' | head -n 1)
# shellcheck disable=SC2046
user gcc -std=c11 -Wall -Wextra -Werror $data/library/round_the_arch.c $(pkg-config --cflags --libs cournand) -o arch \
    >"$said" 2>&1 && user ./arch "$scene" $data/instruments/rosen.toml >"$said" 2>&1 &&
    grep -q 'mm in ascending aorta$' "$said" && ldd /home/trainee/arch | grep -q libcournand.so.0
report "a C program finds the library by pkg-config, and brings a wire round the arch" $?
folder=$(dpkg-architecture -qDEB_HOST_MULTIARCH 2>/dev/null || gcc -print-multiarch)
# shellcheck disable=SC2046
user gcc $data/library/round_the_arch.c $(pkg-config --cflags cournand) "/usr/lib/$folder/libcournand.a" \
    $(pkg-config --libs --static cournand | sed 's/-lcournand//') -o alone >"$said" 2>&1 &&
    user ./alone "$scene" $data/instruments/rosen.toml >"$said" 2>&1 && ! ldd /home/trainee/alone | grep -q libcournand
report "the static library does the same" $?
cat >/home/trainee/CMakeLists.txt <<'C'
cmake_minimum_required(VERSION 3.25)
project(mine C CXX)
find_package(cournand 0.1 CONFIG REQUIRED)
add_executable(mine /usr/share/cournand/examples/library/round_the_arch.c)
target_link_libraries(mine cournand::cournand)
add_executable(mine_alone /usr/share/doc/libcournand-dev/examples/another_angle.cpp)
target_link_libraries(mine_alone cournand::static)
C
user cmake -S . -B b >"$said" 2>&1 && user cmake --build b >"$said" 2>&1 &&
    user b/mine_alone demo.rec "$scene" 1.5 40 10 angle.pgm >"$said" 2>&1 && [ -s /home/trainee/angle.pgm ]
report "a CMake project finds the library, and renders a moment of the recording" $?

# --- Python ---
user python3 /packages/five_lines.py >"$said" 2>&1 && [ "$(stat -c %s /home/trainee/wire.png)" -gt 1000 ]
report "five lines of Python make a picture" $?
user python3 -c 'import importlib.metadata as m, cournand; assert m.version("cournand") == cournand.__version__' \
    >"$said" 2>&1
report "Python knows the version of the package" $?
mkdir -p /packages/tests/build/python/site && ln -s /usr/bin /packages/tests/build/bin
ln -s /usr/lib/python3/dist-packages/cournand /packages/tests/build/python/site/cournand
test=/packages/tests/host/python/tests/test_python_api.py
user env BUILD=build COURNAND_PYTHON_TEST=$test python3 -B $test >"$said" 2>&1
report "the tests of the Python package pass with Debian's NumPy ($(dpkg-query -f '${Version}' -W python3-numpy))" $?

# --- removal ---
cp -r /home/trainee /packages/kept
# shellcheck disable=SC2086
apt-get purge -y $ours >"$said" 2>&1 && ! dpkg-query -W -f '${Package} ${Status}\n' $ours >>"$said" 2>/dev/null
report "apt purges the packages" $?
find / -xdev -iname '*cournand*' -not -path '/packages/*' -not -path '/home/*' -not -path '/proc/*' >"$said"
[ ! -s "$said" ]
report "no file with our name is left" $?
everything >/packages/before
dpkg -i /packages/*.deb >"$said" 2>&1 && user cournand run demo --quiet >>"$said" 2>&1 &&
    user python3 /packages/five_lines.py >>"$said" 2>&1 && dpkg --purge $ours >>"$said" 2>&1 &&
    everything | diff /packages/before - >"$said"
report "installing, using and purging them again leaves every folder as it was" $?
echo "1..$number"
exit $failed
