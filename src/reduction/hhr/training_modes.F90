! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> The modes of a reduced model: POD of its displacement snapshots and, for the domain alone, of its multipliers.
module sig_training_modes
  use sig_deck_config, only: reduction_config_t
  use sig_errors, only: error_t, make_error
  use sig_kinds, only: rk
  use sig_pod, only: compute_pod, pod_t, rows_of_rank
  use sig_pod_rank, only: available_modes, equal_weights, pod_rank
  use sig_problem, only: problem_t
  use sig_snapshot_store, only: snapshot_set_t
  use sig_term_values, only: evaluate_points
  use sig_text, only: counted, to_text
  use petsc
  implicit none(type, external)
  private
  public :: pod_modes_t, compute_modes, compute_dual_modes, field_to_compress, terms_at

  type :: pod_modes_t
    !> descending, of all snapshots
    real(rk), allocatable :: singular_values(:)
    !> orthonormal columns: those that choose the domain, then the further ones of the basis; shape (n_dofs, n_domain + n_extra)
    real(rk), allocatable :: vectors(:, :)
    integer :: n_domain = 0
    integer :: n_extra = 0
  end type pod_modes_t

contains

  !> Collective on comm. Errors: no snapshot differs from zero; the deck wants more modes than there are.
  subroutine compute_modes(problem, snapshots, comm, modes, error, ierr)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: snapshots
    MPI_Comm, intent(in) :: comm
    type(pod_modes_t), intent(out) :: modes
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(pod_t) :: pod

    PetscCall(decompose(problem, snapshots, comm, pod, ierr))
    modes%singular_values = pod%singular_values
    call count_modes(problem%deck%reduction, problem%deck%path, modes, error)
    if (available_modes(modes%singular_values) == 0) call explain_no_modes(snapshots, problem%deck%path, error)
    if (.not. allocated(error)) then
      PetscCall(pod%left_vectors(modes%n_domain + modes%n_extra, modes%vectors, ierr))
    end if
    PetscCall(pod%destroy(ierr))
  end subroutine compute_modes

  !> Singular values of the fields, of which each rank keeps its rows. Collective on comm.
  subroutine decompose(problem, snapshots, comm, pod, ierr)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: snapshots
    MPI_Comm, intent(in) :: comm
    type(pod_t), intent(out) :: pod
    PetscErrorCode, intent(out) :: ierr
    real(rk) :: weights(size(snapshots%parameters, 2)), field(size(snapshots%displacement, 1))
    real(rk), allocatable :: theta(:, :)
    integer :: first, i, last

    theta = terms_at(problem, snapshots)
    weights = 1
    if (problem%deck%reduction%is_normalized) &
      weights = equal_weights([(norm2(field_to_compress(snapshots, theta, i)), i=1, size(weights))])
    PetscCall(rows_of_rank(size(field), comm, first, last, ierr))
    PetscCall(pod%create(last - first + 1, size(field), size(weights), comm, ierr))
    do i = 1, size(weights)
      field = weights(i) * field_to_compress(snapshots, theta, i)
      PetscCall(pod%set_snapshot(i, field(first:last), ierr))
    end do
    PetscCall(pod%decompose(ierr))
  end subroutine decompose

  !> Values of the terms whose free response the fields lose: none where the modes carry the prescribed displacements.
  function terms_at(problem, snapshots) result(theta)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: snapshots
    !> [-] shape (n_terms, n_snapshots)
    real(rk), allocatable :: theta(:, :)
    integer :: i_bad_point, i_bad_source

    if (problem%deck%reduction%dirichlet == 'multiplier') then
      allocate (theta(0, size(snapshots%parameters, 2)))
    else
      call evaluate_points(problem%terms, snapshots%parameters, theta, i_bad_point, i_bad_source)
      theta = theta(:size(snapshots%free_response, 2), :)
    end if
  end function terms_at

  !> A whole field, or what contact adds to the elastic response.
  pure function field_to_compress(snapshots, theta, i) result(field)
    type(snapshot_set_t), intent(in) :: snapshots
    !> of terms_at
    real(rk), intent(in) :: theta(:, :)
    !> 1-based
    integer, intent(in) :: i
    !> [length] shape (n_dofs)
    real(rk) :: field(size(snapshots%displacement, 1))

    field = snapshots%displacement(:, i)
    if (size(theta, 1) > 0) field = field - matmul(snapshots%free_response, theta(:, i))
  end function field_to_compress

  !> Source: section 3.4: the domain by the first tolerance, the basis by the second.
  subroutine count_modes(reduction, path, modes, error)
    type(reduction_config_t), intent(in) :: reduction
    character(*), intent(in) :: path
    type(pod_modes_t), intent(inout) :: modes
    type(error_t), allocatable, intent(out) :: error
    integer :: n_available

    n_available = available_modes(modes%singular_values)
    modes%n_domain = pod_rank(modes%singular_values, reduction%pod_tolerance)
    if (reduction%n_modes > 0) modes%n_domain = reduction%n_modes
    modes%n_extra = reduction%extra_modes
    if (reduction%extended_pod_tolerance > 0) &
      modes%n_extra = max(0, pod_rank(modes%singular_values, reduction%extended_pod_tolerance) - modes%n_domain)
    if (modes%n_domain + modes%n_extra > n_available) call make_error(error, &
      'reduction.n_modes and extra_modes ask for ' // counted(modes%n_domain + modes%n_extra, 'mode') // &
      '; the snapshots have ' // to_text(n_available) // ' above rounding', path, &
      hint='take fewer modes, or more training points')
  end subroutine count_modes

  !> Why there is nothing to compress: no load, or no contact.
  subroutine explain_no_modes(snapshots, path, error)
    type(snapshot_set_t), intent(in) :: snapshots
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error

    if (.not. any(abs(snapshots%displacement) > 0)) then
      call make_error(error, 'all snapshots are zero: no training point loads the bodies', path)
    else if (any(snapshots%multipliers > 0)) then
      call make_error(error, 'the contact forces at the training points displace nothing above rounding', path)
    else
      call make_error(error, 'the bodies touch at no training point: every snapshot is the response without contact, ' // &
        'which needs no mode', path, hint='take training points at which they touch, or fewer clusters')
    end if
  end subroutine explain_no_modes

  !> Modes of the multipliers, shape (n_multipliers, n_modes); none without a tolerance or without contact. Collective on comm.
  !>
  !> Source: section 5.2: "this dual POD RB is only used for the RID expansion".
  subroutine compute_dual_modes(problem, snapshots, comm, vectors, ierr)
    type(problem_t), intent(in) :: problem
    type(snapshot_set_t), intent(in) :: snapshots
    MPI_Comm, intent(in) :: comm
    real(rk), allocatable, intent(out) :: vectors(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: singular_values(:), all_vectors(:, :)
    integer :: n_modes

    ierr = 0
    n_modes = 0
    if (problem%deck%reduction%dual_pod_tolerance > 0) then
      PetscCall(compute_pod(snapshots%multipliers, comm, singular_values, all_vectors, ierr))
      n_modes = pod_rank(singular_values, problem%deck%reduction%dual_pod_tolerance)
    else
      allocate (all_vectors(size(snapshots%multipliers, 1), 0))
    end if
    vectors = all_vectors(:, :n_modes)
  end subroutine compute_dual_modes
end module sig_training_modes
