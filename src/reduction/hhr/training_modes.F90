! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> The modes of a hyper-reduced model: POD of its displacement snapshots. A POD of its contact forces is used only to choose the
!> domain.
module sig_training_modes
  use sig_deck_config, only: reduction_config_t
  use sig_errors, only: error_t, make_error
  use sig_kinds, only: rk
  use sig_pod, only: compute_pod, decompose_contact_parts, pod_t
  use sig_pod_rank, only: available_modes, pod_rank
  use sig_problem, only: problem_t
  use sig_snapshot_lengths, only: snapshot_lengths
  use sig_term_values, only: evaluate_points
  use sig_text, only: counted, to_text
  use sig_training_set, only: training_set_t
  use petsc
  implicit none(type, external)
  private
  public :: pod_modes_t, compute_modes, compute_dual_modes, terms_at

  !> The modes of one cluster.
  type :: pod_modes_t
    !> all singular values, descending
    real(rk), allocatable :: singular_values(:)
    !> orthonormal columns: n_domain modes that choose the domain, then n_extra more modes; all are in the basis; shape (n_dofs,
    !> n_domain + n_extra)
    real(rk), allocatable :: vectors(:, :)
    integer :: n_domain = 0
    integer :: n_extra = 0
  end type pod_modes_t

contains

  !> Computes the modes of the snapshots minus their response without contact, or of the whole snapshots with `dirichlet:
  !> multiplier`; with reduction.normalize each is first scaled to length 1. Collective on comm, over which the dofs of the
  !> snapshots are spread; the result is the same on each rank.
  !>
  !> Errors: there is no mode above rounding, because all snapshots are zero, have no contact, or contact moves nothing; the deck
  !> asks for more modes than there are. After an error modes%vectors is not allocated.
  subroutine compute_modes(problem, snapshots, comm, modes, error, ierr)
    type(problem_t), intent(in) :: problem
    type(training_set_t), intent(in) :: snapshots
    MPI_Comm, intent(in) :: comm
    type(pod_modes_t), intent(out) :: modes
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(pod_t) :: pod

    associate (is_normalized => problem%deck%reduction%is_normalized)
      PetscCall(decompose_contact_parts(snapshots, snapshots%free_response, terms_at(problem, snapshots), is_normalized, comm, pod, ierr))
    end associate
    modes%singular_values = pod%singular_values
    work: block
      call count_modes(problem%deck%reduction, problem%deck%path, modes, error)
      if (available_modes(modes%singular_values) == 0) then
        PetscCall(explain_no_modes(snapshots, problem%deck%path, comm, error, ierr))
      end if
      if (allocated(error)) exit work
      PetscCall(pod%left_vectors(modes%n_domain + modes%n_extra, modes%vectors, ierr))
    end block work
    PetscCall(pod%destroy(ierr))
  end subroutine compute_modes

  !> Returns the values of the lifted terms at the training points: compute_modes subtracts the response to them from the snapshots.
  !> There are none (n_terms = 0) with `dirichlet: multiplier`, where the modes contain the prescribed displacements.
  function terms_at(problem, snapshots) result(theta)
    type(problem_t), intent(in) :: problem
    type(training_set_t), intent(in) :: snapshots
    !> [-] shape (n_terms, n_snapshots)
    real(rk), allocatable :: theta(:, :)
    integer :: i_bad_point, i_bad_source

    if (problem%deck%reduction%dirichlet == 'multiplier') then
      allocate (theta(0, snapshots%n_snapshots()))
    else
      call evaluate_points(problem%terms, snapshots%parameters, theta, i_bad_point, i_bad_source)
      theta = theta(problem%lifted_terms(:size(snapshots%free_response, 2)), :)
    end if
  end function terms_at

  !> Sets modes%n_domain to reduction.n_modes, or, if the deck has no n_modes, to the number that pod_tolerance asks for. Sets
  !> modes%n_extra to the number of further modes that extended_pod_tolerance asks for, or, if the deck has none, to extra_modes.
  !> Source: section 3.4. Errors: both together are more than the modes above rounding.
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
      'the keys of reduction ask for ' // counted(modes%n_domain + modes%n_extra, 'mode') // ' (n_modes or pod_tolerance, and ' // &
      'extra_modes or extended_pod_tolerance); the snapshots have ' // to_text(n_available) // ' above rounding', path, &
      hint='take a smaller n_modes or extra_modes, or more training points')
  end subroutine count_modes

  !> Makes the error for snapshots without modes: all are zero, none has contact forces, or contact moves nothing. Collective on
  !> comm.
  subroutine explain_no_modes(snapshots, path, comm, error, ierr)
    type(training_set_t), intent(in) :: snapshots
    character(*), intent(in) :: path
    MPI_Comm, intent(in) :: comm
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: lengths(:)

    PetscCall(snapshot_lengths(snapshots, comm, lengths, ierr))
    if (.not. any(lengths > 0)) then
      call make_error(error, 'all snapshots of a cluster are zero: none of its training points loads the bodies', path, &
        hint='take training points with loads, displacements, imposed strains or overlaps that are not zero')
    else if (any(snapshots%forces() > 0)) then
      call make_error(error, 'the contact forces at the training points cause no displacement above rounding', path, &
        hint='take training points with larger contact forces; if there are none, the bodies are too stiff or held too firmly ' // &
        'for a reduced model')
    else
      call make_error(error, 'the bodies touch at none of these training points: every snapshot is the response without ' // &
        'contact, so there is nothing to make modes of', path, hint='take training points at which they touch; if the deck ' // &
        'asks for several clusters, fewer clusters may help, too')
    end if
  end subroutine explain_no_modes

  !> Computes the modes of the contact forces, as many as dual_pod_tolerance of the deck asks for. There are none (n_modes = 0)
  !> where the deck has no dual_pod_tolerance or where no snapshot has contact forces. Collective on comm, whose ranks share the
  !> work; the result is the same on each.
  !>
  !> Source: section 5.2: "this dual POD RB is only used for the RID expansion".
  subroutine compute_dual_modes(problem, snapshots, comm, vectors, ierr)
    type(problem_t), intent(in) :: problem
    type(training_set_t), intent(in) :: snapshots
    MPI_Comm, intent(in) :: comm
    !> [-] orthonormal columns, shape (n_multipliers, n_modes)
    real(rk), allocatable, intent(out) :: vectors(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: singular_values(:), all_vectors(:, :)
    integer :: n_modes

    ierr = 0
    n_modes = 0
    if (problem%deck%reduction%dual_pod_tolerance > 0) then
      PetscCall(compute_pod(snapshots%forces(), comm, singular_values, all_vectors, ierr))
      n_modes = pod_rank(singular_values, problem%deck%reduction%dual_pod_tolerance)
    else
      allocate (all_vectors(problem%rows%n_rows, 0))
    end if
    vectors = all_vectors(:, :n_modes)
  end subroutine compute_dual_modes
end module sig_training_modes
