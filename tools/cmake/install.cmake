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
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/cournand)

# The core is freestanding, for a rig's firmware or another host program. The host contains all parts of `cournand`.
set(CRN_CORE_ROOMS firmware/core)
set(CRN_HOST_ROOMS shared/wire shared/scene firmware/app/safety firmware/app/haptics firmware/app firmware/port/sim
    host/base host/model host/link host/effects host/stent host/xray/paths host/xray
    host/xray/style host/xray/gl host/room host/dicom host/patient host/rig host/script host/session
    host/cases host/picture host/report host/assess)

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
install(FILES shared/version.h DESTINATION ${include_folder}/shared)
install(FILES firmware/port/port.h firmware/port/port_built.h firmware/port/udc.h
    DESTINATION ${include_folder}/firmware/port)
install(FILES firmware/port/mps2_an500/rig_page.h DESTINATION ${include_folder}/firmware/port/mps2_an500)
install(DIRECTORY shared/examples/instruments shared/examples/sessions shared/examples/stents shared/examples/lesions
    shared/examples/scenes shared/examples/anatomies shared/examples/assessments
    shared/examples/cases shared/examples/records
    DESTINATION ${CMAKE_INSTALL_DATADIR}/cournand/examples)
install(TARGETS records_postgres LIBRARY DESTINATION lib/cournand) # opened by the program (host/records)
install(FILES LICENSE NOTICE README.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(FILES tools/udev/60-cournand.rules DESTINATION ${CMAKE_INSTALL_DATADIR}/cournand)
get_property(programs GLOBAL PROPERTY CRN_PROGRAMS)
foreach(program cournand anatomy bake centreline)
    if(TARGET ${program})
        install(TARGETS ${program} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
        # Each program writes its man pages and completion scripts itself, from its table of options.
        install(CODE "execute_process(COMMAND \"$<TARGET_FILE:${program}>\" --generate share
            \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DATADIR}\" COMMAND_ERROR_IS_FATAL ANY)")
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
# `cmake --install build --component library` installs the C library alone.
install(TARGETS cournand_shared LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library
    NAMELINK_COMPONENT library PUBLIC_HEADER DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT library)
install(FILES ${PROJECT_BINARY_DIR}/lib/libcournand.a DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library)
install(DIRECTORY host/library/examples/ DESTINATION ${CMAKE_INSTALL_DATADIR}/cournand/examples/library
    COMPONENT library)
configure_file(tools/cmake/cournand.pc.in ${PROJECT_BINARY_DIR}/cournand.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/cournand.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT library)
foreach(part core host)
    configure_file(tools/cmake/cournand-${part}.pc.in ${PROJECT_BINARY_DIR}/cournand-${part}.pc @ONLY)
    install(FILES ${PROJECT_BINARY_DIR}/cournand-${part}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
endforeach()
configure_package_config_file(tools/cmake/cournand-config.cmake.in ${PROJECT_BINARY_DIR}/cournand-config.cmake
    INSTALL_DESTINATION ${package_folder} PATH_VARS include_folder)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/cournand-config-version.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/cournand-config.cmake ${PROJECT_BINARY_DIR}/cournand-config-version.cmake
    DESTINATION ${package_folder})
install(FILES ${PROJECT_BINARY_DIR}/cournand-config.cmake ${PROJECT_BINARY_DIR}/cournand-config-version.cmake
    DESTINATION ${package_folder} COMPONENT library EXCLUDE_FROM_ALL)
