! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> Fills and writes report.yaml, the common report of the stages of a study.
module sig_stage_report
  use mpi, only: MPI_Get_processor_name, MPI_MAX_PROCESSOR_NAME
  use sig_accuracy_warnings, only: equilibrium_warning, motion_warning
  use sig_body_rotations, only: largest_deformation, largest_rotation
  use sig_clock, only: date_and_time_text
  use sig_commit, only: source_commit
  use sig_contact_state, only: contact_state_t
  use sig_deck_units, only: force_unit, stress_unit
  use sig_error_broadcast, only: broadcast_error
  use sig_errors, only: error_t
  use sig_field_output, only: solved_points_t
  use sig_file_system, only: file_exists, read_text_file
  use sig_kinds, only: rk
  use sig_leaning_contacts, only: lean_warnings
  use sig_log, only: log_warning
  use sig_motion_words, only: unheld_motions
  use sig_parameter_space, only: format_point
  use sig_petsc_support, only: library_versions, rank_and_size
  use sig_problem, only: problem_t
  use sig_problem_texts, only: inert_pair_names
  use sig_reactions, only: boundary_reactions, reaction_t
  use sig_reasons, only: reason_converged, reason_text, reason_unsolved_friction
  use sig_reporting, only: report_deck, report_reactions, report_sizes, report_states
  use sig_resultants_of_contact, only: report_resultants
  use sig_row_condition, only: condition_of_rows
  use sig_run_report, only: run_report_t
  use sig_session, only: session_t
  use sig_text, only: append_text, counted, join, short_number, string_t, to_text
  use sig_unheld_bodies, only: moving_bodies, unheld_warning, unheld_without_friction
  use sig_version, only: build_type
  use sig_work_balance, only: report_work
  use petsc
  implicit none(type, external)
  private
  public :: describe_problem, report_fields, warn_of_leans, warn_of_residuals, write_report

contains

  !> Adds the deck, the planned solver, notes and condition number of the contacts, warnings, provenance, the sizes, the versions,
  !> the run and the times of the set-up to the report. Collective on all ranks.
  subroutine describe_problem(problem, report, ierr)
    type(problem_t), intent(in) :: problem
    type(run_report_t), intent(inout) :: report
    PetscErrorCode, intent(out) :: ierr
    type(string_t), allocatable :: versions(:)
    integer :: rank, n_ranks

    call report_deck(problem%deck, report)
    call report%add('solver/type', problem%plan%type)
    call report%add('solver/linear', problem%plan%linear)
    call report%add('solver/reason', problem%plan%why)
    call report%add('solver/notes', problem%notes)
    call report%add('contact/notes', problem%contact_notes)
    call report%add('contact/condition_number', condition_of_rows(problem%rows, problem%boundary%is_prescribed))
    call report%add('solver/warnings', problem%warnings)
    call report%add('provenance', problem%provenance)
    PetscCall(describe_run(problem, report, ierr))
    call report%add('stiffness/depends_on_parameters', .not. problem%has_fixed_stiffness)
    PetscCall(library_versions(versions, ierr))
    call report%add('version/petsc', versions(1)%text)
    call report%add('version/slepc', versions(2)%text)
    call report%add('version/mpi', versions(3)%text)
    PetscCall(rank_and_size(PETSC_COMM_WORLD, rank, n_ranks, ierr))
    call report%add('sizes/n_ranks', n_ranks)
    call report%add('times/mesh', problem%mesh_seconds)
    call report%add('times/pairing', problem%pairing_seconds)
    call report_sizes(problem%mesh%n_nodes, problem%mesh%n_cells, problem%mesh%n_dim * problem%mesh%n_nodes, &
      problem%force_rows%n_rows, inert_pair_names(problem), report)
  end subroutine describe_problem

  !> Adds date, host of this rank, command line, hash of the mesh, commit and build type of this run. They replace those of earlier
  !> commands. Local.
  subroutine describe_run(problem, report, ierr)
    type(problem_t), intent(in) :: problem
    type(run_report_t), intent(inout) :: report
    PetscErrorCode, intent(out) :: ierr
    character(MPI_MAX_PROCESSOR_NAME) :: host
    character(:), allocatable :: line
    integer :: length

    PetscCallMPI(MPI_Get_processor_name(host, length, ierr))
    call report%add('run/date', date_and_time_text())
    call report%add('run/host', host(:length))
    call get_command(length=length)
    allocate (character(length) :: line)
    call get_command(line)
    call report%add('run/command', line)
    call report%add('run/mesh', problem%mesh%file_hash)
    call report%add('version/commit', source_commit)
    call report%add('version/build', build_type)
  end subroutine describe_run

  !> Adds the units, times, contact resultants, reaction forces (of points that converged) and the state of each point (status,
  !> iterations, closed contacts, residuals) of the full-order solutions. Warns in the log of points that did not converge, and as
  !> warn_of_residuals, warn_of_deformations and unheld_warning say of the points that did. Local.
  subroutine report_fields(problem, points, solved, report)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    type(solved_points_t), intent(in) :: solved
    type(run_report_t), intent(inout) :: report
    type(reaction_t), allocatable :: reactions(:)
    character(:), allocatable :: warning
    integer :: i

    call report%add('units/force', force_unit(problem%deck))
    call report%add('units/stress', stress_unit(problem%deck))
    call report%add('times/partition', solved%partition_seconds)
    call report%add('times/assembly', solved%assembly_seconds)
    call report%add('times/setup', solved%setup_seconds)
    call report%add('times/output', solved%output_seconds)
    call report_states(problem%deck, problem%laws, points, solved%states, report)
    call report_resultants(problem, solved%states, report)
    call report_work(problem, points, solved%states, report)
    call warn_of_residuals(pack(solved%states%residuals%equilibrium, solved%states%reason == reason_converged), report)
    call warn_of_deformations(problem, solved, report)
    warning = unheld_warning(problem%deck, problem%mesh, problem%motions, points, solved%states)
    call warn('positions', warning, report)
    do i = 1, size(solved%states)
      if (solved%states(i)%reason /= reason_converged) then
        call warn_of_state(problem, points, solved%states, i)
        cycle
      end if
      call boundary_reactions(problem%mesh, problem%deck%boundary_conditions, solved%states(i)%reactions, reactions)
      call report_reactions(i, reactions, report)
    end do
  end subroutine report_fields

  !> Warns that a state has no solution, and tells which bodies move, or where friction was not solved, which ones may; later states
  !> of a history that remembers are not named, because they have none for this reason.
  subroutine warn_of_state(problem, points, states, i)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    type(contact_state_t), intent(in) :: states(:)
    !> number of the state, 1-based
    integer, intent(in) :: i
    character(:), allocatable :: text
    type(string_t), allocatable :: bodies(:)
    integer :: n_later

    if (is_later_failure(problem, states, i)) return
    text = 'not converged at ' // format_point(problem%deck%state_parameters, points(:, i)) // ': ' // &
      reason_text(states(i)%reason)
    if (allocated(states(i)%drift)) then
      if (any(abs(states(i)%drift) > 0)) then
        bodies = moving_bodies(problem%deck, problem%mesh, problem%motions, &
          reshape(states(i)%drift / maxval(abs(states(i)%drift)), [size(states(i)%drift), 1]))
        text = text // '; it moves: ' // join(bodies, ', ')
      end if
    end if
    text = text // flow_text(problem, states(i))
    if (states(i)%reason == reason_unsolved_friction) text = text // loose_text(problem, states, i)
    if (problem%remembers() .and. problem%deck%history%states%is_there()) then
      associate (n_times => problem%deck%history%states%n_times())
        n_later = n_times - 1 - modulo(i - 1, n_times)
        if (n_later > 0) text = text // '; nor has this history a solution at its ' // counted(n_later, 'later time')
      end associate
    end if
    call log_warning(text)
  end subroutine warn_of_state

  !> Returns up to which time there is an answer and where materials yield; empty where none flows.
  function flow_text(problem, state) result(text)
    type(problem_t), intent(in) :: problem
    type(contact_state_t), intent(in) :: state
    character(:), allocatable :: text
    integer :: k, m

    text = ''
    if (.not. allocated(state%flow)) return
    text = '; there is an answer up to the time ' // short_number(state%flow%reached)
    do m = 1, size(state%flow%yielding)
      if (.not. state%flow%yielding(m) > 0) cycle
      associate (material => problem%deck%materials(m))
        text = text // '; behind it ' // to_text(nint(100 * state%flow%yielding(m))) // ' % of the integration points of '
        do k = 1, size(material%regions)
          if (k > 1) text = text // ', '
          text = text // '''' // material%regions(k)%text // ''''
        end do
        text = text // ' yield'
      end associate
    end do
  end function flow_text

  !> Whether a state has no solution because an earlier one of its history has none.
  pure logical function is_later_failure(problem, states, i)
    type(problem_t), intent(in) :: problem
    type(contact_state_t), intent(in) :: states(:)
    !> number of the state, 1-based
    integer, intent(in) :: i

    is_later_failure = problem%remembers() .and. problem%deck%history%states%is_there()
    if (is_later_failure) is_later_failure = modulo(i - 1, problem%deck%history%states%n_times()) > 0
    if (is_later_failure) is_later_failure = states(i - 1)%reason /= reason_converged
  end function is_later_failure

  !> Returns which bodies may move although nothing was found out of them: those that only friction could hold whose coefficient is
  !> 0, else those that no contact force holds at the time before, else those that only contact holds. Empty where there are none.
  function loose_text(problem, states, i) result(text)
    type(problem_t), intent(in) :: problem
    type(contact_state_t), intent(in) :: states(:)
    !> number of the state, 1-based
    integer, intent(in) :: i
    character(:), allocatable :: text
    real(rk), allocatable :: loose(:, :)
    logical :: is_first
    integer :: k

    text = ''
    if (problem%motions%n_free == 0) return
    loose = unheld_without_friction(problem%motions, problem%laws, states(i)%friction)
    if (size(loose, 2) > 0) then
      text = '; the coefficient of friction is 0, and nothing else holds ' // names_of(loose) // ': hold it by a support'
      return
    end if
    is_first = .true.
    if (problem%deck%history%states%is_there()) is_first = modulo(i - 1, problem%deck%history%states%n_times()) == 0
    if (.not. is_first) loose = unheld_motions(problem%motions, abs(states(i - 1)%multipliers) > 0)
    if (size(loose, 2) > 0) then
      text = '; at the time before, no contact force holds ' // names_of(loose)
    else
      ! each motion alone
      loose = reshape([real(rk) ::], [problem%motions%n_free, problem%motions%n_free], pad=[0.0_rk])
      do k = 1, problem%motions%n_free
        loose(k, k) = 1
      end do
      text = '; only contact holds ' // names_of(loose)
    end if
    text = text // ', and where no force presses, nothing may hold against the loads'
    if (problem%plan%type == 'active_set') text = text // '; solver.type: condensed finds more of such states'

  contains

    !> Returns `'upper' (translation in x), 'bolt' (rotation about y)`.
    function names_of(combinations) result(names)
      real(rk), intent(in) :: combinations(:, :)
      character(:), allocatable :: names
      type(string_t), allocatable :: bodies(:)

      bodies = moving_bodies(problem%deck, problem%mesh, problem%motions, combinations)
      names = join(bodies, ', ')
    end function names_of
  end function loose_text

  !> Warns once in the log and in the report if motion_warning has a text for the solved points.
  subroutine warn_of_deformations(problem, solved, report)
    type(problem_t), intent(in) :: problem
    type(solved_points_t), intent(in) :: solved
    type(run_report_t), intent(inout) :: report
    character(:), allocatable :: warning

    warning = motion_warning(largest_rotation(problem%motions, solved%states), largest_deformation(problem%motions, solved%states))
    call warn('deformations', warning, report)
  end subroutine warn_of_deformations

  !> Gives the warnings of lean_warnings in the log and in the report, but only one of each contact entry in a command. Local.
  subroutine warn_of_leans(session, multipliers, reasons, report)
    type(session_t), intent(inout) :: session
    !> [force] shape (n_rows, n_points)
    real(rk), intent(in) :: multipliers(:, :)
    !> how each point ended, shape (n_points); only those that converged count
    integer, intent(in) :: reasons(:)
    !> gets all that the command has given so far
    type(run_report_t), intent(inout) :: report
    type(string_t), allocatable :: found(:), given(:)
    integer :: i

    found = lean_warnings(session%full_order%problem, multipliers(:, pack([(i, i=1, size(reasons))], reasons == reason_converged)))
    if (.not. allocated(session%lean_warnings)) allocate (session%lean_warnings(size(found)))
    allocate (given(0))
    do i = 1, size(found)
      if (found(i)%text /= '' .and. .not. allocated(session%lean_warnings(i)%text)) then
        call log_warning(found(i)%text)
        session%lean_warnings(i)%text = found(i)%text
      end if
      if (allocated(session%lean_warnings(i)%text)) call append_text(given, session%lean_warnings(i)%text)
    end do
    call report%add('contact/warnings', given)
  end subroutine warn_of_leans

  !> Writes a warning to the log and to a section of the report; does nothing if the text is empty.
  subroutine warn(section, warning, report)
    character(*), intent(in) :: section
    character(*), intent(in) :: warning
    type(run_report_t), intent(inout) :: report

    if (warning == '') return
    call log_warning(warning)
    call report%add(section // '/warning', warning)
  end subroutine warn

  !> Warns once in the log and in the report if equilibrium_warning has a text for these residuals.
  subroutine warn_of_residuals(residuals, report)
    !> [-] residuals of equilibrium of the full-order problem at some points, shape (n_points)
    real(rk), intent(in) :: residuals(:)
    type(run_report_t), intent(inout) :: report
    character(:), allocatable :: warning

    warning = equilibrium_warning(residuals)
    call warn('residuals', warning, report)
  end subroutine warn_of_residuals

  !> Writes report.yaml, and adds to `report` what earlier commands on the same deck and mesh reported and the report lacks, without
  !> the keys `renewed`. The command run takes nothing from earlier commands. Collective on all ranks; the first one writes. Errors
  !> are printed and set session%exit_code on all ranks: the file cannot be written.
  subroutine write_report(session, renewed, report, ierr)
    type(session_t), intent(inout) :: session
    !> sections (`errors`) and keys of sections (`times/query`) that earlier commands wrote and that are out of date now
    character(*), intent(in) :: renewed(:)
    type(run_report_t), intent(inout) :: report
    PetscErrorCode, intent(out) :: ierr
    type(error_t), allocatable :: error

    if (session%rank == 0) call write_report_file(session, renewed, report, error)
    PetscCall(broadcast_error(error, PETSC_COMM_WORLD, ierr))
    if (allocated(error)) call session%fail(error)
  end subroutine write_report

  !> Writes report.yaml as write_report says; an earlier one that cannot be read is replaced. Local. Errors: the file cannot be
  !> written.
  subroutine write_report_file(session, renewed, report, error)
    type(session_t), intent(in) :: session
    character(*), intent(in) :: renewed(:)
    type(run_report_t), intent(inout) :: report
    type(error_t), allocatable, intent(out) :: error
    type(string_t) :: left_out(size(renewed))
    character(:), allocatable :: earlier, path
    integer :: i

    path = session%folder // '/report.yaml'
    do i = 1, size(renewed)
      left_out(i)%text = trim(renewed(i))
    end do
    if (file_exists(path) .and. .not. session%is_whole_run) then
      call read_text_file(path, earlier, error)
      if (.not. allocated(error)) call report%complete(earlier, left_out)
    end if
    call report%write(path, error)
  end subroutine write_report_file
end module sig_stage_report
