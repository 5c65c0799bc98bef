# SPDX-License-Identifier: BSD-3-Clause
# What `cmake --install` takes: the program, the online library with its C header and its pkg-config file.
if(TARGET signorom)
  install(TARGETS signorom)
endif()
set_target_properties(signorom_online PROPERTIES VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR})
install(TARGETS signorom_online)
# `cmake --install --prefix` chooses the prefix when all is built: the file finds it from its own place.
set(pc_folder "${CMAKE_INSTALL_LIBDIR}/pkgconfig")
file(RELATIVE_PATH SIG_PREFIX_FROM_PC "/${pc_folder}" "/")
configure_file("${PROJECT_SOURCE_DIR}/tools/cmake/signorom_online.pc.in" signorom_online.pc @ONLY)
install(FILES "${PROJECT_BINARY_DIR}/signorom_online.pc" DESTINATION "${pc_folder}")
