! SPDX-License-Identifier: BSD-3-Clause
!> Plans the stages of a study together: its sampling, training and validation share one solver. A condensed model needs the
!> response to each multiplier, so a solver that has them may serve all points. Predicts what each stage takes.
module sig_study_plan
  use sig_condensed_plan, only: choose_model_kind, displacement_plan_t, inelastic_model_size, inelastic_training_size, law_place, &
    model_size, most_references, number_size, plan_displacements, room_of, usual_modes
  use sig_deck_config, only: deck_config_t, point_set_config_t, value_config_t
  use sig_errors, only: error_t, make_error
  use sig_kinds, only: rk
  use sig_materials, only: most_chosen_states
  use sig_memory, only: memory_text
  use sig_parameter_space, only: build_states
  use sig_problem, only: problem_t
  use sig_progress, only: duration_text
  use sig_solver_costs, only: comparison_cost, condensed_cost, cost_t, multigrid_cost, operator(+), point_cost, &
    problem_size_t, solves_cost, steps_cost, times
  use sig_solver_plan, only: make_solver_plan, sweep_cost
  use sig_text, only: append_text, counted, join, string_t, to_text
  implicit none(type, external)
  private
  public :: check_training_memory, forget_training, plan_study, stage_lines

contains

  !> Chooses the solver again (make_solver_plan) for all points of the study, and how many groups of ranks solve them where the deck
  !> leaves it open (groups: auto): with the condensed solver all ranks work together if this is faster, else each rank alone. The
  !> choice of the deck stays. Does nothing where elastic constants vary. Local; the same on all ranks.
  subroutine plan_study(problem)
    type(problem_t), intent(inout) :: problem
    character(:), allocatable :: kind, message, reason
    integer :: n_test, n_training

    call count_points(problem%deck, n_training, n_test)
    if (.not. problem%has_fixed_stiffness .or. n_training + n_test == 0) return
    call choose_model_kind(problem, kind, reason)
    problem%sizes%needs_responses = kind == 'condensed' .and. problem%deck%has_training
    if (problem%sizes%needs_responses) call plan_boundaries(problem)
    problem%sizes%n_points = n_training + n_test
    ! the deck's own choice has been accepted when the problem was loaded
    call make_solver_plan(problem%deck%solver, problem%sizes, problem%plan, message)
    if (problem%plan%type /= 'condensed' .or. .not. one_group_is_faster(problem%sizes)) return
    if (problem%deck%training%n_groups == 0) problem%deck%training%n_groups = 1
    if (problem%deck%test%n_groups == 0) problem%deck%test%n_groups = 1
  end subroutine plan_study

  !> Lets the elimination for W give the displacements of the boundaries that the deck names, too, if it has room for them. A note
  !> or a warning says so.
  subroutine plan_boundaries(problem)
    type(problem_t), intent(inout) :: problem
    type(displacement_plan_t) :: displacements

    displacements = plan_displacements(problem)
    if (displacements%misses /= '') call append_text(problem%warnings, displacements%misses)
    if (.not. displacements%is_eliminated) return
    problem%sizes%keeps_named_dofs = .true.
    problem%elimination%dofs = displacements%exact_dofs
    call append_text(problem%notes, 'exact displacements of ' // join(displacements%boundaries, ', ') // ' come with the ' // &
      'elimination of the others: ' // to_text(problem%sizes%n_named_dofs) // ' dofs stay beside ' // &
      counted(problem%sizes%n_multipliers, 'contact force'))
  end subroutine plan_boundaries

  !> Leaves out what only the training of a model needs from the solvers, for stages behind it.
  subroutine forget_training(problem)
    type(problem_t), intent(inout) :: problem

    problem%sizes%keeps_named_dofs = .false.
    problem%elimination%dofs = [integer ::]
  end subroutine forget_training

  !> Counts the points that sampling solves (a greedy selection at most, candidates of clusters, too) and the test points. Sets that
  !> cannot be read count 0.
  subroutine count_points(deck, n_training, n_test)
    type(deck_config_t), intent(in) :: deck
    integer, intent(out) :: n_training
    integer, intent(out) :: n_test

    n_training = 0
    n_test = 0
    if (deck%has_training) n_training = min(n_points_of(deck, deck%training), most_chosen_states(deck))
    if (deck%clusters%target%is_used) n_training = n_training + n_points_of(deck, deck%clusters%target%candidates)
    if (deck%has_test) n_test = n_points_of(deck, deck%test)
  end subroutine count_points

  integer function n_points_of(deck, point_set) result(n)
    type(deck_config_t), intent(in) :: deck
    type(point_set_config_t), intent(in) :: point_set
    type(error_t), allocatable :: error
    real(rk), allocatable :: points(:, :)

    n = 0
    call build_states(deck, point_set, points, error)
    if (allocated(error)) return
    n = size(points, 2)
  end function n_points_of

  !> Whether all ranks together make the responses sooner than each rank alone makes all of them. Alone, each solves its share of
  !> the points; together, all do the dense work of every point.
  pure logical function one_group_is_faster(sizes)
    type(problem_size_t), intent(in) :: sizes
    type(problem_size_t) :: alone
    type(cost_t) :: point, joint, single

    alone = sizes
    alone%n_ranks = 1
    point = point_cost(sizes)
    joint = condensed_cost(sizes)
    single = condensed_cost(alone)
    one_group_is_faster = joint%seconds + sizes%n_points * point%seconds < &
      single%seconds + sizes%n_points * point%seconds / sizes%n_ranks
  end function one_group_is_faster

  !> Returns sentences about what the stages of the study will take: the memory of the machine, the time and memory of each stage,
  !> and the size of the model file. There are none where elastic constants vary and no material flows, and training has none where
  !> it is hyper-reduction.
  !> Requires: plan_study.
  function stage_lines(problem) result(lines)
    type(problem_t), intent(in) :: problem
    type(string_t), allocatable :: lines(:)
    integer :: n_test, n_training
    character(:), allocatable :: kind, reason
    type(cost_t) :: cost
    allocate (lines(0))
    call count_points(problem%deck, n_training, n_test)
    if (.not. (problem%has_fixed_stiffness .or. problem%flow%is_there())) return
    call append_text(lines, 'memory: solvers may take ' // memory_text(problem%sizes%memory) // ' on all ranks together')
    if (problem%flow%is_there()) then
      call add_flow_lines(problem, n_training, n_test, lines)
      return
    end if
    if (n_training == 0) return
    call append_text(lines, room_text(problem))
    associate (plan => problem%plan, sizes => problem%sizes)
      cost = sweep_cost(plan%type, plan%linear, sizes, n_training)
      call append_text(lines, 'predicted: sampling of ' // counted(n_training, 'point') // ': ' // text_of(cost))
      call choose_model_kind(problem, kind, reason)
      if (kind == 'condensed') then
        cost = training_cost(problem)
        call append_text(lines, 'predicted: training: ' // text_of(cost) // '; model file of at most ' // &
          memory_text(model_size(problem)))
      else if (kind == 'tied') then
        call append_text(lines, 'model: ' // reason // '; unknowns only at contacts that change at the training points, and ' // &
          'around them (kind tied)')
      else if (kind == 'hhr' .and. reason /= '') then
        call append_text(lines, 'hyper-reduction (reduction.method: auto): ' // reason)
      end if
      if (n_test == 0) return
      if (plan%type == 'condensed') then
        cost = times(n_test, point_cost(sizes, plan%linear) + comparison_cost(sizes))
        cost%bytes = bytes_of_operator(problem)
      else
        cost = sweep_cost(plan%type, plan%linear, sizes, n_test)
      end if
      call append_text(lines, 'predicted: validation at ' // counted(n_test, 'point') // ': ' // text_of(cost))
    end associate
  end function stage_lines

  !> Returns how large a model may be, and how many contacts have room in it.
  function room_text(problem) result(text)
    type(problem_t), intent(in) :: problem
    character(:), allocatable :: text
    real(rk), parameter :: bytes_per_megabyte = 1.0e6_rk

    associate (reduction => problem%deck%reduction)
      text = 'memory: a model may take ' // memory_text(bytes_per_megabyte * reduction%max_full_order_size) // &
        ' (reduction.max_full_order_size), of this the matrix of all contacts ' // &
        memory_text(bytes_per_megabyte * room_of(problem)) // ', which is enough for ' // &
        counted(int(sqrt(room_of(problem) / number_size)), 'contact row')
    end associate
  end function room_text

  !> Appends what the stages take where materials flow; times of histories are rough, because steps that do not converge are cut.
  subroutine add_flow_lines(problem, n_training, n_test, lines)
    type(problem_t), intent(in) :: problem
    integer, intent(in) :: n_training
    integer, intent(in) :: n_test
    type(string_t), allocatable, intent(inout) :: lines(:)
    type(cost_t) :: cost

    associate (sizes => problem%sizes)
      call append_text(lines, 'materials yield or creep at ' // counted(sizes%n_flow_points, 'integration point'))
      if (n_training == 0) return
      call append_text(lines, 'predicted, roughly: sampling of ' // counted(n_training, 'state') // ': ' // &
        text_of(states_cost(problem, n_training)))
      cost = condensed_cost(sizes)
      cost%bytes = cost%bytes + sizes%n_ranks * inelastic_training_size(problem, n_training)
      call append_text(lines, 'predicted: memory for training: ' // memory_text(cost%bytes) // '; model file of about ' // &
        memory_text(inelastic_model_size(problem)) // ' or less')
      if (n_test > 0) call append_text(lines, 'predicted, roughly: validation at ' // counted(n_test, 'state') // ': ' // &
        text_of(states_cost(problem, n_test)))
    end associate
  end subroutine add_flow_lines

  !> Returns the cost of states of histories where materials flow. Each stiffness has some of them.
  type(cost_t) function states_cost(problem, n_states) result(cost)
    type(problem_t), intent(in) :: problem
    integer, intent(in) :: n_states

    associate (plan => problem%plan, n_at_once => max(1, min(n_states, problem%sizes%n_points)))
      cost = times(max(1, n_states / n_at_once), sweep_cost(plan%type, plan%linear, problem%sizes, n_at_once))
    end associate
  end function states_cost

  !> Errors: materials flow, and the training of a model takes more memory than the ranks have. Requires: plan_study.
  subroutine check_training_memory(problem, error)
    type(problem_t), intent(in) :: problem
    type(error_t), allocatable, intent(out) :: error
    type(value_config_t) :: place
    real(rk) :: n_bytes
    integer :: n_test, n_training

    if (.not. problem%flow%is_there()) return
    call count_points(problem%deck, n_training, n_test)
    n_bytes = problem%sizes%n_ranks * inelastic_training_size(problem, n_training)
    if (n_bytes <= problem%sizes%memory) return
    place = law_place(problem%deck)
    call make_error(error, 'materials yield or creep, but the training of their model takes ' // memory_text(n_bytes) // &
      ' on all ranks, for strains and stresses of ' // counted(problem%force_rows%n_rows, 'contact force') // ' and ' // &
      to_text(n_training) // ' states at ' // counted(problem%sizes%n_flow_points, 'integration point') // &
      '; there is room for ' // memory_text(problem%sizes%memory), problem%deck%path, place%line, place%column, &
      hint='take fewer ranks, training points or times, or a coarser mesh where materials flow; the command solve needs no model')
  end subroutine check_training_memory

  !> Returns the cost of training a condensed model: the responses, unless sampling has made them, the pivot transforms, the model
  !> on every rank, and the compression of displacements, for which the responses are computed once more. Where few modes are
  !> enough, there is no compression; that is known only then.
  type(cost_t) function training_cost(problem) result(cost)
    type(problem_t), intent(in) :: problem
    !> [s] for each number of the responses
    real(rk), parameter :: per_compressed_number = 3.0e-7_rk
    type(displacement_plan_t) :: displacements
    type(cost_t) :: responses

    associate (sizes => problem%sizes)
      ! pivot transforms, which models with friction or ties do without
      cost = times(most_references, point_cost(sizes))
      if (.not. sizes%has_plain_contact) cost = steps_cost(sizes)
      cost%bytes = bytes_of_operator(problem) + sizes%n_ranks * model_size(problem)
      if (problem%plan%type /= 'condensed') cost = cost + condensed_cost(sizes, linear_of_operator(problem))
      displacements = plan_displacements(problem)
      if (.not. displacements%has_modes) return
      if (linear_of_operator(problem) == 'gamg') then
        cost = cost + multigrid_cost(sizes, usual_modes, 1)
      else
        responses = solves_cost(sizes, sizes%n_multipliers)
        cost%seconds = cost%seconds + responses%seconds + per_compressed_number * sizes%n_dofs * real(sizes%n_multipliers, rk)
      end if
    end associate
  end function training_cost

  !> [byte] Returns the memory of the condensed operator.
  pure real(rk) function bytes_of_operator(problem) result(n_bytes)
    type(problem_t), intent(in) :: problem
    type(cost_t) :: cost

    cost = condensed_cost(problem%sizes, linear_of_operator(problem))
    n_bytes = cost%bytes
  end function bytes_of_operator

  !> Returns how the condensed operator solves linear systems: cholesky or gamg.
  pure function linear_of_operator(problem) result(linear)
    type(problem_t), intent(in) :: problem
    character(:), allocatable :: linear

    linear = trim(merge('cholesky', 'gamg    ', problem%plan%may_factor))
    if (problem%plan%type == 'condensed') linear = problem%plan%linear
  end function linear_of_operator

  !> Returns a cost as text: `12 s, 1.3 GB`.
  function text_of(cost) result(text)
    type(cost_t), intent(in) :: cost
    character(:), allocatable :: text

    text = duration_text(cost%seconds) // ', ' // memory_text(cost%bytes)
  end function text_of
end module sig_study_plan
