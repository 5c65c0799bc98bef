# SPDX-License-Identifier: BSD-3-Clause
# What `cmake --install` takes: the program with its decks and meshes, the online library, and what hosts of the library need.
set_target_properties(signorom_online PROPERTIES SOVERSION ${PROJECT_VERSION_MAJOR})
if(SKBUILD) # a wheel has no symbolic links; the library stands inside the Python package
  install(TARGETS signorom_online signorom_fmu LIBRARY DESTINATION signorom_post/lib NAMELINK_SKIP)
  return()
endif()
set_target_properties(signorom_online PROPERTIES VERSION ${PROJECT_VERSION})

include(CMakePackageConfigHelpers)
target_include_directories(signorom_online INTERFACE "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>")
# Compiled modules of Fortran belong to one compiler, so hosts compile the source.
add_library(signorom_online_fortran INTERFACE)
target_sources(signorom_online_fortran INTERFACE
  "$<INSTALL_INTERFACE:$<INSTALL_PREFIX>/${CMAKE_INSTALL_INCLUDEDIR}/signorom.f90>")
target_link_libraries(signorom_online_fortran INTERFACE signorom_online)
set_target_properties(signorom_online PROPERTIES EXPORT_NAME online)
set_target_properties(signorom_online_fortran PROPERTIES EXPORT_NAME online_fortran)

install(TARGETS signorom_online EXPORT signorom_targets
  LIBRARY COMPONENT library NAMELINK_COMPONENT development
  PUBLIC_HEADER COMPONENT development)
install(TARGETS signorom_fmu LIBRARY COMPONENT library) # signorom-post fmu copies it
install(TARGETS signorom_online_fortran EXPORT signorom_targets COMPONENT development)
install(FILES "${PROJECT_SOURCE_DIR}/include/signorom.f90" DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}" COMPONENT development)

# find_package(signorom): the targets signorom::online and signorom::online_fortran
set(config_folder "${CMAKE_INSTALL_LIBDIR}/cmake/signorom")
install(EXPORT signorom_targets NAMESPACE signorom:: FILE signorom-config.cmake DESTINATION "${config_folder}"
  COMPONENT development)
write_basic_package_version_file("${PROJECT_BINARY_DIR}/signorom-config-version.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/signorom-config-version.cmake" DESTINATION "${config_folder}" COMPONENT development)

# `cmake --install --prefix` chooses the prefix when all is built: the file finds it from its own place.
set(pc_folder "${CMAKE_INSTALL_LIBDIR}/pkgconfig")
file(RELATIVE_PATH SIG_PREFIX_FROM_PC "/${pc_folder}" "/")
configure_file("${PROJECT_SOURCE_DIR}/tools/cmake/signorom_online.pc.in" signorom_online.pc @ONLY)
install(FILES "${PROJECT_BINARY_DIR}/signorom_online.pc" DESTINATION "${pc_folder}" COMPONENT development)

if(TARGET signorom)
  install(TARGETS signorom RUNTIME COMPONENT program)
  # a deck finds its mesh beside its folder
  install(DIRECTORY "${PROJECT_SOURCE_DIR}/input" DESTINATION "${CMAKE_INSTALL_DATADIR}/signorom" COMPONENT program
    FILES_MATCHING PATTERN "*.yaml" PATTERN "*.csv" PATTERN "*.json" PATTERN "compare" EXCLUDE)
  install(DIRECTORY "${PROJECT_SOURCE_DIR}/meshes" DESTINATION "${CMAKE_INSTALL_DATADIR}/signorom" COMPONENT program
    FILES_MATCHING PATTERN "*.msh" PATTERN "*.geo")
  include(SigPackages)
endif()
