! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Finds how a condensed model keeps the displacements H z of all dofs: by modes if few are enough, else compressed. Both are chosen
!> by their error in the norm of K at training points and at probes, where the model itself gives the contact forces.
!>
!> Half of the probes help to choose the modes. The other half measures them, because modes are always good where they come from.
module sig_contact_field_training
  use sig_answer, only: answer_t, comparable_size
  use sig_block_compression, only: append_columns, compress_columns, piece_t
  use sig_bodies, only: find_bodies
  use sig_compressed_matrix, only: block_entries, compressed_matrix_t
  use sig_condensed, only: condensed_t
  use sig_contact_field, only: contact_field_t
  use sig_contact_system, only: contact_system_t
  use sig_dense_kernels, only: factor_cholesky
  use sig_energy_modes, only: choose_combinations, product_of
  use sig_full_order, only: full_order_t, team_t
  use sig_kinds, only: rk
  use sig_linear_algebra, only: transposed_product
  use sig_log, only: log_info, log_warning
  use sig_petsc_support, only: broadcast_columns, broadcast_integers, broadcast_singles, multiply_block, sum_over_ranks
  use sig_point_tree, only: point_tree_t
  use sig_probe_points, only: find_probes
  use sig_problem, only: problem_t
  use sig_progress, only: progress_t
  use sig_reduced, only: neighbors_t, reduced_t, room_t
  use sig_reduced_condensed, only: reduced_condensed_t
  use sig_singular_values, only: singular_values
  use sig_term_values, only: evaluate_points
  use sig_text, only: counted, short_number
  use sig_training_set, only: training_set_t
  use petsc
  implicit none(type, external)
  private
  public :: add_contact_field, measure_displacements

  !> Solutions of the condensed problem.
  type :: states_t
    !> [force] z, with 0 at anchors; shape (n_multipliers, n_states)
    real(rk), allocatable :: unknowns(:, :)
    !> [force*length] z'C z, shape (n_states)
    real(rk), allocatable :: energies(:)
    !> [sqrt(force*length)] size of the displacement to which errors are relative, shape (n_states)
    real(rk), allocatable :: sizes(:)
    !> whether the state may be used to choose modes, shape (n_states)
    logical, allocatable :: is_for_modes(:)
  end type states_t

  !> columns of a group
  integer, parameter :: group_size = 64
  !> points of a leaf of the tree of nodes
  integer, parameter :: leaf_size = 32
  !> Modes are taken if they are at most this share of the contacts: compressed responses need about as much memory then.
  real(rk), parameter :: most_modes = 0.1_rk
  integer, parameter :: few_modes = 10
  !> [s] progress is told only if compression takes longer
  real(rk), parameter :: seconds_of_silence = 3
  !> most attempts to reach the tolerance by compression
  integer, parameter :: most_attempts = 6

contains

  !> Adds G and H of all dofs to the model, so that the error of displacements at the states is at most
  !> reduction.displacement_tolerance; warns where this cannot be reached. Collective on all ranks, with the same result on each.
  !> Requires: `reduced` answers queries.
  subroutine add_contact_field(full_order, snapshots, reduced, ierr)
    type(full_order_t), intent(inout) :: full_order
    type(training_set_t), intent(in) :: snapshots
    !> gets field, free_response of all dofs and largest_field
    type(reduced_condensed_t), intent(inout) :: reduced
    PetscErrorCode, intent(out) :: ierr
    type(team_t), pointer :: team
    type(condensed_t), pointer :: condensed
    type(states_t) :: states
    real(rk), allocatable :: combinations(:, :), motions(:, :)
    real(rk) :: error, tolerance

    PetscCall(full_order%ready_team(team, ierr))
    PetscCall(team%solver%condense(condensed, ierr))
    tolerance = full_order%problem%deck%reduction%displacement_tolerance
    call find_states(full_order%problem, snapshots, reduced, .true., states)
    associate (system => team%solver%system, field => reduced%field)
      call field%complete(system%map%n_dofs, system%rows%n_rows)
      PetscCall(system%share_columns(condensed%free_response, size(condensed%free_response, 2), reduced%free_response, ierr))
      PetscCall(broadcast_columns(reduced%free_response, PETSC_COMM_WORLD, ierr))
      allocate (motions(system%map%n_local_dofs, size(reduced%anchors)))
      PetscCall(condensed%respond_to_rows(system, reduced%anchors, motions, ierr))
      PetscCall(system%share_columns(motions, size(motions, 2), field%motions, ierr))
      PetscCall(broadcast_columns(field%motions, PETSC_COMM_WORLD, ierr))
      call choose_modes(states, reduced, tolerance, combinations)
      if (allocated(combinations)) then
        PetscCall(make_modes(system, condensed, combinations, field, ierr))
      else
        PetscCall(compress(full_order%problem, system, condensed, states, reduced, ierr))
      end if
    end associate
    error = largest_error(states, reduced)
    if (error <= tolerance) then
      call log_info('displacements ' // reduced%field%describe() // ': their error in energy is at most ' // &
        short_number(error, 2) // ' at ' // counted(size(states%sizes), 'point'))
    else
      call log_warning('displacements ' // reduced%field%describe() // ' have an error in energy of up to ' // &
        short_number(error, 2) // ', more than reduction.displacement_tolerance (' // short_number(tolerance, 2) // ')')
    end if
  end subroutine add_contact_field

  !> Sets reduced%largest_field, the largest size of the displacement at the training points. Local. Requires: `reduced` answers
  !> queries.
  subroutine measure_displacements(problem, snapshots, reduced)
    type(problem_t), intent(in) :: problem
    type(training_set_t), intent(in) :: snapshots
    type(reduced_condensed_t), intent(inout) :: reduced
    type(states_t) :: states

    call find_states(problem, snapshots, reduced, .false., states)
  end subroutine measure_displacements

  !> Finds the states: the training points, then the probes if they are wanted. Points without an answer are left out. Also sets
  !> reduced%largest_field. Local, with the same result on each rank.
  subroutine find_states(problem, snapshots, reduced, has_probes, states)
    type(problem_t), intent(in) :: problem
    type(training_set_t), intent(in) :: snapshots
    type(reduced_condensed_t), intent(inout) :: reduced
    logical, intent(in) :: has_probes
    type(states_t), intent(out) :: states
    class(reduced_t), pointer :: nobody
    class(room_t), allocatable :: room
    type(answer_t) :: answer
    real(rk), allocatable :: at_points(:, :), at_probes(:, :), theta(:, :)
    integer, allocatable :: nearest(:)
    integer :: i, i_bad_point, i_bad_source, n, n_points

    nobody => null()
    call evaluate_points(problem%terms, snapshots%parameters, at_points, i_bad_point, i_bad_source)
    n_points = size(at_points, 2)
    if (has_probes) then
      call find_probes(problem, snapshots%parameters, at_probes, nearest)
    else
      allocate (at_probes(size(at_points, 1), 0), nearest(0))
    end if
    theta = reshape([at_points, at_probes], [size(at_points, 1), n_points + size(at_probes, 2)])
    nearest = [[(i, i=1, n_points)], nearest]
    call reduced%transform_openings()
    call reduced%create_room(room)
    allocate (states%unknowns(reduced%n_rows(), size(nearest)), states%energies(size(nearest)), states%sizes(size(nearest)))
    n = 0
    do i = 1, size(nearest)
      call answer%start(1, size(theta, 1), reduced%n_modes(), reduced%n_rows(), reduced%n_rows())
      call reduced%solve(theta(:, i), neighbors_t(nearest=nearest(i)), nobody, room, answer)
      if (answer%reason <= 0) cycle
      n = n + 1
      states%unknowns(:, n) = answer%unknowns
      states%unknowns(reduced%anchors, n) = 0
      states%energies(n) = dot_product(states%unknowns(:, n), matmul(reduced%compliance, states%unknowns(:, n)))
      states%sizes(n) = reduced%size_of_field(theta(:, i), states%unknowns(:, n), states%energies(n))
      if (i <= n_points) reduced%largest_field = max(reduced%largest_field, states%sizes(n))
    end do
    states%unknowns = states%unknowns(:, :n)
    states%energies = states%energies(:n)
    states%sizes = [(max(comparable_size(states%sizes(i), reduced%largest_field), tiny(1.0_rk)), i=1, n)]
    states%is_for_modes = [(i <= n_points .or. modulo(i, 2) == 0, i=1, n)]
  end subroutine find_states

  !> Finds the combinations S of contact forces whose displacements H S are the modes, orthonormal in the norm of K: the principal
  !> ones of the states, each state relative to its size. There are as many as bring the error of all states to the tolerance.
  !> They are not allocated if that takes too many. Local, with the same result on each rank.
  subroutine choose_modes(states, reduced, tolerance, combinations)
    type(states_t), intent(in) :: states
    type(reduced_condensed_t), intent(in) :: reduced
    !> [-]
    real(rk), intent(in) :: tolerance
    !> [force/sqrt(force*length)] S, shape (n_multipliers, n_modes)
    real(rk), allocatable, intent(out) :: combinations(:, :)
    real(rk), allocatable :: all_combinations(:, :), chosen(:, :), coordinates(:, :)
    integer :: i, n

    chosen = states%unknowns(:, pack([(i, i=1, size(states%sizes))], states%is_for_modes))
    associate (sizes => pack(states%sizes, states%is_for_modes))
      do i = 1, size(chosen, 2)
        chosen(:, i) = chosen(:, i) / sizes(i)
      end do
    end associate
    call choose_combinations(chosen, reduced%compliance, all_combinations)
    coordinates = transposed_product(product_of(reduced%compliance, all_combinations), states%unknowns)
    n = number_of_modes(states, coordinates, tolerance)
    if (n > min(size(coordinates, 1), max(few_modes, int(most_modes * reduced%n_rows())))) return
    combinations = all_combinations(:, :n)
  end subroutine choose_modes

  !> Returns the least number of modes with which the error of all states is at most the tolerance; one more than there are if all
  !> are not enough.
  pure integer function number_of_modes(states, coordinates, tolerance) result(n)
    type(states_t), intent(in) :: states
    !> of the states in all modes, shape (n_modes, n_states)
    real(rk), intent(in) :: coordinates(:, :)
    real(rk), intent(in) :: tolerance
    real(rk) :: squares(size(states%sizes))

    squares = states%energies
    do n = 0, size(coordinates, 1)
      if (n > 0) squares = squares - coordinates(n, :)**2
      if (all(sqrt(max(squares, 0.0_rk)) <= tolerance * states%sizes)) return
    end do
  end function number_of_modes

  !> Sets modes and coordinates of the field. Without any mode there is one of zeros, so that the model keeps G of all dofs.
  !> Collective on all ranks.
  subroutine make_modes(system, condensed, combinations, field, ierr)
    type(contact_system_t), intent(in) :: system
    type(condensed_t), intent(inout) :: condensed
    !> S
    real(rk), intent(in) :: combinations(:, :)
    type(contact_field_t), intent(inout) :: field
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: local(:, :), used(:, :)

    allocate (used(size(combinations, 1), max(1, size(combinations, 2))), source=0.0_rk)
    used(:, :size(combinations, 2)) = combinations
    allocate (local(system%map%n_local_dofs, size(used, 2)))
    PetscCall(condensed%respond(system, used, local, ierr))
    PetscCall(system%share_columns(local, size(local, 2), field%modes, ierr))
    PetscCall(broadcast_columns(field%modes, PETSC_COMM_WORLD, ierr))
    field%coordinates = transposed_product(used, condensed%compliance)
    field%coordinates(:, condensed%anchors%rows) = 0
    PetscCall(broadcast_columns(field%coordinates, PETSC_COMM_WORLD, ierr))
  end subroutine make_modes

  !> Compresses H until the error of all states is at most reduction.displacement_tolerance, in a few attempts. Collective on all
  !> ranks.
  subroutine compress(problem, system, condensed, states, reduced, ierr)
    type(problem_t), intent(in) :: problem
    type(contact_system_t), intent(inout) :: system
    type(condensed_t), intent(inout) :: condensed
    type(states_t), intent(in) :: states
    type(reduced_condensed_t), intent(inout) :: reduced
    PetscErrorCode, intent(out) :: ierr
    type(point_tree_t) :: nodes, contacts
    real(rk), allocatable :: row_scale(:)
    real(rk) :: error, threshold
    integer :: i

    call plant_trees(problem, reduced%anchors, nodes, contacts)
    PetscCall(scale_rows(system, row_scale, ierr))
    associate (tolerance => problem%deck%reduction%displacement_tolerance)
      threshold = tolerance / 10
      do i = 1, most_attempts
        PetscCall(compress_groups(problem, system, condensed, nodes, contacts, row_scale, threshold, reduced, ierr))
        error = largest_error(states, reduced)
        if (error <= tolerance) exit
        threshold = threshold * max(0.1_rk, tolerance / (2 * error))
      end do
    end associate
    PetscCall(agree(reduced%field, ierr))
  end subroutine compress

  !> Orders the nodes, body by body, and the contacts that are not anchors, so that near ones stand together. Local.
  subroutine plant_trees(problem, anchors, nodes, contacts)
    type(problem_t), intent(in) :: problem
    integer, intent(in) :: anchors(:)
    type(point_tree_t), intent(out) :: nodes
    !> its points are the contacts without the anchors
    type(point_tree_t), intent(out) :: contacts
    integer, allocatable :: body_of_node(:), rows(:)
    real(rk), allocatable :: places(:, :)
    integer :: i, n_bodies

    call find_bodies(problem%mesh, body_of_node, n_bodies)
    call nodes%create(problem%mesh%coordinates, body_of_node, leaf_size)
    rows = pack([(i, i=1, problem%rows%n_rows)], [(all(anchors /= i), i=1, problem%rows%n_rows)])
    allocate (places(problem%mesh%n_dim, size(rows)))
    do i = 1, size(rows)
      places(:, i) = problem%mesh%coordinates(:, minval(problem%rows%first_nodes_of(rows(i))))
    end do
    call contacts%create(places, [(1, i=1, size(rows))], group_size)
    contacts%order = rows(contacts%order)
  end subroutine plant_trees

  !> [sqrt(force/length)] Returns the roots of the diagonal of K, in natural order. An error of H, scaled by them, has about its
  !> size in the norm of K. Collective.
  subroutine scale_rows(system, row_scale, ierr)
    type(contact_system_t), intent(inout) :: system
    !> shape (n_dofs)
    real(rk), allocatable, intent(out) :: row_scale(:)
    PetscErrorCode, intent(out) :: ierr

    allocate (row_scale(system%map%n_dofs))
    PetscCall(MatGetDiagonal(system%stiffness, system%work_out, ierr))
    PetscCall(system%get(system%work_out, row_scale, ierr))
    row_scale = sqrt(row_scale)
  end subroutine scale_rows

  !> Compresses H group by group of columns, and measures the error of each. In a group J with C_JJ = L L', the columns H_J L'^-1
  !> are orthonormal in the norm of K, so that a threshold for them is one for relative errors in this norm. Collective.
  subroutine compress_groups(problem, system, condensed, nodes, contacts, row_scale, threshold, reduced, ierr)
    type(problem_t), intent(in) :: problem
    type(contact_system_t), intent(in) :: system
    type(condensed_t), intent(inout) :: condensed
    type(point_tree_t), intent(in) :: nodes
    type(point_tree_t), intent(in) :: contacts
    !> of scale_rows
    real(rk), intent(in) :: row_scale(:)
    !> [-] largest error in a leaf of the tree
    real(rk), intent(in) :: threshold
    type(reduced_condensed_t), intent(inout) :: reduced
    PetscErrorCode, intent(out) :: ierr
    type(piece_t), allocatable :: pieces(:)
    type(progress_t) :: progress
    real(rk), allocatable :: columns(:, :), factor(:, :), own(:, :), scaled(:, :)
    integer, allocatable :: dofs(:), group(:)
    real(rk) :: error
    integer :: i, k

    ierr = 0
    dofs = [((problem%mesh%n_dim * (nodes%order(i) - 1) + k, k=1, problem%mesh%n_dim), i=1, size(nodes%order))]
    associate (field => reduced%field)
      call clear(field)
      call progress%start('compressed responses to contact forces', size(contacts%order), seconds_of_silence)
      do i = 1, size(contacts%first)
        if (contacts%children(1, i) /= 0) cycle
        group = contacts%order(contacts%first(i):contacts%last(i))
        allocate (own(system%map%n_local_dofs, size(group)))
        PetscCall(condensed%respond_to_rows(system, group, own, ierr))
        PetscCall(system%share_columns(own, size(group), columns, ierr))
        columns = columns(dofs, :)
        call factor_group(reduced%compliance(group, group), factor)
        scaled = columns * spread(row_scale(dofs), 2, size(group))
        call divide_by_factor(factor, scaled)
        call compress_columns(nodes, problem%mesh%n_dim, scaled, threshold, pieces)
        call append_columns(nodes, pieces, columns, 1 / row_scale(dofs), transpose(factor), field%responses)
        field%responses%row_order = dofs
        field%responses%column_order = [field%responses%column_order, group]
        field%group_ends = [field%group_ends, size(field%responses%column_order)]
        PetscCall(measure_group(system, own, factor, field, error, ierr))
        deallocate (own)
        field%group_errors = [field%group_errors, error]
        call progress%advance(size(field%responses%column_order))
      end do
      call progress%finish()
    end associate
  end subroutine compress_groups

  !> Removes what an attempt left.
  subroutine clear(field)
    type(contact_field_t), intent(inout) :: field

    field%responses = compressed_matrix_t()
    call field%responses%complete()
    field%group_ends = [integer ::]
    field%group_errors = [real(rk) ::]
  end subroutine clear

  !> Factors C_JJ = L L'. If it is not positive definite, as where two rows do the same, a little is added to its diagonal, until it
  !> is.
  subroutine factor_group(compliance, factor)
    !> C_JJ
    real(rk), intent(in) :: compliance(:, :)
    !> L, zero above the diagonal
    real(rk), allocatable, intent(out) :: factor(:, :)
    real(rk) :: added, diagonal(size(compliance, 1))
    integer :: i, info, n

    n = size(compliance, 1)
    diagonal = [(compliance(i, i), i=1, n)]
    added = 0
    do
      factor = compliance
      do i = 1, n
        factor(i, i) = factor(i, i) + added * maxval(diagonal)
      end do
      call factor_cholesky(n, factor, info)
      if (info == 0) exit
      added = max(10 * added, 100 * epsilon(added))
    end do
    do i = 2, n
      factor(:i - 1, i) = 0
    end do
  end subroutine factor_group

  !> Multiplies each row by L'^-1 from the right.
  subroutine divide_by_factor(factor, rows)
    !> L, lower triangle
    real(rk), intent(in) :: factor(:, :)
    !> shape (n_rows, n)
    real(rk), intent(inout) :: rows(:, :)
    integer :: i, k

    do i = 1, size(factor, 1)
      do k = 1, i - 1
        rows(:, i) = rows(:, i) - factor(i, k) * rows(:, k)
      end do
      rows(:, i) = rows(:, i) / factor(i, i)
    end do
  end subroutine divide_by_factor

  !> Measures the largest error of the last group in the norm of K, relative to the displacement that the same forces of the group
  !> cause. With the errors E of the columns it is the largest singular value of L^-1 E'K E L'^-1, and its root. Collective.
  subroutine measure_group(system, exact, factor, field, error, ierr)
    type(contact_system_t), intent(in) :: system
    !> columns of H, rows of this rank
    real(rk), intent(in) :: exact(:, :)
    !> L
    real(rk), intent(in) :: factor(:, :)
    type(contact_field_t), intent(in) :: field
    !> [-]
    real(rk), intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: errors(:, :), products(:, :), square(:, :)
    integer :: n

    n = size(field%responses%column_order)
    errors = field%responses%columns_between(n - size(exact, 2) + 1, n)
    errors = exact - errors(system%map%local_dofs, :)
    allocate (products, mold=errors)
    PetscCall(multiply_block(system%stiffness, errors, products, ierr))
    square = transposed_product(errors, products)
    PetscCall(sum_over_ranks(system%comm, square, ierr))
    call divide_by_factor(factor, square)
    square = transpose(square)
    call divide_by_factor(factor, square)
    error = sqrt(maxval(singular_values(square)))
  end subroutine measure_group

  !> [-] Returns the largest error of the displacement of all states, by the field's own bound, relative to their sizes. Local.
  real(rk) function largest_error(states, reduced) result(error)
    type(states_t), intent(in) :: states
    type(reduced_condensed_t), intent(in) :: reduced
    integer :: i

    error = maxval([0.0_rk, [(reduced%field%error_of(reduced%compliance, states%unknowns(:, i), states%energies(i)) / &
      states%sizes(i), i=1, size(states%sizes))]])
  end function largest_error

  !> Gives every rank the compressed responses of the first rank, because groups of ranks compress on their own and may differ by
  !> rounding. Collective on all ranks.
  subroutine agree(field, ierr)
    type(contact_field_t), intent(inout) :: field
    PetscErrorCode, intent(out) :: ierr
    integer, allocatable :: blocks(:)
    real(rk), allocatable :: errors(:, :)

    blocks = [field%responses%blocks]
    PetscCall(broadcast_integers(blocks, PETSC_COMM_WORLD, ierr))
    field%responses%blocks = reshape(blocks, [block_entries, size(blocks) / block_entries])
    PetscCall(broadcast_singles(field%responses%values, PETSC_COMM_WORLD, ierr))
    errors = reshape(field%group_errors, [size(field%group_errors), 1])
    PetscCall(broadcast_columns(errors, PETSC_COMM_WORLD, ierr))
    field%group_errors = errors(:, 1)
  end subroutine agree
end module sig_contact_field_training
