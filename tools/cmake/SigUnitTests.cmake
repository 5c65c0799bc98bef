# SPDX-License-Identifier: BSD-3-Clause
# sig_add_unit_test(<layer> <file.pf> [NPES <count>...] [USES <library>...])
#
# Builds one test program from a .pf file and registers it with ctest: unit.<layer>.<file>, or one entry per rank count,
# unit.<layer>.<file>.np<count>, where NPES is given (the .pf then says `use pfunit`). MPI tests find PETSc and SLEPc started.
# Each entry runs in a folder of its own, so that tests may write files. SIG_SOURCE_DIR holds the root of the sources.
find_package(PFUNIT QUIET) # not packaged by Debian; tests/pfunit serves the same files without it
find_program(SIG_SYSTEM_PYTHON NAMES python3 PATHS /usr/bin NO_DEFAULT_PATH REQUIRED)

execute_process(COMMAND id -u OUTPUT_VARIABLE user_number OUTPUT_STRIP_TRAILING_WHITESPACE)
# One BLAS thread per rank; ranks that wait give their core to those that work.
set(SIG_TEST_ENVIRONMENT OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 OMPI_MCA_mpi_yield_when_idle=1)
# Ranks on one machine talk through memory: Open MPI need not look for networks, nor for a faster way to tell few ranks of each
# other, which takes a third of a start.
list(APPEND SIG_TEST_ENVIRONMENT OMPI_MCA_pml=ob1 OMPI_MCA_btl=self,vader OMPI_MCA_btl_vader_single_copy_mechanism=none
  PMIX_MCA_gds=hash)
# OpenBLAS takes its slowest kernels where it does not know the processor, as 0.3.21 most that are younger than itself.
if(EXISTS /proc/cpuinfo)
  file(STRINGS /proc/cpuinfo processor_flags REGEX "^flags" LIMIT_COUNT 1)
  if(processor_flags MATCHES " avx2 " AND processor_flags MATCHES " fma ")
    list(APPEND SIG_TEST_ENVIRONMENT OPENBLAS_CORETYPE=Haswell)
  endif()
endif()
# Without bytecode, which a variable of the user may forbid, each of some hundred processes compiles what it imports.
list(APPEND SIG_TEST_ENVIRONMENT PYTHONDONTWRITEBYTECODE= "PYTHONPYCACHEPREFIX=${PROJECT_BINARY_DIR}/bytecode")
# The program waits until its files are on the disk; those of tests need none, and take some 10 MB.
execute_process(COMMAND df --output=avail /dev/shm OUTPUT_VARIABLE kilobytes ERROR_QUIET)
if(kilobytes MATCHES "([0-9]+)" AND CMAKE_MATCH_1 GREATER 2000000)
  list(APPEND SIG_TEST_ENVIRONMENT TMPDIR=/dev/shm)
endif()
if(user_number STREQUAL "0") # Open MPI refuses to run as root unless told twice
  list(APPEND SIG_TEST_ENVIRONMENT OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1)
endif()
set(SIG_TEST_TIMEOUT 120) # [s] of a unit test
set(SIG_PYTHON_TIMEOUT 900)
set(SIG_UNIT_TEST_ENVIRONMENT ${SIG_TEST_ENVIRONMENT})
if(SIG_SANITIZE)
  set(undefined UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1)
  # unit tests are full of constructors of types with texts, which gfortran 12 leaks; the program has none
  list(APPEND SIG_UNIT_TEST_ENVIRONMENT ${undefined} ASAN_OPTIONS=detect_leaks=0)
  # the slow unwinder sees the callers in libraries without frame pointers, by which tools/lsan.supp tells what others leak
  list(APPEND SIG_TEST_ENVIRONMENT ${undefined} ASAN_OPTIONS=fast_unwind_on_malloc=0
    LSAN_OPTIONS=suppressions=${PROJECT_SOURCE_DIR}/tools/lsan.supp:print_suppressions=0)
  set(SIG_TEST_TIMEOUT 600)
  set(SIG_PYTHON_TIMEOUT 3600)
endif()
# Rank counts above the number of cores are meant; without --bind-to two tests at once share one core. ctest does not keep cores
# free for the ranks: most of such a test is the start of mpirun, which needs none.
set(SIG_MPIEXEC_FLAGS --oversubscribe --bind-to none)
set(SIG_MPIEXEC "${MPIEXEC_EXECUTABLE}" ${SIG_MPIEXEC_FLAGS} "${MPIEXEC_NUMPROC_FLAG}")

find_program(SIG_GOLD ld.gold)

# The program of one .pf file and its ctest entry <layer>_<file> by pFUnit: on all ranks of the largest count at once, so that a
# test for fewer leaves the others idle.
function(sig_test_with_pfunit program file n_ranks)
  set(folder "${CMAKE_CURRENT_BINARY_DIR}/work/${program}")
  file(MAKE_DIRECTORY "${folder}")
  set(libraries ${ARGN})
  set(labels unit)
  if(n_ranks)
    set(mpi_options MAX_PES ${n_ranks} EXTRA_USE petsc_start EXTRA_INITIALIZE start_petsc)
    list(APPEND libraries sig_petsc_start)
    set(labels unit mpi)
    set(MPIEXEC_PREFLAGS ${SIG_MPIEXEC_FLAGS})
  endif()
  # a name below the source folder, for which pFUnit generates below the build folder
  add_pfunit_ctest(${program} TEST_SOURCES "${file}" LINK_LIBRARIES ${libraries} WORKING_DIRECTORY "${folder}" ${mpi_options})
  set_tests_properties(${program} PROPERTIES LABELS "${labels}" TIMEOUT ${SIG_TEST_TIMEOUT} ENVIRONMENT "${SIG_UNIT_TEST_ENVIRONMENT}")
endfunction()

# Name, rank count (0 = without mpiexec) and command of one ctest entry.
function(sig_register_unit_test name n_ranks program)
  set(folder "${CMAKE_CURRENT_BINARY_DIR}/work/${name}")
  file(MAKE_DIRECTORY "${folder}")
  if(n_ranks)
    add_test(NAME ${name} COMMAND ${SIG_MPIEXEC} ${n_ranks} $<TARGET_FILE:${program}> WORKING_DIRECTORY "${folder}")
    set_tests_properties(${name} PROPERTIES LABELS "unit;mpi")
  else()
    add_test(NAME ${name} COMMAND ${program} WORKING_DIRECTORY "${folder}")
    set_tests_properties(${name} PROPERTIES LABELS unit)
  endif()
  set_tests_properties(${name} PROPERTIES ENVIRONMENT "${SIG_UNIT_TEST_ENVIRONMENT}" TIMEOUT ${SIG_TEST_TIMEOUT})
endfunction()

# The program of one .pf file by the subset in tests/pfunit.
function(sig_build_with_subset program pf_file is_mpi)
  set(translator "${PROJECT_SOURCE_DIR}/tests/pfunit/translate_pf.py")
  set(fortran_file "${CMAKE_CURRENT_BINARY_DIR}/${program}.F90")
  cmake_path(RELATIVE_PATH pf_file BASE_DIRECTORY "${PROJECT_SOURCE_DIR}" OUTPUT_VARIABLE shown_name)
  if(is_mpi)
    set(hook --extra-use petsc_start --extra-initialize start_petsc)
    set(libraries sig_pfunit sig_petsc_start)
  else()
    set(libraries sig_funit)
  endif()
  add_custom_command(OUTPUT "${fortran_file}"
    COMMAND "${SIG_SYSTEM_PYTHON}" "${translator}" "${pf_file}" "${fortran_file}" --shown-name "${shown_name}" ${hook}
    DEPENDS "${pf_file}" "${translator}"
    VERBATIM)
  add_executable(${program} EXCLUDE_FROM_ALL "${fortran_file}")
  target_link_libraries(${program} PRIVATE ${libraries} ${ARGN})
endfunction()

function(sig_add_unit_test layer file)
  cmake_parse_arguments(TEST "" "" "NPES;USES" ${ARGN})
  cmake_path(GET file STEM stem)
  cmake_path(ABSOLUTE_PATH file BASE_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}" OUTPUT_VARIABLE pf_file)
  set(program ${layer}_${stem})
  set(name unit.${layer}.${stem})
  set(is_mpi OFF)
  if(TEST_NPES)
    set(is_mpi ON)
  endif()
  set(libraries sig_${layer} ${TEST_USES} sig_test_support sig_flags)
  if(PFUNIT_FOUND)
    set(max_ranks 0)
    if(is_mpi)
      list(SORT TEST_NPES COMPARE NATURAL)
      list(GET TEST_NPES -1 max_ranks)
    endif()
    sig_test_with_pfunit(${program} "${file}" ${max_ranks} ${libraries})
  else()
    sig_build_with_subset(${program} "${pf_file}" ${is_mpi} ${libraries})
    if(is_mpi)
      foreach(n_ranks ${TEST_NPES})
        sig_register_unit_test(${name}.np${n_ranks} ${n_ranks} ${program})
      endforeach()
    else()
      sig_register_unit_test(${name} 0 ${program})
    endif()
  endif()
  target_compile_definitions(${program} PRIVATE "SIG_SOURCE_DIR=\"${PROJECT_SOURCE_DIR}\"")
  if(SIG_GOLD) # links a test program in a fifth of the time
    target_link_options(${program} PRIVATE -fuse-ld=gold)
  endif()
  # test programs do little themselves, and compile a third faster
  target_compile_options(${program} PRIVATE $<$<CONFIG:Debug>:-O0>)
  set_target_properties(${program} PROPERTIES
    EXCLUDE_FROM_ALL OFF
    Fortran_MODULE_DIRECTORY "${CMAKE_CURRENT_BINARY_DIR}/${program}_modules"
    RUNTIME_OUTPUT_DIRECTORY "${CMAKE_CURRENT_BINARY_DIR}")
  add_dependencies(unit_${layer} ${program})
endfunction()
