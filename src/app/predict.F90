! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> The command predict: writes the answers of a model file at given points as CSV. It needs neither deck nor mesh.
module sig_predict
  use, intrinsic :: iso_c_binding, only: c_int
  use mpi, only: MPI_Comm_rank
  use sig_answer_block, only: answer_block_t, table_header
  use sig_command_line, only: command_t
  use sig_error_broadcast, only: broadcast_error
  use sig_errors, only: error_report, error_t, exit_not_converged, exit_stopped, exit_success, make_error
  use sig_history, only: states_of
  use sig_kinds, only: rk
  use sig_log, only: log_error, log_info, log_note, log_warning
  use sig_model, only: model_t
  use sig_model_file, only: read_model
  use sig_online_model, only: online_model_t
  use sig_output_stream, only: output_stream_t
  use sig_parameter_space, only: format_point
  use sig_petsc_support, only: max_over_ranks
  use sig_point_argument, only: parse_point
  use sig_point_list, only: point_list_t, read_points
  use sig_predicted_fields, only: fields_folder, large_error, predicted_fields_t
  use sig_answer, only: bound_text, method_name, n_answer_methods
  use sig_signals, only: is_stop_requested, say_when_ended
  use sig_text, only: counted, short_number, string_t, to_text
  use petsc
  implicit none(type, external)
  private
  public :: predict

  !> largest number of points that are read, answered and written at a time
  integer, parameter :: block_size = 2000

  !> warning for those who read the table on the terminal
  character(*), parameter :: lines_missing = 'stopped by a signal; answers may be missing at the end of the table'

  ! include/signorom/threads.h describes this procedure in C.
  interface
    integer(c_int) function sig_processor_count() bind(c)
      import :: c_int
    end function sig_processor_count
  end interface

contains

  !> Answers the points of --at or --points with a model and writes the table to the terminal or to --output; with --fields also
  !> writes fields. Rank 0 does the work, because a query is too short to share between ranks; its threads share the points of
  !> --points. Collective on all ranks, which all get the exit code.
  !>
  !> Errors are printed and give the exit code: the model, the points or the history cannot be read; the model cannot answer, or has
  !> no fields (--fields only); a point is outside of the trained box (--strict only); the table or a file cannot be written. Other
  !> exit codes: a point has no answer (3), a signal (130). After a signal there are no new files, and a table that goes to the
  !> terminal, a device or a pipe may lack its last lines.
  subroutine predict(command, exit_code, ierr)
    type(command_t), intent(in) :: command
    integer, intent(out) :: exit_code
    PetscErrorCode, intent(out) :: ierr
    type(error_t), allocatable :: error
    real(rk) :: largest_code
    integer :: rank

    exit_code = exit_success
    call MPI_Comm_rank(PETSC_COMM_WORLD, rank, ierr)
    if (rank == 0) call predict_points(command, exit_code, error)
    PetscCall(broadcast_error(error, PETSC_COMM_WORLD, ierr))
    largest_code = exit_code
    PetscCall(max_over_ranks(PETSC_COMM_WORLD, largest_code, ierr))
    exit_code = nint(largest_code)
    if (allocated(error)) then
      call log_error(error_report(error))
      exit_code = error%exit_code
    end if
  end subroutine predict

  subroutine predict_points(command, exit_code, error)
    type(command_t), intent(in) :: command
    !> changed if a signal came before the end, or if a point has no answer
    integer, intent(inout) :: exit_code
    type(error_t), allocatable, intent(out) :: error
    type(online_model_t), target :: online
    type(answer_block_t) :: answers
    type(point_list_t) :: list
    type(predicted_fields_t) :: fields
    real(rk), allocatable :: points(:, :)
    type(output_stream_t) :: table
    logical :: is_stopped

    is_stopped = .false.
    work: block
      call read_model(command%file, online%model, error)
      if (allocated(error)) exit work
      associate (names => online%model%parameter_names(:online%model%n_given()))
        if (command%at /= '') then
          call parse_point(command%at, names, points, error)
        else
          call list%open(command%points, names, error)
        end if
      end associate
      if (allocated(error)) exit work
      call read_history(command, online%model, error)
      if (allocated(error)) exit work
      call prepare_answers(command, online, answers, error)
      if (allocated(error)) exit work
      if (command%at /= '') then
        call take_points(command, points, answers, error)
      else
        call next_block(command, list, answers, error)
      end if
      if (allocated(error)) exit work
      if (command%has_fields) call fields%create(online, command%file, fields_folder(command%file, command%output), error)
      if (allocated(error)) exit work
      if (command%output == '') call say_when_ended('warning: ' // lines_missing, is_warning=.true.)
      call table%open(command%output, error)
      if (allocated(error)) exit work
      call answer_blocks(command, list, answers, table, fields, is_stopped, error)
    end block work
    if (.not. is_stopped) call fields%close(error)
    call table%close(error, is_dropped=is_stopped)
    if (is_stopped) then
      exit_code = exit_stopped
      call say_stopped(command)
    else if (.not. allocated(error)) then
      call warn_of_verdict(online)
      call report_unanswered(answers, exit_code)
      call report_methods(command, answers)
      if (command%output /= '') call say_notes(online, answers)
      if (command%has_fields) call report_fields(command, online%model, fields)
    end if
    call list%close()
    call answers%destroy()
  end subroutine predict_points

  !> Reads the file of --history, if it is given, and puts its times and tables in the place of the model's. Errors: the model has
  !> no history; those of read_points; times that are not above 0 or do not ascend.
  subroutine read_history(command, model, error)
    type(command_t), intent(in) :: command
    type(model_t), intent(inout) :: model
    type(error_t), allocatable, intent(out) :: error
    real(rk), allocatable :: rows(:, :)
    integer :: i, k

    if (command%history == '') return
    if (.not. model%history%is_there()) then
      call make_error(error, 'the model has no history: its deck has no times', command%file, &
        hint='leave --history out; --points answers many points')
      return
    end if
    call read_points(command%history, model%parameter_names(model%i_time():), rows, error)
    if (allocated(error)) return
    model%history%times = rows(1, :)
    do i = 1, size(rows, 2)
      if (rows(1, i) > maxval([0.0_rk, rows(1, :i - 1)])) cycle
      call make_error(error, 'the times must be greater than 0 and ascend; ' // short_number(rows(1, i)) // ' does not', &
        command%history)
      return
    end do
    do k = 1, size(model%history%tables)
      associate (table => model%history%tables(k))
        if (allocated(table%times)) deallocate (table%times, table%values)
        allocate (table%times(size(rows, 2)), table%values(size(rows, 2)))
        ! gfortran 12 cuts all texts of an array constructor to the length of the first one
        do i = 1, size(rows, 2)
          table%times(i)%text = to_text(rows(1, i))
          table%values(i)%text = to_text(rows(k + 1, i))
        end do
      end associate
    end do
  end subroutine read_history

  !> Prepares the model for queries, and the block for as many threads as --threads says, or as there are processors; for one with
  !> --at. Errors: the model cannot answer.
  subroutine prepare_answers(command, online, answers, error)
    type(command_t), intent(in) :: command
    type(online_model_t), intent(inout), target :: online
    type(answer_block_t), intent(inout) :: answers
    type(error_t), allocatable, intent(out) :: error
    character(:), allocatable :: message
    integer :: n_threads

    n_threads = command%n_threads
    if (n_threads == 0) n_threads = sig_processor_count()
    if (command%at /= '') n_threads = 1
    call online%prepare(message)
    if (.not. allocated(message)) call answers%create(online, n_threads, &
      max(block_size, online%model%history%n_times()), message)
    if (allocated(message)) call make_error(error, 'the model cannot answer: ' // message, command%file)
  end subroutine prepare_answers

  !> Reads the next points of --points into the block and checks them by check_box; block%n_points is 0 at the end and always with
  !> --at. Errors: those of point_list_t%next, for example a line that is no point; those of take_points.
  subroutine next_block(command, list, answers, error)
    type(command_t), intent(in) :: command
    type(point_list_t), intent(inout) :: list
    type(answer_block_t), intent(inout) :: answers
    type(error_t), allocatable, intent(out) :: error
    real(rk), allocatable :: points(:, :)
    integer :: n_points

    answers%n_points = 0
    if (command%at /= '') return
    associate (model => answers%online%model)
      allocate (points(model%n_given(), max(1, block_size / max(1, model%history%n_times()))))
    end associate
    call list%next(points, n_points, error)
    if (.not. allocated(error)) call take_points(command, points(:, :n_points), answers, error)
  end subroutine next_block

  !> Gives the block the states of some points and checks them by check_box. Errors: a table of the history has no finite value at a
  !> point, or its times do not ascend there; that of check_box.
  subroutine take_points(command, points, answers, error)
    type(command_t), intent(in) :: command
    !> shape (n_given, n_points); at most as many as give a full block of states
    real(rk), intent(in) :: points(:, :)
    type(answer_block_t), intent(inout) :: answers
    type(error_t), allocatable, intent(out) :: error
    real(rk), allocatable :: states(:, :)
    character(:), allocatable :: fault
    integer :: i_bad_point

    associate (model => answers%online%model)
      call states_of(model%history, model%parameter_names(:model%n_given()), points, states, i_bad_point, fault)
      if (allocated(fault)) call make_error(error, fault // ' at ' // &
        format_point(model%parameter_names(:model%n_given()), points(:, i_bad_point)), command%file)
    end associate
    if (allocated(error)) return
    answers%n_points = size(states, 2)
    answers%points(:, :answers%n_points) = states
    call check_box(command, answers, error)
  end subroutine take_points

  !> Checks with --strict that the points of the block lie in the trained box; does nothing without --strict. Errors: a point lies
  !> outside; the first one is named.
  subroutine check_box(command, answers, error)
    type(command_t), intent(in) :: command
    type(answer_block_t), intent(in) :: answers
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    if (.not. command%is_strict) return
    do i = 1, answers%n_points
      if (answers%online%is_inside_box(answers%points(:, i))) cycle
      call make_error(error, outside_text(answers%online%model, answers%points(:, i)), command%file)
      return
    end do
  end subroutine check_box

  !> Answers one block of points after the other, and writes the head of the table and the lines in the order of the points; adds
  !> the fields of each point if they are wanted. The memory does not depend on the number of points, and the order of the lines
  !> does not depend on the number of threads. Warns at once of the first point outside of the trained box, and at the end of the
  !> number of these points (if there are several) and of points with several solutions. Errors: those of next_block; the table
  !> cannot be written.
  subroutine answer_blocks(command, list, answers, table, fields, is_stopped, error)
    type(command_t), intent(in) :: command
    type(point_list_t), intent(inout) :: list
    !> with the first points
    type(answer_block_t), intent(inout) :: answers
    type(output_stream_t), intent(inout) :: table
    type(predicted_fields_t), intent(inout) :: fields
    !> a signal came before the end; the lines of the last points may be missing
    logical, intent(out) :: is_stopped
    type(error_t), allocatable, intent(out) :: error
    integer :: i, n_outside

    is_stopped = .false.
    n_outside = 0
    call table%write_line(table_header(answers%online%model), error)
    if (allocated(error)) return
    do while (answers%n_points > 0)
      call answers%answer()
      is_stopped = is_stop_requested()
      if (is_stopped) return
      do i = 1, answers%n_points
        if (answers%is_outside(i)) then
          if (n_outside == 0) call log_warning(outside_text(answers%online%model, answers%points(:, i)) // &
            '; an answer there is an extrapolation')
          n_outside = n_outside + 1
        end if
        call table%write_line(answers%line(i), error)
        if (allocated(error)) return
        call fields%add(answers%points(:, i))
        is_stopped = is_stop_requested()
        if (is_stopped) return
      end do
      call next_block(command, list, answers, error)
      if (allocated(error)) return
    end do
    associate (n_several => sum(answers%askers%n_several))
      if (n_several > 0) call log_warning('the reduced problem has several solutions at ' // to_text(n_several) // ' of ' // &
        to_text(sum(answers%counts())) // ' points, where n_solutions is 2: the contact forces are less reliable there')
    end associate
    if (n_outside > 1) call log_warning(to_text(n_outside) // ' of ' // to_text(sum(answers%counts())) // &
      ' points lie outside the trained box; the first is named above')
  end subroutine answer_blocks

  subroutine say_stopped(command)
    type(command_t), intent(in) :: command

    call say_when_ended('')
    if (command%output == '') then
      call log_warning(lines_missing)
    else
      call log_info('stopped by a signal; no file was written; if --output is a device or a pipe, answers may be missing there')
    end if
  end subroutine say_stopped

  !> Logs the parts' notes of bounds, and the largest estimate of an error where there are estimates.
  subroutine say_notes(online, answers)
    type(online_model_t), intent(in) :: online
    type(answer_block_t), intent(in) :: answers
    character(:), allocatable :: note
    integer :: i

    do i = 1, size(online%model%parts)
      ! gfortran 12 frees a text twice that `associate` names
      note = online%model%parts(i)%reduced%note_of_bounds()
      if (note /= '') call log_info(note)
    end do
    if (answers%largest_estimate() >= 0) call log_info('the error of the contact forces is estimated at up to ' // &
      short_number(answers%largest_estimate()) // ' of their size (column error_estimate; an estimate, no bound)')
  end subroutine say_notes

  !> Warns if the model was validated and not accepted.
  subroutine warn_of_verdict(online)
    type(online_model_t), intent(in) :: online

    associate (verdict => online%model%validation%verdict)
      if (index(verdict, 'NOT accepted') == 1) call log_warning('the validation of this model: ' // verdict)
    end associate
  end subroutine warn_of_verdict

  !> Warns of points without an answer, and sets exit_code to 3 if there are any. Counts all points that the block has answered
  !> since its create, not only those that it holds now.
  subroutine report_unanswered(answers, exit_code)
    type(answer_block_t), intent(in) :: answers
    integer, intent(inout) :: exit_code
    integer :: counts(0:n_answer_methods)

    counts = answers%counts()
    if (counts(0) == 0) return
    exit_code = exit_not_converged
    call log_warning(to_text(counts(0)) // ' of ' // counted(sum(counts), 'point') // &
      ' without an answer; the column status says why')
  end subroutine report_unanswered

  !> Logs the number of points by each method (`none` for those without an answer) and the path of the table; nothing if the table
  !> goes to the terminal.
  subroutine report_methods(command, answers)
    type(command_t), intent(in) :: command
    type(answer_block_t), intent(in) :: answers
    character(:), allocatable :: text
    integer :: counts(0:n_answer_methods), i

    if (command%output == '') return
    counts = answers%counts()
    text = ''
    do i = 0, n_answer_methods
      if (counts(i) > 0) text = text // ', ' // to_text(counts(i)) // ' by ' // method_name(i)
    end do
    call log_info(counted(sum(counts), 'answer') // ' (' // text(3:) // '): ' // command%output)
  end subroutine report_methods

  !> Logs the path of fields.xdmf, how many points have fields, if any has, and the largest error of their displacements; warns of
  !> points without fields, of points at which no contact force holds a body, and of large errors, if there are any.
  subroutine report_fields(command, model, fields)
    type(command_t), intent(in) :: command
    type(model_t), intent(in) :: model
    type(predicted_fields_t), intent(in) :: fields
    character(:), allocatable :: place

    if (fields%n_left_out > 0) call log_warning('no fields for ' // counted(fields%n_left_out, 'point') // &
      ': there is no answer, or Hooke''s law or an imposed strain is not finite')
    if (fields%n_unheld > 0) then
      place = format_point(model%parameter_names, fields%first_unheld)
      if (fields%n_unheld > 1) place = to_text(fields%n_unheld) // ' points, the first (' // place // '),'
      call log_warning('at ' // place // ' no contact force holds a body that only contact can hold: its displacement and its ' // &
        'gaps are one of many possible')
    end if
    if (fields%n_inaccurate > 0) call log_warning('the error of the displacement may be above ' // &
      to_text(nint(100 * large_error)) // ' % at ' // to_text(fields%n_inaccurate) // ' of ' // &
      counted(fields%n_written, 'point') // ' with fields: displacements and stresses are not accurate there; the largest ' // &
      'error is ' // bound_text(fields%largest_bound) // ' at ' // format_point(model%parameter_names, fields%worst) // &
      ' (column displacement_bound)')
    if (fields%n_written > 0) call log_note('fields of ' // counted(fields%n_written, 'point') // error_note(fields) // ': ' // &
      fields_folder(command%file, command%output) // '/fields.xdmf')
  end subroutine report_fields

  !> Returns in parentheses the largest error of the displacements of all points with fields, if it is known and not large.
  function error_note(fields) result(text)
    type(predicted_fields_t), intent(in) :: fields
    character(:), allocatable :: text

    text = ''
    if (fields%n_inaccurate == 0 .and. fields%largest_bound >= 0) text = ' (error of the displacement in the norm of the ' // &
      'stiffness at most ' // short_number(fields%largest_bound) // ')'
  end function error_note

  function outside_text(model, point) result(text)
    type(model_t), intent(in) :: model
    real(rk), intent(in) :: point(:)
    character(:), allocatable :: text
    integer :: i

    text = format_point(model%parameter_names, point) // ' lies outside the trained box ('
    do i = 1, size(point)
      if (i > 1) text = text // ', '
      text = text // model%parameter_names(i)%text // ' from ' // to_text(model%box(1, i)) // ' to ' // to_text(model%box(2, i))
    end do
    text = text // ')'
  end function outside_text
end module sig_predict
