# SPDX-License-Identifier: BSD-3-Clause
# The program stands in the root of the build folder; `cmake --install` takes it, the online library and its C header.
if(NOT TARGET signorom AND EXISTS "${PROJECT_SOURCE_DIR}/src/main.F90")
  add_executable(signorom src/main.F90)
  target_link_libraries(signorom PRIVATE sig_app sig_flags)
  set_target_properties(signorom PROPERTIES
    RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}"
    Fortran_MODULE_DIRECTORY "${PROJECT_BINARY_DIR}/main_modules")
endif()
if(TARGET signorom)
  install(TARGETS signorom)
endif()
if(TARGET signorom_online)
  set_target_properties(signorom_online PROPERTIES VERSION ${PROJECT_VERSION} SOVERSION ${PROJECT_VERSION_MAJOR})
  install(TARGETS signorom_online)
endif()
if(EXISTS "${PROJECT_SOURCE_DIR}/include/signorom.h")
  install(FILES include/signorom.h TYPE INCLUDE)
endif()
