! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Trains a condensed model of a contact that is so large that W takes too much memory. In each cluster of training points, only the
!> contact rows that change are kept.
!>
!> A cluster is a group of training points whose active sets differ little. In a cluster, rows that are closed at all points are
!> tied: they stay closed. Rows that are open at all points carry no force. The unknowns of a query are the other rows and some
!> rings of neighbors around them.
!>
!> With friction, a contact is tied only if it is closed and sticks in all states of all histories. Its first slip would count from
!> the place 0, so that its tangential rows are tied there, too. A contact that closes later sticks where it has closed, and one
!> that slips has no fixed place: both may change. Tied surfaces never change. All histories are one cluster: a state depends on
!> those before it, and the next ones are not known when a query begins.
module sig_tied_training
  use sig_bits, only: pack_columns
  use sig_compliance, only: compliance_point_t
  use sig_condensed_model, only: condensed_model_t
  use sig_condensed_plan, only: displacement_plan_t, number_size, plan_displacements, room_of
  use sig_energy_modes, only: choose_combinations, product_of
  use sig_errors, only: error_t
  use sig_full_order, only: full_order_t, team_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: transposed_product
  use sig_log, only: log_info
  use sig_petsc_support, only: broadcast_columns, multiply_block, sum_over_ranks
  use sig_problem, only: problem_t
  use sig_reasons, only: reason_converged, reason_text
  use sig_reduced, only: reduced_t
  use sig_reference_sets, only: group_sets
  use sig_rounding, only: rounding
  use sig_singular_values, only: svd
  use sig_term_values, only: evaluate_points
  use sig_text, only: counted, short_number, to_text
  use sig_tied, only: solve_tied, tied_response_t
  use sig_tied_compliance, only: row_changing, row_closed, row_open, tied_cluster_t, tied_compliance_t
  use sig_training_set, only: training_set_t
  use petsc
  implicit none(type, external)
  private
  public :: train_tied

  !> number of rings of neighbors around the rows that change at the training points
  integer, parameter :: n_rings = 2
  !> [-] share of the largest friction from which on a contact counts as one that slips
  real(rk), parameter :: at_limit = 1 - 1.0e-6_rk
  !> most clusters; more would leave each too few training points to know which rows change
  integer, parameter :: most_clusters = 16

contains

  !> Trains the model, unless the rows that may change need more memory than reduction.max_full_order_size or the tied stiffness
  !> cannot be factored. Where reduction.displacement is auto or asks for modes, the displacements of each cluster are by modes.
  !> Collective on all ranks, with the same result on each.
  !>
  !> Errors: those of group_sets.
  subroutine train_tied(full_order, snapshots, part, reason, error, ierr)
    !> loaded problem; without friction and ties without a body that only contact holds
    type(full_order_t), intent(inout) :: full_order
    !> points with full-order contact forces
    type(training_set_t), intent(in) :: snapshots
    !> not allocated where there is no model
    class(reduced_t), allocatable, intent(out) :: part
    !> why there is no model; empty where there is one, or an error
    character(:), allocatable, intent(out) :: reason
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(condensed_model_t), allocatable :: model
    type(tied_compliance_t), allocatable :: reduced
    type(displacement_plan_t) :: plan
    integer, allocatable :: states(:, :)
    integer :: i

    ierr = 0
    allocate (reduced)
    states = states_of(full_order%problem, snapshots)
    plan = plan_displacements(full_order%problem)
    reduced%exact_dofs = plan%exact_dofs
    reduced%exact_boundaries = plan%boundaries
    call divide(full_order%problem, states, reduced, reason, error)
    if (allocated(error) .or. reason /= '') return
    ! steps with friction start from the last time
    if (full_order%problem%laws%is_plain()) reduced%start_sets = pack_columns(states == row_closed)
    do i = 1, size(reduced%clusters)
      PetscCall(fill_cluster(full_order, i, snapshots, plan%has_modes, reduced, reason, ierr))
      if (reason /= '') return
    end do
    allocate (model)
    call move_alloc(reduced, model%compliance)
    call move_alloc(model, part)
  end subroutine train_tied

  !> Returns the state of each contact at each training point: row_closed, row_open, or row_changing for a contact with friction
  !> that is closed and may slip. Tied surfaces are closed. Shape (n_contacts, n_points).
  function states_of(problem, snapshots) result(states)
    type(problem_t), intent(in) :: problem
    type(training_set_t), intent(in) :: snapshots
    integer, allocatable :: states(:, :)
    real(rk), allocatable :: forces(:, :), theta(:, :)
    logical, allocatable :: has_friction(:)
    integer :: i, i_bad_point, i_bad_source, k

    forces = snapshots%forces()
    ! the points have been evaluated before
    call evaluate_points(problem%terms, snapshots%parameters, theta, i_bad_point, i_bad_source)
    associate (laws => problem%laws)
      has_friction = laws%have_friction()
      allocate (states(laws%n_contacts, size(forces, 2)))
      do i = 1, size(states, 2)
        states(:, i) = merge(row_closed, row_open, laws%are_closed(forces(:, i)))
        associate (largest => at_limit * laws%friction_at(theta(:, i)) * forces(:laws%n_contacts, i))
          do k = 1, laws%n_contacts
            if (.not. has_friction(k) .or. states(k, i) == row_open) cycle
            if (.not. norm2(laws%tangential(k, forces(:, i))) < largest(k)) states(k, i) = row_changing
          end do
        end associate
      end do
    end associate
  end function states_of

  !> Divides the training points into 1 cluster, then into twice as many each time, until reduction.max_full_order_size allows the
  !> memory that the contact forces of all clusters need; displacements are not counted. There are at most 16 clusters, at most as
  !> many as points, and fewer where there are fewer different active sets; with friction or ties there is one. Local. Errors: those
  !> of group_sets.
  subroutine divide(problem, states, data, reason, error)
    type(problem_t), intent(in) :: problem
    !> of states_of
    integer, intent(in) :: states(:, :)
    !> cluster_of_point and the status of the rows of each cluster are set
    type(tied_compliance_t), intent(inout) :: data
    !> why no division is possible; empty where one is
    character(:), allocatable, intent(out) :: reason
    type(error_t), allocatable, intent(out) :: error
    integer :: i, k, most, n_clusters
    real(rk) :: least, room

    reason = ''
    n_clusters = 1
    most = 1
    if (problem%laws%is_plain()) most = min(most_clusters, size(states, 2))
    least = huge(least)
    do
      call group_sets(states == row_closed, n_clusters, data%cluster_of_point, error)
      if (allocated(error)) return
      if (allocated(data%clusters)) deallocate (data%clusters)
      allocate (data%clusters(maxval(data%cluster_of_point)))
      do k = 1, size(data%clusters)
        data%clusters(k)%status = status_of_rows(problem, states(:, pack([(i, i=1, size(states, 2))], data%cluster_of_point == k)))
      end do
      room = 0
      do k = 1, size(data%clusters)
        room = room + number_size * problem%force_rows%n_rows * &
          real(problem%boundary%n_terms + count(data%clusters(k)%status == row_changing), rk)
      end do
      least = min(least, room)
      if (room <= room_of(problem)) exit
      if (n_clusters >= most) then
        reason = 'with unknowns only at contacts that change it still takes ' // short_number(least, 2) // ' MB'
        if (problem%laws%is_plain()) reason = reason // ', also if the training points are divided into clusters'
        return
      end if
      n_clusters = min(2 * n_clusters, most)
    end do
    do k = 1, size(data%clusters)
      if (.not. problem%motions%are_held_by(data%clusters(k)%status == row_closed)) reason = &
        'the contacts that stay closed and stuck do not hold the bodies that only contact holds'
    end do
  end subroutine divide

  !> Returns the status of each contact row in a cluster: closed at all of its points, open at all of them, or changing. Contacts
  !> within two rings of cells around one that changes count as changing, too, because they may change between these points; only
  !> tied surfaces never do.
  function status_of_rows(problem, states) result(status)
    type(problem_t), intent(in) :: problem
    !> at the points of the cluster, shape (n_contacts, n_points)
    integer, intent(in) :: states(:, :)
    !> row_closed, row_open or row_changing
    integer :: status(problem%force_rows%n_rows)
    logical :: is_changing(size(states, 1))
    integer :: i

    is_changing = .not. (all(states == row_closed, dim=2) .or. all(states == row_open, dim=2))
    do i = 1, n_rings
      call add_ring(problem, is_changing)
    end do
    associate (of_contacts => merge(row_changing, states(:, 1), is_changing .and. .not. problem%laws%is_tied))
      status = of_contacts(problem%laws%contacts_of_forces())
    end associate
  end function status_of_rows

  !> Marks also the contact rows with a node in a cell that contains a node of a marked row.
  subroutine add_ring(problem, is_marked)
    type(problem_t), intent(in) :: problem
    !> shape (n_rows)
    logical, intent(inout) :: is_marked(:)
    logical :: is_node(problem%mesh%n_nodes), is_near(problem%mesh%n_nodes)
    integer :: i, k

    is_node = .false.
    do k = 1, size(is_marked)
      if (is_marked(k)) is_node(problem%rows%nodes_of(k)) = .true.
    end do
    is_near = is_node
    associate (mesh => problem%mesh)
      do i = 1, mesh%n_cells
        associate (nodes => mesh%cell_nodes(mesh%cell_offsets(i) + 1:mesh%cell_offsets(i + 1)))
          if (any(is_node(nodes))) is_near(nodes) = .true.
        end associate
      end do
    end associate
    do k = 1, size(is_marked)
      is_marked(k) = is_marked(k) .or. any(is_near(problem%rows%nodes_of(k)))
    end do
  end subroutine add_ring

  !> Computes the responses of cluster i with its closed rows tied, and logs how many of its rows may change, stay closed and stay
  !> open. Collective on all ranks; the results of the first rank are sent to all. The cluster has no responses where `reason` is
  !> not empty.
  subroutine fill_cluster(full_order, i, snapshots, has_modes, data, reason, ierr)
    type(full_order_t), intent(inout) :: full_order
    integer, intent(in) :: i
    type(training_set_t), intent(in) :: snapshots
    !> whether modes are wanted
    logical, intent(in) :: has_modes
    type(tied_compliance_t), intent(inout) :: data
    !> why the problem with tied rows could not be factored or solved; empty where it could
    character(:), allocatable, intent(out) :: reason
    PetscErrorCode, intent(out) :: ierr
    type(team_t), pointer :: team
    type(tied_response_t) :: response
    real(rk), allocatable :: forces(:, :), patterns(:, :)
    integer :: k

    reason = ''
    associate (cluster => data%clusters(i))
      associate (status => cluster%status(:full_order%problem%laws%n_contacts))
        call log_info('cluster ' // to_text(i) // ': ' // counted(count(status == row_changing), 'contact') // &
          ' may change, ' // to_text(count(status == row_closed)) // ' stay closed, ' // &
          to_text(count(status == row_open)) // ' stay open')
      end associate
      associate (changing => pack([(k, k=1, size(cluster%status))], cluster%status == row_changing), &
                 points => pack([(k, k=1, snapshots%n_snapshots())], data%cluster_of_point == i .and. has_modes))
        forces = snapshots%forces()
        forces = forces(changing, points)
      end associate
      patterns = principal_patterns(forces)
      PetscCall(full_order%ready_team(team, ierr))
      PetscCall(solve_tied(team%solver%system, cluster%status, data%exact_dofs, patterns, response, ierr))
      if (response%reason /= reason_converged) then
        reason = 'with the closed contacts tied, ' // reason_text(response%reason)
        return
      end if
      call move_alloc(response%free, cluster%free)
      call move_alloc(response%operator, cluster%operator)
      call move_alloc(response%free_field, cluster%inner%free_response)
      cluster%inner%contact_response = -response%field
      PetscCall(broadcast_columns(cluster%free, PETSC_COMM_WORLD, ierr))
      PetscCall(broadcast_columns(cluster%operator, PETSC_COMM_WORLD, ierr))
      PetscCall(broadcast_columns(cluster%inner%free_response, PETSC_COMM_WORLD, ierr))
      PetscCall(broadcast_columns(cluster%inner%contact_response, PETSC_COMM_WORLD, ierr))
      if (size(patterns, 2) > 0) then
        PetscCall(add_modes(full_order%problem, team, forces, patterns, response, cluster, ierr))
        call measure_fields(full_order%problem, snapshots, i, forces, data)
      end if
    end associate
  end subroutine fill_cluster

  !> Returns an orthonormal basis of force patterns; a pattern of zeros if there are points but no forces.
  function principal_patterns(forces) result(patterns)
    !> [force] at the points of a cluster, shape (n_changing, n_points)
    real(rk), intent(in) :: forces(:, :)
    real(rk), allocatable :: patterns(:, :)
    real(rk), allocatable :: u(:, :), s(:), vt(:, :)

    call svd(forces, u, s, vt)
    patterns = u(:, :count(s > rounding * maxval([0.0_rk, s])))
    if (size(patterns, 2) == 0 .and. size(forces, 2) > 0) patterns = spread(0 * forces(:, 1), 2, 1)
  end function principal_patterns

  !> Sets the modes of a cluster, which are orthonormal in the norm of K and span the displacements of the patterns, and its
  !> energies. For forces lambda on the changing rows |H lambda|_K^2 = lambda'S lambda, because the tied rows do no work.
  !> Collective.
  subroutine add_modes(problem, team, forces, patterns, response, cluster, ierr)
    type(problem_t), intent(in) :: problem
    type(team_t), intent(inout) :: team
    !> [force] at the points of the cluster, shape (n_changing, n_points)
    real(rk), intent(in) :: forces(:, :)
    !> of principal_patterns
    real(rk), intent(in) :: patterns(:, :)
    type(tied_response_t), intent(in) :: response
    type(tied_cluster_t), intent(inout) :: cluster
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: combinations(:, :), compliance(:, :), driven(:, :), shared(:, :)
    integer :: k

    associate (changing => pack([(k, k=1, size(cluster%status))], cluster%status == row_changing), inner => cluster%inner, &
      modes => cluster%inner%field)
      compliance = cluster%operator(changing, :)
      compliance = (compliance + transpose(compliance)) / 2
      call choose_combinations(forces, compliance, combinations)
      ! without forces on changing rows the whole displacement is free_field, and one mode of zeros says that it is there
      if (size(combinations, 2) == 0) combinations = reshape([real(rk) ::], [size(changing), 1], pad=[0.0_rk])
      modes%modes = -product_of(response%pattern_fields, transposed_product(patterns, combinations))
      PetscCall(broadcast_columns(modes%modes, PETSC_COMM_WORLD, ierr))
      modes%coordinates = transposed_product(combinations, compliance)
      PetscCall(broadcast_columns(modes%coordinates, PETSC_COMM_WORLD, ierr))
      inner%free_response = response%whole_free_field
      PetscCall(broadcast_columns(cluster%inner%free_response, PETSC_COMM_WORLD, ierr))
      associate (system => team%solver%system, own => team%solver%system%map%local_dofs)
        allocate (driven(size(own), problem%boundary%n_terms))
        PetscCall(multiply_block(system%stiffness, inner%free_response(own, :), driven, ierr))
        inner%free_energy = transposed_product(inner%free_response(own, :), driven)
        shared = transposed_product(modes%modes(own, :), driven)
        PetscCall(sum_over_ranks(system%comm, inner%free_energy, ierr))
        PetscCall(sum_over_ranks(system%comm, shared, ierr))
      end associate
      inner%shared_energy = transposed_product(modes%coordinates, shared)
      PetscCall(broadcast_columns(inner%free_energy, PETSC_COMM_WORLD, ierr))
      PetscCall(broadcast_columns(inner%shared_energy, PETSC_COMM_WORLD, ierr))
    end associate
  end subroutine add_modes

  !> Raises data%largest_field to the largest size of the displacement at the points of a cluster. Local.
  subroutine measure_fields(problem, snapshots, i, forces, data)
    type(problem_t), intent(in) :: problem
    type(training_set_t), intent(in) :: snapshots
    !> cluster, with its energies
    integer, intent(in) :: i
    !> [force] at the points of the cluster, shape (n_changing, n_points)
    real(rk), intent(in) :: forces(:, :)
    type(tied_compliance_t), intent(inout) :: data
    real(rk), allocatable :: theta(:, :)
    integer, allocatable :: points(:)
    integer :: i_bad_point, i_bad_source, k
    type(compliance_point_t) :: unused

    points = pack([(k, k=1, snapshots%n_snapshots())], data%cluster_of_point == i)
    call evaluate_points(problem%terms, snapshots%parameters(:, points), theta, i_bad_point, i_bad_source)
    associate (inner => data%clusters(i)%inner)
      do k = 1, size(points)
        data%largest_field = max(data%largest_field, inner%size_of_field(theta(:, k), forces(:, k), &
          sum(matmul(inner%field%coordinates, forces(:, k))**2), unused))
      end do
    end associate
  end subroutine measure_fields
end module sig_tied_training
