# SPDX-License-Identifier: BSD-3-Clause
# Flags of the whole code, each with its reason. sig_flags is linked privately, so no flag leaks to who links a layer.
option(SIG_WARNINGS_AS_ERRORS "Treat compiler warnings as errors" OFF)
option(SIG_SANITIZE "Address and undefined-behaviour sanitizers in C and Fortran" OFF)

set(CMAKE_C_STANDARD 11)
set(CMAKE_C_STANDARD_REQUIRED ON)
set(CMAKE_C_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON) # base, dense and online also make a shared library

set(fortran_flags
  -std=f2018 # no extension slips in
  -ffree-line-length-none # PETSc's macros expand to long lines; 132 is the limit for people, tools/lint.sh has it
  -Wall
  -Wextra
  -fimplicit-none # interface bodies do not inherit the implicit none of their module
  -Wconversion # 1.0e-6 instead of 1.0e-6_rk loses digits silently
  -Wimplicit-interface # a PETSc call without an interface compiles, and crashes
  -Wno-compare-reals # comparing with an exact zero is meant
  -Wno-maybe-uninitialized # gfortran 12 means its own descriptors of allocatable results
  -Wno-unused-dummy-argument) # callbacks and bound procedures have the arguments that their interface gives them
if(CMAKE_BUILD_TYPE STREQUAL "Release")
  # from -O2 on gfortran 12 calls the descriptors of its own temporaries uninitialized; debug builds still look
  list(APPEND fortran_flags -Wno-uninitialized)
endif()
set(c_flags
  -Wall
  -Wextra
  -Wconversion
  -Wno-sign-conversion # sizes come from Fortran as int; every index would need a cast
  -Wshadow
  -Wstrict-prototypes)

add_library(sig_flags INTERFACE)
target_compile_options(sig_flags INTERFACE
  "$<$<COMPILE_LANGUAGE:Fortran>:${fortran_flags}>"
  "$<$<COMPILE_LANGUAGE:C>:${c_flags}>")
# fsync, flock, sigaction, which -std=c11 alone hides
target_compile_definitions(sig_flags INTERFACE $<$<COMPILE_LANGUAGE:C>:_POSIX_C_SOURCE=200809L>)
if(SIG_WARNINGS_AS_ERRORS)
  target_compile_options(sig_flags INTERFACE -Werror)
endif()
if(SIG_SANITIZE)
  target_compile_options(sig_flags INTERFACE
    -fsanitize=address,undefined -fno-sanitize-recover=undefined -fno-omit-frame-pointer
    # before it looks whether the left-hand side is allocated, gfortran 12 computes a size from its uninitialized bounds
    $<$<COMPILE_LANGUAGE:Fortran>:-fno-sanitize=signed-integer-overflow>)
  target_link_options(sig_flags INTERFACE -fsanitize=address,undefined)
endif()

# No -ffpe-trap: LAPACK's dsyevr and muParser raise on purpose. array-temps only prints, and it prints for sound code.
# -g1: line numbers in backtraces, at no cost in speed; -g, which a debugger wants for names of variables, compiles a fifth slower.
set(CMAKE_Fortran_FLAGS_DEBUG "-Og -g1 -fcheck=all,no-array-temps -fbacktrace")
set(CMAKE_C_FLAGS_DEBUG "-O2 -g1") # nothing checks C as it runs; its kernels are several times as fast
set(CMAKE_Fortran_FLAGS_RELEASE "-O2 -g1")
set(CMAKE_C_FLAGS_RELEASE "-O2 -g1")
