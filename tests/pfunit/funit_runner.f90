! SPDX-License-Identifier: BSD-3-Clause
!> Runs the tests of one serial .pf file one after the other; the translator writes the program that calls this.
module funit_runner
  use, intrinsic :: iso_fortran_env, only: output_unit
  use funit_exceptions, only: anyExceptions, begin_test
  implicit none(type, external)
  private
  public :: runner_t, test_i

  abstract interface
    subroutine test_i()
    end subroutine test_i
  end interface

  type :: runner_t
    integer :: n_run = 0
    integer :: n_failed = 0
  contains
    procedure :: run
    procedure :: skip
    procedure :: finish
    procedure :: say
    procedure :: count_result
  end type runner_t

contains

  subroutine run(this, name, test, before, after)
    class(runner_t), intent(inout) :: this
    character(*), intent(in) :: name
    procedure(test_i) :: test
    procedure(test_i), optional :: before
    procedure(test_i), optional :: after

    call this%say('test ' // name)
    call begin_test(name)
    if (present(before)) call before()
    if (.not. anyExceptions()) call test()
    if (present(after)) call after()
    call this%count_result()
  end subroutine run

  !> Says that a test is switched off.
  subroutine skip(this, name)
    class(runner_t), intent(inout) :: this
    character(*), intent(in) :: name

    call this%say('DISABLED ' // name)
  end subroutine skip

  !> Prints the count and ends the program; nothing run counts as a failure.
  subroutine finish(this)
    class(runner_t), intent(inout) :: this

    write (output_unit, '(i0, a, i0, a)') this%n_run, ' tests, ', this%n_failed, ' failed'
    if (this%n_failed > 0 .or. this%n_run == 0) stop 1, quiet = .true.
  end subroutine finish

  subroutine say(this, text)
    class(runner_t), intent(in) :: this
    character(*), intent(in) :: text

    write (output_unit, '(a)') text
    flush (output_unit)
  end subroutine say

  subroutine count_result(this)
    class(runner_t), intent(inout) :: this

    this%n_run = this%n_run + 1
    if (anyExceptions()) this%n_failed = this%n_failed + 1
  end subroutine count_result
end module funit_runner
