! SPDX-License-Identifier: BSD-3-Clause
!> A step with Coulomb friction from the answer of the last one: where sig_friction_problem finds none, along paths from there.
module sig_friction_search
  use sig_friction_problem, only: contact_open, friction_contacts_t, friction_solution_t, friction_workspace_t, solve_friction
  use sig_kinds, only: rk
  use sig_reasons, only: reason_converged
  implicit none(type, external)
  private
  public :: friction_loads_t, search_friction

  !> What a step and the last one have besides W.
  type :: friction_loads_t
    !> [length] q of this step and of the last one, and s_0 as for solve_friction; shapes (n_rows)
    real(rk), allocatable :: q(:)
    real(rk), allocatable :: before(:)
    real(rk), allocatable :: origins(:)
    !> [-] coefficient of friction of each contact
    real(rk), allocatable :: friction(:)
  contains
    procedure :: take
  end type friction_loads_t

  !> limits of `approach`: problems, rounds of sweeps in each, and the smallest share of the way from the last step to this one
  integer, parameter :: most_trials = 60
  integer, parameter :: rounds_of_trials = 2
  real(rk), parameter :: least_length = 1.0e-5_rk
  !> limits of `follow`: places, and those in a row with the same forces up to a share of the largest one: bodies move on and on
  integer, parameter :: most_places = 150
  integer, parameter :: most_steady = 12
  real(rk), parameter :: steady = 1.0e-6_rk

contains

  !> Takes those of the next step. Where there was no step before, q stands for that of the last one.
  pure subroutine take(self, q, origins, friction)
    class(friction_loads_t), intent(inout) :: self
    real(rk), intent(in) :: q(:)
    real(rk), intent(in) :: origins(:)
    real(rk), intent(in) :: friction(:)

    if (.not. allocated(self%q)) self%q = q
    if (size(self%q) /= size(q)) self%q = q
    self%before = self%q
    self%q = q
    self%origins = origins
    self%friction = friction
  end subroutine take

  !> Solves one step. solution%reason says whether there is an answer (solve_friction).
  subroutine search_friction(matrix, contacts, loads, solution, workspace, inverse)
    !> as of solve_friction
    real(rk), contiguous, intent(in) :: matrix(:, :)
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_loads_t), intent(in) :: loads
    !> in: the answer of the last step, or a reason that is not reason_converged in the first one
    type(friction_solution_t), intent(inout) :: solution
    type(friction_workspace_t), intent(inout) :: workspace
    real(rk), allocatable, intent(in) :: inverse(:, :)
    type(friction_solution_t) :: last
    logical :: has_last

    has_last = solution%reason == reason_converged
    if (has_last) then
      last = solution
    else
      last = untouched(contacts, loads%q)
    end if
    call solve_friction(matrix, loads%q, loads%origins, loads%friction, contacts, solution, workspace, inverse)
    if (has_last .and. solution%reason /= reason_converged) &
      call approach(matrix, contacts, loads, last, solution, workspace, inverse)
    if (solution%reason /= reason_converged) call follow(matrix, contacts, loads, last, solution, workspace, inverse)
  end subroutine search_friction

  !> Returns what stands for the last step before the first one: nothing touches.
  pure type(friction_solution_t) function untouched(contacts, openings) result(solution)
    type(friction_contacts_t), intent(in) :: contacts
    !> [length] openings without forces, shape (n_rows)
    real(rk), intent(in) :: openings(:)

    allocate (solution%lambda(size(openings)), source=0.0_rk)
    allocate (solution%openings(size(openings)), source=openings)
    allocate (solution%states(contacts%n_contacts), source=contact_open)
    solution%reason = reason_converged
  end function untouched

  !> Tries a step that was not solved once more, from the answers of problems between the last step and this one: their openings
  !> without forces lie on the line from those of the last step to those of this one. What is remembered stays as it is.
  !> As when a body is nearly unloaded, few of the contacts of the last step may be closed in this one. Where this fails, too, the
  !> reason stays as it was.
  subroutine approach(matrix, contacts, loads, last, solution, workspace, inverse)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_loads_t), intent(in) :: loads
    !> answer of the last step
    type(friction_solution_t), intent(in) :: last
    type(friction_solution_t), intent(inout) :: solution
    type(friction_workspace_t), intent(inout) :: workspace
    real(rk), allocatable, intent(in) :: inverse(:, :)
    type(friction_solution_t) :: start, trial
    real(rk) :: length, place
    integer :: i

    start = last
    place = 0
    length = 0.5_rk
    do i = 1, most_trials
      trial = start
      associate (next => min(1.0_rk, place + length))
        call solve_friction(matrix, loads%before + next * (loads%q - loads%before), loads%origins, loads%friction, contacts, &
          trial, workspace, inverse, rounds_of_trials)
        if (trial%reason == reason_converged) then
          place = next
          start = trial
        else
          length = length / 2
        end if
      end associate
      if (place >= 1) exit
      if (length < least_length) return
    end do
    if (place >= 1) solution = start
  end subroutine approach

  !> Tries a step that was not solved once more, where only contact holds bodies: springs between each place of these bodies and the
  !> next one let them move from contact to contact, as when a load changes its sign and a pin crosses its clearance. From each
  !> place the step itself is tried. Where this fails, too, the reason stays as it was.
  subroutine follow(matrix, contacts, loads, last, solution, workspace, inverse)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    type(friction_contacts_t), intent(in) :: contacts
    type(friction_loads_t), intent(in) :: loads
    !> answer of the last step, or `untouched`
    type(friction_solution_t), intent(in) :: last
    type(friction_solution_t), intent(inout) :: solution
    type(friction_workspace_t), intent(inout) :: workspace
    real(rk), allocatable, intent(in) :: inverse(:, :)
    type(friction_solution_t) :: start, trial
    real(rk), allocatable :: softened(:, :)
    real(rk) :: openings(size(loads%q)), spring
    integer :: i, j, n_steady

    n_steady = 0
    associate (n => contacts%n_forces(), q => loads%q)
      spring = 0
      if (contacts%n_motions > 0) spring = norm2(q(n + 1:)) * maxval(abs(matrix(:n, n + 1:)))
      if (.not. spring > 0) return
      spring = spring / max(tiny(spring), maxval(abs(last%openings(:contacts%n_contacts))))
      softened = matrix
      start = last
      do i = 1, most_places
        do j = n + 1, size(q)
          softened(j, j) = spring
        end do
        openings = q
        openings(n + 1:) = q(n + 1:) - spring * start%lambda(n + 1:)
        trial = start
        call solve_friction(softened, openings, loads%origins, loads%friction, contacts, trial, workspace, &
          most_rounds=rounds_of_trials)
        if (trial%reason /= reason_converged) then
          spring = 4 * spring
          cycle
        end if
        n_steady = n_steady + 1
        if (maxval(abs(trial%lambda(:n) - start%lambda(:n))) > steady * maxval(abs(trial%lambda(:n)))) n_steady = 0
        if (n_steady > most_steady) exit
        start = trial
        call solve_friction(matrix, q, loads%origins, loads%friction, contacts, trial, workspace, inverse, rounds_of_trials)
        if (trial%reason == reason_converged) then
          solution = trial
          return
        end if
        spring = spring / 2
      end do
    end associate
  end subroutine follow
end module sig_friction_search
