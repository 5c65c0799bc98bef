# SPDX-License-Identifier: BSD-3-Clause
# Everything comes from Debian packages; tools/install_dependencies.sh names them.
find_package(PkgConfig REQUIRED)
find_package(MPI REQUIRED COMPONENTS C Fortran)
find_package(Threads REQUIRED)
find_package(LAPACK REQUIRED)
pkg_check_modules(PETSC REQUIRED IMPORTED_TARGET PETSc>=3.18)
pkg_check_modules(SLEPC REQUIRED IMPORTED_TARGET SLEPc>=3.18)
pkg_check_modules(FYAML REQUIRED IMPORTED_TARGET libfyaml>=0.7)
pkg_check_modules(MUPARSER REQUIRED IMPORTED_TARGET muparser>=2.3)
# pkg-config and not find_package: the flavours share one set of CMake cache entries, so the choice would depend on order.
pkg_check_modules(HDF5 REQUIRED IMPORTED_TARGET hdf5-serial)
find_path(METIS_INCLUDE_DIR metis.h REQUIRED)
find_library(METIS_LIBRARY metis REQUIRED)
add_library(sig_metis INTERFACE)
target_include_directories(sig_metis INTERFACE "${METIS_INCLUDE_DIR}")
target_link_libraries(sig_metis INTERFACE "${METIS_LIBRARY}")
