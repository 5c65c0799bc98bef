# SPDX-License-Identifier: BSD-3-Clause
# What `cmake --install` takes: the program, the online library and its C header.
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
