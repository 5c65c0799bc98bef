! SPDX-License-Identifier: BSD-3-Clause
!> Walks through the states of a history of contact with friction, or with tied contacts.
module sig_friction_histories
  use sig_contact_state, only: contact_state_t
  use sig_friction_steps, only: friction_memory_t, friction_steps_t
  use sig_holding, only: anchors_t
  use sig_kinds, only: rk
  use sig_progress, only: progress_t
  use sig_reasons, only: reason_converged
  implicit none(type, external)
  private
  public :: solve_history

  !> [s] progress is told only if a history takes longer
  real(rk), parameter :: seconds_of_silence = 3

contains

  !> Solves the states of one history in their order, from the state before anything has happened. A state that has no answer gets
  !> the reason why, and the later states get the same reason. Local.
  subroutine solve_history(steps, anchors, openings, theta, counts_solutions, states, unknowns, latest, remembered)
    type(friction_steps_t), intent(in) :: steps
    type(anchors_t), intent(in) :: anchors
    !> [length] q of each state, shape (n_rows, n_times)
    real(rk), contiguous, intent(in) :: openings(:, :)
    !> [-] values of the terms in each state, shape (n_terms, n_times)
    real(rk), intent(in) :: theta(:, :)
    !> whether n_solutions of the states is looked for, and progress is told; else n_solutions stays 1
    logical, intent(in) :: counts_solutions
    !> get all but displacement and residuals; shape (n_times)
    type(contact_state_t), intent(inout) :: states(:)
    !> [force] multipliers, and in rows of anchors scaled openings (sig_condensed); shape (n_rows, n_times)
    real(rk), intent(out) :: unknowns(:, :)
    !> what the last step leaves (save of friction_memory_t); zero if it has no answer
    real(rk), intent(out) :: latest(:)
    !> what the steps before have left; not there: the history begins
    real(rk), intent(in), optional :: remembered(:)
    type(friction_memory_t) :: memory
    type(progress_t) :: progress
    integer :: i
    logical :: is_lost, is_valid

    if (counts_solutions) call progress%start('times with friction', size(states), seconds_of_silence)
    unknowns = 0
    is_lost = .false.
    call memory%begin(steps)
    if (present(remembered)) call memory%restore(steps, remembered, is_valid)
    do i = 1, size(states)
      associate (friction => steps%laws%friction_at(theta(:, i)))
        if (.not. is_lost) call steps%advance(openings(:, i), friction, memory)
        call take_answer(steps, anchors, friction, memory, states(i))
        if (counts_solutions) call progress%advance(i)
        is_lost = states(i)%reason /= reason_converged
        if (is_lost) cycle
        if (counts_solutions) states(i)%n_solutions = steps%count_answers(friction, memory)
        call steps%fill_unknowns(memory, unknowns(:, i))
      end associate
    end do
    latest = 0
    if (.not. is_lost) call memory%save(latest)
    if (counts_solutions) call progress%finish()
  end subroutine solve_history

  !> Copies the answer of the last step, or the reason why there is none, into a state.
  pure subroutine take_answer(steps, anchors, friction, memory, state)
    type(friction_steps_t), intent(in) :: steps
    type(anchors_t), intent(in) :: anchors
    !> [-] shape (n_contacts)
    real(rk), intent(in) :: friction(:)
    type(friction_memory_t), intent(in) :: memory
    type(contact_state_t), intent(inout) :: state
    integer :: k, n

    n = size(memory%slip)
    state%reason = memory%solution%reason
    state%n_iterations = memory%solution%n_steps
    state%multipliers = memory%solution%lambda(:n)
    state%friction = friction
    state%origins = memory%origins(:n)
    state%slip = memory%slip
    state%slips = steps%slipping(memory)
    allocate (state%is_active(n), source=.false.)
    associate (is_open => memory%is_open())
      do k = 1, steps%laws%n_contacts
        state%is_active(steps%laws%rows_of(k)) = .not. is_open(k)
      end do
    end associate
    ! the amplitudes close anchors
    if (state%reason /= reason_converged .and. size(anchors%rows) > 0) &
      state%drift = -matmul(anchors%amplitudes, steps%motion(memory))
  end subroutine take_answer
end module sig_friction_histories
