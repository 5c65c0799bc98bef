! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Fields at the deck's output points: full-order, and reduced where there is a model. What ParaView and the figures show.
module sig_field_output
  use sig_clock, only: wall_time
  use sig_contact_rows, only: contact_rows_t
  use sig_contact_state, only: contact_state_t
  use sig_contact_surfaces, only: contact_surfaces_t
  use sig_deck_config, only: deck_config_t
  use sig_elastic_body, only: elastic_body_t
  use sig_error_broadcast, only: broadcast_error
  use sig_errors, only: error_t
  use sig_field_file, only: field_file_t
  use sig_full_order, only: team_t
  use sig_imposed_strain, only: cell_strains, strain_field_t
  use sig_kinds, only: rk
  use sig_model, only: model_t
  use sig_nodal_values, only: nodal_gaps, nodal_pressures
  use sig_rooms, only: rooms_t
  use sig_online_model, only: online_model_t
  use sig_parameter_space, only: format_point
  use sig_problem, only: area_unit, body_at, force_unit, parameter_names, problem_t, stress_unit, strains_at
  use sig_answer, only: answer_t
  use sig_query, only: query_t
  use sig_reconstruction, only: reconstruct_displacement, reconstruct_multipliers
  use sig_solver_options, only: refuse_unused_options
  use sig_state_broadcast, only: broadcast_state
  use sig_stop_request, only: agree_to_stop
  use sig_stress, only: cell_stresses, nodal_stresses, von_mises
  use sig_term_values, only: evaluate_points
  use petsc
  implicit none(type, external)
  private
  public :: write_fields, solved_points_t

  !> Full-order answers, and what they took.
  type :: solved_points_t
    !> shape (n_points)
    type(contact_state_t), allocatable :: states(:)
    !> a signal came before all were solved
    logical :: is_stopped = .false.
    !> [s] wall time of the partition, of the assembly, of all that the solver does once (these too), of writing
    real(rk) :: partition_seconds = 0
    real(rk) :: assembly_seconds = 0
    real(rk) :: setup_seconds = 0
    real(rk) :: output_seconds = 0
  end type solved_points_t

contains

  !> Solves the points and writes fields.h5 and fields.xdmf, contact.h5 and contact.xdmf. Collective on all ranks.
  !>
  !> A signal ends it after the current points, and then nothing is written.
  subroutine write_fields(problem, team, points, folder, solved, error, ierr, model)
    type(problem_t), intent(in) :: problem
    !> ready; shares out the points
    type(team_t), intent(inout) :: team
    !> shape (n_parameters, n_points), checked
    real(rk), intent(in) :: points(:, :)
    character(*), intent(in) :: folder
    type(solved_points_t), intent(out) :: solved
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    type(model_t), intent(in), optional :: model
    real(rk) :: start

    solved%partition_seconds = team%solver%system%partition_seconds
    solved%assembly_seconds = team%solver%system%assembly_seconds
    solved%setup_seconds = team%solver%setup_seconds
    PetscCall(solve_points(problem, team, points, solved, error, ierr))
    if (solved%is_stopped .or. allocated(error)) return
    start = wall_time()
    if (team%groups%world_rank == 0) then
      if (present(model)) then
        call write_file(problem, points, folder, solved%states, error, model)
      else
        call write_file(problem, points, folder, solved%states, error)
      end if
    end if
    PetscCall(broadcast_error(error, PETSC_COMM_WORLD, ierr))
    solved%output_seconds = wall_time() - start
  end subroutine write_fields

  !> As many points at a time as there are groups; all ranks know all states afterwards. Collective on all ranks.
  subroutine solve_points(problem, team, points, solved, error, ierr)
    type(problem_t), intent(in) :: problem
    type(team_t), intent(inout) :: team
    real(rk), intent(in) :: points(:, :)
    type(solved_points_t), intent(inout) :: solved
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    integer :: first, i, last

    ierr = 0
    allocate (solved%states(size(points, 2)))
    do first = 1, size(points, 2), team%groups%n_groups
      last = min(first + team%groups%n_groups - 1, size(points, 2))
      do i = first, last
        if (.not. team%groups%has_point(i)) cycle
        PetscCall(team%solver%solve(problem, points(:, i), solved%states(i), ierr))
      end do
      do i = first, last
        PetscCall(broadcast_state(solved%states(i), team%groups%leader_of(i), PETSC_COMM_WORLD, ierr))
      end do
      PetscCall(agree_to_stop(PETSC_COMM_WORLD, solved%is_stopped, ierr))
      if (first == 1) then
        PetscCall(refuse_unused_options(problem%plan%type, error, ierr))
      end if
      if (solved%is_stopped .or. allocated(error)) return
    end do
  end subroutine solve_points

  !> Local: one rank writes.
  subroutine write_file(problem, points, folder, states, error, model)
    type(problem_t), intent(in) :: problem
    real(rk), intent(in) :: points(:, :)
    character(*), intent(in) :: folder
    type(contact_state_t), intent(in) :: states(:)
    type(error_t), allocatable, intent(out) :: error
    type(model_t), intent(in), optional :: model
    type(online_model_t) :: online
    type(query_t) :: query
    type(field_file_t) :: file
    type(contact_surfaces_t) :: surfaces
    character(:), allocatable :: message
    real(rk), allocatable :: theta(:, :)
    integer :: i, i_bad_point, i_bad_source

    call evaluate_points(problem%terms, points, theta, i_bad_point, i_bad_source)
    call file%create(folder // '/fields.h5', problem%mesh, problem%deck%units%length, parameter_names(problem%deck), error)
    if (.not. allocated(error)) call surfaces%create(problem, folder, error)
    if (allocated(error)) return
    call write_contact(problem, file)
    if (present(model)) then
      online%model = model
      call online%prepare(message)
      if (.not. allocated(message)) call query%create(online, message)
    end if
    do i = 1, size(points, 2)
      call write_point(problem, points(:, i), theta(:, i), states(i), file, surfaces)
      if (present(model) .and. .not. allocated(message)) call write_reduced(problem, points(:, i), online, query, file, &
        surfaces)
    end do
    call query%destroy()
    call file%close(error)
    if (.not. allocated(error)) call surfaces%close(error)
  end subroutine write_file

  !> Which nodes face each other; the same for all points.
  subroutine write_contact(problem, file)
    type(problem_t), intent(in) :: problem
    type(field_file_t), intent(inout) :: file

    call write_side(problem%rows, .false., 'contact/first', file)
    call write_side(problem%rows, .true., 'contact/second', file)
    call file%add_shared_array('contact/areas', problem%rows%areas, area_unit(problem%deck), &
      'area of each contact row: pressure = multiplier / area')
  end subroutine write_contact

  subroutine write_side(rows, is_second, group, file)
    type(contact_rows_t), intent(in) :: rows
    logical, intent(in) :: is_second
    !> from the root
    character(*), intent(in) :: group
    type(field_file_t), intent(inout) :: file
    integer, allocatable :: nodes(:), starts(:)
    real(rk), allocatable :: weights(:)

    call rows%list_side(is_second, starts, nodes, weights)
    call file%add_shared_array(group // '/starts', starts, '-', &
      'nodes of contact row k (from 0) are the entries from starts(k) up to, without, starts(k + 1); none: a rigid obstacle')
    call file%add_shared_array(group // '/nodes', nodes, '-', '1-based, order of the mesh file; the first one of a row on the ' // &
      'first surface carries its multiplier')
    call file%add_shared_array(group // '/weights', weights, '-', &
      'share of the row''s contact force on the node, negative where it pulls')
  end subroutine write_side

  subroutine write_point(problem, point, theta, state, file, surfaces)
    type(problem_t), intent(in) :: problem
    real(rk), intent(in) :: point(:)
    real(rk), intent(in) :: theta(:)
    type(contact_state_t), intent(in) :: state
    type(field_file_t), intent(inout) :: file
    type(contact_surfaces_t), intent(inout) :: surfaces

    associate (deck => problem%deck, n_dim => problem%mesh%n_dim, n_nodes => problem%mesh%n_nodes)
      call file%start_point(format_point(deck%parameters, point), point)
      if (deck%output%has_displacement) call file%add_node_field('displacement', &
        reshape(state%displacement, [n_dim, n_nodes]), deck%units%length, 'displacement, full-order model')
      if (deck%output%has_contact) then
        call write_contact_fields(problem, point, theta, state, file, surfaces)
      end if
      if (deck%output%has_stress) call write_stress_fields(problem, point, state%displacement, file)
    end associate
  end subroutine write_point

  !> In axisymmetry zz is the hoop direction.
  subroutine write_stress_fields(problem, point, displacement, file)
    type(problem_t), intent(in) :: problem
    real(rk), intent(in) :: point(:)
    real(rk), intent(in) :: displacement(:)
    type(field_file_t), intent(inout) :: file
    real(rk), allocatable :: stresses(:, :), smoothed(:, :)
    character(:), allocatable :: unit
    type(elastic_body_t) :: body
    type(strain_field_t) :: imposed

    unit = stress_unit(problem%deck)
    call body_at(problem, point, body)
    call strains_at(problem, point, imposed)
    stresses = cell_stresses(problem%mesh, body, displacement, imposed)
    smoothed = nodal_stresses(problem%mesh, body, displacement, imposed)
    if (problem%strains%are_there()) call file%add_cell_field('imposed_strain', cell_strains(problem%mesh, body, imposed), '-', &
      'mean of what is imposed on the cell by temperature or swelling; stresses come from the rest of the strain')
    call file%add_cell_field('stress', stresses, unit, 'mean stress of the cell, full-order model')
    call file%add_cell_field('von_mises', von_mises(stresses), unit, 'von Mises stress of the mean stress of the cell')
    call file%add_node_field('stress_smoothed', smoothed, unit, &
      'mean stress of the cells around the node, weighted by volume, of one material')
    call file%add_node_field('von_mises_smoothed', von_mises(smoothed), unit, 'von Mises stress of the smoothed stress')
  end subroutine write_stress_fields

  subroutine write_contact_fields(problem, point, theta, state, file, surfaces)
    type(problem_t), intent(in) :: problem
    real(rk), intent(in) :: point(:)
    real(rk), intent(in) :: theta(:)
    type(contact_state_t), intent(in) :: state
    type(field_file_t), intent(inout) :: file
    type(contact_surfaces_t), intent(inout) :: surfaces
    real(rk) :: gap(problem%mesh%n_nodes), force(problem%mesh%n_dim, problem%mesh%n_nodes), opening(problem%rows%n_rows)

    associate (rows => problem%rows, deck => problem%deck)
      ! What the other body does to each node: the opposite of B' lambda, which the stiffness balances.
      force = -reshape(rows%apply_transpose(state%multipliers, size(force)), shape(force))
      opening = matmul(rows%gap, theta) - rows%apply(state%displacement)
      gap = nodal_gaps(rows, opening, size(gap))
      call file%add_node_field('contact_force', force, force_unit(problem%deck), 'contact force on the node, full-order model')
      call file%add_node_field('contact_pressure', nodal_pressures(rows, state%multipliers, size(gap)), stress_unit(deck), &
        'multiplier over area at nodes of the first surfaces, its mean by shares at those of the second')
      call file%add_node_field('gap', gap, deck%units%length, &
        'open distance, the smallest of the rows at the node; no number off the contact surfaces')
      call file%add_array('multipliers_full_order', state%multipliers, force_unit(problem%deck), &
        'contact force of each row, full-order model')
    end associate
    call surfaces%write_point(problem, point, state, opening)
  end subroutine write_contact_fields

  subroutine write_reduced(problem, point, online, query, file, surfaces)
    type(problem_t), intent(in) :: problem
    real(rk), intent(in) :: point(:)
    type(online_model_t), intent(in) :: online
    type(query_t), intent(inout) :: query
    type(field_file_t), intent(inout) :: file
    type(contact_surfaces_t), intent(inout) :: surfaces
    type(answer_t) :: answer
    type(rooms_t) :: rooms
    real(rk), allocatable :: displacement(:)
    real(rk) :: multipliers(online%model%n_multipliers)
    integer :: has_cell(problem%mesh%n_cells), has_row(problem%rows%n_rows)

    call query%evaluate(online, point, answer)
    call reconstruct_displacement(online%model, answer, displacement)
    call reconstruct_multipliers(online, answer, rooms, multipliers)
    has_cell = 0
    has_row = 0
    has_cell(online%model%parts(answer%cluster)%reduced%cells()) = 1
    has_row(online%model%parts(answer%cluster)%reduced%contact_rows()) = 1
    call file%add_cell_field('reduced_domain', has_cell, '-', 'cell of the reduced integration domain that answers')
    call file%add_array('rows_in_reduced_domain', has_row, '-', 'contact row of the reduced integration domain that answers')
    call file%add_node_field('displacement_reduced', reshape(displacement, [problem%mesh%n_dim, problem%mesh%n_nodes]), &
      problem%deck%units%length, 'displacement, reduced model; no number where it has none')
    call file%add_node_field('displacement_reduced_source', displacement_sources(online%model, answer), '-', &
      'where it comes from: 0 there is none, 1 modes, 2 exact')
    call file%add_array('multipliers_reduced', multipliers, force_unit(problem%deck), &
      'contact force of each row, reduced model; outside the reduced domain reconstructed')
    call surfaces%write_reduced(problem, multipliers)
  end subroutine write_reduced

  !> Of each node, one of displacement_*.
  pure function displacement_sources(model, answer) result(sources)
    type(model_t), intent(in) :: model
    type(answer_t), intent(in) :: answer
    real(rk) :: sources(model%n_nodes)
    integer :: i

    associate (part => model%parts(answer%displacement_part)%reduced)
      sources = [(real(part%displacement_source(model%n_dim * i), rk), i=1, model%n_nodes)]
    end associate
  end function displacement_sources
end module sig_field_output
