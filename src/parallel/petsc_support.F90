! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Fortran procedures for the parts of PETSc that are called from C (petsc_support.h), and sums, maxima and broadcasts of arrays
!> over ranks.
module sig_petsc_support
  use, intrinsic :: iso_c_binding, only: c_char, c_double, c_int, c_intptr_t, c_null_char
  use mpi, only: MPI_Allreduce, MPI_Bcast, MPI_Comm_rank, MPI_Comm_size, MPI_DOUBLE_PRECISION, MPI_IN_PLACE, MPI_MAX, MPI_SUM
  use sig_kinds, only: rk, sk
  use sig_memory, only: machine_memory
  use sig_text, only: append_text, join, split, string_t
  use petsc
  implicit none(type, external)
  private
  public :: take_fast_blas, start_petsc, end_petsc, insert_petsc_options, unused_petsc_options, options_unused_everywhere
  public :: library_versions
  public :: create_matrix, multiply_block, create_vector, rank_and_size, rows_of_rank
  public :: broadcast_columns, broadcast_integers, broadcast_singles, sum_over_ranks, max_over_ranks, memory_of_ranks
  public :: precondition_failed, has_multigrid_vi
  public :: message_size

  !> [bytes] room for a message of PETSc: SIG_MESSAGE_SIZE of petsc_support.h
  integer, parameter :: message_size = 256
  !> [bytes] room for the names of options
  integer, parameter :: capacity_of_names = 4096

  interface sum_over_ranks
    procedure sum_vector, sum_block
  end interface sum_over_ranks

  interface max_over_ranks
    procedure max_scalar, max_block
  end interface max_over_ranks

  interface
    subroutine sig_take_fast_blas() bind(c)
    end subroutine sig_take_fast_blas

    function sig_petsc_start() result(status) bind(c)
      import :: c_int
      integer(c_int) :: status
    end function sig_petsc_start

    function sig_petsc_end() result(status) bind(c)
      import :: c_int
      integer(c_int) :: status
    end function sig_petsc_end

    function sig_petsc_insert_options(options, message) result(status) bind(c)
      import :: c_char, c_int
      character(kind=c_char), intent(in) :: options(*)
      character(kind=c_char), intent(out) :: message(*)
      integer(c_int) :: status
    end function sig_petsc_insert_options

    function sig_petsc_unused_options(names, capacity) result(status) bind(c)
      import :: c_char, c_int
      character(kind=c_char), intent(out) :: names(*)
      integer(c_int), value :: capacity
      integer(c_int) :: status
    end function sig_petsc_unused_options

    pure function sig_has_multigrid_vi() result(answer) bind(c)
      import :: c_int
      integer(c_int) :: answer
    end function sig_has_multigrid_vi

    function sig_library_versions(versions, capacity) result(status) bind(c)
      import :: c_char, c_int
      character(kind=c_char), intent(out) :: versions(*)
      integer(c_int), value :: capacity
      integer(c_int) :: status
    end function sig_library_versions

    function sig_matrix_create(comm, n_local, block_size, diagonal, off_diagonal, matrix) result(status) bind(c)
      import :: c_int, c_intptr_t
      integer(c_int), value :: comm, n_local, block_size
      integer(c_int), intent(in) :: diagonal(*), off_diagonal(*)
      integer(c_intptr_t), intent(out) :: matrix
      integer(c_int) :: status
    end function sig_matrix_create

    function sig_matrix_multiply(matrix, n_local, n_columns, columns, product) result(status) bind(c)
      import :: c_double, c_int, c_intptr_t
      integer(c_intptr_t), value :: matrix
      integer(c_int), value :: n_local, n_columns
      real(c_double), intent(in) :: columns(*)
      real(c_double), intent(out) :: product(*)
      integer(c_int) :: status
    end function sig_matrix_multiply

    function sig_precondition_failed(code, sentence, file, line) result(status) bind(c)
      import :: c_char, c_int
      integer(c_int), value :: code, line
      character(kind=c_char), intent(in) :: sentence(*), file(*)
      integer(c_int) :: status
    end function sig_precondition_failed
  end interface

contains

  !> Makes BLAS use kernels that suit the processor. This may start the program anew (blas_kernels.h), so that it must be called
  !> first of all.
  subroutine take_fast_blas()
    call sig_take_fast_blas()
  end subroutine take_fast_blas

  !> Starts MPI, PETSc and SLEPc without reading the command line. With several ranks, a rank that still runs 0.6 s after a stop
  !> signal (sig_signals) is ended by force. It then ends the other ranks, too, unless the launcher (mpirun) has sent the signal,
  !> because the launcher ends them itself. Collective on all ranks.
  subroutine start_petsc(ierr)
    PetscErrorCode, intent(out) :: ierr

    ierr = sig_petsc_start()
  end subroutine start_petsc

  !> Ends SLEPc, PETSc and MPI. Collective on all ranks.
  subroutine end_petsc(ierr)
    PetscErrorCode, intent(out) :: ierr

    ierr = sig_petsc_end()
  end subroutine end_petsc

  !> Whether the solver SNESVI of PETSc can use the preconditioner GAMG. PETSc before 3.19 stops when the inactive set changes its
  !> size.
  logical function has_multigrid_vi()
    has_multigrid_vi = sig_has_multigrid_vi() /= 0
  end function has_multigrid_vi

  !> Adds options, each `-name` or `-name value`, separated by blanks, to the options of PETSc. An option that is added again gets
  !> the new value. If PETSc complains about one, for example about a missing file of options, `message` says so, and ierr is 0.
  subroutine insert_petsc_options(options, ierr, message)
    !> such as `-ksp_type cg -ksp_view`
    character(*), intent(in) :: options
    PetscErrorCode, intent(out) :: ierr
    !> complaint of PETSc about the options, its first 255 characters; not allocated where there is none. Without this argument a
    !> complaint sets ierr to 1
    character(:), allocatable, intent(out), optional :: message
    character(kind=c_char, len=message_size) :: buffer

    buffer = c_null_char
    ierr = sig_petsc_insert_options(options // c_null_char, buffer)
    if (buffer(1:1) == c_null_char) return
    if (present(message)) then
      message = buffer(:index(buffer, c_null_char) - 1)
    else
      ierr = 1
    end if
  end subroutine insert_petsc_options

  !> Returns the PETSc options that no object on this rank has used until now, each as `-name`. A list of more than 4095 characters
  !> is cut. Local.
  subroutine unused_petsc_options(names, ierr)
    type(string_t), allocatable, intent(out) :: names(:)
    PetscErrorCode, intent(out) :: ierr
    character(kind=c_char, len=capacity_of_names) :: buffer
    type(string_t), allocatable :: words(:)
    integer :: i

    ierr = sig_petsc_unused_options(buffer, int(capacity_of_names, c_int))
    words = split(buffer(:index(buffer, c_null_char) - 1), ' ')
    allocate (names(0))
    do i = 1, size(words)
      if (words(i)%text /= '') call append_text(names, words(i)%text)
    end do
  end subroutine unused_petsc_options

  !> Lists the PETSc options, with their hyphen, that were set and that no rank has read so far. Collective on all ranks, with the
  !> same result on each.
  subroutine options_unused_everywhere(names, ierr)
    type(string_t), allocatable, intent(out) :: names(:)
    PetscErrorCode, intent(out) :: ierr
    type(string_t), allocatable :: own(:)
    character(capacity_of_names) :: text
    integer, allocatable :: is_unused(:)
    integer :: i, k

    PetscCall(unused_petsc_options(own, ierr))
    text = join(own, ' ')
    call MPI_Bcast(text, len(text), MPI_CHARACTER, 0, PETSC_COMM_WORLD, ierr)
    names = split(trim(text), ' ')
    names = pack(names, [(names(i)%text /= '', i=1, size(names))])
    is_unused = [(merge(1, 0, any([(own(k)%text == names(i)%text, k=1, size(own))])), i=1, size(names))]
    call MPI_Allreduce(MPI_IN_PLACE, is_unused, size(is_unused), MPI_INTEGER, MPI_MIN, PETSC_COMM_WORLD, ierr)
    names = pack(names, is_unused == 1)
  end subroutine options_unused_everywhere

  !> Returns the versions of PETSc and SLEPc in use, such as 3.18.5, then the name and version of the MPI library.
  subroutine library_versions(versions, ierr)
    !> shape (3)
    type(string_t), allocatable, intent(out) :: versions(:)
    PetscErrorCode, intent(out) :: ierr
    integer, parameter :: capacity = 512
    character(kind=c_char, len=capacity) :: buffer

    ierr = sig_library_versions(buffer, int(capacity, c_int))
    versions = split(buffer(:index(buffer, c_null_char) - 1), ';')
  end subroutine library_versions

  !> Creates an empty square AIJ matrix with memory for the given numbers of blocks per local block row. Collective on comm.
  subroutine create_matrix(comm, n_local, block_size, diagonal, off_diagonal, matrix, ierr)
    MPI_Comm, intent(in) :: comm
    !> number of rows of this rank
    integer, intent(in) :: n_local
    !> number of rows of a block
    integer, intent(in) :: block_size
    !> numbers of blocks of each local block row in the columns of this rank, and in other columns; shape (n_local / block_size)
    integer, intent(in) :: diagonal(:), off_diagonal(:)
    Mat, intent(out) :: matrix
    PetscErrorCode, intent(out) :: ierr

    ierr = sig_matrix_create(int(comm, c_int), n_local, block_size, diagonal, off_diagonal, matrix%v)
  end subroutine create_matrix

  !> Multiplies a square matrix by many columns in one pass over the matrix. Collective on the communicator of the matrix.
  subroutine multiply_block(matrix, columns, product, ierr)
    Mat, intent(in) :: matrix
    !> rows of this rank, shape (n_local, n_columns); n_columns is the same on all ranks
    real(rk), contiguous, intent(in) :: columns(:, :)
    !> rows of this rank of the product, same shape
    real(rk), contiguous, intent(out) :: product(:, :)
    PetscErrorCode, intent(out) :: ierr

    ierr = sig_matrix_multiply(matrix%v, size(columns, 1), size(columns, 2), columns, product)
  end subroutine multiply_block

  !> Creates a distributed vector of zeros. Collective on comm.
  subroutine create_vector(comm, n_local, vector, ierr)
    MPI_Comm, intent(in) :: comm
    !> number of rows of this rank
    integer, intent(in) :: n_local
    Vec, intent(out) :: vector
    PetscErrorCode, intent(out) :: ierr

    PetscCall(VecCreateMPI(comm, n_local, PETSC_DETERMINE, vector, ierr))
    PetscCall(VecSet(vector, 0.0_rk, ierr))
  end subroutine create_vector

  !> Returns the number of this rank (0-based) and the number of ranks of a communicator. Local.
  subroutine rank_and_size(comm, rank, n_ranks, ierr)
    MPI_Comm, intent(in) :: comm
    integer, intent(out) :: rank
    integer, intent(out) :: n_ranks
    PetscErrorCode, intent(out) :: ierr

    call MPI_Comm_rank(comm, rank, ierr)
    call MPI_Comm_size(comm, n_ranks, ierr)
  end subroutine rank_and_size

  !> Sums the memory of the machines on which the ranks of comm run, each machine once. Collective.
  subroutine memory_of_ranks(comm, n_bytes, ierr)
    MPI_Comm, intent(in) :: comm
    !> [byte]
    real(rk), intent(out) :: n_bytes
    PetscErrorCode, intent(out) :: ierr
    MPI_Comm :: machine
    integer :: n_ranks, rank
    real(rk) :: share(1)

    PetscCallMPI(MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, machine, ierr))
    PetscCall(rank_and_size(machine, rank, n_ranks, ierr))
    PetscCallMPI(MPI_Comm_free(machine, ierr))
    share = machine_memory() / n_ranks
    PetscCall(sum_over_ranks(comm, share, ierr))
    n_bytes = share(1)
  end subroutine memory_of_ranks

  !> Returns the first and the last row, 1-based, of the slice of n_rows rows that belongs to this rank. The sizes of the slices
  !> differ by at most one row; last is first - 1 where the slice is empty. Local.
  subroutine rows_of_rank(n_rows, comm, first, last, ierr)
    !> number of all rows
    integer, intent(in) :: n_rows
    MPI_Comm, intent(in) :: comm
    integer, intent(out) :: first
    integer, intent(out) :: last
    PetscErrorCode, intent(out) :: ierr
    integer :: n_ranks, rank

    first = 0
    last = 0
    PetscCall(rank_and_size(comm, rank, n_ranks, ierr))
    first = slice_end(n_rows, rank, n_ranks) + 1
    last = slice_end(n_rows, rank + 1, n_ranks)
  end subroutine rows_of_rank

  !> Returns the last row (1-based) of slice i_slice, 1 to n_slices, when n_rows rows are divided into n_slices slices: the first
  !> modulo(n_rows, n_slices) slices have one row more than the others. 0 for i_slice = 0. No intermediate number overflows.
  pure integer function slice_end(n_rows, i_slice, n_slices)
    integer, intent(in) :: n_rows
    integer, intent(in) :: i_slice
    integer, intent(in) :: n_slices

    slice_end = i_slice * (n_rows / n_slices) + min(i_slice, modulo(n_rows, n_slices))
  end function slice_end

  !> Replaces each entry of an array by its sum over the ranks, on all ranks. The size is the same on all ranks. Collective on comm.
  subroutine sum_vector(comm, values, ierr)
    MPI_Comm, intent(in) :: comm
    real(rk), intent(inout) :: values(:)
    PetscErrorCode, intent(out) :: ierr

    call MPI_Allreduce(MPI_IN_PLACE, values, size(values), MPI_DOUBLE_PRECISION, MPI_SUM, comm, ierr)
  end subroutine sum_vector

  !> Replaces each entry of an array by its sum over the ranks, on all ranks. The shape is the same on all ranks. Collective on
  !> comm.
  subroutine sum_block(comm, values, ierr)
    MPI_Comm, intent(in) :: comm
    real(rk), contiguous, intent(inout) :: values(:, :)
    PetscErrorCode, intent(out) :: ierr

    call MPI_Allreduce(MPI_IN_PLACE, values, size(values), MPI_DOUBLE_PRECISION, MPI_SUM, comm, ierr)
  end subroutine sum_block

  !> Replaces a value by the largest one of all ranks, on all ranks. Collective on comm.
  subroutine max_scalar(comm, value, ierr)
    MPI_Comm, intent(in) :: comm
    real(rk), intent(inout) :: value
    PetscErrorCode, intent(out) :: ierr

    call MPI_Allreduce(MPI_IN_PLACE, value, 1, MPI_DOUBLE_PRECISION, MPI_MAX, comm, ierr)
  end subroutine max_scalar

  !> Replaces each entry of an array by its largest value of all ranks, on all ranks. The shape is the same on all ranks. Collective
  !> on comm.
  subroutine max_block(comm, values, ierr)
    MPI_Comm, intent(in) :: comm
    real(rk), contiguous, intent(inout) :: values(:, :)
    PetscErrorCode, intent(out) :: ierr

    call MPI_Allreduce(MPI_IN_PLACE, values, size(values), MPI_DOUBLE_PRECISION, MPI_MAX, comm, ierr)
  end subroutine max_block

  !> Copies the values of the first rank to all ranks, column by column, so that counts stay below 2**31. Collective on comm.
  subroutine broadcast_columns(values, comm, ierr)
    !> same shape on all ranks
    real(rk), contiguous, intent(inout) :: values(:, :)
    MPI_Comm, intent(in) :: comm
    PetscErrorCode, intent(out) :: ierr
    integer :: i

    ierr = 0
    do i = 1, size(values, 2)
      PetscCallMPI(MPI_Bcast(values(:, i), size(values, 1), MPI_DOUBLE_PRECISION, 0, comm, ierr))
    end do
  end subroutine broadcast_columns

  !> Copies integers, or numbers in single precision, of the first rank to all ranks; each gets an array of the size on the first
  !> rank. Collective on comm.
  subroutine broadcast_integers(values, comm, ierr)
    !> allocated on the first rank
    integer, allocatable, intent(inout) :: values(:)
    MPI_Comm, intent(in) :: comm
    PetscErrorCode, intent(out) :: ierr
    integer :: n(1)

    n = 0
    if (allocated(values)) n = size(values)
    PetscCallMPI(MPI_Bcast(n, 1, MPI_INTEGER, 0, comm, ierr))
    if (allocated(values)) then
      if (size(values) /= n(1)) deallocate (values)
    end if
    if (.not. allocated(values)) allocate (values(n(1)))
    PetscCallMPI(MPI_Bcast(values, n(1), MPI_INTEGER, 0, comm, ierr))
  end subroutine broadcast_integers

  subroutine broadcast_singles(values, comm, ierr)
    !> allocated on the first rank
    real(sk), allocatable, intent(inout) :: values(:)
    MPI_Comm, intent(in) :: comm
    PetscErrorCode, intent(out) :: ierr
    integer :: n(1)

    n = 0
    if (allocated(values)) n = size(values)
    PetscCallMPI(MPI_Bcast(n, 1, MPI_INTEGER, 0, comm, ierr))
    if (allocated(values)) then
      if (size(values) /= n(1)) deallocate (values)
    end if
    if (.not. allocated(values)) allocate (values(n(1)))
    PetscCallMPI(MPI_Bcast(values, n(1), MPI_REAL, 0, comm, ierr))
  end subroutine broadcast_singles

  !> Puts a failed precondition with its place in the source on the error stack of PETSc. The macro SIG_CHECK calls it.
  subroutine precondition_failed(code, sentence, file, line, ierr)
    !> error code of PETSc; ierr gets the same
    PetscErrorCode, intent(in) :: code
    !> what must be true, or what is wrong; without a full stop
    character(*), intent(in) :: sentence
    !> place in the source
    character(*), intent(in) :: file
    integer, intent(in) :: line
    PetscErrorCode, intent(out) :: ierr

    ierr = sig_precondition_failed(code, sentence // c_null_char, file // c_null_char, line)
  end subroutine precondition_failed
end module sig_petsc_support
