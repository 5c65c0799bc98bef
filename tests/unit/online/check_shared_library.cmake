# SPDX-License-Identifier: BSD-3-Clause
# cmake -DLIBRARY=<libsignorom_online.so> -DNM=<nm> -P check_shared_library.cmake
# Fails when the online library needs MPI, PETSc, SLEPc, BLAS or LAPACK, by a library or by a symbol (U dgemm_).
function(check_lines source text)
  string(REPLACE "\n" ";" lines "${text}")
  foreach(line IN LISTS lines)
    string(TOLOWER "${line}" lower_line)
    if(lower_line MATCHES "mpi|petsc|slepc|blas|lapack| u [dis][a-z0-9]+_$")
      string(STRIP "${line}" line)
      list(APPEND offenders "${source}: ${line}")
    endif()
  endforeach()
  list(JOIN offenders "\n  " offenders)
  if(offenders)
    message(FATAL_ERROR "${LIBRARY} must need neither MPI nor PETSc, nor BLAS or LAPACK:\n  ${offenders}")
  endif()
endfunction()

execute_process(COMMAND ldd "${LIBRARY}" OUTPUT_VARIABLE libraries COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND "${NM}" -D "${LIBRARY}" OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
# An empty or foreign library would pass the rest.
if(NOT symbols MATCHES " T signorom_query\n")
  message(FATAL_ERROR "${LIBRARY} does not hold the query")
endif()
if(libraries MATCHES "not found" OR NOT libraries MATCHES "libhdf5_serial")
  message(FATAL_ERROR "${LIBRARY} does not find its libraries, or HDF5 is not the serial flavor:\n${libraries}")
endif()
check_lines(ldd "${libraries}")
check_lines("nm -D" "${symbols}")
