! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Proper orthogonal decomposition (POD): the left singular vectors of the snapshots are the modes.
!>
!> The snapshots are the columns of a matrix, whose rows are spread over the ranks. They are handed over one by one and kept once. A
!> tall matrix (not fewer rows than snapshots) gets a QR over the ranks, and one rank decomposes the triangle. A wide matrix (fewer
!> rows than snapshots) is small, so every rank gathers and decomposes all of it.
module sig_pod
  use, intrinsic :: iso_c_binding, only: c_double, c_int, c_intptr_t
  use sig_kinds, only: rk
  use sig_petsc_support, only: rows_of_rank, sum_over_ranks
  use sig_pod_rank, only: equal_weights
  use sig_ties, only: first_largest
  use sig_training_set, only: training_set_t
  use petsc
  implicit none(type, external)
  private
  public :: pod_t, compute_pod, compute_pod_of_rows, contact_part, decompose_contact_parts, sig_gather_rows

  !> A decomposition in steps: create; set_snapshot for each snapshot; decompose; left_vectors, at most once; destroy. For tall
  !> matrices, `triangle` can take the place of decompose and left_vectors.
  type :: pod_t
    !> [as snapshots] descending, after decompose; shape (min(n_rows, n_snapshots))
    real(rk), allocatable :: singular_values(:)
    MPI_Comm, private :: comm
    integer, private :: n_rows = 0
    integer, private :: n_local = 0
    !> tall matrix: handle of snapshot_svd.h
    integer(c_intptr_t), private :: svd = 0
    !> wide matrix: rows of this rank; after decompose the left vectors
    real(rk), allocatable, private :: wide(:, :)
  contains
    procedure :: create
    procedure :: set_snapshot
    procedure :: triangle
    procedure :: decompose
    procedure :: left_vectors
    procedure :: destroy
  end type pod_t

  ! include/signorom/snapshot_svd.h describes these procedures in C.
  interface
    function sig_snapshot_svd_create(comm, n_local, n_columns, svd) result(status) bind(c)
      import :: c_int, c_intptr_t
      integer(c_int), value :: comm, n_local, n_columns
      integer(c_intptr_t), intent(out) :: svd
      integer(c_int) :: status
    end function sig_snapshot_svd_create

    function sig_snapshot_svd_set_column(svd, column, rows) result(status) bind(c)
      import :: c_double, c_int, c_intptr_t
      integer(c_intptr_t), value :: svd
      integer(c_int), value :: column
      real(c_double), intent(in) :: rows(*)
      integer(c_int) :: status
    end function sig_snapshot_svd_set_column

    function sig_snapshot_svd_triangle(svd, triangle) result(status) bind(c)
      import :: c_double, c_int, c_intptr_t
      integer(c_intptr_t), value :: svd
      real(c_double), intent(out) :: triangle(*)
      integer(c_int) :: status
    end function sig_snapshot_svd_triangle

    function sig_snapshot_svd_decompose(svd, singular_values) result(status) bind(c)
      import :: c_double, c_int, c_intptr_t
      integer(c_intptr_t), value :: svd
      real(c_double), intent(out) :: singular_values(*)
      integer(c_int) :: status
    end function sig_snapshot_svd_decompose

    function sig_snapshot_svd_left(svd, n_vectors, left) result(status) bind(c)
      import :: c_double, c_int, c_intptr_t
      integer(c_intptr_t), value :: svd
      integer(c_int), value :: n_vectors
      real(c_double), intent(out) :: left(*)
      integer(c_int) :: status
    end function sig_snapshot_svd_left

    function sig_snapshot_svd_destroy(svd) result(status) bind(c)
      import :: c_int, c_intptr_t
      integer(c_intptr_t), intent(inout) :: svd
      integer(c_int) :: status
    end function sig_snapshot_svd_destroy

    function sig_thin_svd(n_rows, n_columns, matrix, singular_values, left) result(status) bind(c)
      import :: c_double, c_int
      integer(c_int), value :: n_rows, n_columns
      real(c_double), intent(in) :: matrix(*)
      real(c_double), intent(out) :: singular_values(*)
      real(c_double), intent(out) :: left(*)
      integer(c_int) :: status
    end function sig_thin_svd

    function sig_gather_rows(comm, n_local, n_rows, n_columns, local, gathered) result(status) bind(c)
      import :: c_double, c_int
      integer(c_int), value :: comm, n_local, n_rows, n_columns
      real(c_double), intent(in) :: local(*)
      real(c_double), intent(out) :: gathered(*)
      integer(c_int) :: status
    end function sig_gather_rows
  end interface

contains

  !> Allocates the memory for the snapshots. Collective on comm. A rank may have no rows.
  subroutine create(self, n_local, n_rows, n_snapshots, comm, ierr)
    class(pod_t), intent(out) :: self
    !> number of rows of this rank, and of all ranks
    integer, intent(in) :: n_local
    integer, intent(in) :: n_rows
    integer, intent(in) :: n_snapshots
    MPI_Comm, intent(in) :: comm
    PetscErrorCode, intent(out) :: ierr

    ierr = 0
    self%comm = comm
    self%n_rows = n_rows
    self%n_local = n_local
    allocate (self%singular_values(min(n_rows, n_snapshots)), source=0.0_rk)
    if (n_snapshots > n_rows) then
      allocate (self%wide(n_local, n_snapshots))
    else
      ierr = sig_snapshot_svd_create(comm, n_local, n_snapshots, self%svd)
    end if
  end subroutine create

  !> Stores the rows of this rank as snapshot i. Collective.
  subroutine set_snapshot(self, i, rows, ierr)
    class(pod_t), intent(inout) :: self
    !> 1-based
    integer, intent(in) :: i
    !> those of this rank, shape (n_local)
    real(rk), intent(in), contiguous :: rows(:)
    PetscErrorCode, intent(out) :: ierr

    ierr = 0
    if (allocated(self%wide)) then
      self%wide(:, i) = rows
    else
      ierr = sig_snapshot_svd_set_column(self%svd, i - 1, rows)
    end if
  end subroutine set_snapshot

  !> Returns the coordinates of the snapshots in an orthonormal basis of their span; the entries below the diagonal are zero. For
  !> tall matrices only (not fewer rows than snapshots), after set_snapshot for all of them; only `destroy` may follow. Collective.
  subroutine triangle(self, coordinates, ierr)
    class(pod_t), intent(inout) :: self
    !> [as snapshots] shape (n_snapshots, n_snapshots), the same on all ranks
    real(rk), allocatable, intent(out) :: coordinates(:, :)
    PetscErrorCode, intent(out) :: ierr

    allocate (coordinates(size(self%singular_values), size(self%singular_values)), source=0.0_rk)
    ierr = sig_snapshot_svd_triangle(self%svd, coordinates)
  end subroutine triangle

  !> Sets self%singular_values. Requires: set_snapshot for all snapshots. Collective. ierr is not 0 where PETSc options
  !> (-pod_svd_...) leave values out.
  subroutine decompose(self, ierr)
    class(pod_t), intent(inout) :: self
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: rows(:, :)

    if (.not. allocated(self%wide)) then
      ierr = sig_snapshot_svd_decompose(self%svd, self%singular_values)
      return
    end if
    allocate (rows(self%n_rows, size(self%wide, 2)))
    ierr = sig_gather_rows(self%comm, self%n_local, self%n_rows, size(rows, 2), self%wide, rows)
    CHKERRQ(ierr)
    deallocate (self%wide)
    allocate (self%wide(self%n_rows, self%n_rows))
    ierr = sig_thin_svd(self%n_rows, size(rows, 2), rows, self%singular_values, self%wide)
  end subroutine decompose

  !> Returns the first left singular vectors, with all rows on every rank. Collective. Requires: decompose; no earlier call.
  !>
  !> The result does not depend on the number of ranks, up to rounding: the sign is such that the largest entry of each vector is
  !> positive (of entries within 1e-8 of the largest, the one with the lowest index). Vectors whose singular value is only rounding
  !> (below 1e-15 of the first value) are arbitrary.
  subroutine left_vectors(self, n_vectors, vectors, ierr)
    class(pod_t), intent(inout) :: self
    !> at most the number of singular values
    integer, intent(in) :: n_vectors
    !> [-] orthonormal columns, shape (n_rows, n_vectors), the same on all ranks
    real(rk), allocatable, intent(out) :: vectors(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: local(:, :)

    if (allocated(self%wide)) then
      ierr = 0
      vectors = self%wide(:, :n_vectors)
    else
      allocate (local(self%n_local, n_vectors), vectors(self%n_rows, n_vectors))
      ierr = sig_snapshot_svd_left(self%svd, n_vectors, local)
      CHKERRQ(ierr)
      ierr = sig_gather_rows(self%comm, self%n_local, self%n_rows, n_vectors, local, vectors)
      CHKERRQ(ierr)
    end if
    call fix_signs(vectors)
  end subroutine left_vectors

  !> Chooses the sign of each vector, which the decomposition leaves open: its largest entry becomes positive; of nearly equal
  !> entries the one with the lowest index.
  pure subroutine fix_signs(vectors)
    real(rk), intent(inout) :: vectors(:, :)
    integer :: i_column, i_row

    do i_column = 1, size(vectors, 2)
      i_row = first_largest(abs(vectors(:, i_column)))
      if (vectors(i_row, i_column) < 0) vectors(:, i_column) = -vectors(:, i_column)
    end do
  end subroutine fix_signs

  !> Frees the memory of SLEPc. Collective.
  subroutine destroy(self, ierr)
    class(pod_t), intent(inout) :: self
    PetscErrorCode, intent(out) :: ierr

    ierr = 0
    if (self%svd /= 0) ierr = sig_snapshot_svd_destroy(self%svd)
  end subroutine destroy

  !> Creates and decomposes the POD of the parts of the displacements that contact causes, u_i - G theta_i. Collective on comm, over
  !> which the dofs of the snapshots are spread.
  subroutine decompose_contact_parts(snapshots, response, theta, is_normalized, comm, pod, ierr)
    type(training_set_t), intent(in) :: snapshots
    !> [length] G, the elastic response to each term, all dofs on every rank, shape (n_dofs, n_terms or more)
    real(rk), intent(in) :: response(:, :)
    !> [-] values of the terms, shape (n_terms, n_snapshots); with n_terms = 0 the whole displacements are decomposed
    real(rk), intent(in) :: theta(:, :)
    !> scale all parts to length 1, so that weak ones count as much as strong ones; parts that are only rounding become 0
    !> (equal_weights)
    logical, intent(in) :: is_normalized
    MPI_Comm, intent(in) :: comm
    !> after its step `decompose`; the caller destroys it
    type(pod_t), intent(out) :: pod
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: weights(size(theta, 2))
    real(rk), allocatable :: own_response(:, :)
    integer :: i

    ierr = 0
    associate (first => snapshots%first_dof, last => snapshots%first_dof + snapshots%n_own - 1)
      own_response = response(first:last, :size(theta, 1))
    end associate
    weights = 1
    if (is_normalized) then
      do i = 1, size(weights)
        weights(i) = norm2(contact_part(snapshots, own_response, theta, i))**2
      end do
      PetscCall(sum_over_ranks(comm, weights, ierr))
      weights = equal_weights(sqrt(weights))
    end if
    PetscCall(pod%create(snapshots%n_own, snapshots%n_dofs, size(weights), comm, ierr))
    do i = 1, size(weights)
      PetscCall(pod%set_snapshot(i, weights(i) * contact_part(snapshots, own_response, theta, i), ierr))
    end do
    PetscCall(pod%decompose(ierr))
  end subroutine decompose_contact_parts

  !> [length] Returns u_i - G theta_i at the dofs of this rank, the part of displacement i that contact causes. Local.
  pure function contact_part(snapshots, own_response, theta, i) result(field)
    type(training_set_t), intent(in) :: snapshots
    !> [length] this rank's dofs of G, shape (n_own, n_terms)
    real(rk), intent(in) :: own_response(:, :)
    !> [-] shape (n_terms, n_snapshots)
    real(rk), intent(in) :: theta(:, :)
    !> number of the snapshot, 1-based
    integer, intent(in) :: i
    real(rk) :: field(snapshots%n_own)

    field = snapshots%displacement(i)%values
    if (size(theta, 1) > 0) field = field - matmul(own_response, theta(:, i))
  end function contact_part

  !> Computes the singular values and left singular vectors of snapshots that every rank has. Each rank gets the whole result. The
  !> ranks share the work unless there are more snapshots than rows. Collective on comm.
  subroutine compute_pod(snapshots, comm, singular_values, vectors, ierr)
    !> shape (n_rows, n_snapshots), the same on all ranks
    real(rk), intent(in) :: snapshots(:, :)
    MPI_Comm, intent(in) :: comm
    !> [as snapshots] descending, shape (k), k = min(n_rows, n_snapshots)
    real(rk), allocatable, intent(out) :: singular_values(:)
    !> [-] left singular vectors as from left_vectors, shape (n_rows, k)
    real(rk), allocatable, intent(out) :: vectors(:, :)
    PetscErrorCode, intent(out) :: ierr
    integer :: first, last

    PetscCall(rows_of_rank(size(snapshots, 1), comm, first, last, ierr))
    PetscCall(compute_pod_of_rows(snapshots(first:last, :), size(snapshots, 1), comm, singular_values, vectors, ierr))
  end subroutine compute_pod

  !> Does the same as compute_pod for snapshots whose rows are spread over the ranks in rank order. A rank may have no rows.
  !> Collective on comm.
  subroutine compute_pod_of_rows(local_rows, n_rows, comm, singular_values, vectors, ierr)
    !> shape (rows of this rank, n_snapshots)
    real(rk), intent(in), contiguous :: local_rows(:, :)
    !> rows of all ranks
    integer, intent(in) :: n_rows
    MPI_Comm, intent(in) :: comm
    !> results as from compute_pod
    real(rk), allocatable, intent(out) :: singular_values(:)
    real(rk), allocatable, intent(out) :: vectors(:, :)
    PetscErrorCode, intent(out) :: ierr
    type(pod_t) :: pod
    integer :: i

    PetscCall(pod%create(size(local_rows, 1), n_rows, size(local_rows, 2), comm, ierr))
    do i = 1, size(local_rows, 2)
      PetscCall(pod%set_snapshot(i, local_rows(:, i), ierr))
    end do
    PetscCall(pod%decompose(ierr))
    PetscCall(pod%left_vectors(size(pod%singular_values), vectors, ierr))
    call move_alloc(pod%singular_values, singular_values)
    PetscCall(pod%destroy(ierr))
  end subroutine compute_pod_of_rows
end module sig_pod
