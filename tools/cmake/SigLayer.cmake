# SPDX-License-Identifier: BSD-3-Clause
# sig_add_layer(<name> SOURCES <file>... [USES <library>...])
# One static library sig_<name> with a module folder of its own: a `use` of a layer that is not in USES does not compile.
function(sig_add_layer name)
  cmake_parse_arguments(LAYER "" "" "SOURCES;USES" ${ARGN})
  if(NOT LAYER_SOURCES)
    add_library(sig_${name} INTERFACE)
    target_link_libraries(sig_${name} INTERFACE ${LAYER_USES})
    return()
  endif()
  add_library(sig_${name} STATIC ${LAYER_SOURCES})
  # Only .F90 files have macros. Without this line Ninja runs the preprocessor for all files before it compiles any.
  set(files_with_macros ${LAYER_SOURCES})
  list(FILTER files_with_macros INCLUDE REGEX "\\.F90$")
  set_source_files_properties(${files_with_macros} PROPERTIES Fortran_PREPROCESS ON)
  set_target_properties(sig_${name} PROPERTIES
    Fortran_PREPROCESS OFF
    Fortran_MODULE_DIRECTORY "${CMAKE_CURRENT_BINARY_DIR}/modules")
  target_include_directories(sig_${name} PUBLIC
    "${CMAKE_CURRENT_BINARY_DIR}/modules" "${PROJECT_SOURCE_DIR}/include")
  target_link_libraries(sig_${name} PUBLIC ${LAYER_USES} PRIVATE sig_flags)
endfunction()
