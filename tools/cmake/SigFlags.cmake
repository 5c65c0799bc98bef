# SPDX-License-Identifier: BSD-3-Clause
option(SIG_WARNINGS_AS_ERRORS "Treat compiler warnings as errors" OFF)
option(SIG_SANITIZE "Address and undefined-behaviour sanitizers in C and Fortran" OFF)

set(CMAKE_C_STANDARD 11)
set(CMAKE_C_STANDARD_REQUIRED ON)
set(CMAKE_C_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON) # base, dense and online also make a shared library

add_library(sig_flags INTERFACE)
# -std: no extension slips in.  -ffree-line-length-none: PETSc's macros expand to long lines.
# -Wimplicit-interface: a PETSc call without an interface compiles and then crashes.
target_compile_options(sig_flags INTERFACE
  $<$<COMPILE_LANGUAGE:Fortran>:-std=f2018 -ffree-line-length-none -Wall -Wextra -Wimplicit-interface -Wconversion
  # PETSc's own modules make thousands of these; the compiler initialises the allocatable results it warns about.
  -Wno-unused-parameter -Wno-maybe-uninitialized -Wno-unused-dummy-argument -Wno-compare-reals>
  $<$<COMPILE_LANGUAGE:C>:-Wall -Wextra -Wconversion -Wno-sign-conversion -Wshadow -Wstrict-prototypes>)
target_compile_definitions(sig_flags INTERFACE $<$<COMPILE_LANGUAGE:C>:_POSIX_C_SOURCE=200809L>)
if(SIG_WARNINGS_AS_ERRORS)
  target_compile_options(sig_flags INTERFACE -Werror)
endif()
if(SIG_SANITIZE)
  target_compile_options(sig_flags INTERFACE -fsanitize=address,undefined -fno-omit-frame-pointer)
  target_link_options(sig_flags INTERFACE -fsanitize=address,undefined)
endif()
set(CMAKE_Fortran_FLAGS_DEBUG "-Og -g -fcheck=all -fbacktrace")
set(CMAKE_C_FLAGS_DEBUG "-Og -g")
set(CMAKE_Fortran_FLAGS_RELEASE "-O2 -g1")
set(CMAKE_C_FLAGS_RELEASE "-O2 -g1")
