! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Computes what hyper-reduced models need for bounds of the error of their answers (certificates) where there is no memory for the
!> matrix W of all contacts.
!>
!> W times the contact forces Lambda of the snapshots is known without W: it is the change of the openings by contact, B (u_free -
!> u). Linear solves are needed only for the contact rows of the domains and for the terms.
module sig_lifted_training
  use sig_condensed, only: condensed_t
  use sig_condensed_plan, only: number_size
  use sig_contact_columns, only: contact_columns_t
  use sig_contact_lift, only: contact_lift_t
  use sig_full_order, only: full_order_t, team_t
  use sig_hhr_data, only: hhr_data_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: transposed_product
  use sig_log, only: log_info, log_warning
  use sig_model, only: model_t
  use sig_model_parts, only: cluster_of
  use sig_petsc_support, only: broadcast_columns, max_over_ranks
  use sig_reasons, only: reason_converged, reason_linear_solver
  use sig_singular_values, only: svd
  use sig_term_values, only: evaluate_points
  use sig_text, only: short_number, to_text
  use petsc
  implicit none(type, external)
  private
  public :: add_certificates

  !> largest number of force patterns of a cluster
  integer, parameter :: most_patterns = 20
  !> largest number of snapshots that the patterns are made of
  integer, parameter :: most_samples = 300
  !> [-] patterns whose energy is at most this fraction of the largest one are rounding
  real(rk), parameter :: negligible = 1.0e-10_rk

contains

  !> Adds the data for certificates to every cluster. No cluster gets them where reduction.max_full_order_size is 0 or there are no
  !> contact rows, or, with a warning in the log, where they need more memory than max_full_order_size allows, the stiffness cannot
  !> be factored or a solve fails, or a row has no node of its own that is free to move. Collective on all ranks, with the same
  !> result on each.
  subroutine add_certificates(full_order, model, ierr)
    !> loaded problem, whose stiffness does not depend on the parameters
    type(full_order_t), intent(inout) :: full_order
    !> model of hyper-reduced clusters
    type(model_t), target, intent(inout) :: model
    PetscErrorCode, intent(out) :: ierr
    type(contact_columns_t) :: columns
    type(contact_lift_t) :: lift
    type(hhr_data_t), pointer :: cluster
    integer, allocatable :: chosen(:)
    real(rk) :: room
    integer :: i, k

    ierr = 0
    room = full_order%problem%deck%reduction%max_full_order_size
    if (room <= 0 .or. model%n_multipliers == 0) return
    if (size_of_certificates(model) > room) then
      call log_warning('hyper-reduced answers will have no bound of their error (certificate): it needs ' // &
        short_number(size_of_certificates(model), 2) // ' MB, more than reduction.max_full_order_size')
      return
    end if
    chosen = rows_of_domains(model)
    PetscCall(solve_columns(full_order, chosen, columns, lift, ierr))
    if (columns%reason /= reason_converged .or. .not. lift%is_possible) then
      call log_warning('answers will have no bound of their error (certificate): ' // why_not(columns))
      return
    end if
    do k = 1, model%n_clusters()
      cluster => cluster_of(model, k)
      call fill_certificate(model, columns, columns%columns(:, [(findloc(chosen, cluster%contact_rows(i), dim=1), &
        i=1, cluster%n_rows)]), lift, cluster)
    end do
    call log_info('certificate without the matrix of all contacts: by ' // to_text(size(chosen)) // &
      ' of its columns and the snapshots')
  end subroutine add_certificates

  !> Returns the reason, as text, why there are no certificates: the solves failed, or else the lift is not possible.
  function why_not(columns) result(reason)
    type(contact_columns_t), intent(in) :: columns
    character(:), allocatable :: reason

    reason = 'the stiffness could not be factored, or conjugate gradients did not converge'
    if (columns%reason == reason_converged) reason = 'a contact row has no node of its own that is free to move'
  end function why_not

  !> [MB] Returns the memory for the certificates of all clusters, without the lift.
  real(rk) function size_of_certificates(model) result(room)
    type(model_t), target, intent(in) :: model
    type(hhr_data_t), pointer :: cluster
    integer :: k

    room = 0
    do k = 1, model%n_clusters()
      cluster => cluster_of(model, k)
      room = room + number_size * model%n_multipliers * (model%terms%n_terms() + size(cluster%dual_snapshots, 2) + &
        cluster%n_rows + 2 * most_patterns)
    end do
  end function size_of_certificates

  !> Returns the contact rows of the domains of all clusters, ascending and each once.
  function rows_of_domains(model) result(rows)
    type(model_t), target, intent(in) :: model
    integer, allocatable :: rows(:)
    type(hhr_data_t), pointer :: cluster
    logical :: is_chosen(model%n_multipliers)
    integer :: i, k

    is_chosen = .false.
    do k = 1, model%n_clusters()
      cluster => cluster_of(model, k)
      is_chosen(cluster%contact_rows) = .true.
    end do
    rows = pack([(i, i=1, size(is_chosen))], is_chosen)
  end function rows_of_domains

  !> Computes the columns of W for the chosen rows, the openings without contact per term, and the lift. Collective on all ranks.
  !> The results of the first rank are sent to all. There are none where columns%reason is not reason_converged or lift%is_possible
  !> is false.
  subroutine solve_columns(full_order, chosen, columns, lift, ierr)
    type(full_order_t), intent(inout) :: full_order
    !> numbers of the rows, ascending
    integer, intent(in) :: chosen(:)
    type(contact_columns_t), intent(out) :: columns
    type(contact_lift_t), intent(out) :: lift
    PetscErrorCode, intent(out) :: ierr
    type(team_t), pointer :: team
    real(rk), allocatable :: values(:, :)
    real(rk) :: has_failed

    PetscCall(full_order%ready_team(team, ierr))
    associate (system => team%solver%system)
      select type (solver => team%solver%solver)
      type is (condensed_t)
        call columns%take(solver, chosen)
      class default
        PetscCall(columns%solve(system, solver%is_multigrid .or. .not. full_order%problem%plan%may_factor, chosen, ierr))
      end select
      ! conjugate gradients may fail in one group of ranks only
      has_failed = merge(0.0_rk, 1.0_rk, columns%reason == reason_converged)
      PetscCall(max_over_ranks(PETSC_COMM_WORLD, has_failed, ierr))
      if (has_failed > 0 .and. columns%reason == reason_converged) columns%reason = reason_linear_solver
      if (has_failed > 0) return
      PetscCall(lift%create(system, full_order%problem%mesh, ierr))
    end associate
    if (.not. lift%is_possible) return
    PetscCall(broadcast_columns(columns%free_opening, PETSC_COMM_WORLD, ierr))
    PetscCall(broadcast_columns(columns%columns, PETSC_COMM_WORLD, ierr))
    values = reshape(lift%stiffness%values, [size(lift%stiffness%values), 1])
    PetscCall(broadcast_columns(values, PETSC_COMM_WORLD, ierr))
    lift%stiffness%values = values(:, 1)
  end subroutine solve_columns

  !> Fills cluster%certificate. Requires: the contact forces and contact displacements of the snapshots in `cluster`. Local.
  subroutine fill_certificate(model, columns, own_columns, lift, cluster)
    type(model_t), intent(in) :: model
    type(contact_columns_t), intent(in) :: columns
    !> [length/force] columns of W for the contact rows of the domain of this cluster, shape (n_multipliers, n_rows)
    real(rk), intent(in) :: own_columns(:, :)
    type(contact_lift_t), intent(in) :: lift
    type(hhr_data_t), intent(inout) :: cluster
    real(rk), allocatable :: balanced(:, :), theta(:, :)
    integer :: i_bad_point, i_bad_source

    call evaluate_points(model%terms, model%training_points(:, cluster%training_points), theta, i_bad_point, i_bad_source)
    associate (data => cluster%certificate, n => model%n_multipliers, values => cluster%contact_displacement_snapshots)
      data%free_opening = columns%free_opening
      data%row_opening = own_columns
      data%anchors = columns%anchors%rows
      data%lift = lift%stiffness
      data%snapshot_opening = matmul(model%gap - data%free_opening, theta) - (values(:n, :) - values(n + 1:, :))
      balanced = cluster%dual_snapshots
      balanced(data%anchors, :) = balanced(data%anchors, :) - matmul(transpose(columns%anchors%closing), balanced)
      call choose_patterns(balanced, data%snapshot_opening, data%largest_size, data%pattern_forces, data%pattern_opening)
    end associate
  end subroutine fill_certificate

  !> Computes up to 20 POD modes ("patterns") of the contact forces in the norm of W, that is, in the energy norm of the
  !> displacements that the forces cause. They are made of at most 300 snapshots, taken at equal steps. Patterns with at most 1e-10
  !> of the largest energy are left out. Local.
  subroutine choose_patterns(forces, openings, largest_size, patterns, pattern_openings)
    !> [force] Lambda, in balance with the anchors, and [length] W Lambda; shape (n_multipliers, n_snapshots)
    real(rk), intent(in) :: forces(:, :)
    real(rk), intent(in) :: openings(:, :)
    !> [sqrt(force*length)] largest norm of the forces of a snapshot, of all snapshots
    real(rk), intent(out) :: largest_size
    !> [sqrt(force/length)] patterns of norm 1, and [sqrt(length/force)] W times them; shape (n_multipliers, n_patterns)
    real(rk), allocatable, intent(out) :: patterns(:, :)
    real(rk), allocatable, intent(out) :: pattern_openings(:, :)
    real(rk), allocatable :: gram(:, :), u(:, :), s(:), vt(:, :), weights(:, :)
    integer, allocatable :: some(:)
    integer :: i, n

    largest_size = sqrt(maxval([0.0_rk, (dot_product(forces(:, i), openings(:, i)), i=1, size(forces, 2))]))
    n = min(size(forces, 2), most_samples)
    some = [(1 + ((i - 1) * size(forces, 2)) / n, i=1, n)]
    gram = transposed_product(forces(:, some), openings(:, some))
    call svd((gram + transpose(gram)) / 2, u, s, vt)
    n = min(most_patterns, count(s > negligible * maxval([0.0_rk, s])))
    weights = u(:, :n) / spread(sqrt(s(:n)), 1, size(some))
    patterns = matmul(forces(:, some), weights)
    pattern_openings = matmul(openings(:, some), weights)
  end subroutine choose_patterns
end module sig_lifted_training
