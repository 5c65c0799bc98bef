! SPDX-License-Identifier: BSD-3-Clause
!> Queries of a model at parameter points: the chosen part answers, or the fallback where that part has no answer, and an error
!> bound is added.
module sig_query
  use sig_answer, only: answer_t
  use sig_gradient, only: gradient_t
  use sig_history, only: table_values_t
  use sig_kinds, only: rk
  use sig_model, only: model_t
  use sig_online_model, only: online_model_t
  use sig_reasons, only: reason_bad_point, reason_bad_term, reason_converged, reason_driven, reason_large_bound, &
    reason_needs_history
  use sig_reduced, only: neighbors_t
  use sig_rooms, only: rooms_t
  use sig_term_derivatives, only: differentiate_terms, term_failure_t
  use sig_term_set, only: term_set_t
  use sig_term_values, only: term_values_t
  use sig_text, only: counted, short_number, to_text
  implicit none(type, external)
  private
  public :: query_t

  !> Work arrays and expressions of one thread. After the first answers a query allocates only temporary arrays, which it frees.
  type :: query_t
    private
    type(term_values_t) :: terms
    !> tables of the model's history, and the parameters of the present one with the last time that was asked
    type(table_values_t) :: tables
    real(rk), allocatable :: parameters(:)
    real(rk) :: time = 0
    !> [time] of the state before the one that is asked; 0 at the beginning of a history
    real(rk) :: time_before = 0
    !> why the last time of a history that remembers has no answer; 0 if it has one
    integer :: failure = 0
    !> answer_t%flaw of that time
    integer :: flaw(2) = 0
    !> the last answer is that of advance with the model's own tables
    logical :: follows_tables = .false.
    type(rooms_t) :: rooms
  contains
    procedure :: create
    procedure :: leave_out_points
    procedure :: evaluate
    procedure :: continue
    procedure :: end_history
    procedure :: start
    procedure :: advance
    procedure :: save_memory
    procedure :: restore_memory
    procedure :: differentiate
    procedure :: destroy
  end type query_t

contains

  !> Prepares queries of one thread: compiles the expressions of the terms, and makes the work arrays of all parts. What an earlier
  !> call made is freed. Errors: message is allocated when an expression of a term, or of its window, is not valid.
  subroutine create(self, online, message)
    class(query_t), intent(inout) :: self
    !> the model, after prepare
    type(online_model_t), intent(in) :: online
    character(:), allocatable, intent(out) :: message
    integer :: i

    call self%destroy()
    call self%terms%create(online%model%terms, message)
    if (allocated(message)) return
    associate (model => online%model)
      if (model%history%is_there()) call self%tables%create(model%history, model%parameter_names(:model%n_given()), message)
    end associate
    if (allocated(message)) return
    do i = 1, size(online%model%parts)
      call self%rooms%enter(online%model, i)
    end do
  end subroutine create

  !> Leaves the inelastic strains at integration points out of the answers: only fields need them, and where materials flow they
  !> take most of the time. Requires: create, before the first answer.
  subroutine leave_out_points(self)
    class(query_t), intent(inout) :: self

    call self%rooms%leave_out_points()
  end subroutine leave_out_points

  !> Answers at one point, inside or outside of the trained box. The cluster answers; or the fallback, if the cluster has no answer
  !> or the relative bound of its answer exceeds the model's max_error. An answer without a bound is accepted, and any answer if
  !> max_error is 0. The bound of an answer of the fallback is not compared with max_error. answer%reason > 0 says that there is an
  !> answer. Otherwise it says why there is none; among others reason_bad_point: the number of values is wrong; reason_bad_term: a
  !> term has no finite value; reason_driven: loads drive a body in a motion that nothing holds; reason_large_bound: the bound is
  !> too large and there is no fallback; reason_needs_history: the model has a history and remembers, so that a state alone says
  !> too little. A model with friction that has no history starts from the state before anything has happened.
  subroutine evaluate(self, online, point, answer, cluster)
    class(query_t), intent(inout) :: self
    !> the model that create was called with
    type(online_model_t), intent(in) :: online
    !> [unit of each parameter] values of the parameters in the model's order
    real(rk), intent(in) :: point(:)
    !> out: everything; its arrays are used again if their sizes fit
    type(answer_t), intent(inout) :: answer
    !> number of the cluster that is asked first, 1-based; default: the model's choice at the point
    integer, intent(in), optional :: cluster

    self%failure = 0
    ! a point alone is no step of a history, and a history that has begun goes on behind it
    self%time_before = self%time
    if (online%model%remembers()) then
      call self%rooms%forget(online%model)
      if (online%model%history%is_there()) self%failure = reason_needs_history
    end if
    call answer_state(self, online, point, answer, cluster)
  end subroutine evaluate

  !> Answers the next state of a list in which the states of each history follow each other: a state whose parameters differ from
  !> those before it, or whose time is not later, begins a history. Where nothing remembers, this is evaluate.
  subroutine continue(self, online, point, answer)
    class(query_t), intent(inout) :: self
    type(online_model_t), intent(in) :: online
    !> [unit of each parameter] parameters, time, tables
    real(rk), intent(in) :: point(:)
    type(answer_t), intent(inout) :: answer

    associate (model => online%model)
      if (.not. (model%remembers() .and. model%history%is_there() .and. size(point) == size(model%parameter_names))) then
        call self%evaluate(online, point, answer)
        return
      end if
      self%time_before = self%time
      if (.not. goes_on(self, point(:model%n_given()), point(model%i_time()))) then
        self%parameters = point(:model%n_given())
        self%time_before = 0
        self%failure = 0
        call self%rooms%forget(model)
      end if
      self%time = point(model%i_time())
    end associate
    call answer_state(self, online, point, answer)
  end subroutine continue

  !> Ends a history: the next state of `continue` begins one.
  pure subroutine end_history(self)
    class(query_t), intent(inout) :: self

    if (allocated(self%parameters)) deallocate (self%parameters)
  end subroutine end_history

  pure logical function goes_on(self, parameters, time)
    class(query_t), intent(in) :: self
    real(rk), intent(in) :: parameters(:)
    real(rk), intent(in) :: time

    goes_on = allocated(self%parameters)
    if (goes_on) goes_on = size(self%parameters) == size(parameters) .and. time > self%time
    if (goes_on) goes_on = .not. any(abs(self%parameters - parameters) > 0)
  end function goes_on

  !> Answers a state. Where contacts remember, it is the next one of its history; after a state without an answer there are none.
  subroutine answer_state(self, online, point, answer, cluster)
    class(query_t), intent(inout) :: self
    !> the model that create was called with
    type(online_model_t), intent(in) :: online
    !> [unit of each parameter] values of the parameters in the model's order
    real(rk), intent(in) :: point(:)
    !> out: everything; its arrays are used again if their sizes fit
    type(answer_t), intent(inout) :: answer
    !> number of the cluster that is asked first, 1-based; default: the model's choice at the point
    integer, intent(in), optional :: cluster
    type(neighbors_t) :: near
    integer :: i_cluster, i_source
    logical :: is_valid

    self%follows_tables = .false.
    i_cluster = 1
    if (size(point) == size(online%model%box, 2)) i_cluster = online%model%choice%cluster_of(point)
    if (present(cluster)) i_cluster = cluster
    associate (part => online%model%parts(i_cluster)%reduced)
      call answer%start(i_cluster, online%model%terms%n_terms(), part%n_modes(), part%n_rows(), online%model%n_multipliers)
      if (size(point) /= size(online%model%box, 2)) then
        answer%reason = reason_bad_point
        return
      end if
      answer%is_inside_box = online%is_inside_box(point)
      call online%nearest_point(point, near%nearest, answer%distance)
      if (part%starts_from_two_sides()) call online%opposite_point(point, near%nearest, near%opposite)
    end associate
    call self%terms%evaluate(point, answer%theta, is_valid, i_source)
    answer%reason = merge(reason_converged, reason_bad_term, is_valid)
    if (is_valid) then
      if (.not. online%model%idle_work%is_zero(answer%theta)) answer%reason = reason_driven
    end if
    if (self%failure /= 0) then
      answer%reason = self%failure
      answer%flaw = self%flaw
    end if
    if (answer%reason > 0) then
      call self%rooms%begin_step(online%model, point, self%time - self%time_before)
      call answer_at(self, online, near, answer)
    end if
    if (answer%reason <= 0 .and. online%model%remembers()) then
      self%failure = answer%reason
      self%flaw = answer%flaw
    end if
  end subroutine answer_state

  !> Begins a history at the time 0, where nothing has happened yet. Errors: message is allocated if the model has no history, the
  !> number of values is wrong, or a table is not valid at the point.
  subroutine start(self, online, parameters, message)
    class(query_t), intent(inout) :: self
    !> the model that create was called with
    type(online_model_t), intent(in) :: online
    !> [unit of each parameter] without time and tables, shape (n_given)
    real(rk), intent(in) :: parameters(:)
    character(:), allocatable, intent(out) :: message
    integer :: i_table

    if (allocated(self%parameters)) deallocate (self%parameters)
    associate (model => online%model)
      if (.not. model%history%is_there()) then
        message = 'the model has no history: its deck has no times'
      else if (size(parameters) /= model%n_given()) then
        message = 'the model has ' // counted(model%n_given(), 'parameter') // ', not ' // to_text(size(parameters))
      else
        call self%tables%begin(parameters, i_table, message)
        if (i_table > 0) message = 'the table ''' // model%history%tables(i_table)%name // ''' ' // message
      end if
    end associate
    if (allocated(message)) return
    self%parameters = parameters
    self%time = 0
    self%failure = 0
    call self%rooms%forget(online%model)
  end subroutine start

  !> Answers the next time of a history, which need not be a time of the deck's steps. Where nothing remembers, the answer is that
  !> of evaluate at the state. Errors: message is allocated without start, if the time is not later than the one before, or if there
  !> are values for another number of tables; then nothing is asked.
  subroutine advance(self, online, time, answer, state, message, tables)
    class(query_t), intent(inout) :: self
    !> the model that create was called with
    type(online_model_t), intent(in) :: online
    !> [unit of time]
    real(rk), intent(in) :: time
    !> out: everything, as of evaluate
    type(answer_t), intent(inout) :: answer
    !> the state that was asked: parameters, time, tables
    real(rk), allocatable, intent(inout) :: state(:)
    character(:), allocatable, intent(out) :: message
    !> values of all tables at this time; default: those of the model's tables
    real(rk), intent(in), optional :: tables(:)

    if (.not. allocated(self%parameters)) then
      message = 'no history has begun: start comes first'
    else if (.not. time > self%time) then
      message = 'the time ' // short_number(time) // ' is not later than ' // short_number(self%time) // &
        ', which was asked before'
    else if (present(tables)) then
      if (size(tables) /= size(online%model%history%tables)) message = 'the model has ' // &
        counted(size(online%model%history%tables), 'table') // ', not ' // to_text(size(tables))
    end if
    if (allocated(message)) return
    state = [self%parameters, self%tables%at(time)]
    if (present(tables)) state(size(self%parameters) + 2:) = tables
    self%time_before = self%time
    self%time = time
    call answer_state(self, online, state, answer)
    self%follows_tables = .not. present(tables)
  end subroutine advance

  !> Gives what the next time of the history depends on: the time, the parameters, and what contacts remember. Errors: message is
  !> allocated if no history has begun, or if its last time has no answer.
  subroutine save_memory(self, online, numbers, message)
    class(query_t), intent(in) :: self
    !> the model that create was called with
    type(online_model_t), intent(in) :: online
    !> shape (n_remembered of the model)
    real(rk), intent(inout) :: numbers(:)
    character(:), allocatable, intent(out) :: message

    if (size(numbers) == 0) return
    if (.not. allocated(self%parameters)) then
      message = 'no history has begun: start comes first'
    else if (self%failure /= 0) then
      message = 'the last time of the history has no answer, so that there is nothing to go on from'
    end if
    if (allocated(message)) return
    associate (n => size(self%parameters))
      numbers(1) = self%time
      numbers(2:n + 1) = self%parameters
      call self%rooms%save_memory(online%model, numbers(n + 2:))
    end associate
  end subroutine save_memory

  !> Goes back to where save_memory gave these numbers, perhaps in another query of the same model: advance goes on from there.
  !> Derivatives of later answers take what is remembered as given. Errors: message is allocated if these are no such numbers; then
  !> no history has begun.
  subroutine restore_memory(self, online, numbers, message)
    class(query_t), intent(inout) :: self
    !> the model that create was called with
    type(online_model_t), intent(in) :: online
    !> shape (n_remembered of the model)
    real(rk), intent(in) :: numbers(:)
    character(:), allocatable, intent(out) :: message
    logical :: is_valid

    if (size(numbers) == 0) return
    associate (n => online%model%n_given())
      call self%start(online, numbers(2:n + 1), message)
      if (allocated(message)) return
      call self%rooms%restore_memory(online%model, numbers(n + 2:), is_valid)
      self%time = numbers(1)
      if (is_valid .and. self%time >= 0) return
      deallocate (self%parameters)
      message = 'the memory is none of this model: its numbers are not possible'
    end associate
  end subroutine restore_memory

  !> Computes the derivatives of an answer with respect to each parameter. After advance with the model's own tables, those with
  !> respect to a parameter of the deck or the time contain what the tables change; otherwise each value of a state stands for
  !> itself. They belong to gradient%answer: this is `answer`, or, if
  !> the part that answered is not exact, the answer of the fallback at the point, if there is one.
  !>
  !> Errors: message is allocated, and `gradient` is of no use, when a term jumps at the point, has no finite slope there, or has no
  !> value on the side of `direction`; when the part has no derivatives; or when the contact forces are not unique or the problem of
  !> the contacts that graze has no solution (differentiate_lcp).
  subroutine differentiate(self, online, point, answer, direction, gradient, message)
    class(query_t), intent(inout) :: self
    !> the model that create was called with
    type(online_model_t), intent(in) :: online
    !> the point that evaluate was called with
    real(rk), intent(in) :: point(:)
    !> answer of evaluate, with reason > 0
    type(answer_t), intent(in) :: answer
    !> +1: towards larger values of each parameter; -1: towards smaller ones
    integer, intent(in) :: direction
    type(gradient_t), intent(inout) :: gradient
    character(:), allocatable, intent(out) :: message
    character(:), allocatable :: fault
    logical :: is_kink(size(point))
    integer :: i
    type(term_failure_t) :: failure

    call choose_answer(self, online, point, answer, gradient%answer)
    gradient%direction = direction
    gradient%n_given = online%model%n_given()
    gradient%lengths = online%lengths_at(point)
    if (allocated(gradient%theta)) deallocate (gradient%theta)
    allocate (gradient%theta(size(answer%theta), size(point)))
    if (self%follows_tables) then
      call differentiate_terms(self%terms, point, answer%theta, gradient%lengths, direction, gradient%theta, is_kink, failure, &
        self%tables)
      call self%tables%begin(self%parameters, i, fault)
    else
      call differentiate_terms(self%terms, point, answer%theta, gradient%lengths, direction, gradient%theta, is_kink, failure)
    end if
    gradient%is_one_sided = is_kink
    i = failure%i_parameter
    if (i > 0) then
      call explain(online%model%terms, failure, message)
    else
      i = first_driving(online%model, gradient%theta)
      if (i > 0) message = 'there is no derivative: as ''' // online%model%parameter_names(i)%text // &
        ''' passes this point, the loads drive a body in a motion that nothing holds'
    end if
    if (i > 0) then
      ! a history with friction goes on with derivatives over what is the same at all of its times
      if (i <= gradient%n_given .or. .not. online%model%remembers()) return
      gradient%theta(:, gradient%n_given + 1:) = 0
    end if
    associate (part => gradient%answer%part)
      call online%model%parts(part)%reduced%differentiate(gradient%answer, gradient, fault, self%rooms%of_part(part)%room)
    end associate
    if (.not. allocated(message) .and. allocated(fault)) call move_alloc(fault, message)
  end subroutine differentiate

  !> Returns the first parameter with which loads change that drive a body in a motion that nothing holds; 0 = none.
  pure integer function first_driving(model, theta) result(i)
    type(model_t), intent(in) :: model
    !> derivatives of the terms, shape (n_terms, n_parameters)
    real(rk), intent(in) :: theta(:, :)

    do i = 1, size(theta, 2)
      if (.not. model%idle_work%is_zero(theta(:, i))) return
    end do
    i = 0
  end function first_driving

  !> Says which term or source has no derivative, and over which parameter.
  pure subroutine explain(terms, failure, message)
    type(term_set_t), intent(in) :: terms
    type(term_failure_t), intent(in) :: failure
    character(:), allocatable, intent(out) :: message

    message = 'there is no derivative: as ''' // terms%parameter_names(failure%i_parameter)%text // ''' passes this point, '''
    if (failure%i_source > 0) then
      associate (source => terms%sources(failure%i_source))
        message = message // source%text // ''''
        if (len(source%minimum) + len(source%maximum) > 0) message = message // ', or a bound of its window,'
      end associate
      message = message // ' has no value on the side of this direction'
    else
      message = message // terms%names(failure%i_term)%text // ''' jumps or has no finite slope'
    end if
    message = message // '; the other direction may have a derivative'
  end subroutine explain

  !> Chooses the answer to differentiate: `answer` if the part that answered is exact (is_exact), if the model has no fallback, or
  !> if the fallback has no answer at the point; otherwise the answer of the fallback, without a bound of its forces. A
  !> hyper-reduced answer has an error of its own, and its reconstructed forces have kinks where snapshots enter or leave the
  !> combination. The fallback gives the derivatives of the full-order problem.
  subroutine choose_answer(self, online, point, answer, chosen)
    class(query_t), intent(inout) :: self
    type(online_model_t), intent(in) :: online
    real(rk), intent(in) :: point(:)
    type(answer_t), intent(in) :: answer
    type(answer_t), intent(inout) :: chosen
    type(neighbors_t) :: near
    integer :: i

    chosen = answer
    i = online%model%fallback()
    if (i == 0 .or. online%model%parts(answer%part)%reduced%is_exact()) return
    associate (part => online%model%parts(i)%reduced)
      call chosen%start(i, size(answer%theta), part%n_modes(), part%n_rows(), online%model%n_multipliers)
      chosen%theta = answer%theta
      chosen%is_inside_box = answer%is_inside_box
      call online%nearest_point(point, near%nearest, chosen%distance)
      call part%solve(chosen%theta, near, self%rooms%of_part(i)%room, chosen)
    end associate
    if (chosen%reason <= 0) chosen = answer
  end subroutine choose_answer

  !> Answers by the cluster answer%cluster, or by the fallback if the cluster has no answer or the relative bound of its answer is
  !> too large (is_certain). Without a fallback such a point has no answer: answer%reason is the cluster's, or reason_large_bound.
  !> Requires: answer%start was called, and answer%theta is set.
  subroutine answer_at(self, online, near, answer)
    class(query_t), intent(inout) :: self
    type(online_model_t), intent(in) :: online
    type(neighbors_t), intent(in) :: near
    type(answer_t), intent(inout) :: answer
    integer :: fallback

    fallback = online%model%fallback()
    associate (part => online%model%parts(answer%cluster)%reduced, room => self%rooms%of_part(answer%cluster)%room)
      if (fallback > 0) then
        call part%solve(answer%theta, near, room, answer, online%model%parts(fallback)%reduced)
      else
        call part%solve(answer%theta, near, room, answer)
      end if
    end associate
    if (answer%reason > 0) call certify(self, online, answer)
    if (answer%reason > 0 .and. is_certain(online, answer)) return
    if (fallback > 0) then
      call fall_back(self, online, near, answer)
    else if (answer%reason > 0) then
      answer%reason = reason_large_bound
    end if
    if (answer%reason > 0) return
    answer%n_solutions = 0
    answer%n_free_motions = 0
  end subroutine answer_at

  !> Whether the relative bound is at most max_error; true also without a bound, or if max_error is 0. An answer without a bound is
  !> not refused: the user is told that it has none.
  pure logical function is_certain(online, answer)
    type(online_model_t), intent(in) :: online
    type(answer_t), intent(in) :: answer

    is_certain = online%model%max_error <= 0 .or. answer%relative_bound <= online%model%max_error
  end function is_certain

  !> Bounds the answer's error by the part that answered or, if this part cannot (can_certify), by the fallback, if that can and the
  !> model has a limit (max_error > 0). If neither can, nothing changes. Otherwise the forces of all contacts are first
  !> reconstructed in answer%multipliers, if they are not there yet. If the fallback gives the bound, it corrects them before
  !> (correct_forces).
  subroutine certify(self, online, answer)
    class(query_t), intent(inout) :: self
    type(online_model_t), intent(in) :: online
    type(answer_t), intent(inout) :: answer
    integer :: i
    logical :: is_own

    is_own = online%model%parts(answer%part)%reduced%can_certify()
    i = answer%part
    if (.not. is_own) then
      i = online%model%fallback()
      if (i == 0 .or. online%model%max_error <= 0) return
      if (.not. online%model%parts(i)%reduced%can_certify()) return
    end if
    if (.not. answer%is_whole) then
      associate (part => online%model%parts(answer%part)%reduced)
        call part%fill_multipliers(answer, self%rooms%of_part(answer%part)%room, answer%multipliers)
      end associate
      answer%is_whole = .true.
    end if
    associate (part => online%model%parts(i)%reduced, room => self%rooms%of_part(i)%room)
      if (.not. is_own) call part%correct_forces(answer%theta, room, answer%multipliers)
      call part%certify(answer%multipliers, is_own, room, answer)
    end associate
  end subroutine certify

  !> Answers by the fallback. Bounds of the cluster's answer are dropped, and the numbers of iterations of both parts add up. If the
  !> fallback has no answer either, answer%reason is its reason. Otherwise the cluster's coordinates and forces of its domain become
  !> those under the fallback's forces (displace_under), and the displacement is the fallback's, or the cluster's if the fallback
  !> has none at all.
  subroutine fall_back(self, online, near, answer)
    class(query_t), intent(inout) :: self
    type(online_model_t), intent(in) :: online
    type(neighbors_t), intent(in) :: near
    type(answer_t), intent(inout) :: answer
    integer :: n_iterations

    n_iterations = answer%n_iterations
    answer%part = online%model%fallback()
    call answer%drop_bounds()
    associate (part => online%model%parts(answer%part)%reduced, room => self%rooms%of_part(answer%part)%room)
      call part%solve(answer%theta, near, room, answer)
      answer%n_iterations = n_iterations + answer%n_iterations
      if (answer%reason < 0) return
      call certify(self, online, answer)
      if (part%has_displacement()) answer%displacement_part = answer%part
    end associate
    associate (cluster => online%model%parts(answer%cluster)%reduced)
      call cluster%displace_under(self%rooms%of_part(answer%cluster)%room, answer)
    end associate
  end subroutine fall_back

  !> Frees the expressions and the work arrays; it may be called without create.
  subroutine destroy(self)
    class(query_t), intent(inout) :: self

    call self%terms%destroy()
    call self%tables%destroy()
    if (allocated(self%parameters)) deallocate (self%parameters)
    if (allocated(self%rooms%of_part)) deallocate (self%rooms%of_part)
  end subroutine destroy
end module sig_query
