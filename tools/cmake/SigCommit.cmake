# SPDX-License-Identifier: BSD-3-Clause
# SIG_COMMIT: the commit of the sources, empty where they are no clone. A new commit configures again.
find_package(Git QUIET)
set(SIG_COMMIT "")
if(Git_FOUND)
  execute_process(COMMAND "${GIT_EXECUTABLE}" rev-parse --short=12 HEAD WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}"
    OUTPUT_VARIABLE SIG_COMMIT OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  execute_process(COMMAND "${GIT_EXECUTABLE}" rev-parse --git-path logs/HEAD WORKING_DIRECTORY "${PROJECT_SOURCE_DIR}"
    OUTPUT_VARIABLE log_of_head OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
  cmake_path(ABSOLUTE_PATH log_of_head BASE_DIRECTORY "${PROJECT_SOURCE_DIR}")
  if(SIG_COMMIT AND EXISTS "${log_of_head}")
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${log_of_head}")
  endif()
endif()
