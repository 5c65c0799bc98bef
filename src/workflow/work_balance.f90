! SPDX-License-Identifier: BSD-3-Clause
!> The balance of work of each step of a history with friction.
!>
!> Between two times, forces change along a straight line: their work is the mean of both ends times the change of displacement. As
!> K u + B' lambda = F + R at both ends, the work of loads F and supports R is the change of the energy u . K u / 2 plus the work
!> that the mean contact forces do on the contacts,
!>
!>     mean(F) . du + mean(R) . du = dE + mean(lambda) . B du
!>
!> exactly but for rounding: `residual` is the difference, relative to the sum of the sizes of all products in it. What contacts
!> take is the work of friction, which the steps compute with the forces at their ends, the work against gaps that change,
!> mean(lambda) . dD, and an error of the time steps: half of the change of the friction force times the slip, and half of the
!> last force times the gap where a contact opens. It vanishes with the size of the steps: `time_error` is
!> mean(lambda) . B du - mean(lambda) . dD - friction.
!>
!> Imposed strains act by their forces, which are in F; then E is the energy of the displacement, not that of the stress. Before the
!> first time nothing is displaced or loaded, and overlaps are zero.
module sig_work_balance
  use sig_contact_rows, only: contact_rows_t
  use sig_contact_state, only: contact_state_t, flow_answer_t
  use sig_deck_units, only: moment_unit
  use sig_kinds, only: rk
  use sig_problem, only: problem_t
  use sig_reasons, only: reason_converged
  use sig_run_report, only: run_report_t
  use sig_term_values, only: evaluate_points
  use sig_text, only: to_text
  implicit none(type, external)
  private
  public :: report_work

  !> One end of a step.
  type :: work_end_t
    !> [length] shape (n_dofs)
    real(rk), allocatable :: displacement(:)
    !> [force] loads and forces of imposed strains; forces of the supports; same shape
    real(rk), allocatable :: loads(:)
    real(rk), allocatable :: reactions(:)
    !> [force] shape (n_rows)
    real(rk), allocatable :: multipliers(:)
    !> [length] D, in tangential rows the motion of the obstacle along the tangent; same shape
    real(rk), allocatable :: gap(:)
    !> [force*length] u . K u / 2
    real(rk) :: energy = 0
  end type work_end_t

  !> [force*length] Work of a step, as the head of this file says; residual is [-].
  type :: work_of_step_t
    real(rk) :: loads = 0
    real(rk) :: supports = 0
    real(rk) :: energy = 0
    real(rk) :: contact = 0
    real(rk) :: gaps = 0
    real(rk) :: friction = 0
    real(rk) :: time_error = 0
    real(rk) :: residual = 0
  end type work_of_step_t

contains

  !> Computes the work of a step from both of its ends.
  pure type(work_of_step_t) function balance_step(rows, old, new, slip) result(work)
    !> normal and tangential rows
    type(contact_rows_t), intent(in) :: rows
    type(work_end_t), intent(in) :: old
    type(work_end_t), intent(in) :: new
    !> [length] slip of the step in tangential rows, 0 in normal rows; shape (n_rows)
    real(rk), intent(in) :: slip(:)
    real(rk) :: mean(rows%n_rows), sizes

    sizes = abs(old%energy) + abs(new%energy)
    associate (moved => new%displacement - old%displacement)
      call mean_work(old%loads, new%loads, moved, work%loads, sizes)
      call mean_work(old%reactions, new%reactions, moved, work%supports, sizes)
      call mean_work(old%multipliers, new%multipliers, rows%apply(moved), work%contact, sizes)
    end associate
    mean = (new%multipliers + old%multipliers) / 2
    work%energy = new%energy - old%energy
    work%gaps = dot_product(mean, new%gap - old%gap)
    work%friction = dot_product(new%multipliers, slip)
    work%time_error = work%contact - work%gaps - work%friction
    if (sizes > 0) work%residual = abs(work%loads + work%supports - work%energy - work%contact) / sizes
  end function balance_step

  !> Computes the work of the mean of two forces, and adds the sizes of its products, without the cancellation in the mean.
  pure subroutine mean_work(old, new, moved, work, sizes)
    !> [force] at both ends
    real(rk), intent(in) :: old(:), new(:)
    !> [length] same shape
    real(rk), intent(in) :: moved(:)
    !> [force*length]
    real(rk), intent(out) :: work
    real(rk), intent(inout) :: sizes

    work = dot_product(old + new, moved) / 2
    sizes = sizes + dot_product(abs(old) + abs(new), abs(moved)) / 2
  end subroutine mean_work

  !> Adds the balance of work of all steps below points/<i>/work, and the unit of work. Does nothing where nothing remembers, and
  !> after a state of a history without a solution. Where materials flow, the solver has measured it. Local.
  subroutine report_work(problem, points, states, report)
    type(problem_t), intent(in) :: problem
    !> shape (n_parameters, n_points)
    real(rk), intent(in) :: points(:, :)
    !> shape (n_points)
    type(contact_state_t), intent(in) :: states(:)
    type(run_report_t), intent(inout) :: report
    type(work_end_t) :: new, old
    real(rk), allocatable :: theta(:, :)
    integer :: i, i_bad_point, i_bad_source, n_times

    if (.not. problem%remembers()) return
    call report%add('units/work', moment_unit(problem%deck))
    if (problem%flow%is_there()) then
      do i = 1, size(states)
        if (states(i)%reason == reason_converged) call report_flow(states(i)%flow, 'points/' // to_text(i) // '/work/', report)
      end do
      return
    end if
    call evaluate_points(problem%terms, points, theta, i_bad_point, i_bad_source)
    n_times = max(1, problem%deck%history%states%n_times())
    do i = 1, size(states)
      if (states(i)%reason /= reason_converged) cycle
      call take_end(problem, theta(:, i), states(i), new)
      if (modulo(i - 1, n_times) == 0) call begin(new, problem%rows%n_rows, old)
      call report_step(balance_step(problem%force_rows, old, new, states(i)%slip), 'points/' // to_text(i) // '/work/', report)
      old = new
    end do
  end subroutine report_work

  !> Collects the end of a step.
  subroutine take_end(problem, theta, state, end_of_step)
    type(problem_t), intent(in) :: problem
    !> [-] values of the terms, shape (n_terms)
    real(rk), intent(in) :: theta(:)
    type(contact_state_t), intent(in) :: state
    type(work_end_t), intent(inout) :: end_of_step

    end_of_step%displacement = state%displacement
    end_of_step%loads = problem%boundary%forces(theta)
    end_of_step%reactions = state%reactions
    end_of_step%multipliers = state%multipliers
    end_of_step%gap = matmul(problem%force_rows%gap, theta)
    end_of_step%energy = state%energy
  end subroutine take_end

  !> Makes the state before the first time.
  pure subroutine begin(first, n_normal, before)
    !> state at the first time
    type(work_end_t), intent(in) :: first
    !> number of normal rows
    integer, intent(in) :: n_normal
    type(work_end_t), intent(inout) :: before

    before = first
    before%displacement = 0
    before%loads = 0
    before%reactions = 0
    before%multipliers = 0
    before%gap(:n_normal) = max(first%gap(:n_normal), 0.0_rk)
    before%gap(n_normal + 1:) = 0
    before%energy = 0
  end subroutine begin

  !> Adds the work of a step where materials flow. The error of the time steps is what the mean stresses and contact forces do more
  !> than those at the end.
  subroutine report_flow(flow, group, report)
    type(flow_answer_t), intent(in) :: flow
    !> path of the keys, with its last slash
    character(*), intent(in) :: group
    type(run_report_t), intent(inout) :: report

    associate (work => flow%work)
      call report%add(group // 'loads', work%loads)
      call report%add(group // 'supports', work%supports)
      call report%add(group // 'energy', work%energy)
      call report%add(group // 'imposed_strains', work%imposed)
      call report%add(group // 'plastic', work%plastic)
      call report%add(group // 'creep', work%creep)
      call report%add(group // 'contact', work%contact)
      call report%add(group // 'gaps', work%gaps)
      call report%add(group // 'friction', work%friction)
      call report%add(group // 'time_error', work%inelastic - work%plastic - work%creep + work%contact - work%gaps - work%friction)
      call report%add(group // 'residual', flow%work_residual)
    end associate
  end subroutine report_flow

  subroutine report_step(work, group, report)
    type(work_of_step_t), intent(in) :: work
    !> path of the keys, with its last slash
    character(*), intent(in) :: group
    type(run_report_t), intent(inout) :: report

    call report%add(group // 'loads', work%loads)
    call report%add(group // 'supports', work%supports)
    call report%add(group // 'energy', work%energy)
    call report%add(group // 'contact', work%contact)
    call report%add(group // 'gaps', work%gaps)
    call report%add(group // 'friction', work%friction)
    call report%add(group // 'time_error', work%time_error)
    call report%add(group // 'residual', work%residual)
  end subroutine report_step
end module sig_work_balance
