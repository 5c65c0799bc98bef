! SPDX-License-Identifier: BSD-3-Clause
!> Chooses the solver: that of the deck, or for `auto` the one that fits the size of the problem and the number of points.
module sig_solver_plan
  use sig_deck_config, only: solver_config_t
  use sig_kinds, only: rk
  use sig_solver_costs, only: problem_size_t
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: solver_plan_t, make_solver_plan, plan_text, fits_condensed

  !> The solver that was chosen, and why.
  type :: solver_plan_t
    !> condensed, active_set or snesvi
    character(:), allocatable :: type
    !> cholesky or gamg
    character(:), allocatable :: linear
    !> whether the stiffness is small enough to be factored once, and the deck does not ask for multigrid
    logical :: may_factor = .true.
    !> reason of the choice, as text for a message
    character(:), allocatable :: why
  end type solver_plan_t

  !> largest number of multipliers: W is a dense matrix on every rank
  integer, parameter :: max_condensed = 5000
  !> [bytes] largest memory for K^-1 B' on all ranks together
  real(rk), parameter :: max_response = 4.0e9_rk
  !> largest number of dofs, in the plane and in space, for one factorization; with more, multigrid needs less time and memory
  integer, parameter :: max_condensed_dofs(2:3) = [500000, 100000]
  !> largest number of dofs, in the plane and in space, for factorizations in each step; active_set with more of them gets
  !> multigrid from `auto`. In space both take equal time at 7 000 dofs; at 55 000 multigrid takes a third of the time
  integer, parameter :: max_factored(2:3) = [500000, 15000]
  !> smallest number of points for which K^-1 B' is cheaper than factorizations in each step
  integer, parameter :: min_sweep = 4

contains

  !> Chooses solver and linear solver: those of the deck, or for `auto` by `sizes`, among them the number of points with one
  !> stiffness. message is allocated if the deck asks for something that is not possible: condensed with more than 5000 multipliers,
  !> snesvi where only contact holds a body, or snesvi with gamg and a PETSc before 3.19. Otherwise it is not allocated.
  subroutine make_solver_plan(config, sizes, plan, message)
    !> section solver of the deck
    type(solver_config_t), intent(in) :: config
    type(problem_size_t), intent(in) :: sizes
    type(solver_plan_t), intent(out) :: plan
    !> sentence for the user
    character(:), allocatable, intent(out) :: message

    plan%type = config%type
    plan%linear = config%linear
    plan%may_factor = config%linear /= 'gamg' .and. sizes%n_dofs <= max_condensed_dofs(sizes%n_dim)
    plan%why = 'as the deck says'
    if (plan%type == 'auto') call choose_type(config%linear, sizes, plan)
    if (plan%linear == 'auto') call choose_linear(sizes, plan)
    if (plan%type == 'condensed' .and. sizes%n_multipliers > max_condensed) then
      message = 'condensed can take at most ' // to_text(max_condensed) // &
        ' multipliers, because its matrix is dense; the problem has ' // to_text(sizes%n_multipliers) // &
        '; solver.type must be active_set, snesvi or auto'
    else if (plan%type == 'snesvi' .and. sizes%is_floating) then
      message = 'snesvi cannot solve a problem in which contact alone holds a body; ' // &
        'solver.type must be active_set, condensed or auto'
    else if (plan%type == 'snesvi' .and. plan%linear == 'gamg' .and. .not. sizes%has_multigrid_vi) then
      message = 'snesvi needs PETSc 3.19 or later for gamg; solver.linear must be cholesky, or solver.type active_set'
    end if
  end subroutine make_solver_plan

  pure subroutine choose_type(linear, sizes, plan)
    !> linear solver that the deck asks for
    character(*), intent(in) :: linear
    type(problem_size_t), intent(in) :: sizes
    type(solver_plan_t), intent(inout) :: plan

    plan%type = 'active_set'
    if (linear == 'gamg') then
      plan%why = 'gamg goes with active_set'
    else if (sizes%n_multipliers > max_condensed) then
      plan%why = to_text(sizes%n_multipliers) // ' multipliers are too many for a dense matrix'
    else if (8.0_rk * sizes%n_dofs * sizes%n_multipliers > max_response .or. &
      sizes%n_dofs > max_condensed_dofs(sizes%n_dim)) then
      plan%why = to_text(sizes%n_dofs) // ' dofs are too many to factor the stiffness and keep the response to each multiplier'
    else if (sizes%n_points < min_sweep) then
      plan%why = 'fewer than ' // to_text(min_sweep) // &
        ' points with one stiffness do not pay for the response to each multiplier'
    else
      plan%type = 'condensed'
      plan%why = to_text(sizes%n_points) // ' points share one factorization'
    end if
  end subroutine choose_type

  !> Whether W and the responses to all multipliers are small enough for the condensed solver: at most 5000 multipliers, and 4e9
  !> bytes for all copies of the responses together.
  pure logical function fits_condensed(n_dofs, n_multipliers, n_copies)
    integer, intent(in) :: n_dofs
    integer, intent(in) :: n_multipliers
    !> how many times the responses are kept: on how many ranks, times for how many stiffnesses; default: 1
    real(rk), intent(in), optional :: n_copies
    real(rk) :: response_size

    response_size = 8.0_rk * n_dofs * n_multipliers
    if (present(n_copies)) response_size = response_size * n_copies
    fits_condensed = n_multipliers <= max_condensed .and. response_size <= max_response
  end function fits_condensed

  pure subroutine choose_linear(sizes, plan)
    type(problem_size_t), intent(in) :: sizes
    type(solver_plan_t), intent(inout) :: plan

    plan%linear = 'cholesky'
    if (plan%type /= 'active_set' .or. sizes%n_dofs <= max_factored(sizes%n_dim)) return
    plan%linear = 'gamg'
    plan%why = plan%why // '; multigrid takes less time than factorizations of ' // to_text(sizes%n_dofs) // ' dofs'
  end subroutine choose_linear

  !> Returns the plan as text for the log, as `solver: active_set, gamg: why`.
  pure function plan_text(plan) result(text)
    type(solver_plan_t), intent(in) :: plan
    character(:), allocatable :: text

    text = 'solver: ' // plan%type // ', ' // plan%linear // ': ' // plan%why
  end function plan_text
end module sig_solver_plan
