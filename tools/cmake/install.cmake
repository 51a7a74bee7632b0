# `cmake --install` (make install) installs below PREFIX: programs with man pages and completion scripts, libraries
# with their headers, scenes and instruments. For other projects it installs pkg-config files and a CMake package for
# the C library (docs/library.md), the core and the host:
#
#   find_package(cournand CONFIG REQUIRED)            pkg-config --cflags --libs cournand
#   target_link_libraries(mine cournand::cournand)    pkg-config --cflags --libs cournand-core
#   target_link_libraries(mine cournand::core)        pkg-config --cflags --libs --static cournand-host
#
# The C library has one header, cournand.h. Those of core and host keep their paths: #include "firmware/core/core.h"
# below include/cournand.
include_guard()
set(CMAKE_INSTALL_LIBDIR lib CACHE PATH "libraries below PREFIX")
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

set(include_folder ${CMAKE_INSTALL_INCLUDEDIR}/cournand)

# The core is freestanding, for a rig's firmware or another host program. The host contains all parts of `cournand`.
set(CRN_CORE_ROOMS firmware/core)
set(CRN_HOST_ROOMS shared/wire shared/scene firmware/app/safety firmware/app/haptics firmware/app firmware/port/sim
    host/base host/model host/link host/effects host/stent host/xray/paths host/xray/volume
    host/xray host/xray/style host/xray/gl host/room host/dicom host/patient host/rig host/script host/session
    host/report/figures host/cases host/picture host/report host/assess)

# Archives are in link order: each comes before those that it uses.
function(crn_install_archives rooms name)
    set(archives "")
    foreach(room ${rooms})
        crn_target_of(target ${room})
        install(TARGETS ${target} ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}/cournand COMPONENT ${name})
        file(GLOB headers ${PROJECT_SOURCE_DIR}/${room}/*.h ${PROJECT_SOURCE_DIR}/${room}/*.hpp
            ${PROJECT_SOURCE_DIR}/${room}/*.def)
        install(FILES ${headers} DESTINATION ${include_folder}/${room} COMPONENT ${name})
        string(REPLACE "/" "_" archive ${room})
        list(PREPEND archives ${archive})
    endforeach()
    set(${name}_archives "${archives}" PARENT_SCOPE)
endfunction()

crn_install_archives("${CRN_CORE_ROOMS}" core)
crn_install_archives("${CRN_HOST_ROOMS}" host)
# `cmake --install build --component programs` installs the programs with all that they read.
macro(crn_install_programs)
    install(${ARGN} COMPONENT programs)
endmacro()
install(FILES firmware/core/near/near.h DESTINATION ${include_folder}/firmware/core/near COMPONENT core)
install(FILES shared/version.h DESTINATION ${include_folder}/shared COMPONENT core)
install(FILES firmware/port/port.h firmware/port/port_built.h firmware/port/udc.h
    DESTINATION ${include_folder}/firmware/port COMPONENT core)
install(FILES firmware/port/mps2_an500/rig_page.h DESTINATION ${include_folder}/firmware/port/mps2_an500
    COMPONENT core)
crn_install_programs(DIRECTORY shared/examples/instruments shared/examples/sessions shared/examples/stents
    shared/examples/lesions shared/examples/scenes shared/examples/anatomies shared/examples/assessments
    shared/examples/cases shared/examples/records
    DESTINATION ${CMAKE_INSTALL_DATADIR}/cournand/examples)
# The program opens this library (host/records).
crn_install_programs(TARGETS records_postgres LIBRARY DESTINATION lib/cournand)
crn_install_programs(FILES LICENSE NOTICE README.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
crn_install_programs(FILES tools/udev/60-cournand.rules DESTINATION ${CMAKE_INSTALL_DATADIR}/cournand)
# The entry in the menu of a desktop, and its icon.
crn_install_programs(FILES tools/desktop/cournand.desktop DESTINATION ${CMAKE_INSTALL_DATADIR}/applications)
crn_install_programs(FILES tools/desktop/cournand.svg
    DESTINATION ${CMAKE_INSTALL_DATADIR}/icons/hicolor/scalable/apps)
get_property(programs GLOBAL PROPERTY CRN_PROGRAMS)
foreach(program cournand anatomy bake centreline)
    if(TARGET ${program})
        crn_install_programs(TARGETS ${program} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
        # Each program writes its man pages and completion scripts itself, from its table of options.
        install(CODE "execute_process(COMMAND \"$<TARGET_FILE:${program}>\" --generate share
            \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DATADIR}\" COMMAND_ERROR_IS_FATAL ANY)"
            COMPONENT programs)
    endif()
endforeach()

set(CRN_HOST_SYSTEM_LIBRARIES "-larchive -lpng -lopenh264 -lusb-1.0 -ldcmdata -lofstd -lccd -ldl -lm -pthread")
foreach(library ${core_archives})
    string(APPEND CRN_CORE_LIBRARIES " -l${library}")
endforeach()
foreach(library ${host_archives})
    string(APPEND CRN_HOST_LIBRARIES " -l${library}")
endforeach()
# What a program needs besides the static C library.
set(CRN_LIBRARY_NEEDS "-lccd -lusb-1.0 -lstdc++ -lm -ldl -pthread")

# Sets `up` to the relative path from a folder below PREFIX to PREFIX.
macro(crn_way_up folder)
    string(REGEX REPLACE "[^/]+" ".." up ${folder})
endmacro()

# Installs the C library below the folder LIBRARIES of PREFIX as the component NAME. More words are options for
# install().
function(crn_install_library name libraries)
    set(CMAKE_INSTALL_LIBDIR ${libraries}) # the templates write it
    set(described ${PROJECT_BINARY_DIR}/${name})
    crn_way_up(${libraries}/pkgconfig)
    set(more COMPONENT ${name} ${ARGN})
    install(TARGETS cournand_shared LIBRARY DESTINATION ${libraries} COMPONENT ${name} NAMELINK_COMPONENT ${name}
        ${ARGN} PUBLIC_HEADER DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} ${more})
    install(FILES ${PROJECT_BINARY_DIR}/lib/libcournand.a DESTINATION ${libraries} ${more})
    install(DIRECTORY host/library/examples/ DESTINATION ${CMAKE_INSTALL_DATADIR}/cournand/examples/library ${more})
    configure_file(tools/cmake/cournand.pc.in ${described}/cournand.pc @ONLY)
    install(FILES ${described}/cournand.pc DESTINATION ${libraries}/pkgconfig ${more})
    configure_package_config_file(tools/cmake/cournand-config.cmake.in ${described}/cournand-config.cmake
        INSTALL_DESTINATION ${libraries}/cmake/cournand PATH_VARS include_folder)
    write_basic_package_version_file(${described}/cournand-config-version.cmake COMPATIBILITY SameMinorVersion)
    install(FILES ${described}/cournand-config.cmake ${described}/cournand-config-version.cmake
        DESTINATION ${libraries}/cmake/cournand ${more})
endfunction()

# `cmake --install build --component library` installs the C library alone. The component `debian` is the same library
# where Debian has libraries: in a folder for each kind of processor (tools/deb).
crn_install_library(library ${CMAKE_INSTALL_LIBDIR})
if(CMAKE_LIBRARY_ARCHITECTURE)
    crn_install_library(debian lib/${CMAKE_LIBRARY_ARCHITECTURE} EXCLUDE_FROM_ALL)
endif()
crn_way_up(${CMAKE_INSTALL_LIBDIR}/pkgconfig)
foreach(part core host)
    configure_file(tools/cmake/cournand-${part}.pc.in ${PROJECT_BINARY_DIR}/cournand-${part}.pc @ONLY)
    install(FILES ${PROJECT_BINARY_DIR}/cournand-${part}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig
        COMPONENT ${part})
endforeach()
