! SPDX-License-Identifier: BSD-3-Clause
!> Steps of a history with friction by kept factors, and by factors that each step of Newton's method makes anew, on the matrix of a
!> condensed model; then whole queries of the model.
!>
!> Arguments: model.h5, times that are solved anew as well (the first ones; 0: all), values of the parameters.
program benchmark_friction
  use sig_answer, only: answer_t
  use sig_compliance, only: compliance_point_t
  use sig_condensed_model, only: condensed_model_t
  use sig_dense_kernels, only: add_few_columns
  use sig_errors, only: error_report, error_t
  use sig_friction_steps, only: friction_memory_t, friction_steps_t
  use sig_history, only: states_of
  use sig_kinds, only: rk
  use sig_model_file, only: read_model
  use sig_online_model, only: online_model_t
  use sig_query, only: query_t
  use sig_reasons, only: reason_converged
  use sig_term_values, only: evaluate_points
  implicit none(type, external)

  !> of one way to solve, at each time: CPU time [s], steps, operations, forces
  type :: course_t
    real(rk), allocatable :: seconds(:)
    !> CPU time [s] of one product of W and the forces
    real(rk), allocatable :: of_product(:)
    integer, allocatable :: n_steps(:)
    real(rk), allocatable :: operations(:)
    real(rk), allocatable :: forces(:, :)
  end type course_t

  !> a history is repeated until it has taken so long [s], and the shortest time of each state counts
  real(rk), parameter :: long_enough = 1
  character(1024) :: argument
  character(:), allocatable :: message
  type(online_model_t) :: online
  type(error_t), allocatable :: error
  type(course_t) :: anew, kept
  real(rk), allocatable :: parameters(:), states(:, :), theta(:, :)
  integer :: i, i_bad_point, i_bad_source, n_anew

  call get_command_argument(1, argument)
  call read_model(trim(argument), online%model, error)
  if (allocated(error)) error stop error_report(error)
  call online%prepare(message)
  if (allocated(message)) error stop message
  call get_command_argument(2, argument)
  read (argument, *) n_anew
  allocate (parameters(online%model%n_given()))
  do i = 1, size(parameters)
    call get_command_argument(2 + i, argument)
    read (argument, *) parameters(i)
  end do
  associate (model => online%model)
    call states_of(model%history, model%parameter_names(:model%n_given()), reshape(parameters, [size(parameters), 1]), states, &
      i_bad_point, message)
    if (allocated(message)) error stop message
    call evaluate_points(model%terms, states, theta, i_bad_point, i_bad_source)
    if (n_anew == 0) n_anew = size(theta, 2)
    select type (part => model%parts(1)%reduced)
    type is (condensed_model_t)
      call walk(part, theta, .true., kept)
      print '(a, i0, a, i0, a, i0, a)', 'contacts: ', part%laws%n_contacts, ', rows: ', size(kept%forces, 1), ', times: ', &
        size(theta, 2), ''
      call walk(part, theta(:, :n_anew), .false., anew)
    class default
      error stop 'the model is not condensed'
    end select
  end associate
  print '(a, es8.1)', 'largest difference of forces over the largest force: ', &
    maxval(abs(kept%forces(:, :n_anew) - anew%forces)) / maxval(abs(anew%forces))
  call tell('anew', anew)
  call tell('kept', kept)
  print '(a, f0.1, a)', 'products of W and the forces, one per step: median ', 1.0e6_rk * median(kept%n_steps * kept%of_product), &
    ' us per time'
  print '(a, f0.1)', 'operations of linear problems, anew over kept: ', sum(anew%operations) / sum(kept%operations(:n_anew))
  call ask()

contains

  !> Walks through the history.
  subroutine walk(part, theta, keeps, course)
    type(condensed_model_t), intent(in) :: part
    real(rk), intent(in) :: theta(:, :)
    logical, intent(in) :: keeps
    type(course_t), intent(out) :: course
    type(friction_steps_t) :: steps
    type(friction_memory_t) :: memory
    type(compliance_point_t), target :: point
    real(rk) :: before, end, first, now
    logical :: is_valid
    integer :: i

    call part%compliance%create_point(point)
    call part%compliance%evaluate(theta(:, 1), point, is_valid)
    call steps%create(part%laws, part%compliance%anchors, part%compliance%scale, part%compliance%matrix(point), keeps)
    associate (n => size(theta, 2))
      allocate (course%seconds(n), course%of_product(n), source=huge(first))
      allocate (course%n_steps(n), course%operations(n), course%forces(size(point%opening), n))
    end associate
    call cpu_time(first)
    do
      call memory%begin(steps)
      do i = 1, size(theta, 2)
        call part%compliance%evaluate(theta(:, i), point, is_valid)
        before = memory%n_operations()
        call cpu_time(now)
        call steps%advance(point%opening, part%laws%friction_at(theta(:, i)), memory)
        call cpu_time(end)
        if (memory%solution%reason /= reason_converged) error stop 'a time has no answer'
        course%seconds(i) = min(course%seconds(i), end - now)
        course%n_steps(i) = memory%solution%n_steps
        course%operations(i) = memory%n_operations() - before
        course%forces(:, i) = memory%solution%lambda(:size(point%opening))
        course%of_product(i) = min(course%of_product(i), time_product(part%compliance%matrix(point), course%forces(:, i)))
      end do
      if (end - first > long_enough) return
    end do
  end subroutine walk

  !> Returns the CPU time [s] of one product of W and forces.
  real(rk) function time_product(matrix, forces) result(seconds)
    real(rk), contiguous, intent(in) :: matrix(:, :)
    real(rk), contiguous, intent(in) :: forces(:)
    integer, parameter :: n = 10
    real(rk) :: end, openings(size(forces)), start
    integer :: i

    openings = 0
    call cpu_time(start)
    do i = 1, n
      call add_few_columns(matrix, forces, openings)
    end do
    call cpu_time(end)
    seconds = (end - start) / n
    if (.not. maxval(abs(openings)) < huge(seconds)) error stop 'a product is not finite'
  end function time_product

  !> Times queries of the whole history.
  subroutine ask()
    type(query_t) :: query
    type(answer_t) :: answer
    real(rk) :: seconds(size(theta, 2)), end, first, now
    real(rk), allocatable :: state(:)
    character(:), allocatable :: message
    integer :: i

    call query%create(online, message)
    if (allocated(message)) error stop message
    seconds = huge(seconds)
    call cpu_time(first)
    do
      call query%start(online, parameters, message)
      do i = 1, size(seconds)
        call cpu_time(now)
        call query%advance(online, online%model%history%times(i), answer, state, message)
        call cpu_time(end)
        seconds(i) = min(seconds(i), end - now)
        if (answer%reason <= 0) error stop 'a query has no answer'
      end do
      if (end - first > long_enough) exit
    end do
    print '(a, f0.1, a, f0.1, a)', 'query: median ', 1.0e6_rk * median(seconds), ' us, largest ', 1.0e6_rk * maxval(seconds), ' us'
  end subroutine ask

  subroutine tell(name, course)
    character(*), intent(in) :: name
    type(course_t), intent(in) :: course

    print '(2a, f0.1, a, f0.1, a, f0.1, a, f0.1, a, f0.3, a)', name, ': median ', 1.0e6_rk * median(course%seconds), &
      ' us per time (largest ', 1.0e6_rk * maxval(course%seconds), '), ', &
      1.0e6_rk * median(course%seconds / max(1, course%n_steps)), ' us per step, ', &
      sum(course%n_steps) / real(size(course%n_steps), rk), ' steps and ', &
      1.0e-6_rk * sum(course%operations) / size(course%operations), ' million operations per time'
  end subroutine tell

  pure real(rk) function median(values)
    real(rk), intent(in) :: values(:)
    integer :: i

    median = huge(median)
    do i = 1, size(values)
      if (2 * count(values <= values(i)) >= size(values)) median = min(median, values(i))
    end do
  end function median
end program benchmark_friction
