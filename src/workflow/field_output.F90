! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Fields at the output points (or at --at) for ParaView and the figures: full-order ones, and reduced ones where there is a model.
module sig_field_output
  use, intrinsic :: ieee_arithmetic, only: ieee_is_nan, ieee_quiet_nan, ieee_value
  use sig_answer, only: answer_t
  use sig_clock, only: wall_time
  use sig_contact_state, only: contact_state_t
  use sig_deck_units, only: force_unit
  use sig_error_broadcast, only: broadcast_error
  use sig_errors, only: error_t
  use sig_field_map, only: field_values_t
  use sig_field_mapping, only: create_field_map
  use sig_field_writer, only: field_writer_t
  use sig_file_system, only: write_text_file
  use sig_force_columns, only: force_columns, force_values
  use sig_full_order, only: team_t
  use sig_kinds, only: rk
  use sig_log, only: log_warning
  use sig_model, only: model_t
  use sig_model_header, only: fill_model_header
  use sig_online_model, only: online_model_t
  use sig_problem, only: problem_t
  use sig_query, only: query_t
  use sig_reasons, only: reason_converged, reason_text
  use sig_reconstruction, only: reconstruct_displacement, reconstruct_multipliers
  use sig_rooms, only: rooms_t
  use sig_solver_options, only: refuse_unused_options
  use sig_state_broadcast, only: broadcast_state
  use sig_stop_request, only: agree_to_stop
  use sig_term_values, only: evaluate_points
  use sig_text, only: join
  use sig_text_buffer, only: text_buffer_t
  use sig_training_set, only: training_set_t
  use petsc
  implicit none(type, external)
  private
  public :: write_fields, solve_points, solved_points_t, describe_problem, find_flow_values

  !> The full-order solutions and their times.
  type :: solved_points_t
    !> shape (n_points); after is_stopped only the first ones are set
    type(contact_state_t), allocatable :: states(:)
    !> a signal came; then nothing was written
    logical :: is_stopped = .false.
    !> [s] wall time of the partition, of the assembly, of the whole setup of the solver (with both), and of writing the files
    real(rk) :: partition_seconds = 0
    real(rk) :: assembly_seconds = 0
    real(rk) :: setup_seconds = 0
    real(rk) :: output_seconds = 0
  end type solved_points_t

contains

  !> Solves the full-order problem at the points and writes fields.h5, fields.xdmf, contact.h5 and contact.xdmf (the latter two only
  !> if the deck has contact and wants fields of it), and with a history history.csv. A point that did not converge is left out of
  !> the files; solved%states has the reasons. Collective on all ranks. A signal ends it after the current points, and then nothing
  !> is written.
  !>
  !> Errors: the solver does not use one of its PETSc options; a file cannot be written.
  subroutine write_fields(problem, team, points, folder, solved, error, ierr, model)
    type(problem_t), intent(in) :: problem
    !> ready; shares out the points
    type(team_t), intent(inout) :: team
    !> shape (n_parameters, n_points), checked
    real(rk), intent(in) :: points(:, :)
    !> results folder
    character(*), intent(in) :: folder
    type(solved_points_t), intent(out) :: solved
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    !> reduced model whose answers are written, too; they are left out without a message if the model cannot be prepared for queries
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

  !> Solves the points, one per group of ranks at a time (where states remember, one history), and gives each state to all ranks.
  !> After a signal (solved%is_stopped) or an error the later states are not set. Collective on all ranks. Errors: the solver does
  !> not use one of its PETSc options.
  subroutine solve_points(problem, team, points, solved, error, ierr)
    type(problem_t), intent(in) :: problem
    type(team_t), intent(inout) :: team
    !> shape (n_parameters, n_points), checked
    real(rk), intent(in) :: points(:, :)
    type(solved_points_t), intent(inout) :: solved
    type(error_t), allocatable, intent(out) :: error
    PetscErrorCode, intent(out) :: ierr
    integer :: first, i, last, n_histories, n_times, t

    ierr = 0
    n_times = team%solver%n_times()
    n_histories = size(points, 2) / n_times
    allocate (solved%states(size(points, 2)))
    do first = 1, n_histories, team%groups%n_groups
      last = min(first + team%groups%n_groups - 1, n_histories)
      do i = first, last
        if (.not. team%groups%has_point(i)) cycle
        associate (from => n_times * (i - 1) + 1, to => n_times * i)
          PetscCall(team%solver%solve_history(problem, points(:, from:to), solved%states(from:to), ierr))
        end associate
      end do
      do i = first, last
        do t = n_times * (i - 1) + 1, n_times * i
          PetscCall(broadcast_state(solved%states(t), team%groups%leader_of(i), PETSC_COMM_WORLD, ierr))
        end do
      end do
      PetscCall(agree_to_stop(PETSC_COMM_WORLD, solved%is_stopped, ierr))
      if (first == 1) then
        ! a group without a point has read no options; the first rank's group has one
        if (team%groups%world_rank == 0) then
          PetscCall(refuse_unused_options(problem%plan%type, error, ierr))
        end if
        PetscCall(broadcast_error(error, PETSC_COMM_WORLD, ierr))
      end if
      if (solved%is_stopped .or. allocated(error)) return
    end do
  end subroutine solve_points

  !> Writes the files of the fields at the points that converged, without the reduced model if it cannot be prepared for queries.
  !> Local: one rank writes. Errors: a file cannot be written.
  subroutine write_file(problem, points, folder, states, error, model)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters, n_points), checked
    real(rk), intent(in) :: points(:, :)
    character(*), intent(in) :: folder
    !> full-order solutions, shape (n_points)
    type(contact_state_t), intent(in) :: states(:)
    type(error_t), allocatable, intent(out) :: error
    !> reduced model, as in write_fields
    type(model_t), intent(in), optional :: model
    type(online_model_t) :: online
    type(query_t) :: query
    type(model_t) :: header
    type(field_values_t) :: values
    type(field_writer_t) :: writer
    character(:), allocatable :: message
    integer :: i

    call describe_problem(problem, header, error)
    if (allocated(error)) return
    call writer%create(header, problem%deck%output, folder, error)
    if (allocated(error)) return
    if (present(model)) then
      online%model = model
      call online%prepare(message)
      if (.not. allocated(message)) call query%create(online, message)
    end if
    do i = 1, size(points, 2)
      if (states(i)%reason /= reason_converged) cycle
      call writer%start_point(header, points(:, i))
      call find_flow_values(problem, header, points(:, i), states(i), values)
      call writer%write_values(header, values, .false.)
      if (present(model) .and. .not. allocated(message)) &
        call write_reduced(problem, header, points(:, i), online, query, writer)
    end do
    call query%destroy()
    call writer%close(error)
    if (header%history%is_there() .and. .not. allocated(error)) &
      call write_history_table(header, points, states, folder // '/history.csv', error)
  end subroutine write_file

  !> Writes a table with a row per state: the parameters, the time and its tables, status, and the columns of force_columns. Local.
  !> Errors: the file cannot be written.
  subroutine write_history_table(header, points, states, path, error)
    !> result of describe_problem
    type(model_t), intent(in) :: header
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> shape (n_points)
    type(contact_state_t), intent(in) :: states(:)
    character(*), intent(in) :: path
    type(error_t), allocatable, intent(out) :: error
    type(text_buffer_t) :: buffer
    integer :: i
    real(rk) :: multipliers(header%n_multipliers), slip(header%n_multipliers)
    logical :: is_solved, slips(header%laws%n_contacts)

    call buffer%add(join(header%parameter_names, ',') // ',status,' // force_columns(header) // new_line('a'))
    do i = 1, size(states)
      is_solved = states(i)%reason == reason_converged
      multipliers = 0
      slip = 0
      slips = .false.
      if (is_solved) multipliers = states(i)%multipliers
      if (is_solved .and. allocated(states(i)%slip)) then
        slip = states(i)%slip
        slips = states(i)%slips
      end if
      call buffer%add(join(points(:, i), ',') // ',"' // reason_text(states(i)%reason) // '",' // &
        force_values(header, multipliers, slip, slips, is_solved) // new_line('a'))
    end do
    call write_text_file(path, buffer%text(), error)
  end subroutine write_history_table

  !> Makes a model without parts and training points, which has the data of the problem that the files need. Errors: those of
  !> create_field_map.
  subroutine describe_problem(problem, header, error)
    type(problem_t), intent(in) :: problem
    type(model_t), intent(out) :: header
    type(error_t), allocatable, intent(out) :: error
    type(training_set_t) :: none

    allocate (none%parameters(size(problem%deck%state_parameters), 0))
    call fill_model_header(problem, none, header)
    call create_field_map(problem, header%fields, error)
  end subroutine describe_problem

  !> Does the same as find_values, and computes the strains of materials that flow.
  subroutine find_flow_values(problem, header, point, state, values)
    type(problem_t), intent(in) :: problem
    type(model_t), intent(in) :: header
    real(rk), intent(in) :: point(:)
    type(contact_state_t), intent(in) :: state
    type(field_values_t), intent(inout) :: values

    if (allocated(state%flow)) then
      if (problem%flow%has_plasticity) call values%take_flow(header%fields, plastic=state%flow%plastic)
      if (problem%flow%has_creep) call values%take_flow(header%fields, creep=state%flow%creep)
    end if
    call find_values(header, point, state, values)
  end subroutine find_flow_values

  !> Computes the values of the fields at a point from its full-order solution. Requires: check_points accepted the point.
  subroutine find_values(header, point, state, values)
    !> result of describe_problem
    type(model_t), intent(in) :: header
    !> shape (n_parameters)
    real(rk), intent(in) :: point(:)
    type(contact_state_t), intent(in) :: state
    type(field_values_t), intent(inout) :: values
    real(rk), allocatable :: theta(:, :)
    integer :: i_bad_point, i_bad_source

    call values%take_displacement(header%fields, state%displacement)
    call evaluate_points(header%terms, reshape(point, [size(point), 1]), theta, i_bad_point, i_bad_source)
    call values%take_contact(header%fields, header%laws, theta(:, 1), state%multipliers)
    if (header%laws%remembers()) call values%take_friction(header%fields, state%multipliers, state%slip, state%slips)
    call evaluate_points(header%fields%terms, reshape(point, [size(point), 1]), theta, i_bad_point, i_bad_source)
    call values%take_stresses(header%fields, theta(:, 1))
  end subroutine find_values

  !> Writes the displacement and contact forces of the reduced model at the present point beside the full-order fields, also if the
  !> deck wants only other fields; into contact.h5 only if there is one. It also writes which cells and rows belong to the RID of
  !> the chosen cluster, even where the fallback answers; if this cluster is not hyper-reduced, no cell and all rows. Without an
  !> answer it warns, displacement and contact forces are NaN, and displacement_reduced_source is 0. With friction its traction,
  !> slip and status follow where there is an answer.
  subroutine write_reduced(problem, header, point, online, query, writer)
    type(problem_t), intent(in) :: problem
    !> result of describe_problem
    type(model_t), intent(in) :: header
    real(rk), intent(in) :: point(:)
    type(online_model_t), intent(in) :: online
    type(query_t), intent(inout) :: query
    type(field_writer_t), intent(inout) :: writer
    type(answer_t) :: answer
    type(field_values_t) :: values
    type(rooms_t) :: rooms
    real(rk), allocatable :: displacement(:)
    real(rk) :: multipliers(online%model%n_multipliers), sources(online%model%n_nodes)
    integer :: has_cell(problem%mesh%n_cells), has_row(problem%force_rows%n_rows)

    call query%continue(online, point, answer)
    call reconstruct_displacement(online%model, answer, displacement)
    call reconstruct_multipliers(online, answer, rooms, multipliers)
    sources = displacement_sources(online%model, answer)
    if (answer%reason <= 0) then
      call log_warning('the reduced model has no answer at one of the output points (' // reason_text(answer%reason) // &
        '); its fields have no numbers there')
      multipliers = ieee_value(multipliers, ieee_quiet_nan)
      displacement = ieee_value(displacement, ieee_quiet_nan)
      sources = 0
    end if
    has_cell = 0
    has_row = 0
    has_cell(online%model%parts(answer%cluster)%reduced%cells()) = 1
    has_row(online%model%parts(answer%cluster)%reduced%contact_rows()) = 1
    call writer%file%add_cell_field('reduced_domain', has_cell, '-', 'cell of the reduced integration domain of the chosen cluster')
    associate (n => problem%rows%n_rows)
      call writer%file%add_array('rows_in_reduced_domain', has_row(:n), '-', &
        'contact row of the reduced integration domain of the chosen cluster')
      call write_displacement(problem, displacement, writer)
      call writer%file%add_node_field('displacement_reduced_source', sources, '-', &
      'where it comes from: 0 there is none, 1 modes, 2 exact')
      call writer%file%add_array('multipliers_reduced', multipliers(:n), force_unit(problem%deck), &
        'contact force of each row, reduced model; outside the reduced domain reconstructed')
      call writer%surfaces%write_reduced(multipliers(:n))
    end associate
    if (answer%reason <= 0 .or. .not. allocated(answer%slip)) return
    call values%take_displacement(header%fields, displacement)
    call values%take_contact(header%fields, header%laws, answer%theta, multipliers)
    call values%take_friction(header%fields, multipliers, answer%slip, answer%slips)
    call writer%write_friction(header, values, '_reduced')
    call writer%surfaces%write_friction(values, '_reduced')
  end subroutine write_reduced

  !> Writes the displacement of the reduced model. It is a field that viewers show if all nodes have a displacement;
  !> otherwise only an array of the file, with NaN where there is none.
  subroutine write_displacement(problem, displacement, writer)
    type(problem_t), intent(in) :: problem
    !> [length] of the reduced model, shape (n_dofs)
    real(rk), intent(in) :: displacement(:)
    type(field_writer_t), intent(inout) :: writer
    character(*), parameter :: name = 'displacement_reduced'
    character(*), parameter :: description = 'displacement, reduced model; no number where it has none'
    real(rk) :: vectors(3, problem%mesh%n_nodes)

    associate (n_dim => problem%mesh%n_dim)
      vectors = 0
      vectors(:n_dim, :) = reshape(displacement, [n_dim, problem%mesh%n_nodes])
    end associate
    if (any(ieee_is_nan(displacement))) then
      call writer%file%add_array(name, vectors, problem%deck%units%length, description)
    else
      call writer%file%add_node_field(name, vectors, problem%deck%units%length, description)
    end if
  end subroutine write_displacement

  !> Returns where the displacement of each node in the answer comes from: 0 it has none, 1 modes, 2 exact (displacement_*); shape
  !> (n_nodes).
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
