! SPDX-License-Identifier: BSD-3-Clause
#include "signorom/macros.h"
!> The command predict: answers of a model file at points, as CSV. Needs neither deck nor mesh.
module sig_predict
  use, intrinsic :: iso_fortran_env, only: int64, output_unit
  use mpi, only: MPI_Comm_rank
  use sig_command_line, only: command_t
  use sig_error_broadcast, only: broadcast_error
  use sig_errors, only: error_report, error_t, exit_success, make_error
  use sig_file_system, only: remove_file, rename_file
  use sig_kinds, only: rk
  use sig_log, only: log_error, log_info, log_warning
  use sig_model, only: model_t
  use sig_model_file, only: read_model
  use sig_online_model, only: online_model_t
  use sig_parameter_space, only: format_point, read_points
  use sig_point_argument, only: parse_point
  use sig_query, only: answer_t, method_name, query_t, reason_text
  use sig_reconstruction, only: reconstruct_multipliers
  use sig_text, only: to_text
  use petsc
  implicit none(type, external)
  private
  public :: predict

contains

  !> Rank 0 works: a query is too short to share. Collective on all ranks, which all get the exit code.
  subroutine predict(command, exit_code, ierr)
    type(command_t), intent(in) :: command
    integer, intent(out) :: exit_code
    PetscErrorCode, intent(out) :: ierr
    type(error_t), allocatable :: error
    integer :: rank

    call MPI_Comm_rank(PETSC_COMM_WORLD, rank, ierr)
    if (rank == 0) call predict_points(command, error)
    PetscCall(broadcast_error(error, PETSC_COMM_WORLD, ierr))
    exit_code = exit_success
    if (.not. allocated(error)) return
    call log_error(error_report(error))
    exit_code = error%exit_code
  end subroutine predict

  subroutine predict_points(command, error)
    type(command_t), intent(in) :: command
    type(error_t), allocatable, intent(out) :: error
    type(online_model_t) :: online
    type(query_t) :: query
    real(rk), allocatable :: points(:, :)
    character(:), allocatable :: message

    call read_model(command%file, online%model, error)
    if (allocated(error)) return
    if (command%at /= '') then
      call parse_point(command%at, online%model%parameter_names, points, error)
    else
      call read_points(command%points, online%model%parameter_names, points, error)
    end if
    if (allocated(error)) return
    call online%prepare(message)
    if (.not. allocated(message)) call query%create(online, message)
    if (allocated(message)) then
      call make_error(error, 'the model cannot answer: ' // message, command%file)
    else
      call write_answers(command, online, query, points, error)
    end if
    call query%destroy()
  end subroutine predict_points

  subroutine write_answers(command, online, query, points, error)
    type(command_t), intent(in) :: command
    type(online_model_t), intent(in) :: online
    type(query_t), intent(inout) :: query
    real(rk), intent(in) :: points(:, :)
    type(error_t), allocatable, intent(out) :: error
    integer(int64) :: n_bytes
    integer :: unit

    if (command%is_strict) call check_box(command, online, points, error)
    if (.not. allocated(error)) call open_table(command, unit, error)
    if (allocated(error)) return
    call answer_points(online, query, points, unit, n_bytes)
    call close_table(command, unit, n_bytes, error)
    if (command%output /= '' .and. .not. allocated(error)) call log_info(to_text(size(points, 2)) // ' answers: ' // command%output)
  end subroutine write_answers

  !> What --strict asks for, before anything is written.
  subroutine check_box(command, online, points, error)
    type(command_t), intent(in) :: command
    type(online_model_t), intent(in) :: online
    real(rk), intent(in) :: points(:, :)
    type(error_t), allocatable, intent(out) :: error
    integer :: i

    do i = 1, size(points, 2)
      if (online%is_inside_box(points(:, i))) cycle
      call make_error(error, outside_text(online%model, points(:, i)), command%file)
      return
    end do
  end subroutine check_box

  !> The terminal, or a file beside the one that is asked for: it takes its name when it is whole.
  subroutine open_table(command, unit, error)
    type(command_t), intent(in) :: command
    integer, intent(out) :: unit
    type(error_t), allocatable, intent(out) :: error
    character(200) :: reason
    integer :: status

    unit = output_unit
    if (command%output == '') return
    open (newunit=unit, file=command%output // '.partial', action='write', status='replace', iostat=status, iomsg=reason)
    if (status /= 0) call make_error(error, 'cannot write the answers: ' // trim(reason), command%output)
  end subroutine open_table

  !> Errors: the disk took less than was written, of which the buffered units of gfortran say nothing; the name is taken.
  subroutine close_table(command, unit, n_bytes, error)
    type(command_t), intent(in) :: command
    integer, intent(in) :: unit
    !> what the file must hold
    integer(int64), intent(in) :: n_bytes
    type(error_t), allocatable, intent(out) :: error
    type(error_t), allocatable :: ignored
    integer(int64) :: n_found
    integer :: status

    if (command%output == '') return
    close (unit, iostat=status)
    inquire (file=command%output // '.partial', size=n_found)
    if (status /= 0 .or. n_found /= n_bytes) then
      call make_error(error, 'cannot write the answers: no room for them', command%output)
    else
      call rename_file(command%output // '.partial', command%output, error)
    end if
    if (.not. allocated(error)) return
    error%file = command%output
    call remove_file(command%output // '.partial', ignored)
  end subroutine close_table

  !> A line per point as it is answered, so that memory does not grow with their number.
  subroutine answer_points(online, query, points, unit, n_bytes)
    type(online_model_t), intent(in) :: online
    type(query_t), intent(inout) :: query
    real(rk), intent(in) :: points(:, :)
    integer, intent(in) :: unit
    !> what was written
    integer(int64), intent(out) :: n_bytes
    type(answer_t) :: answer
    character(:), allocatable :: line
    integer :: i, n_outside, status

    n_outside = 0
    line = header(online%model)
    n_bytes = len(line) + 1
    write (unit, '(a)', iostat=status) line
    ! A full disk: n_bytes is then more than the file has, which the caller finds.
    if (status /= 0) return
    do i = 1, size(points, 2)
      call query%evaluate(online, points(:, i), answer)
      if (.not. answer%is_inside_box) then
        if (n_outside == 0) call log_warning(outside_text(online%model, points(:, i)) // '; the answer is an extrapolation')
        n_outside = n_outside + 1
      end if
      line = row(online%model, points(:, i), answer)
      n_bytes = n_bytes + len(line) + 1
      write (unit, '(a)', iostat=status) line
      if (status /= 0) return
    end do
    if (n_outside > 1) call log_warning(to_text(n_outside) // ' of ' // to_text(size(points, 2)) // &
      ' points lie outside the trained box; the first is named above')
  end subroutine answer_points

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

  !> Column lambda_k is the contact force of pair k, named by the first node's tag in the mesh file.
  function header(model) result(text)
    type(model_t), intent(in) :: model
    character(:), allocatable :: text
    integer :: i

    text = ''
    do i = 1, size(model%parameter_names)
      text = text // model%parameter_names(i)%text // ','
    end do
    text = text // 'cluster,'
    if (size(model%clusters) > 1) text = text // 'next_cluster,'
    text = text // 'status,solver,n_active,contact_force'
    do i = 1, model%n_multipliers
      text = text // ',lambda_' // to_text(model%first_node_tags(i))
    end do
  end function header

  function row(model, point, answer) result(text)
    type(model_t), intent(in) :: model
    real(rk), intent(in) :: point(:)
    type(answer_t), intent(in) :: answer
    character(:), allocatable :: text
    real(rk), allocatable :: multipliers(:)
    integer :: i

    call reconstruct_multipliers(model, answer, multipliers)
    text = ''
    do i = 1, size(point)
      text = text // to_text(point(i)) // ','
    end do
    text = text // to_text(answer%cluster) // ','
    if (size(model%clusters) > 1) text = text // to_text(model%choice%next_cluster(point)) // ','
    text = text // status(answer) // ',' // method_name(answer%method) // ',' // &
      to_text(count(multipliers > 0)) // ',' // to_text(sum(multipliers))
    do i = 1, size(multipliers)
      text = text // ',' // to_text(multipliers(i))
    end do
  end function row

  function status(answer) result(text)
    type(answer_t), intent(in) :: answer
    character(:), allocatable :: text

    text = 'answered'
    if (answer%reason < 0) text = '"' // reason_text(answer%reason) // '"'
  end function status
end module sig_predict
