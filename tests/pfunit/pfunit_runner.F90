! SPDX-License-Identifier: BSD-3-Clause
!> Runs the tests of one .pf file that are meant for the rank count of this process group.
module pfunit_runner
  use, intrinsic :: iso_fortran_env, only: output_unit
  use funit_exceptions, only: begin_test, set_rank
  use funit_runner, only: runner_t
  use mpi, only: MPI_Barrier, MPI_COMM_WORLD, MPI_Comm_dup, MPI_Comm_free, MPI_Comm_rank, MPI_Comm_size, MPI_Finalize, MPI_Init
  use pfunit, only: MpiTestMethod, anyExceptions
  implicit none(type, external)
  private
  public :: mpi_runner_t

  abstract interface
    subroutine mpi_test_i(this)
      import :: MpiTestMethod
      class(MpiTestMethod), intent(inout) :: this
    end subroutine mpi_test_i
  end interface

  !> Every rank runs a test without ranks in a file that has some, by the procedure run of its parent.
  type, extends(runner_t) :: mpi_runner_t
    integer :: rank = 0
    integer :: n_processes = 0
  contains
    procedure :: start
    procedure :: run_mpi
    procedure :: finish
    procedure :: say
    procedure :: count_result
  end type mpi_runner_t

contains

  subroutine start(this)
    class(mpi_runner_t), intent(inout) :: this
    integer :: status

    call MPI_Init(status)
    call MPI_Comm_rank(MPI_COMM_WORLD, this%rank, status)
    call MPI_Comm_size(MPI_COMM_WORLD, this%n_processes, status)
    call set_rank(this%rank)
  end subroutine start

  !> Empty counts = any number of ranks.
  subroutine run_mpi(this, name, counts, test, before, after)
    class(mpi_runner_t), intent(inout) :: this
    character(*), intent(in) :: name
    integer, intent(in) :: counts(:)
    procedure(mpi_test_i) :: test
    procedure(mpi_test_i), optional :: before
    procedure(mpi_test_i), optional :: after
    type(MpiTestMethod) :: method
    integer :: communicator, status

    if (size(counts) > 0 .and. .not. any(counts == this%n_processes)) return
    call this%say('test ' // name)
    call begin_test(name)
    ! a communicator per test: what one test leaves behind cannot match a message of the next
    call MPI_Comm_dup(MPI_COMM_WORLD, communicator, status)
    call method%set_group(communicator, this%n_processes, this%rank)
    if (present(before)) call before(method)
    if (.not. anyExceptions(communicator)) call test(method)
    if (present(after)) call after(method)
    call this%count_result()
    call MPI_Comm_free(communicator, status)
  end subroutine run_mpi

  !> Prints the count and ends the program on every rank with the same code; nothing run counts as a failure.
  subroutine finish(this)
    class(mpi_runner_t), intent(inout) :: this
    character(80) :: text
    integer :: status

    write (text, '(i0, a, i0, a, i0, a)') this%n_run, ' tests, ', this%n_failed, ' failed (', this%n_processes, ' ranks)'
    call this%say(trim(text))
    call MPI_Finalize(status)
    if (this%n_failed > 0 .or. this%n_run == 0) stop 1, quiet = .true.
  end subroutine finish

  subroutine say(this, text)
    class(mpi_runner_t), intent(in) :: this
    character(*), intent(in) :: text

    if (this%rank > 0) return
    write (output_unit, '(a)') text
    flush (output_unit)
  end subroutine say

  !> A failure on any rank is a failure of the test. Collective.
  subroutine count_result(this)
    class(mpi_runner_t), intent(inout) :: this
    integer :: status

    this%n_run = this%n_run + 1
    if (anyExceptions(MPI_COMM_WORLD)) this%n_failed = this%n_failed + 1
    ! ranks wait for each other, so that the output of one test stays together
    call MPI_Barrier(MPI_COMM_WORLD, status)
  end subroutine count_result
end module pfunit_runner
