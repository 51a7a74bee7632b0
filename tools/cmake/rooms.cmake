# A room is a folder with one library, its programs and its tests. Its CMakeLists.txt is one short list:
#
#   crn_room(SOURCES a.cpp b.cpp USES host/base shared/wire PACKAGES png TESTS tests/test_a.cpp)
#   crn_program(cournand SOURCES main.cpp USES host/command)
#
# TOGETHER compiles all sources of the room as one unit, which takes about half of the compiler's time. It requires that
# no local name occurs twice. CRN_TOGETHER=OFF compiles each source by itself, which is faster while one is edited. USES
# names other rooms by their folder, and PACKAGES names those of packages.cmake. An include path is always relative to
# the root. test_layers.py checks what a room may include; the linker checks that USES is complete.
include_guard()

# Returns the folder of the present list, relative to the root: "host/model".
macro(crn_folder variable)
    file(RELATIVE_PATH ${variable} ${PROJECT_SOURCE_DIR} ${CMAKE_CURRENT_SOURCE_DIR})
endmacro()

function(crn_target_of variable folder)
    string(REPLACE "/" "_" name ${folder})
    set(${variable} crn_${name} PARENT_SCOPE)
endfunction()

# Sets the flags of every object, and the level of this target. LEVEL ("-O3 -fno-math-errno ...") replaces the usual
# one.
function(crn_flags target level)
    target_include_directories(${target} PRIVATE ${PROJECT_SOURCE_DIR})
    if(NOT level)
        set(level ${CRN_OPT})
    endif()
    separate_arguments(level)
    target_compile_options(${target} PRIVATE ${level})
    target_link_libraries(${target} PRIVATE crn_common)
endfunction()

# Code that runs once (command lines, tests) is compiled quickly, at this level.
function(crn_quick target level)
    if(NOT CRN_QUICK)
        set(level ${CRN_OPT})
    endif()
    crn_flags(${target} ${level})
    crn_prefix_header(${target} ${level})
endfunction()

# Compiles single sources at another level than the rest of their target.
function(crn_sources_at level)
    set_source_files_properties(${ARGN} PROPERTIES COMPILE_OPTIONS "${level}" SKIP_PRECOMPILE_HEADERS ON)
endfunction()

# A source of a program that measures is compiled with the level of the product.
function(crn_optimised)
    crn_sources_at(-O2 ${ARGN})
endfunction()

function(crn_uses target scope)
    foreach(folder ${ARGN})
        crn_target_of(used ${folder})
        target_link_libraries(${target} ${scope} ${used})
    endforeach()
endfunction()

function(crn_packages target scope)
    foreach(package ${ARGN})
        crn_package(${package})
        target_link_libraries(${target} ${scope} crn_package_${package})
    endforeach()
endfunction()

function(crn_room)
    cmake_parse_arguments(ROOM "TOGETHER" "LEVEL" "SOURCES;USES;PACKAGES;TESTS;TEST_USES;LABELS" ${ARGN})
    crn_folder(folder)
    crn_target_of(target ${folder})
    string(REPLACE "/" "_" archive ${folder})
    add_library(${target} STATIC ${ROOM_SOURCES})
    set_target_properties(${target} PROPERTIES OUTPUT_NAME ${archive}
        ARCHIVE_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib)
    if(CRN_SANITIZE AND NOT ROOM_LEVEL AND "${ROOM_SOURCES}" MATCHES "\\.cpp" AND NOT folder IN_LIST CRN_COMPUTING)
        set(ROOM_LEVEL -O0)
    endif()
    crn_flags(${target} "${ROOM_LEVEL}")
    if(CRN_SANITIZE AND NOT folder IN_LIST CRN_FUZZED)
        target_compile_options(${target} PRIVATE -fno-sanitize-coverage=trace-cmp)
    endif()
    crn_uses(${target} PUBLIC ${ROOM_USES})
    crn_packages(${target} PUBLIC ${ROOM_PACKAGES})
    crn_prefix_header(${target} "${ROOM_LEVEL}")
    if(ROOM_TOGETHER AND CRN_TOGETHER)
        set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0)
    endif()
    if(ROOM_TESTS)
        set(level "")
        if("${ROOM_LEVEL}" STREQUAL "${CRN_PIXELS}") # its tests look at pixels, and would run longer than they compile
            set(level -O1)
        endif()
        crn_tests(SOURCES ${ROOM_TESTS} USES ${folder} ${ROOM_TEST_USES} LABELS ${ROOM_LABELS} LEVEL ${level})
    endif()
endfunction()

# Adds a program in bin/. IN names another folder below the build, for programs outside the product. UNUSED: not part
# of `all`.
function(crn_program name)
    cmake_parse_arguments(PROGRAM "" "IN" "SOURCES;USES;PACKAGES" ${ARGN})
    if(NOT PROGRAM_IN)
        set(PROGRAM_IN bin)
    endif()
    add_executable(${name} ${PROGRAM_SOURCES})
    set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/${PROGRAM_IN})
    crn_quick(${name} -O0)
    crn_uses(${name} PRIVATE ${PROGRAM_USES})
    crn_packages(${name} PRIVATE ${PROGRAM_PACKAGES})
    if(PROGRAM_IN STREQUAL bench)
        if(NOT TARGET crn_benches)
            add_custom_target(crn_benches)
        endif()
        add_dependencies(crn_benches ${name})
    endif()
    if(PROGRAM_IN STREQUAL bin)
        set_property(GLOBAL APPEND PROPERTY CRN_PROGRAMS ${name})
    endif()
endfunction()

# Adds CMocka programs, one per C source: test/FOLDER/NAME below the build. All C++ sources together become one program,
# and each of their names is a link to it: the program runs the file by whose name it was called. One unit takes half of
# the time of single ones. It requires that no local name occurs twice in a call of this function. APART: sources that
# stay single. EXTRA: sources that every program contains.
function(crn_tests)
    if(NOT CRN_HAS_TESTS)
        return()
    endif()
    cmake_parse_arguments(TEST "APART" "LEVEL" "SOURCES;USES;PACKAGES;EXTRA;LABELS" ${ARGN})
    crn_folder(folder)
    if(NOT TEST_LEVEL)
        set(TEST_LEVEL ${CRN_TEST_OPT})
        if(CRN_SANITIZE AND folder IN_LIST CRN_COMPUTING)
            set(TEST_LEVEL -O1)
        endif()
    endif()
    set(joined ${TEST_SOURCES})
    list(FILTER joined INCLUDE REGEX "\\.cpp$")
    list(LENGTH joined count)
    if(count GREATER 1 AND CRN_TOGETHER AND NOT TEST_APART)
        list(REMOVE_ITEM TEST_SOURCES ${joined})
        crn_joined_tests(${joined})
    endif()
    foreach(source ${TEST_SOURCES})
        crn_test_name(name ${source})
        string(REPLACE "/" "_" target test_${name})
        crn_test_program(${target} ${name} ${source})
        crn_register(${name} $<TARGET_FILE:${target}> "${TEST_LABELS}")
    endforeach()
endfunction()

# Returns the name of the test with this source: FOLDER/tests/test_a.
macro(crn_test_name variable source)
    cmake_path(REMOVE_EXTENSION source OUTPUT_VARIABLE place)
    set(${variable} ${folder}/${place})
endmacro()

# Uses the arguments of crn_tests.
macro(crn_test_program target name source)
    add_executable(${target} ${source} ${TEST_EXTRA})
    set(program "${name}")
    cmake_path(GET program FILENAME file)
    cmake_path(GET program PARENT_PATH below)
    set_target_properties(${target} PROPERTIES OUTPUT_NAME ${file}
        RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/test/${below})
    if("${source}" MATCHES "\\.c$" AND CRN_SANITIZE) # references in double and 128 bits run long
        crn_quick(${target} -O1)
    else()
        crn_quick(${target} ${TEST_LEVEL})
    endif()
    crn_uses(${target} PRIVATE ${TEST_USES})
    crn_packages(${target} PRIVATE cmocka ${TEST_PACKAGES})
    crn_needed_by_tests("${TEST_LABELS}" ${target})
endmacro()

# Uses the arguments of crn_tests, too.
macro(crn_joined_tests)
    string(REPLACE "/" "_" all tests_${folder})
    if(TARGET test_${all}) # another call of this list made it
        string(APPEND all _more)
    endif()
    set(tests "")
    set(table "")
    set(links "")
    foreach(source ${ARGN})
        crn_test_name(name ${source})
        cmake_path(GET name FILENAME file)
        cmake_path(GET name PARENT_PATH below)
        string(APPEND tests "#define main main_of_${file}\n#include \"${folder}/${source}\"\n#undef main\n")
        string(APPEND table "    {\"${file}\", main_of_${file}},\n")
        list(APPEND links COMMAND ${CMAKE_COMMAND} -E create_symlink ${all}
            ${PROJECT_BINARY_DIR}/test/${below}/${file})
        crn_register(${name} ${PROJECT_BINARY_DIR}/test/${name} "${TEST_LABELS}")
        string(REPLACE "/" "_" single test_${name}) # `ninja` builds a test by its name, joined or not
        add_custom_target(${single} DEPENDS test_${all})
    endforeach()
    set(unit ${CMAKE_CURRENT_BINARY_DIR}/${all}.cpp)
    configure_file(${PROJECT_SOURCE_DIR}/tools/cmake/tests_of_room.cpp.in ${unit} @ONLY)
    crn_test_program(test_${all} ${below}/${all} ${unit})
    add_custom_command(TARGET test_${all} POST_BUILD ${links})
endmacro()

# Adds executable scripts that print TAP, run from the root with BUILD in their environment. NEEDS: targets that they
# run.
function(crn_scripts)
    if(NOT CRN_HAS_TESTS OR CRN_SANITIZE)
        return()
    endif()
    cmake_parse_arguments(SCRIPT "" "" "SOURCES;NEEDS;LABELS" ${ARGN})
    crn_folder(folder)
    foreach(source ${SCRIPT_SOURCES})
        cmake_path(SET name NORMALIZE ${folder}/${source})
        crn_register(${name} ${PROJECT_SOURCE_DIR}/${name} "${SCRIPT_LABELS};script")
    endforeach()
    if(SCRIPT_NEEDS)
        crn_needed_by_tests("${SCRIPT_LABELS}" ${SCRIPT_NEEDS})
    endif()
endfunction()

function(crn_needed_by_tests labels)
    if("lab" IN_LIST labels OR (CRN_SANITIZE AND "sanitized_in_lab" IN_LIST labels))
        add_dependencies(crn_tests_lab ${ARGN})
    else()
        add_dependencies(crn_tests ${ARGN})
    endif()
endfunction()

# Sets labels: `lab` for evidence, `hours` for tests that take long, `product` for all other tests, and `sanitized` in
# the sanitizers' build. `make test` sanitizes the C code, parsers and state machines. What computes has the label
# `sanitized_in_lab`: `make test` runs it plain, and `make test-lab` runs it under the sanitizers.
function(crn_register name command labels)
    if(CRN_SANITIZE)
        list(APPEND labels sanitized)
        if("sanitized_in_lab" IN_LIST labels)
            list(APPEND labels lab)
        endif()
    endif()
    if(NOT "lab" IN_LIST labels AND NOT "hours" IN_LIST labels)
        list(APPEND labels product)
    endif()
    add_test(NAME ${name} COMMAND ${command} WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
    set_tests_properties(${name} PROPERTIES LABELS "${labels}" TIMEOUT 600 ENVIRONMENT
        "BUILD=${CRN_BUILD_NAME};PACKAGES=skip;CMOCKA_MESSAGE_OUTPUT=TAP")
endfunction()

# Adds a libFuzzer target and the program that writes its first inputs, in the sanitizers' build only. With the label
# `lab`, `make test-lab` runs it in place of `make test`.
function(crn_fuzz source)
    if(NOT CRN_HAS_TESTS OR NOT CRN_SANITIZE)
        return()
    endif()
    cmake_parse_arguments(FUZZ "" "" "SOURCES;USES;PACKAGES;LABELS" ${ARGN})
    if(NOT FUZZ_LABELS)
        set(FUZZ_LABELS product)
    endif()
    crn_folder(folder)
    cmake_path(REMOVE_EXTENSION source OUTPUT_VARIABLE place)
    set(name ${folder}/${place})
    string(REPLACE "/" "_" target fuzz_${name})
    cmake_path(GET place FILENAME file)
    cmake_path(GET place PARENT_PATH below)
    add_library(${target}_objects OBJECT ${source} ${FUZZ_SOURCES})
    crn_flags(${target}_objects "-O2")
    foreach(kind "" _seeds)
        add_executable(${target}${kind} $<TARGET_OBJECTS:${target}_objects>)
        if(kind)
            target_sources(${target}${kind} PRIVATE ${PROJECT_SOURCE_DIR}/tools/check/fuzz_seeds.c)
        else()
            target_link_options(${target} PRIVATE -fsanitize=fuzzer)
        endif()
        set_target_properties(${target}${kind} PROPERTIES OUTPUT_NAME ${file}${kind} LINKER_LANGUAGE CXX
            RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/test/${folder}/${below})
        crn_flags(${target}${kind} "-O2")
        crn_uses(${target}${kind} PRIVATE ${FUZZ_USES})
        crn_packages(${target}${kind} PRIVATE ${FUZZ_PACKAGES})
        add_dependencies(crn_fuzzers ${target}${kind})
        if(NOT FUZZ_LABELS STREQUAL product)
            add_dependencies(crn_tests_lab ${target}${kind})
        else()
            add_dependencies(crn_fuzzers_product ${target}${kind})
        endif()
    endforeach()
    add_test(NAME fuzz/${name} COMMAND $<TARGET_FILE:${target}> -max_total_time=3
        WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
    set_tests_properties(fuzz/${name} PROPERTIES LABELS "${FUZZ_LABELS};fuzz")
endfunction()
