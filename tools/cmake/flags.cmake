# Flags for all code: every target of this project links crn_common.
include_guard()

set(CRN_OPT "-O2" CACHE STRING "level of everything that sets none of its own")
set(CRN_CORE_OPT "-O3" CACHE STRING "level of firmware/core")
set(CRN_TEST_OPT "-O1" CACHE STRING "level of tests: long lists that run once")
set(CRN_DEBUG "-g1" CACHE STRING "debug information: -g1 lines only, -g for a debugger")
set(CRN_SANITIZE "" CACHE STRING "sanitizers, such as address,undefined")
set(CRN_SANITIZE_GCC "" CACHE STRING "the same by gcc, which has no fuzzers: for the readers of scans")
set(CRN_QUICK ON CACHE BOOL "compile what runs once without optimising")
set(CRN_TOGETHER ON CACHE BOOL "compile all sources of a room as one unit")
set(CRN_USB_ID "1209:0001" CACHE STRING "number of a rig on the bus, vendor:product in hexadecimal (docs/usb.md)")
set(CRN_PARTS "run;window;tools;tests;lab" CACHE STRING
    "what is built: run, window, igtl, tools, tests, lab; or library alone")

set(CMAKE_C_STANDARD 11)
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_C_EXTENSIONS OFF)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
# With hidden symbols, code that can become part of a shared library is as fast as the compiler's usual code for
# programs (docs/library.md).
if(NOT CMAKE_CROSSCOMPILING)
    set(CMAKE_C_VISIBILITY_PRESET hidden)
    set(CMAKE_CXX_VISIBILITY_PRESET hidden)
endif()

find_program(CRN_CCACHE ccache)
if(CRN_CCACHE AND NOT CMAKE_C_COMPILER_LAUNCHER AND NOT CMAKE_CROSSCOMPILING) # call graphs (.ci) are not cached
    set(CMAKE_C_COMPILER_LAUNCHER ${CRN_CCACHE})
    # The cache stores objects that use a precompiled header only if it may ignore macros which that header defines and
    # the time of compilation. No source here uses either.
    set(CMAKE_CXX_COMPILER_LAUNCHER env CCACHE_SLOPPINESS=pch_defines,time_macros ${CRN_CCACHE})
endif()

# The headers with which most C++ files begin are precompiled. A precompiled header fits one set of flags, so there is
# one for each level, and for code that hides its symbols and code that does not.
set(CRN_PREFIX_HEADERS ON CACHE BOOL "precompile the headers that most C++ files begin with")

add_library(crn_common INTERFACE)
target_compile_options(crn_common INTERFACE
    # Builds in every folder give the same bytes, because the compiler records this folder as "."
    # (docs/dependencies.md).
    -ffile-prefix-map=${PROJECT_SOURCE_DIR}=.
    ${CRN_DEBUG} -Wall -Wextra -Wshadow -Werror
    $<$<COMPILE_LANGUAGE:C>:-Wpedantic> $<$<COMPILE_LANGUAGE:C>:-Wvla> $<$<COMPILE_LANGUAGE:C>:-Wmissing-prototypes>
    $<$<COMPILE_LANGUAGE:CXX>:-ffp-contract=off>)
target_include_directories(crn_common SYSTEM INTERFACE /usr/include/eigen3)
target_link_options(crn_common INTERFACE -pthread)
# All objects can become part of a shared library, so that libcournand needs no second compilation. CMake's own property
# would compile programs with -fPIE, and the compiler refuses a precompiled header of the libraries there.
if(NOT CMAKE_CROSSCOMPILING)
    target_compile_options(crn_common INTERFACE -fPIC)
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU)
    # gcc 12 at -O3 warns of overlapping copies in std::string's operator+ that do not exist (its bug 105329). With a
    # precompiled header it no longer recognises that they are in its own library. clang still reports real ones.
    target_compile_options(crn_common INTERFACE $<$<COMPILE_LANGUAGE:CXX>:-Wno-restrict>)
    # The compiler collects its own garbage less often, which saves a tenth of its time and takes 0.2 GB more memory.
    target_compile_options(crn_common INTERFACE "$<$<COMPILE_LANGUAGE:CXX>:SHELL:--param ggc-min-heapsize=524288>")
    if(CRN_PREFIX_HEADERS)
        target_compile_options(crn_common INTERFACE $<$<COMPILE_LANGUAGE:CXX>:-fpch-preprocess> # for ccache
            $<$<COMPILE_LANGUAGE:CXX>:-Wno-array-bounds>
            $<$<COMPILE_LANGUAGE:CXX>:-Wno-stringop-overflow> $<$<COMPILE_LANGUAGE:CXX>:-Wno-stringop-overread>)
    endif()
endif()
if(CMAKE_CXX_COMPILER_ID STREQUAL Clang AND CRN_PREFIX_HEADERS)
    # A compiler cache needs a precompiled header that does not contain the time.
    target_compile_options(crn_common INTERFACE "$<$<COMPILE_LANGUAGE:CXX>:SHELL:-Xclang -fno-pch-timestamp>")
endif()
find_program(CRN_LLD ld.lld)
if(CRN_LLD AND NOT CMAKE_CROSSCOMPILING)
    target_link_options(crn_common INTERFACE -fuse-ld=lld)
endif()
if(CRN_SANITIZE)
    # The fuzzers' hooks are in all objects, because they cost tests little.
    target_compile_options(crn_common INTERFACE -fsanitize=fuzzer-no-link,${CRN_SANITIZE}
        -fno-sanitize-recover=all -fno-omit-frame-pointer)
    target_link_options(crn_common INTERFACE -fsanitize=${CRN_SANITIZE})
endif()
if(CRN_SANITIZE_GCC)
    target_compile_options(crn_common INTERFACE -fsanitize=${CRN_SANITIZE_GCC} -fno-sanitize-recover=all
        -fno-omit-frame-pointer)
    target_link_options(crn_common INTERFACE -fsanitize=${CRN_SANITIZE_GCC})
endif()
string(REPLACE ":" ";" crn_usb_id ${CRN_USB_ID})
list(GET crn_usb_id 0 crn_vendor)
list(GET crn_usb_id 1 crn_product)
target_compile_definitions(crn_common INTERFACE CRN_USB_VENDOR_ID=0x${crn_vendor} CRN_USB_PRODUCT_ID=0x${crn_product})

# Loops over pixels become vector code, and neither flag changes a value.
if(CRN_SANITIZE)
    set(CRN_PIXELS "-O1 -fno-math-errno -fno-trapping-math")
else()
    set(CRN_PIXELS "-O3 -fno-math-errno -fno-trapping-math")
endif()
# Rooms that draw, write tables or keep records compute little. This level saves a fifth of the compiler's time.
if(CRN_SANITIZE)
    set(CRN_LIGHT -O0)
elseif(CRN_QUICK)
    set(CRN_LIGHT -O1)
endif()
# Sanitized rooms are compiled without optimisation, which takes two thirds of the time, except these, which compute,
# and their tests: the linker takes an inline function of Eigen from the first object that has it, which is the test's.
set(CRN_COMPUTING host/model host/effects host/stent host/patient hil_tests/plant)
# Fuzzers enter these rooms first. Elsewhere they learn little from comparisons, and tracing those doubles the time.
set(CRN_FUZZED firmware/app firmware/app/safety firmware/app/haptics firmware/app/usb shared/scene host/base host/link
    host/session tools/mesh/files tools/centreline)
# gcc's scheduling makes the core slower rather than faster (docs/bench.md).
set(CRN_CORE "${CRN_CORE_OPT} -ffreestanding")
if(CMAKE_C_COMPILER_ID STREQUAL GNU)
    string(APPEND CRN_CORE " -fno-schedule-insns -fno-tree-pre")
endif()

function(crn_prefix_header target level)
    if(NOT CRN_PREFIX_HEADERS)
        return()
    endif()
    get_target_property(sources ${target} SOURCES)
    if(NOT "${sources}" MATCHES "\\.cpp")
        return()
    endif()
    foreach(source ${sources})
        if(source MATCHES "\\.c$")
            set_source_files_properties(${source} PROPERTIES SKIP_PRECOMPILE_HEADERS ON SKIP_UNITY_BUILD_INCLUSION ON)
        endif()
    endforeach()
    string(MAKE_C_IDENTIFIER "crn_prefix_${CMAKE_CXX_VISIBILITY_PRESET}_${level}" owner)
    if(NOT TARGET ${owner})
        file(WRITE ${PROJECT_BINARY_DIR}/${owner}.cpp "")
        add_library(${owner} OBJECT ${PROJECT_BINARY_DIR}/${owner}.cpp)
        crn_flags(${owner} "${level}")
        target_precompile_headers(${owner} PRIVATE <Eigen/Core> <Eigen/Geometry> <algorithm> <array> <cmath>
            <cstdint> <cstdio> <filesystem> <fstream> <functional> <map> <memory> <optional> <set> <span> <sstream>
            <string> <thread> <vector>)
    endif()
    target_precompile_headers(${target} REUSE_FROM ${owner})
endfunction()
