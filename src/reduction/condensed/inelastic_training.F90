! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Makes a reduced model of a problem whose materials flow (sig_inelastic_model) from full-order solutions of histories.
!>
!> The displacement that inelastic strains cause is u_in = u - G theta + H z. Its main directions in the norm of the stiffness are
!> the modes. With them the laws are run through the histories once more at all points, and a few points are chosen, with weights
!> that make their sums equal to those over all points.
module sig_inelastic_training
  use sig_answer, only: answer_t
  use sig_body_compliance, only: body_compliance_t
  use sig_compliance, only: compliance_point_t
  use sig_condensed, only: condensed_t
  use sig_condensed_plan, only: most_modes, most_stresses, number_size, small_size
  use sig_condensed_model, only: condensed_model_t
  use sig_condensed_training, only: train_condensed
  use sig_contact_responses, only: close_rows, columns_at_once, measure_work
  use sig_elasticity, only: n_stresses
  use sig_errors, only: error_t
  use sig_flow_points, only: flow_law_t, flow_points_t, flow_room_t
  use sig_flow_properties, only: compiled_properties_t
  use sig_flow_strains, only: strain_matrices
  use sig_flowing_cells, only: dofs_of_flowing_bodies
  use sig_full_order, only: full_order_t, team_t
  use sig_imposed_strain, only: strain_field_t
  use sig_inelastic_model, only: inelastic_model_t
  use sig_interpolated_training, only: train_interpolated
  use sig_kinds, only: rk
  use sig_linear_algebra, only: add_product, lu_t, multiply, transposed_product, unit_vector
  use sig_log, only: log_info
  use sig_mesh, only: mesh_t, nodes_of_cell
  use sig_cell_stiffness, only: cell_dofs
  use sig_petsc_support, only: broadcast_columns, multiply_block, sum_over_ranks
  use sig_point_choice, only: choose_points, share_missed
  use sig_point_values, only: count_points
  use sig_problem, only: problem_t
  use sig_random_numbers, only: random_t
  use sig_reasons, only: reason_converged
  use sig_reduced, only: model_sizes_t, neighbors_t, reduced_t, room_t
  use sig_reduced_kinds, only: bodies_of
  use sig_response_compression, only: group_contacts
  use sig_singular_values, only: svd
  use sig_strain_compression, only: compress_strains
  use sig_term_values, only: evaluate_points
  use sig_text, only: counted, short_number, string_t, to_text
  use sig_training_set, only: training_set_t
  use petsc
  implicit none(type, external)
  private
  public :: add_strains, train_inelastic

  !> modes leave at most this share of reduction.inelastic_tolerance of the displacements by inelastic strains: forces are the
  !> reactions of a stiff system, and multiply their errors. There are at most most_modes (sig_condensed_plan)
  real(rk), parameter :: mode_share = 1.0e-2_rk
  !> [-] displacements by inelastic strains are rounding if they are at most this share of all displacements, in the norm of the
  !> stiffness
  real(rk), parameter :: least_share = 1.0e-8_rk
  !> [-] tolerances with which points are chosen (sig_point_choice), one after the other; 0 = all points
  real(rk), parameter :: tolerances(4) = [1.0e-3_rk, 1.0e-4_rk, 1.0e-5_rk, 0.0_rk]
  !> [-] tolerance of the points that correct, and what they may miss of all sums over the points: sig_point_choice fits only some
  !> random sums of them where they are many
  real(rk), parameter :: check_tolerance = 1.0e-5_rk, most_missed = 1.0e-3_rk
  !> the points that correct are chosen by so many closings of contacts at most
  integer, parameter :: most_closings = 256
  !> [-] errors in training (measure_error) with which no further points are chosen, and for which not all points are taken; and by
  !> how much one error is much above another
  real(rk), parameter :: enough = 2.0e-3_rk, tolerable = 1.0e-2_rk, much_above = 1.5_rk
  !> [-] main directions of the stresses of inelastic strains that count
  real(rk), parameter :: stress_tolerance = 1.0e-5_rk

  !> The states of the histories.
  type :: states_t
    !> values of the terms, shape (n_terms, n_states), and those of imposed strains
    real(rk), allocatable :: theta(:, :)
    real(rk), allocatable :: strain_theta(:, :)
    !> [force] unknowns of the contact, and its forces, which differ at anchors (sig_answer); shape (n_rows, n_states)
    real(rk), allocatable :: unknowns(:, :)
    real(rk), allocatable :: forces(:, :)
    !> [sqrt(force*length)] shape (n_modes, n_states)
    real(rk), allocatable :: amplitudes(:, :)
    !> numbers of the states, shape (n_numbers, n_states), and [time] since the state before in the history
    real(rk), allocatable :: numbers(:, :)
    real(rk), allocatable :: dt(:)
    !> whether a history begins
    logical, allocatable :: is_first(:)
  end type states_t

contains

  !> Trains the model. Collective on all ranks, with the same result on each. Errors: those of train_contact.
  !>
  !> Where the stiffness depends on the parameters, that of the bodies that flow does not, and bodies are coupled by contact alone:
  !> modes, and strains at the points of these bodies, are the same for all elastic constants of the other bodies. They are computed
  !> with those in the middle of the box.
  subroutine train_inelastic(full_order, snapshots, part, error, ierr)
    type(full_order_t), intent(inout) :: full_order
    !> full-order solutions with displacements; those of a history follow each other; gets openings
    type(training_set_t), intent(inout) :: snapshots
    !> not allocated where the stiffness could not be factored
    class(reduced_t), allocatable, intent(out) :: part
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(inelastic_model_t), allocatable :: model
    type(team_t), pointer :: team
    type(condensed_t), pointer :: condensed
    type(states_t) :: states
    real(rk), allocatable :: local(:, :), shared(:, :)

    PetscCall(full_order%ready_team(team, ierr))
    PetscCall(team%solver%take_middle(full_order%problem, ierr))
    PetscCall(team%solver%condense(condensed, ierr))
    if (condensed%reason /= reason_converged) return
    allocate (model)
    associate (problem => full_order%problem, system => team%solver%system)
      call collect_states(problem, snapshots, states)
      PetscCall(find_modes(problem, team, condensed, snapshots, states, local, ierr))
      PetscCall(system%share_columns(local, size(local, 2), model%modes, ierr))
      PetscCall(broadcast_columns(model%modes, PETSC_COMM_WORLD, ierr))
      PetscCall(broadcast_columns(states%amplitudes, PETSC_COMM_WORLD, ierr))
      PetscCall(broadcast_columns(states%unknowns, PETSC_COMM_WORLD, ierr))
      PetscCall(close_rows(system, local, shared, ierr))
      PetscCall(broadcast_columns(shared, PETSC_COMM_WORLD, ierr))
      model%mode_openings = -shared
      model%mode_openings(condensed%anchors%rows, :) = 0
      call take_materials(problem, model)
      call create_points(problem, model%all)
      call add_strains(problem, model%modes, model%all, model%all%of_modes)
      PetscCall(system%share_columns(condensed%free_response, size(states%theta, 1), shared, ierr))
      PetscCall(broadcast_columns(shared, PETSC_COMM_WORLD, ierr))
      call add_strains(problem, shared, model%all, model%all%of_terms)
      PetscCall(add_contact_strains(problem, team, condensed, model%all, ierr))
      model%largest_amplitude = sqrt(maxval(sum(states%amplitudes**2, dim=1)))
      PetscCall(train_contact(full_order, snapshots, model%contact, error, ierr))
      if (allocated(error)) return
      call reduce_points(problem, states, model)
      ! products with full matrices are faster as long as these are small
      if (.not. (model%checks_all .and. number_size * size(model%all%of_contact) <= small_size)) &
        call compress_contact(problem, condensed%anchors%rows, model)
    end associate
    call move_alloc(model, part)
  end subroutine train_inelastic

  !> Trains the contact of elastic bodies. Where the stiffness depends on the parameters, that of the team changes. Collective on
  !> all ranks, with the same result on each. Errors: those of train_condensed or train_interpolated.
  subroutine train_contact(full_order, snapshots, model, error, ierr)
    type(full_order_t), intent(inout) :: full_order
    !> with openings
    type(training_set_t), intent(in) :: snapshots
    type(condensed_model_t), target, intent(inout) :: model
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    class(reduced_t), allocatable :: contact
    type(body_compliance_t), pointer :: bodies

    if (full_order%problem%has_fixed_stiffness) then
      PetscCall(train_condensed(full_order, snapshots, contact, error, ierr))
    else
      PetscCall(train_interpolated(full_order, snapshots, .false., contact, error, ierr))
    end if
    if (allocated(error)) return
    select type (contact)
    type is (condensed_model_t)
      model = contact
    end select
    bodies => bodies_of(model)
    ! contact closes and opens with the inelastic strains, too, so that each solve starts anew
    if (associated(bodies)) bodies%start_sets = bodies%start_sets(:, :0)
  end subroutine train_contact

  !> Compresses the strains of contact forces at all points.
  subroutine compress_contact(problem, anchors, model)
    type(problem_t), intent(in) :: problem
    !> contact rows
    integer, intent(in) :: anchors(:)
    type(inelastic_model_t), intent(inout) :: model
    integer, allocatable :: cells(:), ends(:), order(:)
    real(rk) :: places(problem%mesh%n_dim, model%all%n_points())
    integer :: i, n, n_points

    cells = flowing_cells(problem)
    n = 0
    do i = 1, size(cells)
      n_points = count_points(problem%mesh, problem%body, [cells(i)])
      associate (corners => problem%mesh%coordinates(:, nodes_of_cell(problem%mesh, cells(i))))
        places(:, n + 1:n + n_points) = spread(sum(corners, dim=2) / size(corners, 2), 2, n_points)
      end associate
      n = n + n_points
    end do
    call group_contacts(problem, anchors, order, ends)
    call compress_strains(places, model%hooke, order, ends, anchors, model%all)
  end subroutine compress_contact

  !> Takes parameters, terms and steps of time of the snapshots.
  subroutine collect_states(problem, snapshots, states)
    type(problem_t), intent(in) :: problem
    type(training_set_t), intent(in) :: snapshots
    type(states_t), intent(out) :: states
    integer :: i, i_bad_point, i_bad_source, i_time

    states%numbers = snapshots%parameters
    call evaluate_points(problem%terms, states%numbers, states%theta, i_bad_point, i_bad_source)
    call evaluate_points(problem%strains%terms, states%numbers, states%strain_theta, i_bad_point, i_bad_source)
    states%forces = snapshots%forces()
    states%unknowns = states%forces
    associate (n => size(states%numbers, 2))
      i_time = size(states%numbers, 1) - problem%deck%history%states%n_values() + 1
      allocate (states%dt(n), states%is_first(n))
      do i = 1, n
        states%is_first(i) = i == 1
        if (i > 1) states%is_first(i) = .not. states%numbers(i_time, i) > states%numbers(i_time, i - 1) .or. &
          any(abs(states%numbers(:i_time - 1, i) - states%numbers(:i_time - 1, i - 1)) > 0)
        states%dt(i) = states%numbers(i_time, i)
        if (.not. states%is_first(i)) states%dt(i) = states%dt(i) - states%numbers(i_time, i - 1)
      end do
    end associate
  end subroutine collect_states

  !> Finds the modes and the amplitudes of the states, the openings of the anchors among the unknowns, and the openings that
  !> inelastic strains cause. Collective on all ranks.
  subroutine find_modes(problem, team, condensed, snapshots, states, modes, ierr)
    type(problem_t), intent(in) :: problem
    type(team_t), intent(inout) :: team
    type(condensed_t), intent(inout) :: condensed
    !> gets openings
    type(training_set_t), intent(inout) :: snapshots
    type(states_t), intent(inout) :: states
    !> [length/sqrt(force*length)] rows of this rank, shape (n_local_dofs, n_modes)
    real(rk), allocatable, intent(out) :: modes(:, :)
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: columns(:, :), energies(:, :), u(:, :), values(:), vt(:, :)
    real(rk) :: energy
    integer :: i, n_modes

    PetscCall(find_inelastic(problem, team, condensed, snapshots, states, columns, energy, ierr))
    PetscCall(close_rows(team%solver%system, -columns, snapshots%openings, ierr))
    snapshots%openings(condensed%anchors%rows, :) = 0
    PetscCall(broadcast_columns(snapshots%openings, PETSC_COMM_WORLD, ierr))
    PetscCall(measure_work(team%solver%system, columns, energies, ierr))
    PetscCall(broadcast_columns(energies, PETSC_COMM_WORLD, ierr))
    energies = (energies + transpose(energies)) / 2
    call svd(energies, u, values, vt)
    n_modes = 0
    do while (n_modes < min(most_modes, size(values)))
      if (sum(values(n_modes + 1:)) <= (mode_share * problem%deck%reduction%inelastic_tolerance)**2 * sum(values)) exit
      if (values(n_modes + 1) <= max(epsilon(values) * 100 * values(1), least_share**2 * energy)) exit
      n_modes = n_modes + 1
    end do
    allocate (modes(size(columns, 1), n_modes), source=0.0_rk)
    allocate (states%amplitudes(n_modes, size(values)))
    do i = 1, n_modes
      call multiply(1 / sqrt(values(i)), columns, u(:, i), 0.0_rk, modes(:, i))
      states%amplitudes(i, :) = sqrt(values(i)) * u(:, i)
    end do
  end subroutine find_modes

  !> Computes u - G theta + H z of all states in the bodies that flow, with closed anchors. In the other bodies it is zero, but for
  !> rigid motions of those that hang on anchors. Collective on the ranks of the team.
  subroutine find_inelastic(problem, team, condensed, snapshots, states, columns, energy, ierr)
    type(problem_t), intent(in) :: problem
    type(team_t), intent(inout) :: team
    type(condensed_t), intent(inout) :: condensed
    type(training_set_t), intent(in) :: snapshots
    type(states_t), intent(inout) :: states
    !> [length] rows of this rank, shape (n_local_dofs, n_states)
    real(rk), allocatable, intent(out) :: columns(:, :)
    !> [force*length] u'K u of all states together
    real(rk), intent(out) :: energy
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: closing(:, :), response(:, :)
    real(rk) :: energies(1, 1)
    real(rk) :: whole(snapshots%n_dofs)
    logical, allocatable :: flows(:)
    integer :: first, i, last, n

    ierr = 0
    energies = 0
    n = snapshots%n_snapshots()
    associate (system => team%solver%system, anchors => condensed%anchors%rows, n_free => size(condensed%free_response, 2))
      allocate (columns(system%map%n_local_dofs, n))
      do i = 1, n
        whole = 0
        whole(snapshots%first_dof:snapshots%first_dof + snapshots%n_own - 1) = snapshots%displacement(i)%values
        PetscCall(sum_over_ranks(PETSC_COMM_WORLD, whole, ierr))
        columns(:, i) = whole(system%map%local_dofs)
      end do
      PetscCall(close_rows(system, columns, closing, ierr))
      do i = 1, size(anchors)
        states%unknowns(anchors(i), :) = (matmul(problem%force_rows%gap(anchors(i), :), states%theta) - closing(anchors(i), :)) / &
          condensed%scale
      end do
      do first = 1, n, columns_at_once
        last = min(first + columns_at_once - 1, n)
        allocate (response(size(columns, 1), last - first + 1))
        PetscCall(multiply_block(system%stiffness, columns(:, first:last), response, ierr))
        energies = energies + sum(columns(:, first:last) * response)
        PetscCall(condensed%respond(system, states%unknowns(:, first:last), response, ierr))
        columns(:, first:last) = columns(:, first:last) + response
        call add_product(-1.0_rk, condensed%free_response, states%theta(:n_free, first:last), columns(:, first:last))
        deallocate (response)
      end do
      flows = dofs_of_flowing_bodies(problem%mesh, problem%body, problem%motions%body_of_node)
      flows = flows(system%map%local_dofs)
      do i = 1, n
        where (.not. flows) columns(:, i) = 0
      end do
      PetscCall(condensed%hang_bodies(system, columns, ierr))
      PetscCall(sum_over_ranks(system%comm, energies, ierr))
    end associate
    PetscCall(broadcast_columns(energies, PETSC_COMM_WORLD, ierr))
    energy = energies(1, 1)
  end subroutine find_inelastic

  !> Takes the laws, properties and terms of imposed strains.
  subroutine take_materials(problem, model)
    type(problem_t), intent(in) :: problem
    type(inelastic_model_t), intent(inout) :: model
    integer, allocatable :: flowing(:)
    integer :: i

    flowing = flowing_materials(problem)
    allocate (model%material_names(size(flowing)), model%law_names(size(flowing)), model%curve_starts(size(flowing) + 1), &
      model%curve_strains(0))
    allocate (model%hooke(n_stresses, n_stresses * size(flowing)))
    model%curve_starts = 0
    do i = 1, size(flowing)
      associate (law => problem%flow%laws(flowing(i))%law)
        model%material_names(i)%text = problem%deck%materials(flowing(i))%name
        model%law_names(i)%text = trim(law%name)
        model%curve_strains = [model%curve_strains, law%curve_strains]
      end associate
      model%curve_starts(i + 1) = size(model%curve_strains)
      model%hooke(:, n_stresses * (i - 1) + 1:n_stresses * i) = problem%body%stress_matrix(:, :, flowing(i))
    end do
    model%properties = problem%flow%properties
    ! elastic materials have none
    model%properties%starts = [0, problem%flow%properties%starts(flowing + 1)]
    model%strain_terms = problem%strains%terms
  end subroutine take_materials

  !> Returns the materials of the deck that flow, 1-based.
  pure function flowing_materials(problem) result(materials)
    type(problem_t), intent(in) :: problem
    integer, allocatable :: materials(:)
    integer :: i

    materials = pack([(i, i=1, size(problem%flow%laws))], [(allocated(problem%flow%laws(i)%law), i=1, size(problem%flow%laws))])
  end function flowing_materials

  !> Makes all points of the cells that flow, with their volumes, materials, imposed strains and temperatures.
  subroutine create_points(problem, points)
    type(problem_t), intent(in) :: problem
    type(flow_points_t), intent(inout) :: points
    type(strain_field_t) :: field
    real(rk), allocatable :: matrices(:, :, :), volumes(:)
    integer, allocatable :: cells(:), flowing(:)
    integer :: i, i_term, k, n, n_terms

    flowing = flowing_materials(problem)
    associate (mesh => problem%mesh, body => problem%body, mechanics => problem%body%mechanics, strains => problem%strains)
      cells = flowing_cells(problem)
      n = count_points(mesh, body, cells)
      n_terms = strains%terms%n_terms()
      points%components = mechanics%strains(:mechanics%n_strains)
      allocate (points%materials(n), points%weights(n))
      allocate (points%imposed(n_stresses * n, n_terms), source=0.0_rk)
      n = 0
      do i = 1, size(cells)
        call strain_matrices(mesh, body, cells(i), matrices, volumes)
        points%materials(n + 1:n + size(volumes)) = findloc(flowing, body%material_of_cell(cells(i)), dim=1)
        points%weights(n + 1:n + size(volumes)) = volumes
        n = n + size(volumes)
      end do
      do i_term = 1, n_terms
        if (.not. strains%are_there()) exit
        call strains%evaluate(mesh, body, unit_vector(n_terms, i_term), field)
        n = 0
        do i = 1, size(cells)
          do k = 1, count_points(mesh, body, [cells(i)])
            points%imposed(n_stresses * n + 1:n_stresses * (n + 1), i_term) = field%at_point(cells(i), k)
            n = n + 1
          end do
        end do
      end do
      points%temperatures = problem%flow%temperatures
      call points%contact_blocks%complete()
    end associate
  end subroutine create_points

  pure function flowing_cells(problem) result(cells)
    type(problem_t), intent(in) :: problem
    integer, allocatable :: cells(:)
    integer :: i

    cells = pack([(i, i=1, problem%mesh%n_cells)], [(problem%body%flows_in(i), i=1, problem%mesh%n_cells)])
  end function flowing_cells

  !> Computes the strains at all points of some displacements.
  subroutine add_strains(problem, displacements, points, strains)
    type(problem_t), intent(in) :: problem
    !> [length] natural, shape (n_dofs, n_columns)
    real(rk), intent(in) :: displacements(:, :)
    type(flow_points_t), intent(in) :: points
    !> shape (n_strains * n_points, n_columns)
    real(rk), allocatable, intent(out) :: strains(:, :)
    real(rk), allocatable :: matrices(:, :, :), volumes(:), cell(:, :)
    integer, allocatable :: cells(:)
    integer :: i, k, n

    associate (n_strains => size(points%components))
      allocate (strains(n_strains * size(points%weights), size(displacements, 2)))
      cells = flowing_cells(problem)
      n = 0
      do i = 1, size(cells)
        call strain_matrices(problem%mesh, problem%body, cells(i), matrices, volumes)
        cell = displacements(cell_dofs(problem%mesh, cells(i)), :)
        do k = 1, size(volumes)
          strains(n + 1:n + n_strains, :) = matmul(matrices(points%components, :, k), cell)
          n = n + n_strains
        end do
      end do
    end associate
  end subroutine add_strains

  !> Computes the strains at all points of minus the columns of H. Collective on the ranks of the team.
  subroutine add_contact_strains(problem, team, condensed, points, ierr)
    type(problem_t), intent(in) :: problem
    type(team_t), intent(inout) :: team
    type(condensed_t), intent(inout) :: condensed
    type(flow_points_t), intent(inout) :: points
    PetscErrorCode, intent(out) :: ierr
    real(rk), allocatable :: columns(:, :), shared(:, :), strains(:, :)
    integer :: first, i, last

    ierr = 0
    associate (system => team%solver%system, n_rows => team%solver%system%rows%n_rows)
      allocate (points%of_contact(size(points%components) * size(points%weights), n_rows))
      do first = 1, n_rows, columns_at_once
        last = min(first + columns_at_once - 1, n_rows)
        allocate (columns(system%map%n_local_dofs, last - first + 1))
        PetscCall(condensed%respond_to_rows(system, [(i, i=first, last)], columns, ierr))
        PetscCall(system%share_columns(columns, size(columns, 2), shared, ierr))
        call add_strains(problem, shared, points, strains)
        points%of_contact(:, first:last) = -strains
        deallocate (columns)
      end do
      ! bodies that an anchor moves are not strained
      points%of_contact(:, condensed%anchors%rows) = 0
      PetscCall(broadcast_columns(points%of_contact, PETSC_COMM_WORLD, ierr))
    end associate
  end subroutine add_contact_strains

  !> Chooses points (sig_point_choice), more and more of them, and runs the model through the histories with them, until the error
  !> is small; at last with all points. Takes the fewest points whose error is not much above the smallest.
  subroutine reduce_points(problem, states, model)
    type(problem_t), intent(in) :: problem
    type(states_t), intent(in) :: states
    type(inelastic_model_t), intent(inout) :: model
    real(rk), allocatable :: shares(:, :), stresses(:, :)
    real(rk) :: errors(size(tolerances))
    integer :: k

    call find_stresses(states, model, stresses)
    allocate (shares(model%all%n_points(), size(tolerances)), source=1.0_rk)
    call take_points(model%all, [real(rk) ::], model%check)
    call take_points(model%all, [real(rk) ::], model%chosen)
    call make_ready(problem, states, model)
    call choose_check_points(states, stresses, model)
    errors = huge(errors)
    do k = 1, size(tolerances)
      if (tolerances(k) <= 0 .and. minval(errors) <= tolerable) exit
      if (tolerances(k) > 0) call choose_points(model%all, model%hooke, stresses, tolerances(k), shares(:, k))
      call take_points(model%all, shares(:, k), model%chosen)
      call measure_error(states, model, errors(k))
      if (errors(k) <= enough) exit
    end do
    k = size(tolerances)
    if (minval(errors) < huge(errors)) k = findloc(errors / much_above <= minval(errors), .true., dim=1)
    call take_points(model%all, shares(:, k), model%chosen)
    call report(model, errors(k))
  end subroutine reduce_points

  !> Chooses the points that correct. Their sums are the openings that inelastic strains cause, and answers are sensitive to these:
  !> so the sums count by the forces that would close them, with the elastic constants of the state that presses most. Requires:
  !> make_ready.
  subroutine choose_check_points(states, stresses, model)
    type(states_t), intent(in) :: states
    real(rk), intent(in) :: stresses(:, :)
    type(inelastic_model_t), target, intent(inout) :: model
    type(compliance_point_t), target :: point
    type(lu_t) :: lu
    real(rk), pointer, contiguous :: compliance(:, :)
    real(rk), allocatable :: of_closing(:, :), stiff(:, :)
    real(rk) :: shares(model%all%n_points())
    integer :: i
    logical :: is_valid

    call model%contact%compliance%create_point(point)
    i = maxloc(norm2(states%forces, dim=1), dim=1)
    call model%contact%compliance%evaluate(states%theta(:, i), point, is_valid)
    compliance => model%contact%compliance%matrix(point)
    stiff = compliance
    associate (anchors => model%contact%compliance%anchors)
      stiff(anchors, :) = 0
      stiff(:, anchors) = 0
      do i = 1, size(anchors)
        stiff(anchors(i), anchors(i)) = 1
      end do
    end associate
    call lu%factor(stiff)
    shares = 1
    if (.not. lu%is_singular) then
      call strain_by_closing(model%all%of_contact, lu, of_closing)
      call choose_points(model%all, model%hooke, stresses, check_tolerance, shares, of_closing)
      if (share_missed(of_closing, stresses, shares) > most_missed) shares = 1
    end if
    ! more than half of the points are not worth their error; where nothing flows in training, all must look whether something does
    if (2 * count(shares > 0) > size(shares) .or. .not. any(shares > 0)) shares = 1
    model%checks_all = all(shares > 0)
    if (.not. model%checks_all) call take_points(model%all, shares, model%check)
  end subroutine choose_check_points

  !> Computes the strains of the contact forces that close each contact by a unit. With more contacts than most_closings, these are
  !> so many sums of them with random signs, which keep sizes on average: all would take several times the memory of of_contact.
  subroutine strain_by_closing(of_contact, lu, of_closing)
    !> strains of unit contact forces, shape (n_strains * n_points, n_rows)
    real(rk), contiguous, intent(in) :: of_contact(:, :)
    !> factors of W
    type(lu_t), intent(in) :: lu
    real(rk), allocatable, intent(out) :: of_closing(:, :)
    real(rk), allocatable :: forces(:, :)
    type(random_t) :: random
    real(rk) :: draw
    integer :: i, k, n_rows

    n_rows = size(of_contact, 2)
    allocate (forces(n_rows, min(n_rows, most_closings)), source=0.0_rk)
    do k = 1, size(forces, 2)
      forces(k, k) = 1
      if (n_rows <= most_closings) cycle
      do i = 1, n_rows
        call random%fraction(draw)
        forces(i, k) = sign(1 / sqrt(real(most_closings, rk)), draw - 0.5_rk)
      end do
    end do
    forces = lu%solve(forces)
    allocate (of_closing(size(of_contact, 1), size(forces, 2)), source=0.0_rk)
    call add_product(1.0_rk, of_contact, forces, of_closing)
  end subroutine strain_by_closing

  !> Says how many modes and points there are, and the error that they make.
  subroutine report(model, error)
    type(inelastic_model_t), intent(in) :: model
    !> result of measure_error
    real(rk), intent(in) :: error
    character(:), allocatable :: text
    integer :: n_check

    text = 'some states of the training have no answer'
    if (error < huge(error)) text = 'forces and amplitudes in training miss by at most ' // short_number(error)
    n_check = merge(model%all%n_points(), model%check%n_points(), model%checks_all)
    call log_info('inelastic strains: ' // counted(size(model%modes, 2), 'mode') // ', ' // to_text(model%chosen%n_points()) // &
      ' of ' // counted(model%all%n_points(), 'integration point') // ', ' // to_text(n_check) // ' for the correction; ' // text)
  end subroutine report

  !> Makes the model able to answer.
  subroutine make_ready(problem, states, model)
    type(problem_t), intent(in) :: problem
    type(states_t), intent(in) :: states
    type(inelastic_model_t), intent(inout) :: model
    character(:), allocatable :: message

    call model%complete(model_sizes_t(n_dofs=size(model%modes, 1), n_multipliers=size(states%unknowns, 1), &
      n_terms=size(states%theta, 1), n_points=size(states%dt), laws=problem%laws))
    call model%prepare(message)
  end subroutine make_ready

  !> Runs the model through the histories. error [-] is the largest one of the contact forces or of the amplitudes of the modes,
  !> over the largest size in the same history, but at least over a thousandth of the largest in all; huge where a state has no
  !> answer. Requires: make_ready.
  subroutine measure_error(states, model, error)
    type(states_t), intent(in) :: states
    type(inelastic_model_t), intent(inout) :: model
    real(rk), intent(out) :: error
    class(room_t), allocatable :: room
    type(answer_t) :: answer
    real(rk), dimension(2, size(states%dt)) :: errors, sizes
    integer :: first, i, last, n

    n = size(states%dt)
    associate (n_rows => size(states%forces, 1))
      call answer%start(1, size(states%theta, 1), model%n_modes(), n_rows, n_rows)
    end associate
    call model%create_room(room)
    room%has_points = .false.
    error = huge(error)
    do i = 1, n
      if (states%is_first(i)) call model%forget(room)
      call model%begin_step(room, states%numbers(:, i), states%dt(i))
      call model%solve(states%theta(:, i), neighbors_t(), room, answer)
      if (answer%reason <= 0) return
      errors(:, i) = [norm2(answer%multipliers - states%forces(:, i)), norm2(answer%coordinates - states%amplitudes(:, i))]
      sizes(:, i) = [norm2(states%forces(:, i)), norm2(states%amplitudes(:, i))]
    end do
    error = 0
    last = 0
    do while (last < n)
      first = last + 1
      last = first
      do while (last < n)
        if (states%is_first(last + 1)) exit
        last = last + 1
      end do
      do i = 1, 2
        associate (largest => max(maxval(sizes(i, first:last)), maxval(sizes(i, :)) / 1000, tiny(error)))
          error = max(error, maxval(errors(i, first:last)) / largest)
        end associate
      end do
    end do
  end subroutine measure_error

  !> Runs the laws through the histories, and finds the main directions of the stresses that inelastic strains take away, times the
  !> volumes of the points, each with its size over all states.
  subroutine find_stresses(states, model, stresses)
    type(states_t), intent(in) :: states
    type(inelastic_model_t), intent(inout) :: model
    !> [force, force/length] shape (n_strains * n_points, n_directions)
    real(rk), allocatable, intent(out) :: stresses(:, :)
    type(flow_law_t), allocatable :: laws(:)
    type(flow_room_t) :: room
    type(compiled_properties_t) :: properties
    character(:), allocatable :: message
    real(rk), allocatable :: all(:, :), products(:, :), u(:, :), values(:), vt(:, :)
    integer :: i, n
    logical :: is_solved

    call model%make_laws(laws, message)
    call model%all%create_room(laws, room)
    call model%properties%compile(properties, message)
    associate (points => model%all)
      allocate (all(size(room%taken), size(states%dt)))
      do i = 1, size(states%dt)
        if (states%is_first(i)) room%old_states = 0
        call properties%evaluate(states%numbers(:, i), points%materials, points%temperatures, room%properties)
        call points%update(laws, states%theta(:, i), states%strain_theta(:, i), states%unknowns(:, i), states%amplitudes(:, i), &
          states%dt(i), room, is_solved)
        all(:, i) = room%taken
        room%old_states = room%states
      end do
    end associate
    products = transposed_product(all, all)
    call svd(products, u, values, vt)
    n = count(values > stress_tolerance**2 * values(1))
    ! where nothing flows, stresses are rounding
    n = min(n, merge(most_stresses, 0, model%n_modes() > 0))
    allocate (stresses(size(all, 1), n), source=0.0_rk)
    call add_product(1.0_rk, all, u(:, :n), stresses)
  end subroutine find_stresses

  !> Copies the points whose shares are positive, with weights that are multiplied by them.
  subroutine take_points(all, shares, points)
    type(flow_points_t), intent(in) :: all
    !> shape (n_points), or empty for no point
    real(rk), intent(in) :: shares(:)
    type(flow_points_t), intent(out) :: points
    integer, allocatable :: chosen(:), rows(:), six(:)
    integer :: i, k

    chosen = pack([(i, i=1, size(shares))], shares > 0)
    associate (n => size(all%components))
      rows = [((n * (chosen(i) - 1) + k, k=1, n), i=1, size(chosen))]
      six = [((n_stresses * (chosen(i) - 1) + k, k=1, n_stresses), i=1, size(chosen))]
    end associate
    points%components = all%components
    points%materials = all%materials(chosen)
    points%weights = shares(chosen) * all%weights(chosen)
    points%of_terms = all%of_terms(rows, :)
    points%of_contact = all%of_contact(rows, :)
    points%of_modes = all%of_modes(rows, :)
    points%imposed = all%imposed(six, :)
    points%temperatures = all%temperatures(chosen, :)
    call points%contact_blocks%complete()
  end subroutine take_points
end module sig_inelastic_training
