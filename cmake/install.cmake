# What `cmake --install` puts where, and the Debian packages that `cpack` makes of the same: one a
# component. docs/release.md.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# Manual pages and completion say what the options themselves say.
set(pages ${PROJECT_BINARY_DIR}/man1)
set(completion ${PROJECT_BINARY_DIR}/completion/sheen)
add_custom_command(
    OUTPUT ${pages}/sheen.1 ${completion}
    COMMAND ${CMAKE_COMMAND} -E make_directory ${pages} ${PROJECT_BINARY_DIR}/completion
    COMMAND sheen manual --output ${pages}
    COMMAND sheen completion > ${completion}
    DEPENDS sheen
    VERBATIM)
add_custom_target(sheen_manual ALL DEPENDS ${pages}/sheen.1 ${completion})

install(TARGETS sheen COMPONENT sheen)
install(DIRECTORY ${pages}/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT sheen)
install(FILES ${completion} DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions
        COMPONENT sheen)
install(FILES scenes/cornell_glossy.glb DESTINATION ${CMAKE_INSTALL_DATADIR}/sheen/scenes
        COMPONENT sheen)
install(FILES README.md CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/sheen COMPONENT sheen)

set(cmake_files ${CMAKE_INSTALL_LIBDIR}/cmake/Sheen)
install(TARGETS libsheen EXPORT SheenTargets
        LIBRARY COMPONENT libsheen NAMELINK_COMPONENT libsheen-dev)
install(DIRECTORY include/sheen DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT libsheen-dev)
install(EXPORT SheenTargets NAMESPACE Sheen:: DESTINATION ${cmake_files} COMPONENT libsheen-dev)
configure_package_config_file(cmake/SheenConfig.cmake.in SheenConfig.cmake
                              INSTALL_DESTINATION ${cmake_files})
write_basic_package_version_file(SheenConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/SheenConfig.cmake ${PROJECT_BINARY_DIR}/SheenConfigVersion.cmake
        DESTINATION ${cmake_files} COMPONENT libsheen-dev)
# From where the file lies, so that it is right wherever all is unpacked.
file(RELATIVE_PATH prefix_from_pc /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
configure_file(cmake/sheen.pc.in sheen.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/sheen.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig
        COMPONENT libsheen-dev)
install(DIRECTORY examples DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libsheen-dev
        COMPONENT libsheen-dev PATTERN "*.py" EXCLUDE)
install(FILES docs/library.md DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libsheen-dev
        COMPONENT libsheen-dev)

if(SHEEN_PYTHON)
    install(TARGETS sheen_python LIBRARY DESTINATION lib/python3/dist-packages
            COMPONENT python3-sheen)
    install(FILES examples/image.py DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/python3-sheen/examples
            COMPONENT python3-sheen)
endif()

# Packages of their own, so that the program brings no window system and no MPI.
set(sheen_components sheen libsheen libsheen-dev)
if(SHEEN_VIEWER)
    install(TARGETS sheen-viewer COMPONENT sheen-viewer)
    list(APPEND sheen_components sheen-viewer)
endif()
if(SHEEN_MPI)
    install(TARGETS sheen-mpi COMPONENT sheen-mpi)
    install(FILES docs/clusters.md DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/sheen-mpi COMPONENT sheen-mpi)
    list(APPEND sheen_components sheen-mpi)
endif()
if(SHEEN_PYTHON)
    list(APPEND sheen_components python3-sheen)
endif()

set(libsheen_package libsheen${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
foreach(component IN LISTS sheen_components)
    string(REGEX REPLACE "^libsheen$" "${libsheen_package}" folder ${component})
    install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${folder} RENAME copyright
            COMPONENT ${component})
endforeach()

# ---- Debian packages ------------------------------------------------------------------------------
set(SHEEN_MAINTAINER "Sheen <sheen@localhost>" CACHE STRING "Maintainer that packages name")
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_CONTACT "${SHEEN_MAINTAINER}")
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_COMPONENTS_ALL ${sheen_components})
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${PROJECT_BINARY_DIR}/src/library)

# sheen_package(COMPONENT SECTION DEPENDS WHAT), DEPENDS beside what libraries ask for
function(sheen_package component section depends what)
    string(TOUPPER ${component} name)
    set(package ${component})
    if(component STREQUAL libsheen)
        set(package ${libsheen_package})
    endif()
    foreach(pair "PACKAGE_NAME ${package}" "PACKAGE_SECTION ${section}" "PACKAGE_DEPENDS ${depends}"
                 "DESCRIPTION ${what}")
        string(FIND "${pair}" " " space)
        string(SUBSTRING "${pair}" 0 ${space} key)
        math(EXPR space "${space} + 1")
        string(SUBSTRING "${pair}" ${space} -1 value)
        set(CPACK_DEBIAN_${name}_${key} "${value}" PARENT_SCOPE)
    endforeach()
endfunction()
set(same "${libsheen_package} (= ${PROJECT_VERSION})")
sheen_package(sheen graphics "" "The program: renders, bakes and compares from the command line.")
sheen_package(libsheen libs "" "The library, as programs that use it need it.")
sheen_package(libsheen-dev libdevel "${same}" "Headers for C and C++, CMake and pkg-config files, examples.")
sheen_package(sheen-viewer graphics "sheen (= ${PROJECT_VERSION})" "The window that `sheen view` opens.")
if(SHEEN_MPI)
    sheen_package(sheen-mpi graphics "sheen (= ${PROJECT_VERSION}), openmpi-bin"
                  "What `sheen` becomes under mpirun: work shared out over many machines.")
endif()
if(SHEEN_PYTHON)
    math(EXPR next "${Python3_VERSION_MINOR} + 1")
    sheen_package(
        python3-sheen python
        "${same}, python3 (>= 3.${Python3_VERSION_MINOR}), python3 (<< 3.${next}), python3-numpy"
        "The Python module: numpy arrays in and out.")
endif()
include(CPack)
